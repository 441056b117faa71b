"""Files that are worked on one after the other, or several at a time by processes."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from pcsmooth.child_processes import deaf_to_interrupts, end_children, spawning
from pcsmooth.cleanup import on_failure
from pcsmooth.cli.batch_record import Verdict, file_state, verdict_on
from pcsmooth.cli.file_task import Work
from pcsmooth.cli.interrupts import end_when_told
from pcsmooth.cli.sources import Job
from pcsmooth.errors import CloudFileError, PcsmoothError
from pcsmooth.files.notes import COORDINATES, WARNING
from pcsmooth.printable import printable

#: Seconds that the processes have to end when the batch is broken off.
_PATIENCE = 1.0

WHY_SKIPPED: dict[Verdict, str] = {
    "current": "is there and up to date",
    "changed": "is there, changed since it was made; --overwrite makes it anew",
    "unknown": "is there, but not known how it was made; --overwrite makes it anew",
    "older": "is there, older than its input; --overwrite makes it anew",
    "meanwhile": "is there, made meanwhile by another run",
}
"""What is said of results that are left alone."""


@dataclass(frozen=True)
class Done:
    """What became of a file.

    Attributes
    ----------
    job : Job
        Which.
    summary : dict or None
        What was found, ready for JSON; None if it failed or was skipped.
    failure : str
        Why it failed, in one line; empty if it did not.
    messages : list of str
        What was said on the way.
    seconds : float
        Time it took.
    skipped_as : str
        What its result was found to be, if it was skipped.
    source_state : list of int or None
        Size and time of the input before it was read.
    """

    job: Job
    summary: dict[str, Any] | None = None
    failure: str = ""
    messages: list[str] = field(default_factory=list)
    seconds: float = 0.0
    skipped_as: Verdict = "missing"
    source_state: list[int] | None = None

    @property
    def outcome(self) -> str:
        """done, failed or skipped."""
        return "failed" if self.failure else "skipped" if self.summary is None else "done"

    @property
    def remarks(self) -> list[str]:
        """What is to be told of the file even if not everything is, without its name."""
        about = f"{self.job.source}: "
        said = (message.removeprefix(about) for message in self.messages)
        return [message for message in said if message.startswith((WARNING, COORDINATES))]

    @property
    def warnings(self) -> list[str]:
        """What is warned of, without the name of the file."""
        return [
            words.removeprefix(WARNING).strip()
            for words in self.remarks
            if words.startswith(WARNING)
        ]

    @property
    def record(self) -> dict[str, Any]:
        """One line of JSON: the summary, or in its place what came instead."""
        if self.summary is not None:
            return self.summary
        names = (
            {"file": self.job.source}
            if self.job.target is None
            else {"input": self.job.source, "output": self.job.target}
        )
        return names | (
            {"error": self.failure}
            if self.failure
            else {"skipped": True, "why": WHY_SKIPPED[self.skipped_as]}
        )


def results_of(
    work: Work,
    jobs: list[Job],
    note: Callable[[Done], None],
    *,
    processes: int,
    skips_existing: bool,
) -> Generator[Done, None, None]:
    """Work on all files, one or several at a time; results come in the order of the files.

    If a process dies, which ends all others too, the files that may have been its own get one each,
    and those after them new ones.

    Parameters
    ----------
    work : callable
        What to do with a file.
    jobs : list of Job
        The files.
    note : callable
        Is told what became of each as soon as it is known.
    processes : int
        How many are worked on at a time.
    skips_existing : bool
        Whether files whose result is there are left alone, unless it is known to be outdated.

    Yields
    ------
    Done
    """
    attempt = partial(_attempt, work, skips_existing)
    processes = min(processes, len(jobs))
    if processes == 1:
        for job in jobs:
            done = attempt(job)
            note(done)
            yield done
        return

    def note_result(future: Future[Done]) -> None:
        if not future.cancelled() and future.exception() is None:
            note(future.result())

    with _workers(processes) as pool, on_failure(partial(end_children, _PATIENCE)):
        with deaf_to_interrupts():
            waiting = [pool.submit(attempt, job) for job in jobs]
        for future in waiting:
            future.add_done_callback(note_result)
        suspects = processes + 1  # at work, or the next
        later: Generator[Done, None, None] | None = None
        for job, future in zip(jobs, waiting, strict=True):
            if not _died(future):
                yield future.result()
            elif suspects > 0:
                suspects -= 1
                done = _done_alone(attempt, job)
                note(done)
                yield done
            else:
                if later is None:
                    rest = [job for job, other in zip(jobs, waiting, strict=True) if _died(other)]
                    later = results_of(
                        work, rest[processes + 1 :], note, processes=processes,
                        skips_existing=skips_existing,
                    )  # fmt: skip
                yield next(later)


def _died(future: Future[Done]) -> bool:
    """Wait for a file; whether a process died before it was done."""
    return isinstance(future.exception(), BrokenProcessPool)


def _done_alone(attempt: Callable[[Job], Done], job: Job) -> Done:
    """Work on a file, whose process may have died, in one of its own."""
    with _workers(1) as pool:
        try:
            with deaf_to_interrupts():
                future = pool.submit(attempt, job)
            done = future.result()
        except BrokenProcessPool:
            return Done(
                job,
                failure=f"{job.source}: its process was killed, perhaps for lack of memory; "
                "run it alone, or with fewer --jobs",
            )
    told = f"{WARNING} a process was killed, perhaps for lack of memory; done in one of its own"
    return replace(done, messages=[told, *done.messages])


def _workers(processes: int) -> ProcessPoolExecutor:
    return ProcessPoolExecutor(processes, spawning(), end_when_told)


def _attempt(work: Work, skips_existing: bool, job: Job) -> Done:
    """Work on one file; whatever goes wrong is its failure alone."""
    verdict = verdict_on(job) if skips_existing else "missing"
    is_kept = verdict not in ("missing", "outdated") and not job.options.get("overwrite")
    if verdict == "current" or is_kept:
        return Done(job, skipped_as=verdict)
    options = job.options | {"overwrite": True} if verdict == "outdated" else job.options
    messages: list[str] = []
    source_state = file_state(job.source)
    started = time.perf_counter()
    try:
        if job.target is not None:
            _make_folder(Path(job.target).parent)
        summary = work(job.source, job.target, say=messages.append, shows_bar=False, **options)
    except MemoryError:
        return Done(
            job, failure=f"{job.source}: not enough memory; run it alone", messages=messages
        )
    except PcsmoothError as error:
        is_of_result = isinstance(error, CloudFileError) and error.path == job.target
        if (
            skips_existing
            and verdict == "missing"
            and is_of_result
            and verdict_on(job) != "missing"
        ):
            return Done(job, skipped_as="meanwhile", messages=messages)
        return Done(job, failure=_named(str(error), job), messages=messages)
    except Exception as error:
        cause = f"{type(error).__name__}: {error}; please report this"
        return Done(job, failure=_named(cause, job), messages=messages)
    seconds = time.perf_counter() - started
    return Done(job, summary, messages=messages, seconds=seconds, source_state=source_state)


def _make_folder(folder: Path) -> None:
    from pcsmooth.formats.system_errors import named_system_errors

    with named_system_errors(str(folder)):
        folder.mkdir(parents=True, exist_ok=True)


def _named(message: str, job: Job) -> str:
    """Put the file in front of a message, in one line, unless it begins with it or its result."""
    source, target = printable(job.source), printable(job.target or "")
    line = printable(" ".join(message.split()))
    return line if line.startswith((f"{source}:", f"{target}:")) else f"{source}: {line}"
