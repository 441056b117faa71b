"""What a PCD file holds besides its points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import COLORS
from pcsmooth.formats.pcd.header import PcdHeader
from pcsmooth.formats.typed_rows import OddWords, renumbered

PACKED = {"rgb": COLORS[::-1], "rgba": (*COLORS[::-1], "alpha")}
"""Fields that hold the bytes of a color in one number, and the columns for these, blue first."""


@dataclass(frozen=True)
class PcdLayout:
    """What a PCD file holds besides its points, and how its fields became columns.

    Attributes
    ----------
    header : PcdHeader
        The header as read.
    columns : tuple of tuple of str
        For each field the columns that hold it: one for each item or, of packed colors, for each
        byte; positions under ``x``, ``y``, ``z``; none for padding.
    verbatim : mapping of int to ndarray, each of shape (n, count)
        The values of fields that the columns do not hold in full, by the rank of the field:
        padding and packed colors.
    odd_words : dict
        Numbers that are not finite as text spells them, as `read_fields` gives them.
    """

    header: PcdHeader
    columns: tuple[tuple[str, ...], ...]
    verbatim: Mapping[int, npt.NDArray[Any]]
    odd_words: OddWords

    @property
    def format(self) -> str:
        """Name of the format."""
        return "pcd"

    @property
    def besides(self) -> list[str]:
        """The organisation in rows and the viewpoint, in words."""
        return [] if self.header.is_plain else ["width, height and viewpoint of the PCD file"]

    def of_rows(self, kept: npt.NDArray[np.bool_]) -> PcdLayout:
        """Give the layout of the points (n,) that stay."""
        verbatim = {
            rank: values[kept] if len(values) == len(kept) else values
            for rank, values in self.verbatim.items()
        }
        return replace(self, verbatim=verbatim, odd_words=renumbered(self.odd_words, kept))


def bytes_of(values: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
    """Parts of numbers of 4 bytes, lowest first, as (n, 4)."""
    return np.ascontiguousarray(values).view(np.uint8).copy()
