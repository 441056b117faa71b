"""Polygons of GeoJSON (RFC 7946), whatever their coordinates are of."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NoReturn

from pcsmooth.errors import CloudFileError
from pcsmooth.files.polygon import checked_ring
from pcsmooth.formats.excerpt import excerpt

if TYPE_CHECKING:
    from pcsmooth.files.polygon import Ring

_AGAIN = "export it again as GeoJSON"

#: Where the parts of what has parts are.
_PARTS = {"FeatureCollection": "features", "GeometryCollection": "geometries"}


def areas_of_geojson(path: str, text: str) -> tuple[tuple[Ring, ...], ...]:
    """Read the rings of each polygon.

    Parameters
    ----------
    path : str
        The file, for messages.
    text : str
        What is in it.

    Raises
    ------
    CloudFileError
        It is no GeoJSON, or holds another geometry than polygons.
    """
    try:
        whole = json.loads(text)
    except RecursionError:
        raise CloudFileError(path, "its GeoJSON is nested too deeply", _AGAIN) from None
    except ValueError as error:  # among them numbers of too many digits
        cause = f"is no JSON: {excerpt(str(error))}"
        raise CloudFileError(path, cause, "get the whole file, or export it again") from None
    areas = []
    for number, rings in enumerate(_polygons(path, whole), 1):
        if not isinstance(rings, list):
            _refuse(path, f"polygon {number} has no list of rings")
        if rings:
            areas.append(
                tuple(
                    checked_ring(path, _positions(path, ring, place), place)
                    for rank, ring in enumerate(rings, 1)
                    for place in [f"ring {rank} of polygon {number}"]
                )
            )
    return tuple(areas)


def _polygons(path: str, whole: Any) -> Iterator[Any]:
    """Give the coordinates of each polygon, in the order of the file."""
    waiting = [whole]
    while waiting:
        thing = waiting.pop()
        if thing is None:  # a feature may be nowhere
            continue
        kind = thing.get("type") if isinstance(thing, dict) else None
        if kind == "Feature":
            waiting.append(thing.get("geometry"))
        elif kind == "Polygon":
            yield thing.get("coordinates")
        elif kind in ("MultiPolygon", *_PARTS):
            parts = thing.get(_PARTS.get(kind, "coordinates"))
            if not isinstance(parts, list):
                _refuse(path, f"a {kind} has no list of its parts")
            if kind == "MultiPolygon":
                yield from parts
            else:
                waiting.extend(reversed(parts))
        elif isinstance(kind, str):
            raise CloudFileError(
                path, f"holds a {excerpt(kind)}, which is no polygon", "leave only polygons in it"
            )
        else:
            _refuse(path, "holds something that is no GeoJSON object")


def _positions(path: str, ring: Any, place: str) -> list[tuple[float, float]]:
    if not isinstance(ring, list):
        _refuse(path, f"{place} is no list of positions")
    found = []
    for position in ring:
        if not (
            isinstance(position, list)
            and len(position) > 1
            and all(type(value) in (int, float) for value in position[:2])
        ):
            _refuse(path, f"{place} has a position that is not two numbers")
        try:
            found.append((float(position[0]), float(position[1])))
        except OverflowError:
            found.append((float("inf"), 0.0))
    return found


def _refuse(path: str, cause: str) -> NoReturn:
    raise CloudFileError(path, cause, _AGAIN)
