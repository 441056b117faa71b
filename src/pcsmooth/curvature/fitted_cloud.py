"""Normals and curvatures at all points of a cloud in parts."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.cell_normals import CELLS, CellNormals
from pcsmooth.curvature.orientation import Orientation
from pcsmooth.curvature.oriented_normals import CENTERS, OrientedNormals, find_oriented_normals
from pcsmooth.curvature.shape_operators import (
    CLUSTERS,
    find_shape_operators,
    finest_cluster,
)
from pcsmooth.curvature.support import (
    NestedFits,
    Support,
    Supports,
    choose_supports,
    fit_supports,
    limited_support,
    radius_of_support,
    ratios_of_supports,
    sample_ranks,
)
from pcsmooth.energies.centers import Centers, place_centers
from pcsmooth.energies.on_parts import BALLS, EVALUATION, Totals
from pcsmooth.energies.protocol import Energy
from pcsmooth.kernels.surface import shape_operators as columns
from pcsmooth.kernels.surface.shape_operators import N_ESTIMATES
from pcsmooth.neighbors.local_radii import LocalRadii
from pcsmooth.neighbors.marked import marked_rows
from pcsmooth.parts.cloud_state import CloudState
from pcsmooth.parts.column import Column
from pcsmooth.parts.part import Part, Parts, Reach
from pcsmooth.parts.streamed_median import streamed_median

#: Radii of a neighbourhood for curvature that a point's estimate depends on: the blocks of
#: clusters are not wider than 4 / 3 of one (than sqrt(2), if radii are local), and those around a
#: point's own count.
_RADII = 8.0 / 3.0 + 1e-3
_LOCAL_RADII = 2.0 * math.sqrt(2.0) + 1e-3

#: How far the anchors of two points may be from them, in radii of the balls.
_ANCHORS = 4.0


@dataclass(frozen=True, eq=False)
class FittedCloud:
    """Normals and curvatures of a cloud in parts: see `CurvatureEstimate`.

    Attributes
    ----------
    estimates : Column
        (N_ESTIMATES,), by the columns of `pcsmooth.kernels.surface.shape_operators`.
    normal_support, curvature_support : float
        Points of a neighbourhood.
    orientation : dict of str to int
        How many components got their sign for which reason.
    totals : list of Totals
        The energy of the parts.
    has_principal : bool
        Whether Gaussian and principal curvatures are known.
    """

    estimates: Column
    normal_support: float
    curvature_support: float
    orientation: dict[str, int]
    totals: list[Totals]
    has_principal: bool = True

    def mean_curvature(self, dimension: int, unit: float) -> tuple[int, float]:
        """Count the points without a normal, and find the median size of the others' curvature.

        0.0 if there are none; in 1 / the unit of the input.
        """
        rows, known = 0, 0

        def sizes() -> Iterator[npt.NDArray[np.float64]]:
            nonlocal rows, known
            rows = known = 0
            for chunk in self.estimates.chunks():
                has_normal = chunk[:, :dimension].any(axis=1)
                rows += len(chunk)
                known += int(np.count_nonzero(has_normal))
                yield np.abs(chunk[has_normal, columns.MEAN] / unit)

        any_known = any(len(chunk) for chunk in sizes())
        median = streamed_median(sizes) if any_known else 0.0
        return rows - known, median

    def clear_marked(self, marks: Column) -> None:
        """Take the estimates away from points that are marked."""
        first = 0
        for chunk in marks.chunks():
            stop = first + len(chunk)
            found = self.estimates.read(first, stop)
            self.estimates.write(first, np.where((chunk != 0)[:, np.newaxis], 0.0, found))
            first = stop


def fit_cloud(
    parts: Parts,
    state: CloudState,
    energy: Energy,
    *,
    support: Support,
    orientation: Orientation,
) -> FittedCloud:
    """Estimate normals and curvatures at all points.

    Parameters
    ----------
    parts : Parts
        The cloud.
    state : CloudState
        Where it is. After a step what noise is left is smooth, and would pass for shape in the
        finest neighbourhoods: they are not tried.
    energy : Energy
        Whose radius the balls have, and whose value is told.
    support : int or "auto"
        Points of a neighbourhood.
    orientation : Orientation
        Where normals point, seen from the cloud's origin, in its unit.

    Returns
    -------
    FittedCloud
    """
    dimension = parts.dimension

    def normals(count: int) -> tuple[OrientedNormals, list[Totals]]:
        return find_oriented_normals(parts, state, energy, count, orientation)

    def supports_for(found: OrientedNormals) -> Supports:
        return _choose(parts, state, energy, found)

    if support == "auto":
        (count, *smaller) = CELLS[dimension]
        found, totals = normals(count)
        supports = supports_for(found)
        for fewer in smaller:
            if supports.may_be_finer and state.iteration == 0:
                finer, _ = normals(fewer)
                others = supports_for(finer)
                if others.normal_error < supports.normal_error:
                    found, finer, supports = finer, found, others
                finer.drop(parts)
        radii = (supports.normal_radius, supports.curvature_radius)
    else:
        wanted = limited_support(support, parts.count)
        most = CELLS[dimension][0]
        found, totals = normals(min(wanted, most))
        wanted = limited_support(wanted, found.distinct)
        if min(wanted, most) < found.count:  # there are few distinct points
            found, totals = normals(wanted)
        radii = (radius_of_support(wanted, found.count, found.extent, dimension),) * 2
    clusters = (
        radii[1] / CLUSTERS[dimension]
        if energy.local is None
        else finest_cluster(radii[1] * energy.local.least_spacing, dimension)
    )
    parts.check_width(state.box, clusters, "the pieces of a neighbourhood for curvature")
    parts.forget(EVALUATION, BALLS)
    estimates = parts.create("estimates", (np.float64, (N_ESTIMATES,)))
    step = _Fit(_Cells(found, energy, state.box), radii, estimates)
    for _ in parts.map("curvature", step, state.points, state.drift):
        pass
    parts.forget(CENTERS)
    found.drop(parts)
    points_of = [found.count * (length / found.extent) ** (dimension - 1) for length in radii]
    return FittedCloud(estimates, points_of[0], points_of[1], found.reasons, totals)


def _choose(parts: Parts, state: CloudState, energy: Energy, found: OrientedNormals) -> Supports:
    """Choose the radii of neighbourhoods from a sample of the points."""
    samples = marked_rows(found.is_distinct, sample_ranks(found.distinct))
    ratios = ratios_of_supports(found.distinct, parts.dimension, found.count)
    fits = NestedFits(
        ratios,
        np.full((len(samples), len(ratios), 3), np.nan),
        np.full((len(samples), len(ratios), 3), np.nan),
    )
    step = _FitSamples(_Cells(found, energy, state.box), ratios, samples)
    for places, part in parts.map("neighbourhoods", step, state.points, state.drift):
        fits.normals[places] = part.normals
        fits.shapes[places] = part.shapes
    return choose_supports(fits, found.extent, parts.dimension)


@dataclass(frozen=True, eq=False)
class _Cells:
    """The cell normals of a cloud, as parts take them up.

    Attributes
    ----------
    found : OrientedNormals
        The normals.
    energy : Energy
        Whose radius the balls have.
    box : ndarray, shape (2, d)
        Bounding box of the cloud, L.
    """

    found: OrientedNormals
    energy: Energy
    box: npt.NDArray[np.float64]

    def reach(self, length: float) -> float | Reach:
        """How far anchors within a length of those of own points may be, L.

        The length is in the unit of the extent.
        """
        if self.energy.local is not None:
            return _AnchorReach(self.energy.local, length)
        return length + _ANCHORS * self.energy.radius

    def lengths(
        self, part: Part, length: float, numbers: npt.NDArray[np.int64]
    ) -> tuple[float | npt.NDArray[np.float64], float]:
        """Give a length in the unit of the extent, L, and the least of all points.

        If the unit is local at some points of a part, (k,).
        """
        local = self.energy.local
        if local is None:
            return length, length
        return length * part.read(local.spacings)[numbers], length * local.least_spacing

    def of(self, part: Part) -> tuple[Centers, npt.NDArray[np.int64], CellNormals]:
        """Give the points of a part in a grid, their numbers in its order, and their normals."""
        centers = part.remember(CENTERS, lambda: self._place(part))
        numbers = centers.distinct[centers.grid.order]

        def rows(column: Column) -> npt.NDArray[np.float64]:
            values = part.read(column)[numbers]
            padded = np.zeros((3, len(numbers)))
            padded[: values.shape[1]] = values.T
            return padded

        links = np.empty((0, 0), np.int32)  # have served their purpose
        weights = part.read(self.found.weights)[numbers]
        normals, anchors = rows(self.found.normals), rows(self.found.anchors)
        return centers, numbers, CellNormals(normals, anchors, links, weights, np.empty(0))

    def _place(self, part: Part) -> Centers:
        """Sort the points of a part as the union of balls did."""
        local = self.energy.local
        radii = None if local is None else local.in_part(part)
        if radii is not None and radii.least < radii.largest:
            return place_centers(
                part.points, radii.largest, reach=radii.largest, radii=radii, box=self.box
            )
        radius = self.energy.radius
        return place_centers(part.points, radius, reach=radius, box=self.box)


@dataclass(frozen=True, eq=False)
class _AnchorReach:
    """How far the points are whose anchors are near those of own ones (see `Reach`).

    Attributes
    ----------
    local : LocalRadii
        Radii of the balls.
    length : float
        Within which distance, in local spacings.
    """

    local: LocalRadii
    length: float

    def of_parts(self, drift: float) -> npt.NDArray[np.float64]:
        """Tell it of all parts, L: anchors are up to two radii away from their points."""
        around, shift = self.local.around, 2.0 * self.local.multiple

        def spacing(within: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
            return around(within + 2.0 * drift)

        own = (self.length + shift) * spacing(np.zeros(around.n_parts))
        reach = own
        while True:
            farther = own + shift * spacing(reach)
            if not (farther > reach).any():
                return reach
            reach = farther


@dataclass(frozen=True, eq=False)
class _FitSamples:
    """Fit the neighbourhoods of a part's own samples: which they are, the fits."""

    cells: _Cells
    ratios: npt.NDArray[np.float64]
    samples: npt.NDArray[np.int64]

    @property
    def reach(self) -> float | Reach:
        return self.cells.reach(2.0 * self.cells.found.extent * float(self.ratios[-1]))

    def __call__(self, part: Part) -> tuple[npt.NDArray[np.int64], NestedFits]:
        places = np.flatnonzero((self.samples >= part.first) & (self.samples < part.stop))
        if places.size == 0:
            none = np.empty((0, len(self.ratios), 3))
            return places, NestedFits(self.ratios, none, none)
        centers, numbers, normals = self.cells.of(part)
        ranks = np.empty(len(part.points), np.int64)
        ranks[numbers] = np.arange(len(numbers))
        chosen = ranks[np.searchsorted(part.rows, self.samples[places])]
        extent, least = self.cells.lengths(part, self.cells.found.extent, numbers)
        return places, fit_supports(
            normals, centers.grid.coordinates, centers.dimension, chosen, extent, self.ratios, least
        )


@dataclass(frozen=True, eq=False)
class _Fit:
    """Fit normals and shape operators at the points of a part."""

    cells: _Cells
    radii: tuple[float, float]
    estimates: Column

    @property
    def reach(self) -> float | Reach:
        radii = _RADII if self.cells.energy.local is None else _LOCAL_RADII
        return self.cells.reach(radii * self.radii[1])

    def __call__(self, part: Part) -> None:
        centers, numbers, normals = self.cells.of(part)
        of_normal, _ = self.cells.lengths(part, self.radii[0], numbers)
        of_curvature, least = self.cells.lengths(part, self.radii[1], numbers)
        fitted = find_shape_operators(
            normals, centers.grid.coordinates, numbers, len(part.points), centers.dimension,
            of_normal, of_curvature, self.cells.box[0], least,
        )  # fmt: skip
        if len(numbers) < len(part.points):
            fitted = fitted[centers.carriers]
        part.write(self.estimates, fitted)
