"""Which planes meet in the corners of a convex polytope, found by cutting; in 2D read lines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError

#: Half the side of the cube that polytopes are cut from, in largest offsets.
_START = 64.0

#: What corners may stick out of a plane, over the size of the polytope, before they are cut off.
_TOLERANCE = 1e-12


@dataclass(frozen=True)
class Polytope:
    """A bounded convex polytope in d = 2 or 3 dimensions.

    Where more than d planes meet there are several corners in one place, as if the planes had
    been moved a little.

    Attributes
    ----------
    planes : tuple of tuples of d int
        Numbers, increasing, of the planes that meet in each corner.
    corners : ndarray, shape (V, d)
        Where.
    """

    planes: tuple[tuple[int, ...], ...]
    corners: npt.NDArray[np.float64]

    @property
    def edges(self) -> dict[tuple[int, ...], tuple[int, int]]:
        """The two corners of each edge, by the d - 1 planes that meet along it.

        Raises
        ------
        InvalidInputError
            If rounding has spoiled the polytope.
        """
        ends: dict[tuple[int, ...], list[int]] = {}
        for corner, planes in enumerate(self.planes):
            for left_out in range(len(planes)):
                edge = planes[:left_out] + planes[left_out + 1 :]
                ends.setdefault(edge, []).append(corner)
        pairs = {edge: (found[0], found[-1]) for edge, found in ends.items() if len(found) == 2}
        if len(pairs) < len(ends):
            raise InvalidInputError(
                "a cell is too degenerate for automatic differentiation; move the points a little, "
                "or take analytic gradients"
            )
        return pairs

    def cut(self, number: int, normal: npt.NDArray[np.float64], offset: float) -> Polytope | None:
        """Keep the part with normal . x <= offset; None if that has no inside.

        Parameters
        ----------
        number : int
            Of the new plane; larger than those there are.
        normal : ndarray, shape (d,)
            Its unit normal.
        offset : float
            Its distance from the origin, L.
        """
        heights = self.corners @ normal - offset
        out = heights > _TOLERANCE * np.abs(self.corners).max()
        if not out.any():
            return self
        if out.all():
            return None
        planes = [self.planes[corner] for corner in np.flatnonzero(~out)]
        corners = [*self.corners[~out]]
        for edge, (first, second) in self.edges.items():
            if out[first] != out[second]:
                share = heights[first] / (heights[first] - heights[second])
                apart = self.corners[second] - self.corners[first]
                planes.append((*edge, number))
                corners.append(self.corners[first] + min(max(share, 0.0), 1.0) * apart)
        return Polytope(tuple(planes), np.array(corners))


def intersect_half_spaces(
    normals: npt.NDArray[np.float64], offsets: npt.NDArray[np.float64]
) -> Polytope | None:
    """Find the corners of {x : normals x <= offsets}.

    Parameters
    ----------
    normals : ndarray, shape (F, d)
        Unit normals that leave nothing unbounded.
    offsets : ndarray, shape (F,)
        Distances from the origin, L, of any sign.

    Returns
    -------
    Polytope or None
        Its planes are numbered like the rows. None if nothing or next to nothing is left.
    """
    dimension = normals.shape[1]
    size = _START * np.abs(offsets).max()
    signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * dimension)).reshape(dimension, -1).T
    faces = np.where(signs < 0, np.arange(dimension), dimension + np.arange(dimension))
    cell: Polytope | None = Polytope(
        tuple(tuple(sorted(int(face) - 2 * dimension for face in row)) for row in faces),
        size * signs,
    )
    for number, (normal, offset) in enumerate(zip(normals, offsets, strict=True)):
        if cell is None:
            return None
        cell = cell.cut(number, normal, float(offset))
    return cell
