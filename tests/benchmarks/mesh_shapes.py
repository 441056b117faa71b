"""Closed meshes in the unit sphere, and noisy clouds on them as papers on denoising make them."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh
from peer_answers import recall_peer
from surface_distances import Array, Faces, unit_sphere

MESHES = ("fandisk", "spot", "koala", "hand", "skull", "wingnut", "penguin", "goathead")
ANALYTIC = ("sphere", "torus")
NOISES = (0.01, 0.02, 0.03)  #: standard deviations, of the radius of the unit sphere


@dataclass(frozen=True)
class Shape:
    """A mesh whose bounding box is centred at the origin and whose farthest vertex is at 1."""

    name: str
    vertices: Array
    faces: Faces

    def sample(self, n_points: int, seed: int) -> tuple[Array, Array]:
        """Sample points by Poisson disks, in random order, and noise of standard deviation 1.

        Raises
        ------
        PeerError
            If the program that samples is not there.
        """
        rng = np.random.default_rng(seed)
        points = recall_peer("poisson_disk", (self.vertices, self.faces), n_points, seed)
        clean = points[rng.permutation(len(points))[:n_points]]
        return clean, rng.normal(size=clean.shape)


def available_shapes(data: Path) -> tuple[str, ...]:
    """Names of the meshes of a folder, and of those that are made."""
    return (*(name for name in MESHES if _path(data, name).exists()), *ANALYTIC)


def load_shapes(names: Sequence[str], data: Path) -> list[Shape]:
    """Make shapes or read them from a folder, by name."""
    return [_load(name, data) for name in names]


def _path(data: Path, name: str) -> Path:
    return data / "meshes" / f"{name}.ply"


def _load(name: str, data: Path) -> Shape:
    if name == "sphere":
        mesh = trimesh.creation.icosphere(subdivisions=4)
    elif name == "torus":
        mesh = trimesh.creation.torus(1.0, 0.4, major_sections=96, minor_sections=48)
    else:
        mesh = trimesh.load_mesh(_path(data, name), process=False)
    vertices = np.asarray(mesh.vertices, dtype=np.float64)
    center, radius = unit_sphere(vertices)
    return Shape(name, (vertices - center) / radius, np.asarray(mesh.faces, dtype=np.int64))
