from __future__ import annotations

import gc
import socket
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import pcsmooth
from pcsmooth.errors import CloudFileError, PcsmoothError
from pcsmooth.kernels import level
from pcsmooth.tiling import dask_runner
from pcsmooth.tiling.dask_runner import DaskRunner
from tiling import tile_work
from tiling.dask_clusters import UNTIDY, start_cluster
from tiling.tile_work import SQUARES, tasks

if TYPE_CHECKING:
    from distributed import LocalCluster

pytestmark = [UNTIDY, pytest.mark.slow]


@pytest.fixture(scope="module")
def cluster() -> Iterator[LocalCluster]:
    with start_cluster(n_workers=1, threads_per_worker=2) as cluster:
        yield cluster


@pytest.fixture
def runner(cluster: LocalCluster, tmp_path: Path) -> Iterator[DaskRunner]:
    with DaskRunner(cluster.scheduler_address, tmp_path) as runner:
        yield runner


def test_the_scheduler_keeps_no_results(
    runner: DaskRunner, cluster: LocalCluster, tmp_path: Path
) -> None:
    list(runner.map(tile_work.square, tasks(tmp_path)))
    ends = time.monotonic() + 5.0
    assert cluster.scheduler is not None
    while cluster.scheduler.tasks and time.monotonic() < ends:
        time.sleep(0.05)
    assert not cluster.scheduler.tasks


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
        list(runner.map(tile_work.square, tasks(tmp_path)))


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
    monkeypatch.setattr(dask_runner, "_do_alone", tile_work.answer_oddly_at_first)
    assert list(runner.map(tile_work.square, tasks(tmp_path))) == SQUARES
    assert len(list(tmp_path.iterdir())) == len(SQUARES)
    monkeypatch.setattr(dask_runner, "_do_alone", tile_work.answer_nothing)
    with pytest.raises(
        PcsmoothError,
        match=r"^tile 0: a dask worker answered with something else \(NoneType\) 4 times; restart",
    ):
        list(runner.map(tile_work.square, tasks(tmp_path)))


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
                list(runner.map(tile_work.square, tasks(tmp_path)))


def test_a_scheduler_that_goes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dask_runner, "_CONNECTING", 1.0)
    with start_cluster(n_workers=1, processes=False) as cluster:
        runner = DaskRunner(cluster.scheduler_address, tmp_path)
        results = runner.map(tile_work.square, tasks(tmp_path, 100))
        assert next(results) == 0
    told = "the dask scheduler has gone; start it anew, and the run$"
    with runner:
        with pytest.raises(PcsmoothError, match=told):
            list(results)
        with pytest.raises(PcsmoothError, match=told):
            list(runner.map(tile_work.square, tasks(tmp_path)))


def test_a_worker_of_several_threads_does_one_task_at_a_time(
    runner: DaskRunner, tmp_path: Path
) -> None:
    assert all(runner.map(tile_work.run_alone, tasks(tmp_path)))
    assert set(runner.map(tile_work.threads_here, tasks(tmp_path))) <= {1, 2}


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
