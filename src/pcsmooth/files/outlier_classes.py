"""Outliers by the noise classes of LAS: 7, and 18 for high ones."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.denoising import Denoised
from pcsmooth.errors import CloudFileError
from pcsmooth.files.outlier_rows import are_treated
from pcsmooth.files.output_columns import numbers_of
from pcsmooth.filters.high_outliers import high_outliers
from pcsmooth.parts.column import Column

_LOW, _HIGH = 7, 18

#: Where LAS has them, and the formats that do.
_NAME, _FORMATS = "classification", ("las", "laz")


@dataclass(frozen=True)
class ClassCounts:
    """How many outliers got which class.

    Attributes
    ----------
    class_7, class_18 : int
        Noise, and such as lies above the surface.
    """

    class_7: int
    class_18: int


def check_classes(format: str, path: str) -> None:
    """Raise `CloudFileError` if a file of a format has no classes."""
    if format not in _FORMATS:
        raise CloudFileError(
            path,
            f"--outliers class is for LAS and LAZ, and {format} files have no classes",
            "pass --outliers mark",
        )


def classes_of_outliers(denoised: Denoised) -> tuple[Column, ClassCounts]:
    """Find the class of each outlier but those that are fixed; of all other points it is 0.

    Parameters
    ----------
    denoised : Denoised
        By a filter, which finds outliers.
    """
    parts, outliers = denoised.parts, denoised.columns["outlier"]
    is_high = high_outliers(denoised.moved.state.points, outliers)
    classes = parts.create("outlier_class", np.uint8)
    first = before = high = low = 0
    for marks, fixed in zip(outliers.chunks(), parts.fixed.chunks(), strict=True):
        found = np.zeros(len(marks), np.uint8)
        rows = np.flatnonzero(marks)
        found[rows] = np.where(is_high[before : before + len(rows)], _HIGH, _LOW)
        found[~are_treated(marks, fixed)] = 0
        low += int(np.count_nonzero(found == _LOW))
        high += int(np.count_nonzero(found == _HIGH))
        classes.write(first, found)
        first, before = first + len(marks), before + len(rows)
    return classes, ClassCounts(low, high)


def with_classes(
    cloud: PointCloud, path: str, places: npt.NDArray[np.int64], classes: npt.NDArray[np.uint8]
) -> PointCloud:
    """Give rows of a cloud their classes.

    Parameters
    ----------
    cloud : PointCloud
        Some rows as they came, of which there may be no classes.
    path : str
        The file that they come from, for messages.
    places : ndarray of int, shape (m,)
        Some of them.
    classes : ndarray of uint8, shape (m,)
        Their new classes; those of 0 keep what they have.

    Raises
    ------
    CloudFileError
        The cloud has a column of that name with anything but whole numbers from 0 to 255.
    """
    after = np.zeros(len(cloud), np.uint8)
    if _NAME in cloud.columns:
        before = numbers_of(cloud.columns[_NAME])
        if before is None or not np.isin(before, np.arange(256)).all():
            raise CloudFileError(
                path,
                f"its column '{_NAME}' is not of whole numbers from 0 to 255, so that it cannot "
                "take classes",
                "rename it, or pass --outliers mark",
            )
        after = before.astype(np.uint8)
    after[places[classes != 0]] = classes[classes != 0]
    return replace(cloud, columns={**cloud.columns, _NAME: after})
