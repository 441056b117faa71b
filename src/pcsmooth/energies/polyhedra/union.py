"""The union of convex polyhedra: its measures, and the energies made of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import get_args

import numpy as np
import numpy.typing as npt

from pcsmooth.bodies.convex_body import ConvexBody
from pcsmooth.energies.cell_reach import cell_reach
from pcsmooth.energies.centers import place_centers
from pcsmooth.energies.polyhedra import alpha_complex
from pcsmooth.energies.polyhedra.body_tables import body_tables
from pcsmooth.energies.polyhedra.exact import measure_exact
from pcsmooth.energies.polyhedra.inclusion_exclusion import measure_inclusion_exclusion
from pcsmooth.energies.polyhedra.naive import measure_naive
from pcsmooth.energies.protocol import Evaluation, Quantity, UnionName, Weight
from pcsmooth.energies.unequal_radii import unequal_radii
from pcsmooth.energies.weighting import weigh_at_own_pace
from pcsmooth.errors import InvalidInputError
from pcsmooth.kernels.polyhedra import union_rows as columns
from pcsmooth.neighbors.local_radii import LocalRadii
from pcsmooth.unit_of_length import power_of_two_near, unit_near

#: Longest automatic step, in spacings. Where a facet of K is parallel to the surface the gradient
#: jumps whenever one point overtakes another: longer steps leave jitter, shorter ones hold back
#: the few points that lead such a facet.
_LONGEST_STEP = 0.4


@dataclass(frozen=True)
class PolyhedronUnion:
    """Measures of a union of bodies p_i + r_i K in d = 2 or 3 dimensions, and their gradients.

    In 2D read area for volume and length for area. Of coincident points the first carries the
    body, if radii differ the first of the largest; the measures and gradients of the others are 0.

    Attributes
    ----------
    radius : float
        Factor r of the body, L; the largest if they are unequal.
    body : ConvexBody
        K.
    union : {"naive", "inclusion-exclusion", "exact"}
        How the union is computed.
    points : ndarray, shape (n, d)
        The points, L.
    box : ndarray, shape (2, d), or None
        Bounding box of the whole cloud, if they are a part of one, L.
    carriers : ndarray of int, shape (n,)
        Number of the point that carries the body at the same position.
    rows : ndarray, shape (n, N_COLUMNS)
        All other measures, by the columns of `pcsmooth.kernels.polyhedra.union_rows`.
    radii : ndarray, shape (n,), optional
        Factor of each body, L, if they are unequal; the gradients are those at fixed radii.
    """

    radius: float
    body: ConvexBody
    union: UnionName
    points: npt.NDArray[np.float64]
    box: npt.NDArray[np.float64] | None
    carriers: npt.NDArray[np.int64]
    rows: npt.NDArray[np.float64]
    radii: npt.NDArray[np.float64] | None = None

    @cached_property
    def volume(self) -> float:
        """Volume of the union, L^d."""
        return float(self.volume_shares.sum())

    @cached_property
    def area(self) -> float:
        """Measure of the boundary of the union, L^(d-1)."""
        return float(self.visible_areas.sum())

    @property
    def volume_shares(self) -> npt.NDArray[np.float64]:
        """Volumes that add up to that of the union, (n,), L^d."""
        return self.rows[:, columns.VOLUME_SHARE]

    @cached_property
    def cell_volumes(self) -> npt.NDArray[np.float64]:
        """Volume of each restricted cell V_i and (p_i + r_i K), (n,), L^d.

        They add up to the volume of the naive union only.
        """
        return self._restricted_cells[:, columns.VOLUME_SHARE]

    @property
    def visible_areas(self) -> npt.NDArray[np.float64]:
        """Measure of the parts of each body's facets that bound the union, (n,), L^(d-1)."""
        return self.rows[:, columns.VISIBLE_AREA]

    @property
    def volume_gradient(self) -> npt.NDArray[np.float64]:
        """Gradient of the volume, (n, d), L^(d-1)."""
        return self._vectors(columns.VOLUME_GRADIENT)

    @property
    def area_gradient(self) -> npt.NDArray[np.float64]:
        """Gradient of the boundary's measure, (n, d), L^(d-2)."""
        return self._vectors(columns.AREA_GRADIENT)

    @property
    def volume_diagonal(self) -> npt.NDArray[np.float64]:
        """Stiffness of the volume, (n,): see `Evaluation.diagonal`.

        The sum over the facets between restricted cells of area / distance, and enough for an
        automatic step to end within a share of the spacing. If the cell of a body is empty, which
        is among larger ones, it is infinite, or 0 if nothing is visible of it: the point rests.
        """
        return self._stiffness(columns.VOLUME_DIAGONAL, self.volume_gradient)

    @property
    def area_diagonal(self) -> npt.NDArray[np.float64]:
        """Stiffness of the boundary's measure, (n,).

        As that of the volume, with the edges of the facets, length / (distance sin(angle to K)).
        """
        return self._stiffness(columns.AREA_DIAGONAL, self.area_gradient)

    def _stiffness(self, column: int, gradient: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        radius = self.radius if self.radii is None else self.radii
        widths = (self.cell_volumes / (2.0 * radius)) ** (1.0 / (self.body.dimension - 1))
        longest = _LONGEST_STEP * widths
        scale = power_of_two_near(float(np.abs(gradient).max()))  # squares are to be floats
        lengths = np.linalg.norm(gradient / scale, axis=1) * scale
        stiffness = np.where(lengths > 0.0, np.inf, 0.0)
        np.divide(lengths, longest, out=stiffness, where=longest > 0.0)
        return np.asarray(np.maximum(stiffness, self._restricted_cells[:, column]))

    def _vectors(self, column: int) -> npt.NDArray[np.float64]:
        return self.rows[:, column : column + self.body.dimension]

    @cached_property
    def _restricted_cells(self) -> npt.NDArray[np.float64]:
        if self.union == "naive":
            return self.rows
        radius = self.radius if self.radii is None else self.radii
        return measure_polyhedra(self.points, radius, self.body, "naive", self.box).rows


def measure_polyhedra(
    points: npt.ArrayLike,
    radius: npt.ArrayLike,
    body: ConvexBody,
    union: UnionName = "exact",
    box: npt.NDArray[np.float64] | None = None,
) -> PolyhedronUnion:
    """Measure the union of the bodies p_i + r_i K, and its first variation.

    Parameters
    ----------
    points : array_like of float, shape (n, d)
        Centres, L; n >= 1, finite.
    radius : float or array_like of float, shape (n,)
        r, the same for all bodies, or r_i of each, L; finite and > 0.
    body : ConvexBody
        K, of the same dimension as the points.
    union : {"naive", "inclusion-exclusion", "exact"}
        ``"naive"``: the sum of the cells V_i and (p_i + r_i K), V_i the Euclidean Voronoi cell
        (report, Section 3.3.1), or, if the bodies are unequal, the power cell of the largest balls
        in them. ``"inclusion-exclusion"``: over the alpha-complex of the points, alpha = r
        (Section 3.3.2), or that of the balls of the radii r_i. ``"exact"``: the union itself.
    box : ndarray, shape (2, d), optional
        Bounding box of the whole cloud, L, if the points are a part of one.

    Returns
    -------
    PolyhedronUnion
        volume, area, cell_volumes and visible_areas (n,), volume_gradient and area_gradient
        (n, d).

    Raises
    ------
    InvalidInputError
        If the points have another shape than (n, d), there are none, a coordinate is not finite
        (the first such row is named), a radius is not finite and positive or there are not as
        many as points, or the union is none of the three.
    PcsmoothError
        If the alpha-complex cannot be found.

    Notes
    -----
    Over a surface with normals n, sampled more and more densely, the naive volume tends to the
    integral of r (rho(n) + rho(-n)) and the exact one to that of r (h(n) + h(-n)), rho being the
    radial function of K and h its support function (report, Eq. 4.19): only the latter has K
    itself as the shape of least energy. Inclusion-exclusion over the alpha-complex is exact for
    balls only; its limit exceeds the exact one, by an amount that depends on the sampling.

    At ties, where facets of several bodies lie in one plane, the volume has no gradient; what the
    bodies share is given to the first of their points by x, y, z, whatever their order.

    Examples
    --------
    >>> square = ConvexBody([[1, 0], [0, 1], [-1, 0], [0, -1]], [1, 1, 1, 1])
    >>> union = measure_polyhedra([[0, 0], [1, 0.5]], radius=1.0, body=square)
    >>> round(union.volume, 12), round(union.area, 12)
    (6.5, 11.0)
    >>> union = measure_polyhedra([[0, 0], [1, 0.75]], radius=[1.0, 0.5], body=square)
    >>> round(union.volume, 12), union.visible_areas.round(12).tolist()
    (4.625, [6.75, 2.75])
    """
    if union not in get_args(UnionName):
        raise InvalidInputError(
            f"union is {union!r}; it must be naive, inclusion-exclusion or exact"
        )
    radii = unequal_radii(points, radius)
    radius = float(np.max(radius))
    reach = radius if union == "inclusion-exclusion" else radius * body.circumradius
    digits = alpha_complex.DIGITS if union == "inclusion-exclusion" else None
    unit = unit_near(radius)
    centers = place_centers(points, radius, reach, radii=radii, unit=unit, digits=digits, box=box)
    if centers.dimension != body.dimension:
        raise InvalidInputError(
            f"the points have {centers.dimension} coordinates and the body {body.dimension}"
        )
    tables = body_tables(body, radius / unit)
    sizes = np.ones(len(centers.distinct))
    if radii is not None:
        sizes = radii.values[centers.distinct][centers.grid.order] / radius
    if union == "naive":
        found = measure_naive(centers, tables, sizes)
    elif union == "exact":
        found = measure_exact(centers, tables, sizes, None if box is None else box / unit)
    else:
        found = measure_inclusion_exclusion(centers, radius / unit, tables, sizes)
    rows = np.empty_like(found)
    rows[centers.grid.order] = found
    rows *= unit ** _powers_of_length(body.dimension) / tables.thickness
    return PolyhedronUnion(
        radius,
        body,
        union,
        np.asarray(points, dtype=float),
        box,
        centers.carriers,
        centers.spread(rows),
        None if radii is None else radii.values,
    )


def _powers_of_length(dimension: int) -> npt.NDArray[np.float64]:
    """Powers of length in the columns of the rows, (N_COLUMNS,)."""
    powers = np.full(columns.N_COLUMNS, dimension - 1.0)
    powers[columns.VOLUME_SHARE] = dimension
    powers[columns.AREA_GRADIENT : columns.AREA_GRADIENT + 3] = dimension - 2
    powers[columns.VOLUME_DIAGONAL] = dimension - 2
    powers[columns.AREA_DIAGONAL] = dimension - 3
    return powers


@dataclass(frozen=True)
class PolyhedronEnergy:
    """Volume of a union of convex polyhedra or measure of its boundary, plain or weighted.

    Attributes
    ----------
    radius : float
        r; the median of local ones.
    body : ConvexBody
        K.
    union : {"naive", "inclusion-exclusion", "exact"}
        How the union is computed (see `measure_polyhedra`).
    quantity : {"volume", "area"}
        What is measured; in 2D area and perimeter.
    weight : {"none", "cell", "boundary"}
        What the gradients are divided by (see `weigh`).
    local : LocalRadii, optional
        Factors r_i of the bodies around all points, if each has its own; see `BallEnergy`.
    """

    radius: float
    body: ConvexBody
    union: UnionName = "exact"
    quantity: Quantity = "volume"
    weight: Weight = "cell"
    local: LocalRadii | None = None

    def reach(self, dimension: int) -> float:
        """How far it looks from a point, L: as far as the cells of the bodies, or of the balls."""
        return cell_reach(self.radius * max(1.0, self.body.circumradius), dimension)

    def evaluate(
        self, points: npt.NDArray[np.float64], box: npt.NDArray[np.float64] | None = None
    ) -> Evaluation:
        """Evaluate the energy at finite points, shape (n, d), n >= 1 (see `Energy`)."""
        radius = self.radius if self.local is None else self.local.values
        union = measure_polyhedra(points, radius, self.body, self.union, box)
        return weigh_at_own_pace(union, self.quantity, self.weight, self.radius)
