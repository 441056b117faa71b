"""Polygons of well-known text (OGC 06-103r4), such as `POLYGON ((0 0, 1 0, 1 1, 0 0))`."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING, NoReturn

from pcsmooth.errors import CloudFileError
from pcsmooth.files.polygon import checked_ring
from pcsmooth.formats.excerpt import excerpt

if TYPE_CHECKING:
    from pcsmooth.files.polygon import Ring

_TOKEN = re.compile(
    r"\s*(?:(?P<word>[A-Za-z]+)|(?P<mark>[(),])|"
    r"(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?))"
)

#: What other programs put in front.
_REFERENCE = re.compile(r"SRID=\d+;", re.IGNORECASE)

_POLYGONS, _COLLECTION = ("POLYGON", "MULTIPOLYGON"), "GEOMETRYCOLLECTION"

#: Geometries without, or not only with, straight sides around an inside.
_OTHERS = (
    "POINT", "LINESTRING", "MULTIPOINT", "MULTILINESTRING", "CIRCULARSTRING", "COMPOUNDCURVE",
    "CURVEPOLYGON", "MULTICURVE", "MULTISURFACE", "TRIANGLE", "TIN", "POLYHEDRALSURFACE",
)  # fmt: skip

#: Collections in collections at most.
_DEEPEST = 50


def areas_of_wkt(path: str, text: str) -> tuple[tuple[Ring, ...], ...]:
    """Read the rings of each polygon.

    Parameters
    ----------
    path : str
        The file, for messages.
    text : str
        What is in it: one geometry.

    Raises
    ------
    CloudFileError
        It is no WKT, or holds another geometry than polygons.
    """
    reading = _Reading(path, text)
    reading.geometry(1)
    reading.end()
    return tuple(reading.areas)


class _Reading:
    """What has been read of a text."""

    def __init__(self, path: str, text: str) -> None:
        self.path, self.text = path, text
        reference = _REFERENCE.match(text)
        self.at = 0 if reference is None else reference.end()
        self.areas: list[tuple[Ring, ...]] = []
        self.polygons = 0
        self._step()

    def geometry(self, depth: int) -> None:
        """Read a geometry."""
        kind = self._word()
        for suffix in ("ZM", "Z", "M"):
            if kind.removesuffix(suffix) in (*_POLYGONS, _COLLECTION):
                kind = kind.removesuffix(suffix)
                break
        if kind not in (*_POLYGONS, _COLLECTION):
            if kind in _OTHERS:
                raise CloudFileError(
                    self.path, f"holds a {kind}, which is no polygon", "leave only polygons in it"
                )
            self._refuse("a polygon")
        self._take()
        if self._word() in ("Z", "M", "ZM"):
            self._take()
        if self._is_empty():
            return
        if depth > _DEEPEST:
            raise CloudFileError(
                self.path, "its collections are nested too deeply", "export it again as GeoJSON"
            )
        if kind == "POLYGON":
            self._polygon()
        else:
            self._list(
                self._polygon if kind == "MULTIPOLYGON" else lambda: self.geometry(depth + 1)
            )

    def end(self) -> None:
        """Refuse what comes behind."""
        if self.token:
            self._refuse("the end")

    def _polygon(self) -> None:
        self.polygons += 1
        if self._is_empty():
            return
        rings: list[Ring] = []

        def ring() -> None:
            positions: list[tuple[float, float]] = []
            self._list(lambda: positions.append(self._position()))
            place = f"ring {len(rings) + 1} of polygon {self.polygons}"
            rings.append(checked_ring(self.path, positions, place))

        self._list(ring)
        self.areas.append(tuple(rings))

    def _position(self) -> tuple[float, float]:
        found = []
        while self.kind == "number":
            found.append(float(self._take()))
        if not 2 <= len(found) <= 4:
            self._refuse("two to four numbers of a position")
        return found[0], found[1]

    def _list(self, part: Callable[[], None]) -> None:
        """Read parts in parentheses, between commas."""
        self._mark("(")
        part()
        while self.token == ",":
            self._take()
            part()
        self._mark(")")

    def _mark(self, mark: str) -> None:
        if self.token != mark:
            self._refuse(f"'{mark}'")
        self._take()

    def _word(self) -> str:
        return self.token.upper() if self.kind == "word" else ""

    def _is_empty(self) -> bool:
        if self._word() != "EMPTY":
            return False
        self._take()
        return True

    def _take(self) -> str:
        token = self.token
        self._step()
        return token

    def _step(self) -> None:
        """Go to the next token, at the end to an empty one."""
        found = _TOKEN.match(self.text, self.at)
        if found is None:
            rest = self.text[self.at :].split(maxsplit=1)
            self.token, self.kind = (rest[0], "other") if rest else ("", "")
            return
        self.at = found.end()
        self.kind = str(found.lastgroup)
        self.token = found[self.kind]

    def _refuse(self, wanted: str) -> NoReturn:
        here = f"'{excerpt(self.token)}'" if self.token else "its end"
        raise CloudFileError(
            self.path,
            f"is neither GeoJSON nor WKT: there is {here} in place of {wanted}",
            "get the whole file, or export the polygon again",
        )
