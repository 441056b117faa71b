"""`pcsmooth plot`: two clouds side by side, coloured by a value, with its histogram."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from pcsmooth.cli.configured_command import ConfiguredCommand
from pcsmooth.cli.messages import computing, speaker
from pcsmooth.cli.options import (
    STANDARD_STREAM,
    Colormap,
    Named,
    Reading,
    overwrite_option,
    quiet_option,
    reading_options,
)
from pcsmooth.errors import CloudFileError
from pcsmooth.files.notes import Say

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    from matplotlib.figure import Figure

    from pcsmooth.cloud import PointCloud
    from pcsmooth.plots.valued_clouds import ValuedClouds
    from pcsmooth.plots.views import View

_PICTURE, _PAGE = ".png", ".html"


class Direction(click.ParamType["tuple[float, float]"]):
    """Elevation and azimuth, degrees."""

    name = "elev,azim"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Turn two numbers into floats."""
        try:
            elevation, azimuth = map(float, str(value).split(","))
        except ValueError:
            elevation = azimuth = math.nan
        if not (abs(elevation) <= 90.0 and math.isfinite(azimuth)):
            self.fail(
                f"{value!r} is not an elevation from -90 to 90 and an azimuth, such as 30,-60",
                param,
                ctx,
            )
        return elevation, azimuth


@click.command(
    cls=ConfiguredCommand, short_help="Show two clouds side by side, in a picture or a page."
)
@click.argument("before_path", metavar="BEFORE", type=Named())
@click.argument("after_path", metavar="AFTER", type=Named())
@click.option(
    "-o",
    "--output",
    "output_path",
    type=Named(),
    metavar="FILE",
    required=True,
    help="Picture to write, .png, or page on which the clouds can be turned, .html.",
)
@click.option(
    "--color-by",
    type=click.Choice(["shaded", "displacement", "curvature", "distance"]),
    help="shaded: surfaces as light falls on them, in pictures also a part shown larger and a thin "
    "slice, or curves and the part that moved most; displacement of each point along its normal, "
    "row i being the same point in both, without a sign where the second file has no normals; mean "
    "curvature, from the file's columns if it has them, else estimated; distance to the nearest "
    "point of --reference, or else of the other cloud. [default: shaded, with "
    "--colormap displacement]",
)
@click.option(
    "--reference",
    "reference_path",
    type=Named(),
    metavar="FILE",
    help="Cloud from which distances are measured, with --color-by distance.",
)
@click.option(
    "--view",
    "direction",
    type=Direction(),
    help="From where clouds in space are seen, degrees above the plane of x and y and around z: "
    "90,-90 as a map, -90,-90 as a depth camera has it [default: from the side that normals in "
    "the file look to, else 30,-60].",
)
@click.option(
    "--colormap",
    type=Colormap(),
    help="A color map of matplotlib [default: viridis, and coolwarm for curvature].",
)
@reading_options
@overwrite_option
@quiet_option
def plot(
    before_path: str,
    after_path: str,
    output_path: str,
    color_by: Literal["shaded", "displacement", "curvature", "distance"] | None,
    reference_path: str | None,
    direction: tuple[float, float] | None,
    colormap: str | None,
    reading: Reading,
    overwrite: bool,
    quiet: bool,
) -> None:
    """Show BEFORE and AFTER side by side (PLY, LAS, PCD, E57, PTX, mesh or text; - is stdin).

    Surfaces are shaded as light falls on them, with a part shown larger and a thin slice; or points
    get colours by a value, on one scale without the outermost 2 percent, and a histogram shows how
    the values are spread. stderr says their mean, median, root mean square (RMS) and maximum. Pages
    have both clouds shaded, in colours by any column, with slices and distances, in one file that
    needs no network. Large clouds are drawn from a part of their points; the numbers are of all.
    Points that a file calls noise are left out.

    \b
    Examples:
      pcsmooth plot scan.ply smooth.ply -o smooth.png
      pcsmooth plot scan.ply smooth.ply -o moved.png --color-by displacement
      pcsmooth plot scan.ply smooth.ply -o moved.html --view -90,-90
      pcsmooth plot scan.ply smooth.ply -o curved.png --color-by curvature
      pcsmooth plot a.ply b.ply -o d.png --color-by distance --reference c.ply
    """
    from pcsmooth.cli.files import (
        check_beside,
        check_suffix,
        display_name,
        reading_of_all,
        write_beside,
    )
    from pcsmooth.plots.figures import check_matplotlib

    if reference_path is not None and color_by != "distance":
        raise click.UsageError("--reference needs --color-by distance")
    read = [path for path in (before_path, after_path, reference_path) if path is not None]
    if read.count(STANDARD_STREAM) > 1:
        raise click.UsageError("only one cloud can come from stdin")
    say = speaker(quiet)
    check_beside(output_path, "-o", overwrite, say, *read)
    check_suffix(output_path, _PICTURE, _PAGE)
    is_page = Path(output_path).suffix.lower() == _PAGE
    if color_by == "shaded" and colormap is not None:
        raise click.UsageError("--color-by shaded has no --colormap")
    check_matplotlib()
    started = time.perf_counter()
    clouds = _read_alike(read, reading_of_all(reading, tuple(read)), say)
    names = [display_name(path) for path in read]
    if direction is not None and clouds[0].dimension == 2:
        raise CloudFileError(names[0], "is a plane curve, which has no --view", "leave it out")
    color_by = color_by or ("displacement" if colormap else "shaded")
    shown = _valued(clouds, names, color_by, say)
    view = _view(clouds[:2], direction)
    if is_page:
        from pcsmooth.files.output_columns import normals_of
        from pcsmooth.plots.interactive import MOST_TURNED, interactive_page

        most = MOST_TURNED
        by = "" if color_by == "shaded" else f" by {color_by}"
        title = f"{Path(names[0]).name} and {Path(names[1]).name}{by}"
        normals = [normals_of(cloud) if cloud.dimension == 3 else None for cloud in clouds[:2]]
        data = interactive_page(
            shown,
            title,
            others=_other_values(shown, clouds[:2], normals[1]),
            normals=[None, normals[1]],  # before, noise is to be seen
            view=view,
            starts_shaded=color_by == "shaded",
            colormap=colormap,
        ).encode()
    elif color_by == "shaded":
        from pcsmooth.plots.cloud_figure import MOST_DRAWN
        from pcsmooth.plots.figures import png_of
        from pcsmooth.plots.shaded_figure import MOST_SHADED

        most = MOST_SHADED if shown.dimension == 3 else MOST_DRAWN
        data = png_of(_shaded(clouds, [cloud.title for cloud in shown.clouds], view, say))
    else:
        from pcsmooth.plots.cloud_figure import MOST_DRAWN, cloud_figure
        from pcsmooth.plots.figures import png_of

        most = MOST_DRAWN
        data = png_of(cloud_figure(shown, view=view, colormap=colormap))
    write_beside(data, output_path, overwrite, say)
    _tell(shown, names, most, say, has_colors=color_by != "shaded")
    say(f"  wrote {output_path} in {time.perf_counter() - started:.2f} s")


def _shaded(clouds: list[PointCloud], titles: list[str], view: View, say: Say) -> Figure:
    """Draw surfaces lit by the normals after, those of the file or rough ones."""
    from pcsmooth.errors import InvalidInputError
    from pcsmooth.files.output_columns import normals_of
    from pcsmooth.plots.curve_figure import curve_figure
    from pcsmooth.plots.shaded_figure import shaded_figure

    before, after = (cloud.active_points for cloud in clouds[:2])
    if clouds[0].dimension == 2:
        return curve_figure(before, after, titles)
    normals = normals_of(clouds[1])
    if normals is None:
        say("the second cloud has no normals nx ny nz: both are lit by planes through 8 points")
    try:
        return shaded_figure(before, after, normals, view, titles)
    except InvalidInputError as error:
        raise CloudFileError(titles[1], *str(error).split("; ")) from error


def _read_alike(paths: list[str], reading: Reading, say: Say) -> list[PointCloud]:
    """Read clouds that must have the same number of coordinates, and a finite point each."""
    from pcsmooth.cli.files import display_name, source_of
    from pcsmooth.positions import usable_rows

    clouds = [source_of(path, reading).read(say) for path in paths]
    for path, cloud in zip(paths, clouds, strict=True):
        if cloud.dimension != clouds[0].dimension:
            raise CloudFileError(
                display_name(path),
                f"has points of {cloud.dimension} coordinates, {display_name(paths[0])} of "
                f"{clouds[0].dimension}",
                "pass --dim 2",
            )
        if not usable_rows(cloud.active_points).any():
            raise CloudFileError(
                display_name(path), "no point with finite coordinates", "check the file"
            )
    return clouds


def _valued(
    clouds: list[PointCloud],
    names: list[str],
    color_by: Literal["shaded", "displacement", "curvature", "distance"],
    say: Say,
) -> ValuedClouds:
    """Give every point its value."""
    from pcsmooth.errors import InvalidInputError
    from pcsmooth.files.output_columns import normals_of
    from pcsmooth.plots.valued_clouds import (
        along_normals,
        by_curvature,
        by_displacement,
        by_distance,
        magnitudes,
    )

    titles = [
        f"{part}: {Path(name).name}"
        for part, name in zip(("before", "after"), names[:2], strict=True)
    ]
    before, after = (cloud.active_points for cloud in clouds[:2])
    if color_by == "distance":
        reference = clouds[2].active_points if len(clouds) > 2 else None
        return by_distance(before, after, reference, titles)
    if color_by in ("shaded", "displacement"):
        try:
            moved = by_displacement(before, after, titles)
        except InvalidInputError as error:
            cause, _, remedy = str(error).partition("; ")
            raise CloudFileError(names[1], cause, remedy) from error
        normals = normals_of(clouds[1])
        if color_by == "shaded" or normals is None:
            return moved
        say(f"moved: {magnitudes(moved.distributions['displacement']).in_words()}")
        return along_normals(moved, normals)
    found = {
        part: (cloud.active_points, _curvature(cloud, name, part, say))
        for part, cloud, name in zip(("before", "after"), clouds, names, strict=True)
    }
    return by_curvature(found, titles)


def _other_values(
    shown: ValuedClouds, clouds: list[PointCloud], normals: npt.NDArray[np.float64] | None
) -> list[ValuedClouds]:
    """Give the clouds other values to choose from: how far they moved, and columns of the files."""
    import numpy as np

    from pcsmooth.files.output_columns import values_of
    from pcsmooth.plots.valued_clouds import along_normals, by_displacement, with_values

    others = []
    if shown.is_paired:
        moved = by_displacement(clouds[0].active_points, clouds[1].active_points)
        lengths = [moved, *([] if normals is None else [along_normals(shown, normals)])]
        others += [values for values in lengths if values.label != shown.label]
    found = [values_of(cloud) for cloud in clouds]
    for name in dict.fromkeys([*found[1], *found[0]]):
        values = [
            columns[name][cloud.rows] if name in columns else np.full(len(cloud.rows), np.nan)
            for columns, cloud in zip(found, shown.clouds, strict=True)
        ]
        others.append(with_values(shown, name, values))
    return others


def _curvature(cloud: PointCloud, name: str, part: str, say: Say) -> npt.NDArray[np.float64]:
    """Take a cloud's own mean curvature, or estimate it; NaN where unknown."""
    import numpy as np

    from pcsmooth.files.output_columns import mean_curvature_of, normals_of
    from pcsmooth.python.estimating import estimate_curvature

    own = mean_curvature_of(cloud)
    if own is not None:
        values, column = own
        say(f"curvature {part}: column {column} of {name}")
        return values
    say(f"curvature {part}: estimated")
    with computing(name, say):
        estimate = estimate_curvature(cloud.active_points, normals=normals_of(cloud))
    return np.where(estimate.normals.any(axis=1), estimate.mean_curvature, np.nan)


def _view(clouds: list[PointCloud], direction: tuple[float, float] | None) -> View:
    """Take the view that is wanted, or the one that normals suggest, those after first."""
    from pcsmooth.files.output_columns import normals_of
    from pcsmooth.plots.views import View, facing

    if direction is not None:
        return View(*direction)
    found = [normals_of(cloud) for cloud in clouds if cloud.dimension == 3]
    return facing(next((normals for normals in reversed(found) if normals is not None), None))


def _tell(shown: ValuedClouds, names: list[str], most: int, say: Say, *, has_colors: bool) -> None:
    """Print the numbers for a person."""
    from pcsmooth.plots.cloud_figure import counts_in_words
    from pcsmooth.plots.valued_clouds import magnitudes

    for name, cloud in zip(names, shown.clouds, strict=False):
        say(f"{name}: {counts_in_words(cloud, most)}")
    if has_colors:
        say(f"  colours: {shown.label}")
    for part, values in shown.distributions.items():
        say(f"  {part}: {magnitudes(values).in_words(shown.symbol)}")
