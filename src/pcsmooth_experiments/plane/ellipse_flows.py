"""An ellipse under the area flow and under the perimeter flow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pcsmooth.plots.figures import new_figure
from pcsmooth_experiments.claims import in_words, verdict_on
from pcsmooth_experiments.experiment import Experiment, Inputs, Outcome, Table
from pcsmooth_experiments.plane.cloud_panels import AREA, BEFORE, PERIMETER
from pcsmooth_experiments.plane.descents import PERIMETER_STEP, area_descent, perimeter_descent
from pcsmooth_experiments.plane.ellipse import (
    REPORT_ELLIPSE,
    REPORT_POINTS,
    REPORT_RADIUS,
    Array,
    sampling_parameters,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Iterations of the thesis.
_ITERATIONS = 100

_FLOWS = {"area": area_descent(REPORT_RADIUS), "perimeter": perimeter_descent(REPORT_RADIUS)}
_COLORS = {"area": AREA, "perimeter": PERIMETER}
_STYLES = {"even": "-", "parameter": "--"}


@dataclass(frozen=True)
class EllipseFlow:
    """One flow of one sampling of the thesis' ellipse.

    Attributes
    ----------
    sampling : {"even", "parameter"}
        Points evenly spaced along the curve, or at t = 2 pi k / n.
    flow : {"area", "perimeter"}
        What decreases.
    states : ndarray, shape (iterations + 1, n, 2)
        The points at each iteration, L, in their order around the curve.
    """

    sampling: str
    flow: str
    states: Array

    @property
    def aspects(self) -> Array:
        """Width over height at each iteration; 1 for a circle."""
        extents = np.ptp(self.states, axis=1)
        return np.asarray(extents[:, 0] / extents[:, 1])

    @property
    def roundness(self) -> Array:
        """4 pi A / L^2 of the closed polygon at each iteration; 1 for a circle."""
        x, y = np.moveaxis(self.states, 2, 0)
        next_x, next_y = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
        areas = 0.5 * np.sum(x * next_y - next_x * y, axis=1)
        lengths = np.hypot(next_x - x, next_y - y).sum(axis=1)
        return np.asarray(4.0 * np.pi * areas / lengths**2)

    @property
    def becomes_rounder(self) -> bool:
        """Whether it ends closer to a circle than it began, by both measures."""
        aspects, roundness = self.aspects, self.roundness
        return bool(aspects[-1] < aspects[0] and roundness[-1] > roundness[0])


def measure_ellipse_flows(iterations: int) -> tuple[EllipseFlow, ...]:
    """Run both flows of two samplings of the thesis' ellipse, 100 points, r = 15.

    Parameters
    ----------
    iterations : int
        Steps of each flow.

    Returns
    -------
    tuple of EllipseFlow
        Even points under area and perimeter, then even parameters.
    """
    samplings = {
        "even": REPORT_ELLIPSE.even_parameters(REPORT_POINTS),
        "parameter": sampling_parameters(REPORT_POINTS),
    }
    return tuple(
        EllipseFlow(
            sampling,
            flow,
            np.array([s.points for s in descent.states(REPORT_ELLIPSE.at(t), iterations)]),
        )
        for sampling, t in samplings.items()
        for flow, descent in _FLOWS.items()
    )


def draw_ellipse_flows(flows: tuple[EllipseFlow, ...]) -> Figure:
    """Draw where the flows end (Figure 28) and how round the points are on the way."""
    figure = new_figure(11.0, 8.6)
    for number, flow in enumerate(flows[:2], 1):
        axes = figure.add_subplot(2, 2, number)
        axes.plot(*flow.states[0].T, ".", color=BEFORE, label="before")
        axes.plot(*flow.states[-1].T, ".", color=_COLORS[flow.flow], label="after")
        radius = float(np.linalg.norm(flow.states[-1], axis=1).mean())
        turn = np.linspace(0.0, 2.0 * np.pi, 200)
        axes.plot(radius * np.cos(turn), radius * np.sin(turn), color="black", linewidth=0.5)
        axes.set_aspect("equal")
        axes.set_title(
            f"{flow.flow} flow, {len(flow.states) - 1} iterations, evenly spaced points\n"
            "(thin: the circle of the mean radius)"
        )
    measures = (
        ("width / height", [flow.aspects for flow in flows]),
        ("4πA/L² of the polygon", [flow.roundness for flow in flows]),
    )
    for number, (label, curves) in enumerate(measures, 3):
        axes = figure.add_subplot(2, 2, number)
        for flow, curve in zip(flows, curves, strict=True):
            axes.plot(
                curve, _STYLES[flow.sampling], color=_COLORS[flow.flow],
                label=f"{flow.flow}, {_words(flow.sampling)}",
            )  # fmt: skip
        axes.set_xlabel("iteration")
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _words(sampling: str) -> str:
    return {"even": "evenly spaced", "parameter": "even in t"}[sampling]


def _run(_: Inputs) -> Outcome:
    flows = measure_ellipse_flows(_ITERATIONS)
    ends = [f"{flow.aspects[-1]:.3f}" for flow in flows]
    rounder = [flow.becomes_rounder for flow in flows]
    return Outcome(
        verdict=verdict_on(rounder),
        caption=(
            f"Width/height 1.5 becomes {ends[0]} (area) and {ends[1]} (perimeter) from evenly "
            f"spaced points, {ends[2]} and {ends[3]} from even t; {sum(rounder)} of {len(flows)} "
            f"become rounder: {in_words(all(rounder))}."
        ),
        draw=lambda: draw_ellipse_flows(flows),
        tables={"ellipse-flows": _table(flows)},
        explanation=(
            f"Steps are {PERIMETER_STEP:g} (perimeter) and {PERIMETER_STEP:g}/r (area), at which "
            "both are stable. The circle is approached slowly, and slower from points even in t, "
            "as in the thesis' Section 2.3.2: without weights a point moves by spacing times "
            "curvature, and at the sharp ends, where those points are dense, they lag. To first "
            "order such a flow is a discrete heat flow, which shrinks the affine image of a "
            "regular polygon without changing its proportions."
        ),
    )


def _table(flows: tuple[EllipseFlow, ...]) -> Table:
    table: Table = {"iteration": np.arange(len(flows[0].states))}
    for flow in flows:
        table[f"aspect_{flow.flow}_{flow.sampling}"] = flow.aspects
        table[f"roundness_{flow.flow}_{flow.sampling}"] = flow.roundness
    return table


EXPERIMENT = Experiment(
    name="ellipse-flows",
    place="Figure 28",
    title="an ellipse under both flows: does it become a circle?",
    run=_run,
)
