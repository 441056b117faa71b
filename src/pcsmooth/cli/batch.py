"""One command on many files: each on its own, whatever becomes of the others."""

from __future__ import annotations

import json
import os
import sys
import time
from collections import Counter
from collections.abc import Callable, Generator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import click

from pcsmooth import machine
from pcsmooth.child_processes import deaf_to_interrupts, end_children, spawning
from pcsmooth.cleanup import on_failure
from pcsmooth.cli.file_task import FileTask, Work
from pcsmooth.cli.interrupts import end_when_told
from pcsmooth.cli.messages import COMPILING, speaker, teller_of_compilation
from pcsmooth.cli.options import STANDARD_STREAM
from pcsmooth.cli.sources import Job, find_sources, is_one_file, plan_jobs
from pcsmooth.errors import PcsmoothError
from pcsmooth.files.notes import COORDINATES, WARNING, Say, remove_left_over
from pcsmooth.printable import printable
from pcsmooth.process_count import fitting_processes

#: Gives the options for each of some files.
OptionsOfFiles = Callable[[list[str]], list[dict[str, Any]]]

#: Memory that is taken for each byte of a file: 700 bytes for a point of some 24, as in PLY files
#: with colours or doubles, and in text.
_MEMORY_PER_BYTE = 29

#: Seconds that the processes have to end when the batch is broken off.
_PATIENCE = 1.0


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
    """

    job: Job
    summary: dict[str, Any] | None = None
    failure: str = ""
    messages: list[str] = field(default_factory=list)
    seconds: float = 0.0

    @property
    def outcome(self) -> str:
        """done, failed or skipped."""
        return "failed" if self.failure else "skipped" if self.summary is None else "done"

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
        return names | ({"error": self.failure} if self.failure else {"skipped": True})


@dataclass(frozen=True)
class Batch:
    """How a batch is run.

    Attributes
    ----------
    skips_existing : bool
        Whether files whose result is there are left alone.
    processes : int
        Files that are worked on at a time.
    quiet, verbose : bool
        Whether nothing but failures is told, and whether everything is.
    as_json : bool
        Whether a record of each file is printed on stdout.
    """

    skips_existing: bool = False
    processes: int = 1
    quiet: bool = False
    verbose: bool = False
    as_json: bool = False


def run_on_files(task: FileTask, options_of: OptionsOfFiles | None = None) -> None:
    """Work on the files of a command, one as it is or many as a batch.

    Parameters
    ----------
    task : FileTask
        What to do.
    options_of : callable, optional
        Gives the options for each of some files, in place of those of the task.

    Raises
    ------
    PcsmoothError
        If a file failed; of many, when all have been worked on.
    click.UsageError
        If files and options do not go together.
    """
    files = task.files
    if task.as_json and files.output == STANDARD_STREAM:
        raise click.UsageError("--json and -o - both want stdout")
    say = speaker(task.quiet)
    if files.output is not None or (files.folder is None and is_one_file(files.names)):
        (source,) = files.names
        (options,) = _options_of([source], task, options_of)
        if files.output is not None and files.output != STANDARD_STREAM:
            remove_left_over(os.path.dirname(os.path.realpath(files.output)), say)
        summary = task.work(source, files.output, say=say, shows_bar=not task.quiet, **options)
        if task.as_json:
            click.echo(json.dumps(summary))
        elif task.show is not None:
            task.show(summary)
        return
    found = find_sources(files.names, recursive=files.recursive, output=files.folder)
    sources = [source.path for source in found]
    jobs = (
        [Job(source, None) for source in sources]
        if files.folder is None
        else plan_jobs(found, files.folder, files.suffix)
    )
    processes = files.jobs
    if processes > 1:
        processes = fitting_processes(
            "--jobs", processes, _MEMORY_PER_BYTE * _largest_size(sources), say
        )
    shared = max(1, machine.cores() // processes) if processes > 1 else None
    jobs = [
        replace(job, options=_with_threads(options, shared))
        for job, options in zip(jobs, _options_of(sources, task, options_of), strict=True)
    ]
    for folder in sorted({os.path.dirname(job.target) for job in jobs if job.target is not None}):
        remove_left_over(folder, say)
    batch = Batch(files.skip_existing, processes, task.quiet, task.verbose, task.as_json)
    run_batch(task.work, jobs, batch, task.show)


def _options_of(
    sources: list[str], task: FileTask, options_of: OptionsOfFiles | None
) -> list[dict[str, Any]]:
    return [task.options] * len(sources) if options_of is None else options_of(sources)


def _with_threads(options: dict[str, Any], threads: int | None) -> dict[str, Any]:
    """Give options, if they leave it open, a number of threads."""
    if threads is None or options.get("threads", 1) is not None:
        return options
    return {**options, "threads": threads}


def _largest_size(sources: list[str]) -> int:
    """Size of the largest file, bytes; 0 if there is none."""
    return max((os.path.getsize(source) for source in sources if os.path.isfile(source)), default=0)


def run_batch(
    work: Work,
    jobs: list[Job],
    batch: Batch,
    show: Callable[[dict[str, Any]], None] | None = None,
) -> None:
    """Work on files and tell what became of each, in their order.

    Parameters
    ----------
    work : callable
        What to do with a file; a function that other processes can import.
    jobs : list of Job
        The files.
    batch : Batch
        How.
    show : callable, optional
        Prints a summary on stdout, unless it is to be JSON.

    Raises
    ------
    PcsmoothError
        In the end, if a file failed.
    """
    from tqdm import tqdm

    from pcsmooth.kernels.ahead import compiling_ahead

    started = time.perf_counter()
    say, insist = speaker(batch.quiet), speaker(quiet=False)
    bar = tqdm(
        total=len(jobs), unit="file", delay=1.0, leave=False, file=sys.stderr,
        disable=True if batch.quiet else None,
    )  # fmt: skip
    ended: list[Done] = []  # as they come
    told: list[Done] = []  # in the order of the files

    def say_over_bar(message: str) -> None:
        with bar.external_write_mode(file=sys.stderr):
            say(message)

    def note(done: Done) -> None:
        bar.update()
        ended.append(done)

    def tell(done: Done) -> None:
        told.append(done)
        with bar.external_write_mode(file=sys.stderr):
            _tell(done, f"[{len(told)}/{len(jobs)}]", batch.verbose, say, insist)
        if batch.as_json:
            click.echo(json.dumps(done.record))
        elif show is not None and done.summary is not None:
            show(done.summary)

    def sum_up() -> None:
        bar.close()
        _sum_up(told, len(jobs), time.perf_counter() - started, say)

    def break_off() -> None:
        for done in ended:
            if not any(done is other for other in told):
                tell(done)
        sum_up()

    with (
        on_failure(break_off),
        bar,
        compiling_ahead(teller_of_compilation(say_over_bar)),
        closing(_results(work, jobs, batch, note)) as results,
    ):
        for done in results:
            tell(done)
    sum_up()
    failed = sum(bool(done.failure) for done in told)
    if failed:
        raise PcsmoothError(f"{failed} of {len(jobs)} files failed")


def _sum_up(told: list[Done], n_files: int, seconds: float, say: Say) -> None:
    """Say how many files came to which end, and what failed."""
    counts = Counter(done.outcome for done in told)
    left = n_files - len(told)
    say(
        f"{n_files} files: {counts['done']} done, {counts['skipped']} skipped, "
        f"{counts['failed']} failed{f', {left} not done' if left else ''}, in {seconds:.1f} s"
    )
    for done in told:
        if done.failure:
            say(f"  {done.failure}")


def _tell(
    done: Done,
    place: str,
    verbose: bool,
    say: Say,
    insist: Say,
) -> None:
    """Tell of a file: one line, warnings, and everything if that is wanted."""
    about = f"{done.job.source}: "
    for message in done.messages:
        if message.startswith(COMPILING):
            continue  # announced when it began
        if verbose:
            say(message)
        elif message.removeprefix(about).startswith((WARNING, COORDINATES)):
            say(about + message.removeprefix(about))
    if done.failure:
        insist(f"{place} Error: {done.failure}")
    elif done.summary is None:
        say(f"{place} {done.job.source}: skipped, {done.job.target} is there")
    else:
        target = "" if done.job.target is None else f" -> {done.job.target}"
        say(
            f"{place} {done.job.source}{target}: {done.summary['points']} points, "
            f"{done.seconds:.2f} s"
        )


def _results(
    work: Work,
    jobs: list[Job],
    batch: Batch,
    note: Callable[[Done], None],
) -> Generator[Done, None, None]:
    """Work on all files, one or several at a time; results come in the order of the files.

    Each is noted as soon as it is there. If a process dies, which ends all others too, the files
    that may have been its own get one each, and those after them new ones.
    """
    task = partial(_attempt, work, batch.skips_existing)
    processes = min(batch.processes, len(jobs))
    if processes == 1:
        for job in jobs:
            done = task(job)
            note(done)
            yield done
        return

    def note_result(future: Future[Done]) -> None:
        if not future.cancelled() and future.exception() is None:
            note(future.result())

    with _workers(processes) as pool, on_failure(partial(end_children, _PATIENCE)):
        with deaf_to_interrupts():
            waiting = [pool.submit(task, job) for job in jobs]
        for future in waiting:
            future.add_done_callback(note_result)
        suspects = processes + 1  # at work, or the next
        later: Generator[Done, None, None] | None = None
        for job, future in zip(jobs, waiting, strict=True):
            if not _died(future):
                yield future.result()
            elif suspects > 0:
                suspects -= 1
                done = _done_alone(task, job)
                note(done)
                yield done
            else:
                if later is None:
                    rest = [job for job, other in zip(jobs, waiting, strict=True) if _died(other)]
                    later = _results(work, rest[processes + 1 :], batch, note)
                yield next(later)


def _died(future: Future[Done]) -> bool:
    """Wait for a file; whether a process died before it was done."""
    return isinstance(future.exception(), BrokenProcessPool)


def _done_alone(task: Callable[[Job], Done], job: Job) -> Done:
    """Work on a file, whose process may have died, in one of its own."""
    with _workers(1) as pool:
        try:
            with deaf_to_interrupts():
                future = pool.submit(task, job)
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
    if skips_existing and job.target is not None and os.path.exists(job.target):
        return Done(job)
    messages: list[str] = []
    started = time.perf_counter()
    try:
        if job.target is not None:
            _make_folder(Path(job.target).parent)
        summary = work(job.source, job.target, say=messages.append, shows_bar=False, **job.options)
    except MemoryError:
        return Done(
            job, failure=f"{job.source}: not enough memory; run it alone", messages=messages
        )
    except PcsmoothError as error:
        return Done(job, failure=_named(str(error), job), messages=messages)
    except Exception as error:
        cause = f"{type(error).__name__}: {error}; please report this"
        return Done(job, failure=_named(cause, job), messages=messages)
    return Done(job, summary, messages=messages, seconds=time.perf_counter() - started)


def _make_folder(folder: Path) -> None:
    from pcsmooth.formats.system_errors import named_system_errors

    with named_system_errors(str(folder)):
        folder.mkdir(parents=True, exist_ok=True)


def _named(message: str, job: Job) -> str:
    """Put the file in front of a message, in one line, unless it begins with it or its result."""
    source, target = printable(job.source), printable(job.target or "")
    line = printable(" ".join(message.split()))
    return line if line.startswith((f"{source}:", f"{target}:")) else f"{source}: {line}"
