"""`pcsmooth convert`: read clouds and write them in another format."""

from __future__ import annotations

import time
from typing import Any

import click

from pcsmooth.cli.batch_table import count_column, number_column
from pcsmooth.cli.configured_command import ConfiguredCommand
from pcsmooth.cli.file_task import FileTask
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
from pcsmooth.cli.progress_bar import ProgressBar
from pcsmooth.files.notes import Say
from pcsmooth.printable import counted

#: What the table at the end of a batch says of each file.
_COLUMNS = (
    count_column("points", "points"),
    count_column("format", "format"),
    number_column("rounding", "rounding"),
)


@click.command(cls=ConfiguredCommand, short_help="Write clouds in another format.")
@files_options
@position_type_option
@reading_options
@overwrite_option
@quiet_option
@json_option
def convert(files: Files, quiet: bool, as_json: bool, **options: Any) -> FileTask:
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

    options["reading"] = reading_of_all(options["reading"], files.names, recursive=files.recursive)
    return FileTask(convert_file, files, options, quiet, True, as_json, columns=_COLUMNS)


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
    from pcsmooth.cli.files import check_output, display_name, source_of, write_and_say
    from pcsmooth.formats import coordinate_columns

    check_output(output_path, overwrite)
    started = time.perf_counter()
    name = display_name(input_path)
    with ProgressBar(name, 1, shows_bar, say) as bar:
        cloud = source_of(input_path, reading).read(bar.say)
        bar.begin("writing")
        written = write_and_say(cloud, output_path, overwrite, bar.say, single)
    say(f"{name}: {counted(len(cloud), 'point')} written to {output_path}")
    return {
        "input": name,
        "output": output_path,
        "format": written.format,
        "points": len(cloud),
        "coordinates": coordinate_columns(cloud),
        "lost": written.lost,
        "rounding": written.rounding,
        "seconds": round(time.perf_counter() - started, 3),
    }
