"""Work on tiles by the workers of a dask cluster, which may die without ending the run."""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError
from dataclasses import dataclass
from functools import partial
from os.path import exists
from pathlib import Path
from pkgutil import resolve_name
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self
from uuid import uuid4

from pcsmooth.errors import PcsmoothError
from pcsmooth.formats.system_errors import named_system_errors
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.optional_libraries import optional_library
from pcsmooth.printable import printable
from pcsmooth.tiling.runner import TileWork, in_order, tile_name

if TYPE_CHECKING:
    from distributed import Client, Future

#: Tasks that are handed out at a time, for each worker.
_AHEAD = 2

#: What is to be the same on all workers as in this process, lest results differ, and where it is
#: found.
_COMPARED = {
    "pcsmooth": "pcsmooth:__version__",
    "numpy": "numpy:__version__",
    "numba": "numba:__version__",
    "kernels for": "pcsmooth.kernels.level:COMPILED_FOR",
}

#: Seconds to wait for the scheduler.
_CONNECTING = 10.0

#: Seconds to wait for a first worker, and for another one when all have gone.
_WORKERLESS = 30.0

#: Seconds between two looks at what has become of a task.
_GLANCE = 5.0

#: Held by the task that a worker is at.
_ALONE = threading.Lock()


class DaskRunner:
    """Does work on tiles on a dask cluster.

    A worker does one task at a time, as each needs memory for a tile, and its kernels take as many
    threads as dask gave it. The cluster repeats what was lost with a worker. To be closed, or used
    as a context manager; closing leaves the cluster as it is.

    Parameters
    ----------
    address : str
        Of the scheduler, like "tcp://host:8786".
    folder : Path
        Where the columns will lie, on a disk that all workers see by the same name.
    retries : int
        How often a task is repeated that failed, or of which something else came back. How many
        workers may die at a task is up to the scheduler
        (``distributed.scheduler.allowed-failures``).

    Raises
    ------
    PcsmoothError
        dask is not installed, the scheduler cannot be reached, or there is no worker; a worker
        has not the same versions of pcsmooth, NumPy and numba, or compiles for other processors, or
        does not see the folder.
    CloudFileError
        No file can be made in the folder.
    """

    def __init__(self, address: str, folder: Path, retries: int = 3) -> None:
        self._dask = optional_library("distributed", "dask", "runs on dask clusters")
        self._address = address
        self._retries = retries
        self._versions = _versions()
        self._client = self._connect()
        try:
            self._wait_for_worker(_WORKERLESS)
            self._check_versions()
            self._check_folder(folder)
        except BaseException:
            self.close()
            raise

    def map(self, work: TileWork, tasks: Iterable[tuple[Any, ...]]) -> Iterator[Any]:
        """Call `work(*task)` for each task on one of the workers; see `Runner.map`.

        Raises
        ------
        PcsmoothError
            Too many workers died at a task, none is left, or the scheduler has gone.
        """
        ahead = _AHEAD * max(1, self._count_workers())
        yield from in_order(partial(self._submit, work), tasks, ahead)

    def close(self) -> None:
        """Take leave of the cluster."""
        self._client.close()

    def __enter__(self) -> Self:
        """Give the runner itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close it."""
        self.close()

    def _connect(self) -> Client:
        client: Client = object.__new__(self._dask.Client)
        try:
            # Not called as a class: what fails to start would be out of reach, and would close
            # itself when rubbish is collected, perhaps by the thread that another one starts,
            # which then waits for it in vain.
            type(client).__init__(client, self._address, timeout=_CONNECTING, set_as_default=False)
        except Exception as error:  # of any library beneath it: of sockets, TLS, configuration
            client.close()
            raise PcsmoothError(
                f"{self._address}: no dask scheduler answers within {_CONNECTING:.0f} s "
                f"({_in_one_line(error)}); check the address, and that it runs"
            ) from error
        return client

    def _wait_for_worker(self, seconds: float) -> None:
        try:
            self._client.wait_for_workers(1, timeout=seconds)
        except TimeoutError as error:
            raise PcsmoothError(
                f"{self._address}: the dask scheduler has no worker; start some, as with "
                f"`dask worker {self._address}`"
            ) from error

    def _check_versions(self) -> None:
        for library, version in self._versions.items():
            for worker, found in self._ask(resolve_name, _COMPARED[library]):
                if isinstance(found, ImportError):
                    raise PcsmoothError(
                        f"dask worker {worker} has no {library}; install {library} {version} there"
                    )
                if not (isinstance(found, str) and found == version):
                    raise PcsmoothError(_other_version(worker, library, found, version))

    def _check_folder(self, folder: Path) -> None:
        with (
            named_system_errors(str(folder)),
            tempfile.NamedTemporaryFile(prefix="seen-by-all-", dir=folder) as probe,
        ):
            # By the name that tasks will use, absolute or not.
            for worker, is_seen in self._ask(exists, str(folder / Path(probe.name).name)):
                if not is_seen:
                    raise PcsmoothError(
                        f"dask worker {worker} does not see the folder {folder}; name one, by its "
                        "absolute path, that all workers share"
                    )

    def _ask(self, question: Any, argument: str) -> Iterator[tuple[str, Any]]:
        """Call a function on all workers: their addresses, and what it returned or raised."""
        answers = self._client.run(question, argument, on_error="return")
        for worker, answer in answers.items():
            if isinstance(answer, Exception) and not isinstance(answer, ImportError):
                raise PcsmoothError(
                    f"dask worker {worker} does not answer ({_in_one_line(answer)})"
                ) from answer
            yield worker, answer

    def _submit(self, work: TileWork, task: tuple[Any, ...]) -> _Submitted:
        key = f"{work.__name__.strip('_')}-{uuid4().hex}-{tile_name(task)}"

        def hand_out(attempt: int) -> Future[Any]:
            if self._client.status == "closed":
                raise self._lost()
            return self._client.submit(
                _do_alone, key, work, task, self._versions, retries=self._retries, pure=False,
                key=f"{key}-{attempt}",
            )  # fmt: skip

        return _Submitted(self, hand_out, key, task)

    def _result(self, future: Future[Any], task: tuple[Any, ...]) -> Any:
        """Wait for a task."""
        try:
            while True:
                try:
                    return future.result(timeout=_GLANCE)
                except TimeoutError:
                    if future.done():
                        return future.result()  # or the task's own error
                    if not self._count_workers():
                        self._wait_for_worker(_WORKERLESS)
        except self._dask.KilledWorker as error:
            raise PcsmoothError(
                f"{tile_name(task)}: {error.allowed_failures + 1} dask workers at work on it "
                f"died, the last of them {_address_of(error.last_worker)}, perhaps for lack of "
                "memory; use smaller tiles or workers with more memory"
            ) from error
        except (CancelledError, OSError, RuntimeError) as error:
            if self._client.status == "running" and not isinstance(error, CancelledError):
                raise  # the task's own
            raise self._lost() from error

    def _count_workers(self) -> int:
        try:
            return len(self._client.nthreads())
        except (CancelledError, OSError, RuntimeError) as error:
            raise self._lost() from error

    def _lost(self) -> PcsmoothError:
        return PcsmoothError(
            f"{self._address}: the dask scheduler has gone; start it anew, and the run"
        )


class _Submitted:
    """A task on the cluster: see `Pending`."""

    def __init__(
        self,
        runner: DaskRunner,
        hand_out: Callable[[int], Future[Any]],
        key: str,
        task: tuple[Any, ...],
    ) -> None:
        self._runner = runner
        self._hand_out = hand_out
        self._key = key
        self._task = task
        self._future = hand_out(0)

    def result(self) -> Any:
        for attempt in range(1, self._runner._retries + 2):
            try:
                outcome = self._runner._result(self._future, self._task)
            finally:
                self._future.release()
            if type(outcome) is _Outcome and outcome.key == self._key:
                return outcome.result
            if attempt <= self._runner._retries:
                self._future = self._hand_out(attempt)
        raise PcsmoothError(
            f"{tile_name(self._task)}: a dask worker answered with something else "
            f"({type(outcome).__name__}) {attempt} times; restart the workers, all with the same "
            "installation"
        )

    def cancel(self) -> None:
        # The scheduler drops what nobody holds; to cancel would be to wait for its answer.
        self._future.release()


@dataclass(frozen=True)
class _Outcome:
    """What came of a task, with the key that it was handed out by."""

    key: str
    result: Any


def _do_alone(
    key: str, work: TileWork, task: tuple[Any, ...], versions: dict[str, str]
) -> _Outcome:
    """Do a task on a worker, of which others may be at hand that came after the start."""
    from distributed import get_worker

    worker = get_worker()
    for library, found in _versions().items():
        if found != versions[library]:
            raise PcsmoothError(_other_version(worker.address, library, found, versions[library]))
    with _ALONE, thread_limit(worker.state.nthreads):
        return _Outcome(key, work(*task))


def _versions() -> dict[str, str]:
    return {name: str(resolve_name(place)) for name, place in _COMPARED.items()}


def _other_version(worker: str, library: str, found: Any, wanted: str) -> str:
    remedy = f"install {library} {wanted} there"
    if library == "kernels for":
        remedy = "set NUMBA_CPU_NAME to the lower of the two here and for all workers"
    return (
        f"dask worker {worker} has {library} {printable(str(found))}, with which results may "
        f"differ from those of {wanted} here; {remedy}"
    )


def _address_of(worker: Any) -> str:
    return str(getattr(worker, "address", worker))


def _in_one_line(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__
