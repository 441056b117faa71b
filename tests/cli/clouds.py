"""Clouds for the tests of the command line, and files that hold them."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import plyfile

Points = npt.NDArray[np.float64]

DATA = Path(__file__).parents[2] / "data"

#: The columns that `curvature` adds to PLY, in order.
PLY_CURVATURES = [
    "nx",
    "ny",
    "nz",
    "quality",
    "scalar_mean_curvature",
    "curvature",
    "scalar_gaussian_curvature",
    "scalar_k1",
    "scalar_k2",
    "scalar_confidence",
]

#: The columns that `denoise` adds: flows, and the filter, its default.
PLY_FLOW_ESTIMATES = [*PLY_CURVATURES, "scalar_displacement"]
PLY_ESTIMATES = [*PLY_FLOW_ESTIMATES, "scalar_outlier"]

#: The columns that `curvature` adds to text with a header.
TEXT_CURVATURES = ["mean_curvature", "gaussian_curvature", "k1", "k2", "confidence"]

#: The encodings of PLY as plyfile takes them: text, byte order.
ENCODINGS = {"ascii": (True, "="), "little": (False, "<"), "big": (False, ">")}


def sphere(n: int = 150, noise: float = 0.02, seed: int = 1) -> Points:
    """Points spread evenly over the unit sphere, with noise, in no spatial order."""
    rng = np.random.default_rng(seed)
    height = 1.0 - (2.0 * rng.permutation(n) + 1.0) / n
    turn = np.pi * (1.0 + 5.0**0.5) * n * (1.0 - height) / 2.0
    ring = np.sqrt(1.0 - height**2)
    points = np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=1)
    return points + rng.normal(scale=noise, size=points.shape)


def circle(n: int = 60, noise: float = 0.02, seed: int = 1) -> Points:
    """Points in order around the unit circle, with noise."""
    rng = np.random.default_rng(seed)
    angle = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False)
    points = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return points + rng.normal(scale=noise, size=points.shape)


def brute_force_spacing(points: Points) -> float:
    """Mean distance to the 6 (in 2D: 2) nearest others; for clouds without outliers."""
    distances = np.linalg.norm(points[:, None] - points, axis=2)
    nearest = np.sort(distances, axis=1)[:, 1 : {2: 3, 3: 7}[points.shape[1]]]
    return float(nearest.mean())


def vertices(points: Points, code: str = "f4", **columns: npt.NDArray[Any]) -> plyfile.PlyElement:
    """Vertex element with x y (z) of the type and more columns after them."""
    types = [(name, code) for name in "xyz"[: points.shape[1]]]
    types += [(name, values.dtype.str[1:]) for name, values in columns.items()]
    table = np.empty(len(points), types)
    for name, values in zip("xyz", points.T, strict=False):
        table[name] = values
    for name, values in columns.items():
        table[name] = values
    return plyfile.PlyElement.describe(table, "vertex")


def save_ply(path: Path, *elements: plyfile.PlyElement, encoding: str = "little") -> Path:
    """Write elements as PLY."""
    text, byte_order = ENCODINGS[encoding]
    plyfile.PlyData(elements, text=text, byte_order=byte_order).write(str(path))
    return path


def save_text(path: Path, rows: Sequence[Sequence[object]] | Points, delimiter: str = " ") -> Path:
    """Write rows of numbers and words, all digits kept."""
    lines = (delimiter.join(word if isinstance(word, str) else repr(word) for word in row)
             for row in (rows.tolist() if isinstance(rows, np.ndarray) else rows))  # fmt: skip
    path.write_text("".join(line + "\n" for line in lines))
    return path


def load_ply(source: Path | bytes) -> plyfile.PlyData:
    """Read PLY by another reader than the project's, all at once."""
    data = source if isinstance(source, bytes) else source.read_bytes()
    return plyfile.PlyData.read(io.BytesIO(data), mmap=False)


def positions(source: Path | bytes) -> npt.NDArray[Any]:
    """x y z of a PLY file, (n, 3), in the type of the file."""
    vertex = load_ply(source)["vertex"]
    return np.stack([vertex[name] for name in "xyz"], axis=1)
