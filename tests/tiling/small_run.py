"""A small cloud denoised in tiles, and work that goes wrong: for tests of runners."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.bodies.presets import load_presets
from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.tiling import dask_runner, flow
from pcsmooth.tiling.cutting import Piece, Source
from pcsmooth.tiling.denoising import denoise_in_tiles
from pcsmooth.tiling.runner import InProcess, Runner

_ROWS = 2500


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


def result_of(
    runner: Runner, folder: Path, count: int = 6000, tile_points: int = 1000, **options: Any
) -> bytes:
    """Denoise a cloud in tiles; what the result holds on disk."""
    folder.mkdir(exist_ok=True)
    result = denoise_in_tiles(
        source_of(noisy_sphere(count)), folder, tile_points, runner, iterations=1, **options
    )
    assert result.cloud.partition.n_tiles >= 5
    return Path(result.ordered.path).read_bytes()


def expected(folder: Path, **options: Any) -> bytes:
    return result_of(InProcess(), folder, **options)


#: What `result_of` is asked for with a body in place of the balls.
CUBE: dict[str, Any] = {"polyhedron": load_presets()["cube"], "union": "naive"}


# --- work


def tasks(cloud: Path, count: int = 8) -> Iterator[tuple[Path, int]]:
    return ((cloud, tile) for tile in range(count))


#: What `square` makes of them.
SQUARES = [tile * tile for tile in range(8)]


def square(cloud: Path, tile: int) -> int:
    """Take longer for the first tiles than for those after them."""
    time.sleep(0.05 * (3 - tile % 4))
    return tile * tile


def square_and_tell(cloud: Path, tile: int) -> int:
    (cloud / f"begun{tile}").touch()
    return tile * tile


def die_once(cloud: Path, tile: int) -> int:
    if tile == 3 and not (cloud / "died").exists():
        (cloud / "died").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return tile * tile


def die_always(cloud: Path, tile: int) -> int:
    if tile == 3:
        with (cloud / "deaths").open("a") as deaths:
            deaths.write("x")
        os.kill(os.getpid(), signal.SIGKILL)
    return tile * tile


def fail(cloud: Path, tile: int) -> int:
    if tile == 3:
        raise {
            "file": CloudFileError("x.bin", "the disk is full", "make room"),
            "input": InvalidInputError("that is no number"),
            "interrupt": KeyboardInterrupt(),
            "bug": KeyError("oops"),
            "system": TimeoutError("the disk sleeps"),
        }[cloud.name]
    return tile * tile


def step_and_die(*task: Any) -> Any:
    """Take a step; the first time at a tile, die before that."""
    cloud, tile, *_ = task
    mark = cloud.folder / "died"
    if tile == 2 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return flow._step_tile(*task)


def sleep_long(cloud: Path, tile: int) -> int:
    (cloud / f"asleep{tile}").touch()
    time.sleep(600.0)
    return tile


def threads_here(cloud: Path, tile: int) -> int:
    from pcsmooth.kernels.threads import thread_limit

    with thread_limit(None) as count:
        return count


def run_alone(cloud: Path, tile: int) -> bool:
    """Whether no other task runs in this process meanwhile."""
    mark = cloud / f"busy{os.getpid()}"
    try:
        mark.touch(exist_ok=False)
    except FileExistsError:
        return False
    time.sleep(0.1)
    mark.unlink()
    return True


def answer_oddly_at_first(key: str, *asked: Any) -> object:
    """Stand in for what dask workers call: nothing, or what belongs to another key, comes back."""
    _, (cloud, tile), _ = asked
    mark = cloud / f"odd{tile}"
    if mark.exists():
        return dask_runner._do_alone(key, *asked)
    mark.touch()
    return None if tile % 2 else dask_runner._do_alone(f"not {key}", *asked)


def answer_nothing(*_asked: Any) -> None:
    pass


def give_what_cannot_be_sent(cloud: Path, tile: int) -> object:
    return lambda: tile
