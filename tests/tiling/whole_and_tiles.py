"""Runs of a whole cloud and of the same cloud in tiles, compared."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from oracles import Array
from pcsmooth.denoise_result import DenoiseResult
from pcsmooth.denoising import denoise
from pcsmooth.tiling.cutting import Piece, Source
from pcsmooth.tiling.denoising import TiledResult, denoise_in_tiles
from pcsmooth.tiling.runner import InProcess

#: Rows that are read at a time.
_ROWS = 700

#: Per point; and of the whole cloud.
_OF_POINTS = ("points", "displacement", "finite", "outliers")
_ESTIMATES = (
    "normals",
    "mean_curvature",
    "gaussian_curvature",
    "principal_curvatures",
    "confidence",
)
_OVERALL = (
    "scheme", "energy", "weight", "spacing", "radius", "step", "plan", "order", "max_move",
    "stopped_early", "solver_iterations", "solver_error",
)  # fmt: skip
_OF_ESTIMATES = ("radius", "spacing", "normal_support", "curvature_support", "orientation")


def source_of(points: Array, fixed: npt.NDArray[np.bool_] | None = None) -> Source:
    """A cloud as it is read in pieces."""

    def slices() -> Iterator[slice]:
        return (slice(start, start + _ROWS) for start in range(0, len(points), _ROWS))

    return Source(
        len(points),
        points.shape[1],
        False,
        lambda: (points[rows] for rows in slices()),
        lambda: (Piece(points[rows], None if fixed is None else fixed[rows]) for rows in slices()),
    )


def assert_same_in_tiles(
    points: Array,
    folder: Path,
    tile_points: int,
    fixed: npt.NDArray[np.bool_] | None = None,
    **options: Any,
) -> tuple[DenoiseResult, TiledResult]:
    """Denoise a cloud both ways: all that belongs to points has the same bits.

    One thread each: most kernels have too little to do to be worth waking another.
    """
    options = {"threads": 1, **options}
    whole = denoise(points, fixed=fixed, **options)
    source = source_of(points, fixed)
    tiled = denoise_in_tiles(source, folder, tile_points, InProcess(), **options)
    parts = list(tiled.parts(source.positions()))
    for name in _OF_POINTS:
        found = [getattr(part, name) for part in parts]
        expected = getattr(whole, name)
        if expected is None:
            assert found == [None] * len(parts)
        else:
            np.testing.assert_array_equal(np.concatenate(found), expected, err_msg=name)
    for name in _ESTIMATES:
        found = [getattr(part.curvature, name) for part in parts]
        expected = getattr(whole.curvature, name)
        np.testing.assert_array_equal(np.concatenate(found), expected, err_msg=name)
    for name in _OVERALL:
        assert getattr(tiled.overall, name) == getattr(whole, name), name
    for name in _OF_ESTIMATES:
        assert getattr(tiled.overall.curvature, name) == getattr(whole.curvature, name), name
    for a, b in zip(tiled.overall.history, whole.history, strict=True):
        assert a.iteration == b.iteration
        np.testing.assert_allclose(
            [a.volume, a.area, a.mean_move, a.max_move],
            [b.volume, b.area, b.mean_move, b.max_move],
            rtol=1e-12,
        )
    return whole, tiled
