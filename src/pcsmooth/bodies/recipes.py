"""What a table of a preset file says, made into a body."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from inspect import Parameter, signature
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from pcsmooth.bodies.convex_body import ConvexBody
from pcsmooth.bodies.generators import GENERATORS
from pcsmooth.bodies.suggestions import suggestion
from pcsmooth.errors import CloudFileError, InvalidInputError

#: What a body can be made of, and the keys that go with each.
_SOURCES: dict[str, set[str]] = {
    "normals": {"offsets"},
    "vertices": {"center"},
    "mesh": {"center"},
    "generator": set(),
    "base": set(),
}

#: Keys that any table may have.
_COMMON = {"description", "scale", "rotate"}

#: Meshes are often in single precision.
_MESH_TOLERANCE = 1e-6


def body_of(
    table: Mapping[str, Any],
    folder: Path,
    body_named: Callable[[str], ConvexBody],
    allow_outside: bool = False,
) -> ConvexBody:
    """Make the body that a table describes: its source, then scaled, then turned.

    Parameters
    ----------
    table : mapping
        A table of a preset file.
    folder : Path
        Where the names of meshes start.
    body_named : callable
        Gives the body of another preset.
    allow_outside : bool
        Whether meshes may lie outside of the folder.

    Raises
    ------
    InvalidInputError
        If a key is unknown or missing, a value is of the wrong type, the mesh cannot be read or
        lies outside, or there is no such body.
    """
    body = _source(table, folder, body_named, allow_outside)
    if "scale" in table:
        body = body.scaled(table["scale"])
    if "rotate" in table:
        body = body.rotated(_turn(table["rotate"], body.dimension))
    return body


def _source(
    table: Mapping[str, Any],
    folder: Path,
    body_named: Callable[[str], ConvexBody],
    allow_outside: bool,
) -> ConvexBody:
    found = [key for key in table if key in _SOURCES]
    if len(found) != 1:
        if not found:
            _check_keys(table, set(_SOURCES).union(_COMMON, *_SOURCES.values()))
        said = " and ".join(found) or "nothing"
        raise InvalidInputError(f"it is made of {said}; give exactly one of {', '.join(_SOURCES)}")
    (source,) = found
    _check_type(table, "description", str)
    _check_type(table, "center", bool)
    if source in ("mesh", "generator", "base"):
        _check_type(table, source, str)
    if "\0" in table.get("mesh", ""):
        raise InvalidInputError(f"mesh {table['mesh']!r} is no name of a file; correct it")
    if source == "generator":
        return _generated(table)
    _check_keys(table, {source} | _SOURCES[source] | _COMMON)
    if source == "base":
        return body_named(table["base"])
    if source == "normals":
        return ConvexBody(table["normals"], table.get("offsets", 1.0))
    center = table.get("center", False)
    if source == "vertices":
        return ConvexBody.from_vertices(table["vertices"], center=center)

    from pcsmooth.bodies.mesh_files import read_mesh_vertices

    path = folder / table["mesh"]
    if not (allow_outside or _lies_in(folder, path)):
        raise InvalidInputError(
            f"mesh {table['mesh']!r} lies outside of the folder of this file; pass --allow-outside "
            "if you trust it"
        )
    try:
        points = read_mesh_vertices(str(path))
    except CloudFileError as error:
        raise InvalidInputError(f"mesh {error}") from error
    return ConvexBody.from_vertices(points, center=center, tolerance=_MESH_TOLERANCE)


def _lies_in(folder: Path, path: Path) -> bool:
    """Whether a file lies in a folder, wherever links lead."""
    return Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder))


def _generated(table: Mapping[str, Any]) -> ConvexBody:
    name = table["generator"]
    if name not in GENERATORS:
        raise InvalidInputError(f"there is no generator {name!r}; {suggestion(name, GENERATORS)}")
    parameters = signature(GENERATORS[name]).parameters
    _check_keys(table, {"generator", *parameters} | _COMMON)
    for key, parameter in parameters.items():
        if key not in table and parameter.default is Parameter.empty:
            raise InvalidInputError(f"generator {name!r} lacks {key}; add it")
    return GENERATORS[name](**{key: table[key] for key in parameters if key in table})


def _check_keys(table: Mapping[str, Any], known: set[str]) -> None:
    for key in table:
        if key not in known:
            raise InvalidInputError(f"there is no key {key!r}; {suggestion(key, known)}")


def _check_type(table: Mapping[str, Any], key: str, kind: type) -> None:
    if not isinstance(table.get(key, kind()), kind):
        words = {str: "a text in quotes", bool: "true or false"}[kind]
        raise InvalidInputError(f"{key} is {table[key]!r}; it must be {words}")


def _turn(rotate: Any, dimension: int) -> npt.NDArray[np.float64]:
    """Matrix (d, d) of a rotation: degrees in 2D, an axis and degrees in 3D."""
    axis, degrees = np.zeros(3), math.nan
    match dimension, rotate:
        case 2, int() | float():
            axis, degrees = np.array([0.0, 0.0, 1.0]), rotate
        case 3, {"axis": [_, _, _] as given, "degrees": int() | float() as angle, **others}:
            if not others and all(isinstance(entry, (int, float)) for entry in given):
                axis, degrees = np.array(given, np.float64), angle
    length = np.linalg.norm(axis)
    if not (0.0 < length < math.inf and math.isfinite(degrees)):
        form = "a number of degrees" if dimension == 2 else "{ axis = [0, 0, 1], degrees = 45 }"
        raise InvalidInputError(f"rotate is {rotate!r}; in {dimension}D write {form}")
    matrix = Rotation.from_rotvec(math.radians(degrees) / length * axis).as_matrix()
    return np.asarray(matrix[:dimension, :dimension])
