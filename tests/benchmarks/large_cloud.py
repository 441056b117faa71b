"""A cloud of any size, written point by point, and what it takes to denoise it in tiles.

Usage: python tests/benchmarks/large_cloud.py COUNT FOLDER [OPTION ...]

Writes FOLDER/cloud.ply, a noisy terrain of COUNT points, denoises it with the options given, and
prints a line: points, tiles, seconds, microseconds a point, and the most memory that was resident.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

_ROWS = 1 << 20

#: Standard deviation of the noise, in spacings.
_NOISE = 0.3


def terrain(count: int) -> Iterator[npt.NDArray[np.float64]]:
    """Points (m, 3) about 1 cm apart on rolling hills, row after row, each with its own noise."""
    side = math.isqrt(count)
    for start in range(0, count, _ROWS):
        rng = np.random.default_rng([count, start])
        number = np.arange(start, min(start + _ROWS, count))
        points = np.empty((len(number), 3))
        points[:, 0] = number % side + rng.random(len(number))
        points[:, 1] = number // side + rng.random(len(number))
        points[:, 2] = 20.0 * np.sin(points[:, 0] / 200.0) * np.cos(points[:, 1] / 150.0)
        points[:, 2] += rng.normal(0.0, _NOISE, len(number))
        yield 0.01 * points


def write_cloud(path: Path, count: int) -> None:
    """Write the terrain to a PLY file of doubles, in bounded memory."""
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {count}\n"
    header += "".join(f"property double {axis}\n" for axis in "xyz") + "end_header\n"
    with path.open("wb") as file:
        file.write(header.encode())
        for points in terrain(count):
            file.write(points.astype("<f8").tobytes())


def main() -> None:
    """Write the cloud, denoise it and print the line."""
    count, folder, options = int(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:]
    source = folder / "cloud.ply"
    write_cloud(source, count)
    started = time.perf_counter()
    command = [sys.executable, "-m", "pcsmooth", "denoise", str(source), "-o"]
    command += [str(folder / "smooth.ply"), "--overwrite", "--json", *options]
    process = subprocess.Popen(command, stdout=subprocess.PIPE)
    output = process.stdout.read() if process.stdout else b""
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - started
    if status != 0:
        raise SystemExit(os.waitstatus_to_exitcode(status))
    tiles = json.loads(output)["tiles"]
    print(
        f"{count} points, {tiles or 'no'} tiles: {seconds:.0f} s, {seconds / count * 1e6:.1f} us a "
        f"point, at most {usage.ru_maxrss / 1e6:.2f} GB resident"
    )


if __name__ == "__main__":
    main()
