"""Run random command lines with random preset files, and print how they end as a Markdown table.

Every command must end with status 0, 1 or 2 and, unless that is 0, with one line that says what is
wrong. Any other exception, a warning, five minutes of CPU time, and control characters are
failures, which are printed; then the exit code is 1.
Usage: python fuzz_commands.py [--runs N] [--seed SEED] [--only INDEX]
"""

import argparse
import multiprocessing
import sys
import time
from collections import Counter, defaultdict
from concurrent.futures import ProcessPoolExecutor
from functools import partial

from fuzz_command_trial import Ending, command_trial, judged_command, shown
from fuzz_table import print_endings, print_failures
from machine import machine_line
from tables import heading

PROCESSES = 2


def main() -> int:
    """Run what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", type=int, metavar="INDEX", help="judge this one and no other")
    chosen = parser.parse_args()
    if chosen.only is not None:
        ending = judged_command(command_trial(chosen.seed, chosen.only))
        case = shown(command_trial(chosen.seed, chosen.only))
        print(case, ending.kind, ending.detail.encode(errors="backslashreplace").decode(), sep="\n")
        return ending.failed

    started = time.perf_counter()
    counts: Counter[tuple[str, str]] = Counter()
    failures: defaultdict[str, list[int]] = defaultdict(list)
    # Processes of an executor may start others, as commands do.
    spawning = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(PROCESSES, mp_context=spawning) as pool:
        judge = partial(_judge, chosen.seed)
        for index, command, ending in pool.map(judge, range(chosen.runs)):
            counts[command, "failed" if ending.failed else ending.kind] += 1
            if ending.failed:
                failures[ending.kind].append(index)
    seconds = time.perf_counter() - started

    heading(
        "Command lines",
        machine_line(),
        f"{chosen.runs} command lines, seed {chosen.seed}, {seconds:.0f} s in {PROCESSES} "
        "processes",
    )
    print_endings(
        counts,
        ("command", "runs", "done", "failed cleanly", "wrong usage", "failures"),
        ("status 0", "status 1", "status 2", "failed"),
    )
    print_failures(failures, chosen.seed)
    return 1 if failures else 0


def _judge(seed: int, index: int) -> tuple[int, str, Ending]:
    case = command_trial(seed, index)
    return index, case.command, judged_command(case)


if __name__ == "__main__":
    sys.exit(main())
