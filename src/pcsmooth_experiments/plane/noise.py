"""Noisy ellipses under the area flow and under the perimeter flow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pcsmooth_experiments.claims import in_words, verdict_on
from pcsmooth_experiments.experiment import Experiment, Inputs, Outcome, Table
from pcsmooth_experiments.plane.cloud_panels import Panel, draw_panels
from pcsmooth_experiments.plane.curve_gaps import Gaps, gaps_around
from pcsmooth_experiments.plane.descents import before_and_after
from pcsmooth_experiments.plane.ellipse import REPORT_RADIUS, Array, fit_ellipse
from pcsmooth_experiments.row_tables import table_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ITERATIONS = 100

#: The author's radius for both clouds, and for each one at which the perimeter flow does better.
_CASES = (
    ("ellipse-noise-5", REPORT_RADIUS, True),
    ("ellipse-noisy-dense", REPORT_RADIUS, True),
    ("ellipse-noise-5", 20.0, False),
    ("ellipse-noisy-dense", 10.0, False),
)

#: Noise counts as removed when no more than this share of it is left.
_REMOVED = 0.5


@dataclass(frozen=True)
class NoisyFlow:
    """Both flows of a noisy cloud.

    Attributes
    ----------
    cloud : str
        Its name.
    radius : float
        Of the disks, L.
    is_reported : bool
        Whether the radius is the author's.
    points : dict of str to ndarray
        "before" and after the "area" and the "perimeter" flow, (n, 2), L.
    noise : dict of str to float
        RMS distance of these from the ellipse that fits them best, L.
    gaps : dict of str to Gaps
        Between consecutive points of these.
    """

    cloud: str
    radius: float
    is_reported: bool
    points: dict[str, Array]
    noise: dict[str, float]
    gaps: dict[str, Gaps]

    def removes(self, flow: str) -> bool:
        """Whether a flow leaves no more than half of the noise."""
        return self.noise[flow] <= _REMOVED * self.noise["before"]


def measure_noise_removal(cloud: str, points: Array, radius: float, is_reported: bool) -> NoisyFlow:
    """Run 100 iterations of both flows of a noisy ellipse.

    Parameters
    ----------
    cloud : str
        What it is called.
    points : ndarray, shape (n, 2)
        Points near an ellipse, L.
    radius : float
        Of the disks, L.
    is_reported : bool
        Whether the radius is the author's.

    Returns
    -------
    NoisyFlow
    """
    states = before_and_after(points, radius, _ITERATIONS)
    return NoisyFlow(
        cloud,
        radius,
        is_reported,
        states,
        {name: _noise(state) for name, state in states.items()},
        {name: gaps_around(state) for name, state in states.items()},
    )


def draw_noise_removal(found: list[NoisyFlow]) -> Figure:
    """Draw where both flows take each cloud (Figure 212)."""
    return draw_panels(
        [
            Panel(
                f"{flow.cloud}, r = {flow.radius:g}: {name} flow\n"
                f"RMS {flow.noise['before']:.2f} → {flow.noise[name]:.2f}, "
                f"CV of the gaps {flow.gaps[name].variation:.2f}",
                flow.points["before"],
                flow.points[name],
            )
            for flow in found
            for name in ("area", "perimeter")
        ],
        columns=2,
        width=5.0,
    )


def _noise(points: Array) -> float:
    return float(np.sqrt(np.mean(fit_ellipse(points).distances(points) ** 2)))


def _run(inputs: Inputs) -> Outcome:
    found = [
        measure_noise_removal(cloud, inputs.points(f"{cloud}.xy"), radius, is_reported)
        for cloud, radius, is_reported in _CASES
    ]
    reported = [flow for flow in found if flow.is_reported]
    claims = {name: [flow.removes(name) for flow in reported] for name in ("area", "perimeter")}
    sparse, dense = reported
    open_at_first = sparse.gaps["before"].holes(sparse.radius)
    return Outcome(
        verdict=verdict_on(claims["area"] + claims["perimeter"]),
        caption=(
            f"RMS off the ellipse, r = {REPORT_RADIUS:g}: 100 points {_levels(sparse)}, 200 points "
            f"{_levels(dense)} (before, area, perimeter). Area flow: "
            f"{in_words(all(claims['area']))}; perimeter flow: "
            f"{in_words(all(claims['perimeter']))}."
        ),
        draw=lambda: draw_noise_removal(found),
        tables={"noise": _table(found)},
        explanation=(
            "Where noise is as thick as the disks the union is a band with two sides. The "
            "perimeter flow shortens each side by itself and nothing draws them together: the "
            "points end on two curves, each smooth, one inside the other, with smaller steps as "
            "well. A smaller radius leaves fewer such places, until the union falls apart: among "
            f"the 100 points {open_at_first} gaps are wider than the disks from the start, and "
            "their ends withdraw. The area flow draws the band together, and into clumps. The "
            "clouds and the radius are the author's, whose logged perimeters (energy-decrease) "
            "this flow repeats, so it is the method's own property."
        ),
    )


def _levels(flow: NoisyFlow) -> str:
    return ", ".join(f"{flow.noise[name]:.3g}" for name in ("before", "area", "perimeter"))


def _table(found: list[NoisyFlow]) -> Table:
    names = (
        "cloud", "radius", "state", "rms_distance", "gap_variation", "largest_over_mean_gap",
        "holes",
    )  # fmt: skip
    return table_of(
        names,
        [
            (flow.cloud, flow.radius, name, flow.noise[name], gaps.variation, gaps.largest,
             gaps.holes(flow.radius))
            for flow in found
            for name, gaps in flow.gaps.items()
        ],
    )  # fmt: skip


EXPERIMENT = Experiment(
    name="noise",
    place="Figure 212",
    title="noisy ellipses under both flows: is the noise removed?",
    run=_run,
)
