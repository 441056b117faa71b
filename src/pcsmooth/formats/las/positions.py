"""Where the points of a LAS file are: whole steps from an origin."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.coordinates import three_coordinates
from pcsmooth.formats.stored_positions import StoredPositions
from pcsmooth.positions import usable_rows
from pcsmooth.printable import counted

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int32]

INT32 = np.iinfo(np.int32)

#: Steps of new files, as a share of the spacing, and steps that an extent may have at most.
_STEP_SHARE = 1e-4
_MOST_STEPS = 2e9

#: Steps that the origin of a new file is a multiple of.
_ORIGIN_STEPS = 1e6

#: Point format of new files.
_NEW_FORMAT = 6

MADE_AT = slice(26, 94)
"""Where a header has its system, its software, and the day and year in which it was made."""

COMMENTS = ("pcsmooth", 1)
"""The record that holds the comments."""

#: Of new files: no date, so that the same cloud gives the same file.
_NEW = 2 * b"pcsmooth".ljust(32, b"\0") + bytes(4)


@dataclass(frozen=True)
class ExtraDimension:
    """A dimension in the extra bytes of a point.

    Attributes
    ----------
    description : laspy ExtraBytesStruct, or None
        How the file describes it; None if it does not, and these bytes are the last of a point.
    dtype : numpy.dtype
        Type of an item.
    count : int
        Number of items.
    columns : tuple of str
        The columns that hold the items; none if nothing tells what the bytes mean.
    scales, offsets : ndarray of float64, shape (count,), or None
        By which each item is multiplied, and what is added; None if it is as it is.
    raw : ndarray, shape (n, count), or None
        The values in the file, where columns do not hold them as they are.
    """

    description: Any
    dtype: np.dtype[Any]
    count: int
    columns: tuple[str, ...]
    scales: Floats | None = None
    offsets: Floats | None = None
    raw: npt.NDArray[Any] | None = None


@dataclass(frozen=True)
class LasLayout:
    """What a LAS file holds besides its points, and how its dimensions became columns.

    Attributes
    ----------
    format : str
        ``"las"`` or ``"laz"``.
    header : laspy.LasHeader
        The header as read; not to be changed.
    integers : ndarray of int32, shape (n, 3)
        The coordinates in steps, as they are in the file; none of a file without its points.
    made : bytes
        What the header says of its making: by which system and software, and when.
    records, extended : tuple of laspy.VLR
        The records before and after the points.
    extras : tuple of ExtraDimension
        The dimensions in the extra bytes.
    first : int
        Which row of the file the first point is.
    """

    format: str
    header: Any
    integers: Integers
    made: bytes
    records: tuple[Any, ...] = ()
    extended: tuple[Any, ...] = ()
    extras: tuple[ExtraDimension, ...] = ()
    first: int = 0

    @property
    def besides(self) -> list[str]:
        """The records of the file, in words."""
        count = len(self.records) + len(self.extended)
        several = f"{counted(count, 'LAS record')} (such as the coordinate system)"
        return [several] if count else []

    def of_rows(self, kept: npt.NDArray[np.bool_]) -> LasLayout:
        """Give the layout of the points (n,) that stay."""

        def of(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
            return values[kept] if len(values) == len(kept) else values

        extras = tuple(
            extra if extra.raw is None else replace(extra, raw=of(extra.raw))
            for extra in self.extras
        )
        return replace(self, integers=of(self.integers), extras=extras)


def stored_in_las(cloud: PointCloud, path: str) -> StoredPositions:
    """Positions as a LAS file holds them: in the steps of the file, or of a new one.

    Raises
    ------
    CloudFileError
        A point that is not finite or beyond the integers of the file.
    """
    layout = layout_for(cloud)
    xyz = coordinates(in_steps(cloud, layout, path), layout.header)
    scales = layout.header.scales
    steps = f"{scales[0]:.9g}" if np.ptp(scales) == 0.0 else " ".join(f"{s:.9g}" for s in scales)
    is_new = layout is not cloud.layout
    return StoredPositions(
        xyz[:, : cloud.dimension],
        f"LAS positions in steps of {steps}",
        ".ply keeps them",
        f"LAS positions are written in steps of {steps}" if is_new else "",
    )


def check_las(cloud: PointCloud, path: str) -> None:
    """Find out early whether a cloud can be a LAS or LAZ file, whatever the steps.

    Parameters
    ----------
    cloud : PointCloud
        What is to be written.
    path : str
        Name of the file in errors.

    Raises
    ------
    CloudFileError
        A point that is not finite.
    """
    first = cloud.layout.first if isinstance(cloud.layout, LasLayout) else 0
    _check_finite(three_coordinates(cloud), first, path)


def coordinates(integers: Integers, header: Any) -> Floats:
    """Turn steps into coordinates, (n, 3); infinite where the scale of the file is too large."""
    with np.errstate(over="ignore"):
        return np.asarray(integers * header.scales + header.offsets, np.float64)


def layout_for(cloud: PointCloud) -> LasLayout:
    """Layout of the LAS file that the cloud came from, or that of a new one."""
    layout = cloud.layout
    if isinstance(layout, LasLayout) and len(layout.integers) == len(cloud):
        return layout
    if isinstance(layout, LasLayout):  # rows came or went: every point is placed anew
        extras = tuple(replace(extra, raw=None) for extra in layout.extras)
        nothing = np.empty((0, 3), np.int32)
        return replace(layout, integers=nothing, extras=extras)
    return new_layout([cloud])


def new_layout(clouds: Iterable[PointCloud]) -> LasLayout:
    """Layout of a new file for points, in any number of pieces."""
    import laspy

    header = laspy.LasHeader(version="1.4", point_format=_NEW_FORMAT)
    header.scales, header.offsets = _steps(clouds)
    header.global_encoding.wkt = True  # so a coordinate system would be given: the format says so
    return LasLayout("las", header, np.empty((0, 3), np.int32), _NEW)


def _steps(clouds: Iterable[PointCloud]) -> tuple[Floats, Floats]:
    """Choose steps and origin for points: a power of ten, far below the spacing if that fits."""
    count, low, high = 0, np.full(3, np.inf), np.full(3, -np.inf)
    for cloud in clouds:
        xyz = three_coordinates(cloud)
        usable = xyz[usable_rows(xyz)]
        count += len(usable)
        low = np.minimum(low, usable.min(axis=0, initial=np.inf))
        high = np.maximum(high, usable.max(axis=0, initial=-np.inf))
    if not count:
        return np.full(3, 0.001), np.zeros(3)
    a, b, c = extent = high - low
    spacing = np.sqrt((a * b + b * c + c * a) / count) or extent.max() / count
    finest = extent.max() / _MOST_STEPS
    precision = np.abs([low, high]).max() * np.finfo(np.float64).eps or 0.001
    step = 10.0 ** np.floor(np.log10(_STEP_SHARE * spacing)) if spacing > 0.0 else 0.0
    step = max(step, 10.0 ** np.ceil(np.log10(max(finest, precision))))
    offsets = np.round((0.5 * low + 0.5 * high) / (_ORIGIN_STEPS * step)) * _ORIGIN_STEPS * step
    return np.full(3, step), offsets + 0.0  # never -0.0, which would depend on the order of rows


def in_steps(cloud: PointCloud, layout: LasLayout, path: str) -> Integers:
    """Coordinates in steps; points that are where they were keep their integers."""
    xyz = three_coordinates(cloud)
    _check_finite(xyz, layout.first, path)
    scales, offsets = layout.header.scales, layout.header.offsets
    if len(layout.integers) != len(cloud):
        moved, integers = np.ones(len(cloud), np.bool_), np.empty((len(cloud), 3), np.int32)
    else:
        moved = (xyz != coordinates(layout.integers, layout.header)).any(axis=1)
        integers = layout.integers.copy()
    with np.errstate(over="ignore"):
        steps = np.rint((xyz[moved] - offsets) / scales)
    beyond = ((steps < INT32.min) | (steps > INT32.max)).any(axis=1)
    if beyond.any():
        number = layout.first + int(np.flatnonzero(moved)[beyond][0]) + 1
        raise CloudFileError(
            path,
            f"point {number} is beyond the integers of 32 bits in steps of {scales.tolist()} "
            f"from {offsets.tolist()}",
            "write .ply instead",
        )
    integers[moved] = steps.astype(np.int32)
    return integers


def is_comments(record: Any) -> bool:
    """Whether a record of a file holds its comments."""
    return (record.user_id, record.record_id) == COMMENTS


def _check_finite(xyz: Floats, first: int, path: str) -> None:
    finite = np.isfinite(xyz).all(axis=1)
    if not finite.all():
        number = first + int(np.flatnonzero(~finite)[0]) + 1
        raise CloudFileError(
            path,
            f"point {number} is not finite, and LAS holds integers",
            "write .ply instead, or remove the point",
        )
