"""Points selected by an expression, a box, a polygon, or all of these."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.files.polygon import Polygon
from pcsmooth.files.polygon_file import read_polygon
from pcsmooth.files.where import Where, without_spaces
from pcsmooth.printable import counted

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from pcsmooth.cloud import PointCloud

Others = Literal["act", "ignore"]
"""What the points do that are not selected: act on those that are, or nothing."""

_SIZES = (4, 6)


@dataclass(frozen=True, init=False, eq=False)
class Selection:
    """Which points are selected: those that are by all that is given.

    Parameters
    ----------
    where : str or Where, optional
        An expression on columns (see `Where`).
    box : iterable of float, optional
        Least coordinates, then largest, L: four numbers for x and y, six for x, y and z. Its
        boundary belongs to it.
    polygon : path or Polygon, optional
        An area of x and y, of GeoJSON or WKT. Its boundary belongs to it.
    others : {"act", "ignore"}
        What the other points do; they stay where they are.

    Raises
    ------
    InvalidInputError
        If there are not so many numbers, one that should be least is larger or NaN, or a value is
        not known.
    CloudFileError
        If the polygon cannot be read.
    """

    where: Where | None
    box: tuple[float, ...] | None
    polygon: Polygon | None
    others: Others

    def __init__(
        self,
        where: str | Where | None = None,
        box: Iterable[float] | None = None,
        polygon: str | os.PathLike[str] | Polygon | None = None,
        others: Others = "act",
    ) -> None:
        if others not in get_args(Others):
            raise InvalidInputError(f"others is {others!r}; it must be act or ignore")
        values = {
            "where": Where(where) if isinstance(where, str) else where,
            "box": None if box is None else _checked_box(tuple(map(float, box))),
            "polygon": read_polygon(polygon) if isinstance(polygon, str | os.PathLike) else polygon,
            "others": others,
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def selected(self, cloud: PointCloud, path: str) -> npt.NDArray[np.bool_]:
        """Find the selected points, (n,); none with NaN for x or y is in a box or a polygon.

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
        if self.polygon is not None:
            found &= self.polygon.contains(cloud.points[:, :2])
        return found

    @property
    def ignores_others(self) -> bool:
        """Whether the other points act on nothing."""
        return self.others == "ignore"

    @property
    def in_words(self) -> str:
        """Say what is asked for."""
        words = [] if self.where is None else [repr(self.where.text)]
        words += [] if self.box is None else [f"the box {_spelled(self.box)}"]
        words += [] if self.polygon is None else [f"the polygon {self.polygon.path}"]
        return " and ".join(words)

    @property
    def provenance(self) -> str:
        """Write it for a comment, in which values have no spaces."""
        words = {
            "where": self.where and without_spaces(self.where.text),
            "box": self.box and _spelled(self.box),
            "polygon": self.polygon and without_spaces(os.path.basename(self.polygon.path)),
            "others": "ignore" if self.ignores_others else "",
        }
        return "".join(f" {name}={value}" for name, value in words.items() if value)

    def missed_in_words(self, box: npt.NDArray[np.float64] | None, noise: int) -> str:
        """Say that it selects no point of a cloud, and what may be why.

        Parameters
        ----------
        box : ndarray, shape (2, d), or None
            Corners of the points' bounding box; None if there is no point.
        noise : int
            Points that the file calls noise, and that take no part.
        """
        missed = f"no point is selected by {self.in_words}"
        if noise and self.where is not None:
            missed += (
                f" ({counted(noise, 'point')} of a noise class or withheld left out; "
                "--keep-noise-class takes them in)"
            )
        if self.polygon is None or box is None:
            return missed
        extent = self.polygon.extent
        if extent is None:
            return f"{missed}, which is empty"
        degrees = ""
        if _may_be_degrees(extent) and not _may_be_degrees(box):
            degrees = "; if these are degrees, project it like the points"
        return (
            f"{missed}: the polygon spans {_range_in_words(extent)}, the points "
            f"{_range_in_words(box)}{degrees}"
        )


def _checked_box(box: tuple[float, ...]) -> tuple[float, ...]:
    half = len(box) // 2
    if len(box) not in _SIZES or not all(
        low <= high for low, high in zip(box[:half], box[half:], strict=True)
    ):
        raise InvalidInputError(
            f"a box is XMIN,YMIN,XMAX,YMAX or XMIN,YMIN,ZMIN,XMAX,YMAX,ZMAX, not {_spelled(box)}"
        )
    return box


def _spelled(box: tuple[float, ...]) -> str:
    return ",".join(f"{value:.17g}" for value in box)


def _may_be_degrees(box: npt.NDArray[np.float64]) -> bool:
    return bool((abs(box[:, :2]) <= (180.0, 90.0)).all())


def _range_in_words(box: npt.NDArray[np.float64]) -> str:
    (x, y), (x_most, y_most) = box[:, :2].tolist()
    return f"x {x:.10g} to {x_most:.10g}, y {y:.10g} to {y_most:.10g}"
