"""Wall time and peak memory, of work in this process and of whole commands.

A process starts with the peak memory of the one that started it. So commands are started by a
small process: this file as a script, which prints what it measured as JSON.
Usage: python measuring.py COMMAND [ARGUMENT ...]
"""

import json
import os
import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

#: Bytes in the unit of ru_maxrss.
_PEAK_UNIT = 1 if sys.platform == "darwin" else 1024


@dataclass(frozen=True)
class CommandRun:
    """Wall time, peak resident memory and standard output of a command that has ended well."""

    seconds: float
    peak_bytes: int
    output: str


def wall_seconds(work: Callable[[], object]) -> float:
    """Wall time of some work."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def median_seconds(*works: Callable[[], object], repeats: int = 3) -> list[float]:
    """Median wall time of each work; they take turns, so that all see the same machine."""
    rounds = [[wall_seconds(work) for work in works] for _ in range(repeats)]
    return [statistics.median(times) for times in zip(*rounds, strict=True)]


def run_command(*command: str, environment: Mapping[str, str] | None = None) -> CommandRun:
    """Run a command and measure it; the environment is added to this process's own."""
    done = subprocess.run(
        [sys.executable, "-S", __file__, *command],
        env={**os.environ, **(environment or {})},
        stdout=subprocess.PIPE,
        check=True,
    )
    return CommandRun(**json.loads(done.stdout))


def peak_bytes() -> int:
    """Most memory that this process has had resident."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * _PEAK_UNIT


def resident_bytes() -> int:
    """Memory that this process has resident now (where that is unknown, its peak)."""
    pages = Path("/proc/self/statm")
    if not pages.exists():
        return peak_bytes()
    return int(pages.read_text().split()[1]) * resource.getpagesize()


def _measure(command: list[str]) -> CommandRun:
    start = time.perf_counter()
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        output = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.perf_counter() - start
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise subprocess.CalledProcessError(process.returncode, command)
    return CommandRun(seconds, usage.ru_maxrss * _PEAK_UNIT, output)


if __name__ == "__main__":
    print(json.dumps(asdict(_measure(sys.argv[1:]))))
