"""A cloud cut into tiles: runs of rows in the order of cubes along a Morton curve."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.tiling.cubes import CELLS_PER_AXIS, MARGIN, cells_within, cube_cells
from pcsmooth.tiling.runs import join_runs


@dataclass(frozen=True, eq=False)
class Partition:
    """Tiles of consecutive cubes; rows are sorted by the codes of their cubes.

    Attributes
    ----------
    corner : ndarray, shape (d,)
        Corner of cube 0, L.
    width : float
        Side of a cube, L.
    codes : ndarray of int, shape (m,)
        Morton codes of the occupied cubes, increasing.
    starts : ndarray of int, shape (m + 1,)
        Row at which each cube begins, and the number of all rows.
    tile_starts : ndarray of int, shape (t + 1,)
        Cube, by its place in `codes`, at which each tile begins, and m.
    """

    corner: npt.NDArray[np.float64]
    width: float
    codes: npt.NDArray[np.int64]
    starts: npt.NDArray[np.int64]
    tile_starts: npt.NDArray[np.int64]

    @property
    def n_tiles(self) -> int:
        """Number of tiles."""
        return len(self.tile_starts) - 1

    def rows(self, tile: int) -> tuple[int, int]:
        """First row of a tile and the row after its last.

        Raises
        ------
        IndexError
            There is no such tile.
        """
        first, stop = self._cubes(tile)
        return int(self.starts[first]), int(self.starts[stop])

    def halo(self, tile: int, distance: float) -> npt.NDArray[np.int64]:
        """Rows of the other tiles' cubes that come near one of the tile's cubes.

        All points within `distance` of a point of the tile, along every axis, are in the tile or
        in its halo. That holds at the ends of the range of cubes too, whose outer cubes go on
        without end: clamping never moves the numbers of two cubes apart, and two outer cubes that
        adjoin touch however far out.

        Parameters
        ----------
        tile : int
            0 <= tile < n_tiles.
        distance : float
            Largest distance between two cubes along every axis, L, >= 0. A millionth of a cube is
            added, so that rounding never loses a point.

        Returns
        -------
        ndarray of int, shape (k, 2)
            Runs of rows, increasing, that do not adjoin.

        Raises
        ------
        IndexError
            There is no such tile.
        InvalidInputError
            The distance is negative or NaN.
        """
        first, stop = self._cubes(tile)
        near = self._near(tile, distance)
        near[first:stop] = False
        cubes = np.flatnonzero(near)
        return join_runs(np.stack([self.starts[cubes], self.starts[cubes + 1]], axis=1))

    def largest_near(
        self, tile: int, distance: float, values: npt.NDArray[np.float64]
    ) -> np.float64:
        """Find the largest value of the cubes that are the tile's own or in its halo.

        Parameters
        ----------
        tile, distance
            As in `halo`.
        values : ndarray, shape (m,)
            A value for each cube.
        """
        return np.float64(values[self._near(tile, distance)].max())

    def _near(self, tile: int, distance: float) -> npt.NDArray[np.bool_]:
        """Tell which cubes come near the tile's, (m,); its own do."""
        first, stop = self._cubes(tile)
        if not distance >= 0.0:
            raise InvalidInputError(f"halo of {distance} is not a length")
        # Between cubes whose numbers differ by k lie k - 1 cubes.
        reach = 1 + math.floor(min(distance / self.width + MARGIN, CELLS_PER_AXIS))
        cells = cube_cells(self.codes, len(self.corner))
        return cells_within(cells, cells[first:stop], reach)

    def _cubes(self, tile: int) -> tuple[int, int]:
        if not 0 <= tile < self.n_tiles:
            raise IndexError(f"no tile {tile} among {self.n_tiles}")
        return int(self.tile_starts[tile]), int(self.tile_starts[tile + 1])


def partition_of(
    codes: npt.NDArray[np.int64],
    counts: npt.NDArray[np.int64],
    corner: npt.NDArray[np.float64],
    width: float,
    tile_points: int,
) -> Partition:
    """Gather consecutive cubes to tiles.

    Parameters
    ----------
    codes : ndarray of int, shape (m,)
        Morton codes of cubes, increasing.
    counts : ndarray of int, shape (m,)
        Points of each cube; those without any are left out.
    corner : ndarray, shape (d,)
        Corner of cube 0, L.
    width : float
        Side of a cube, L, > 0.
    tile_points : int
        Most points of a tile, >= 1. Only a cube that holds more by itself makes a larger one.

    Returns
    -------
    Partition
        No tile is empty.

    Raises
    ------
    InvalidInputError
        Codes that do not increase, a negative count, a width or a tile without size.
    """
    if not (len(codes) == len(counts) and np.all(codes[1:] > codes[:-1]) and np.all(counts >= 0)):
        raise InvalidInputError("cubes need increasing codes and as many counts of points")
    if not (0.0 < width < math.inf and tile_points >= 1):
        raise InvalidInputError(f"no tiles of {tile_points} points in cubes of width {width}")
    occupied = counts > 0
    starts = np.concatenate([[0], np.cumsum(counts[occupied], dtype=np.int64)])
    tile_starts = [0]
    while tile_starts[-1] < len(starts) - 1:
        first = tile_starts[-1]
        stop = int(np.searchsorted(starts, starts[first] + tile_points, side="right")) - 1
        tile_starts.append(max(stop, first + 1))
    return Partition(corner, width, codes[occupied], starts, np.array(tile_starts, np.int64))
