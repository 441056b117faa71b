"""`pcsmooth curvature`: read clouds, write them back with normals and curvatures."""

from __future__ import annotations

import time
from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import click

from pcsmooth.cli.batch_table import count_column, number_column
from pcsmooth.cli.configured_command import ConfiguredCommand
from pcsmooth.cli.estimates import say_estimates
from pcsmooth.cli.file_task import FileTask
from pcsmooth.cli.messages import computing, radius_in_words, say_points
from pcsmooth.cli.options import (
    Files,
    Reading,
    check_writing,
    files_options,
    json_option,
    noise_class_option,
    orient_option,
    overwrite_option,
    quiet_option,
    radius_option,
    reading_options,
    support_option,
    threads_option,
    writing_options,
)
from pcsmooth.cli.progress_bar import ProgressBar
from pcsmooth.cli.selection_options import selection_options
from pcsmooth.cli.tile_options import tile_options
from pcsmooth.files.notes import Say
from pcsmooth.printable import counted

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from pcsmooth.estimating import EstimatedParts
    from pcsmooth.files.selection import Selection
    from pcsmooth.files.tiling import Tiling
    from pcsmooth.files.writing import Writing
    from pcsmooth.methods.estimate import Estimate

#: Quantiles that -v prints.
_QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)

#: What the table at the end of a batch says of each file.
_COLUMNS = (
    count_column("points", "points"),
    number_column("support", "curvature_support"),
    number_column("median |H|", "median_abs_mean_curvature"),
    count_column("without normal", "without_normal"),
)


@click.command(cls=ConfiguredCommand, short_help="Add normals and curvatures to clouds.")
@files_options
@radius_option
@support_option
@click.option(
    "--estimator",
    type=click.Choice(["cells", "gradient"]),
    default="cells",
    show_default=True,
    help="cells fits the normals of the cells; gradient divides that of the energy by the "
    "visible boundary, and gives no Gaussian and principal curvatures in 3D.",
)
@click.option(
    "--energy",
    type=click.Choice(["volume", "area"]),
    help="Whose gradient, with --estimator gradient only [default: volume].",
)
@orient_option
@writing_options
@reading_options
@selection_options
@noise_class_option
@threads_option
@tile_options
@overwrite_option
@quiet_option
@click.option("-v", "--verbose", is_flag=True, help="Print quantiles of each estimate.")
@json_option
def curvature(
    files: Files,
    estimator: Literal["cells", "gradient"],
    energy: Literal["volume", "area"] | None,
    writing: Writing,
    quiet: bool,
    verbose: bool,
    as_json: bool,
    **options: Any,
) -> FileTask:
    """Add normals and curvatures to each INPUT (PLY, LAS, PCD, E57, PTX, mesh or text; - is stdin).

    Row i of OUTPUT is row i of the input at the same place, with every column, element and
    comment it had, and normals, curvatures (1/unit, positive where the surface bends away from
    the normal) and their confidence (0 to 1) added. Points that are not selected have zeros there.

    \b
    Examples:
      pcsmooth curvature scan.ply -o curved.ply
      pcsmooth curvature scan.ply -o hills.ply --orient direction=0,0,1
      pcsmooth curvature scan.ply -o seen.ply --colormap coolwarm --color-by k1
      pcsmooth curvature scan.ply -o for_pcl.ply --dialect pcl --json
      zcat s.ply.gz | pcsmooth curvature - -o - --support 100 | gzip > t.ply.gz
      pcsmooth curvature scans/*.ply --output-dir curved --jobs 2
      pcsmooth curvature city.las -o roofs.las --where 'classification == 6'
      pcsmooth curvature city.laz -o curved.laz --tile 1000000
    """
    if energy is not None and estimator != "gradient":
        raise click.UsageError("--energy is for --estimator gradient only")
    if estimator == "gradient" and writing.color_by not in ("mean", "confidence"):
        raise click.UsageError(
            f"--estimator gradient has no {writing.color_by} to color by; choose mean or confidence"
        )
    check_writing(writing, "")
    from pcsmooth.cli.files import reading_of_all
    from pcsmooth.methods.estimate import Estimate

    options["estimate"] = Estimate(options.pop("support"), options.pop("orient"))
    options["reading"] = reading_of_all(options["reading"], files.names, recursive=files.recursive)
    chosen = {"estimator": estimator, "energy": energy, "writing": writing, "verbose": verbose}
    options |= chosen
    return FileTask(curvature_of_file, files, options, quiet, verbose, as_json, columns=_COLUMNS)


def curvature_of_file(
    input_path: str,
    output_path: str,
    *,
    say: Say,
    shows_bar: bool,
    radius: str,
    estimate: Estimate,
    estimator: Literal["cells", "gradient"],
    energy: Literal["volume", "area"] | None,
    writing: Writing,
    reading: Reading,
    selection: Selection | None,
    keeps_noise: bool,
    threads: int | None,
    tiling: Tiling,
    overwrite: bool,
    verbose: bool,
) -> dict[str, Any]:
    """Estimate normals and curvatures of one cloud; returns the summary."""
    from pcsmooth.cli.files import check_output, check_writable, source_of, target_of
    from pcsmooth.estimating import STAGES
    from pcsmooth.files.curvature_file import estimate_input
    from pcsmooth.files.opening import open_input

    check_output(output_path, overwrite)
    started = time.perf_counter()
    source = source_of(input_path, reading, keeps_noise=keeps_noise)
    target = target_of(output_path, overwrite)
    with (
        ProgressBar(source.path, STAGES, shows_bar, say) as bar,
        open_input(
            source, target, tiling=tiling,
            whole_cloud_for=writing.whole_cloud_for, threads=threads, say=bar.say,
        ) as cloud,
    ):  # fmt: skip
        check_writable(cloud.template, output_path)
        with computing(source.path, bar.say):
            done = estimate_input(
                cloud, target, estimate, radius=radius, estimator=estimator,
                quantity=energy or "volume", writing=writing, selection=selection,
                threads=threads, started=started, say=bar.say, callback=bar.tell,
            )  # fmt: skip
        report = done.report
        say_points(report.input, report.points, bar.say)
        if report.tiles:
            bar.say(f"  in {counted(report.tiles, 'tile')}")
        on_energy = "" if report.energy is None else f" on the {report.energy}"
        bar.say(f"  {radius_in_words(report)}, estimator {estimator}{on_energy}")
        say_estimates(report.estimates, bar.say)
        if verbose:
            _say_quantiles(done.estimated, writing, bar.say)
    say(f"  wrote {output_path} in {report.seconds:.2f} s")
    return report.as_json()


def _say_quantiles(estimated: EstimatedParts, writing: Writing, say: Say) -> None:
    """Print how each estimate is spread over the points that have a normal."""
    from pcsmooth.files.output_columns import named_estimates
    from pcsmooth.parts.streamed_median import streamed_percentile

    def known(name: str) -> Iterator[npt.NDArray[np.float64]]:
        for estimate in estimated.all():
            yield named_estimates(estimate, writing.convention)[name][estimate.has_normal]

    say("  quantiles   " + "".join(f"{100 * share:>11.0f}%" for share in _QUANTILES))
    for name in named_estimates(next(estimated.all()), writing.convention):
        if any(len(values) for values in known(name)):
            found = (streamed_percentile(partial(known, name), 100 * q) for q in _QUANTILES)
            say(f"  {name:<12}" + "".join(f"{value:>12.4g}" for value in found))
