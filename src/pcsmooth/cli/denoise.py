"""`pcsmooth denoise`: read a cloud, flow it, write it back with estimates."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from pcsmooth.cli.options import (
    STANDARD_STREAM,
    Radius,
    Step,
    dimension_option,
    input_argument,
    json_option,
    quiet_option,
    threads_option,
)

if TYPE_CHECKING:
    from pcsmooth.cloud import PointCloud
    from pcsmooth.denoising import DenoiseResult, Record

#: Positions as float32 are warned about when rounding takes more than this share of the mean
#: displacement.
_ROUNDING_SHARE = 0.01


@click.command()
@input_argument
@click.option(
    "-o",
    "--output",
    "output_path",
    metavar="OUTPUT",
    required=True,
    help="File to write; its suffix chooses the format (.ply .xyz .xy .txt .asc .csv .pts). "
    "- is stdout, in the format of the input.",
)
@click.option(
    "--energy",
    type=click.Choice(["volume", "area"]),
    default="volume",
    show_default=True,
    help="What decreases: volume of the union of balls, or area of its boundary "
    "(2D: area and perimeter).",
)
@click.option(
    "--weight",
    type=click.Choice(["none", "cell", "boundary"]),
    default="cell",
    show_default=True,
    help="What each gradient is divided by: nothing, the point's cell, or its visible boundary.",
)
@click.option(
    "--radius",
    type=Radius(),
    default="auto",
    show_default=True,
    help="Radius of the balls: a length, 3x (times the mean spacing), 2% (of the bounding box's "
    "diagonal), or auto (2x).",
)
@click.option(
    "--iterations",
    type=click.IntRange(min=0),
    default=6,
    show_default=True,
    metavar="N",
    help="Number of Euler steps.",
)
@click.option(
    "--step",
    type=Step(),
    default="auto",
    show_default=True,
    help="Time step; auto is stable on any cloud.",
)
@dimension_option
@click.option(
    "--fixed",
    "fixed_column",
    metavar="COLUMN",
    help="Points whose value in this column (a name, or a number from 1 in text files) is not "
    "zero, or is the word fixed, do not move but act on the others. Rows of a text file that end "
    "in the word fixed are held without this option.",
)
@click.option(
    "--energy-log",
    "log_path",
    metavar="FILE.csv",
    help="Write iteration,volume,area,mean_move,max_move for every state 0..N.",
)
@threads_option
@click.option(
    "--float/--double",
    "single",
    default=None,
    help="Type of the positions in the output [default: as in the input].",
)
@click.option("--overwrite", is_flag=True, help="Replace files that exist.")
@quiet_option
@click.option("-v", "--verbose", is_flag=True, help="Print every state of the flow.")
@json_option
def denoise(
    input_path: str,
    output_path: str,
    energy: Literal["volume", "area"],
    weight: Literal["none", "cell", "boundary"],
    radius: str,
    iterations: int,
    step: float | Literal["auto"],
    dim: Literal["auto", 2, 3],
    fixed_column: str | None,
    log_path: str | None,
    threads: int | None,
    single: bool | None,
    overwrite: bool,
    quiet: bool,
    verbose: bool,
    as_json: bool,
) -> None:
    """Smooth the point cloud INPUT (PLY or text; - is stdin) and write it to OUTPUT.

    Row i of the output is row i of the input, with every column, element and comment it had,
    its position moved, and normals, mean curvature (1/unit, positive where the surface bends
    away from the normal) and displacement added.

    \b
    Examples:
      pcsmooth denoise scan.ply -o smooth.ply
      pcsmooth denoise scan.ply -o smooth.ply --radius 3x --iterations 10
      pcsmooth denoise curve.xy -o smooth.xy --energy area --energy-log energy.csv
      pcsmooth denoise survey.csv -o smooth.csv --fixed control_point --json
      zcat s.ply.gz | pcsmooth denoise - -o - --radius 0.02 | gzip > t.ply.gz
    """
    from pcsmooth.cli.files import (
        check_log,
        check_output,
        check_terminal,
        display_name,
        read_input,
        write_output,
    )

    if as_json and output_path == STANDARD_STREAM:
        raise click.UsageError("--json and -o - both want stdout")
    check_output(output_path, overwrite)
    if log_path is not None:
        check_log(log_path, overwrite, input_path, output_path)

    def say(message: str) -> None:
        if not quiet:
            click.echo(message, err=True)

    started = time.perf_counter()
    name = display_name(input_path)
    cloud = read_input(input_path, dim)
    check_terminal(cloud, output_path)
    result, held = _flow(
        cloud, name, fixed_column, say, quiet, verbose,
        energy=energy, weight=weight, radius=radius, iterations=iterations, step=step,
        threads=threads,
    )  # fmt: skip
    smooth = _output_cloud(
        cloud, result, output_path, single, say, f"energy={energy} weight={weight}"
    )
    write_output(smooth, output_path)
    if log_path is not None:
        from pcsmooth.cli.energy_log import write_energy_log

        write_energy_log(result.history, log_path)
    summary = _summary(name, output_path, result, held, energy, weight)
    summary["seconds"] = round(time.perf_counter() - started, 3)
    _tell(summary, say)
    if as_json:
        click.echo(json.dumps(summary))


def _flow(
    cloud: PointCloud,
    name: str,
    fixed_column: str | None,
    say: Callable[[str], None],
    quiet: bool,
    verbose: bool,
    **options: Any,
) -> tuple[DenoiseResult, int]:
    """Run the flow with a progress bar; returns its result and the number of fixed points."""
    from tqdm import tqdm

    from pcsmooth.cli.fixed_points import fixed_points
    from pcsmooth.denoising import denoise as denoise_points
    from pcsmooth.errors import CloudFileError, InvalidInputError
    from pcsmooth.kernels.threads import announce_compilation

    fixed = fixed_points(cloud, fixed_column, name)
    held = 0 if fixed is None else int(fixed.sum())
    bar = tqdm(
        total=options["iterations"] + 1, desc=Path(name).name, unit="state", delay=1.0, leave=False,
        file=sys.stderr, disable=True if quiet else None,
    )  # fmt: skip

    def on_state(record: Record) -> None:
        if verbose:
            with bar.external_write_mode(file=sys.stderr):
                say(
                    f"  {record.iteration:4d}  volume {record.volume:.8g}  area {record.area:.8g}"
                    f"  moved {record.mean_move:.3g} (at most {record.max_move:.3g})"
                )
        bar.update()

    with bar, announce_compilation(lambda: say("compiling for this machine (first run only) ...")):
        try:
            result = denoise_points(cloud.points, fixed=fixed, on_state=on_state, **options)
        except InvalidInputError as error:
            cause, _, remedy = str(error).partition("; ")
            raise CloudFileError(name, cause, remedy) from error
    return result, held


def _output_cloud(
    cloud: PointCloud,
    result: DenoiseResult,
    output_path: str,
    single: bool | None,
    say: Callable[[str], None],
    how: str,
) -> PointCloud:
    """Build the cloud to write; says what will be lost, rounded or left out."""
    from dataclasses import replace

    import numpy as np

    import pcsmooth
    from pcsmooth.attributes import with_estimates
    from pcsmooth.errors import CloudFileError
    from pcsmooth.formats import lost_in, output_format, written_position_type

    to_stdout = output_path == STANDARD_STREAM
    target = output_format(None if to_stdout else output_path, cloud)
    if single is not None:
        cloud = replace(cloud, position_type=np.dtype(np.float32 if single else np.float64))
    written_type = written_position_type(cloud)
    if written_type != cloud.position_type:
        say(f"positions are {cloud.position_type} in the input; they are written as double")
    with np.errstate(over="ignore"):
        written = result.points.astype(written_type)
    if np.any(np.isinf(written) & np.isfinite(result.points)):
        raise CloudFileError(output_path, "float cannot hold such coordinates", "pass --double")
    rounding = np.abs(written[result.finite] - result.points[result.finite]).max()
    mean_displacement = result.displacement[result.finite].mean()
    if rounding > _ROUNDING_SHARE * mean_displacement:
        say(
            f"warning: float positions round these coordinates by up to {rounding:.2g}, against "
            f"a mean displacement of {mean_displacement:.2g}; --double keeps them"
        )
    lost = lost_in(cloud, target)
    if lost:
        say(f"warning: {target} files cannot hold {', '.join(lost)}")
    smooth, kept = with_estimates(
        cloud,
        result.points,
        result.normals,
        result.mean_curvature,
        result.displacement,
        is_ply=target == "ply",
        provenance=f"{pcsmooth.__version__} denoise {how} radius={result.radius:.9g} "
        f"spacing={result.spacing:.9g} step={result.step:.9g} "
        f"iterations={len(result.history) - 1}",
    )
    for column in kept:
        say(f"column '{column}' is the input's own and kept; the estimate has its other names")
    return smooth


def _summary(
    name: str, output_path: str, result: DenoiseResult, held: int, energy: str, weight: str
) -> dict[str, Any]:
    """Collect what the summary says, in the order of the JSON."""
    first, last = result.history[0], result.history[-1]
    moved = result.displacement[result.finite]
    return {
        "input": name,
        "output": output_path,
        "points": len(result.points),
        "dimension": int(result.points.shape[1]),
        "not_finite": int((~result.finite).sum()),
        "fixed": held,
        "energy": energy,
        "weight": weight,
        "spacing": result.spacing,
        "radius": result.radius,
        "step": result.step,
        "iterations": last.iteration,
        "volume_before": first.volume,
        "volume_after": last.volume,
        "area_before": first.area,
        "area_after": last.area,
        "mean_displacement": float(moved.mean()),
        "max_displacement": float(moved.max()),
    }


def _tell(summary: dict[str, Any], say: Callable[[str], None]) -> None:
    """Print the summary for a person."""
    notes = "".join(
        f", {summary[key]} {text}"
        for key, text in (("not_finite", "not finite (passed through)"), ("fixed", "fixed"))
        if summary[key]
    )
    spacings = summary["radius"] / summary["spacing"] if summary["spacing"] else 0.0
    say(f"{summary['input']}: {summary['points']} points in {summary['dimension']}D{notes}")
    say(
        f"  radius {summary['radius']:.6g} ({spacings:.3g}x the mean spacing "
        f"{summary['spacing']:.6g}), step {summary['step']:.6g}, "
        f"{summary['iterations']} iterations on the {summary['energy']}, "
        f"weight {summary['weight']}"
    )
    say(
        f"  volume {summary['volume_before']:.6g} -> {summary['volume_after']:.6g}, "
        f"area {summary['area_before']:.6g} -> {summary['area_after']:.6g}"
    )
    say(
        f"  points moved {summary['mean_displacement']:.4g} on average, "
        f"{summary['max_displacement']:.4g} at most"
    )
    say(f"  wrote {summary['output']} in {summary['seconds']:.2f} s")
