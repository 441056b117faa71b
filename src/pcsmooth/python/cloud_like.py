"""Clouds as Python callers have them: arrays, and the objects of this and other libraries."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import InvalidInputError
from pcsmooth.positions import as_positions


@runtime_checkable
class HasPoints(Protocol):
    """What has points, as the clouds of Open3D and the meshes of PyVista and meshio."""

    @property
    def points(self) -> Any: ...  # noqa: D102


@runtime_checkable
class HasVertices(Protocol):
    """What has vertices, as the clouds and meshes of trimesh."""

    @property
    def vertices(self) -> Any: ...  # noqa: D102


@runtime_checkable
class HasPointAttributes(Protocol):
    """What has attributes by name, as the tensor clouds of Open3D."""

    @property
    def point(self) -> Any: ...  # noqa: D102


CloudLike = npt.ArrayLike | PointCloud | HasPoints | HasVertices | HasPointAttributes
"""Positions, or what has them."""


def cloud_of(given: CloudLike) -> PointCloud:
    """Take a cloud as it is given.

    Parameters
    ----------
    given : array_like, PointCloud or another library's cloud
        Positions (n, 2) or (n, 3); or an object that has them as ``points`` (Open3D, PyVista,
        meshio), as ``vertices`` (trimesh), or as ``point["positions"]`` (tensors of Open3D). Of
        other libraries' clouds nothing but the positions is taken.

    Returns
    -------
    PointCloud
        Positions in a new array, masked coordinates NaN; columns and the rest as they were.

    Raises
    ------
    InvalidInputError
        It is the name of a file, or has no positions of two or three real coordinates.
    """
    if isinstance(given, str | bytes | os.PathLike):
        raise InvalidInputError(
            f"points are {given!r}, a name; give read_cloud({given!r}), or have denoise_file read "
            "and write files"
        )
    if isinstance(given, PointCloud):
        return given
    return PointCloud(as_positions(_positions(given)))


def _positions(given: Any) -> Any:
    if isinstance(given, np.ndarray):
        return given
    if isinstance(given, HasPointAttributes) and isinstance(given.point, Mapping):
        return _array(given.point["positions"])
    if isinstance(given, HasPoints):
        return _array(given.points)
    if isinstance(given, HasVertices):
        return _array(given.vertices)
    return given


def _array(values: Any) -> Any:
    """Take a tensor's array; others are arrays, or become some."""
    return values.numpy() if hasattr(values, "numpy") else np.asarray(values)
