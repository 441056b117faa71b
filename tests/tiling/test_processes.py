from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from pcsmooth.errors import CloudFileError, InvalidInputError, PcsmoothError
from pcsmooth.tiling import flow
from pcsmooth.tiling.processes import ProcessRunner
from tiling import small_run
from tiling.small_run import SQUARES, tasks


@pytest.fixture(scope="module")
def runner() -> Iterator[ProcessRunner]:
    with ProcessRunner(2) as runner:
        yield runner


def test_results_come_in_the_order_of_the_tasks(runner: ProcessRunner, tmp_path: Path) -> None:
    assert list(runner.map(small_run.square, tasks(tmp_path))) == SQUARES


def test_few_tasks_are_begun_ahead_of_what_is_asked_for(
    runner: ProcessRunner, tmp_path: Path
) -> None:
    results = runner.map(small_run.square_and_tell, tasks(tmp_path, 100))
    assert next(results) == 0
    time.sleep(0.3)
    assert len(list(tmp_path.iterdir())) <= 4


def test_a_cloud_becomes_the_same_to_the_last_bit(runner: ProcessRunner, tmp_path: Path) -> None:
    assert small_run.result_of(runner, tmp_path / "two") == small_run.expected(tmp_path / "one")


def test_a_cloud_of_bodies_too(runner: ProcessRunner, tmp_path: Path) -> None:
    found = small_run.result_of(runner, tmp_path / "two", **small_run.CUBE)
    assert found == small_run.expected(tmp_path / "one", **small_run.CUBE)


def test_a_process_that_is_killed_does_not_change_the_result(
    runner: ProcessRunner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = small_run.expected(tmp_path / "one")
    monkeypatch.setattr(flow, "_step_tile", small_run.step_and_die)
    assert small_run.result_of(runner, tmp_path / "two") == expected
    assert (tmp_path / "two" / "died").exists()


def test_a_task_whose_process_died_is_done_again(runner: ProcessRunner, tmp_path: Path) -> None:
    assert list(runner.map(small_run.die_once, tasks(tmp_path))) == SQUARES
    assert (tmp_path / "died").exists()


def test_a_task_that_kills_every_process_is_named(runner: ProcessRunner, tmp_path: Path) -> None:
    with pytest.raises(
        PcsmoothError,
        match=r"^tile 3: 4 processes at work on it died \(SIGKILL\), perhaps for lack of memory; "
        "use smaller tiles or fewer processes$",
    ):
        list(runner.map(small_run.die_always, tasks(tmp_path)))
    assert (tmp_path / "deaths").read_text() == "xxxx"
    assert list(runner.map(small_run.square, tasks(tmp_path))) == SQUARES


@pytest.mark.parametrize(
    ("name", "kind", "message"),
    [
        ("file", CloudFileError, "x.bin: the disk is full; make room"),
        ("input", InvalidInputError, "that is no number"),
        ("interrupt", KeyboardInterrupt, ""),
        ("bug", KeyError, "'oops'"),
        ("system", TimeoutError, "the disk sleeps"),
    ],
)
def test_what_a_task_raises_comes_through(
    runner: ProcessRunner, tmp_path: Path, name: str, kind: type[BaseException], message: str
) -> None:
    with pytest.raises(kind) as raised:
        list(runner.map(small_run.fail, tasks(tmp_path / name)))
    assert type(raised.value) is kind
    assert str(raised.value) == message
    assert "in fail" in raised.value.__notes__[0]


class Unreadable:
    def __reduce__(self) -> tuple[type[int], tuple[str]]:
        return int, ("seven",)


def test_what_cannot_be_sent(runner: ProcessRunner, tmp_path: Path) -> None:
    with pytest.raises(AttributeError, match="lambda"):
        list(runner.map(lambda _folder, tile: tile, tasks(tmp_path)))
    with pytest.raises(TypeError, match=r"^a function cannot be sent: .*lambda"):
        list(runner.map(small_run.give_what_cannot_be_sent, tasks(tmp_path)))
    with pytest.raises(ValueError, match="seven"):
        list(runner.map(small_run.square, [(Unreadable(), 0)]))
    assert list(runner.map(small_run.square, tasks(tmp_path))) == SQUARES


def test_closing_ends_tasks(tmp_path: Path) -> None:
    with ProcessRunner(2) as runner:
        results = runner.map(small_run.sleep_long, tasks(tmp_path))
        waiter = runner._submit(small_run.sleep_long, (tmp_path, 0))
        while not (tmp_path / "asleep0").exists():
            time.sleep(0.05)
        started = time.monotonic()
    assert time.monotonic() - started < 5.0
    with pytest.raises(PcsmoothError, match="tile 0: the processes have been ended"):
        waiter.result()
    with pytest.raises(RuntimeError):
        next(results)


def test_each_process_has_its_share_of_threads(tmp_path: Path) -> None:
    with ProcessRunner(1, threads=1) as runner:
        assert list(runner.map(small_run.threads_here, tasks(tmp_path, 2))) == [1, 1]


@pytest.mark.parametrize(("processes", "threads", "retries"), [(0, 1, 3), (1, 0, 3), (1, 1, -1)])
def test_numbers_that_make_no_sense(processes: int, threads: int, retries: int) -> None:
    with pytest.raises(InvalidInputError):
        ProcessRunner(processes, threads, retries)
