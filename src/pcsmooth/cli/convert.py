"""`pcsmooth convert`: read clouds and write them in another format."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

import click

from pcsmooth.cli.batch import run_on_files
from pcsmooth.cli.options import (
    Files,
    Reading,
    files_options,
    json_option,
    overwrite_option,
    position_type_option,
    quiet_option,
    reading_options,
)
from pcsmooth.files.notes import WARNING, Say

if TYPE_CHECKING:
    from pcsmooth.cloud import PointCloud


@click.command(short_help="Write clouds in another format.")
@files_options
@position_type_option
@reading_options
@overwrite_option
@quiet_option
@json_option
def convert(files: Files, quiet: bool, as_json: bool, **options: Any) -> None:
    """Write each INPUT (PLY, LAS, PCD, E57, PTX, mesh or text; - is stdin) as OUTPUT or into DIR.

    Row i of the output is row i of the input with all that its format can hold; stderr says what
    it cannot, and how far it rounds the positions.

    \b
    Examples:
      pcsmooth convert station.e57 -o station.laz
      pcsmooth convert scan.laz -o scan.ply
      pcsmooth convert points.pcd -o points.csv --overwrite
      pcsmooth convert stations/ --output-dir tiles --suffix .laz --jobs 2
    """
    from pcsmooth.cli.files import reading_of_all

    options["reading"] = reading_of_all(options["reading"], files.names)
    run_on_files(convert_file, files, options, quiet=quiet, verbose=True, as_json=as_json)


def convert_file(
    input_path: str,
    output_path: str,
    *,
    say: Say,
    shows_bar: bool,
    single: bool | None,
    reading: Reading,
    overwrite: bool,
) -> dict[str, Any]:
    """Write one cloud in another format; returns the summary."""
    from pcsmooth.cli.files import (
        check_output,
        check_writable,
        display_name,
        source_of,
        target_format,
        write_output,
    )
    from pcsmooth.files.estimates_output import with_position_type
    from pcsmooth.formats import coordinate_columns, lost_in, stored_positions
    from pcsmooth.formats.stored_positions import MUCH_ROUNDING

    check_output(output_path, overwrite)
    started = time.perf_counter()
    cloud = source_of(input_path, reading).read(say)
    check_writable(cloud, output_path)
    target = target_format(cloud, output_path)
    cloud = with_position_type(cloud, target, single)
    lost = lost_in(cloud, target)
    if lost:
        say(f"{WARNING} {target} files cannot hold {', '.join(lost)}")
    stored = stored_positions(cloud, target, output_path)
    if stored.note:
        say(stored.note)
    rounding = stored.rounding(cloud)
    if rounding > 0.0:
        words = stored.rounding_in_words(rounding)
        say(f"{WARNING} {words}" if rounding > MUCH_ROUNDING * _rough_spacing(cloud) else words)
    write_output(cloud, output_path, overwrite, say)
    name = display_name(input_path)
    say(f"{name}: {len(cloud)} points written to {output_path}")
    return {
        "input": name,
        "output": output_path,
        "format": target,
        "points": len(cloud),
        "coordinates": coordinate_columns(cloud),
        "lost": lost,
        "rounding": rounding,
        "seconds": round(time.perf_counter() - started, 3),
    }


def _rough_spacing(cloud: PointCloud) -> float:
    """Spacing of as many points on a flat sheet, or a line, of the same diagonal; 0 of none."""
    import numpy as np

    finite = cloud.points[np.isfinite(cloud.points).all(axis=1)]
    if len(finite) == 0:
        return 0.0
    with np.errstate(over="ignore"):
        extent = np.ptp(finite, axis=0).tolist()
    return math.hypot(*extent) / math.pow(len(finite), 1.0 / (cloud.dimension - 1))
