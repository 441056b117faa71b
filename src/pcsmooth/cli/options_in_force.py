"""Which value each option of a run has, and where it comes from."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

from pcsmooth.cli.configuration import OF_PATTERNS, OF_THE_LINE
from pcsmooth.cli.help import options_by_group
from pcsmooth.cli.options import Named

if TYPE_CHECKING:
    from pcsmooth.cli.configured_command import ConfiguredContext


@dataclass(frozen=True)
class OptionInForce:
    """An option of a run.

    Attributes
    ----------
    name : str
        What it is called, without dashes.
    value : bool, int, float, str, list or None
        What it is given; None if nothing.
    origin : str
        Where that comes from.
    type : click.ParamType
        What it may be.
    """

    name: str
    value: Any
    origin: str
    type: click.ParamType[Any]

    @property
    def line(self) -> str:
        """A line of TOML; a remark if a file could not give the option, or nothing does."""
        if self.value is None:
            return f"# {self.name} is not given"
        line = f"{self.name} = {_toml(self.value)}  # {self.origin}"
        return f"# {line}" if f"--{self.name}" in OF_THE_LINE else line


def options_in_force(ctx: ConfiguredContext) -> list[OptionInForce]:
    """List the options of a run but those that only show something.

    Parameters
    ----------
    ctx : ConfiguredContext
        That of the run.

    Returns
    -------
    list of OptionInForce
        As help orders them.
    """
    return [
        _in_force(option, ctx)
        for group in options_by_group(ctx.command, ctx).values()
        for option in group
        if option.opts[-1] not in _SHOWING
    ]


#: Options that say nothing of the result, and of which the answer would be a riddle.
_SHOWING = OF_THE_LINE - {"--output"}


#: Options that decide on nothing in a result, or on its name alone.
_UNDECIDING = {
    "output", "output-dir", "suffix", "recursive", "skip-existing", "jobs", "overwrite", "report",
    "energy-log", "quiet", "verbose", "json", "threads", "tile", "tile-folder", "workers",
    "scheduler",
}  # fmt: skip


def deciding_options(ctx: ConfiguredContext) -> dict[str, Any]:
    """Give what decides on the results of a run, as JSON.

    Parameters
    ----------
    ctx : ConfiguredContext
        That of the run.

    Returns
    -------
    dict
        What each option is given, by its name; of files that options name also size and time.
    """
    found: dict[str, Any] = {"command": ctx.info_name}
    for option in options_in_force(ctx):
        if option.name not in _UNDECIDING and option.value is not None:
            found[option.name] = option.value
            if isinstance(option.type, Named) and os.path.exists(option.value):
                state = os.stat(option.value)
                found[option.name] = [option.value, state.st_size, state.st_mtime_ns]
    return found


def options_in_words(ctx: ConfiguredContext) -> str:
    """Write what each option of a run is and where that comes from, as a configuration file.

    Parameters
    ----------
    ctx : ConfiguredContext
        That of the run.

    Returns
    -------
    str
        TOML of several lines.
    """
    name = ctx.info_name
    lines = [f"[{name}]", *(option.line for option in options_in_force(ctx))]
    for section in ctx.configuration.of_patterns if ctx.configuration is not None else []:
        lines += ["", f"[[{name}.{OF_PATTERNS}]]  # {section.place}"]
        lines.append(f"pattern = {_toml(list(section.patterns))}")
        by_parameter = {str(option.name): option for option in ctx.command.get_params(ctx)}
        for parameter, value in section.values.items():
            option = by_parameter[parameter]
            assert isinstance(option, click.Option)
            is_given = parameter in ctx.given
            origin = "not in force: the command line wins" if is_given else section.place
            lines.append(_option(option, value, origin).line)
    return "\n".join(lines)


def _in_force(option: click.Option, ctx: ConfiguredContext) -> OptionInForce:
    parameter = str(option.name)
    if parameter in ctx.given:
        value, origin = ctx.given[parameter], "command line"
    elif ctx.default_map is not None and parameter in ctx.default_map:
        value = ctx.default_map[parameter]
        origin = next(one.place for one in reversed(ctx.sections) if parameter in one.values)
    else:
        value, origin = option.get_default(ctx), "default"
    return _option(option, value, origin)


def _option(option: click.Option, value: Any, origin: str) -> OptionInForce:
    return OptionInForce(_spelled(option), _plain(option, value), origin, option.type)


def _spelled(option: click.Option) -> str:
    return option.opts[-1].removeprefix("--")


def _plain(option: click.Option, value: Any) -> Any:
    """Give a value a type of TOML; None if there is none."""
    if isinstance(value, bool):
        return value
    if not (value and isinstance(value, str | int | float | list | tuple)) and value != 0:
        return None  # nothing, or what click calls unset
    if option.multiple:
        return [str(one) for one in value]
    if isinstance(option.type, click.types.IntParamType | click.types.FloatParamType):
        return option.type(value)
    return str(value)


def _toml(value: Any) -> str:
    """Spell a value; strings and lists of JSON are those of TOML, but not NaN and infinity."""
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value, ensure_ascii=False)
