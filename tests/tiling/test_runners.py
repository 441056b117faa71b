"""What every runner must do; a further one needs one more entry in `RUNNERS`."""

from __future__ import annotations

import gc
import re
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

from pcsmooth.errors import PcsmoothError
from pcsmooth.tiling import tiled_cloud
from pcsmooth.tiling.dask_runner import DaskRunner
from pcsmooth.tiling.processes import ProcessRunner
from pcsmooth.tiling.runner import InProcess, Runner
from tiling import small_run, tile_work
from tiling.dask_clusters import UNTIDY, start_cluster
from tiling.tile_work import SQUARES, tasks


@dataclass(frozen=True)
class Kind:
    """A runner, and what is its own.

    Attributes
    ----------
    start : callable
        Starts one; gets a folder that all its workers are to see.
    ahead : int
        Most tasks that are handed out before the first is done.
    killed : str or None
        What is said, as a pattern, when all workers that may try tile 3 were killed at it; None if
        work is done in this process.
    deaths : int
        How many these are.
    blames_others : bool
        Whether tasks that were beside a killed one may be taken for what killed it.
    notes : str
        What notes on the error of a task say, as a pattern; empty if none is promised.
    is_interrupted : bool
        Whether a KeyboardInterrupt in a task comes through.
    """

    start: Callable[[Path], AbstractContextManager[Runner]]
    ahead: int
    killed: str | None = None
    deaths: int = 0
    blames_others: bool = False
    notes: str = ""
    is_interrupted: bool = True


@contextmanager
def dask(folder: Path) -> Iterator[Runner]:
    with (
        start_cluster(allowed_failures=1, n_workers=2, threads_per_worker=2) as cluster,
        DaskRunner(cluster.scheduler_address, folder) as runner,
    ):
        yield runner
    gc.collect()  # while warnings are ignored


RUNNERS = [
    pytest.param(Kind(lambda _folder: nullcontext(InProcess()), ahead=1), id="in process"),
    pytest.param(
        Kind(
            lambda _folder: ProcessRunner(2, retries=1),
            ahead=4,
            killed=r"2 processes at work on it died \(SIGKILL\), perhaps for lack of memory; "
            "use smaller tiles or fewer processes",
            deaths=2,
            notes="in another process:.* in fail",
        ),
        id="processes",
    ),
    pytest.param(
        Kind(
            dask,
            ahead=4,
            killed=r"2 dask workers at work on it died, the last of them tcp://127.0.0.1:\d+, "
            "perhaps for lack of memory; use smaller tiles or workers with more memory",
            deaths=2,
            blames_others=True,
            is_interrupted=False,
        ),
        id="dask",
        marks=[UNTIDY, pytest.mark.slow],
    ),
]


@pytest.fixture(scope="module", params=RUNNERS)
def kind(request: pytest.FixtureRequest) -> Kind:
    kind: Kind = request.param
    return kind


@pytest.fixture(scope="module")
def runner(kind: Kind, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Runner]:
    """Start each only once."""
    with kind.start(tmp_path_factory.mktemp("seen-by-all")) as runner:
        yield runner


@pytest.fixture
def _mortal(kind: Kind) -> None:
    if kind.killed is None:
        pytest.skip("there is no worker that could be killed")


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], bytes]:
    """Give the results of `small_run` in this process, each computed once."""

    @cache
    def expected(name: str) -> bytes:
        options = small_run.OPTIONS[name]
        return small_run.result_of(InProcess(), tmp_path_factory.mktemp(name), **options)

    return expected


def test_results_come_in_the_order_of_the_tasks(runner: Runner, tmp_path: Path) -> None:
    assert list(runner.map(tile_work.square_slowly, tasks(tmp_path))) == SQUARES


def test_without_tasks_there_are_no_results(runner: Runner) -> None:
    assert list(runner.map(tile_work.square, [])) == []


def test_few_tasks_are_begun_ahead_of_what_is_asked_for(
    runner: Runner, kind: Kind, tmp_path: Path
) -> None:
    drawn = []

    def drawing() -> Iterator[tuple[Path, int]]:
        for task in tasks(tmp_path, 100):
            drawn.append(task)
            yield task

    results = runner.map(tile_work.square_and_tell, drawing())
    for asked in range(3):
        assert next(results) == asked**2
        time.sleep(0.05)
        assert len(drawn) <= asked + kind.ahead
        assert len(list(tmp_path.iterdir())) <= len(drawn)


def test_results_that_nobody_asks_for_any_more(runner: Runner, tmp_path: Path) -> None:
    results = runner.map(tile_work.square, tasks(tmp_path, 100))
    assert next(results) == 0
    del results
    assert list(runner.map(tile_work.square, tasks(tmp_path))) == SQUARES


@pytest.mark.slow
def test_a_cloud_becomes_the_same_to_the_last_bit(
    runner: Runner, tmp_path: Path, expected: Callable[[str], bytes]
) -> None:
    found = small_run.result_of(runner, tmp_path / "cloud", **small_run.OPTIONS["balls"])
    assert found == expected("balls")


@pytest.mark.usefixtures("_mortal")
def test_a_worker_that_is_killed_does_not_change_the_result(
    runner: Runner,
    tmp_path: Path,
    expected: Callable[[str], bytes],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    wanted = expected("bodies")
    monkeypatch.setattr(tiled_cloud, "_do", small_run.do_and_die)
    found = small_run.result_of(runner, tmp_path / "cloud", **small_run.OPTIONS["bodies"])
    assert found == wanted
    assert (tmp_path / "cloud" / "died").exists()


@pytest.mark.usefixtures("_mortal")
def test_a_task_whose_worker_died_is_done_again(runner: Runner, tmp_path: Path) -> None:
    assert list(runner.map(tile_work.die_once, tasks(tmp_path))) == SQUARES
    assert (tmp_path / "died").exists()


@pytest.mark.usefixtures("_mortal")
def test_a_task_that_kills_every_worker_is_named(
    runner: Runner, kind: Kind, tmp_path: Path
) -> None:
    given = [(tmp_path, 3)] if kind.blames_others else tasks(tmp_path)
    with pytest.raises(PcsmoothError, match=f"^tile 3: {kind.killed}$"):
        list(runner.map(tile_work.die_always, given))
    assert (tmp_path / "deaths").read_text() == "x" * kind.deaths
    assert list(runner.map(tile_work.square, tasks(tmp_path))) == SQUARES


@pytest.mark.parametrize("name", tile_work.ERRORS)
def test_what_a_task_raises_comes_through(
    runner: Runner, kind: Kind, tmp_path: Path, name: str
) -> None:
    error = tile_work.ERRORS[name]
    if isinstance(error, KeyboardInterrupt) and not kind.is_interrupted:
        pytest.skip("an interrupt of a worker is not one of the run")
    with pytest.raises(type(error)) as raised:
        list(runner.map(tile_work.fail, tasks(tmp_path / name)))
    assert type(raised.value) is type(error)
    assert str(raised.value) == str(error)
    notes = "\n".join(getattr(raised.value, "__notes__", []))
    assert re.search(kind.notes, notes, re.DOTALL)
    assert list(runner.map(tile_work.square, tasks(tmp_path))) == SQUARES
