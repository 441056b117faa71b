"""Ways to denoise a cloud: pcsmooth, and other programs with parameters that suit the clouds."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from peer_answers import recall_peer
from peers import Array

from pcsmooth import denoise

#: Takes noisy points and the mean spacing of the clean ones, returns the points denoised.
Smoother = Callable[[Array, float], Array]

#: What pcsmooth is called with, by the name in the tables.
VARIANTS: Mapping[str, Mapping[str, Any]] = {
    "pcsmooth": {},
}


def by_pcsmooth(options: Mapping[str, Any]) -> Smoother:
    """Denoise by pcsmooth with some options."""

    def smooth(points: Array, spacing: float) -> Array:
        return np.asarray(denoise(points, **options).points)

    return smooth


def by_peer(program: str, *parameters: float, spacings: tuple[float, ...] = ()) -> Smoother:
    """Denoise by a program of `peers`; its last parameters are lengths in spacings."""

    def smooth(points: Array, spacing: float) -> Array:
        lengths = (round(multiple * spacing, 9) for multiple in spacings)
        return recall_peer(program, (points,), *parameters, *lengths)

    return smooth


def unchanged(points: Array, spacing: float) -> Array:
    """Leave the points as they are."""
    return points


NOISY = "noisy"
INPUT: Mapping[str, Smoother] = {NOISY: unchanged}
OURS: Mapping[str, Smoother] = {name: by_pcsmooth(options) for name, options in VARIANTS.items()}
JETS: Mapping[int, str] = {count: f"CGAL jets, k {count}" for count in (24, 50, 100)}
BY_JETS: Mapping[str, Smoother] = {
    name: by_peer("cgal_smooth_jets", count) for count, name in JETS.items()
}
OTHERS: Mapping[str, Smoother] = {
    "CGAL bilateral, k 50, 25°, 2 times": by_peer("cgal_smooth_bilateral", 50, 25, 2),
    "CGAL bilateral, k 120, 25°, once": by_peer("cgal_smooth_bilateral", 120, 25, 1),
    "Open3D MLS, k 50, radius 5": by_peer("open3d_smooth_mls", 50, spacings=(5,)),
    "Open3D bilateral, k 50, radius 5, sigmas 2 and 2": by_peer(
        "open3d_smooth_bilateral", 50, spacings=(5, 2, 2)
    ),
    "Open3D Laplacian, k 20, rate 0.5, 3 times": by_peer("open3d_smooth_laplacian", 3, 0.5, 20),
    "Open3D Taubin, its defaults": by_peer("open3d_smooth_taubin", 10, 0.5, -0.53, 20),
}
PEERS_NOTE = (
    "The bilateral filter of CGAL gets normals of jets with k = 24, oriented along a minimum "
    "spanning tree. The lengths of Open3D are in mean spacings of the clean cloud, which it is "
    "told. On two of the shapes, 10,000 points, Open3D's own defaults were tried too: MLS and "
    "bilateral are better with them at 1 % and worse beyond, Laplacian is worse at all noises."
)
SMOOTHERS: Mapping[str, Smoother] = {**INPUT, **OURS, **BY_JETS, **OTHERS}
