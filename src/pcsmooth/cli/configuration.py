"""Options from a file in TOML: those of each command, and of files whose names fit patterns."""

from __future__ import annotations

import json
import os
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from pathlib import PurePath
from typing import Any

import click

from pcsmooth.cli.help import GROUPS
from pcsmooth.cli.options import STANDARD_STREAM
from pcsmooth.errors import CloudFileError

FOUND_NAME = "pcsmooth.toml"
"""Name of the file that is used if it lies in the current folder."""

OF_PATTERNS = "files"
"""Key of the sections, in the table of a command, that are for files of some names only."""

OF_THE_LINE = {"--output", "--config", "--no-config", "--print-config", "--help", "--help-all"}
"""Options that are of the command line alone."""

#: Options by which a file that merely lies in the folder, as one of somebody else's may, could
#: write where nobody wants it, read what is guarded, or tell a host of the cloud.
_OF_NAMED_FILES = {
    "--output-dir", "--overwrite", "--report", "--energy-log", "--tile-folder", "--scheduler",
    "--allow-outside",
}  # fmt: skip

OF_BATCHES = {*GROUPS["Many files"], "--report"}
"""Options of a batch as a whole."""

_OF_RUNS = {*OF_BATCHES, "--quiet", "--verbose", "--json", "--overwrite"}


@dataclass(frozen=True)
class Section:
    """Options that a file gives to a command.

    Attributes
    ----------
    place : str
        The file and where in it, for messages.
    values : dict
        What each option is given, as click takes it, by the name of its parameter.
    spelled : dict
        What stands there, by the names of the options.
    patterns : tuple of str
        Names of the files it is for; all if there are none.
    """

    place: str
    values: dict[str, Any]
    spelled: dict[str, str]
    patterns: tuple[str, ...] = ()

    def in_words(self, overruled: Collection[str]) -> str:
        """Spell the options as they stand there, but those of some parameters."""
        spelled = zip(self.values, self.spelled.items(), strict=True)
        return ", ".join(
            f"{name} = {value}"
            for parameter, (name, value) in spelled
            if parameter not in overruled
        )

    def fits(self, source: str) -> bool:
        """Whether a file, which stdin is not, is one of those that the section is for."""
        if not self.patterns:
            return True
        return source != STANDARD_STREAM and any(map(PurePath(source).match, self.patterns))


@dataclass(frozen=True)
class Configuration:
    """What a file says of a command.

    Attributes
    ----------
    path : str
        The file; empty if there is none.
    sections : list of Section
        That of all files first, if there is one; later ones win.
    """

    path: str = ""
    sections: list[Section] = field(default_factory=list)

    @property
    def common(self) -> list[Section]:
        """The sections for all files."""
        return [section for section in self.sections if not section.patterns]

    @property
    def of_patterns(self) -> list[Section]:
        """The sections for some files."""
        return [section for section in self.sections if section.patterns]

    def fitting(self, source: str) -> list[Section]:
        """List the sections for a file."""
        return [section for section in self.sections if section.fits(source)]


def found_configuration() -> str | None:
    """Name of the file in the current folder, if there is one."""
    return FOUND_NAME if os.path.isfile(FOUND_NAME) else None


def read_configuration(
    path: str, context: click.Context, commands: Collection[str], *, is_named: bool
) -> Configuration:
    """Read what a file says of a command.

    Parameters
    ----------
    path : str
        The file.
    context : click.Context
        That of the command.
    commands : collection of str
        Names of all commands that a file may have a table of.
    is_named : bool
        Whether the user named the file, and so trusts it.

    Returns
    -------
    Configuration

    Raises
    ------
    CloudFileError
        The file cannot be read, or names what there is not or cannot be.
    """
    from pcsmooth.bodies.suggestions import suggestion
    from pcsmooth.bodies.toml_files import read_toml

    tables = read_toml(path)
    for name, table in tables.items():
        if name not in commands:
            raise CloudFileError(
                path, f"there is no command {name!r}", suggestion(name, sorted(commands))
            )
        if not isinstance(table, dict):
            raise CloudFileError(
                path, f"{name!r} stands outside of a table", f"write a table such as [{name}]"
            )
    name = str(context.info_name)
    table = tables.get(name, {})
    of_patterns = table.pop(OF_PATTERNS, [])
    if not (isinstance(of_patterns, list) and all(isinstance(one, dict) for one in of_patterns)):
        raise CloudFileError(
            path, f"{OF_PATTERNS!r} is no list of tables", f"write [[{name}.{OF_PATTERNS}]]"
        )
    options = _Options(path, context, is_named)
    sections = [options.section(f"[{name}]", table)] if table else []
    for number, one in enumerate(of_patterns, 1):
        where = f"[[{name}.{OF_PATTERNS}]] number {number}"
        sections.append(options.section(where, one, options.patterns(where, one)))
    return Configuration(path, sections)


class _Options:
    """The options of a command that a file may give."""

    def __init__(self, path: str, context: click.Context, is_named: bool) -> None:
        self.path = path
        self.context = context
        self.is_named = is_named
        self.by_name = {
            name.removeprefix("--"): option
            for option in context.command.get_params(context)
            if isinstance(option, click.Option) and option.opts[-1] not in OF_THE_LINE
            for name in (*option.opts, *option.secondary_opts)
            if name.startswith("--")
        }

    def patterns(self, where: str, table: dict[str, Any]) -> tuple[str, ...]:
        """Take the patterns out of a table."""
        found = table.pop("pattern", None)
        patterns = [found] if isinstance(found, str) else found
        if not (
            isinstance(patterns, list)
            and patterns
            and all(isinstance(one, str) and one for one in patterns)
        ):
            raise CloudFileError(
                self.path, f"{where} has no pattern", "write one, such as pattern = '*.ply'"
            )
        for one in patterns:
            try:
                PurePath("name").match(one)
            except ValueError:
                raise CloudFileError(
                    self.path, f"{where}: {one!r} fits no name", "write one such as '*.ply'"
                ) from None
        return tuple(patterns)

    def section(self, where: str, table: dict[str, Any], patterns: tuple[str, ...] = ()) -> Section:
        """Check and convert a table."""
        values: dict[str, Any] = {}
        for name, value in table.items():
            option = self._option(where, name, bool(patterns))
            if option.name in values:
                raise CloudFileError(
                    self.path, f"{where} has --{name} twice", "leave out one of the two names"
                )
            if f"--{name}" in option.secondary_opts:
                value = not value if isinstance(value, bool) else value
            values[str(option.name)] = self._value(where, name, option, value)
        spelled = {name: json.dumps(value, ensure_ascii=False) for name, value in table.items()}
        return Section(f"{self.path} {where}", values, spelled, patterns)

    def _option(self, where: str, name: str, is_of_pattern: bool) -> click.Option:
        from pcsmooth.bodies.suggestions import suggestion

        option = self.by_name.get(name)
        if option is None:
            command = self.context.command.name
            raise CloudFileError(
                self.path,
                f"{where}: {command} has no option {name!r} that a file can give",
                suggestion(name, self.by_name),
            )
        spelled = option.opts[-1]
        if spelled in _OF_NAMED_FILES and not self.is_named:
            raise CloudFileError(
                self.path,
                f"{where}: {name!r} is not taken from a file that only lies in the folder",
                f"name it by --config {self.path}",
            )
        if is_of_pattern and spelled in _OF_RUNS:
            raise CloudFileError(
                self.path,
                f"{where}: {name!r} is of the whole run",
                f"put it into [{self.context.command.name}]",
            )
        return option

    def _value(self, where: str, name: str, option: click.Option, value: Any) -> Any:
        """Give a value as the command line would, and check it."""
        if option.is_flag != isinstance(value, bool):
            wanted = "true or false" if option.is_flag else "a number, a text or a list"
            raise CloudFileError(self.path, f"{where}: {name!r} is not {wanted}", "correct it")
        given: Any = value
        if not option.is_flag:
            texts = list(_texts(value))
            if not texts or None in texts:
                raise CloudFileError(
                    self.path, f"{where}: {name!r} is not a number, a text or a list", "correct it"
                )
            given = texts if option.multiple else ",".join(map(str, texts))
        try:
            option.type_cast_value(self.context, given)
        except click.BadParameter as error:
            cause, _, remedy = error.message.rstrip(".").partition("; ")
            raise CloudFileError(
                self.path, f"{where}: {name}: {cause}", remedy or "correct it there"
            ) from error
        return given


def _texts(value: Any) -> Iterator[str | None]:
    """Spell a value, or each of a list; None for what is neither number nor text."""
    for one in value if isinstance(value, list) else [value]:
        is_plain = isinstance(one, str | int | float) and not isinstance(one, bool)
        try:
            yield str(one) if is_plain else None
        except ValueError:  # a whole number of more digits than Python spells
            yield None
