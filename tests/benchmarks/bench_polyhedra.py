"""Speed, memory, limits and shapes of unions of convex polyhedra, as Markdown tables.

Everything runs on 2 threads. Times are the least of up to three runs, of one where it takes more
than five seconds. Without sections named, all are printed but the memory's.
Usage: python bench_polyhedra.py [--scale SHARE] [SECTION ...]
"""

import argparse
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import get_args

import numpy as np
import numpy.typing as npt
from clouds import noisy_ellipse, noisy_torus
from machine import machine_line
from measuring import run_command, wall_seconds
from polyhedra_shapes import (
    FIGURE_38,
    RATIO,
    STEP,
    even_sphere,
    flowing_sphere,
    hull_beside,
    least_of_radial,
)
from tables import header, heading, percent, row

from pcsmooth import ConvexBody, load_presets, measure_balls, measure_polyhedra
from pcsmooth.energies.protocol import UnionName
from pcsmooth.kernels.threads import thread_limit

THREADS = 2
NOISE = 0.3  #: spacings
UNIONS: tuple[UnionName, ...] = get_args(UnionName)

#: Points per second to reach, by body and union.
SPEED_TARGETS = {
    ("cube", "naive"): 60_000,
    ("icosahedron", "naive"): 25_000,
    ("cube", "inclusion-exclusion"): 10_000,
    ("cube", "exact"): 15_000,
    ("icosahedron", "exact"): 3_000,
}

#: Radius of the bodies on the unit sphere where limits are measured.
LIMIT_RADIUS = 0.15

Points = npt.NDArray[np.float64]


def best_seconds(work: Callable[[], object], repeats: int = 3, enough: float = 5.0) -> float:
    """Least wall time of some runs, of one that takes long enough."""
    best = wall_seconds(work)
    for _ in range(repeats - 1):
        if best < enough:
            best = min(best, wall_seconds(work))
    return best


# --- speed


def speed_section(scale: float) -> None:
    """Time evaluations of noisy clouds, beside the union of balls."""
    n_points = round(100_000 * scale)
    heading(
        f"Points per second, {n_points:,} points with noise of {NOISE} spacings, r = {RATIO:g} "
        f"spacings, {THREADS} threads",
        "In brackets the target.",
    )
    header("cloud", "body", *UNIONS)
    clouds = {
        "torus": (noisy_torus, ("cube", "icosahedron", "sphere-50")),
        "ellipse (2D)": (noisy_ellipse, ("square", "circle-64")),
    }
    for name, (make, bodies) in clouds.items():
        points, spacing = make(n_points, NOISE)
        small, small_spacing = make(500, NOISE)
        measure_balls(small, RATIO * small_spacing)  # compile or load
        ball = best_seconds(partial(measure_balls, points, RATIO * spacing))
        row(name, "ball", f"{n_points / ball:,.0f}", "", "")
        for body in bodies:
            shape = load_presets()[body]
            cells = []
            for union in UNIONS:
                measure_polyhedra(small, RATIO * small_spacing, shape, union)
                work = partial(measure_polyhedra, points, RATIO * spacing, shape, union)
                target = SPEED_TARGETS.get((body, union))
                shown = f" ({target:,})" if target else ""
                cells.append(f"{n_points / best_seconds(work):,.0f}{shown}")
            row(name, body, *cells)


# --- memory


def memory_section(scale: float) -> None:
    """Measure the peak memory of evaluations, each in a process of its own."""
    n_points = round(1_000_000 * scale)
    points, spacing = noisy_torus(n_points, NOISE)
    heading(f"Peak memory, torus of {n_points:,} points, cube, r = {RATIO:g} spacings")
    header("union", "bytes per point beyond the input")
    script = Path(__file__).with_name("polyhedra_memory.py")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "points.npy"
        np.save(path, points)
        for union in UNIONS:
            run = run_command(sys.executable, str(script), str(path), str(RATIO * spacing), union)
            row(union, f"{int(run.output) / n_points:.0f}")


# --- limits


def limits_section(scale: float) -> None:
    """Compare volumes over a sphere with the integrals that they tend to."""
    radius = LIMIT_RADIUS / np.sqrt(scale)
    heading(
        f"Volumes over the even unit sphere, r = {radius:.3g}, beside their limits",
        "Radial: integral of r (rho(n) + rho(-n)); support: of r (h(n) + h(-n)). Errors by r over "
        "the spacing; the last column is what the two errors before tend to if they fall as its "
        "inverse (naive: as its inverse square).",
    )
    header("body", "union", "limit", "over r", "error at 2", "error at 4", "extrapolated")
    normals = even_sphere(100_000)
    for name in ("cube", "tetrahedron", "icosahedron"):
        body = load_presets()[name]
        radial, support = sphere_limits(body, radius, normals)
        for union in UNIONS:
            limit = radial if union == "naive" else support
            errors = [volume_over_sphere(body, union, radius, k) / limit - 1.0 for k in (2, 4)]
            share = 4.0 if union == "naive" else 2.0
            errors.append((share * errors[1] - errors[0]) / (share - 1.0))
            kind = "radial" if union == "naive" else "support"
            row(name, union, kind, f"{limit:.2f}", *map(percent, errors))


def sphere_limits(body: ConvexBody, radius: float, normals: Points) -> tuple[float, float]:
    """Integrals over the unit sphere divided by r; the radial one with the shell's own areas."""
    outer = 1.0 + radius * body.radial(normals)
    inner = 1.0 - radius * body.radial(-normals)
    radial = 4.0 / 3.0 * np.pi * float(np.mean(outer**3 - inner**3)) / radius
    widths = body.support(normals) + body.support(-normals)
    return radial, 4.0 * np.pi * float(np.mean(widths))


def volume_over_sphere(body: ConvexBody, union: UnionName, radius: float, ratio: float) -> float:
    """Volume over r of bodies whose r is so many spacings of an even unit sphere."""
    points = even_sphere(round(4.0 * np.pi * (ratio / radius) ** 2))
    return measure_polyhedra(points, radius, body, union).volume / radius


# --- shapes


def spheres_section(scale: float) -> None:
    """Follow the thesis' Figure 38: how near to K a sphere comes."""
    n_points, steps = round(1000 * scale), (0, 10, 20, 40)
    heading(
        f"Figure 38 of the thesis: a sphere of {n_points:,} points, r = {RATIO:g} spacings",
        "Median angle over the convex hull's area to the nearest normal of K, degrees, after so "
        f"many steps on the volume, equal ones of {STEP:g} spacings squared or automatic ones, and "
        "of the shape of a given volume whose limit is least: K for the exact union.",
    )
    header("body", "union", "step", *map(str, steps), "least")
    for name in FIGURE_38:
        body = load_presets()[name]
        pillow = hull_beside(least_of_radial(body), body)
        least = {"naive": f"{pillow.median_angle:.1f}", "exact": "0.0"}
        for union in UNIONS:
            for step in ("equal", "automatic"):
                clouds = list(
                    flowing_sphere(n_points, body, union, steps[-1], automatic=step == "automatic")
                )
                angles = [hull_beside(clouds[count], body).median_angle for count in steps]
                row(name, union, step, *(f"{a:.1f}" for a in angles), least.get(union, ""))


SECTIONS: dict[str, Callable[[float], None]] = {
    "speed": speed_section,
    "limits": limits_section,
    "spheres": spheres_section,
    "memory": memory_section,
}


def main() -> None:
    """Print the sections asked for."""
    parser = argparse.ArgumentParser(description="Print tables of speed, memory and limits.")
    parser.add_argument("--scale", type=float, default=1.0, help="share of the full sizes [1]")
    parser.add_argument("section", nargs="*", help=", ".join(SECTIONS))
    options = parser.parse_args()
    unknown = set(options.section) - set(SECTIONS)
    if unknown:
        parser.error(f"no section {', '.join(sorted(unknown))}; there are {', '.join(SECTIONS)}")
    print(machine_line())
    with thread_limit(THREADS):
        for name in options.section or [name for name in SECTIONS if name != "memory"]:
            SECTIONS[name](options.scale)


if __name__ == "__main__":
    main()
