"""What commands say on stderr, in words that they share."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import click

from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.files.notes import Say
from pcsmooth.printable import counted, printable

if TYPE_CHECKING:
    from pcsmooth.files.report import CurvatureReport, DenoiseReport, PointFacts

#: Seconds between two messages about what is compiled.
_SECONDS_BETWEEN = 5.0

COMPILING = "compiling for this machine"
"""How the message begins that says so."""


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

    def announce(compiled: int, count: int) -> None:
        nonlocal said
        if time.monotonic() - said >= _SECONDS_BETWEEN:
            said = time.monotonic()
            say(compiling(compiled, count))

    return announce


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


def say_points(name: str, facts: PointFacts, say: Say, fixed: int = 0) -> None:
    """Say what was read."""
    points = f"{counted(facts.points, 'point')} in {facts.dimension}D"
    say(f"{name}: {', '.join([points, *facts.exceptions_in_words(fixed)])}")


def radius_in_words(report: DenoiseReport | CurvatureReport) -> str:
    """Say which radius was chosen: of local ones the median and the range, and perhaps why."""
    radius, spacing = report.radius, report.spacing
    if report.radius_range is None:
        spacings = radius / spacing if spacing else 0.0
        return f"radius {radius:.6g} ({spacings:.3g}x the mean spacing {spacing:.6g})"
    least, largest = report.radius_range
    words = f"local radius {least:.6g} to {largest:.6g}, median {radius:.6g}"
    if report.sparse_share is None:
        return words
    return f"{words}: one would be too small for {report.sparse_share:.0%} of the surface"
