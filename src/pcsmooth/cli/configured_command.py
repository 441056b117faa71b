"""Commands whose options a configuration file may give, and which work on files."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import click
from click.core import augment_usage_errors

from pcsmooth.cli.batch import run_on_files
from pcsmooth.cli.configuration import (
    FOUND_NAME,
    OF_BATCHES,
    Configuration,
    Section,
    found_configuration,
    read_configuration,
)
from pcsmooth.cli.file_task import ChosenOptions, FileTask
from pcsmooth.cli.help import GroupedCommand, options_of
from pcsmooth.cli.messages import speaker
from pcsmooth.cli.options import Named
from pcsmooth.cli.options_in_force import deciding_options, options_in_words
from pcsmooth.files.notes import Say
from pcsmooth.printable import counted


class ConfiguredContext(click.Context):
    """A run of a command, and what its options are taken from.

    Attributes
    ----------
    words : list of str
        The command line behind the name of the command.
    given : dict
        What the command line gives each parameter, as it is written there.
    configuration : Configuration
        What a file says.
    sections : list of Section
        Those of it that apply.
    """

    words: list[str]
    given: dict[str, Any]
    configuration: Configuration | None = None
    sections: list[Section]


class ConfiguredCommand(GroupedCommand):
    """A command whose options a configuration file may give."""

    context_class = ConfiguredContext

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self.params += _options()

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Take options from the command line, and what it does not give from the file."""
        assert isinstance(ctx, ConfiguredContext)
        ctx.words = list(args)
        values, _, found = self.make_parser(ctx).parse_args(args=list(args))
        given = [option for option in found if isinstance(option, click.Option)]
        ctx.given = {str(option.name): values[str(option.name)] for option in given}
        asks_for_help = any({"--help", "--help-all"} & set(option.opts) for option in given)
        if not (ctx.resilient_parsing or asks_for_help):
            if ctx.configuration is None:
                ctx.configuration = self._configuration(ctx)
                ctx.sections = ctx.configuration.common
            ctx.default_map = self._defaults(ctx)
        try:
            return super().parse_args(ctx, args)
        except click.MissingParameter:  # after all that are given have been checked
            if "print_config" not in ctx.given:
                raise
            return []

    def _configuration(self, ctx: ConfiguredContext) -> Configuration:
        """Read the file that is named, or else the one that is found."""
        named = ctx.given.get("config")
        path = found_configuration() if named is None else named
        if ctx.given.get("no_config"):
            if named is not None:
                raise click.UsageError("--config and --no-config exclude each other", ctx)
            path = None
        if path is None:
            return Configuration()
        group: Any = ctx.parent.command if ctx.parent is not None else None
        commands = group.commands if group is not None else {self.name: self}
        names = [str(name) for name, one in commands.items() if isinstance(one, ConfiguredCommand)]
        return read_configuration(path, ctx, names, is_named=named is not None)

    def _defaults(self, ctx: ConfiguredContext) -> dict[str, Any]:
        """Merge the sections."""
        values = {name: value for one in ctx.sections for name, value in one.values.items()}
        return {name: value for name, value in values.items() if name not in _overruled(ctx)}

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command on its files, or show what its options are taken from."""
        assert isinstance(ctx, ConfiguredContext)
        if ctx.given.get("print_config"):
            click.echo(options_in_words(ctx))
            return
        say = speaker(bool(ctx.params.get("quiet")))
        for section in ctx.sections:
            if words := section.in_words(_overruled(ctx)):
                say(f"options of {section.place}: {words}")
        with _naming_sections(ctx):
            task = super().invoke(ctx)
        if isinstance(task, FileTask):
            with augment_usage_errors(ctx):
                run_on_files(task, partial(self._options_of_files, ctx, task, say))

    def _options_of_files(
        self, ctx: ConfiguredContext, task: FileTask, say: Say, sources: list[str]
    ) -> list[ChosenOptions]:
        """Give each file the options that the sections whose patterns it fits make of them."""
        assert ctx.configuration is not None
        fitting = [ctx.configuration.fitting(source) for source in sources]
        for section in ctx.configuration.of_patterns:
            count = sum(section in sections for sections in fitting)
            words = section.in_words(_overruled(ctx))
            if count and words:
                say(f"options of {section.place}, for {counted(count, 'file')}: {words}")
        made = [(ctx.sections, ChosenOptions(task.options, deciding_options(ctx)))]
        for sections in fitting:
            if all(sections != known for known, _ in made):
                with self._context_with(ctx, sections) as own, _naming_sections(own):
                    options = super().invoke(own).options
                    made.append((sections, ChosenOptions(options, deciding_options(own))))
        return [next(chosen for known, chosen in made if known == one) for one in fitting]

    def _context_with(self, ctx: ConfiguredContext, sections: list[Section]) -> ConfiguredContext:
        """Parse the command line with other sections."""
        own = ConfiguredContext(self, info_name=ctx.info_name, parent=ctx.parent)
        own.configuration, own.sections = ctx.configuration, sections
        with own.scope(cleanup=False):
            self.parse_args(own, list(ctx.words))
        return own


@contextmanager
def _naming_sections(ctx: ConfiguredContext) -> Iterator[None]:
    """Say of options that do not go together which of them the command line does not show."""
    try:
        yield
    except click.UsageError as error:
        words = [(section.place, section.in_words(_overruled(ctx))) for section in ctx.sections]
        given = [f"{place} gives {options}" for place, options in words if options]
        raise click.UsageError("; ".join([error.message.rstrip("."), *given]), ctx) from error


def _overruled(ctx: ConfiguredContext) -> set[str]:
    """Name the parameters that no file decides on: a single output is no batch."""
    names = set(ctx.given)
    if "output" in ctx.given:
        options = options_of(ctx.command, ctx)
        names |= {str(option.name) for option in options if option.opts[-1] in OF_BATCHES}
    return names


def _options() -> list[click.Option]:
    return [
        click.Option(
            ["--config"],
            type=Named(),
            metavar="FILE",
            expose_value=False,
            help="Take options that the command line does not give from this file, in TOML: those "
            "of [COMMAND], and of [[COMMAND.files]] for files that fit a pattern. [default: "
            f"{FOUND_NAME} in the current folder]",
        ),
        click.Option(
            ["--no-config"], is_flag=True, expose_value=False, help=f"Take none from {FOUND_NAME}."
        ),
        click.Option(
            ["--print-config"],
            is_flag=True,
            is_eager=True,
            expose_value=False,
            help="Show what each option is and where that comes from, as such a file, and exit.",
        ),
    ]
