"""What a text file of points holds besides its values."""

from __future__ import annotations

from dataclasses import dataclass

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
    counted : bool
        Whether the file had a count line.
    comments, comments_below : tuple of (str, str)
        Each comment above the first row and after it, and the line that held it.
    """

    format: str
    delimiter: str
    names: tuple[str, ...]
    labels: tuple[str, ...] = ()
    header_mark: str = ""
    counted: bool = False
    comments: tuple[tuple[str, str], ...] = ()
    comments_below: tuple[tuple[str, str], ...] = ()

    @property
    def besides(self) -> list[str]:
        """Nothing: what is no point is a comment or the name of a column."""
        return []
