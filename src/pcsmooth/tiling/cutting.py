"""A cloud of any size, read in pieces, cut into tiles on disk."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import NoFinitePointError
from pcsmooth.point_order import order_by_position
from pcsmooth.positions import local_origin, usable_rows
from pcsmooth.progress import Callback, Progress, ignore
from pcsmooth.tiling.column_store import FileColumn
from pcsmooth.tiling.cube_width import choose_width
from pcsmooth.tiling.cubes import cube_codes
from pcsmooth.tiling.disk_sort import sort_on_disk
from pcsmooth.tiling.partition import partition_of
from pcsmooth.tiling.tile_store import TileStore
from pcsmooth.unit_of_length import unit_near

_STAGE = "cutting into tiles"

#: Points that show how dense the cloud is.
_SAMPLES = 1_000_000

#: Cubes that the points of a tile fill at least.
_CUBES_OF_TILE = 64


@dataclass(frozen=True, eq=False)
class Piece:
    """Consecutive rows of a cloud.

    Attributes
    ----------
    points : ndarray, shape (m, d)
        Positions, L.
    fixed : ndarray of bool, shape (m,), optional
        Which of them are fixed.
    normals : ndarray, shape (m, d), optional
        Normals they came with; zero where there is none.
    """

    points: npt.NDArray[np.float64]
    fixed: npt.NDArray[np.bool_] | None = None
    normals: npt.NDArray[np.float64] | None = None


@dataclass(frozen=True)
class Source:
    """A cloud that can be read in pieces, again and again.

    Attributes
    ----------
    count : int
        Rows.
    dimension : int
        d.
    has_normals : bool
        Whether it comes with normals that are to be looked at.
    positions : callable
        Gives the positions, piece by piece.
    pieces : callable
        Gives them with the marks of fixed points and the normals.
    """

    count: int
    dimension: int
    has_normals: bool
    positions: Callable[[], Iterable[npt.NDArray[np.float64]]]
    pieces: Callable[[], Iterable[Piece]]


def cut_cloud(
    source: Source, folder: Path, tile_points: int, callback: Callback = ignore
) -> TileStore:
    """Sort the finite points of a cloud into tiles.

    Parameters
    ----------
    source : Source
        The cloud; it is read three times.
    folder : Path
        Gets the columns: about 30 to 40 bytes a point.
    tile_points : int
        Most points of a tile.
    callback : callable
        Told how many of the three passes are done.

    Returns
    -------
    TileStore
        With the columns `numbers`, `start` and `fixed`. Its rows are in the order in which points
        are taken (see `order_by_position`).

    Raises
    ------
    NoFinitePointError
        There is no point with finite coordinates.
    InvalidInputError
        The cloud is too large or small to be measured.
    CloudFileError
        The cloud cannot be read, or a column not be written.
    """
    callback(Progress(_STAGE, 0, 3))
    count, box, sample = _survey(source)
    callback(Progress(_STAGE, 1, 3))
    origin = local_origin(box)
    box = box - origin
    width = choose_width(
        sample - origin, count, box[0], float(np.ptp(box, axis=0).max()),
        max(1, tile_points // _CUBES_OF_TILE),
    )  # fmt: skip
    codes, counts = _count_cubes(source, origin, box[0], width)
    callback(Progress(_STAGE, 2, 3))
    unit = unit_near(width)
    box, width = box / unit, width / unit
    partition = partition_of(codes, counts, box[0], width, tile_points)
    cloud = TileStore(folder, partition, origin, unit, box, source.has_normals)
    columns = {"number": cloud.numbers, "point": cloud.start, "fixed": cloud.fixed}
    if source.has_normals:
        columns["normal"] = cloud.given
    row_type = np.dtype([(name, *_field(column.dtype)) for name, column in columns.items()])
    rows = cloud.create("rows", row_type)
    sort_on_disk(lambda: _rows(source, cloud, row_type), partition.codes, partition.starts, rows)
    for column in columns.values():
        FileColumn.create(column.path, column.dtype, column.rows)
    for tile in range(partition.n_tiles):
        first, stop = partition.rows(tile)
        chunk = rows.read(first, stop)
        normals = chunk["normal"] if source.has_normals else None
        order = order_by_position(chunk["point"], normals, box)
        for name, column in columns.items():
            column.write(first, chunk[name][order])
    cloud.drop("rows")
    callback(Progress(_STAGE, 3, 3))
    return cloud


def _field(dtype: np.dtype[Any]) -> tuple[Any, tuple[int, ...]]:
    return dtype.base, dtype.shape


def _finite(points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    usable = usable_rows(points)
    return points if usable.all() else points[usable]


def _survey(
    source: Source,
) -> tuple[int, npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Count the finite points, find their bounding box (2, d), and take a sample of them."""
    low = np.full(source.dimension, np.inf)
    high = np.full(source.dimension, -np.inf)
    step = -(-source.count // _SAMPLES) or 1
    count, read = 0, 0
    sample = []
    for points in source.positions():
        finite = _finite(points)
        count += len(finite)
        if len(finite):
            low = np.minimum(low, finite.min(axis=0))
            high = np.maximum(high, finite.max(axis=0))
        sample.append(_finite(points[-read % step :: step]))
        read += len(points)
    if count == 0:
        raise NoFinitePointError
    chosen = np.concatenate(sample)
    return count, np.stack([low, high]), chosen if len(chosen) else low[np.newaxis]


def _count_cubes(
    source: Source,
    origin: npt.NDArray[np.float64],
    corner: npt.NDArray[np.float64],
    width: float,
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Find the occupied cubes and how many points are in each."""
    codes, counts = np.empty(0, np.int64), np.empty(0, np.int64)
    for points in source.positions():
        more, numbers = np.unique(
            cube_codes(_finite(points) - origin, corner, width), return_counts=True
        )
        codes, places = np.unique(np.concatenate([codes, more]), return_inverse=True)
        sums = np.bincount(places, np.concatenate([counts, numbers]), len(codes))
        counts = sums.astype(np.int64)
    return codes, counts


def _rows(
    source: Source, cloud: TileStore, row_type: np.dtype[Any]
) -> Iterator[tuple[npt.NDArray[np.int64], npt.NDArray[Any]]]:
    """Give the rows of the column of starts in the order of the input, with their cubes."""
    number = 0
    for piece in source.pieces():
        usable = usable_rows(piece.points)
        rows = np.empty(np.count_nonzero(usable), row_type)
        rows["number"] = np.arange(number, number + len(rows))
        rows["point"] = (piece.points[usable] - cloud.origin) / cloud.unit
        rows["fixed"] = False if piece.fixed is None else piece.fixed[usable]
        if piece.normals is not None:
            rows["normal"] = piece.normals[usable]
        number += len(rows)
        yield cube_codes(rows["point"], cloud.partition.corner, cloud.partition.width), rows
