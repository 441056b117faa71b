"""A sphere that flows under polyhedra (Figure 38)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, get_args

import numpy as np
import numpy.typing as npt
from scipy.spatial import ConvexHull

from pcsmooth.bodies.convex_body import ConvexBody
from pcsmooth.bodies.presets import load_presets
from pcsmooth.energies.polyhedra.union import PolyhedronEnergy
from pcsmooth.energies.protocol import UnionName
from pcsmooth.flows.euler import Euler
from pcsmooth.flows.flow import run_flow
from pcsmooth.neighbors.spacing import mean_spacing
from pcsmooth.plots.figures import new_figure
from pcsmooth_experiments.claims import verdict_on
from pcsmooth_experiments.experiment import Experiment, Inputs, Outcome, Table, Verdict

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = npt.NDArray[np.float64]

_BODIES = ("cube", "bipyramid", "icosahedron")
_UNIONS: tuple[UnionName, ...] = get_args(UnionName)

#: Radius in mean spacings; the thesis gives neither radius nor step.
_RADIUS = 2.0

#: Number of the thesis' iterations, and of more.
_REPORTED, _MORE = 10, 40

#: A facet of the hull faces along a facet of K if it is within this angle, degrees.
_FACING = 10.0


@dataclass(frozen=True)
class Facing:
    """How the convex hull of a cloud faces along the facets of a body.

    Attributes
    ----------
    median : float
        Angle to the nearest normal of K of half of the hull's area, degrees.
    share : float
        Share of the hull's area that is within 10 degrees of a normal of K.
    """

    median: float
    share: float


@dataclass(frozen=True)
class PolyhedralFlow:
    """One flow.

    Attributes
    ----------
    body : str
        Name of K.
    union : {"naive", "inclusion-exclusion", "exact"}
        How the union is computed.
    clouds : dict of int to ndarray
        Positions after 0, 10 and more iterations, (n, 3), L.
    facing : tuple of Facing
        Of every state from 0 on.
    volumes : ndarray
        Volume of the union in every state, L^3.
    """

    body: str
    union: UnionName
    clouds: dict[int, Array]
    facing: tuple[Facing, ...]
    volumes: Array

    @property
    def medians(self) -> Array:
        """Median angles of all states, degrees."""
        return np.array([facing.median for facing in self.facing])


def facing_of(points: Array, body: ConvexBody) -> Facing:
    """Measure how the convex hull of points faces along the facets of a body."""
    hull = ConvexHull(points)
    edges = np.diff(points[hull.simplices], axis=1)
    areas = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    cosines = (hull.equations[:, :3] @ body.normals.T).max(axis=1)
    angles = np.degrees(np.arccos(cosines.clip(-1.0, 1.0)))
    order = np.argsort(angles, kind="stable")
    covered = np.cumsum(areas[order]) / areas.sum()
    half = min(int(np.searchsorted(covered, 0.5)), len(order) - 1)
    return Facing(float(angles[order[half]]), float(areas[angles <= _FACING].sum() / areas.sum()))


def measure_polyhedral_flows(
    points: Array, iterations: tuple[int, int] = (_REPORTED, _MORE)
) -> tuple[PolyhedralFlow, ...]:
    """Let points flow under three bodies in all three unions, with automatic steps.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        A sphere, L.
    iterations : tuple of two int
        After how many the clouds are kept; the second is how many there are in all.

    Returns
    -------
    tuple of PolyhedralFlow
    """
    radius = _RADIUS * mean_spacing(points)
    found = []
    for name in _BODIES:
        body = load_presets()[name]
        for union in _UNIONS:
            energy = PolyhedronEnergy(radius, body, union)
            states = list(run_flow(energy, points, Euler(), iterations[1]))
            found.append(
                PolyhedralFlow(
                    name,
                    union,
                    {count: states[count].points for count in (0, *iterations)},
                    tuple(facing_of(state.points, body) for state in states),
                    np.array([state.evaluation.value for state in states]),
                )
            )
    return tuple(found)


def draw_polyhedral_flows(found: tuple[PolyhedralFlow, ...]) -> Figure:
    """Draw the hull before and after, a row for each body."""
    figure = new_figure(12.5, 7.2)
    _, reported, more = found[0].clouds
    columns: list[tuple[UnionName, int]] = [
        ("naive", 0), ("naive", reported), ("inclusion-exclusion", reported), ("exact", reported),
        ("naive", more), ("exact", more),
    ]  # fmt: skip
    for row, name in enumerate(_BODIES):
        body = load_presets()[name]
        for column, (union, count) in enumerate(columns):
            (flow,) = (one for one in found if (one.body, one.union) == (name, union))
            place = row * len(columns) + column + 1
            axes = figure.add_subplot(len(_BODIES), len(columns), place, projection="3d")
            _draw_hull(axes, flow.clouds[count], body)
            title = f"{name}: sphere" if count == 0 else f"{union}, {count} steps"
            axes.set_title(f"{title}\nmedian angle {flow.medians[count]:.1f}°", fontsize=9)
    return figure


def _draw_hull(axes: object, points: Array, body: ConvexBody) -> None:
    from mpl_toolkits.mplot3d import Axes3D
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    assert isinstance(axes, Axes3D)
    hull = ConvexHull(points)
    normals = hull.equations[:, :3]
    angles = np.degrees(np.arccos((normals @ body.normals.T).max(axis=1).clip(-1.0, 1.0)))
    light = 0.55 + 0.45 * (normals @ np.array([0.35, -0.6, 0.72])).clip(0.0)
    faces = np.outer(light, [0.75, 0.78, 0.82])
    faces[angles <= _FACING] = np.outer(light, [0.98, 0.72, 0.35])[angles <= _FACING]
    axes.add_collection3d(
        Poly3DCollection(
            points[hull.simplices], facecolors=faces, edgecolors=(0, 0, 0, 0.15), lw=0.2
        )
    )
    reach = float(np.abs(points).max())
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), zlim=(-reach, reach))
    axes.set_box_aspect((1, 1, 1), zoom=1.3)
    axes.view_init(22.0, -62.0)
    axes.set_axis_off()


def judge(found: tuple[PolyhedralFlow, ...]) -> Verdict:
    """Compare with "the flow seems to converge towards the polyhedron".

    It does if the volume falls in every step, the median angle between the hull and K is smaller
    after the thesis' iterations than before, and smaller still after all. It is counted for how
    many bodies and unions of the thesis (naive and inclusion-exclusion) it does: all, some, none.
    """
    holds = []
    for flow in found:
        if flow.union == "exact":
            continue
        start, reported, more = flow.clouds
        medians = flow.medians
        holds.append(
            bool((np.diff(flow.volumes) < 0.0).all())
            and bool(medians[more] < medians[reported] < medians[start])
        )
    return verdict_on(holds)


_EXPLANATION = """
The thesis gives neither radius nor step: r is two mean spacings, steps are automatic. Colour marks
what of the hull is within 10 degrees of a facet of K. After 10 such steps the sphere has begun to
turn into K; the rest needs more. Where the flow ends depends on the union: the exact one tends to
the integral of the support function of K, whose shape of least energy is K itself (Wulff's
theorem); the naive one tends to that of the radial function (the thesis' Eq. 4.19), whose least
shape is K with pillows on its facets, so that it comes nearer to K without becoming K. In Eq. 4.18
the thesis' rho_K(n) = -rho_K(-n) for symmetric K must have no minus.
""".strip().replace("\n", " ")


def outcome_of(found: tuple[PolyhedralFlow, ...]) -> Outcome:
    """Put the numbers into words and tables."""
    start, reported, more = found[0].clouds

    def angles(union: UnionName, count: int) -> str:
        return ", ".join(f"{one.medians[count]:.0f}°" for one in found if one.union == union)

    caption = (
        f"Median angle of hull to K (cube, bipyramid, icosahedron): "
        f"{angles('naive', start)}; "
        f"after {reported} steps naive {angles('naive', reported)}, exact "
        f"{angles('exact', reported)}; after {more} {angles('naive', more)}, exact "
        f"{angles('exact', more)}."
    )
    return Outcome(
        judge(found),
        caption,
        partial(draw_polyhedral_flows, found),
        {"polyhedral-flows": _table(found)},
        _EXPLANATION,
    )


def _table(found: tuple[PolyhedralFlow, ...]) -> Table:
    counts = [len(flow.volumes) for flow in found]
    facing = [facing for flow in found for facing in flow.facing]
    return {
        "body": np.repeat([flow.body for flow in found], counts),
        "union": np.repeat([flow.union for flow in found], counts),
        "iteration": np.concatenate([np.arange(count) for count in counts]),
        "volume": np.concatenate([flow.volumes for flow in found]),
        "median_angle": np.array([one.median for one in facing]),
        "share_within_10_degrees": np.array([one.share for one in facing]),
    }


def _run(inputs: Inputs) -> Outcome:
    return outcome_of(measure_polyhedral_flows(inputs.points("sphere_1k.xyz")))


EXPERIMENT = Experiment(
    "polyhedral-flows", "Figure 38", "a sphere that flows under polyhedra", _run
)
