"""Options that select points."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, Literal

import click

from pcsmooth.cli.options import Named
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


_SELECTING = (
    click.option(
        "--where",
        type=Expression(),
        metavar="EXPRESSION",
        help="Select points by their columns: names of columns and x y z, such as are no names "
        "elsewhere in back ticks (`scan angle`), numbers, words in quotation marks, + - * / // % "
        "**, comparisons, in (1, 2), not in, and, or, not. NaN is never selected.",
    ),
    click.option(
        "--box",
        type=BoxCorners(),
        metavar="XMIN,YMIN[,ZMIN],XMAX,YMAX[,ZMAX]",
        help="Select points in this box, its boundary included. What several of these options "
        "select is what each of them does.",
    ),
    click.option(
        "--polygon",
        type=Named(),
        metavar="FILE",
        help="Select points whose x and y are in this polygon, its boundary included: GeoJSON or "
        "WKT, in the coordinates of the points, also of several parts and with holes.",
    ),
)

_others = click.option(
    "--others",
    type=click.Choice(["act", "ignore"]),
    help="What points that are not selected do, which stay where they are in any case: act on the "
    "selected ones, or nothing, as if they were not there. [default: act]",
)


def selection_options(command: Command) -> Command:
    """Give a command the options of `Selection`, and one of these as the keyword `selection`."""

    @_others
    @wraps(command)
    def collected(*, others: Literal["act", "ignore"] | None, **options: Any) -> Any:
        if others is not None and all(
            options[name] is None for name in ("where", "box", "polygon")
        ):
            raise click.UsageError("--others needs --where, --box or --polygon")
        return _selecting(command, others or "act", **options)

    return _with_selecting(collected)


def selection_alone_options(command: Command) -> Command:
    """Do the same for a command that looks at the selected points only."""

    @wraps(command)
    def collected(**options: Any) -> Any:
        return _selecting(command, "ignore", **options)

    return _with_selecting(collected)


def _with_selecting(command: Command) -> Command:
    for option in reversed(_SELECTING):
        command = option(command)
    return command


def _selecting(
    command: Command,
    others: Literal["act", "ignore"],
    *,
    where: Any,
    box: tuple[float, ...] | None,
    polygon: str | None,
    **options: Any,
) -> Any:
    from pcsmooth.files.selection import Selection

    selects = where is not None or box is not None or polygon is not None
    selection = Selection(where, box, polygon, others) if selects else None
    return command(selection=selection, **options)
