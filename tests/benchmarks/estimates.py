"""Ways to estimate normals and curvatures of a cloud: pcsmooth's, its parts and others'.

Each way returns its candidates, by the parameter that tells them apart.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from curvature_shapes import Surface, principal
from jets import fit_jets, plane_normals
from peers import PeerError, ask_peer
from scipy.spatial import cKDTree

from pcsmooth import BallUnion, CurvatureEstimate, estimate_curvature, measure_balls
from pcsmooth.curvature.cell_normals import find_cell_normals
from pcsmooth.neighbors.grid import build_grid

Array = npt.NDArray[np.float64]

SAMPLES = 2500  #: points at which the slow ways are tried
COUNT = 30  #: points of a neighbourhood where all ways have the same
COUNTS = (12, 18, 24, 30, 45, 60, 90, 130, 180, 250, 350, 500, 800)
SCALES = (2, 3, 4, 6, 8, 12, 16, 20, 28)  #: of MeshLab's filter


@dataclass(frozen=True)
class Fields:
    """What was estimated, at all points or at a sample of them."""

    normals: Array | None = None
    mean: Array | None = None
    gauss: Array | None = None
    rows: npt.NDArray[np.intp] | None = None
    has_signs: bool = False

    def pick(self, truth: Array) -> Array:
        """Take what belongs to the points of the estimate."""
        return truth if self.rows is None else truth[self.rows]


Candidates = dict[str, Fields]
Way = Callable[["Case"], Candidates]
Error = Callable[[Surface, Fields], float]
Form = Callable[[float], str]


@dataclass(frozen=True, eq=False)
class Case:
    """A surface, and what several ways need of it."""

    surface: Surface

    @cached_property
    def estimate(self) -> CurvatureEstimate:
        return estimate_curvature(self.surface.points)

    @cached_property
    def union(self) -> BallUnion:
        return measure_balls(self.surface.points, self.estimate.radius)

    @cached_property
    def sample(self) -> npt.NDArray[np.intp]:
        step = max(1, len(self.surface) // SAMPLES)
        return np.arange(0, len(self.surface), step)

    @cached_property
    def tree(self) -> cKDTree:
        return cKDTree(self.surface.points)

    @cached_property
    def around_sample(self) -> npt.NDArray[np.intp]:
        """The nearest points of the sample, as many as any way asks for."""
        return self.nearest(max(COUNTS), self.sample)

    def nearest(
        self, count: int, rows: npt.NDArray[np.intp] | slice = slice(None)
    ) -> npt.NDArray[np.intp]:
        """Return the numbers of the points nearest to some points."""
        return np.asarray(self.tree.query(self.surface.points[rows], count, workers=2)[1])

    @cached_property
    def plane_normals(self) -> Array:
        """Normals by principal component analysis, with the signs of the truth."""
        normals = plane_normals(self.surface.points[self.nearest(COUNT)])
        return outward(normals, self.surface.normals)

    @cached_property
    def cell_normals(self) -> Array:
        grid = build_grid(self.surface.points, 2.0 * self.union.radius)
        found = find_cell_normals(
            grid, grid.order, self.union, 3, count=COUNT, reach=2.0 * self.union.radius
        )
        normals = np.empty_like(self.surface.points)
        normals[grid.order] = found.normals.T
        return outward(normals, self.surface.normals)

    @cached_property
    def jets(self) -> dict[int, Candidates]:
        """Jets of each degree, for all numbers of points that determine them."""
        return {degree: self._jets(degree) for degree in (2, 3, 4)}

    def _jets(self, degree: int) -> Candidates:
        n_terms = (degree + 1) * (degree + 2) // 2
        truth = self.surface.normals[self.sample]
        return {
            f"k {count}": Fields(
                *fit_jets(
                    self.surface.points, self.sample, self.around_sample[:, :count], truth, degree
                ),
                self.sample,
            )
            for count in COUNTS
            if count >= 1.5 * n_terms
        }

    @cached_property
    def apss(self) -> Candidates:
        chosen = np.zeros(len(self.surface))
        chosen[self.sample] = 1.0
        question = (self.surface.points, self.plane_normals, chosen)
        found = {}
        for scale in SCALES:
            mean, gauss = ask_peer("meshlab_apss", question, scale)[self.sample].T
            found[f"scale {scale}"] = Fields(None, mean, gauss, self.sample)
        return found


def outward(normals: Array, truth: Array) -> Array:
    """Give normals the signs of others."""
    along = np.sum(normals * truth, axis=1)
    return np.where(along < 0.0, -1.0, 1.0)[:, np.newaxis] * normals


def fields_of(estimate: CurvatureEstimate) -> Fields:
    return Fields(
        estimate.normals,
        estimate.mean_curvature,
        estimate.gaussian_curvature,
        has_signs=True,
    )


def by_default(case: Case) -> Candidates:
    return {"": fields_of(case.estimate)}


def by_options(**options: Any) -> Way:
    """`estimate_curvature` with other options than the defaults."""
    return lambda case: {"": fields_of(estimate_curvature(case.surface.points, **options))}


def cells_alone(case: Case) -> Candidates:
    """Normals of the tensors of the cells."""
    return {"": Fields(case.cell_normals)}


def gradients_alone(case: Case) -> Candidates:
    """Normals along the gradients of the volume, zero where there are none."""
    gradients = case.union.volume_gradient
    lengths = np.linalg.norm(gradients, axis=1, keepdims=True)
    normals = np.divide(gradients, lengths, out=np.zeros_like(gradients), where=lengths > 0.0)
    return {"": Fields(normals, has_signs=True)}


def by_cell_measures(*counts: int) -> Way:
    """Curvatures from sums over the cells of the nearest points.

    The gradients along the normals over the cells' volumes C are 2 H. With the visible areas S,
    sum S = 2 a (1 + r² K) and sum C = 2 a r (1 + r² K / 3) for a piece of surface of area a.
    """

    def way(case: Case) -> Candidates:
        union, radius = case.union, case.union.radius
        slopes = np.sum(union.volume_gradient * case.cell_normals, axis=1)
        found = {}
        for count in counts:
            near = case.nearest(count, case.sample)
            volumes = union.cell_volumes[near].sum(axis=1)
            mean = 0.5 * slopes[near].sum(axis=1) / volumes
            ratio = radius * union.visible_areas[near].sum(axis=1) / volumes
            gauss = 1.5 * (ratio - 1.0) / radius**2
            found[f"k {count}" if len(counts) > 1 else ""] = Fields(None, mean, gauss, case.sample)
        return found

    return way


def by_jets(*degrees: int) -> Way:
    """Jets; the degree is named where there are several."""
    if len(degrees) == 1:
        return lambda case: case.jets[degrees[0]]
    return lambda case: {
        f"degree {degree}, {label}": fields
        for degree in degrees
        for label, fields in case.jets[degree].items()
    }


def by_apss(case: Case) -> Candidates:
    return case.apss


def by_peer(name: str, *counts: int) -> Way:
    """Normals of a program that looks at the nearest points."""
    return lambda case: {
        f"k {count}" if len(counts) > 1 else "": Fields(
            ask_peer(name, (case.surface.points,), count)
        )
        for count in counts
    }


def by_voronoi_covariance(case: Case) -> Candidates:
    """Normals of CGAL, for several radii of convolution, in spacings."""
    surface = case.surface
    return {
        f"radius {radius}": Fields(
            ask_peer("cgal_vcm", (surface.points,), 4.0 * surface.spacing, radius * surface.spacing)
        )
        for radius in (2, 3, 4, 6, 8)
    }


def by_meshlab(case: Case) -> Candidates:
    """Normals of planes in MeshLab, smoothed."""
    return {
        f"k {count}, {smoothings}x": Fields(
            ask_peer("meshlab_normals", (case.surface.points,), count, smoothings)
        )
        for count in (10, 18, 30)
        for smoothings in (0, 2, 5)
    }


def normal_angles(surface: Surface, fields: Fields) -> Array:
    """Angles to the true normals in degrees, whatever the sign."""
    assert fields.normals is not None
    along = np.abs(np.sum(fields.normals * fields.pick(surface.normals), axis=1))
    return np.asarray(np.degrees(np.arccos(np.minimum(along, 1.0))))


def normal_error(surface: Surface, fields: Fields) -> float:
    """Median angle to the true normals, in degrees."""
    return float(np.median(normal_angles(surface, fields)))


def mean_error(surface: Surface, fields: Fields) -> float:
    """Median relative error of the mean curvature."""
    assert fields.mean is not None
    return _median_error(fields.mean, fields.pick(surface.mean))


def gauss_error(surface: Surface, fields: Fields) -> float:
    """Median relative error of the Gaussian curvature."""
    assert fields.gauss is not None
    return _median_error(fields.gauss, fields.pick(surface.gauss))


def principal_error(which: int) -> Error:
    """Median relative error of k1 (which = 0) or k2."""

    def error(surface: Surface, fields: Fields) -> float:
        assert fields.mean is not None
        assert fields.gauss is not None
        true = fields.pick(principal(surface.mean, surface.gauss)[which])
        return _median_error(principal(fields.mean, fields.gauss)[which], true)

    return error


def _median_error(values: Array, truth: Array) -> float:
    return float(np.median(np.abs(values - truth) / np.abs(truth)))


def describe(way: Way, case: Case, error: Error, form: Form) -> str:
    """Least error of a way's candidates as text, with the parameter that gave it."""
    try:
        candidates = way(case)
    except PeerError as failure:
        return str(failure)
    errors = {label: error(case.surface, fields) for label, fields in candidates.items()}
    best = min(errors, key=lambda label: errors[label])
    return form(errors[best]) + (f" ({best})" if best else "")
