"""When and on what a benchmark ran, in one line."""

import os
import platform
from datetime import UTC, datetime
from pathlib import Path

import numba
import numpy as np


def machine_line() -> str:
    """Day, cores, processor, and the versions that matter to speed."""
    return (
        f"{datetime.now(UTC).date()}: {_cores()} cores, {_processor()}; "
        f"Python {platform.python_version()}, numpy {np.__version__}, numba {numba.__version__}"
    )


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _processor() -> str:
    table = Path("/proc/cpuinfo")
    for line in table.read_text().splitlines() if table.exists() else ():
        name, _, value = line.partition(":")
        if name.strip() == "model name":
            return value.strip()
    return platform.processor() or platform.machine()
