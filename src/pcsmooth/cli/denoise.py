"""`pcsmooth denoise`: read clouds, move their points, write them back with estimates."""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pcsmooth.cli.batch import run_on_files
from pcsmooth.cli.estimates import (
    check_color_by,
    cloud_to_write,
    estimate_summary,
    input_normals,
    provenance_of,
    say_estimates,
)
from pcsmooth.cli.flow_options import method_options, method_summary, say_motion
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
    presets_options,
    quiet_option,
    radius_option,
    reading_options,
    support_option,
    threads_option,
    writing_options,
)
from pcsmooth.cli.shapes import check_dimension, shape_in_words, union_of
from pcsmooth.cli.tile_options import Tiling, tile_options
from pcsmooth.cli.tiled_denoise import denoise_provenance, denoise_tiled, points_of_tile
from pcsmooth.printable import printable

if TYPE_CHECKING:
    from pcsmooth.cloud import PointCloud
    from pcsmooth.denoise_result import DenoiseResult
    from pcsmooth.methods.estimate import Estimate
    from pcsmooth.methods.method import Method
    from pcsmooth.methods.motion import Motion
    from pcsmooth.progress import Progress


#: What the summary says of all points, in this order.
_COUNTS = (
    "points",
    "dimension",
    "coordinates",
    "not_finite",
    "noise_class",
    "fixed",
    "tiles",
)


@click.command()
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
@noise_class_option
@click.option(
    "--energy-log",
    "log_path",
    metavar="FILE.csv",
    help="Write iteration,volume,area,mean_move,max_move for every state 0..N.",
)
@click.option(
    "--report",
    "report_path",
    metavar="FILE.html",
    help="Write a page, all in one file, with what was chosen and measured and with pictures.",
)
@support_option
@orient_option
@writing_options
@threads_option
@tile_options
@overwrite_option
@quiet_option
@click.option("-v", "--verbose", is_flag=True, help="Print every state of the flow.")
@json_option
def denoise(files: Files, quiet: bool, verbose: bool, as_json: bool, **options: Any) -> None:
    """Denoise each INPUT (PLY, LAS, PCD, E57, PTX, mesh or text; - is stdin) into OUTPUT or DIR.

    The noise is measured and filtered out; with options of flows the points go down the gradient
    of an energy instead. Row i of the output is row i of the input, with every column, element
    and comment it had, its position moved, and normals, curvatures (1/unit, positive where the
    surface bends away from the normal), their confidence and displacement added. Outliers stay
    where they are and get 1 in the column outlier.

    \b
    Examples:
      pcsmooth denoise scan.ply -o smooth.ply
      pcsmooth denoise scan.ply -o smooth.ply --noise 0.4 --motion normal
      pcsmooth denoise scan.ply -o smooth.ply --scheme euler --iterations 10
      pcsmooth denoise scan.ply -o smooth.ply --scheme implicit --keep-volume
      pcsmooth denoise curve.xy -o smooth.xy --energy area --energy-log energy.csv
      pcsmooth denoise facade.ply -o smooth.ply --polyhedron cube
      pcsmooth denoise scan.ply -o smooth.ply --report scan.html
      pcsmooth denoise survey.csv -o smooth.csv --fixed control_point --json
      pcsmooth denoise numbered.xyz -o smooth.xyz --columns 2,3,4
      zcat s.ply.gz | pcsmooth denoise - -o - --radius 0.02 | gzip > t.ply.gz
      pcsmooth denoise scans/ 'more/*.xyz' --output-dir smooth --skip-existing
      pcsmooth denoise city.las -o smooth.las --scheme euler --tile 1000000
    """
    for option, name in (("log_path", "--energy-log"), ("report_path", "--report")):
        if files.folder is not None and options[option] is not None:
            raise click.UsageError(f"{name} is for one input, not for --output-dir")
    from pcsmooth.cli.files import reading_of_all
    from pcsmooth.methods.estimate import Estimate

    options["estimate"] = Estimate(options.pop("support"), options.pop("orient"))
    options["reading"] = reading_of_all(options["reading"], files.names)
    run_on_files(
        denoise_file, files, {**options, "verbose": verbose},
        quiet=quiet, verbose=verbose, as_json=as_json,
    )  # fmt: skip


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
    keeps_noise: bool,
    log_path: str | None,
    report_path: str | None,
    writing: Writing,
    threads: int | None,
    overwrite: bool,
    verbose: bool,
    tiling: Tiling,
) -> dict[str, Any]:
    """Denoise one cloud; returns the summary."""
    from pcsmooth.cli.files import (
        check_active,
        check_beside,
        check_output,
        check_writable,
        count_noise,
        display_name,
        read_input,
        write_output,
    )
    from pcsmooth.formats import coordinate_columns

    check_output(output_path, overwrite)
    used = [path for path in (input_path, output_path, presets_path) if path is not None]
    if log_path is not None:
        check_beside(log_path, "--energy-log", overwrite, say, *used)
        used.append(log_path)
    if report_path is not None:
        _check_report(report_path, overwrite, say, *used)
    started = time.perf_counter()
    name = display_name(input_path)
    tile_points = points_of_tile(
        input_path, output_path, tiling, method, motion, writing, reading,
        has_report=report_path is not None,
    )  # fmt: skip
    shape = shape_in_words(method.shapes, polyhedron)
    cloud = None
    if tile_points is not None:
        if tiling.size not in ("auto", tile_points):
            say(f"--tile {tiling.size}: tiles of {tile_points} points, lest they are too many")
        result, counted, estimated = denoise_tiled(
            input_path, output_path, tiling, tile_points, say=say, shows_bar=shows_bar,
            verbose=verbose, method=method, motion=motion, estimate=estimate, reading=reading,
            fixed_column=fixed_column, keeps_noise=keeps_noise, writing=writing, shape=shape,
            check=partial(check_dimension, method.shapes, polyhedron, presets_path),
            overwrite=overwrite, threads=threads,
        )  # fmt: skip
    else:
        cloud = read_input(input_path, reading, say, keeps_noise=keeps_noise)
        check_active([cloud], name)
        check_writable(cloud, output_path)
        check_color_by(writing, cloud.dimension, name)
        check_dimension(method.shapes, polyhedron, presets_path, cloud.dimension)
        result, held = _move(
            cloud, name, fixed_column, say, shows_bar, verbose, method=method, motion=motion,
            estimate=estimate, threads=threads,
        )  # fmt: skip
        estimated = estimate_summary(result.curvature, writing)
        smooth = cloud_to_write(
            cloud, result.points, result.curvature, output_path, writing, say,
            displacement=result.displacement,
            outliers=result.outliers,
            provenance=denoise_provenance(
                result, shape, provenance_of(estimated, estimate.orient)
            ),
        )  # fmt: skip
        write_output(smooth, output_path, overwrite, say)
        counted = {
            **_counted(result, held, count_noise(cloud)),
            "coordinates": coordinate_columns(cloud),
        }
    if log_path is not None:
        from pcsmooth.cli.energy_log import write_energy_log

        write_energy_log(result.history, log_path, overwrite, say)
    summary = {
        **_summary(name, output_path, result, counted),
        **method_summary(result, counted["outliers"]),
        **shape,
        **estimated,
    }
    if report_path is not None and cloud is not None:
        from pcsmooth.cli.files import write_beside
        from pcsmooth.plots.denoise_page import denoise_page

        page = denoise_page(cloud.points, result, summary)
        write_beside(page.encode(), report_path, overwrite, say)
    summary["seconds"] = round(time.perf_counter() - started, 3)
    _tell(summary, say)
    return summary


def _check_report(path: str, overwrite: bool, say: Say, *others: str) -> None:
    """Raise an error if a report cannot be drawn, or not be written there."""
    from pcsmooth.cli.files import check_beside, check_suffix
    from pcsmooth.plots.figures import check_matplotlib

    check_beside(path, "--report", overwrite, say, *others)
    check_suffix(path, ".html")
    check_matplotlib()


def _move(
    cloud: PointCloud,
    name: str,
    fixed_column: str | None,
    say: Say,
    shows_bar: bool,
    verbose: bool,
    *,
    method: Method,
    estimate: Estimate,
    **options: Any,
) -> tuple[DenoiseResult, int]:
    """Denoise with a progress bar; returns the result and the number of fixed points."""
    from tqdm import tqdm

    from pcsmooth.cli.fixed_points import fixed_points
    from pcsmooth.denoising import denoise as denoise_points

    fixed = fixed_points(cloud, fixed_column, name)
    held = 0 if fixed is None else int(fixed.sum())
    normals = input_normals(cloud, estimate.orient, name)
    bar = tqdm(
        desc=printable(Path(name).name), unit="stage", delay=1.0, leave=False,
        file=sys.stderr, disable=None if shows_bar else True,
    )  # fmt: skip

    def tell(progress: Progress) -> None:
        if verbose and progress.record is not None:
            with bar.external_write_mode(file=sys.stderr):
                say(progress.record.in_words())
        bar.update(progress.done)

    with bar, computing(name, say, union_of(method.shapes)):
        result = denoise_points(
            cloud.active_points, method, estimate=estimate, fixed=fixed, normals=normals,
            callback=tell, **options,
        )  # fmt: skip
    return replace(result, points=cloud.completed(result.points)), held


def _counted(result: DenoiseResult, held: int, n_noise: int) -> dict[str, Any]:
    """Collect what the summary says of all points."""
    moved = result.displacement[result.finite]
    return {
        "points": len(result.points),
        "dimension": int(result.points.shape[1]),
        "not_finite": int((~result.finite).sum()) - n_noise,
        "noise_class": n_noise,
        "fixed": held,
        "mean_displacement": float(moved.mean()),
        "max_displacement": float(moved.max()),
        "outliers": None if result.outliers is None else int(result.outliers.sum()),
        "tiles": None,
    }


def _summary(
    name: str, output_path: str, result: DenoiseResult, counted: dict[str, Any]
) -> dict[str, Any]:
    """Collect what the summary says, in the order of the JSON."""
    first, last = result.history[0], result.history[-1]
    return {
        "input": name,
        "output": output_path,
        **{key: counted[key] for key in _COUNTS},
        "spacing": result.spacing,
        "radius": result.radius,
        "volume_before": first.volume,
        "volume_after": last.volume,
        "area_before": first.area,
        "area_after": last.area,
        "mean_displacement": counted["mean_displacement"],
        "max_displacement": counted["max_displacement"],
    }


def _tell(summary: dict[str, Any], say: Say) -> None:
    """Print the summary for a person."""
    say_points(summary, say)
    if summary["tiles"]:
        say(f"  in {summary['tiles']} tiles")
    if "polyhedron" in summary:
        say(f"  polyhedron {summary['polyhedron']}, union {summary['union']}")
    say(f"  {radius_in_words(summary)}")
    say_motion(summary, say)
    say(
        f"  volume {summary['volume_before']:.6g} -> {summary['volume_after']:.6g}, "
        f"area {summary['area_before']:.6g} -> {summary['area_after']:.6g}"
    )
    say(
        f"  points moved {summary['mean_displacement']:.4g} on average, "
        f"{summary['max_displacement']:.4g} at most"
    )
    say_estimates(summary, say)
    say(f"  wrote {summary['output']} in {summary['seconds']:.2f} s")
