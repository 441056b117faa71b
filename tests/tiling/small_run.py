"""A small cloud denoised in tiles by any runner, on which a worker may die."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.bodies.presets import load_presets
from pcsmooth.flows import flow
from pcsmooth.tiling.cutting import Piece, Source
from pcsmooth.tiling.runner import Runner
from pcsmooth.tiling.tiled_cloud import _do
from tiling.in_tiles import denoise_in_tiles

_COUNT = 2000
_ROWS = 800  # of a piece of the source
_TILE_POINTS = 350


def source_of(points: npt.NDArray[np.float64]) -> Source:
    def pieces() -> Iterator[npt.NDArray[np.float64]]:
        for start in range(0, len(points), _ROWS):
            yield points[start : start + _ROWS]

    return Source(
        len(points), points.shape[1], False, pieces, lambda: (Piece(part) for part in pieces())
    )


def noisy_sphere(count: int) -> npt.NDArray[np.float64]:
    rng = np.random.default_rng(5)
    points: npt.NDArray[np.float64] = rng.normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1)[:, np.newaxis]
    noise: npt.NDArray[np.float64] = rng.normal(size=points.shape)
    noise *= 0.3 * float(np.sqrt(4 * np.pi / count))
    return points + noise


def result_of(runner: Runner, folder: Path, **options: Any) -> bytes:
    """Denoise the cloud in tiles; what the result holds on disk."""
    folder.mkdir(exist_ok=True)
    result = denoise_in_tiles(
        source_of(noisy_sphere(_COUNT)), folder, _TILE_POINTS, runner, iterations=1, **options
    )
    assert result.store.partition.n_tiles >= 5
    return Path(result.ordered.path).read_bytes()


#: What `result_of` is asked for, with balls and with a body in their place.
OPTIONS: dict[str, dict[str, Any]] = {
    "balls": {},
    "bodies": {"polyhedron": load_presets()["cube"], "union": "naive"},
}


def do_and_die(*task: Any) -> Any:
    """Do work on a tile; the first time that one is to move, die before that."""
    store, tile, step, *_ = task
    mark = store.folder / "died"
    if tile == 2 and isinstance(step, flow._Step) and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return _do(*task)
