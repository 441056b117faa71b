"""Denoise a cloud of any size: cut into tiles on disk, moved step by step, put in order again."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Unpack

import numpy as np

from pcsmooth.cloud import PointCloud
from pcsmooth.denoise_result import DenoiseResult
from pcsmooth.denoising import Denoised, denoise_parts
from pcsmooth.errors import InvalidInputError
from pcsmooth.estimating import given_normals
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.methods.estimate import Estimate
from pcsmooth.methods.keywords import Keywords, resolve_keywords
from pcsmooth.methods.method import Method
from pcsmooth.methods.motion import Direction, Motion
from pcsmooth.positions import usable_rows
from pcsmooth.progress import Callback, ignore
from pcsmooth.tiling.column_store import FileColumn
from pcsmooth.tiling.cutting import Source, cut_cloud
from pcsmooth.tiling.input_order import in_input_order
from pcsmooth.tiling.runner import Runner
from pcsmooth.tiling.tile_store import TileStore
from pcsmooth.tiling.tiled_cloud import TiledCloud


@dataclass(frozen=True, eq=False)
class TiledResult:
    """A denoised cloud on disk.

    Attributes
    ----------
    store : TileStore
        The tiles.
    denoised : Denoised
        What holds for the whole cloud.
    ordered : FileColumn
        What there is of each finite point, in the order of the input.
    """

    store: TileStore
    denoised: Denoised
    ordered: FileColumn

    @property
    def overall(self) -> DenoiseResult:
        """What holds for the whole cloud, without any points."""
        nowhere = np.empty((0, self.store.dimension))
        none = np.empty(0, np.int64)
        return self.denoised.result(nowhere, none != 0, none, self.ordered.read(0, 0))

    def parts(self, pieces: Iterable[PointCloud]) -> Iterator[tuple[PointCloud, DenoiseResult]]:
        """Give the result of the input piece by piece.

        Parameters
        ----------
        pieces : iterable of PointCloud
            All of the input, in its order; rows marked as noise are those that took no part.

        Yields
        ------
        piece : PointCloud
            As it came.
        result : DenoiseResult
            Of its rows.
        """
        start = 0
        for piece in pieces:
            finite = usable_rows(piece.active_points)
            stop = start + int(np.count_nonzero(finite))
            rows = self.ordered.read(start, stop)
            yield piece, self.denoised.result(piece.points, finite, np.flatnonzero(finite), rows)
            start = stop


def denoise_in_tiles(
    source: Source,
    folder: Path,
    tile_points: int,
    runner: Runner,
    method: Method | None = None,
    *,
    motion: Motion | Direction = "free",
    estimate: Estimate | None = None,
    threads: int | None = None,
    callback: Callback = ignore,
    **keywords: Unpack[Keywords],
) -> TiledResult:
    """Denoise a cloud that need not fit into memory.

    Parameters
    ----------
    source : Source
        The cloud.
    folder : Path
        An empty folder on a disk that all workers see. It takes up to 400 bytes a point, and
        holds the result.
    tile_points : int
        Most points of a tile; memory goes with it, not with the cloud.
    runner : Runner
        Does the work on the tiles.
    method, motion, estimate, threads, **keywords
        As `denoise` takes them; what needs the whole cloud, `Method.whole_cloud_for` tells.
    callback : callable
        Told how far each stage is, and the record of each state.

    Returns
    -------
    TiledResult
        The same as that of `denoise`, to the last bit. But implicit steps solve one system of
        equations for each tile and what is around it, to the same tolerance: both are within
        that, 1e-3 of the displacement (root of the mean square, weighted by the masses), of the
        exact solution; what is left out of the systems is less than 1e-6 of it.

    Raises
    ------
    InvalidInputError
        Option values, no finite point, no normals where they are to be followed, a radius that
        cannot be derived, an implicit step that cannot be solved, or a cloud wider than some
        hundred thousand radii.
    CloudFileError
        The folder is full.
    """
    method, motion, estimate = resolve_keywords(method, motion, estimate, keywords)
    if method.whole_cloud_for:
        raise InvalidInputError(f"{method.whole_cloud_for} cannot be done in tiles; pass tile off")
    if not source.has_normals:
        given_normals(None, (source.count, source.dimension), estimate.orientation)
    with thread_limit(threads):
        store = cut_cloud(source, folder, tile_points, callback)
        cloud = TiledCloud(store, runner, callback)
        denoised = denoise_parts(cloud, method, motion, estimate, callback)
        ordered = in_input_order(store, denoised.columns, callback)
    return TiledResult(store, denoised, ordered)
