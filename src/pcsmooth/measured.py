"""What has to be known of a cloud before anything is done with it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.lengths import AUTO_SPACINGS, is_auto, local_multiple, resolve_length, resolve_radius
from pcsmooth.neighbors.coincident import Distinct, mark_distinct
from pcsmooth.neighbors.grid import is_in_range
from pcsmooth.neighbors.local_radii import LocalRadii
from pcsmooth.neighbors.spacing import measure_spacing
from pcsmooth.neighbors.spacing_in_parts import local_spacings_of
from pcsmooth.neighbors.spacing_samples import share_apart
from pcsmooth.parts.part import Parts

#: Share of the surface on which one radius may be too small. Where it was at a tenth, normals far
#: from a scanner became right with local radii; where it was at a sixteenth or less nothing did.
SPARSE = 0.09


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

    def noise(self, spec: float | str) -> float:
        """Turn the noise as given into a number, in the unit: see `length`.

        Raises
        ------
        InvalidInputError
            It is larger than the cloud.
        """
        noise = self.length(spec, "noise")
        size = float(np.linalg.norm(np.ptp(self.ends, axis=0)))
        if noise > size > 0.0:
            raise InvalidInputError(
                f"noise {spec} is larger than the cloud, whose diagonal is "
                f"{size * self.unit:.4g}; give it in the unit of the coordinates, as 0.5x or as 1%"
            )
        return noise

    def radius(self, spec: float | str) -> float:
        """Turn a radius as given into a number, in the unit: see `resolve_radius`."""
        return resolve_radius(spec, self.ends, self.spacing, self.unit)

    def local_radii(
        self, spec: float | str, parts: Parts, *, may_choose: bool
    ) -> LocalRadii | None:
        """Find the radius of each ball of the cloud at its start, in the unit, if it is local.

        Parameters
        ----------
        spec : float or str
            The radius as given.
        parts : Parts
            The cloud.
        may_choose : bool
            Whether "auto" may be local, too: it is where one radius is too small for much of the
            surface (see `sparse_share`).

        Raises
        ------
        InvalidInputError
            As `radius`: all points are at one place, or too near to be measured.
        """
        multiple = local_multiple(spec)
        if multiple is not None:
            self.radius(spec)
            return self._local_radii(multiple, parts)
        if not (may_choose and is_auto(spec)):
            return None
        share = self.sparse_share(parts)
        if share <= SPARSE:
            return None
        local = replace(self._local_radii(AUTO_SPACINGS, parts), sparse_share=share)
        # Tiles of clouds that are too wide for the smallest balls would not be as the whole.
        return local if is_in_range(parts.box, local.least_spacing, parts.box[0]) else None

    def sparse_share(self, parts: Parts) -> float:
        """Tell on which share of the surface points are farther apart than the automatic radius.

        That is 0 of points that do not lie on a surface, and in the plane (see `share_apart`).
        """
        if self.spacing == 0.0:
            return 0.0
        return share_apart(parts, self.distinct, AUTO_SPACINGS * self.spacing)

    def _local_radii(self, multiple: float, parts: Parts) -> LocalRadii:
        local = LocalRadii.of_parts(parts, local_spacings_of(parts, self.distinct), multiple)
        parts.drop("local spacings")
        return local


def measure_cloud(parts: Parts) -> Measured:
    """Find size, spacing and coincident points of a cloud at its start."""
    distinct = mark_distinct(parts)
    spacing = measure_spacing(parts, distinct)
    # Of one point, one: messages tell the difference.
    return Measured(distinct, parts.box[: parts.count], spacing, parts.unit)
