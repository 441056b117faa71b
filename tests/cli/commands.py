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

from pcsmooth.cli.main import run

#: Starts the command line as a shell would, even where the tests run with signals ignored.
_START = (
    "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
    "signal.signal(signal.SIGHUP, signal.SIG_DFL); "
    "from pcsmooth.cli.main import run; run()"
)


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
    output, stderr = io.BytesIO(), io.StringIO()
    stdout = io.TextIOWrapper(output, write_through=True)
    with (
        mock.patch.object(sys, "argv", ["pcsmooth", *map(str, arguments)]),
        mock.patch.object(sys.modules["__main__"], "__package__", None),  # names the program
        mock.patch.object(sys, "stdin", io.TextIOWrapper(io.BytesIO(stdin))),
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


def process(*arguments: object, stdin: bytes = b"") -> Finished:
    """Run ``python -m pcsmooth`` to its end."""
    done = subprocess.run(
        [sys.executable, "-m", "pcsmooth", *map(str, arguments)],
        input=stdin,
        capture_output=True,
        timeout=300,
    )
    return Finished(done.returncode, done.stdout, done.stderr.decode())


def start(
    *arguments: object,
    stderr: int = subprocess.PIPE,
    env: Mapping[str, str] | None = None,
    own_group: bool = False,
) -> subprocess.Popen[bytes]:
    """Start the command line in a process that `interrupt` can end; with its own, a group."""
    return subprocess.Popen(
        [sys.executable, "-c", _START, *map(str, arguments)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=stderr,
        env=None if env is None else {**os.environ, **env},
        start_new_session=own_group,
    )


def interrupt(running: subprocess.Popen[bytes]) -> int:
    """Send Ctrl-C to a process and wait for its exit status."""
    running.send_signal(signal.SIGINT)
    return running.wait(timeout=60)
