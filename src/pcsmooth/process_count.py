"""How many processes share the work."""

from collections.abc import Callable

from pcsmooth import machine

#: Memory that a process takes before it has a cloud, bytes: measured 190 MB.
_BYTES_PER_PROCESS = 200_000_000

#: Largest share of the memory that they take together.
_LARGEST_SHARE = 0.5


def fitting_processes(
    option: str, wanted: int, memory_of_each: int, say: Callable[[str], object]
) -> int:
    """Count the processes that there are cores and memory for, one at least.

    Parameters
    ----------
    option : str
        What asks for them.
    wanted : int
        How many are asked for.
    memory_of_each : int
        What the work of each takes, bytes.
    say : callable
        Told if they are fewer.
    """
    memory = int(_LARGEST_SHARE * machine.memory())
    limits = {
        "as many as there are cores": machine.cores(),
        "as memory allows": max(1, memory // (_BYTES_PER_PROCESS + memory_of_each)),
    }
    reason, most = min(limits.items(), key=lambda limit: limit[1])
    if most < wanted:
        say(f"{option} {wanted}: {most} at a time, {reason}")
    return min(wanted, most)
