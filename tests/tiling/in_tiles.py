"""A cloud in memory denoised in tiles, without files of points."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Unpack

import numpy as np

from pcsmooth.cloud import PointCloud
from pcsmooth.denoised_rows import DenoisedRows
from pcsmooth.denoising import Denoised, denoise_parts
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
    def overall(self) -> DenoisedRows:
        """What holds for the whole cloud, without any points."""
        nowhere = np.empty((0, self.store.dimension))
        none = np.empty(0, np.int64)
        return self.denoised.result(nowhere, none != 0, none, self.ordered.read(0, 0))

    def parts(self, pieces: Iterable[PointCloud]) -> Iterator[tuple[PointCloud, DenoisedRows]]:
        """Give the result of the input piece by piece.

        Parameters
        ----------
        pieces : iterable of PointCloud
            All of the input, in its order; rows marked as noise are those that took no part.

        Yields
        ------
        piece : PointCloud
            As it came.
        result : DenoisedRows
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
    """Denoise a cloud in tiles: what `denoise` takes, and who works on them in which folder."""
    method, motion, estimate = resolve_keywords(method, motion, estimate, keywords)
    if not source.has_normals:
        given_normals(None, (source.count, source.dimension), estimate.orientation)
    with thread_limit(threads):
        store = cut_cloud(source, folder, tile_points, callback)
        cloud = TiledCloud(store, runner, callback)
        denoised = denoise_parts(cloud, method, motion, estimate, callback)
        ordered = in_input_order(store, denoised.columns, callback)
    return TiledResult(store, denoised, ordered)
