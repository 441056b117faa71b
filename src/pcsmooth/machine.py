"""What this process may take of the machine."""

import os

#: Where Linux says what a container may take.
_CONTAINER_LIMIT = "/sys/fs/cgroup/memory.max"


def cores() -> int:
    """Count the cores that this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def memory() -> int:
    """Tell the memory of the machine, or of the container that this runs in, in bytes."""
    physical = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    try:
        with open(_CONTAINER_LIMIT, encoding="ascii") as file:
            return min(physical, int(file.read()))
    except (OSError, ValueError):
        return physical  # no container, or one without a limit, which it calls max
