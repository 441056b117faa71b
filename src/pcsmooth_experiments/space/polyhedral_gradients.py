"""Gradients of unions of cubes, on a circle and on the corners of a cube (Figures 34 and 35)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, get_args

import numpy as np
import numpy.typing as npt

from pcsmooth.bodies.presets import load_presets
from pcsmooth.energies.polyhedra.union import measure_polyhedra
from pcsmooth.energies.protocol import UnionName
from pcsmooth.plots.figures import new_figure
from pcsmooth_experiments.claims import verdict_on
from pcsmooth_experiments.experiment import Experiment, Inputs, Outcome, Verdict
from pcsmooth_experiments.space.restricted_polytopes import restricted_corners, restricted_facets

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = npt.NDArray[np.float64]

_UNIONS: tuple[UnionName, ...] = get_args(UnionName)

#: The thesis gives no radii; the first of each is drawn and decides. Neighbours are 0.39 apart on
#: the circle and 2 on the cube.
_ON_CIRCLE = (0.6, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.8, 1.0)
_ON_CUBE = (1.5, 1.2, 2.0)


@dataclass(frozen=True)
class Gradients:
    """Gradients of the volume of one union.

    Attributes
    ----------
    radius : float
        r, L.
    union : {"naive", "inclusion-exclusion", "exact"}
        How it is computed.
    vectors : ndarray, shape (n, 3)
        The gradients, L^2.
    outward : ndarray, shape (n,)
        Their components away from the centre of the points, L^2.
    """

    radius: float
    union: UnionName
    vectors: Array
    outward: Array

    @property
    def cosines(self) -> Array:
        """Cosine of the angle between each gradient and the direction away from the centre."""
        lengths = np.linalg.norm(self.vectors, axis=1)
        return np.asarray(
            np.divide(self.outward, lengths, out=np.zeros_like(lengths), where=lengths > 0.0)
        )


@dataclass(frozen=True)
class PolyhedralGradients:
    """Gradients under a cube.

    Attributes
    ----------
    circle, cube : ndarray, shape (n, 3)
        The points, L.
    at_corners : ndarray of bool, shape (n,)
        Which points of the circle are nearest to the corners of the cube.
    on_circle, on_cube : tuple of Gradients
        For every radius and union.
    """

    circle: Array
    cube: Array
    at_corners: npt.NDArray[np.bool_]
    on_circle: tuple[Gradients, ...]
    on_cube: tuple[Gradients, ...]

    @property
    def turning_radius(self) -> float:
        """Smallest radius from which the 4 points at the corners have inward naive gradients."""
        inward = [
            (one.radius, bool((one.outward[self.at_corners] < 0.0).all()))
            for one in sorted(self.on_circle, key=lambda one: one.radius)
            if one.union == "naive"
        ]
        last_outward = max((radius for radius, turned in inward if not turned), default=0.0)
        return min((radius for radius, _ in inward if radius > last_outward), default=np.inf)


def measure_polyhedral_gradients(
    circle: Array,
    cube: Array,
    circle_radii: tuple[float, ...] = _ON_CIRCLE,
    cube_radii: tuple[float, ...] = _ON_CUBE,
) -> PolyhedralGradients:
    """Measure the gradients of the volume of unions of cubes.

    Parameters
    ----------
    circle : ndarray, shape (n, 3)
        Points of a circle around the origin in a plane of two axes.
    cube : ndarray, shape (8, 3)
        Corners of a cube around the origin.
    circle_radii, cube_radii : tuple of float
        r; the first of each is the one that is drawn.

    Returns
    -------
    PolyhedralGradients
    """
    in_order = np.sort(np.abs(circle), axis=1)
    at_corners = np.zeros(len(circle), np.bool_)
    at_corners[np.argsort(in_order[:, 1])[-4:]] = True  # the smaller coordinate is largest there
    return PolyhedralGradients(
        circle, cube, at_corners, _gradients(circle, circle_radii), _gradients(cube, cube_radii)
    )


def _gradients(points: Array, radii: tuple[float, ...]) -> tuple[Gradients, ...]:
    body = load_presets()["cube"]
    away = points / np.linalg.norm(points, axis=1, keepdims=True)
    found = []
    for radius in radii:
        for union in _UNIONS:
            vectors = measure_polyhedra(points, radius, body, union).volume_gradient
            found.append(Gradients(radius, union, vectors, np.einsum("ij,ij->i", vectors, away)))
    return tuple(found)


def draw_polyhedral_gradients(found: PolyhedralGradients) -> Figure:
    """Draw cells and gradients on the circle, and on the cube for all three unions."""
    figure = new_figure(13.0, 4.2)
    grid = figure.add_gridspec(1, 4, width_ratios=[1.1, 1, 1, 1])
    axes = figure.add_subplot(grid[0])
    (flat,) = (axis for axis in range(3) if np.ptp(found.circle[:, axis]) < 1e-6)
    points = np.delete(found.circle, flat, axis=1)
    drawn = found.on_circle[0]
    for number in range(len(points)):
        cell = restricted_corners(points, number, drawn.radius, load_presets()["square"])
        axes.fill(*cell.T, fc="0.93", ec="tab:blue", lw=0.8)
    arrows = 0.45 * np.delete(drawn.vectors, flat, axis=1) / np.linalg.norm(
        drawn.vectors, axis=1
    ).max()  # fmt: skip
    for chosen, color in ((found.at_corners, "tab:red"), (~found.at_corners, "tab:green")):
        axes.quiver(
            *points[chosen].T, *arrows[chosen].T, color=color, angles="xy", scale_units="xy",
            scale=1.0, width=0.009, zorder=3,
        )  # fmt: skip
    axes.plot(*points.T, "k.", ms=5, zorder=4)
    axes.set_aspect("equal")
    axes.set_title(f"Figure 34: cells and gradients, naive, r = {drawn.radius:g}", fontsize=9)
    axes.tick_params(labelsize=7)
    for column, one in enumerate(found.on_cube[: len(_UNIONS)], start=1):
        _draw_cube(figure.add_subplot(grid[column], projection="3d"), found.cube, one)
    return figure


def _draw_cube(axes: object, points: Array, one: Gradients) -> None:
    from mpl_toolkits.mplot3d import Axes3D
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    assert isinstance(axes, Axes3D)
    body = load_presets()["cube"]
    for number in range(len(points)):
        facets = restricted_facets(points, number, one.radius, body)
        axes.add_collection3d(
            Poly3DCollection(
                facets, facecolors=(0.3, 0.5, 0.9, 0.03), edgecolors="tab:blue", lw=0.6
            )
        )
    arrows = 2.0 * one.vectors / np.linalg.norm(one.vectors, axis=1).max()
    axes.quiver(*points.T, *arrows.T, color="tab:red", lw=1.5, arrow_length_ratio=0.25)
    axes.scatter(*points.T, color="k", s=12, depthshade=False)
    reach = 1.0 + one.radius
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), zlim=(-reach, reach))
    axes.set_box_aspect((1, 1, 1), zoom=1.15)
    axes.view_init(18, -58)
    axes.set_axis_off()
    axes.set_title(
        f"Figure 35: {one.union}, r = {one.radius:g}\nangle to the diagonal at most "
        f"{np.degrees(np.arccos(min(1.0, one.cosines.min()))):.0f}°",
        fontsize=9,
    )


def judge(found: PolyhedralGradients) -> Verdict:
    """Compare with the thesis' two statements, at the radii that are drawn.

    On the circle the naive gradients point inwards at the 4 points at the corners of the cube, and
    outwards at all others; on the cube every component of every gradient points outwards, naive
    and by inclusion-exclusion. Both, one or none of them hold.
    """
    naive = found.on_circle[0]
    holds = (
        bool(
            (naive.outward[found.at_corners] < 0.0).all()
            and (naive.outward[~found.at_corners] > 0.0).all()
        ),
        all(
            bool((one.vectors * np.sign(found.cube) > 0.0).all())
            for one in found.on_cube
            if one.radius == found.on_cube[0].radius and one.union != "exact"
        ),
    )
    return verdict_on(holds)


_EXPLANATION = """
The thesis does not give its radii. The flow follows minus the gradient: inward gradients push the
4 points out, towards corners, and all others in. With small radii the squares of neighbours barely
meet, and the 4 gradients point outwards too. They point inwards in the naive union only, whose
limit is the radial function of K; the exact union tends to the support function, under which a
slanted edge has no force. On the cube's corners the exact gradients are not along the diagonals
where sides of several cubes lie in one plane: there the volume has no gradient, and the first of
the points gets what they share; the components still point outwards.
""".strip().replace("\n", " ")


def outcome_of(found: PolyhedralGradients) -> Outcome:
    """Put the numbers into words and tables."""
    naive = found.on_circle[0]
    by_diagonal = {
        one.union: np.degrees(np.arccos(min(1.0, float(one.cosines.min()))))
        for one in found.on_cube[: len(_UNIONS)]
    }
    caption = (
        f"Fig. 34: outward component {naive.outward[found.at_corners].max():.2f} at 4 corners, "
        f"{naive.outward[~found.at_corners].min():.2f} or more elsewhere (r = {naive.radius:g}). "
        f"Fig. 35: all outwards, within {by_diagonal['naive']:.0f}° of the diagonal naive, "
        f"{by_diagonal['inclusion-exclusion']:.0f}° incl.-excl."
    )
    return Outcome(
        judge(found),
        caption,
        partial(draw_polyhedral_gradients, found),
        {
            "polyhedral-gradients-circle": _table(found.circle, found.on_circle),
            "polyhedral-gradients-cube": _table(found.cube, found.on_cube),
        },
        f"{_EXPLANATION} Of the radii tried, they are inward from {found.turning_radius:g} on.",
    )


def _table(points: Array, found: tuple[Gradients, ...]) -> dict[str, npt.NDArray[np.generic]]:
    counts = [len(points)] * len(found)
    vectors = np.concatenate([one.vectors for one in found])
    places = np.concatenate([points] * len(found))
    return {
        "union": np.repeat([one.union for one in found], counts),
        "r": np.repeat([one.radius for one in found], counts),
        **{name: places[:, axis] for axis, name in enumerate("xyz")},
        **{f"gradient_{name}": vectors[:, axis] for axis, name in enumerate("xyz")},
        "outward": np.concatenate([one.outward for one in found]),
        "cosine": np.concatenate([one.cosines for one in found]),
    }


def _run(inputs: Inputs) -> Outcome:
    return outcome_of(
        measure_polyhedral_gradients(inputs.points("circle_16.xyz"), inputs.points("cube.xyz"))
    )


EXPERIMENT = Experiment(
    "polyhedral-gradients",
    "Figures 34 and 35",
    "gradients of unions of cubes on a circle and on the corners of a cube",
    _run,
)
