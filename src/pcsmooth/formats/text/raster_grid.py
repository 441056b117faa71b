"""Grids of heights in text, which hold no coordinates of points."""

from __future__ import annotations

import re
from collections.abc import Iterable
from itertools import dropwhile, islice

from pcsmooth.errors import CloudFileError

_GRIDS = {
    "an ESRI ASCII grid": re.compile(r"\s*(ncols|nrows)\s+\d+\s*[\r\n]+\s*(ncols|nrows)\s", re.I),
    "a Surfer grid": re.compile(r"\s*DSAA\s"),
    "a GRASS grid": re.compile(r"\s*north:\s*\S+\s*[\r\n]+\s*south:", re.I),
}

_IS_COMMENT = re.compile(r"\s*(?:#|//|[%!;]|\Z)")
"""How comments begin, and blank lines."""

_FIRST_LINES = 16
"""Lines behind the comments that are enough to know a grid by."""


def refuse_grid(lines: Iterable[str], path: str) -> None:
    """Raise `CloudFileError` if a text file is a raster grid; says how to get points of it."""
    head = "\n".join(islice(dropwhile(_IS_COMMENT.match, lines), _FIRST_LINES))
    for name, begins in _GRIDS.items():
        if begins.match(head):
            raise CloudFileError(
                path,
                f"it is {name}, a raster without coordinates of points",
                "turn it into points first, such as by gdal_translate -of XYZ grid.asc points.xyz",
            )
