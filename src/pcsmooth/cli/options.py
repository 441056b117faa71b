"""Arguments and options that commands share, and the types of their values."""

from __future__ import annotations

import math
from typing import Any

import click

STANDARD_STREAM = "-"

input_argument = click.argument("input_path", metavar="INPUT")

dimension_option = click.option(
    "--dim",
    type=click.Choice(["auto", "2", "3"]),
    default="auto",
    show_default=True,
    callback=lambda _context, _option, value: value if value == "auto" else int(value),
    help="Number of coordinates. auto takes what the file has; with 2, x and y are points of a "
    "plane curve and a third coordinate is kept like any other column.",
)

threads_option = click.option(
    "--threads",
    type=click.IntRange(min=1),
    metavar="N",
    help="Threads to use [default: all]. The result does not depend on it.",
)

quiet_option = click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")

json_option = click.option("--json", "as_json", is_flag=True, help="Summary as JSON on stdout.")


class Radius(click.ParamType[str]):
    """A length, 3x, 2% or auto; checked here, resolved when the cloud is known."""

    name = "value"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Check the value and hand it on."""
        from pcsmooth.errors import InvalidInputError
        from pcsmooth.radius import check_radius

        try:
            check_radius(value)
        except InvalidInputError as error:
            self.fail(str(error), param, ctx)
        return value


class Step(click.ParamType[float | str]):
    """A positive number or auto."""

    name = "value"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Turn a number into a float and leave auto alone."""
        if value == "auto":
            return value
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not (math.isfinite(number) and number > 0.0):
            self.fail(f"{value!r} is neither a positive number nor auto", param, ctx)
        return number
