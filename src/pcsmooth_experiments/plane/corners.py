"""Corners of a shark, a bird and a square under the flows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pcsmooth.neighbors.spacing import mean_spacing
from pcsmooth_experiments.claims import in_words, verdict_on
from pcsmooth_experiments.experiment import Experiment, Inputs, Outcome, Table
from pcsmooth_experiments.plane.cloud_panels import Panel, draw_panels
from pcsmooth_experiments.plane.descents import Descent
from pcsmooth_experiments.plane.ellipse import Array
from pcsmooth_experiments.row_tables import table_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: The author's steps.
_AREA_STEP, _PERIMETER_STEP = 0.1, 0.05

#: Distance within which turning counts as one corner, in units of the bounding box's diagonal.
_CORNER = 0.02


#: Visible angle from which on a point counts as having a part of the boundary.
_VISIBLE = 1e-9


@dataclass(frozen=True)
class _Case:
    """A flow of a cloud; `is_reported` where the thesis shows it, with the author's numbers."""

    cloud: str
    descent: Descent
    iterations: int
    is_reported: bool


_CASES = (
    _Case("shark", Descent("area", 0.8, _PERIMETER_STEP), 20, True),
    _Case("bird", Descent("area", 0.5, _PERIMETER_STEP), 20, True),
    _Case("square", Descent("volume", 30.0, _AREA_STEP), 20, True),
    _Case("square", Descent("area", 30.0, _PERIMETER_STEP), 200, True),
    _Case("shark", Descent("area", 0.024, 0.001), 100, False),
    _Case("bird", Descent("area", 0.034, 0.001), 100, False),
)


@dataclass(frozen=True)
class CornerFlow:
    """A flow of a cloud with corners.

    Attributes
    ----------
    cloud, flow : str
        Which cloud, and "area" or "perimeter".
    radius, step, spacing : float
        Of the disks, of the flow, and between the points, L.
    is_reported : bool
        Whether it is the thesis', with the author's radius and step.
    visible : int
        Points of the cloud that have a part of the union's boundary.
    stable_step : float
        Largest step that is stable at the start: the inverse of the largest stiffness.
    before, after : ndarray, shape (n, 2)
        The points, L.
    sharpness : ndarray, shape (iterations + 1,)
        Mean turning at corners after each iteration, degrees: see `mean_turning`.
    """

    cloud: str
    flow: str
    radius: float
    step: float
    spacing: float
    is_reported: bool
    visible: int
    stable_step: float
    before: Array
    after: Array
    sharpness: Array

    @property
    def is_smoothed(self) -> bool:
        """Whether corners turn less in the end."""
        return bool(self.sharpness[-1] < self.sharpness[0])


def mean_turning(points: Array, reach: float) -> float:
    """Measure how sharp the corners of a cloud are that its convex hull touches.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        Points in any order, not all on a line.
    reach : float
        What counts as one corner, L.

    Returns
    -------
    float
        Degrees: the exterior angles of the hull within `reach` of a place on its boundary, in
        the mean over all directions in which the hull is seen. Of a square 90, of a circle of
        radius R almost 2 reach / R in radians.
    """
    from scipy.spatial import ConvexHull

    corners = points[ConvexHull(points).vertices]
    sides = np.roll(corners, -1, axis=0) - corners
    headings = np.arctan2(sides[:, 1], sides[:, 0])
    turns = (headings - np.roll(headings, 1)) % (2.0 * np.pi)
    distances = np.linalg.norm(corners[:, np.newaxis] - corners, axis=2)
    together = (distances <= reach) @ turns
    return float(np.degrees(together @ turns / turns.sum()))


def measure_corners(clouds: dict[str, Array]) -> tuple[CornerFlow, ...]:
    """Run the flows of the thesis' clouds with corners.

    Parameters
    ----------
    clouds : dict of str to ndarray
        Points (n, 2) of "shark", "bird" and "square".

    Returns
    -------
    tuple of CornerFlow
        Those of the thesis first, then others with small radii.
    """
    return tuple(_follow(case, clouds[case.cloud]) for case in _CASES)


def draw_corners(flows: tuple[CornerFlow, ...]) -> Figure:
    """Draw the clouds before and after (Figures 29 and 210)."""
    return draw_panels(
        [
            Panel(
                f"{flow.cloud}, {flow.flow} flow, r = {flow.radius:g} "
                f"({flow.radius / flow.spacing:.2g} spacings)\n"
                f"{len(flow.sharpness) - 1} steps of {flow.step:g}; corners "
                f"{flow.sharpness[0]:.0f}° → {flow.sharpness[-1]:.0f}°",
                flow.before,
                flow.after,
            )
            for flow in flows
        ],
        columns=2,
        height=3.2,
        width=5.4,
    )


def _follow(case: _Case, points: Array) -> CornerFlow:
    reach = _CORNER * float(np.linalg.norm(np.ptp(points, axis=0)))
    states = case.descent.states(points, case.iterations)
    start = states[0].evaluation
    return CornerFlow(
        cloud=case.cloud,
        flow="area" if case.descent.quantity == "volume" else "perimeter",
        radius=case.descent.radius,
        step=case.descent.step,
        spacing=mean_spacing(points),
        is_reported=case.is_reported,
        visible=int(np.count_nonzero(start.union.visible_areas > _VISIBLE * start.union.radius)),
        stable_step=float(1.0 / start.diagonal.max()),
        before=points,
        after=states[-1].points,
        sharpness=np.array([mean_turning(state.points, reach) for state in states]),
    )


def _run(inputs: Inputs) -> Outcome:
    flows = measure_corners({case.cloud: inputs.points(f"{case.cloud}.xy") for case in _CASES})
    stable = min(flow.stable_step for flow in flows if not flow.is_reported)
    reported = [flow for flow in flows if flow.is_reported]
    shark, bird = reported[:2]
    ends = ", ".join(
        f"{flow.cloud} {flow.sharpness[0]:.0f}° → {flow.sharpness[-1]:.0f}° ({flow.flow})"
        for flow in reported
    )
    return Outcome(
        verdict=verdict_on(flow.is_smoothed for flow in reported),
        caption=f"Mean turning at corners: {ends}: "
        f"{in_words(all(flow.is_smoothed for flow in reported))}.",
        draw=lambda: draw_corners(flows),
        tables={"corners": _table(flows)},
        explanation=(
            f"The author's radii of shark and bird are {shark.radius / shark.spacing:.0f} and "
            f"{bird.radius / bird.spacing:.0f} spacings: only {shark.visible} of "
            f"{len(shark.before)} and {bird.visible} of {len(bird.before)} points have a part of "
            "the boundary, all others rest, and those at the tips gather into clumps. With radii "
            "of two spacings all points move; the author's perimeter step is then far beyond what "
            f"is stable, {stable:.1g}, so it is {flows[-1].step:g}, and thin tips withdraw more "
            "than they become round. The perimeter's step for the square is small: it takes ten "
            "times the iterations of the area flow. How many iterations the thesis shows it does "
            "not say."
        ),
    )


def _table(flows: tuple[CornerFlow, ...]) -> Table:
    rows = [
        (flow.cloud, flow.flow, flow.radius, flow.radius / flow.spacing, flow.step, flow.visible,
         iteration, degrees)
        for flow in flows
        for iteration, degrees in enumerate(flow.sharpness.tolist())
    ]  # fmt: skip
    names = (
        "cloud", "flow", "radius", "radius_in_spacings", "step", "visible_points", "iteration",
        "mean_turning_degrees",
    )  # fmt: skip
    return table_of(names, rows)


EXPERIMENT = Experiment(
    name="corners",
    place="Figures 29 and 210",
    title="corners of a shark, a bird and a square",
    run=_run,
)
