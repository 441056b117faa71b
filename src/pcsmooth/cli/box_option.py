"""The option that selects points by a box."""

from __future__ import annotations

from typing import Any

import click

from pcsmooth.errors import InvalidInputError


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


box_option = click.option(
    "--box",
    type=BoxCorners(),
    metavar="XMIN,YMIN[,ZMIN],XMAX,YMAX[,ZMAX]",
    help="Only points in this box move, its boundary included, and with --where only those of "
    "them that are selected; the others act on them.",
)
