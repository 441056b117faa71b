"""Work on tiles that goes well or wrong, for tests of runners; imports little, as workers do it."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from pcsmooth.errors import CloudFileError, InvalidInputError


def tasks(cloud: Path, count: int = 8) -> Iterator[tuple[Path, int]]:
    return ((cloud, tile) for tile in range(count))


#: What `square` makes of them.
SQUARES = [tile * tile for tile in range(8)]


def square(cloud: Path, tile: int) -> int:
    return tile * tile


def square_slowly(cloud: Path, tile: int) -> int:
    """Take longer for the first tiles than for those after them."""
    time.sleep(0.04 * (3 - tile % 4))
    return tile * tile


def square_and_tell(cloud: Path, tile: int) -> int:
    (cloud / f"done{tile}").touch()
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


#: What `fail` raises.
ERRORS: dict[str, BaseException] = {
    "file": CloudFileError("x.bin", "the disk is full", "make room"),
    "input": InvalidInputError("that is no number"),
    "bug": KeyError("oops"),
    "system": TimeoutError("the disk sleeps"),
    "interrupt": KeyboardInterrupt(),
}


def fail(cloud: Path, tile: int) -> int:
    """Raise, at one tile, the error that the cloud is named after."""
    if tile == 3:
        raise ERRORS[cloud.name]
    return tile * tile


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
    time.sleep(0.05)
    mark.unlink()
    return True


def answer_oddly_at_first(
    key: str, work: Callable[..., Any], task: tuple[Path, int], versions: dict[str, str]
) -> object:
    """Stand in for what dask workers call: nothing, or what belongs to another key, comes back."""
    from pcsmooth.tiling import dask_runner

    cloud, tile = task
    mark = cloud / f"odd{tile}"
    if mark.exists():
        return dask_runner._do_alone(key, work, task, versions)
    mark.touch()
    return None if tile % 2 else dask_runner._do_alone(f"not {key}", work, task, versions)


def answer_nothing(*_asked: object) -> None:
    pass


def give_what_cannot_be_sent(cloud: Path, tile: int) -> object:
    return lambda: tile
