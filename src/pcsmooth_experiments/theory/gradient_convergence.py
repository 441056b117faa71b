"""Whether the gradients tend to the mean curvature vector (report, Proposition 6)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, get_args

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.single_gradient import curvature_vectors
from pcsmooth.energies.balls import BallUnion, measure_balls
from pcsmooth.energies.protocol import Quantity
from pcsmooth.plots.figures import new_figure
from pcsmooth_experiments.claims import verdict_on
from pcsmooth_experiments.experiment import Experiment, Inputs, Outcome, Table, Verdict
from pcsmooth_experiments.row_tables import table_of
from pcsmooth_experiments.sampled_shapes import (
    SampledShape,
    Sampling,
    Shape,
    ellipse,
    spheroid,
    torus,
)
from pcsmooth_experiments.theory.fitted_order import fitted_order, ranges_in_words
from pcsmooth_experiments.theory.joint_limits import (
    FIXED_RADIUS,
    FIXED_RATIO,
    RATIO_AS_RADIUS,
    RATIO_AS_SQUARE,
    JointLimit,
)
from pcsmooth_experiments.theory.slope_lines import draw_slope, mark_decades
from pcsmooth_experiments.theory.tangent_cells import tangent_cells

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = npt.NDArray[np.float64]

#: Numbers of points on curves; on surfaces Fibonacci numbers, the most even on a torus.
_ON_CURVES = (200, 400, 800, 1600, 3200, 6400)
_ON_SURFACES = (2584, 4181, 6765, 10946, 17711, 28657)

#: Radius for the coarsest points; the shapes have the size 1, and reaches from 0.36 on.
_FIRST_RADIUS = 0.16

#: Points whose cells are looked at are that many of a random torus, with this radius.
_CHECKED, _CHECKED_OF, _CHECKED_RADIUS = 800, 75025, 0.1

#: The thesis' bound is of order 1 in r where epsilon / r falls as r; a fitted order that is at
#: least this counts as that.
_ORDER_ENOUGH = 0.8

_QUANTITIES: tuple[Quantity, ...] = get_args(Quantity)

_LIMITS = (FIXED_RADIUS, FIXED_RATIO, RATIO_AS_RADIUS, RATIO_AS_SQUARE)

#: Names of the columns of errors.
ERRORS = ("rms", "largest", "normal_rms", "normal_largest", "tangential_rms", "tangential_largest")


@dataclass(frozen=True)
class Series:
    """Errors of one estimate on one shape, as the points become denser.

    Attributes
    ----------
    shape : str
        Circle, ellipse, sphere, ellipsoid or torus.
    dimension : int
        d.
    sampling : {"even", "random"}
        Of the points.
    limit : JointLimit
        How the radius follows.
    quantity : {"volume", "area"}
        Whose gradient.
    n_points : ndarray of int, shape (m,)
        Numbers of points.
    covering, radius : ndarray, shape (m,)
        Covering radius epsilon (report, Definition 9), measured, and radius of the balls, L.
    errors : dict of str to ndarray, each (m,)
        By the names `ERRORS`: root mean square and largest over the points, of the vector and of
        its normal and tangential parts, each over the largest |k1 + k2| of the shape. If r is
        fixed the vector is compared with its limit (k1 + k2) n / (1 + r^2 k1 k2), else with
        (k1 + k2) n.
    hidden : ndarray of int, shape (m,)
        Points without a visible boundary, whose estimate is 0.
    """

    shape: str
    dimension: int
    sampling: Sampling
    limit: JointLimit
    quantity: Quantity
    n_points: npt.NDArray[np.int64]
    covering: Array
    radius: Array
    errors: dict[str, Array]
    hidden: npt.NDArray[np.int64]

    @property
    def variable(self) -> Array:
        """What the orders refer to: epsilon / r if r is fixed, else r."""
        return self.covering / self.radius if self.limit.is_fixed else self.radius

    def order(self, error: str) -> float:
        """Exponent of the power law through an error."""
        return fitted_order(self.variable, self.errors[error])


@dataclass(frozen=True)
class CellCheck:
    """Errors at random points of a torus, beside those that their plane cells explain.

    All are over the largest |k1 + k2| of the shape.

    Attributes
    ----------
    radius : float
        Radius of the balls, L.
    ratio : float
        Covering radius over radius of the balls.
    numbers : ndarray of int, shape (m,)
        Which points.
    normal : dict of str to ndarray, each (m,)
        Normal component of the error, of volume and area.
    expected_normal : ndarray, shape (m,)
        What the edges of the cell make of it: its `TangentCells.edge_shares` times k1 and k2 in
        place of their sum.
    tangential : dict of str to ndarray, each (m,)
        Component along the centroid c of the cell, of volume and area.
    expected_tangential : ndarray, shape (m,)
        |c| / r^2; of the area with the other sign.
    """

    radius: float
    ratio: float
    numbers: npt.NDArray[np.int64]
    normal: dict[Quantity, Array]
    expected_normal: Array
    tangential: dict[Quantity, Array]
    expected_tangential: Array

    def normal_slope(self, quantity: Quantity) -> float:
        """Measured over expected, by least squares."""
        return _slope(self.expected_normal, self.normal[quantity])

    def tangential_slope(self, quantity: Quantity) -> float:
        """Measured over expected, by least squares."""
        return _slope(self.expected_tangential, self.tangential[quantity])


def _slope(expected: Array, measured: Array) -> float:
    return float(expected @ measured / (expected @ expected))


@dataclass(frozen=True)
class GradientConvergence:
    """All series, and the check of what the errors are made of."""

    series: tuple[Series, ...]
    cells: CellCheck

    def find(self, shape: str, sampling: Sampling, limit: JointLimit, quantity: Quantity) -> Series:
        """Look one series up."""
        (found,) = (
            one
            for one in self.series
            if (one.shape, one.sampling, one.limit, one.quantity)
            == (shape, sampling, limit, quantity)
        )
        return found


def estimated_vectors(union: BallUnion, quantity: Quantity) -> Array:
    """Estimates of (k1 + k2) n by the thesis, (n, d), 1/L: its left side of Eq. 4.15."""
    return (union.dimension - 1) * curvature_vectors(union, quantity)


def measure_gradient_convergence(
    on_curves: tuple[int, ...] = _ON_CURVES,
    on_surfaces: tuple[int, ...] = _ON_SURFACES,
    checked_of: int = _CHECKED_OF,
) -> GradientConvergence:
    """Measure the errors of both estimates on all shapes, samplings and joint limits.

    Parameters
    ----------
    on_curves, on_surfaces : tuple of int
        Numbers of points, increasing; at least two of each.
    checked_of : int
        Number of points of the torus on which the cells of some are looked at.

    Returns
    -------
    GradientConvergence
    """
    curves = ellipse(1.0, 1.0), ellipse(1.0, 0.6)
    surfaces = spheroid(1.0, 1.0), spheroid(1.0, 0.7), torus(0.4)
    series: list[Series] = []
    for shape in (*curves, *surfaces):
        counts = on_curves if shape.dimension == 2 else on_surfaces
        for sampling in get_args(Sampling):
            series += _measure_shape(shape, counts, sampling)
    return GradientConvergence(tuple(series), check_cells(torus(0.4), checked_of))


def _measure_shape(shape: Shape, counts: tuple[int, ...], sampling: Sampling) -> list[Series]:
    samples = [shape.sample(count, sampling) for count in counts]
    covering = np.array([shape.covering_radius(sample.points) for sample in samples])
    first = _FIRST_RADIUS
    found = []
    for limit in _LIMITS:
        radii = np.array([limit.radius(c, float(covering[0]), first) for c in covering])
        unions = [
            measure_balls(sample.points, radius)
            for sample, radius in zip(samples, radii, strict=True)
        ]
        hidden = np.array([np.count_nonzero(union.visible_areas == 0.0) for union in unions])
        for quantity in _QUANTITIES:
            rows = []
            for union, sample in zip(unions, samples, strict=True):
                expected = sample.mean_curvatures / (_fade(sample, first) if limit.is_fixed else 1)
                rows.append(_errors(estimated_vectors(union, quantity), sample, expected))
            errors = {name: np.array([row[name] for row in rows]) for name in ERRORS}
            numbers = np.array(counts), covering, radii, errors, hidden
            found.append(Series(shape.name, shape.dimension, sampling, limit, quantity, *numbers))
    return found


def _fade(sample: SampledShape, radius: float) -> Array | float:
    """Find what the curvature is divided by where r is not small: 1 + r^2 k1 k2, in 2D 1."""
    curvatures = sample.principal_curvatures
    return 1.0 if curvatures.shape[1] == 1 else 1.0 + radius**2 * curvatures.prod(axis=1)


def _errors(vectors: Array, sample: SampledShape, expected: Array) -> dict[str, float]:
    scale = float(np.abs(sample.mean_curvatures).max())
    wrong = (vectors - expected[:, np.newaxis] * sample.normals) / scale
    along = np.einsum("ij,ij->i", wrong, sample.normals)
    across = np.linalg.norm(wrong - along[:, np.newaxis] * sample.normals, axis=1)
    parts = {"": np.linalg.norm(wrong, axis=1), "normal_": np.abs(along), "tangential_": across}
    found = {}
    for name, part in parts.items():
        found[f"{name}rms"] = float(np.sqrt(np.mean(part**2)))
        found[f"{name}largest"] = float(part.max())
    return found


def check_cells(shape: Shape, n_points: int, radius: float = _CHECKED_RADIUS) -> CellCheck:
    """Compare the estimates at some of the random points of a surface with their cells.

    Parameters
    ----------
    shape : Shape
        A surface.
    n_points : int
        How many random points it has.
    radius : float
        Of the balls, L.

    Returns
    -------
    CellCheck
    """
    sample = shape.sample(n_points, "random")
    union = measure_balls(sample.points, radius)
    rng = np.random.default_rng(1)
    numbers = rng.choice(n_points, min(_CHECKED, n_points), replace=False)
    cells = tangent_cells(sample, numbers)
    scale = np.abs(sample.mean_curvatures).max()
    fade = (_fade(sample, radius) * np.ones(n_points))[numbers] * scale
    limit = sample.mean_curvatures[numbers] / fade
    by_edges = np.einsum("ma,ma->m", sample.principal_curvatures[numbers], cells.edge_shares)
    distances = np.linalg.norm(cells.centroids, axis=1)
    normal: dict[Quantity, Array] = {}
    tangential: dict[Quantity, Array] = {}
    for quantity in _QUANTITIES:
        vectors = estimated_vectors(union, quantity)[numbers] / scale
        along = np.einsum("ij,ij->i", vectors, sample.normals[numbers])
        across = np.einsum("ij,ij->i", vectors, cells.centroids) / distances
        normal[quantity], tangential[quantity] = along - limit, across
    return CellCheck(
        radius, shape.covering_radius(sample.points) / radius, numbers,
        normal, by_edges / fade - limit, tangential, distances / radius**2 / scale,
    )  # fmt: skip


def draw_gradient_convergence(found: GradientConvergence) -> Figure:
    """Draw the errors in both limits, and what they are made of."""
    figure = new_figure(11.5, 10.5)
    grid = figure.subplots(3, 3)
    shapes = ("ellipse", "sphere", "torus")
    for axes, shape in zip(grid[0], shapes, strict=True):
        _draw_series(axes, found, shape, FIXED_RADIUS)
        axes.set_title(f"{shape}: r fixed, error against the limit at that r", fontsize=9)
    for axes, shape in zip(grid[1], shapes, strict=True):
        _draw_series(axes, found, shape, RATIO_AS_RADIUS)
        axes.set_title(f"{shape}: ε ~ r², error against the curvature", fontsize=9)
    _draw_series(grid[2, 0], found, "ellipse", FIXED_RATIO)
    grid[2, 0].set_title("ellipse: ε/r fixed, error against the curvature", fontsize=9)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=8)
    check = found.cells
    parts = (
        ("normal", check.expected_normal, check.normal, "Σ w h κ(u) / a - H"),
        ("tangential", check.expected_tangential, check.tangential, "|centroid| / r²"),
    )
    for axes, (part, expected, measured, formula) in zip(grid[2, 1:], parts, strict=True):
        for quantity, color in zip(_QUANTITIES, ("tab:red", "tab:blue"), strict=True):
            axes.plot(expected, measured[quantity], ".", ms=2.5, color=color, label=quantity)
        ends = np.array([expected.min(), expected.max()])
        axes.plot(ends, ends, color="0.3", lw=0.8)
        if part == "tangential":
            axes.plot(ends, -ends, color="0.3", lw=0.8)
        axes.set_title(f"torus, random: {part} error and its cause", fontsize=9)
        axes.set_xlabel(f"expected from the cell, {formula}", fontsize=8)
        axes.set_ylabel("measured, over max |H|", fontsize=8)
        axes.legend(fontsize=7, markerscale=3)
    for axes in grid.flat:
        axes.tick_params(labelsize=7)
        axes.grid(alpha=0.25)
    return figure


#: Sampling, quantity, error, label and how its line is drawn.
_LINES: tuple[tuple[Sampling, Quantity, str, str, dict[str, object]], ...] = (
    ("even", "volume", "rms", "even, volume", {"color": "tab:green", "marker": "o"}),
    ("even", "area", "rms", "even, area", {"color": "tab:green", "ls": "--", "marker": "x"}),
    ("random", "volume", "normal_rms", "random, volume, normal part",
     {"color": "tab:blue", "marker": "o"}),
    ("random", "area", "normal_rms", "random, area, normal part",
     {"color": "tab:blue", "ls": "--", "marker": "x"}),
    ("random", "volume", "tangential_rms", "random, volume, tangential part",
     {"color": "tab:red", "marker": "o"}),
    ("random", "area", "tangential_rms", "random, area, tangential part",
     {"color": "tab:red", "ls": "--", "marker": "x"}),
)  # fmt: skip


def _draw_series(axes: Axes, found: GradientConvergence, shape: str, limit: JointLimit) -> None:
    for sampling, quantity, error, label, style in _LINES:
        one = found.find(shape, sampling, limit, quantity)
        axes.loglog(one.variable, one.errors[error], ms=4, lw=1.1, label=label, **style)
    even = found.find(shape, "even", limit, "volume")
    random = found.find(shape, "random", limit, "volume")
    if limit is not FIXED_RATIO:
        draw_slope(axes, even.variable, 2, 0.5 * float(even.errors["rms"].max()))
    if limit is FIXED_RADIUS:
        draw_slope(axes, random.variable, 1, 2.5 * float(random.errors["tangential_rms"].max()))
    if limit is FIXED_RATIO:
        draw_slope(axes, random.variable, -1, 2.5 * float(random.errors["tangential_rms"].min()))
    mark_decades(axes)
    axes.set_xlabel("ε/r" if limit.is_fixed else "r", fontsize=8)
    axes.set_ylabel("RMS error over max |H|", fontsize=8)


def judge(found: GradientConvergence) -> Verdict:
    """Compare the orders with the thesis'.

    Where epsilon / r falls as r, Proposition 6 says that the vectors' error is of order 1 in r
    or better. It is counted for how many shapes and samplings the RMS error of the volume's
    gradient has a fitted order of 0.8 or more: all, some or none.
    """
    keeps = [
        series.order("rms") >= _ORDER_ENOUGH
        for series in found.series
        if series.limit == RATIO_AS_RADIUS and series.quantity == "volume"
    ]
    return verdict_on(keeps)


_EXPLANATION = """
Errors are root mean squares over the points, over the largest |H|, H = k1 + k2; eps is the
covering radius, measured; r starts at 0.16 (the
shapes have the size 1), and orders are fitted against eps/r where
r is fixed, else against r. What the thesis left open: the gradient of the boundary's area over
S_i converges where that of the volume does, at the same orders. On n even points of a circle,
with x = sin(pi/n) R/r, the volume gives (1/R) x sqrt(1 - x^2) / arcsin x = (1/R) (1 - 2x^2/3 -
...) and the area (1/R) x / (sqrt(1 - x^2) arcsin x) = (1/R) (1 + x^2/3 + ...): order 2 in eps/r,
and no error in r. As eps/r falls with r fixed, both tend to H in 2D and to H / (1 + r^2 k1 k2) in
3D, so even points have O((eps/r)^2) + O(r^2), better than the thesis' O(eps/r) + O(r). Uneven
points do not keep the thesis' bound, for two reasons that its proof passes over. (1) Replacing
p_i by the projection of x leaves, to first order, the tangential vector +c/r^2 for the volume and
-c/r^2 for the area, c being the centroid of the point's Voronoi cell seen from it (in 2D half the
difference of its two arms): an error of eps/r^2, which grows as 1/r where eps/r is fixed, stalls
where eps ~ r^2 and vanishes only where eps = o(r^2). The signs say why the volume's flow clumps
points and the area's is Lloyd's algorithm; their mean is free of it. (2) The walls of a Voronoi
cell are not normal to the surface: from -r to r the cell widens by the sum over its edges of
length w times distance h times the normal curvature kappa(u) across, over its area a, in place
of H. Both are equal in 2D, where the normal part is right, on spheres and on lattices; on uneven
points of a surface with k1 != k2 the normal part is off by a share of |k1 - k2| that no limit
removes; only averages over many points can converge. The spirals on spheres and ellipsoids are
even but at their poles: in the largest norm the tangential error there is of order 1 in eps/r
with r fixed, and stays where eps ~ r^2, as on random points.
""".strip().replace("\n", " ")


def _in_words(check: CellCheck) -> str:
    error = check.normal["volume"]
    return (
        f"The last two pictures: at {len(error)} of the random points of a torus, with "
        f"eps/r = {check.ratio:.2f} and r = {check.radius:g}, the normal error of the volume's "
        f"vectors is {error.mean():.3f} on average with a standard deviation of {error.std():.3f}, "
        "both over the largest |H|; measured over expected error is, by least squares, "
        f"{check.normal_slope('volume'):.2f} for its normal and "
        f"{check.tangential_slope('volume'):.2f} for its tangential part, and "
        f"{check.normal_slope('area'):.2f} and {check.tangential_slope('area'):.2f} for the area's."
    )


def _ranges(found: GradientConvergence) -> str:
    def of(sampling: Sampling, limit: JointLimit) -> str:
        return ranges_in_words({
            one.shape: one.variable for one in found.series
            if (one.sampling, one.limit, one.quantity) == (sampling, limit, "volume")
        })  # fmt: skip

    return (
        f"With r fixed, eps/r runs over {of('even', FIXED_RADIUS)} of even points and over "
        f"{of('random', FIXED_RADIUS)} of random ones; with eps ~ r^2, r over "
        f"{of('even', RATIO_AS_RADIUS)} and over {of('random', RATIO_AS_RADIUS)}."
    )


def outcome_of(found: GradientConvergence) -> Outcome:
    """Put the numbers into words and tables."""

    def order(shape: str, sampling: Sampling, limit: JointLimit, error: str = "rms") -> float:
        return found.find(shape, sampling, limit, "volume").order(error)

    def of_all(sampling: Sampling, quantity: Quantity) -> list[float]:
        return [
            one.order("rms")
            for one in found.series
            if (one.limit, one.sampling, one.quantity) == (FIXED_RADIUS, sampling, quantity)
        ]

    even = of_all("even", "volume") + of_all("even", "area")
    caption = (
        f"Even points keep Prop. 6 (RMS): order {min(even):.2f}-{max(even):.2f} in ε/r, by volume "
        "and by area (open in the thesis). Random ones do not: ellipse "
        f"r^{order('ellipse', 'random', FIXED_RATIO):.1f} at fixed ε/r; torus, ε ~ r²: order "
        f"{order('torus', 'random', RATIO_AS_RADIUS):.1f}, not 1."
    )
    return Outcome(
        judge(found),
        caption,
        partial(draw_gradient_convergence, found),
        {
            "gradient-convergence-errors": _error_table(found),
            "gradient-convergence-orders": _order_table(found),
            "gradient-convergence-cells": _cell_table(found.cells),
        },
        f"{_EXPLANATION} {_ranges(found)} {_in_words(found.cells)}",
    )


def _names(series: Series) -> dict[str, object]:
    return {
        "shape": series.shape,
        "sampling": series.sampling,
        "limit": series.limit.name,
        "quantity": series.quantity,
    }


def _columns(rows: list[dict[str, object]]) -> Table:
    return table_of(list(rows[0]), [list(row.values()) for row in rows])


def _error_table(found: GradientConvergence) -> Table:
    return _columns([
        _names(one) | {
            "n_points": one.n_points[i], "eps": one.covering[i], "r": one.radius[i],
            "eps_over_r": one.covering[i] / one.radius[i], "hidden_points": one.hidden[i],
        } | {name: one.errors[name][i] for name in ERRORS}
        for one in found.series for i in range(len(one.radius))
    ])  # fmt: skip


def _order_table(found: GradientConvergence) -> Table:
    rows = []
    for one in found.series:
        ratios = one.covering / one.radius
        rows.append(
            _names(one)
            | {
                "order_in": "eps/r" if one.limit.is_fixed else "r",
                "eps_over_r_from": ratios[0], "eps_over_r_to": ratios[-1],
                "r_from": one.radius[0], "r_to": one.radius[-1],
            }
            | {name: one.order(name) for name in ERRORS}
        )  # fmt: skip
    return _columns(rows)


def _cell_table(check: CellCheck) -> Table:
    return {
        "point": check.numbers,
        "normal_error_expected": check.expected_normal,
        "normal_error_volume": check.normal["volume"],
        "normal_error_area": check.normal["area"],
        "centroid_over_r2": check.expected_tangential,
        "tangential_error_volume": check.tangential["volume"],
        "tangential_error_area": check.tangential["area"],
    }


def _run(_inputs: Inputs) -> Outcome:
    return outcome_of(measure_gradient_convergence())


EXPERIMENT = Experiment(
    "gradient-convergence",
    "Proposition 6, Section 4.3, and Section 4.4",
    "gradients of volume and boundary area against the mean curvature vector",
    _run,
)
