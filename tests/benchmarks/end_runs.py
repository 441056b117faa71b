"""End runs at random moments, by signals, and look at what is left.

Usage: python end_runs.py [MOMENTS] [SEED]

Prints a table for runs in tiles, in tiles with workers, and batches with jobs, each ended by
SIGKILL, SIGTERM and SIGINT at so many moments: how many ended before they were done, exit statuses,
processes at work 5 s later, outputs that were neither the old nor the new one, and files that the
next run, which must give the right bytes, left beside its result.
"""

from __future__ import annotations

import contextlib
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import psutil
from clouds import noisy_torus

from pcsmooth import PointCloud, write_cloud

#: Points of each cloud.
_COUNT = 6000

_START = (
    "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
    "from pcsmooth.cli.main import run; run()"
)

_EULER = ["--scheme", "euler", "--iterations", "3", "--overwrite", "-q"]

RUNS = {
    "tiles": ["denoise", "a.ply", "-o", "out/a.ply", "--tile", "1500", *_EULER],
    "workers": ["denoise", "a.ply", "-o", "out/a.ply", "--tile", "1500", "--workers", "2", *_EULER],
    "jobs": ["denoise", "a.ply", "b.ply", "c.ply", "--output-dir", "out", "--jobs", "2", *_EULER],
}


def start(folder: Path, arguments: list[str]) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-c", _START, *arguments], cwd=folder, start_new_session=True,
        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip


def at_work(group: int) -> int:
    """Count the processes of a group that have not ended."""
    count = 0
    for each in psutil.process_iter():
        with contextlib.suppress(psutil.NoSuchProcess, ProcessLookupError):
            count += os.getpgid(each.pid) == group and each.status() != psutil.STATUS_ZOMBIE
    return count


def contents(folder: Path) -> dict[str, bytes]:
    """What lies in the folder and in that of the results, other folders by name alone."""
    return {
        str(path.relative_to(folder)): b"" if path.is_dir() else path.read_bytes()
        for path in [*folder.iterdir(), *(folder / "out").iterdir()]
    }


def end_at_moments(folder: Path, arguments: list[str], number: int, moments: int) -> Counter[str]:
    """End a run at random moments; what was found."""
    old = contents(folder)
    began = time.monotonic()
    assert start(folder, arguments).wait() == 0
    duration = time.monotonic() - began
    new = contents(folder)
    found: Counter[str] = Counter()
    for _ in range(moments):
        for path, data in old.items():
            if not (folder / path).is_dir():
                (folder / path).write_bytes(data)
        child = start(folder, arguments)
        time.sleep(duration * random.random())
        if number == signal.SIGINT:
            os.killpg(child.pid, number)
        else:
            child.send_signal(number)
        status = child.wait()
        found[f"status {status}"] += 1
        time.sleep(5.0)
        found["at work"] += at_work(child.pid)
        left = contents(folder)
        found["damaged"] += sum(left.get(path) not in (old[path], new[path]) for path in old)
        found["left at once"] += len(left.keys() - old.keys())
        found["next run failed"] += start(folder, arguments).wait() != 0
        after = contents(folder)
        found["left in the end"] += len(after.keys() - new.keys())
        found["other bytes"] += sum(after.get(path) != data for path, data in new.items())
    return found


def main(moments: int, seed: int) -> None:
    random.seed(seed)
    with tempfile.TemporaryDirectory() as place:
        for name, arguments in RUNS.items():
            for number in (signal.SIGKILL, signal.SIGTERM, signal.SIGINT):
                folder = Path(place) / "work"
                shutil.rmtree(folder, ignore_errors=True)
                (folder / "out").mkdir(parents=True)
                for cloud in ("a", "b", "c"):
                    points, _ = noisy_torus(_COUNT, 0.3, seed=ord(cloud))
                    write_cloud(PointCloud(points), folder / f"{cloud}.ply")
                    if cloud in " ".join(arguments[1:4]):
                        (folder / "out" / f"{cloud}.ply").write_text("old")
                found = end_at_moments(folder, arguments, number, moments)
                print(name, number.name, dict(found), flush=True)


if __name__ == "__main__":
    main(int((sys.argv[1:] or ["30"])[0]), int((sys.argv[2:] or ["0"])[0]))
