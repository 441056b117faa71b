"""What is said on the way, in words that commands share."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pcsmooth.cloud import PointCloud

#: Takes each message.
Say = Callable[[str], object]

WARNING = "warning:"
COORDINATES = "coordinates:"
"""How messages begin, behind the name of a file if they have one, that no batch leaves out."""


def say_coordinates(cloud: PointCloud, name: str, say: Say) -> None:
    """Say which columns of a text file are the coordinates."""
    from pcsmooth.formats import coordinate_columns

    columns = coordinate_columns(cloud)
    numbered = "columns " if all(map(str.isdecimal, columns)) else ""
    say(f"{name}: {COORDINATES} {numbered}{', '.join(columns)}")


def say_warnings(cloud: PointCloud, name: str, say: Say) -> None:
    """Say what the reader of a file found amiss."""
    for warning in cloud.warnings:
        say(f"{name}: {WARNING} {warning}")


def remove_left_over(folder: str, say: Say) -> None:
    """Remove from a folder, if it is there, what runs have left that were killed."""
    from pcsmooth.temporaries import remove_abandoned

    removed = remove_abandoned(folder)
    if removed:
        what = "temporary file or folder" if len(removed) == 1 else "temporary files and folders"
        say(f"{folder}: removed {len(removed)} {what} of runs that were killed")
