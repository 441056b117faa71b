"""Help in groups: what most people need first, all of it on demand."""

from __future__ import annotations

import textwrap
from typing import Any

import click
from click.shell_completion import CompletionItem

COMMON = "Options"
"""Title of the group that `--help` explains; of the others it gives the names."""

#: Groups of options by their first names, in the order in which help shows them; what is in none
#: of them is common.
GROUPS: dict[str, tuple[str, ...]] = {
    "Reading": ("--dim", "--columns", "--fixed", "--keep-noise-class"),
    "Selecting points": ("--where", "--box", "--polygon", "--others"),
    "Writing": (
        "--float", "--dialect", "--colormap", "--color-by", "--columns-extra",
        "--write-displacement", "--energy-log", "--report",
    ),
    "Many files": ("--output-dir", "--suffix", "--recursive", "--skip-existing", "--jobs"),
    "Normals and curvature": ("--support", "--orient", "--mean-convention", "--estimator"),
    "Balls, polyhedra and flows": (
        "--scheme", "--radius", "--energy", "--weight", "--iterations", "--step", "--order",
        "--keep-volume", "--stop", "--gradient", "--polyhedron", "--union", "--presets",
        "--allow-outside",
    ),
    "Configuration": ("--config", "--no-config", "--print-config"),
    "Large clouds": ("--threads", "--tile", "--tile-folder", "--workers", "--scheduler"),
}  # fmt: skip


class GroupedCommand(click.Command):
    """A command of many options: `--help` explains the common ones, `--help-all` all of them."""

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        """Give the parameters; the options that show help come last."""
        params = super().get_params(ctx)
        return [*params[:-1], _help_all_option(), *params[-1:]]

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options in groups."""
        shows_all = ctx.meta.get(_SHOWS_ALL, False)
        groups = options_by_group(self, ctx)
        _write(formatter, COMMON, groups.pop(COMMON), ctx)
        if shows_all:
            for title, options in groups.items():
                _write(formatter, title, options, ctx)
            return
        with formatter.section("More options, which --help-all explains"):
            for title, options in groups.items():
                formatter.write(_filled(f"{title}:", options, formatter))


def options_of(command: click.Command, ctx: click.Context) -> list[click.Option]:
    """List the options of a command that help shows."""
    return [
        param
        for param in command.get_params(ctx)
        if isinstance(param, click.Option) and not param.hidden
    ]


def options_by_group(command: click.Command, ctx: click.Context) -> dict[str, list[click.Option]]:
    """Sort the options of a command into groups, as `GROUPS` orders them; none is empty.

    Parameters
    ----------
    command : click.Command
        The command.
    ctx : click.Context
        In which it is shown.

    Returns
    -------
    dict of str to list of click.Option
        Options by the title of their group, `COMMON` first.
    """
    options = options_of(command, ctx)
    by_name = {option.opts[-1]: option for option in options}
    groups = {
        title: [by_name.pop(name) for name in names if name in by_name]
        for title, names in GROUPS.items()
    }
    found = {COMMON: list(by_name.values()), **groups}
    return {title: group for title, group in found.items() if group}


#: Key in the context of a run of what its help is to show.
_SHOWS_ALL = "pcsmooth.help.shows_all"


def _help_all_option() -> click.Option:
    return click.Option(
        ["--help-all"],
        is_flag=True,
        is_eager=True,
        expose_value=False,
        callback=_show_all,
        help="Show all options and exit.",
    )


def _show_all(ctx: click.Context, _option: click.Parameter, is_wanted: bool) -> None:
    if is_wanted and not ctx.resilient_parsing:
        click.echo(full_help(ctx.command, ctx))
        ctx.exit()


def full_help(command: click.Command, ctx: click.Context) -> str:
    """Give the help of a command with all its options."""
    ctx.meta[_SHOWS_ALL] = True
    return command.get_help(ctx)


def _write(
    formatter: click.HelpFormatter, title: str, options: list[click.Option], ctx: click.Context
) -> None:
    with formatter.section(title):
        formatter.write_dl(
            [record for option in options if (record := option.get_help_record(ctx)) is not None]
        )


def _filled(title: str, options: list[click.Option], formatter: click.HelpFormatter) -> str:
    """Write the names of a group in lines; none is parted at a hyphen."""
    indent = " " * formatter.current_indent
    text = textwrap.fill(
        " ".join([title, *(option.opts[-1] for option in options)]),
        formatter.width,
        initial_indent=indent,
        subsequent_indent=indent + "  ",
        break_on_hyphens=False,
    )
    return text + "\n"


def _commands(
    context: click.Context, _param: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Offer the commands that begin so."""
    assert context.parent is not None
    group: Any = context.parent.command
    names = group.list_commands(context.parent)
    return [CompletionItem(name) for name in names if name.startswith(incomplete)]


@click.command("help", short_help="Explain a command with all its options.")
@click.argument("name", metavar="[COMMAND]", required=False, shell_complete=_commands)
@click.pass_context
def show_help(ctx: click.Context, name: str | None) -> None:
    """Explain COMMAND with all its options, or say which commands there are.

    \b
    Examples:
      pcsmooth help
      pcsmooth help denoise
    """
    parent = ctx.parent
    assert parent is not None
    group: Any = parent.command
    if name is None:
        click.echo(group.get_help(parent))
        return
    command = group.get_command(parent, name)
    if command is None:
        names = ", ".join(group.list_commands(parent))
        raise click.UsageError(f"there is no command '{name}'; there are {names}", ctx)
    with click.Context(command, parent, name) as own:
        click.echo(full_help(command, own))
