"""What a file keeps of positions: the numbers that come back when it is read."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.position_type import written_position_type

#: Rounding is much if it takes more than this share of the spacing.
MUCH_ROUNDING = 0.01


@dataclass(frozen=True)
class StoredPositions:
    """Positions as a file will hold them.

    Attributes
    ----------
    points : ndarray of float64, shape (n, d)
        What will be read back, L.
    kind : str
        What kind of positions they are, such as ``"float positions"``.
    remedy : str
        What keeps more digits.
    note : str
        What the user should know in any case; may be empty.
    """

    points: npt.NDArray[np.float64]
    kind: str
    remedy: str
    note: str = ""

    def rounding(self, cloud: PointCloud, rows: npt.NDArray[np.bool_] | None = None) -> float:
        """Largest difference from the finite coordinates of a cloud, or of some of its rows, L."""
        kept, points = self.points, cloud.points
        if rows is not None:
            kept, points = kept[rows], points[rows]
        finite = np.isfinite(points)
        return float(np.abs(kept[finite] - points[finite]).max(initial=0.0))

    def rounding_in_words(self, rounding: float, against: str = "") -> str:
        """Say how far positions are rounded, perhaps against what, and what helps."""
        return (
            f"{self.kind} round these coordinates by up to {rounding:.2g}{against}; {self.remedy}"
        )


def stored_as_floats(cloud: PointCloud, path: str) -> StoredPositions:
    """Positions in a file that has them as float or double.

    Parameters
    ----------
    cloud : PointCloud
        What is to be written.
    path : str
        Name of the file in errors.

    Returns
    -------
    StoredPositions

    Raises
    ------
    CloudFileError
        A coordinate is beyond the numbers of the type.
    """
    written = written_position_type(cloud)
    with np.errstate(over="ignore"):
        points = cloud.points.astype(written)
    if np.any(np.isinf(points) & np.isfinite(cloud.points)):
        raise CloudFileError(path, "float cannot hold such coordinates", "pass --double")
    note = f"positions are {cloud.position_type} in the input; they are written as double"
    return StoredPositions(
        points.astype(np.float64),
        "float positions",
        "--double keeps them",
        note if written != cloud.position_type else "",
    )
