"""A cloud denoised as a whole and in tiles, and what differs between the two."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import astuple
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.curvature.orientation import parse_orientation
from pcsmooth.denoised_rows import DenoisedRows
from pcsmooth.estimating import given_normals
from pcsmooth.python.denoising import denoise
from pcsmooth.tiling.cutting import Piece, Source
from pcsmooth.tiling.runner import InProcess
from tiling.clouds import Points
from tiling.in_tiles import TiledResult, denoise_in_tiles

#: What must be the same to the last bit at every point.
OF_POINTS: dict[str, Callable[[DenoisedRows], npt.NDArray[Any]]] = {
    "points": lambda result: result.points,
    "displacement": lambda result: result.displacement,
    "finite": lambda result: result.finite,
    "normals": lambda result: result.curvature.normals,
    "mean_curvature": lambda result: result.curvature.mean_curvature,
    "gaussian_curvature": lambda result: result.curvature.gaussian_curvature,
    "principal_curvatures": lambda result: result.curvature.principal_curvatures,
    "confidence": lambda result: result.curvature.confidence,
    "finite estimates": lambda result: result.curvature.finite,
}

#: What must be the same of the whole cloud.
OF_CLOUDS = (
    "method", "motion", "spacing", "radius", "step", "plan", "stopped_early",
    "solver_iterations", "solver_error",
)  # fmt: skip
OF_ESTIMATES = ("normal_support", "curvature_support", "orientation")


def source_of(
    points: Points,
    *,
    fixed: npt.NDArray[np.bool_] | None = None,
    normals: Points | None = None,
    rows: int = 999,
) -> Source:
    """A cloud in memory that is read so many rows at a time."""

    def pieces() -> Iterator[Piece]:
        for start in range(0, len(points), rows):
            part = slice(start, start + rows)
            yield Piece(
                points[part],
                None if fixed is None else fixed[part],
                None if normals is None else normals[part],
            )

    return Source(
        len(points),
        points.shape[1],
        normals is not None,
        lambda: (piece.points for piece in pieces()),
        pieces,
    )


def with_scheme(options: dict[str, Any]) -> dict[str, Any]:
    """Add the scheme euler, unless the options tell of another or of a method."""
    return options if "method" in options else {"scheme": "euler", **options}


def in_tiles(
    points: Points,
    tile_points: int,
    folder: Path,
    *,
    fixed: npt.NDArray[np.bool_] | None = None,
    normals: Points | None = None,
    **options: Any,
) -> TiledResult:
    """Denoise a cloud in tiles."""
    rule = parse_orientation(options.get("orient", "auto"))
    given = None if normals is None else given_normals(normals, points.shape, rule)
    source = source_of(points, fixed=fixed, normals=given)
    options = with_scheme(options)
    return denoise_in_tiles(source, folder, tile_points, InProcess(), **options)


def differences(whole: DenoisedRows, tiled: TiledResult, points: Points) -> list[str]:
    """Name what is not the same in two results for the same points."""
    clouds = (PointCloud(points[start : start + 777]) for start in range(0, len(points), 777))
    parts = [part for _, part in tiled.parts(clouds)]
    unlike = [
        name
        for name, read in OF_POINTS.items()
        if read(whole).tobytes() != np.concatenate([read(part) for part in parts]).tobytes()
    ]
    outliers = [part.outliers for part in parts if part.outliers is not None]
    if whole.outliers is None:
        unlike += ["outliers"] * bool(outliers)
    elif not np.array_equal(whole.outliers, np.concatenate(outliers)):
        unlike.append("outliers")
    for one, other, names in (
        (whole, tiled.overall, OF_CLOUDS),
        (whole.curvature, tiled.overall.curvature, OF_ESTIMATES),
    ):
        unlike += [name for name in names if getattr(one, name) != getattr(other, name)]
    if whole.history != tiled.overall.history:
        unlike.append("history")
    return unlike


def states(result: DenoisedRows) -> npt.NDArray[np.float64]:
    """The history as a table."""
    return np.array([astuple(state) for state in result.history], np.float64)


def compare(
    points: Points, tile_points: int, folder: Path, **options: Any
) -> tuple[list[str], DenoisedRows, TiledResult]:
    """Denoise a cloud both ways; name what differs."""
    options = with_scheme(options)
    whole = denoise(points, **options)
    tiled = in_tiles(points, tile_points, folder, **options)
    return differences(whole, tiled, points), whole, tiled
