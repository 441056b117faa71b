"""What has to be known of a cloud before anything is done with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.lengths import local_multiple, resolve_length, resolve_radius
from pcsmooth.neighbors.coincident import Distinct, mark_distinct
from pcsmooth.neighbors.local_radii import LocalRadii
from pcsmooth.neighbors.local_spacing import spacings_in_order
from pcsmooth.neighbors.spacing import measure_spacing
from pcsmooth.parts.part import Parts


@dataclass(frozen=True, eq=False)
class Measured:
    """A cloud's size and spacing.

    Attributes
    ----------
    distinct : Distinct
        Its points that are the first at their position.
    ends : ndarray, shape (m, d)
        Points with the bounding box of the cloud, in the unit; one point if it has but one.
    spacing : float
        Mean spacing of the points, in the unit.
    unit : float
        What all lengths are multiples of, L.
    """

    distinct: Distinct
    ends: npt.NDArray[np.float64]
    spacing: float
    unit: float = 1.0

    @property
    def dimension(self) -> int:
        """Number of coordinates of a point, 2 or 3."""
        return int(self.ends.shape[1])

    def length(self, spec: float | str, name: str) -> float:
        """Turn a length as given into a number, in the unit: see `resolve_length`."""
        return resolve_length(spec, self.ends, self.spacing, name, self.unit)

    def radius(self, spec: float | str) -> float:
        """Turn a radius as given into a number, in the unit: see `resolve_radius`."""
        return resolve_radius(spec, self.ends, self.spacing, self.unit)

    def local_radii(self, spec: float | str, parts: Parts) -> LocalRadii | None:
        """Find the radius of each ball of the cloud at its start, in the unit, if it is local.

        Raises
        ------
        InvalidInputError
            As `radius`: all points are at one place, or too near to be measured.
        """
        multiple = local_multiple(spec)
        if multiple is None:
            return None
        self.radius(spec)
        return LocalRadii.of(spacings_in_order(parts.start.read(0, parts.count)), multiple)


def measure_cloud(parts: Parts) -> Measured:
    """Find size, spacing and coincident points of a cloud at its start."""
    distinct = mark_distinct(parts)
    spacing = measure_spacing(parts, distinct)
    # Of one point, one: messages tell the difference.
    return Measured(distinct, parts.box[: parts.count], spacing, parts.unit)
