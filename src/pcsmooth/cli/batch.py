"""One command on many files: each on its own, whatever becomes of the others."""

from __future__ import annotations

import json
import os
import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import replace
from typing import Any

import click

from pcsmooth import machine
from pcsmooth.cleanup import on_failure
from pcsmooth.cli.batch_record import BatchRecord
from pcsmooth.cli.batch_report import BatchReport
from pcsmooth.cli.batch_table import Column, table_lines, terminal_width
from pcsmooth.cli.batch_workers import WHY_SKIPPED, Done, results_of
from pcsmooth.cli.file_task import ChosenOptions, FileTask
from pcsmooth.cli.messages import COMPILING, speaker, teller_of_compilation
from pcsmooth.cli.options import STANDARD_STREAM
from pcsmooth.cli.sources import Job, find_sources, is_one_file, plan_jobs
from pcsmooth.errors import PcsmoothError
from pcsmooth.files.notes import WARNING, Say, remove_left_over
from pcsmooth.process_count import fitting_processes

#: Gives the options for each of some files.
OptionsOfFiles = Callable[[list[str]], list[ChosenOptions]]

#: Memory that is taken for each byte of a file: 700 bytes for a point of some 24, as in PLY files
#: with colours or doubles, and in text.
_MEMORY_PER_BYTE = 29


def run_on_files(task: FileTask, options_of: OptionsOfFiles) -> None:
    """Work on the files of a command, one as it is or many as a batch.

    Parameters
    ----------
    task : FileTask
        What to do.
    options_of : callable
        Gives the options for each of some files.

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
        (chosen,) = options_of([source])
        if files.output is not None and files.output != STANDARD_STREAM:
            remove_left_over(os.path.dirname(os.path.realpath(files.output)), say)
        summary = task.work(
            source, files.output, say=say, shows_bar=not task.quiet, **chosen.options
        )
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
        replace(job, options=_with_threads(chosen.options, shared), in_force=chosen.in_force)
        for job, chosen in zip(jobs, options_of(sources), strict=True)
    ]
    for folder in sorted({os.path.dirname(job.target) for job in jobs if job.target is not None}):
        remove_left_over(folder, say)
    run_batch(task, jobs, processes)


def _with_threads(options: dict[str, Any], threads: int | None) -> dict[str, Any]:
    """Give options, if they leave it open, a number of threads."""
    if threads is None or options.get("threads", 1) is not None:
        return options
    return {**options, "threads": threads}


def _largest_size(sources: list[str]) -> int:
    """Size of the largest file, bytes; 0 if there is none."""
    return max((os.path.getsize(source) for source in sources if os.path.isfile(source)), default=0)


def run_batch(task: FileTask, jobs: list[Job], processes: int = 1) -> None:
    """Work on files and tell what became of each, in their order.

    Parameters
    ----------
    task : FileTask
        What to do.
    jobs : list of Job
        The files.
    processes : int
        How many are worked on at a time.

    Raises
    ------
    PcsmoothError
        In the end, if a file failed.
    """
    from tqdm import tqdm

    from pcsmooth.kernels.ahead import compiling_ahead

    started = time.perf_counter()
    say, insist = speaker(task.quiet), speaker(quiet=False)
    folder = task.files.folder
    record = None if folder is None else BatchRecord(folder)
    if record is not None:
        jobs = [replace(job, known=record.of(job)) for job in jobs]
    report = None
    if task.report is not None and folder is not None:
        report = BatchReport(task.report, folder)
        report.check(overwrite=bool(task.options.get("overwrite")))
        jobs = [report.with_pages(job) for job in jobs]
    bar = tqdm(
        total=len(jobs), unit="file", delay=1.0, leave=False, file=sys.stderr,
        disable=True if task.quiet else None,
    )  # fmt: skip
    ended: list[Done] = []  # as they come
    told: list[Done] = []  # in the order of the files

    def say_over_bar(message: str) -> None:
        with bar.external_write_mode(file=sys.stderr):
            say(message)

    def note(done: Done) -> None:
        bar.update()
        if record is not None and done.summary is not None:
            record.note(done.job, done.source_state, done.summary)
        ended.append(done)

    def tell(done: Done) -> None:
        told.append(done)
        with bar.external_write_mode(file=sys.stderr):
            _tell(done, f"[{len(told)}/{len(jobs)}]", task.verbose, say, insist)
        if task.as_json:
            click.echo(json.dumps(done.record))
        elif task.show is not None and done.summary is not None:
            task.show(done.summary)

    def sum_up() -> None:
        bar.close()
        if record is not None and record.failure:
            say(f"{WARNING} {record.failure}: --skip-existing will not know these results")
        _sum_up(told, len(jobs), time.perf_counter() - started, task.columns, say)
        if report is not None:
            report.write_index(jobs, told, task.columns, time.perf_counter() - started)

    def break_off() -> None:
        for done in ended:
            if not any(done is other for other in told):
                tell(done)
        try:
            sum_up()
        except PcsmoothError as error:  # what ended the batch matters more
            insist(f"{WARNING} {error}")

    results = results_of(
        task.work, jobs, note, processes=processes, skips_existing=task.files.skip_existing
    )
    with (
        on_failure(break_off),
        bar,
        compiling_ahead(teller_of_compilation(say_over_bar)),
        closing(results) as ended_in_order,
    ):
        for done in ended_in_order:
            tell(done)
    sum_up()
    failed = sum(bool(done.failure) for done in told)
    if failed:
        raise PcsmoothError(f"{failed} of {len(jobs)} files failed")


def _sum_up(
    told: list[Done], n_files: int, seconds: float, columns: Sequence[Column], say: Say
) -> None:
    """Say what was found of each file, how many came to which end, and what failed."""
    if columns and any(done.summary is not None for done in told):
        say("")
        for line in table_lines(
            [done.job.source for done in told],
            columns,
            [done.outcome if done.summary is None else done.summary for done in told],
            [done.seconds for done in told],
            [len(done.warnings) for done in told],
            terminal_width(),
        ):
            say(line)
        say("")
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
    if verbose:
        for message in done.messages:
            if not message.startswith(COMPILING):  # announced when it began
                say(message)
    else:
        for message in done.remarks:
            say(f"{done.job.source}: {message}")
    if done.failure:
        insist(f"{place} Error: {done.failure}")
    elif done.summary is None:
        say(f"{place} {done.job.source}: skipped, {done.job.target} {WHY_SKIPPED[done.skipped_as]}")
    else:
        target = "" if done.job.target is None else f" -> {done.job.target}"
        say(
            f"{place} {done.job.source}{target}: {done.summary['points']} points, "
            f"{done.seconds:.2f} s"
        )
