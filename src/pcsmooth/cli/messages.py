"""What commands say on stderr, in words that they share."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.point_counts import exceptions_in_words
from pcsmooth.printable import printable

if TYPE_CHECKING:
    from pcsmooth.cloud import PointCloud

Say = Callable[[str], None]

#: Seconds between two messages about what is compiled.
_SECONDS_BETWEEN = 5.0

COMPILING = "compiling for this machine"
"""How the message begins that says so."""

WARNING = "warning:"
COORDINATES = "coordinates:"
"""How messages begin, behind the name of a file if they have one, that no batch leaves out."""


def speaker(quiet: bool) -> Say:
    """Return a function that prints a line on stderr, unless the command is to be quiet."""

    def say(message: str) -> None:
        if not quiet:
            click.echo(printable(message), err=True)

    return say


@contextmanager
def computing(name: str, say: Say, union: str | None = None) -> Iterator[None]:
    """Announce compilation; what cannot be computed becomes an error of the file.

    `union` is how that of polyhedra is computed, if there are any.
    """
    from pcsmooth.kernels.ahead import compiling_ahead

    with compiling_ahead(teller_of_compilation(say), union):
        try:
            yield
        except InvalidInputError as error:
            cause, _, remedy = str(error).partition("; ")
            raise CloudFileError(name, cause, remedy or "choose another option") from error


def teller_of_compilation(say: Say) -> Callable[[int, int], None]:
    """Return a function that says how many kernels have been compiled, now and then."""
    said = -_SECONDS_BETWEEN

    def tell(compiled: int, count: int) -> None:
        nonlocal said
        if time.monotonic() - said >= _SECONDS_BETWEEN:
            said = time.monotonic()
            say(compiling(compiled, count))

    return tell


def compiling(compiled: int, count: int) -> str:
    """Say that kernels are compiled, and what helps if that will be so in every run."""
    from pcsmooth.kernels.cache import why_not_kept

    reason = why_not_kept()
    when = "first run only"
    if reason:
        when = (
            f"in every run, as nothing is kept: {reason}; set NUMBA_CACHE_DIR to a folder that you "
            "alone may write"
        )
    return f"{COMPILING} ({when}): {compiled} of {count} kernels ..."


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


def say_points(summary: dict[str, Any], say: Say) -> None:
    """Say what was read."""
    points = f"{summary['points']} points in {summary['dimension']}D"
    say(f"{summary['input']}: {', '.join([points, *exceptions_in_words(summary)])}")


def filled_in_words(summary: dict[str, Any]) -> str:
    """Say why a cloud without a surface is left alone."""
    flat = summary["dimension"] == 2
    surface, filled = ("curve", "an area") if flat else ("surface", "a volume")
    return f"no {surface} shows at any scale, the points fill {filled}"


def radius_in_words(summary: dict[str, Any]) -> str:
    """Say which radius was chosen."""
    spacings = summary["radius"] / summary["spacing"] if summary["spacing"] else 0.0
    return (
        f"radius {summary['radius']:.6g} ({spacings:.3g}x the mean spacing "
        f"{summary['spacing']:.6g})"
    )
