"""Which scheme, energy, weight and radius do what, as Markdown tables."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import curvature_shapes
import numpy as np
from analytic_quality import clean_torus, noisy_points, torus_distances
from mesh_shapes import Shape, load_shapes
from peers import PeerError
from scipy.spatial import cKDTree
from shape_keeping import largest_hole, volume_change
from surface_distances import Array, chamfer_distance, root_mean_square
from tables import header, heading, percent, row

from pcsmooth import denoise
from pcsmooth.neighbors.spacing import mean_spacing

MESHES = ("spot", "wingnut", "koala")
N_POINTS = 10_000
LEVELS = (0.01, 0.03)  #: standard deviations of the noise on the meshes, of their radius
TORUS_NOISES = (0.36, 1.42)  #: likewise on the torus, in spacings
AXES = 180.0, 120.0  #: semi-axes of the ellipse
ELLIPSE_POINTS, ELLIPSE_NOISES, ELLIPSE_SEEDS = 400, (0.3, 1.0, 2.0), 5


@dataclass(frozen=True)
class Choice:
    """One way to call `denoise`.

    Attributes
    ----------
    options : mapping
        Its options.
    noise_share : float or None
        The noise that it is told, as a share of what it measures; None if it is told nothing.
    """

    options: Mapping[str, Any] = field(default_factory=dict)
    noise_share: float | None = None

    def options_for(self, points: Array) -> dict[str, Any]:
        """All options for a cloud."""
        options = dict(self.options)
        if self.noise_share is not None:
            plan = denoise(points).plan
            assert plan is not None
            options["noise"] = self.noise_share * plan.noise.deviation
        return options

    def __call__(self, points: Array) -> Array:
        """Denoise a cloud."""
        return np.asarray(denoise(points, **self.options_for(points)).points)


def _euler(**options: Any) -> Choice:
    return Choice({"scheme": "euler", **options})


def _implicit(order: int, **options: Any) -> Choice:
    return Choice({"scheme": "implicit", "order": order, **options})


CHOICES: Mapping[str, Choice] = {
    "filter (the default)": Choice(),
    "filter along normals": Choice({"motion": "normal"}),
    "filter, told half the noise": Choice(noise_share=0.5),
    "filter, told twice the noise": Choice(noise_share=2.0),
    "Euler, volume, cell": _euler(),
    "Euler, volume, boundary": _euler(weight="boundary"),
    "Euler, volume, none": _euler(weight="none"),
    "Euler, area, cell": _euler(energy="area"),
    "Euler, area, none": _euler(energy="area", weight="none"),
    "Euler, radius 1.5x": _euler(radius="1.5x"),
    "Euler, radius 3x": _euler(radius="3x"),
    "Euler, radius 4x": _euler(radius="4x"),
    "Euler, keep_volume": _euler(keep_volume=True),
    "Euler along normals": _euler(motion="normal"),
    "implicit, order 1": _implicit(1),
    "implicit, order 2": _implicit(2),
    "implicit, order 2, radius 3x": _implicit(2, radius="3x"),
}


def choices_section(data: Path, seed: int) -> None:
    """Compare choices on the shipped meshes, a torus and an ellipse."""
    heading(
        "Choices in 3D",
        f"On {', '.join(MESHES)} ({N_POINTS:,} points, noise in shares of the radius): mean CD "
        "times 10⁴; and, at the smaller noise, the volume change largest in magnitude, the "
        "largest hole, in spacings, and how uneven the points are: standard deviation over mean "
        "of the distances to the nearest point, averaged. On the torus (20,000 random points): "
        "RMS distance in units of the noise, which is in spacings, and CPU seconds per 100,000 "
        "points at the smaller noise, the best of three.",
    )
    columns = [
        *(f"CD, {percent(level)}" for level in LEVELS),
        *(f"torus, {noise:g}" for noise in TORUS_NOISES),
        *("volume", "hole", "uneven", "CPU s"),
    ]
    header("choice", *columns)
    shapes = load_shapes(MESHES, data)
    try:
        row("noisy", *mesh_cells(None, shapes, seed))
        for name, choice in CHOICES.items():
            row(name, *mesh_cells(choice, shapes, seed))
    except PeerError as failure:
        print(f"\nSkipped: point_cloud_utils {failure}.")
    ellipse_table()


def ellipse_table() -> None:
    """Print what the choices do to an ellipse."""
    heading(
        "Choices in 2D",
        f"Ellipse with semi-axes {AXES[0]:g} and {AXES[1]:g}, {ELLIPSE_POINTS} points, means over "
        f"{ELLIPSE_SEEDS} seeds: RMS distance in units of the noise, and change of the enclosed "
        "area (perimeter times mean signed distance, over the area). The noise is in spacings.",
    )
    header(
        "choice",
        *(f"{kind}, {n:g}" for kind in ("distance", "area") for n in ELLIPSE_NOISES),
    )
    for name, choice in {"noisy": None, **CHOICES}.items():
        row(name, *ellipse_cells(choice))


def mesh_cells(choice: Choice | None, shapes: Sequence[Shape], seed: int) -> list[str]:
    """Return the cells of the table in 3D; None leaves the points as they are."""
    scores = np.zeros(len(LEVELS))
    changes, holes, unevenness = [], [], []
    for shape in shapes:
        clean, unit = shape.sample(N_POINTS, seed)
        for place, level in enumerate(LEVELS):
            noisy = clean + level * unit
            points = noisy if choice is None else choice(noisy)
            scores[place] += 1e4 * chamfer_distance(points, clean) / len(shapes)
            if place == 0:
                changes.append(volume_change(points, shape))
                holes.append(largest_hole(points, clean) / mean_spacing(clean))
                unevenness.append(uneven(points))
    return [
        *map("{:.3f}".format, scores),
        *torus_cells(choice),
        f"{100 * max(changes, key=abs):+.2f} %",
        f"{max(holes):.2f}",
        f"{np.mean(unevenness):.2f}",
        cpu_seconds(choice),
    ]


def torus_cells(choice: Choice | None) -> list[str]:
    """RMS distances to the torus, in units of the noise."""
    clean = clean_torus(0)
    cells = []
    for noise in TORUS_NOISES:
        deviation = noise * mean_spacing(clean)
        noisy = noisy_points(clean, deviation, 0)
        points = noisy if choice is None else choice(noisy)
        cells.append(f"{root_mean_square(torus_distances(points)) / deviation:.2f}")
    return cells


def cpu_seconds(choice: Choice | None) -> str:
    """CPU seconds per 100,000 points, on the torus with the least noise; the best of three."""
    if choice is None:
        return ""
    clean = clean_torus(0)
    noisy = noisy_points(clean, TORUS_NOISES[0] * mean_spacing(clean), 0)
    options = choice.options_for(noisy)
    taken = []
    for _ in range(3):
        start = time.process_time()
        denoise(noisy, **options)
        taken.append(time.process_time() - start)
    return f"{1e5 / len(noisy) * min(taken):.1f}"


def uneven(points: Array) -> float:
    """Standard deviation over mean of the distances to the nearest other point."""
    distances, _ = cKDTree(points).query(points, 2)
    return float(distances[:, 1].std() / distances[:, 1].mean())


def ellipse_cells(choice: Choice | None) -> list[str]:
    """Return the cells of the table in 2D; None leaves the points as they are."""
    surface, _ = curvature_shapes.ellipse(ELLIPSE_POINTS, *AXES)
    to_area = surface.spacing * ELLIPSE_POINTS / (np.pi * AXES[0] * AXES[1])
    errors, changes = [], []
    for noise in ELLIPSE_NOISES:
        deviation = noise * surface.spacing
        found = []
        for seed in range(ELLIPSE_SEEDS):
            noisy = noisy_points(surface.points, deviation, seed)
            found.append(ellipse_distances(noisy if choice is None else choice(noisy)))
        errors.append(np.mean([root_mean_square(far) for far in found]) / deviation)
        changes.append(100 * to_area * np.mean(found))
    return [*map("{:.2f}".format, errors), *map("{:+.2f} %".format, changes)]


def ellipse_distances(points: Array) -> Array:
    """Signed distances to the ellipse."""
    curve, normals, tree = _fine_ellipse()
    _, nearest = tree.query(points)
    return np.asarray(np.sum((points - curve[nearest]) * normals[nearest], axis=1))


@cache
def _fine_ellipse() -> tuple[Array, Array, cKDTree]:
    """Points so close to each other that a distance to the curve is one to the nearest."""
    surface, _ = curvature_shapes.ellipse(100_000, *AXES)
    return surface.points, surface.normals, cKDTree(surface.points)
