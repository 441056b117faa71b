"""Ellipses with oscillations of one and of two amplitudes under both flows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pcsmooth_experiments.claims import in_words, verdict_on
from pcsmooth_experiments.experiment import Experiment, Inputs, Outcome, Table
from pcsmooth_experiments.plane.cloud_panels import Panel, draw_panels
from pcsmooth_experiments.plane.curve_gaps import Gaps, gaps_around
from pcsmooth_experiments.plane.descents import before_and_after
from pcsmooth_experiments.plane.ellipse import (
    REPORT_ELLIPSE,
    REPORT_POINTS,
    REPORT_RADIUS,
    Array,
    fit_ellipse,
    sampling_parameters,
)
from pcsmooth_experiments.row_tables import table_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ITERATIONS = 100

#: Waves around the ellipse, and the amplitudes of the author's cloud of two, L.
WAVES = 10
AMPLITUDES = (20.0, 40.0)

#: A radius between the two amplitudes, L.
_BETWEEN = 30.0

#: Oscillations count as smoothed when no more than this share of the amplitude is left.
_SMOOTHED = 0.5


def oscillating_ellipse(amplitudes: tuple[float, ...]) -> Array:
    """Sample the thesis' ellipse with waves along its normals, their amplitudes taking turns.

    Parameters
    ----------
    amplitudes : tuple of float
        Amplitudes of one wave after the other, L, repeated around the ellipse.

    Returns
    -------
    ndarray, shape (100, 2)
        Of amplitudes 20 and 40 the author's own cloud, to its six digits.
    """
    t = sampling_parameters(REPORT_POINTS)
    wave = np.arange(REPORT_POINTS) * WAVES // REPORT_POINTS
    heights = np.asarray(amplitudes)[wave % len(amplitudes)] * np.sin(WAVES * t)
    return np.asarray(REPORT_ELLIPSE.at(t) + heights[:, np.newaxis] * REPORT_ELLIPSE.normals(t))


@dataclass(frozen=True)
class OscillationFlow:
    """Both flows of an oscillating cloud.

    Attributes
    ----------
    cloud : str
        "one amplitude" or "two amplitudes".
    radius : float
        Of the disks, L.
    points : dict of str to ndarray
        "before" and after the "area" and the "perimeter" flow, (n, 2), L.
    amplitudes : dict of str to tuple of float
        Of these, for each amplitude of the cloud: the largest distance of the points of its waves
        from the ellipse that fits all points best, L.
    gaps : dict of str to Gaps
        Between consecutive points of these.
    """

    cloud: str
    radius: float
    points: dict[str, Array]
    amplitudes: dict[str, tuple[float, ...]]
    gaps: dict[str, Gaps]

    @property
    def area_opens_holes(self) -> bool:
        """Whether the area flow has gaps wider than the disks in the end, and had none."""
        return self.gaps["before"].holes(self.radius) == 0 < self.gaps["area"].holes(self.radius)

    @property
    def perimeter_smooths(self) -> bool:
        """Whether the perimeter flow leaves half of each amplitude at most, and no hole."""
        halved = (
            after <= _SMOOTHED * before
            for before, after in zip(
                self.amplitudes["before"], self.amplitudes["perimeter"], strict=True
            )
        )
        return all(halved) and self.gaps["perimeter"].holes(self.radius) == 0


def measure_oscillations(cloud: str, points: Array, radius: float, kinds: int) -> OscillationFlow:
    """Run 100 iterations of both flows of an ellipse with oscillations.

    Parameters
    ----------
    cloud : str
        What it is called.
    points : ndarray, shape (100, 2)
        As `oscillating_ellipse` makes them, L.
    radius : float
        Of the disks, L.
    kinds : int
        Number of amplitudes.

    Returns
    -------
    OscillationFlow
    """
    states = before_and_after(points, radius, _ITERATIONS)
    return OscillationFlow(
        cloud,
        radius,
        states,
        {name: _amplitudes(state, kinds) for name, state in states.items()},
        {name: gaps_around(state) for name, state in states.items()},
    )


def draw_oscillations(found: list[OscillationFlow]) -> Figure:
    """Draw where both flows take the clouds (Figures 213 and 214)."""
    return draw_panels(
        [
            Panel(
                f"{flow.cloud}, r = {flow.radius:g}: {name} flow\namplitude "
                f"{_in_words(flow.amplitudes['before'])} → {_in_words(flow.amplitudes[name])}, "
                f"CV of the gaps {flow.gaps[name].variation:.2f}",
                flow.points["before"],
                flow.points[name],
            )
            for flow in found
            for name in ("area", "perimeter")
        ],
        columns=2,
        width=5.0,
        height=3.6,
    )


def _amplitudes(points: Array, kinds: int) -> tuple[float, ...]:
    distances = np.abs(fit_ellipse(points).distances(points))
    kind = (np.arange(len(points)) * WAVES // len(points)) % kinds
    return tuple(float(distances[kind == number].max()) for number in range(kinds))


def _in_words(amplitudes: tuple[float, ...]) -> str:
    return "/".join(f"{amplitude:.2g}" for amplitude in amplitudes)


def _run(inputs: Inputs) -> Outcome:
    one, two = oscillating_ellipse(AMPLITUDES[:1]), inputs.points("ellipse-osc2.xy")
    found = [
        measure_oscillations("one amplitude", one, REPORT_RADIUS, 1),
        measure_oscillations("two amplitudes", two, REPORT_RADIUS, 2),
        measure_oscillations("two amplitudes", two, _BETWEEN, 2),
    ]
    opens = [flow.area_opens_holes for flow in found]
    smooths = [flow.perimeter_smooths for flow in found]
    left = ", ".join(
        f"{_in_words(flow.amplitudes['before'])} → {_in_words(flow.amplitudes['perimeter'])} "
        f"(r = {flow.radius:g})"
        for flow in found
    )
    return Outcome(
        verdict=verdict_on(opens + smooths),
        caption=(
            f"Area flow opens holes in {sum(opens)} of {len(found)}: {in_words(all(opens))}. "
            f"Perimeter flow, amplitudes {left}: {in_words(all(smooths))}."
        ),
        draw=lambda: draw_oscillations(found),
        tables={"oscillations": _table(found)},
        explanation=(
            f"With r = {REPORT_RADIUS:g}, less than either amplitude, the perimeter flow smooths "
            f"both. The thesis' radius lies between the two amplitudes; with r = {_BETWEEN:g}, "
            "between 20 and 40, the disks of neighbouring waves merge into a band, of which the "
            "perimeter flow shortens the two sides one by one: the points end on two curves, as "
            "those of a noisy cloud do."
        ),
    )


def _table(found: list[OscillationFlow]) -> Table:
    names = (
        "cloud", "radius", "state", "largest_amplitude", "smallest_amplitude", "gap_variation",
        "largest_over_mean_gap", "holes",
    )  # fmt: skip
    return table_of(
        names,
        [
            (flow.cloud, flow.radius, name, max(flow.amplitudes[name]), min(flow.amplitudes[name]),
             gaps.variation, gaps.largest, gaps.holes(flow.radius))
            for flow in found
            for name, gaps in flow.gaps.items()
        ],
    )  # fmt: skip


EXPERIMENT = Experiment(
    name="oscillations",
    place="Figures 213 and 214",
    title="oscillations of one and two amplitudes under both flows",
    run=_run,
)
