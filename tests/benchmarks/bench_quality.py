"""Quality of denoising beside other programs', as Markdown tables.

pcsmooth runs with its defaults and knows nothing but the points.
Usage: python bench_quality.py [--data DIR] [--shapes NAME,...] [--points N,...] [--seed S]
    [SECTION ...]
"""

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import smoothers as ways
from analytic_quality import analytic_section
from choices import choices_section
from clouds import noisy_torus
from kept_shapes import kept_section
from machine import machine_line
from measuring import run_command
from mesh_shapes import ANALYTIC, NOISES, Shape, available_shapes, load_shapes
from peers import PeerError
from scan_quality import scans_section
from smoothers import Smoother
from surface_distances import (
    Array,
    chamfer_distance,
    point_to_mesh_distance,
)
from tables import header, heading, percent, row

from pcsmooth.neighbors.spacing import mean_spacing

SHIPPED = Path(__file__).resolve().parents[2] / "data"
Score = tuple[float, float]  #: CD and P2M, times 10^4
Scores = Mapping[tuple[str, float, str], Score | str]  #: by shape, noise and way; why there is none

#: Number of points: jets of which the better is the reference, and targets for each noise.
TARGETS: Mapping[int, tuple[tuple[str, ...], tuple[float, ...]]] = {
    10_000: ((ways.JETS[24],), (0.90, 0.80, 0.65)),
    50_000: ((ways.JETS[24], ways.JETS[100]), (0.70, 0.70, 0.70)),
}

SPEED_TARGET = 3.0


def shapes_section(shapes: Sequence[Shape], counts: Sequence[int], seed: int) -> None:
    """Compare CD and P2M on noisy meshes."""
    for n_points in counts:
        heading(
            f"Shapes: {n_points:,} points by Poisson disks, isotropic Gaussian noise, seed {seed}",
            "Meshes in the unit sphere; the noise is a share of its radius. Chamfer distance (CD) "
            "to the clean cloud and point-to-mesh distance (P2M), squared, both ways, times 10⁴.",
            ways.PEERS_NOTE,
        )
        scores: dict[tuple[str, float, str], Score | str] = {}
        for shape in shapes:
            try:
                clean, noise = shape.sample(n_points, seed)
            except PeerError as failure:
                print(f"Skipped: point_cloud_utils {failure}.")
                return
            spacing = mean_spacing(clean)
            for level in NOISES:
                for name, way in ways.SMOOTHERS.items():
                    case = shape.name, level, name
                    scores[case] = score(way, clean, clean + level * noise, spacing, shape)
        meshes = [shape.name for shape in shapes if shape.name not in ANALYTIC]
        if meshes:
            means_table(scores, meshes, n_points)
        shapes_table(scores, [shape.name for shape in shapes])


def score(way: Smoother, clean: Array, noisy: Array, spacing: float, shape: Shape) -> Score | str:
    """CD and P2M of what a way makes of a cloud, or why there is none."""
    try:
        points = way(noisy, spacing)
    except PeerError as failure:
        return str(failure)
    return (
        1e4 * chamfer_distance(points, clean),
        1e4 * point_to_mesh_distance(points, shape.vertices, shape.faces),
    )


def means_table(scores: Scores, shapes: Sequence[str], n_points: int) -> None:
    """Print means over the shapes, and ratios to jets beside their targets."""
    print(f"Means over {', '.join(shapes)}:\n")
    header("way", *(f"{kind}, {percent(noise)}" for noise in NOISES for kind in ("CD", "P2M")))
    means: dict[str, Array] = {}
    for name in ways.SMOOTHERS:
        found = [scores[shape, noise, name] for noise in NOISES for shape in shapes]
        failures = [entry for entry in found if isinstance(entry, str)]
        if failures:
            row(name, failures[0], *[""] * (2 * len(NOISES) - 1))
            continue
        means[name] = np.reshape(found, (len(NOISES), len(shapes), 2)).mean(axis=1).ravel()
        row(name, *map("{:.3f}".format, means[name]))
    references, targets = TARGETS.get(n_points, ((ways.JETS[24],), ()))
    if not all(name in means for name in references):
        return
    best = np.min([means[name] for name in references], axis=0)
    for name in ways.VARIANTS:
        ratios = map("{:.2f}".format, means[name] / best)
        row(f"{name} / {' or '.join(references)}", *ratios)
    if targets:
        row("target of this ratio", *(f"{target:.2f}" for target in targets for _ in range(2)))
    print(flush=True)


def shapes_table(scores: Scores, shapes: Sequence[str]) -> None:
    """Print CD and P2M of each shape and noise."""
    names = (*ways.INPUT, *ways.OURS, *ways.BY_JETS)
    print("CD and P2M of each shape:\n")
    header("shape", "noise", *names)
    for shape in shapes:
        for noise in NOISES:
            found = [scores[shape, noise, name] for name in names]
            cells = (
                entry if isinstance(entry, str) else f"{entry[0]:.3f}, {entry[1]:.3f}"
                for entry in found
            )
            row(shape, percent(noise), *cells)


def speed_section() -> None:
    """Time the defaults beside CGAL's jets."""
    n_points = 1_000_000
    heading(
        f"Speed: torus of {n_points:,} random points, noise of 0.3 spacings",
        "Seconds of the calls alone, each in a process of its own: the kernels are loaded and CGAL "
        "has the points already. CGAL's Python package is built with its parallel variant.",
    )
    header("way", "seconds", "CPU seconds", "threads")
    times = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "points.npy"
        np.save(path, noisy_torus(n_points, 0.3)[0])
        script = Path(__file__).with_name("smoothing_time.py")
        for name, program in ((ways.JETS[24], "cgal"), ("pcsmooth", "pcsmooth")):
            try:
                run = run_command(sys.executable, str(script), program, str(path))
            except subprocess.CalledProcessError:
                row(name, "did not run", "", "")
                continue
            found = json.loads(run.output)
            times[name] = np.array([found["seconds"], found["cpu_seconds"]])
            row(name, *(f"{found[key]:.3g}" for key in ("seconds", "cpu_seconds", "threads")))
    if len(times) == 2:
        wall, cpu = times["pcsmooth"] / times[ways.JETS[24]]
        print(f"\nRatio: {wall:.2f} (target {SPEED_TARGET:g}), of CPU seconds {cpu:.2f}.")


def names_of(text: str) -> list[str]:
    """Split at commas."""
    return text.split(",")


def main() -> None:
    """Print the sections asked for."""
    parser = argparse.ArgumentParser(description="Print tables of the quality of denoising.")
    parser.add_argument(
        "--data", type=Path, default=SHIPPED, help="folder with meshes/ and scans/ [the shipped]"
    )
    parser.add_argument("--shapes", type=names_of, help="of the folder's, and sphere, torus [all]")
    parser.add_argument(
        "--points", type=names_of, default=["10000", "50000"], help="points [10000,50000]"
    )
    parser.add_argument("--seed", type=int, default=1, help="of samples and noise [1]")
    parser.add_argument("section", nargs="*", help="shapes, analytic, kept, scans, choices, speed")
    options = parser.parse_args()
    shapes = load_shapes(options.shapes or available_shapes(options.data), options.data)
    counts = [int(count) for count in options.points]
    sections: dict[str, Callable[[], None]] = {
        "shapes": partial(shapes_section, shapes, counts, options.seed),
        "analytic": analytic_section,
        "kept": partial(kept_section, shapes, counts[0], options.seed),
        "scans": partial(scans_section, options.data, SHIPPED),
        "choices": partial(choices_section, SHIPPED, options.seed),
        "speed": speed_section,
    }
    unknown = set(options.section) - set(sections)
    if unknown:
        parser.error(f"no section {', '.join(sorted(unknown))}; there are {', '.join(sections)}")
    print(machine_line())
    for name in options.section or sections:
        sections[name]()


if __name__ == "__main__":
    main()
