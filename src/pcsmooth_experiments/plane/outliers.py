"""An ellipse with outliers under area, weighted area and perimeter flow."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from pcsmooth_experiments.claims import in_words, verdict_on
from pcsmooth_experiments.experiment import Experiment, Inputs, Outcome, Table
from pcsmooth_experiments.plane.cloud_panels import Panel, draw_panels
from pcsmooth_experiments.plane.curve_gaps import Gaps, gaps_around
from pcsmooth_experiments.plane.descents import (
    area_descent,
    perimeter_descent,
    weighted_area_descent,
)
from pcsmooth_experiments.plane.ellipse import (
    REPORT_ELLIPSE,
    REPORT_POINTS,
    REPORT_RADIUS,
    Array,
    fit_ellipse,
)
from pcsmooth_experiments.row_tables import table_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Steps of each flow; the gaps are measured at each of these numbers of them.
_STOPS = (0, 20, 40, 60, 80, 100)

_FINE = "weighted area, fine"

#: Steps of the weighted area flow are also made this many times smaller, and as many more.
_REFINEMENT = 5

#: An outlier is swallowed when it is no farther from the curve than the points are from each
#: other, in units of their mean spacing.
_SWALLOWED = 1.0


@dataclass(frozen=True)
class OutlierStop:
    """Where a flow stands.

    Attributes
    ----------
    iteration : int
        Steps taken.
    points : ndarray, shape (n, 2)
        The points, L; the outliers are those from `REPORT_POINTS` on.
    gaps : Gaps
        Between consecutive points.
    farthest : float
        Largest distance of an outlier from the ellipse that fits the others best, L.
    hole_angle : float
        Angle, seen from the centre, between the middle of the largest gap and the middle of the
        outliers as they were, degrees.
    """

    iteration: int
    points: Array
    gaps: Gaps
    farthest: float
    hole_angle: float


def measure_outliers(points: Array) -> dict[str, tuple[OutlierStop, ...]]:
    """Follow three flows of an ellipse with outliers, r = 15.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        100 points around an ellipse, then the outliers.

    Returns
    -------
    dict of str to tuple of OutlierStop
        Of the flows "area", "weighted area" (by cells), "perimeter", and "weighted area, fine",
        which takes five steps for one, at 0 to 100 iterations.
    """
    weighted = weighted_area_descent(points, REPORT_RADIUS)
    flows = {
        "area": (area_descent(REPORT_RADIUS), 1),
        "weighted area": (weighted, 1),
        "perimeter": (perimeter_descent(REPORT_RADIUS), 1),
        _FINE: (replace(weighted, step=weighted.step / _REFINEMENT), _REFINEMENT),
    }
    place = points[REPORT_POINTS:].mean(axis=0)
    found = {}
    for name, (descent, times) in flows.items():
        states = descent.states(points, _STOPS[-1] * times)
        found[name] = tuple(_look(stop, states[stop * times].points, place) for stop in _STOPS)
    return found


def draw_outliers(found: dict[str, tuple[OutlierStop, ...]]) -> Figure:
    """Draw the cloud and where the flows end (Figure 211)."""
    start = found["area"][0].points
    return draw_panels(
        [
            Panel(
                f"{name} flow, {stops[-1].iteration} iterations\n"
                f"CV of the gaps {stops[-1].gaps.variation:.2f}, largest/mean "
                f"{stops[-1].gaps.largest:.1f}",
                start,
                stops[-1].points,
            )
            for name, stops in found.items()
            if name != _FINE
        ],
        columns=3,
    )


def _look(iteration: int, points: Array, place: Array) -> OutlierStop:
    curve = fit_ellipse(points[:REPORT_POINTS])
    gaps = gaps_around(points)
    middle = gaps.widest
    cosine = middle @ place / (np.linalg.norm(middle) * np.linalg.norm(place))
    return OutlierStop(
        iteration,
        points,
        gaps,
        float(np.abs(curve.distances(points[REPORT_POINTS:])).max()),
        float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))),
    )


def _run(inputs: Inputs) -> Outcome:
    points = inputs.points("ellipse-outliers.xy")
    found = measure_outliers(points)
    ends = {name: stops[-1] for name, stops in found.items() if name != _FINE}
    start = found["area"][0]
    spread = float(np.ptp(np.degrees(REPORT_ELLIPSE.nearest(points[REPORT_POINTS:]))))
    spacing = float(start.gaps.distances.mean())
    are_swallowed = all(end.farthest <= _SWALLOWED * spacing for end in ends.values())
    holes = {name: end.gaps.holes(REPORT_RADIUS) for name, end in ends.items()}
    opens = holes["area"] > 0 and ends["area"].hole_angle <= spread
    is_cured = holes["weighted area"] == 0
    return Outcome(
        verdict=verdict_on([are_swallowed, opens, is_cured, holes["perimeter"] == 0]),
        caption=(
            f"Outliers {start.farthest:.0f} off end within "
            f"{max(end.farthest for end in ends.values()):.1f}: {in_words(are_swallowed)}. Largest "
            f"gap/mean: area {ends['area'].gaps.largest:.1f} ({in_words(opens)}), weighted "
            f"{ends['weighted area'].gaps.largest:.1f} ({in_words(is_cured)}), perimeter "
            f"{ends['perimeter'].gaps.largest:.1f}."
        ),
        draw=lambda: draw_outliers(found),
        tables={"outliers": _table(found)},
        explanation=_explain(found),
    )


def _explain(found: dict[str, tuple[OutlierStop, ...]]) -> str:
    opened = "; ".join(f"{name} {_first_hole(stops)}" for name, stops in found.items())
    return (
        "A hole is a gap along the curve that is wider than the disks: their union is open there. "
        f"The first one is there: {opened} (of {_REFINEMENT} times as many steps, as small). The "
        "weights put it off; they do not remove it, and smaller steps do not either: the outliers "
        "come down as a clump that draws its neighbours in. The steps are such that the mean "
        "point goes as far under each flow."
    )


def _first_hole(stops: tuple[OutlierStop, ...]) -> str:
    first = next((stop.iteration for stop in stops if stop.gaps.holes(REPORT_RADIUS)), None)
    return "never" if first is None else f"by iteration {first}"


def _table(found: dict[str, tuple[OutlierStop, ...]]) -> Table:
    rows = [
        (name, stop.iteration, stop.gaps.variation, stop.gaps.largest,
         stop.gaps.holes(REPORT_RADIUS), stop.hole_angle, stop.farthest)
        for name, stops in found.items()
        for stop in stops
    ]  # fmt: skip
    names = (
        "flow", "iteration", "gap_variation", "largest_over_mean_gap", "holes",
        "hole_to_outliers_degrees", "farthest_outlier",
    )  # fmt: skip
    return table_of(names, rows)


EXPERIMENT = Experiment(
    name="outliers",
    place="Figure 211",
    title="outliers beside an ellipse: swallowed, and what they leave",
    run=_run,
)
