"""The command line, run in this process or in one of its own."""

from __future__ import annotations

import contextlib
import io
import json
import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from unittest import mock

import pytest

from cli.forks import PIPE, Running
from pcsmooth.cli.main import run


class OneWay(io.BytesIO):
    """A stream like a pipe, in which nobody can go back."""

    def seekable(self) -> bool:
        return False

    def seek(self, _offset: int, _whence: int = 0, /) -> int:
        raise io.UnsupportedOperation("seek")

    def tell(self) -> int:
        raise io.UnsupportedOperation("tell")


@dataclass(frozen=True)
class Finished:
    """What a command left behind."""

    status: int
    stdout: bytes
    stderr: str

    @property
    def json(self) -> dict[str, Any]:
        """What stdout says, all of it, as JSON."""
        facts: dict[str, Any] = json.loads(self.stdout)
        return facts


def pcsmooth(*arguments: object, stdin: bytes = b"") -> Finished:
    """Run the command line in this process, warnings being errors."""
    output, stderr = OneWay(), io.StringIO()
    stdout = io.TextIOWrapper(output, write_through=True)
    with (
        mock.patch.object(sys, "argv", ["pcsmooth", *map(str, arguments)]),
        mock.patch.object(sys.modules["__main__"], "__package__", None),  # names the program
        mock.patch.object(sys, "stdin", io.TextIOWrapper(OneWay(stdin))),
        contextlib.redirect_stdout(stdout),
        contextlib.redirect_stderr(stderr),
        pytest.raises(SystemExit) as end,
    ):
        run()
    stdout.flush()
    assert isinstance(end.value.code, int)
    return Finished(end.value.code, output.getvalue(), stderr.getvalue())


def succeeds(*arguments: object, stdin: bytes = b"") -> Finished:
    """Run a command that must end well."""
    finished = pcsmooth(*arguments, stdin=stdin)
    assert finished.status == 0, finished.stderr
    return finished


def process(
    *arguments: object, stdin: bytes = b"", env: Mapping[str, str] | None = None
) -> Finished:
    """Run ``python -m pcsmooth`` to its end, from the first import on."""
    done = subprocess.run(
        [sys.executable, "-m", "pcsmooth", *map(str, arguments)],
        input=stdin,
        capture_output=True,
        env={**os.environ, **(env or {})},
        timeout=300,
    )
    return Finished(done.returncode, done.stdout, done.stderr.decode())


def start(*arguments: object, stderr: int = PIPE, own_group: bool = False) -> Running:
    """Start the command line in a process that `interrupt` can end; with its own, a group."""
    return Running(arguments, stderr=stderr, own_group=own_group)


def forked(
    *arguments: object,
    stdin: int | None = None,
    stdout: int = PIPE,
    stderr: int = PIPE,
    limit: int | None = None,
) -> Finished:
    """Run the command line in a process of its own to its end, with these for its streams.

    With a limit, no file may grow beyond so many bytes.
    """
    with Running(arguments, stdin=stdin, stdout=stdout, stderr=stderr, limit=limit) as child:
        output, said = child.communicate(timeout=120)
        return Finished(child.wait(), output, said.decode())


def interrupt(running: Running) -> int:
    """Send Ctrl-C to a process and wait for its exit status."""
    running.send_signal(signal.SIGINT)
    return running.wait(timeout=60)
