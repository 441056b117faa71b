"""Processes of the command line that start at once: forked from one that has imported everything.

Each has its own number, streams, signals and, if wanted, group, as one that a shell starts. What
they leave out is what comes before `run()`: for that there is `commands.process`.
"""

from __future__ import annotations

import atexit
import contextlib
import gc
import json
import os
import resource
import select
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Sequence
from functools import cache
from types import TracebackType
from typing import Any, BinaryIO, Self

#: In the place of a stream: a pipe to this process; and none, as behind ``>&-`` in a shell.
PIPE, CLOSED = -1, -2

_MOST_BYTES = 1 << 16


class Running:
    """A command that has been started; a context manager, which waits for its end.

    If the block fails, it ends the command.

    Attributes
    ----------
    pid : int
        Its number.
    stdout, stderr : file or None
        What it says, if that is a pipe.
    returncode : int or None
        How it ended, if that is known: its status, or the signal times -1.
    """

    def __init__(
        self,
        arguments: Sequence[object],
        *,
        stdin: int | None = None,
        stdout: int = PIPE,
        stderr: int = PIPE,
        own_group: bool = False,
        limit: int | None = None,
    ) -> None:
        self.returncode: int | None = None
        self.stdout: BinaryIO | None = None
        self.stderr: BinaryIO | None = None
        streams = [stdin, stdout, stderr]
        with contextlib.ExitStack() as stack:
            null = os.open(os.devnull, os.O_RDWR)
            stack.callback(os.close, null)
            files = [null if each is None or each < 0 else each for each in streams]
            for number, name in ((1, "stdout"), (2, "stderr")):
                if streams[number] == PIPE:
                    ours, files[number] = os.pipe()
                    stack.callback(os.close, files[number])
                    setattr(self, name, os.fdopen(ours, "rb"))
            request = {
                "arguments": [str(each) for each in arguments],
                "folder": os.getcwd(),
                "closed": [number for number, each in enumerate(streams) if each == CLOSED],
                "own_group": own_group,
                "limit": limit,
            }
            self.pid = _ask(request, files)
        self._end = os.pidfd_open(self.pid)

    def send_signal(self, number: int) -> None:
        """Send it a signal, unless it has ended."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        """End it at once."""
        self.send_signal(signal.SIGKILL)

    def poll(self) -> int | None:
        """How it ended, or None."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.wait(0.0)
        return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        """Wait for its end, at most for so many seconds."""
        if self.returncode is None:
            if not select.select([self._end], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired("pcsmooth", timeout or 0.0)
            self.returncode = os.waitstatus_to_exitcode(_ask({"ended": self.pid}))
            os.close(self._end)
        return self.returncode

    def communicate(self, timeout: float | None = None) -> tuple[bytes, bytes]:
        """Read all that it says, and wait for its end."""
        said: dict[str, bytes] = {"stdout": b"", "stderr": b""}

        def read(name: str, stream: BinaryIO) -> None:
            said[name] = stream.read()

        readers = [
            threading.Thread(target=read, args=(name, stream), daemon=True)
            for name, stream in (("stdout", self.stdout), ("stderr", self.stderr))
            if stream is not None and not stream.closed
        ]
        for reader in readers:
            reader.start()
        self.wait(timeout)
        for reader in readers:
            reader.join()
        return said["stdout"], said["stderr"]

    def __enter__(self) -> Self:
        """Give the process itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Wait for its end."""
        if error is not None:
            self.kill()
        for stream in (self.stdout, self.stderr):
            if stream is not None:
                stream.close()
        self.wait()


def _ask(request: dict[str, Any], files: Sequence[int] = ()) -> int:
    """Have the server do something; its answer is a number."""
    server = _server()
    socket.send_fds(server, [json.dumps(request).encode()], files)
    return int(server.recv(_MOST_BYTES))


@cache
def _server() -> socket.socket:
    """Start the process that all others are forked from; it ends with this one."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    program = (
        f"import sys; sys.path[:] = {sys.path!r}; "
        f"from cli.forks import serve; serve({theirs.fileno()})"
    )
    with theirs:
        server = subprocess.Popen(
            [sys.executable, "-c", program],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            pass_fds=[theirs.fileno()],
        )

    def end() -> None:
        ours.close()
        server.wait()

    atexit.register(end)
    return ours


def serve(number: int) -> None:
    """Fork a process for each request that comes through a socket, until it is closed."""
    import cli.preloaded  # noqa: F401
    from pcsmooth.cli.main import run

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # of a terminal: whoever started this decides
    gc.freeze()  # lest every process goes through all that in the end
    with socket.socket(fileno=number) as client:
        while True:
            message, files, _, _ = socket.recv_fds(client, _MOST_BYTES, 3)
            if not message:
                return
            request = json.loads(message)
            if "ended" in request:
                client.send(str(os.waitpid(request["ended"], 0)[1]).encode())
            elif os.fork() == 0:
                _become(request, files)
                client.send(str(os.getpid()).encode())
                break
            for file in files:
                os.close(file)
    run()


def _become(request: dict[str, Any], files: Sequence[int]) -> None:
    """Be as the command that is asked for finds itself when it begins."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # which tests may run without, as under nohup
    if request["own_group"]:
        os.setpgid(0, 0)
    if request["limit"] is not None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (request["limit"], request["limit"]))
    os.chdir(request["folder"])
    for number, file in enumerate(files):
        os.dup2(file, number)
        os.close(file)
    sys.stdout = os.fdopen(1, "w", closefd=False)  # the old one takes it for seekable
    for number in request["closed"]:
        os.close(number)
        setattr(sys, ("stdin", "stdout", "stderr")[number], None)  # as Python has it then
    sys.argv = ["pcsmooth", *request["arguments"]]
