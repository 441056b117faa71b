"""Points selected by an expression, a box, or both."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.files.where import Where

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from pcsmooth.cloud import PointCloud

_SIZES = (4, 6)


@dataclass(frozen=True)
class Selection:
    """Which points are selected: those that are by all that is given.

    Attributes
    ----------
    where : Where or None
        An expression.
    box : tuple of float or None
        Least coordinates, then largest, L: four numbers for x and y, six for x, y and z. Its
        boundary belongs to it.

    Raises
    ------
    InvalidInputError
        If there are not so many numbers, or one that should be least is larger or NaN.
    """

    where: Where | None = None
    box: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        """Check the box."""
        if self.box is None:
            return
        half = len(self.box) // 2
        if len(self.box) not in _SIZES or not all(
            low <= high for low, high in zip(self.box[:half], self.box[half:], strict=True)
        ):
            raise InvalidInputError(
                f"a box is XMIN,YMIN,XMAX,YMAX or XMIN,YMIN,ZMIN,XMAX,YMAX,ZMAX, not {self._box}"
            )

    def selected(self, cloud: PointCloud, path: str) -> npt.NDArray[np.bool_]:
        """Find the selected points, (n,); no point with NaN among its coordinates is in a box.

        Parameters
        ----------
        cloud : PointCloud
            What was read.
        path : str
            The file, for messages.

        Raises
        ------
        CloudFileError
            As `Where.selected`, or if a box has more coordinates than the points.
        """
        import numpy as np

        found = np.ones(len(cloud), np.bool_)
        if self.where is not None:
            found &= self.where.selected(cloud, path)
        if self.box is not None:
            axes = len(self.box) // 2
            if axes > cloud.dimension:
                raise CloudFileError(
                    path, "its points have no z for the box", "give XMIN,YMIN,XMAX,YMAX"
                )
            points = cloud.points[:, :axes]
            found &= (points >= self.box[:axes]).all(axis=1)
            found &= (points <= self.box[axes:]).all(axis=1)
        return found

    @property
    def in_words(self) -> str:
        """Say what is asked for."""
        words = [] if self.where is None else [repr(self.where.text)]
        return " and ".join(words + ([] if self.box is None else [f"the box {self._box}"]))

    @property
    def provenance(self) -> str:
        """Write it for a comment, in which values have no spaces."""
        words = "" if self.where is None else f" where={self.where.as_value()}"
        return words + ("" if self.box is None else f" box={self._box}")

    @property
    def _box(self) -> str:
        return ",".join(f"{value:.17g}" for value in self.box or ())
