"""Rows of a file that are left out since they are outliers, or since they are none."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.files.cloud_input import CloudInput, InputPiece
from pcsmooth.files.writing import Outliers
from pcsmooth.formats.some_rows import refers_to_rows
from pcsmooth.parts.column import Column


def leaves_out(outliers: Outliers) -> bool:
    """Whether rows are left out."""
    return outliers in ("remove", "only")


def check_outliers(template: PointCloud, format: str, path: str, outliers: Outliers) -> None:
    """Find out early whether rows can be left out of a file.

    Parameters
    ----------
    template : PointCloud
        What was read, perhaps without its points.
    format, path : str
        The file that will be written.
    outliers : {"mark", "remove", "only", "class"}
        Which rows are left out.

    Raises
    ------
    CloudFileError
        They cannot, as the file would hold something that names points by their rows.
    """
    if not leaves_out(outliers):
        return
    named = refers_to_rows(template, format)
    if named:
        raise CloudFileError(
            path,
            f"--outliers {outliers} leaves rows out, and {named} would name other points",
            "write .pcd or .xyz, or leave the option out",
        )


def rows_written(source: CloudInput, columns: Mapping[str, Column], outliers: Outliers) -> int:
    """Count the rows that are written.

    Parameters
    ----------
    source : CloudInput
        What was read.
    columns : mapping of str to Column
        Marks of all points that take part: "outlier" and "fixed".
    outliers : {"mark", "remove", "only", "class"}
        Which rows are left out.

    Raises
    ------
    CloudFileError
        None is.
    """
    if not leaves_out(outliers):
        return source.count
    found = 0
    if "outlier" in columns:
        marks, held = columns["outlier"].chunks(), columns["fixed"].chunks()
        for outlier, fixed in zip(marks, held, strict=True):
            found += int(np.count_nonzero(are_treated(outlier, fixed)))
    count = found if outliers == "only" else source.count - found
    if count == 0:
        cause = "no point is an outlier" if outliers == "only" else "all points are outliers"
        raise CloudFileError(
            source.name, f"{cause}, so that nothing is left to write", "leave out --outliers"
        )
    return count


def kept_rows(piece: InputPiece, outliers: Outliers) -> npt.NDArray[np.bool_]:
    """Tell which rows of a piece of the input are written, (n,)."""
    leaving = np.zeros(len(piece.cloud), np.bool_)
    if len(piece.places):
        leaving[piece.places] = are_treated(piece.rows["outlier"], piece.rows["fixed"])
    return leaving if outliers == "only" else ~leaving


def are_treated(
    outlier: npt.NDArray[np.generic], fixed: npt.NDArray[np.generic]
) -> npt.NDArray[np.bool_]:
    """Tell which points are treated as outliers, by their marks (m,): none that is fixed."""
    return np.asarray((outlier != 0) & (fixed == 0))
