"""What a text file of points holds besides its values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.formats.text.dialect import plain_name
from pcsmooth.formats.text.encoding import readable
from pcsmooth.formats.typed_rows import renumbered

HEADERLESS = frozenset({"xyz", "xy", "pts"})
"""Formats whose readers expect nothing but numbers."""


@dataclass(frozen=True)
class TextLayout:
    """How a text file was written, so that it can be written alike.

    Attributes
    ----------
    format : str
        Name of the format, such as ``"xyz"``.
    delimiter : str
        What stands between columns.
    names : tuple of str
        Every column of the file in order: ``x``, ``y``, ``z`` for the positions, and the keys of
        ``PointCloud.columns``.
    labels : tuple of str
        The same columns as spelled in the header; empty if there was none.
    header_mark : str
        What stood before the header.
    blocks : tuple of int
        Numbers of rows that follow one another, each block below a line that counts them; empty
        if there was none.
    comments, comments_below : tuple of (str, str)
        Each comment above the first row and after it, and the line that held it.
    decimal_commas : frozenset of str
        Columns of words whose decimals had a comma, and the positions if theirs had.
    odd_rows : dict of int to tuple of str
        Coordinates of rows that are not finite as they are spelled, rows increasing.
    """

    format: str
    delimiter: str
    names: tuple[str, ...]
    labels: tuple[str, ...] = ()
    header_mark: str = ""
    blocks: tuple[int, ...] = ()
    comments: tuple[tuple[str, str], ...] = ()
    comments_below: tuple[tuple[str, str], ...] = ()
    decimal_commas: frozenset[str] = frozenset()
    odd_rows: Mapping[int, tuple[str, ...]] = field(default_factory=dict)

    @property
    def besides(self) -> list[str]:
        """Nothing: what is no point is a comment or the name of a column."""
        return []

    def of_rows(self, kept: npt.NDArray[np.bool_]) -> TextLayout:
        """Give the layout of the rows (n,) that stay."""
        return replace(self, odd_rows=renumbered(self.odd_rows, kept))


def coordinate_columns(cloud: PointCloud) -> list[str]:
    """Columns of a file that hold the coordinates.

    Parameters
    ----------
    cloud : PointCloud
        What was read.

    Returns
    -------
    list of str
        Names, as the header of a text file spells them, or numbers from 1 if it has none.
    """
    axes = "xyz"[: cloud.dimension]
    layout = cloud.layout
    if not isinstance(layout, TextLayout):
        return list(axes)
    places = map(layout.names.index, axes)
    return [readable(plain_name(layout.labels[p])) if layout.labels else str(p + 1) for p in places]
