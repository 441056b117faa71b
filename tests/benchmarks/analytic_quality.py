"""How far denoised clouds are from a torus and a sphere, as a Markdown table."""

from collections.abc import Callable, Sequence

import curvature_shapes
import numpy as np
import smoothers as ways
from peers import PeerError
from smoothers import Smoother
from surface_distances import Array, root_mean_square
from tables import header, heading, row

from pcsmooth.neighbors.spacing import mean_spacing

NOISES = (0.36, 0.71, 1.42)  #: standard deviations, in spacings
TARGETS = (0.0015, 0.0032, 0.0085)  #: RMS distances
N_POINTS = 20_000
SEEDS = (0, 1, 2)


def clean_torus(seed: int) -> Array:
    """Random points of the torus with radii 1 and 0.4 about the z axis."""
    return curvature_shapes.torus(N_POINTS, 0.0, seed=seed).points


def torus_distances(points: Array) -> Array:
    """Signed distances to this torus."""
    ring = np.hypot(points[:, 0], points[:, 1]) - 1.0
    return np.asarray(np.hypot(ring, points[:, 2]) - 0.4)


def clean_sphere(seed: int) -> Array:
    """Random points of the unit sphere."""
    return curvature_shapes.sphere(N_POINTS, 1.0, False, seed=seed).points


def sphere_distances(points: Array) -> Array:
    """Signed distances to this sphere."""
    return np.asarray(np.linalg.norm(points, axis=1) - 1.0)


def noisy_points(clean: Array, deviation: float, seed: int) -> Array:
    """Add isotropic noise, L."""
    return clean + deviation * np.random.default_rng(100 + seed).normal(size=clean.shape)


def analytic_section() -> None:
    """Compare distances to a torus and a sphere."""
    heading(
        f"Analytic: {N_POINTS:,} uniformly random points, isotropic noise, means over three seeds",
        "RMS distance to the surface. The noise is in mean spacings of the clean cloud, at the "
        "torus (radii 1 and 0.4) about 0.01, 0.02 and 0.04. Distances and targets are lengths "
        "where these radii and that of the sphere are 1; they scale with the surface.",
    )
    names = (*ways.INPUT, *ways.OURS, ways.JETS[24], ways.JETS[100])
    header("surface", "noise, spacings", "noise, length", *names, "target")
    surfaces: dict[str, tuple[Callable[[int], Array], Callable[[Array], Array]]] = {
        "torus": (clean_torus, torus_distances),
        "sphere": (clean_sphere, sphere_distances),
    }
    for surface, (make, distances) in surfaces.items():
        clouds = [make(seed) for seed in SEEDS]
        spacings = [mean_spacing(cloud) for cloud in clouds]
        for noise, target in zip(NOISES, TARGETS, strict=True):
            noisy = [
                noisy_points(cloud, noise * spacing, seed)
                for seed, cloud, spacing in zip(SEEDS, clouds, spacings, strict=True)
            ]
            cells = [
                surface_errors(ways.SMOOTHERS[name], noisy, spacings, distances) for name in names
            ]
            length = f"{noise * float(np.mean(spacings)):.4f}"
            row(surface, f"{noise:g}", length, *cells, f"{target:.4f}")


def surface_errors(
    way: Smoother,
    clouds: Sequence[Array],
    spacings: Sequence[float],
    distances: Callable[[Array], Array],
) -> str:
    """Mean RMS distance to a surface of what a way makes of clouds, or why there is none."""
    try:
        found = [way(cloud, spacing) for cloud, spacing in zip(clouds, spacings, strict=True)]
    except PeerError as failure:
        return str(failure)
    return f"{np.mean([root_mean_square(distances(cloud)) for cloud in found]):.5f}"
