"""`pcsmooth undo`: bring back the positions that denoised clouds had."""

from __future__ import annotations

import time
from typing import Any

import click

from pcsmooth.cli.batch_table import count_column
from pcsmooth.cli.configured_command import ConfiguredCommand
from pcsmooth.cli.file_task import FileTask
from pcsmooth.cli.options import (
    Files,
    Reading,
    files_options,
    json_option,
    overwrite_option,
    quiet_option,
    reading_options,
)
from pcsmooth.cli.progress_bar import ProgressBar
from pcsmooth.files.notes import Say
from pcsmooth.printable import counted

#: What the table at the end of a batch says of each file.
_COLUMNS = (count_column("points", "points"), count_column("brought back", "brought_back"))


@click.command(cls=ConfiguredCommand, short_help="Bring back the positions from before denoising.")
@files_options
@reading_options
@overwrite_option
@quiet_option
@json_option
def undo(files: Files, quiet: bool, as_json: bool, **options: Any) -> FileTask:
    """Undo each INPUT (PLY, LAS, PCD, E57, PTX, mesh or text; - is stdin) to where its points were.

    It is a result of denoise --write-displacement.
    Positions are exact, to the precision of the file. The columns and comments that denoise added
    are left out; normals, colours and rows that it replaced or removed cannot come back.

    \b
    Examples:
      pcsmooth undo smooth.ply -o scan_again.ply
      pcsmooth undo smooth/ --output-dir scans
      pcsmooth undo survey.laz -o survey_again.laz --json
    """
    from pcsmooth.cli.files import reading_of_all

    options["reading"] = reading_of_all(options["reading"], files.names, recursive=files.recursive)
    return FileTask(undo_file, files, options, quiet, True, as_json, columns=_COLUMNS)


def undo_file(
    input_path: str,
    output_path: str,
    *,
    say: Say,
    shows_bar: bool,
    reading: Reading,
    overwrite: bool,
) -> dict[str, Any]:
    """Bring back the positions of one cloud; returns the summary."""
    from pcsmooth.cli.files import check_output, display_name, source_of, write_and_say
    from pcsmooth.files.undo import undone

    check_output(output_path, overwrite)
    started = time.perf_counter()
    name = display_name(input_path)
    with ProgressBar(name, 1, shows_bar, say) as bar:
        smooth = source_of(input_path, reading).read(bar.say)
        cloud = undone(smooth, name)
        gone = [column for column in smooth.columns if column not in cloud.columns]
        bar.say(f"columns left out: {', '.join(gone)}")
        bar.begin("writing")
        written = write_and_say(cloud, output_path, overwrite, bar.say)
    moved = int((cloud.points != smooth.points).any(axis=1).sum())
    points = counted(len(cloud), "point")
    say(f"{name}: {moved} of {points} brought back, written to {output_path}")
    return {
        "input": name,
        "output": output_path,
        "format": written.format,
        "points": len(cloud),
        "brought_back": moved,
        "columns_left_out": gone,
        "lost": written.lost,
        "rounding": written.rounding,
        "seconds": round(time.perf_counter() - started, 3),
    }
