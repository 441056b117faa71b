"""What the shell is told."""

from enum import IntEnum


class ExitStatus(IntEnum):
    """How a command ended. A reader of stdout that leaves early counts as failed (by click)."""

    OK = 0
    FAILED = 1
    USAGE = 2
    HUNG_UP = 129
    INTERRUPTED = 130
    TERMINATED = 143
