"""What batches have made of which files in a folder, and by which options."""

from __future__ import annotations

import json
import os
from contextlib import suppress
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal

import pcsmooth
from pcsmooth.cli.sources import Job
from pcsmooth.errors import CloudFileError

NAME = ".pcsmooth-batch.jsonl"
"""Name of the file in the folder of the results: a line of JSON for each result."""

#: Whether a result is there, and what of.
Verdict = Literal["missing", "current", "outdated", "changed", "unknown", "older", "meanwhile"]


@dataclass(frozen=True)
class ResultRecord:
    """What is known of a result.

    Attributes
    ----------
    result : list
        Size and time of the file, as it was left.
    source : list
        Size and time of the input that it was made from.
    options : dict
        By which options.
    version : str
        Of pcsmooth.
    summary : dict
        What was found.
    """

    result: list[int]
    source: list[int]
    options: dict[str, Any]
    version: str
    summary: dict[str, Any]

    @classmethod
    def of(cls, job: Job, source: list[int] | None, summary: dict[str, Any]) -> ResultRecord | None:
        """Take it from a job that is done; None if its files are gone again, or were no files."""
        assert job.target is not None
        result = file_state(job.target)
        if result is None or source is None:
            return None
        return cls(result, source, job.in_force, pcsmooth.__version__, summary)

    def is_of(self, job: Job) -> bool:
        """Whether a job would make the same of what its input is now."""
        made_by = (self.source, self.options, self.version)
        return made_by == (file_state(job.source), job.in_force, pcsmooth.__version__)


_FIELDS = fields(ResultRecord)


def verdict_on(job: Job) -> Verdict:
    """Say whether the result of a job is there, and whether it is what the job would make.

    Parameters
    ----------
    job : Job
        With what is known of its result.

    Returns
    -------
    {"missing", "current", "outdated", "changed", "unknown", "older"}
        changed: by something else since it was made; unknown: nothing says how it was made; older:
        nor was it made from what the input is now.
    """
    state = None if job.target is None else file_state(job.target)
    if state is None:
        return "missing"
    if job.known is None:
        source = file_state(job.source)
        return "unknown" if source is None or source[1] <= state[1] else "older"
    if job.known.result != state:
        return "changed"
    is_whole = all(map(os.path.exists, job.beside))
    return "current" if is_whole and job.known.is_of(job) else "outdated"


class BatchRecord:
    """The records of the results in a folder.

    Parameters
    ----------
    folder : str
        The folder, which need not exist.

    Attributes
    ----------
    failure : str
        Why a result could not be added; empty if all could.
    """

    def __init__(self, folder: str) -> None:
        self.folder = folder
        self.failure = ""
        self._path = os.path.join(folder, NAME)
        self._known: dict[str, ResultRecord] = {}
        for line in self._lines():
            with suppress(ValueError, TypeError, KeyError, RecursionError):
                facts = json.loads(line)
                known = ResultRecord(**{field.name: facts[field.name] for field in _FIELDS})
                if isinstance(known.summary, dict):
                    self._known[str(facts["name"])] = known

    def _lines(self) -> list[bytes]:
        """Read what is there; a damaged file, or none, tells nothing."""
        from pcsmooth.bodies.small_files import read_small_file

        if os.path.islink(self._path) or not os.path.exists(self._path):
            return []
        try:
            return read_small_file(self._path).splitlines()
        except CloudFileError:
            return []

    def of(self, job: Job) -> ResultRecord | None:
        """Give what is known of the result of a job."""
        return self._known.get(self._name(job))

    def note(self, job: Job, source: list[int] | None, summary: dict[str, Any]) -> None:
        """Add a result, by a line behind the others, so that batches may share the folder.

        If that fails, `failure` says why. `source` is the state of the input before it was read:
        it may have changed since.
        """
        record = ResultRecord.of(job, source, summary)
        if record is None:
            return
        line = json.dumps({"name": self._name(job), **vars(record)})
        # No link is followed, no reader of a pipe waited for: somebody else might have laid it.
        flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND
        flags |= getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
        try:
            number = os.open(self._path, flags, 0o666)
            with open(number, "ab", buffering=0) as file:
                file.write(f"\n{line}\n".encode())  # the line before may have no end
        except OSError as error:
            self.failure = f"{self._path}: cannot be written ({error.strerror})"

    def _name(self, job: Job) -> str:
        assert job.target is not None
        return Path(os.path.relpath(job.target, self.folder)).as_posix()


def file_state(path: str) -> list[int] | None:
    """Size and time of a file; None if there is none."""
    try:
        state = os.stat(path)
    except OSError:
        return None
    return [state.st_size, state.st_mtime_ns]
