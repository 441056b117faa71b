"""Points on a segment whose ends are fixed, under both flows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from pcsmooth.plots.figures import new_figure
from pcsmooth_experiments.claims import in_words, verdict_on
from pcsmooth_experiments.experiment import Experiment, Inputs, Outcome, Table
from pcsmooth_experiments.plane.cloud_panels import AREA, BEFORE, PERIMETER
from pcsmooth_experiments.plane.curve_gaps import Gaps, gaps_along
from pcsmooth_experiments.plane.descents import before_and_after
from pcsmooth_experiments.plane.ellipse import REPORT_RADIUS, Array
from pcsmooth_experiments.row_tables import table_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Iterations of the thesis.
_ITERATIONS = 50

#: Connected components of the union in the thesis.
COMPONENTS = 5

#: Gaps within a component and between components of the segment made for that, and a radius
#: that lies between them.
_INNER_GAPS, _OUTER_GAP, _FIVE_RADIUS = (6.0, 12.0), 27.5, 10.0

_COLORS = {"before": BEFORE, "area": AREA, "perimeter": PERIMETER}


@dataclass(frozen=True)
class SegmentFlow:
    """Both flows of points on a segment.

    Attributes
    ----------
    name : str
        Which points.
    radius : float
        Of the disks, L.
    components : int
        Connected components of their union before.
    points : dict of str to ndarray
        "before" and after the "area" and the "perimeter" flow, (n, 2), L.
    gaps : dict of str to Gaps
        Between consecutive points of these.
    """

    name: str
    radius: float
    components: int
    points: dict[str, Array]
    gaps: dict[str, Gaps]

    def evens(self, flow: str) -> bool:
        """Whether the gaps are more even after a flow."""
        return self.gaps[flow].variation < self.gaps["before"].variation


def five_components() -> Array:
    """Make fifteen points from (-100, 0) to (100, 0) in five groups of three.

    Returns
    -------
    ndarray, shape (15, 2)
        With disks of radius 10, one component for each group.
    """
    gaps = np.append(np.tile([*_INNER_GAPS, _OUTER_GAP], COMPONENTS - 1), _INNER_GAPS)
    along = np.concatenate([[0.0], np.cumsum(gaps)]) - 100.0
    return np.column_stack([along, np.zeros(len(along))])


def count_components(points: Array, radius: float) -> int:
    """Count the connected components of disks around points (n, 2) on a line along x."""
    return 1 + int(np.count_nonzero(np.diff(np.sort(points[:, 0])) > 2.0 * radius))


def possible_components(points: Array) -> Table:
    """Tell how many components disks around points (n, 2) on a line along x can have.

    Returns
    -------
    dict
        radius_from: the least radius, L, with that many components.
    """
    radii = np.unique(np.append(0.0, 0.5 * np.diff(np.sort(points[:, 0]))))
    return {
        "radius_from": radii,
        "components": np.array([count_components(points, radius) for radius in radii]),
    }


def measure_segment(name: str, points: Array, radius: float) -> SegmentFlow:
    """Run 50 iterations of both flows with the outermost points fixed.

    Parameters
    ----------
    name : str
        Which points.
    points : ndarray, shape (n, 2)
        On a line along x, L.
    radius : float
        Of the disks, L.

    Returns
    -------
    SegmentFlow
    """
    fixed: npt.NDArray[np.bool_] = np.zeros(len(points), np.bool_)
    fixed[[points[:, 0].argmin(), points[:, 0].argmax()]] = True
    states = before_and_after(points, radius, _ITERATIONS, fixed)
    return SegmentFlow(
        name,
        radius,
        count_components(points, radius),
        states,
        {state: gaps_along(moved) for state, moved in states.items()},
    )


def draw_segments(found: list[SegmentFlow]) -> Figure:
    """Draw the points with their disks before and after the flows (Figure 215)."""
    figure = new_figure(8.6, 2.5 * len(found) + 0.3)
    for number, flow in enumerate(found, 1):
        axes = figure.add_subplot(len(found), 1, number)
        heights = -3.0 * flow.radius * np.arange(len(flow.points))
        for height, (state, points) in zip(heights, flow.points.items(), strict=True):
            placed = points + np.array([0.0, height])
            axes.plot(*placed.T, ".", color=_COLORS[state], markersize=8)
            _draw_disks(axes, placed, flow.radius, _COLORS[state])
        axes.set_aspect("equal")
        axes.set_xlim(-120.0, 120.0)
        axes.set_yticks(
            heights,
            [
                f"{'before' if state == 'before' else f'after the {state} flow'}\n"
                f"CV of the gaps {gaps.variation:.2f}"
                for state, gaps in flow.gaps.items()
            ],
        )
        axes.set_title(
            f"{flow.name}, r = {flow.radius:g}: "
            f"{flow.components} component{'s' if flow.components > 1 else ''} before"
        )
    return figure


def _draw_disks(axes: Axes, points: Array, radius: float, color: str) -> None:
    from matplotlib.patches import Circle

    for point in points:
        axes.add_patch(Circle(point, radius, color=color, alpha=0.12, linewidth=0))


def _run(inputs: Inputs) -> Outcome:
    line = inputs.points("line_fixed.xy")
    found = [
        measure_segment("the author's points", line, REPORT_RADIUS),
        measure_segment("points in five groups", five_components(), _FIVE_RADIUS),
    ]
    ours, five = found
    is_evened, are_five_evened = ours.evens("perimeter"), five.evens("perimeter")
    area_evens = ours.evens("area") or five.evens("area")
    return Outcome(
        verdict=verdict_on([is_evened, are_five_evened, area_evens]),
        caption=(
            f"CV of the gaps in {ours.components} component {_change(ours, 'perimeter')} by "
            f"perimeter ({in_words(is_evened)}), {_change(ours, 'area')} by area "
            f"({in_words(area_evens)}); in {five.components} {_change(five, 'perimeter')} and "
            f"{_change(five, 'area')} ({in_words(are_five_evened)})."
        ),
        draw=lambda: draw_segments(found),
        tables={"segment": _table(found), "segment-components": possible_components(line)},
        explanation=_explain(line, ours),
    )


def _explain(line: Array, ours: SegmentFlow) -> str:
    possible = sorted(set(possible_components(line)["components"].tolist()))
    counts = ", ".join(str(count) for count in possible)
    clumps = count_components(ours.points["area"], ours.radius)
    return (
        "On a line the area of two disks, as a function of their distance, is concave: a point "
        "between two others goes to the nearer one, so the area flow gathers the points wherever "
        "it can. The perimeter is convex: the point goes to the middle, and the perimeter flow "
        "evens the points of a component that is fixed at both ends. Components apart do not act "
        "on each other, so one that is held at no end or at one only contracts, under both flows: "
        f"five components cannot become even. The author's points have {counts} components, by "
        f"the radius{'' if COMPONENTS in possible else f', never {COMPONENTS}'}; so the five are "
        f"made here. After the area flow with r = {ours.radius:g} the author's have {clumps}."
    )


def _change(flow: SegmentFlow, name: str) -> str:
    return f"{flow.gaps['before'].variation:.2f} → {flow.gaps[name].variation:.2f}"


def _table(found: list[SegmentFlow]) -> Table:
    return table_of(
        (
            "points", "radius", "components_before", "state", "components", "gap_variation",
            "largest_over_mean_gap",
        ),
        [
            (flow.name, flow.radius, flow.components, state,
             count_components(flow.points[state], flow.radius), gaps.variation, gaps.largest)
            for flow in found
            for state, gaps in flow.gaps.items()
        ],
    )  # fmt: skip


EXPERIMENT = Experiment(
    name="segment",
    place="Figure 215",
    title="points on a segment with fixed ends: do they become even?",
    run=_run,
)
