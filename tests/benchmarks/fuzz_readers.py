"""Read damaged files of every format, and print what becomes of them as a Markdown table.

Every input must become a cloud, which is then written and read again and must be the same, or an
error that names the file. Any other exception, a warning, more time or memory than the size of
the file explains, and a changed cloud are failures: they are kept in a folder, and the exit code
is 1. Usage: python fuzz_readers.py [--inputs N] [--seed SEED] [--only INDEX] [--out DIR]
"""

import argparse
import sys
import time
from collections import Counter, defaultdict
from pathlib import Path

from fuzz_table import SHOWN, print_endings, print_failures
from fuzz_trial import CPU_SECONDS, MEMORY_BESIDE, MEMORY_PER_BYTE, judged, trial
from fuzz_workers import verdicts
from machine import machine_line
from tables import heading

PROCESSES = 2


def main() -> int:
    """Run what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--inputs", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", type=int, metavar="INDEX", help="judge this input and no other")
    parser.add_argument("--out", type=Path, default=Path("out/fuzz"))
    chosen = parser.parse_args()
    if chosen.only is not None:
        return _one(chosen.seed, chosen.only, chosen.out)

    started = time.perf_counter()
    counts: Counter[tuple[str, str]] = Counter()
    failures: defaultdict[str, list[int]] = defaultdict(list)
    for index, format, verdict in verdicts(chosen.seed, chosen.inputs, PROCESSES):
        counts[format, "failed" if verdict.failed else verdict.kind] += 1
        if verdict.failed:
            failures[verdict.kind].append(index)
            if len(failures[verdict.kind]) <= SHOWN:
                _keep(chosen.out, chosen.seed, index, verdict.detail)
    seconds = time.perf_counter() - started

    heading(
        "Damaged files",
        machine_line(),
        f"{chosen.inputs} inputs, seed {chosen.seed}, {seconds:.0f} s in {PROCESSES} processes; "
        f"at most {CPU_SECONDS:g} s and {MEMORY_BESIDE >> 20} MiB + {MEMORY_PER_BYTE} x the size "
        "of the file each",
    )
    print_endings(
        counts,
        ("format", "inputs", "clouds", "clean errors", "failures"),
        ("cloud", "error", "failed"),
    )
    print_failures(failures, chosen.seed, f"; kept in {chosen.out}")
    return 1 if failures else 0


def _one(seed: int, index: int, folder: Path) -> int:
    verdict = judged(trial(seed, index))
    print(verdict.kind, verdict.detail, sep="\n")
    if verdict.failed:
        print("kept as", _keep(folder, seed, index, verdict.detail))
    return verdict.failed


def _keep(folder: Path, seed: int, index: int, detail: str) -> Path:
    case = trial(seed, index)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{seed}-{index}.{case.format}"
    path.write_bytes(case.data)
    log = f"dim={case.dim} sniffed={case.sniffed}\n{detail}"
    path.with_suffix(".log").write_text(log, errors="backslashreplace")
    return path


if __name__ == "__main__":
    sys.exit(main())
