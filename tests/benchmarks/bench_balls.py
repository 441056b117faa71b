"""Time and memory of evaluations, flows and the command line, as one Markdown table.

The yardstick is scipy's cKDTree, built and asked for the 24 nearest neighbours of every point
(itself among them) with 2 workers, in the same run on the same cloud. Everything runs on 2
threads. Times are medians of three runs, of one for flows and the largest cloud.
Usage: python bench_balls.py [--scale SHARE]
"""

import argparse
import sys
import tempfile
from functools import partial
from pathlib import Path
from time import perf_counter

import numpy as np
import numpy.typing as npt
from clouds import (
    graded_plane,
    noisy_ellipse,
    noisy_torus,
    room_with_clump,
    solid_clump,
    spread_plane,
)
from machine import machine_line
from measuring import median_seconds, run_command
from scipy.spatial import cKDTree

from pcsmooth import (
    BallEnergy,
    Filter,
    PointCloud,
    estimate_curvature,
    local_spacings,
    measure_balls,
    write_cloud,
)
from pcsmooth import (
    denoise as denoise_points,
)
from pcsmooth.flows.euler import Euler
from pcsmooth.flows.flow import run_flow
from pcsmooth.kernels.threads import thread_limit

THREADS = 2
NOISE = 0.3  #: spacings
STEPS = 10

Points = npt.NDArray[np.float64]


def main(scale: float) -> None:
    """Print the table; the clouds have `scale` times the full number of points."""
    million = round(1_000_000 * scale)
    print(machine_line(), end="\n\n")
    print("| measured | points | radius, spacings | seconds | points/s | result | target |")
    print("|---|--:|--:|--:|--:|---|---|")
    with thread_limit(THREADS), tempfile.TemporaryDirectory() as folder:
        for small, spacing in (noisy_torus(2000, NOISE), noisy_ellipse(2000, NOISE)):
            measure_balls(small, 2 * spacing)  # compile or load
        warm_command(Path(folder))
        points, spacing = noisy_torus(million, NOISE)
        times = torus_rows(points, spacing)
        flow_rows(points, spacing, times)
        evaluation_memory_row(points, spacing, Path(folder))
        command_memory_rows(points, Path(folder))
        large_torus_row(4 * million, times[2])
        ellipse_row(million, million / times[2])
        pair_rows(round(100_000 * scale))
        spread_rows(round(200_000 * scale))
        clump_rows(scale, Path(folder))
        start_rows(round(10_000 * scale), Path(folder))


def row(
    measured: str,
    n_points: int | None = None,
    radius: str = "",
    seconds: float | None = None,
    rate: bool = False,
    result: str = "",
    target: str = "",
) -> None:
    """Print one row of the table."""
    cells = (
        measured,
        "" if n_points is None else f"{n_points:,}",
        radius,
        "" if seconds is None else f"{seconds:.3g}",
        f"{n_points / seconds:,.0f}" if rate and n_points and seconds else "",
        result,
        target,
    )
    print("|", " | ".join(cells), "|", flush=True)


def yardstick(points: Points) -> None:
    """Build a tree and query 24 neighbours of every point."""
    cKDTree(points).query(points, 24, workers=THREADS)


def against_tree(seconds: float, reference: float) -> str:
    """Say how many times the yardstick something takes."""
    return f"{seconds / reference:.2f} × k-d tree ({reference:.3g} s)"


def torus_rows(points: Points, spacing: float) -> dict[int, float]:
    """Time one evaluation at two radii; returns the seconds by radius in spacings."""
    targets = {2: "0.7", 3: "1.0"}
    reference, *taken = median_seconds(
        partial(yardstick, points),
        *(partial(measure_balls, points, multiple * spacing) for multiple in targets),
    )
    times = dict(zip(targets, taken, strict=True))
    for multiple, target in targets.items():
        seconds = times[multiple]
        text = against_tree(seconds, reference)
        row("evaluation, torus", len(points), str(multiple), seconds, True, text, target)
    return times


def flow_rows(points: Points, spacing: float, times: dict[int, float]) -> None:
    """Time flows, with and without the evaluation of the input, beside one evaluation."""
    for multiple, evaluation in times.items():
        start = perf_counter()
        states = run_flow(BallEnergy(multiple * spacing), points, Euler(), STEPS)
        next(states)
        first = perf_counter()
        for _ in states:
            pass
        end = perf_counter()
        names = (f"{STEPS} steps of a flow", f"flow with its {STEPS + 1} evaluations")
        for name, seconds, target in zip(names, (end - first, end - start), ("8", ""), strict=True):
            text = f"{seconds / evaluation:.2f} × one evaluation"
            row(f"{name}, torus", len(points), str(multiple), seconds, False, text, target)


def evaluation_memory_row(points: Points, spacing: float, folder: Path) -> None:
    """Measure the peak memory of one evaluation, in a process of its own."""
    path = folder / "points.npy"
    np.save(path, points)
    script = Path(__file__).with_name("evaluation_memory.py")
    run = run_command(sys.executable, str(script), str(path), str(2 * spacing))
    text = f"{int(run.output) / len(points):.0f} bytes per point beyond the input"
    row("peak memory of an evaluation, torus", len(points), "2", result=text, target="400")


def pcsmooth(*arguments: str) -> tuple[str, ...]:
    """Return the command line of `pcsmooth` with some arguments."""
    return (sys.executable, "-m", "pcsmooth", *arguments)


def denoise(path: Path, *options: str) -> tuple[str, ...]:
    """Return the command line that denoises a PLY file, by default with the filter."""
    output = str(path.with_name("smooth.ply"))
    return pcsmooth(
        "denoise", str(path), "-o", output, "--overwrite", "--quiet",
        "--threads", str(THREADS), *options,
    )  # fmt: skip


def warm_command(folder: Path) -> None:
    """Let the command line compile what is not in the cache yet."""
    path = folder / "warm.ply"
    write_cloud(PointCloud(noisy_torus(2000, NOISE)[0]), str(path))
    for scheme in ("euler", "filter"):
        run_command(*denoise(path, "--scheme", scheme))


def command_memory_rows(points: Points, folder: Path) -> None:
    """Measure the peak memory of denoising a file by a flow and by the filter."""
    path = folder / "torus.ply"
    write_cloud(PointCloud(points), str(path))
    for options in (("--scheme", "euler", "--iterations", str(STEPS)), ()):
        run = run_command(*denoise(path, *options))
        name = f"`{' '.join(('pcsmooth denoise', *options))}`, binary PLY"
        text = f"{run.peak_bytes / 1e9:.2f} GB peak memory"
        row(name, len(points), "auto", run.seconds, result=text, target="1.2 GB")


def large_torus_row(n_points: int, smaller: float) -> None:
    """Time one evaluation of a cloud four times as large."""
    points, spacing = noisy_torus(n_points, NOISE)
    reference, seconds = median_seconds(
        partial(yardstick, points), partial(measure_balls, points, 2 * spacing), repeats=1
    )
    ratio = f"{seconds / smaller:.2f} × a quarter of the points"
    text = f"{ratio}, {against_tree(seconds, reference)}"
    row("evaluation, torus", n_points, "2", seconds, True, text, "4.4")


def ellipse_row(n_points: int, torus_rate: float) -> None:
    """Time one evaluation in 2D; the rate in 3D is given."""
    points, spacing = noisy_ellipse(n_points, NOISE)
    reference, seconds = median_seconds(
        partial(yardstick, points), partial(measure_balls, points, 2 * spacing)
    )
    factor = f"{n_points / seconds / torus_rate:.1f} × the 3D points/s"
    text = f"{factor}, {against_tree(seconds, reference)}"
    row("evaluation, ellipse (2D)", n_points, "2", seconds, True, text, "10")


def pair_rows(n_points: int) -> None:
    """Time evaluations by pairs of neighbours, on an even cloud and one of uneven density."""
    points, spacing = noisy_torus(n_points, NOISE)
    multiples = (2, 3, 4, 6, 8)
    radii = [multiple * spacing for multiple in multiples]
    reference, *times = median_seconds(
        partial(yardstick, points), *(partial(measure_balls, points, radius) for radius in radii)
    )
    for multiple, radius, seconds in zip(multiples, radii, times, strict=True):
        text = f"{per_pair(points, radius, seconds)}, {against_tree(seconds, reference)}"
        row("pairs, torus", n_points, str(multiple), seconds, True, text)

    points, smallest = graded_plane(2 * n_points, NOISE)
    reference, seconds = median_seconds(
        partial(yardstick, points), partial(measure_balls, points, 8 * smallest)
    )
    text = f"{per_pair(points, 8 * smallest, seconds)}, {against_tree(seconds, reference)}"
    name = "pairs, plane with a thousandfold fall of density"
    row(name, len(points), "8 where densest", seconds, True, text)


def spread_rows(n_points: int) -> None:
    """Time local radii on planes whose spacing varies, beside one radius on an even plane."""
    even = spread_plane(n_points, NOISE, 1.0)
    radius = 2.0 * float(np.median(local_spacings(even)))
    references = median_seconds(
        partial(measure_balls, even, radius),
        partial(denoise_points, even, Filter(radius=radius)),
        partial(estimate_curvature, even, radius=radius),
    )
    for variation in (1.0, 10.0, 100.0, 500.0):
        points = spread_plane(n_points, NOISE, variation)
        times = median_seconds(
            partial(measure_balls, points, 2.0 * local_spacings(points)),
            partial(denoise_points, points, Filter(radius="local")),
            partial(estimate_curvature, points, radius="local"),
        )
        for name, seconds, one in zip(
            ("evaluation", "default filter", "curvature"), times, references, strict=True
        ):
            text = f"{seconds / one:.2f} × one radius on an even one"
            name = f"{name}, local radii, plane whose spacing varies {variation:.0f} times"
            row(name, n_points, "local 2", seconds, True, text, "1.3")


def clump_rows(scale: float, folder: Path) -> None:
    """Time clumps of points that are all within one radius, alone and in a room."""
    before = 0.0
    with thread_limit(1):
        for n_points in (round(count * scale) for count in (1000, 4000, 10_000)):
            points = solid_clump(n_points)
            (seconds,) = median_seconds(partial(measure_balls, points, 1.0))
            text = f"{per_pair(points, 1.0, seconds)}"
            text += f", {seconds / before:.3g} × the row above" if before else ""
            row("clump within one radius, 1 thread", n_points, "", seconds, True, text)
            before = seconds
    path = folder / "room.ply"
    points = room_with_clump(round(56_000 * scale))
    write_cloud(PointCloud(points), str(path))
    for options in ((), ("--scheme", "euler")):
        seconds = run_command(*denoise(path, *options)).seconds
        name = f"`{' '.join(('pcsmooth denoise', *options))}`, room with a clump"
        row(name, len(points), "auto", seconds, target="30 s")


def per_pair(points: Points, radius: float, seconds: float) -> str:
    """Say how many pairs of points are nearer than two radii, and the time for each.

    A pair is counted from both of its ends, as every cell looks at all of its neighbours.
    """
    tree = cKDTree(points)
    pairs = int(tree.count_neighbors(tree, 2 * radius)) - len(points)
    return f"{pairs / 1e6:.3g} M pairs, {seconds / pairs * 1e9:.3g} ns per pair"


def start_rows(n_points: int, folder: Path) -> None:
    """Time the command line where it starts, and where it has to compile first."""
    best = min(run_command(*pcsmooth("--help")).seconds for _ in range(5))
    row("`pcsmooth --help`, best of 5", seconds=best)

    path = folder / "small.ply"
    write_cloud(PointCloud(noisy_torus(n_points, NOISE)[0]), str(path))
    command = denoise(path)
    warm = min(run_command(*command).seconds for _ in range(3))
    row("`pcsmooth denoise`, best of 3", n_points, "auto", warm)
    empty = {"NUMBA_CACHE_DIR": str(folder / "kernels")}
    first = run_command(*command, environment=empty).seconds
    text = f"{first - warm:.1f} s more than when warm: compilation"
    row("`pcsmooth denoise`, first run", n_points, "auto", first, result=text, target="30 s")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Print a Markdown table of times and memory.")
    parser.add_argument("--scale", type=float, default=1.0, help="share of the full sizes [1]")
    main(parser.parse_args().scale)
