"""`pcsmooth curvature`: read clouds, write them back with normals and curvatures."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from pcsmooth.cli.batch import run_on_files
from pcsmooth.cli.estimates import (
    check_color_by,
    cloud_to_write,
    estimate_summary,
    input_normals,
    known_estimates,
    provenance_of,
    say_estimates,
)
from pcsmooth.cli.messages import Say, computing, radius_in_words, say_points
from pcsmooth.cli.options import (
    Files,
    Reading,
    Writing,
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
from pcsmooth.printable import printable

if TYPE_CHECKING:
    from pcsmooth.curvature.estimate import CurvatureEstimate
    from pcsmooth.progress import Progress

#: Quantiles that -v prints.
_QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)


@click.command()
@files_options
@radius_option
@support_option
@click.option(
    "--estimator",
    type=click.Choice(["cells", "report"]),
    default="cells",
    show_default=True,
    help="cells fits the normals of the cells; report divides the gradient of the energy by the "
    "visible boundary, and gives no Gaussian and principal curvatures in 3D.",
)
@click.option(
    "--energy",
    type=click.Choice(["volume", "area"]),
    help="Whose gradient, with --estimator report only [default: volume].",
)
@orient_option
@writing_options
@reading_options
@noise_class_option
@threads_option
@overwrite_option
@quiet_option
@click.option("-v", "--verbose", is_flag=True, help="Print quantiles of each estimate.")
@json_option
def curvature(
    files: Files,
    estimator: Literal["cells", "report"],
    energy: Literal["volume", "area"] | None,
    writing: Writing,
    quiet: bool,
    verbose: bool,
    as_json: bool,
    **options: Any,
) -> None:
    """Add normals and curvatures to each INPUT (PLY, LAS, PCD, E57, PTX, mesh or text; - is stdin).

    Row i of OUTPUT is row i of the input at the same place, with every column, element and
    comment it had, and normals, curvatures (1/unit, positive where the surface bends away from
    the normal) and their confidence (0 to 1) added.

    \b
    Examples:
      pcsmooth curvature scan.ply -o curved.ply
      pcsmooth curvature scan.ply -o hills.ply --orient direction=0,0,1
      pcsmooth curvature scan.ply -o seen.ply --colormap coolwarm --color-by k1
      pcsmooth curvature scan.ply -o for_pcl.ply --dialect pcl --json
      zcat s.ply.gz | pcsmooth curvature - -o - --support 100 | gzip > t.ply.gz
      pcsmooth curvature scans/*.ply --output-dir curved --jobs 2
    """
    if energy is not None and estimator != "report":
        raise click.UsageError("--energy is for --estimator report only")
    if estimator == "report" and writing.color_by not in ("mean", "confidence"):
        raise click.UsageError(
            f"--estimator report has no {writing.color_by} to color by; choose mean or confidence"
        )
    from pcsmooth.cli.files import reading_of_all

    options["reading"] = reading_of_all(options["reading"], files.names)
    chosen = {"estimator": estimator, "energy": energy, "writing": writing, "verbose": verbose}
    run_on_files(
        curvature_of_file, files, options | chosen, quiet=quiet, verbose=verbose, as_json=as_json
    )


def curvature_of_file(
    input_path: str,
    output_path: str,
    *,
    say: Say,
    shows_bar: bool,
    radius: str,
    support: int | Literal["auto"],
    estimator: Literal["cells", "report"],
    energy: Literal["volume", "area"] | None,
    orient: str,
    writing: Writing,
    reading: Reading,
    keeps_noise: bool,
    threads: int | None,
    overwrite: bool,
    verbose: bool,
) -> dict[str, Any]:
    """Estimate normals and curvatures of one cloud; returns the summary."""
    from pcsmooth.cli.files import (
        check_active,
        check_output,
        check_writable,
        count_noise,
        display_name,
        read_input,
        write_output,
    )

    check_output(output_path, overwrite)
    started = time.perf_counter()
    name = display_name(input_path)
    cloud = read_input(input_path, reading, say, keeps_noise=keeps_noise)
    check_active([cloud], name)
    check_writable(cloud, output_path)
    check_color_by(writing, cloud.dimension, name)
    normals = input_normals(cloud, orient, name)

    from tqdm import tqdm

    from pcsmooth.estimating import estimate_curvature
    from pcsmooth.formats import coordinate_columns

    bar = tqdm(
        unit="stage", delay=1.0, leave=False, file=sys.stderr,
        disable=None if shows_bar else True,
    )  # fmt: skip

    def tell(progress: Progress) -> None:
        bar.set_description(f"{printable(Path(name).name)}: {progress.stage}", refresh=False)
        bar.update(progress.done)

    with bar, computing(name, say):
        estimate = estimate_curvature(
            cloud.active_points, radius=radius, support=support, estimator=estimator,
            energy=energy or "volume", orient=orient, normals=normals, threads=threads,
            callback=tell,
        )  # fmt: skip
    found = estimate_summary(estimate, writing)
    if estimator == "report":
        found["curvature_support"] = None
    method = estimator if estimator == "cells" else f"{estimator} energy={energy or 'volume'}"
    curved = cloud_to_write(
        cloud, cloud.points, estimate, output_path, writing, say,
        provenance=f"curvature estimator={method} radius={estimate.radius:.9g} "
        f"spacing={estimate.spacing:.9g} {provenance_of(found, orient)}",
    )  # fmt: skip
    write_output(curved, output_path, overwrite, say)
    summary = {
        "input": name,
        "output": output_path,
        "points": len(cloud),
        "dimension": cloud.dimension,
        "coordinates": coordinate_columns(cloud),
        "not_finite": int((~estimate.finite).sum()) - count_noise(cloud),
        "noise_class": count_noise(cloud),
        "estimator": estimator,
        "energy": None if estimator == "cells" else energy or "volume",
        "spacing": estimate.spacing,
        "radius": estimate.radius,
        **found,
        "seconds": round(time.perf_counter() - started, 3),
    }
    say_points(summary, say)
    on_energy = "" if summary["energy"] is None else f" on the {summary['energy']}"
    say(f"  {radius_in_words(summary)}, estimator {estimator}{on_energy}")
    say_estimates(summary, say)
    if verbose:
        _say_quantiles(estimate, writing, say)
    say(f"  wrote {output_path} in {summary['seconds']:.2f} s")
    return summary


def _say_quantiles(estimate: CurvatureEstimate, writing: Writing, say: Say) -> None:
    """Print how each estimate is spread over the points that have a normal."""
    import numpy as np

    say("  quantiles   " + "".join(f"{100 * share:>11.0f}%" for share in _QUANTILES))
    for name, values in known_estimates(estimate, writing).items():
        if len(values):
            numbers = "".join(f"{value:>12.4g}" for value in np.quantile(values, _QUANTILES))
            say(f"  {name:<12}{numbers}")
