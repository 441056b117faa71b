"""Areas bounded by straight lines, and which points are in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pcsmooth.errors import CloudFileError

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    Ring = npt.NDArray[np.float64]

#: A point is on the boundary if it is nearer than this share of the largest coordinate: a few
#: roundings, as the decimals of a point on a slanting line are no binary numbers.
_ROUNDING = 2.0**-50

#: Positions of a ring at least, the first one again at the end.
_LEAST = 4


@dataclass(frozen=True, eq=False)
class Polygon:
    """The union of areas, each within a ring and without the rings of its holes.

    Attributes
    ----------
    path : str
        The file that it comes from, for messages.
    areas : tuple of tuple of ndarray, shape (n, 2)
        Rings of each area, their last position the first one again; the holes' behind the outer
        one. What is within an odd number of them belongs to it, and so do the rings.
    """

    path: str
    areas: tuple[tuple[Ring, ...], ...]

    @property
    def extent(self) -> npt.NDArray[np.float64] | None:
        """Least and largest coordinates, (2, 2); None if it is empty."""
        import numpy as np

        if not self.areas:
            return None
        corners = np.concatenate([ring for rings in self.areas for ring in rings])
        return np.stack([corners.min(axis=0), corners.max(axis=0)])

    def contains(self, points: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        """Tell which points (n, 2) are in it or on its boundary, (n,); none with NaN is."""
        import numpy as np

        found = np.zeros(len(points), np.bool_)
        extent = self.extent
        if extent is None:
            return found
        width = _ROUNDING * float(np.abs(extent).max())
        near = _in_box(points, extent[0] - width, extent[1] + width)
        rows = near[np.argsort(points[near, 1])]
        ordered = points[rows]
        for rings in self.areas:
            low, high = rings[0].min(axis=0) - width, rings[0].max(axis=0) + width
            first = int(np.searchsorted(ordered[:, 1], low[1], "left"))
            stop = int(np.searchsorted(ordered[:, 1], high[1], "right"))
            inside = first + _in_box(ordered[first:stop], low, high)
            chosen = _within(rings, ordered[inside], width)
            found[rows[inside[chosen]]] = True
        return found


def _in_box(
    points: npt.NDArray[np.float64], low: npt.NDArray[np.float64], high: npt.NDArray[np.float64]
) -> npt.NDArray[np.int64]:
    """List the points (n, 2) that are in a box."""
    import numpy as np

    x, y = points.T
    return np.flatnonzero((x >= low[0]) & (x <= high[0]) & (y >= low[1]) & (y <= high[1]))


def _within(
    rings: Sequence[Ring], points: npt.NDArray[np.float64], width: float
) -> npt.NDArray[np.bool_]:
    """Tell which points (n, 2), by increasing y, are within an odd number of rings, or on one.

    Each side looks only at the points beside it: a line from a point to the right meets it or not.
    """
    import numpy as np

    x, y = np.ascontiguousarray(points.T)
    is_odd = np.zeros(len(points), np.bool_)
    is_on = np.zeros(len(points), np.bool_)
    for ring in rings:
        starts, ends = ring[:-1], ring[1:]
        lows, highs = np.minimum(starts, ends), np.maximum(starts, ends)
        firsts = np.searchsorted(y, lows[:, 1] - width, "left").tolist()
        stops = np.searchsorted(y, highs[:, 1] + width, "right").tolist()
        lengths = np.hypot(*(ends - starts).T).tolist()
        sides = zip(
            starts.tolist(), ends.tolist(), lows[:, 0].tolist(), highs[:, 0].tolist(), lengths,
            firsts, stops, strict=True,
        )  # fmt: skip
        for (x1, y1), (x2, y2), low, high, length, first, stop in sides:
            if first == stop:
                continue
            across, along = x[first:stop], y[first:stop]
            # twice the area of the triangle: its sign tells the side of the point
            area = (across - x1) * (y2 - y1) - (along - y1) * (x2 - x1)
            crosses = (along < y1) != (along < y2)
            is_odd[first:stop] ^= crosses & ((area < 0.0) if y2 > y1 else (area > 0.0))
            is_near = np.abs(area) <= width * length
            if is_near.any():
                is_on[first:stop] |= is_near & (across >= low - width) & (across <= high + width)
    return is_odd | is_on


def checked_ring(path: str, positions: Sequence[tuple[float, float]], place: str) -> Ring:
    """Make a ring of its positions.

    Parameters
    ----------
    path : str
        The file.
    positions : sequence of (float, float)
        As they came.
    place : str
        Which ring, for messages.

    Raises
    ------
    CloudFileError
        If it has fewer than four, a coordinate is not finite or beyond 1e150, or the last one is
        not the first one.
    """
    import numpy as np

    from pcsmooth.positions import usable_rows

    if len(positions) < _LEAST:
        raise CloudFileError(
            path,
            f"{place} has {len(positions)} positions",
            "a ring has four at least, the first one again at the end",
        )
    ring = np.array(positions, np.float64)
    if not usable_rows(ring).all():
        raise CloudFileError(
            path,
            f"{place} has a coordinate that is not finite or too large",
            "correct it, or export the polygon again",
        )
    if (ring[0] != ring[-1]).any():
        raise CloudFileError(
            path,
            f"{place} is not closed: it ends elsewhere than it begins",
            "write its first position again at its end",
        )
    return ring
