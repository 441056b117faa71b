"""Grids of heights in text, which hold no coordinates of points."""

from __future__ import annotations

import re

from pcsmooth.errors import CloudFileError

_GRIDS = {
    "an ESRI ASCII grid": re.compile(r"\s*(ncols|nrows)\s+\d+\s*[\r\n]+\s*(ncols|nrows)\s", re.I),
    "a Surfer grid": re.compile(r"\s*DSAA\s"),
    "a GRASS grid": re.compile(r"\s*north:\s*\S+\s*[\r\n]+\s*south:", re.I),
}

_COMMENTS = re.compile(r"(?:\s*+(?:#|//|[%!;])[^\r\n]*+)*+")


def refuse_grid(text: str, path: str) -> None:
    """Raise `CloudFileError` if a text file is a raster grid; says how to get points of it."""
    begin = _COMMENTS.match(text)
    assert begin is not None  # there may be none
    for name, begins in _GRIDS.items():
        if begins.match(text, begin.end()):
            raise CloudFileError(
                path,
                f"it is {name}, a raster without coordinates of points",
                "turn it into points first, such as by gdal_translate -of XYZ grid.asc points.xyz",
            )
