"""`pcsmooth denoise`: read clouds, move their points, write them back with estimates."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from pcsmooth.cli.batch_table import count_column, number_column
from pcsmooth.cli.configured_command import ConfiguredCommand
from pcsmooth.cli.estimates import say_estimates
from pcsmooth.cli.file_task import FileTask
from pcsmooth.cli.flow_options import method_options, say_motion
from pcsmooth.cli.messages import computing, radius_in_words, say_points
from pcsmooth.cli.options import (
    Files,
    Named,
    Reading,
    check_writing,
    files_options,
    json_option,
    noise_class_option,
    orient_option,
    overwrite_option,
    presets_options,
    quiet_option,
    radius_option,
    reading_options,
    support_option,
    threads_option,
    writing_options,
)
from pcsmooth.cli.outliers_option import outliers_option
from pcsmooth.cli.progress_bar import ProgressBar
from pcsmooth.cli.selection_options import selection_options
from pcsmooth.cli.shapes import check_dimension, shape_facts, union_of
from pcsmooth.cli.tile_options import tile_options
from pcsmooth.files.notes import Say
from pcsmooth.printable import counted

if TYPE_CHECKING:
    from pcsmooth.files.report import DenoiseReport
    from pcsmooth.files.selection import Selection
    from pcsmooth.files.tiling import Tiling
    from pcsmooth.files.writing import Writing
    from pcsmooth.methods.estimate import Estimate
    from pcsmooth.methods.method import Method
    from pcsmooth.methods.motion import Motion

#: What the table at the end of a batch says of each file.
_COLUMNS = (
    count_column("points", "points"),
    number_column("noise", "noise"),
    number_column("noise left", "noise_after"),
    number_column("moved", "mean_displacement"),
    count_column("outliers", "outliers"),
)


@click.command(cls=ConfiguredCommand, short_help="Take the noise out of clouds.")
@files_options
@radius_option
@click.option(
    "--polyhedron",
    metavar="NAME",
    help="Body in place of the ball (see pcsmooth presets): the surface turns towards its facets.",
)
@click.option(
    "--union",
    type=click.Choice(["naive", "inclusion-exclusion", "exact"]),
    help="How the union of polyhedra is computed [default: exact].",
)
@presets_options
@method_options
@reading_options
@click.option(
    "--fixed",
    "fixed_column",
    metavar="COLUMN",
    help="Points whose value in this column (a name, or a number from 1 in text files) is not "
    "zero, or is the word fixed, do not move but act on the others. Rows of a text file that end "
    "in the word fixed are held without this option.",
)
@selection_options
@noise_class_option
@click.option(
    "--energy-log",
    "log_path",
    type=Named(),
    metavar="FILE.csv",
    help="Write iteration,volume,area,mean_move,max_move for every state 0..N.",
)
@click.option(
    "--report",
    "report_path",
    type=Named(),
    metavar="FILE.html",
    help="Write a page, all in one file, with what was chosen and measured and with pictures. With "
    "--output-dir a folder: one such page for each input, and index.html on all of them.",
)
@click.option(
    "--write-displacement",
    "writes_displacement",
    is_flag=True,
    help="Write each point's way back to the input as columns dx dy dz, from which pcsmooth undo "
    "restores the positions exactly.",
)
@support_option
@orient_option
@writing_options
@outliers_option
@threads_option
@tile_options
@overwrite_option
@quiet_option
@click.option("-v", "--verbose", is_flag=True, help="Print every state of the flow.")
@json_option
def denoise(
    files: Files,
    quiet: bool,
    verbose: bool,
    as_json: bool,
    writes_displacement: bool,
    **options: Any,
) -> FileTask:
    """Denoise each INPUT (PLY, LAS, PCD, E57, PTX, mesh or text; - is stdin) into OUTPUT or DIR.

    The noise is measured and filtered out; with options of flows the points go down the gradient
    of an energy instead. Row i of the output is row i of the input, with every column, element
    and comment it had, its position moved, and normals, curvatures (1/unit, positive where the
    surface bends away from the normal), their confidence and displacement added. Outliers stay
    where they are and get 1 in the column outlier. If points are selected, only these move.

    \b
    Examples:
      pcsmooth denoise scan.ply -o smooth.ply
      pcsmooth denoise scan.ply -o smooth.ply --noise 0.4 --motion normal
      pcsmooth denoise station.ptx -o ranges.ply --motion ray --origin 0,0,0
      pcsmooth denoise scan.ply -o smooth.ply --scheme euler --iterations 10
      pcsmooth denoise scan.ply -o smooth.ply --scheme implicit --keep-volume
      pcsmooth denoise curve.xy -o smooth.xy --energy area --energy-log energy.csv
      pcsmooth denoise facade.ply -o smooth.ply --polyhedron cube
      pcsmooth denoise scan.ply -o smooth.ply --report scan.html
      pcsmooth denoise survey.csv -o smooth.csv --fixed control_point --json
      pcsmooth denoise city.las -o smooth.las --where 'classification == 2'
      pcsmooth denoise city.las -o smooth.las --box 1000,2000,1500,2600
      pcsmooth denoise city.las -o smooth.las --polygon area.wkt --others ignore
      pcsmooth denoise tree.laz -o clean.laz --outliers remove
      pcsmooth denoise city.las -o smooth.las --outliers class
      pcsmooth denoise numbered.xyz -o smooth.xyz --columns 2,3,4
      zcat s.ply.gz | pcsmooth denoise - -o - --radius 0.02 | gzip > t.ply.gz
      pcsmooth denoise scans/ 'more/*.xyz' --output-dir smooth --skip-existing
      pcsmooth denoise scans/ --output-dir smooth --recursive --report pages
      pcsmooth denoise scans/ --output-dir smooth --config night.toml
      pcsmooth denoise city.las -o smooth.las --scheme euler --tile 1000000
    """
    report = None
    if files.folder is not None:
        if options["log_path"] is not None:
            raise click.UsageError("--energy-log is for one input, not for --output-dir")
        report, options["report_path"] = options["report_path"], None
        if report is not None and report.lower().endswith(".html"):
            raise click.UsageError("--report names a folder for many pages, with --output-dir")
    from pcsmooth.cli.files import reading_of_all
    from pcsmooth.methods.estimate import Estimate

    options["writing"] = replace(
        options["writing"], displacement=writes_displacement, outliers=options.pop("outliers")
    )
    check_writing(options["writing"], options["method"].name)
    options["estimate"] = Estimate(options.pop("support"), options.pop("orient"))
    options["reading"] = reading_of_all(options["reading"], files.names, recursive=files.recursive)
    options["verbose"] = verbose
    return FileTask(
        denoise_file, files, options, quiet, verbose, as_json, columns=_COLUMNS, report=report
    )


def denoise_file(
    input_path: str,
    output_path: str,
    *,
    say: Say,
    shows_bar: bool,
    method: Method,
    motion: Motion,
    estimate: Estimate,
    polyhedron: str | None,
    presets_path: str | None,
    reading: Reading,
    fixed_column: str | None,
    selection: Selection | None,
    keeps_noise: bool,
    log_path: str | None,
    report_path: str | None,
    writing: Writing,
    threads: int | None,
    overwrite: bool,
    verbose: bool,
    tiling: Tiling,
    thumbnail_path: str | None = None,
) -> dict[str, Any]:
    """Denoise one cloud; returns the summary.

    With `thumbnail_path` the report, and a picture there, are those of a file of a batch.
    """
    from pcsmooth.cli.files import check_beside, check_output, check_writable, source_of, target_of
    from pcsmooth.files.denoise_file import denoise_input
    from pcsmooth.files.opening import open_input
    from pcsmooth.plots.page import is_own_page

    check_output(output_path, overwrite)
    used = [path for path in (input_path, output_path, presets_path) if path is not None]
    if log_path is not None:
        check_beside(log_path, "--energy-log", overwrite, say, *used)
        used.append(log_path)
    replaces_report = overwrite
    if report_path is not None:
        # Of a batch it is made anew, if it is one, with the result.
        replaces_report |= thumbnail_path is not None and is_own_page(report_path)
        _check_report(report_path, replaces_report, say, *used)
    if thumbnail_path is not None:
        check_beside(thumbnail_path, "--report", replaces_report, say, *used)
    started = time.perf_counter()
    source, target = (
        source_of(input_path, reading, keeps_noise=keeps_noise),
        target_of(output_path, overwrite),
    )
    with (
        ProgressBar(
            source.path, method.stages(motion), shows_bar, say, says_states=verbose
        ) as bar,
        open_input(
            source, target, tiling=tiling,
            whole_cloud_for=method.whole_cloud_for or writing.whole_cloud_for,
            threads=threads, say=bar.say,
        ) as cloud,
    ):  # fmt: skip
        check_writable(cloud.template, output_path)
        check_dimension(method.shapes, polyhedron, presets_path, cloud.dimension)
        with computing(source.path, bar.say, union_of(method.shapes)):
            done = denoise_input(
                cloud, target, method, motion=motion, estimate=estimate, writing=writing,
                fixed_column=fixed_column, selection=selection,
                shape=shape_facts(method.shapes, polyhedron),
                threads=threads, started=started, say=bar.say, callback=bar.tell,
            )  # fmt: skip
        if log_path is not None:
            from pcsmooth.cli.energy_log import write_energy_log

            write_energy_log(done.denoised.history, log_path, overwrite, bar.say)
        if report_path is not None:
            from pcsmooth.cli.files import write_beside
            from pcsmooth.plots.denoise_page import denoise_page

            bar.begin("drawing the report")
            sample = done.sample()
            page = denoise_page(sample, done.denoised, done.report)
            write_beside(page.encode(), report_path, replaces_report, bar.say)
            if thumbnail_path is not None:
                from pcsmooth.plots.thumbnail import thumbnail

                write_beside(thumbnail(sample), thumbnail_path, replaces_report, bar.say)
    report = done.report
    _tell(report, say)
    return report.as_json()


def _check_report(path: str, overwrite: bool, say: Say, *others: str) -> None:
    """Raise an error if a report cannot be drawn, or not be written there."""
    from pcsmooth.cli.files import check_beside, check_suffix
    from pcsmooth.plots.figures import check_matplotlib

    check_beside(path, "--report", overwrite, say, *others)
    check_suffix(path, ".html")
    check_matplotlib()


def _tell(report: DenoiseReport, say: Say) -> None:
    """Print the report for a person."""
    say_points(report.input, report.points, say, report.fixed)
    if report.tiles:
        say(f"  in {counted(report.tiles, 'tile')}")
    if report.shape is not None:
        say(f"  polyhedron {report.shape.polyhedron}, union {report.shape.union}")
    is_flow = report.scheme != "filter"
    if is_flow or report.radius_range is not None:
        say(f"  {radius_in_words(report)}")
    say_motion(report, say)
    say(f"  points moved {report.moved_in_words()}")
    if words := report.rms_in_words():
        say(f"  {words}")
    if is_flow:
        say(
            f"  volume {report.volume_before:.6g} -> {report.volume_after:.6g}, "
            f"area {report.area_before:.6g} -> {report.area_after:.6g}"
        )
    say_estimates(report.estimates, say)
    say(f"  wrote {report.output} in {report.seconds:.2f} s")
