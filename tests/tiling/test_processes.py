from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from pcsmooth.errors import InvalidInputError, PcsmoothError
from pcsmooth.tiling.processes import ProcessRunner
from tiling import tile_work
from tiling.tile_work import SQUARES, tasks


@pytest.fixture(scope="module")
def runner() -> Iterator[ProcessRunner]:
    with ProcessRunner(1, threads=1) as runner:
        yield runner


class Unreadable:
    def __reduce__(self) -> tuple[type[int], tuple[str]]:
        return int, ("seven",)


def test_what_cannot_be_sent(runner: ProcessRunner, tmp_path: Path) -> None:
    with pytest.raises(AttributeError, match="lambda"):
        list(runner.map(lambda _folder, tile: tile, tasks(tmp_path)))
    with pytest.raises(TypeError, match=r"^a function cannot be sent: .*lambda"):
        list(runner.map(tile_work.give_what_cannot_be_sent, tasks(tmp_path)))
    with pytest.raises(ValueError, match="seven"):
        list(runner.map(tile_work.square, [(Unreadable(), 0)]))
    assert list(runner.map(tile_work.square, tasks(tmp_path))) == SQUARES


def test_each_process_has_its_share_of_threads(runner: ProcessRunner, tmp_path: Path) -> None:
    assert list(runner.map(tile_work.threads_here, tasks(tmp_path, 2))) == [1, 1]


def test_closing_ends_tasks(tmp_path: Path) -> None:
    with ProcessRunner(2) as runner:
        results = runner.map(tile_work.sleep_long, tasks(tmp_path))
        waiter = runner._submit(tile_work.sleep_long, (tmp_path, 0))
        while not (tmp_path / "asleep0").exists():
            time.sleep(0.02)
        started = time.monotonic()
    assert time.monotonic() - started < 5.0
    with pytest.raises(PcsmoothError, match="tile 0: the processes have been ended"):
        waiter.result()
    with pytest.raises(RuntimeError):
        next(results)


@pytest.mark.parametrize(("processes", "threads", "retries"), [(0, 1, 3), (1, 0, 3), (1, 1, -1)])
def test_numbers_that_make_no_sense(processes: int, threads: int, retries: int) -> None:
    with pytest.raises(InvalidInputError):
        ProcessRunner(processes, threads, retries)
