"""Bodies from and to mesh files."""

from __future__ import annotations

from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import numpy as np
import numpy.typing as npt
import trimesh

from pcsmooth.bodies.convex_body import ConvexBody
from pcsmooth.bodies.small_files import read_small_file
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.atomic import atomic_write
from pcsmooth.formats.system_errors import named_system_errors

#: Formats of meshes, by the end of the file's name.
_SUFFIXES = (".ply", ".stl", ".obj", ".off")


def read_mesh_vertices(path: str) -> npt.NDArray[np.float64]:
    """Read the vertices (n, 3) of a mesh.

    Raises
    ------
    CloudFileError
        If the file cannot be read, is no mesh of a known format, or holds no triangles.
    """
    file_type = _file_type(path)
    data = read_small_file(path)
    try:
        mesh = trimesh.load_mesh(BytesIO(data), file_type=file_type)
    except Exception as error:  # each reader of trimesh has errors of its own
        raise CloudFileError(
            path, f"cannot be read as a mesh ({error})", "check the file"
        ) from error
    if len(mesh.vertices) == 0:
        raise CloudFileError(path, "holds no triangles", "give a mesh")
    return np.asarray(mesh.vertices, np.float64)


def write_mesh(
    body: ConvexBody,
    path: str,
    *,
    overwrite: bool = True,
    tell: Callable[[str], object] | None = None,
) -> None:
    """Write a body in 3D as a closed mesh of triangles that look outward.

    Parameters
    ----------
    body : ConvexBody
        What to write.
    path : str
        Where; the suffix says in which format.
    overwrite : bool
        Whether a file that is there, or comes to be there meanwhile, is replaced.
    tell : callable, optional
        Gets a phrase for each attribute of a replaced file that could not be kept.

    Raises
    ------
    CloudFileError
        If the suffix is not of a mesh, the body is in 2D, or the file cannot, or must not, be
        written.
    """
    file_type = _file_type(path)
    if body.dimension != 3:
        raise CloudFileError(path, "a body in 2D is no mesh", "choose a preset in 3D")
    mesh = trimesh.Trimesh(body.vertices, body.simplices, process=False)
    with (
        named_system_errors(path),
        atomic_write(path, overwrite=overwrite, tell=tell) as file,
    ):
        mesh.export(file, file_type=file_type)


def _file_type(path: str) -> str:
    suffix = Path(path).suffix.lower()
    if suffix not in _SUFFIXES:
        raise CloudFileError(
            path, f"its suffix {suffix!r} is of no mesh", f"use one of {' '.join(_SUFFIXES)}"
        )
    return suffix[1:]
