"""Arguments and options that commands share, and the types of their values."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from pcsmooth.attributes import Convention, Dialect

STANDARD_STREAM = "-"

WRITTEN_SUFFIXES = ".ply .xyz .xy .txt .asc .csv .pts .las .laz .pcd .obj .off .stl"
"""Suffixes of `pcsmooth.formats.WRITTEN_FORMATS`, which help must not load."""

#: Fewest points to which a normal is fitted.
_SMALLEST_SUPPORT = 3

Command = Callable[..., None]

input_argument = click.argument("input_path", metavar="INPUT")

output_option = click.option(
    "-o",
    "--output",
    "output_path",
    metavar="OUTPUT",
    required=True,
    help=f"File to write; its suffix chooses the format ({WRITTEN_SUFFIXES}). "
    "- is stdout, in the format of the input.",
)

overwrite_option = click.option("--overwrite", is_flag=True, help="Replace files that exist.")

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

        try:
            self.check(value)
        except InvalidInputError as error:
            self.fail(str(error), param, ctx)
        return value

    def check(self, value: Any) -> None:
        """Raise `InvalidInputError` unless the value is understood."""
        from pcsmooth.lengths import check_radius

        check_radius(value)


class Length(Radius):
    """A length, 3x or 2%; like a radius, but never automatic."""

    def __init__(self, quantity: str) -> None:
        self.quantity = quantity

    def check(self, value: Any) -> None:
        """Raise `InvalidInputError` unless the value is understood."""
        from pcsmooth.lengths import check_length

        check_length(value, self.quantity)


class Positive(click.ParamType[float | str]):
    """A positive number."""

    name = "number"
    wanted = "not a positive number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Turn the number into a float."""
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not (math.isfinite(number) and number > 0.0):
            self.fail(f"{value!r} is {self.wanted}", param, ctx)
        return number


class Step(Positive):
    """A positive number or auto."""

    name = "value"
    wanted = "neither a positive number nor auto"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Turn a number into a float and leave auto alone."""
        return value if value == "auto" else super().convert(value, param, ctx)


class Support(click.ParamType[int | str]):
    """A number of points, or auto."""

    name = "points"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Turn a number into an int and leave auto alone."""
        if value == "auto":
            return value
        if not (str(value).isdecimal() and int(value) >= _SMALLEST_SUPPORT):
            self.fail(
                f"{value!r} is neither a number of points, {_SMALLEST_SUPPORT} or more, nor auto",
                param,
                ctx,
            )
        return int(value)


class Orient(click.ParamType[str]):
    """Where normals point; checked here, without spaces, which a comment might break at."""

    name = "rule"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Check the rule and hand it on."""
        from pcsmooth.curvature.orientation import parse_orientation
        from pcsmooth.errors import InvalidInputError

        rule = "".join(str(value).split())
        try:
            parse_orientation(rule)
        except InvalidInputError as error:
            self.fail(str(error), param, ctx)
        return rule


class Colormap(click.ParamType[str]):
    """A color map that is there."""

    name = "name"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Check the name and hand it on."""
        from pcsmooth.colors import check_colormap
        from pcsmooth.errors import InvalidInputError

        try:
            check_colormap(value)
        except InvalidInputError as error:
            self.fail(str(error), param, ctx)
        return value


radius_option = click.option(
    "--radius",
    type=Radius(),
    default="auto",
    show_default=True,
    help="Radius of the balls, or what the polyhedron is scaled by: a length, 3x (times the mean "
    "spacing), 2% (of the bounding box's diagonal), or auto (2x).",
)

presets_option = click.option(
    "--presets",
    "presets_path",
    metavar="FILE",
    help="TOML file with further bodies, a table for each: normals and offsets, vertices, mesh, "
    "generator or base, and if wanted center, scale and rotate.",
)

support_option = click.option(
    "--support",
    type=Support(),
    default="auto",
    show_default=True,
    help="Points to which normal and curvature are fitted, 3 or more; auto chooses from the noise "
    "in the cloud.",
)

orient_option = click.option(
    "--orient",
    type=Orient(),
    default="auto",
    show_default=True,
    help="Where normals point: outward, propagate (the highest point's up), input (as the "
    "input's nx ny nz), viewpoint=X,Y,Z, direction=X,Y,Z; auto is input where there are normals, "
    "else outward, and open sheets along the positive leading axis.",
)


@dataclass(frozen=True)
class Writing:
    """How estimates are to be written.

    Attributes
    ----------
    convention : {"half", "sum"}
        Which mean curvature.
    dialect : {"generic", "meshlab", "cloudcompare", "pcl"}
        Which program the columns of a PLY file are for.
    colormap : str or None
        Color map, None for no colors.
    color_by : str
        The estimate shown in colors.
    single : bool or None
        Whether positions are float; None leaves it to input and dialect. LAS has its steps.
    """

    convention: Convention
    dialect: Dialect
    colormap: str | None
    color_by: str
    single: bool | None


position_type_option = click.option(
    "--float/--double",
    "single",
    default=None,
    help="Type of the positions in the output [default: as in the input, float in a new PCD file].",
)

_WRITING_OPTIONS = (
    click.option(
        "--mean-convention",
        "convention",
        type=click.Choice(["half", "sum"]),
        default="half",
        show_default=True,
        help="Mean curvature written: half is (k1+k2)/2, sum is k1+k2. In 2D there is only k.",
    ),
    click.option(
        "--dialect",
        type=click.Choice(["generic", "meshlab", "cloudcompare", "pcl"]),
        default="generic",
        show_default=True,
        help="Columns of a PLY file: all, or only those that one program reads. pcl makes the "
        "positions float, unless --double is given. Files of other formats get the same in any "
        "dialect.",
    ),
    click.option(
        "--colormap",
        type=Colormap(),
        help="Write red green blue too, by this color map of matplotlib, such as coolwarm.",
    ),
    click.option(
        "--color-by",
        type=click.Choice(["mean", "gaussian", "k1", "k2", "confidence"]),
        help="Estimate that --colormap shows [default: mean].",
    ),
    position_type_option,
)


def writing_options(command: Command) -> Command:
    """Give a command the options of `Writing`, and one of these as the keyword `writing`."""

    @wraps(command)
    def collected(
        *,
        convention: Convention,
        dialect: Dialect,
        colormap: str | None,
        color_by: str | None,
        single: bool | None,
        **others: Any,
    ) -> None:
        if color_by is not None and colormap is None:
            raise click.UsageError("--color-by needs --colormap")
        writing = Writing(convention, dialect, colormap, color_by or "mean", single)
        command(writing=writing, **others)

    for option in reversed(_WRITING_OPTIONS):
        collected = option(collected)
    return collected
