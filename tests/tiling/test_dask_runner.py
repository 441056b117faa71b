from __future__ import annotations

import gc
import logging
import socket
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

import pcsmooth
from pcsmooth.errors import CloudFileError, InvalidInputError, PcsmoothError
from pcsmooth.kernels import level
from pcsmooth.tiling import dask_runner, flow
from pcsmooth.tiling.dask_runner import DaskRunner
from tiling import small_run
from tiling.small_run import SQUARES, tasks

if TYPE_CHECKING:
    from distributed import LocalCluster

# Workers that die leave sockets and warnings behind.
pytestmark = pytest.mark.filterwarnings("ignore")


def start_cluster(**options: Any) -> LocalCluster:
    distributed = pytest.importorskip("distributed")
    cluster: LocalCluster = distributed.LocalCluster(
        dashboard_address=None, silence_logs=logging.CRITICAL, **options
    )
    return cluster


@pytest.fixture(scope="module")
def cluster() -> Iterator[LocalCluster]:
    with start_cluster(n_workers=2, threads_per_worker=1) as cluster:
        yield cluster


@pytest.fixture
def runner(cluster: LocalCluster, tmp_path: Path) -> Iterator[DaskRunner]:
    cluster.scale(2)
    with DaskRunner(cluster.scheduler_address, tmp_path) as runner:
        yield runner


def test_results_come_in_the_order_of_the_tasks(runner: DaskRunner, tmp_path: Path) -> None:
    assert list(runner.map(small_run.square, tasks(tmp_path))) == SQUARES


def test_few_tasks_are_begun_ahead_of_what_is_asked_for(runner: DaskRunner, tmp_path: Path) -> None:
    results = runner.map(small_run.square_and_tell, tasks(tmp_path, 100))
    assert next(results) == 0
    time.sleep(0.3)
    assert len(list(tmp_path.iterdir())) <= 4


def test_the_scheduler_keeps_no_results(
    runner: DaskRunner, cluster: LocalCluster, tmp_path: Path
) -> None:
    list(runner.map(small_run.square, tasks(tmp_path)))
    ends = time.monotonic() + 5.0
    assert cluster.scheduler is not None
    while cluster.scheduler.tasks and time.monotonic() < ends:
        time.sleep(0.05)
    assert not cluster.scheduler.tasks


def test_a_cloud_becomes_the_same_to_the_last_bit(runner: DaskRunner, tmp_path: Path) -> None:
    assert small_run.result_of(runner, tmp_path / "two") == small_run.expected(tmp_path / "one")


def test_a_worker_that_is_killed_does_not_change_the_result(
    runner: DaskRunner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = small_run.expected(tmp_path / "one", **small_run.CUBE)
    monkeypatch.setattr(flow, "_step_tile", small_run.step_and_die)
    assert small_run.result_of(runner, tmp_path / "two", **small_run.CUBE) == expected
    assert (tmp_path / "two" / "died").exists()


def test_a_task_that_kills_every_worker_is_named(runner: DaskRunner, tmp_path: Path) -> None:
    with pytest.raises(
        PcsmoothError,
        match=r"^tile 3: 4 dask workers at work on it died, the last of them tcp://127.0.0.1:\d+, "
        "perhaps for lack of memory; use smaller tiles or workers with more memory$",
    ):
        list(runner.map(small_run.die_always, [(tmp_path, 3)]))
    assert (tmp_path / "deaths").read_text() == "xxxx"


@pytest.mark.parametrize(
    ("name", "kind", "message"),
    [
        ("file", CloudFileError, "x.bin: the disk is full; make room"),
        ("input", InvalidInputError, "that is no number"),
        ("bug", KeyError, "'oops'"),
        ("system", TimeoutError, "the disk sleeps"),
    ],
)
def test_what_a_task_raises_comes_through(
    runner: DaskRunner, tmp_path: Path, name: str, kind: type[BaseException], message: str
) -> None:
    with pytest.raises(kind) as raised:
        list(runner.map(small_run.fail, tasks(tmp_path / name)))
    assert type(raised.value) is kind
    assert str(raised.value) == message


def test_workers_of_another_version(
    cluster: LocalCluster, runner: DaskRunner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = (
        rf"^dask worker tcp://\S+ has pcsmooth {pcsmooth.__version__}, with which results may "
        r"differ from those of 99\.0 here; install pcsmooth 99\.0 there$"
    )
    monkeypatch.setattr(pcsmooth, "__version__", "99.0")
    with pytest.raises(PcsmoothError, match=told):
        DaskRunner(cluster.scheduler_address, tmp_path)
    # One that came after the start.
    monkeypatch.setitem(runner._versions, "pcsmooth", "99.0")
    with pytest.raises(PcsmoothError, match=told):
        list(runner.map(small_run.square, tasks(tmp_path)))


def test_workers_that_compile_for_other_processors(
    cluster: LocalCluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(level, "COMPILED_FOR", "x86-64-v9")
    wanted = dask_runner._versions()
    monkeypatch.undo()
    monkeypatch.setattr(dask_runner, "_versions", lambda: wanted)
    with pytest.raises(
        PcsmoothError,
        match=rf"^dask worker tcp://\S+ has kernels for {level.COMPILED_FOR}, with which results "
        "may differ from those of x86-64-v9 here; set NUMBA_CPU_NAME to the lower of the two here "
        "and for all workers$",
    ):
        DaskRunner(cluster.scheduler_address, tmp_path)


def test_versions_that_are_no_text(
    cluster: LocalCluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dask_runner, "_versions", lambda: {"numpy": "1.0"})
    monkeypatch.setattr(DaskRunner, "_ask", lambda *_question: [("tcp://w", Agreeable())])
    with pytest.raises(PcsmoothError, match=r"dask worker tcp://w has numpy 1\.0\\x1b, with which"):
        DaskRunner(cluster.scheduler_address, tmp_path)


class Agreeable:
    """Is equal to everything."""

    def __eq__(self, other: object) -> bool:
        return True

    def __ne__(self, other: object) -> bool:
        return False

    def __str__(self) -> str:
        return "1.0\x1b"


def test_a_worker_that_answers_with_something_else(
    runner: DaskRunner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dask_runner, "_do_alone", small_run.answer_oddly_at_first)
    assert list(runner.map(small_run.square, tasks(tmp_path))) == SQUARES
    assert len(list(tmp_path.iterdir())) == len(SQUARES)
    monkeypatch.setattr(dask_runner, "_do_alone", small_run.answer_nothing)
    with pytest.raises(
        PcsmoothError,
        match=r"^tile 0: a dask worker answered with something else \(NoneType\) 4 times; restart",
    ):
        list(runner.map(small_run.square, tasks(tmp_path)))


def test_workers_without_the_package(
    cluster: LocalCluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dask_runner, "_versions", lambda: {"no_such_library": "1.0"})
    monkeypatch.setitem(dask_runner._COMPARED, "no_such_library", "no_such_library:__version__")
    with pytest.raises(
        PcsmoothError, match=r"has no no_such_library; install no_such_library 1\.0 there$"
    ):
        DaskRunner(cluster.scheduler_address, tmp_path)


def test_workers_that_do_not_see_the_folder(
    cluster: LocalCluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Named relative to a folder that workers, which have been started before, are not in.
    monkeypatch.chdir(tmp_path)
    with pytest.raises(PcsmoothError, match=r"does not see the folder \.; name one, by its abs"):
        DaskRunner(cluster.scheduler_address, Path())
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_not_there(cluster: LocalCluster, tmp_path: Path) -> None:
    with pytest.raises(CloudFileError, match="no such file or folder"):
        DaskRunner(cluster.scheduler_address, tmp_path / "none")


def test_a_scheduler_without_workers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dask_runner, "_WORKERLESS", 0.5)
    monkeypatch.setattr(dask_runner, "_GLANCE", 0.2)
    with start_cluster(n_workers=0, processes=False) as cluster:
        with pytest.raises(PcsmoothError, match=r"the dask scheduler has no worker; start some"):
            DaskRunner(cluster.scheduler_address, tmp_path)
        cluster.scale(1)
        with DaskRunner(cluster.scheduler_address, tmp_path) as runner:
            cluster.scale(0)
            while cluster.scheduler.workers:
                time.sleep(0.05)
            with pytest.raises(PcsmoothError, match=r"the dask scheduler has no worker; start"):
                list(runner.map(small_run.square, tasks(tmp_path)))


def test_a_scheduler_that_goes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dask_runner, "_CONNECTING", 1.0)
    with start_cluster(n_workers=1, processes=False) as cluster:
        runner = DaskRunner(cluster.scheduler_address, tmp_path)
        results = runner.map(small_run.square, tasks(tmp_path, 100))
        assert next(results) == 0
    told = "the dask scheduler has gone; start it anew, and the run$"
    with runner:
        with pytest.raises(PcsmoothError, match=told):
            list(results)
        with pytest.raises(PcsmoothError, match=told):
            list(runner.map(small_run.square, tasks(tmp_path)))


def test_a_worker_of_several_threads_does_one_task_at_a_time(tmp_path: Path) -> None:
    with (
        start_cluster(n_workers=2, threads_per_worker=2) as cluster,
        DaskRunner(cluster.scheduler_address, tmp_path) as runner,
    ):
        assert all(runner.map(small_run.run_alone, tasks(tmp_path, 12)))
        assert set(runner.map(small_run.threads_here, tasks(tmp_path))) <= {1, 2}
        assert small_run.result_of(runner, tmp_path / "two") == small_run.expected(tmp_path / "one")


def test_a_scheduler_that_cannot_be_reached(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr(dask_runner, "_CONNECTING", 1.0)
    with socket.socket() as busy:
        busy.bind(("127.0.0.1", 0))  # nobody listens
        address = f"tcp://127.0.0.1:{busy.getsockname()[1]}"
        with pytest.raises(
            PcsmoothError, match=rf"^{address}: no dask scheduler answers within 1 s \(.*\); check"
        ):
            DaskRunner(address, tmp_path)


def test_a_configuration_that_refuses_the_address(cluster: LocalCluster, tmp_path: Path) -> None:
    dask = pytest.importorskip("dask")
    with (
        dask.config.set({"distributed.comm.require-encryption": True}),
        pytest.raises(PcsmoothError, match="encryption required by Dask configuration"),
    ):
        DaskRunner(cluster.scheduler_address, tmp_path)


@pytest.mark.parametrize("address", ["nowhere", "ftp://nowhere:1", "tcp://127.0.0.1", ""])
def test_what_is_no_address(tmp_path: Path, address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(dask_runner, "_CONNECTING", 1.0)
    with pytest.raises(PcsmoothError, match="no dask scheduler answers"):
        DaskRunner(address, tmp_path)
    left = [each for each in gc.get_objects() if type(each) is distributed.Client]
    assert left == [] or {each.status for each in left} == {"closed"}


def test_without_the_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(
        PcsmoothError,
        match=r"^runs on dask clusters need distributed, which is not installed; "
        r"pip install 'pcsmooth\[dask\]'$",
    ):
        DaskRunner("tcp://127.0.0.1:8786", tmp_path)
