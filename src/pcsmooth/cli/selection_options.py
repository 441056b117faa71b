"""Options that select points."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any

import click

from pcsmooth.errors import InvalidInputError

Command = Callable[..., Any]


class Expression(click.ParamType[Any]):
    """An expression on columns."""

    name = "expression"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Parse it."""
        from pcsmooth.files.where import Where

        try:
            return Where(value)
        except InvalidInputError as error:
            self.fail(str(error), param, ctx)


class BoxCorners(click.ParamType[Any]):
    """Least coordinates, then largest."""

    name = "box"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read the numbers."""
        from pcsmooth.files.selection import Selection

        try:
            box = tuple(map(float, value.split(",")))
        except ValueError:
            self.fail(f"{value!r} is not numbers between commas", param, ctx)
        try:
            Selection(box=box)
        except InvalidInputError as error:
            self.fail(str(error), param, ctx)
        return box


_OPTIONS = (
    click.option(
        "--where",
        type=Expression(),
        metavar="EXPRESSION",
        help="Only these points move, the others act on them: names of columns and x y z, "
        "numbers, words in quotation marks, + - * / // % **, comparisons, and, or, not. NaN is "
        "never selected.",
    ),
    click.option(
        "--box",
        type=BoxCorners(),
        metavar="XMIN,YMIN[,ZMIN],XMAX,YMAX[,ZMAX]",
        help="Only points in this box move, its boundary included, and with --where only those of "
        "them that are selected; the others act on them.",
    ),
)


def selection_options(command: Command) -> Command:
    """Give a command the options of `Selection`, and one of these as the keyword `selection`."""

    @wraps(command)
    def collected(*, where: Any, box: tuple[float, ...] | None, **others: Any) -> Any:
        from pcsmooth.files.selection import Selection

        selects = where is not None or box is not None
        return command(selection=Selection(where, box) if selects else None, **others)

    for option in reversed(_OPTIONS):
        collected = option(collected)
    return collected
