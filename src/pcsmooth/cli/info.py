"""`pcsmooth info`: what files hold, and what denoising would choose."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from pcsmooth.cli.configured_command import ConfiguredCommand
from pcsmooth.cli.file_task import FileTask
from pcsmooth.cli.messages import computing
from pcsmooth.cli.options import (
    Files,
    Reading,
    inputs_argument,
    jobs_option,
    json_option,
    noise_class_option,
    reading_options,
    recursive_option,
    threads_option,
)
from pcsmooth.cli.progress_bar import ProgressBar
from pcsmooth.cli.selection_options import selection_alone_options
from pcsmooth.cli.tile_options import tile_options
from pcsmooth.files.notes import Say
from pcsmooth.printable import printable

if TYPE_CHECKING:
    from pcsmooth.files.selection import Selection
    from pcsmooth.files.tiling import Tiling

#: Stages of a description, at most.
_STAGES = 4


@click.command(
    cls=ConfiguredCommand, short_help="Say what is in clouds, and what denoise would choose."
)
@inputs_argument
@recursive_option
@reading_options
@selection_alone_options
@noise_class_option
@threads_option
@tile_options
@jobs_option
@json_option
def info(
    names: tuple[str, ...], recursive: bool, jobs: int, as_json: bool, **options: Any
) -> FileTask:
    """Describe each point cloud INPUT (PLY, LAS, PCD, E57, PTX, mesh or text; - is stdin).

    Counts, columns, extent, spacing and how much it varies, coincident points, rows that are not
    finite, the noise, and what `denoise` would choose and why. Lengths are in the unit of the file.
    If points are selected, what is measured is measured of these alone.

    \b
    Examples:
      pcsmooth info scan.ply
      pcsmooth info scan.ply --json | jq .noise
      pcsmooth info scans/ --recursive --json > scans.jsonl
      pcsmooth info city.las --where 'classification in (2, 9)'
      pcsmooth info city.laz --tile 1000000 --workers 2
    """
    from pcsmooth.cli.files import reading_of_all

    options["reading"] = reading_of_all(options["reading"], names, recursive=recursive)
    files = Files(names, recursive=recursive, jobs=jobs)
    return FileTask(info_of_file, files, options, as_json=as_json, show=_show)


def info_of_file(
    input_path: str,
    output_path: None,
    *,
    say: Say,
    shows_bar: bool,
    reading: Reading,
    selection: Selection | None,
    keeps_noise: bool,
    tiling: Tiling,
    threads: int | None,
) -> dict[str, Any]:
    """Describe one cloud."""
    from pcsmooth.cli.files import source_of
    from pcsmooth.files.cloud_facts import describe_cloud
    from pcsmooth.files.opening import open_input

    source = source_of(input_path, reading, keeps_noise=keeps_noise)
    with (
        ProgressBar(source.path, _STAGES, shows_bar, say) as bar,
        open_input(
            source, tiling=tiling, threads=threads, checks_active=False, say=bar.say
        ) as cloud,
        computing(source.path, bar.say),
    ):
        return describe_cloud(cloud, selection, threads, bar.tell).as_json()


def _show(facts: dict[str, Any]) -> None:
    """Print the facts for a person, but for what there is not."""
    known = {name: value for name, value in facts.items() if value is not None}
    width = max(map(len, known))
    for name, value in known.items():
        click.echo(f"{name.replace('_', ' '):<{width}}  {printable(_readable(value))}")


def _readable(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{name} ({kind})" for name, kind in value.items()) or "none"
    if isinstance(value, list):
        if value and isinstance(value[0], str):
            return "; ".join(value)
        return "  ".join(f"{number:.10g}" for number in value) or "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
