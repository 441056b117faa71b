"""Energies along the flows, beside the author's own log."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pcsmooth.errors import CloudFileError
from pcsmooth.plots.figures import new_figure
from pcsmooth_experiments.claims import in_words, verdict_on
from pcsmooth_experiments.experiment import Experiment, Inputs, Outcome
from pcsmooth_experiments.plane.cloud_panels import AREA, PERIMETER
from pcsmooth_experiments.plane.descents import Descent, perimeter_descent
from pcsmooth_experiments.plane.ellipse import (
    REPORT_ELLIPSE,
    REPORT_POINTS,
    REPORT_RADIUS,
    Array,
    sampling_parameters,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LOG = "perimeter-dense.log"
_ITERATIONS = 100

#: The author's step for the area flow, and radius of the square.
_AREA_STEP, _SQUARE_RADIUS = 0.1, 30.0

#: Relative difference from the log, which has six digits.
_SAME = 1e-5


@dataclass(frozen=True)
class EnergyDecrease:
    """Energies along three flows.

    Attributes
    ----------
    square, ellipse : ndarray, shape (101,)
        Area of the union before and after each of 100 steps of the area flow, L^2.
    perimeters : ndarray, shape (60,)
        Perimeter of the union before each step of the perimeter flow of the noisy ellipse, L.
    logged : ndarray, shape (60,)
        The same as the author's program logged it.
    """

    square: Array
    ellipse: Array
    perimeters: Array
    logged: Array

    @property
    def relative_differences(self) -> Array:
        """Of the perimeters from those logged, (60,)."""
        return np.asarray(np.abs(self.perimeters / self.logged - 1.0))


def measure_energy_decrease(square: Array, noisy: Array, logged: Array) -> EnergyDecrease:
    """Run the flows whose energies the thesis shows, and the one that its author logged.

    Parameters
    ----------
    square, noisy : ndarray, shape (n, 2)
        The square's points and the dense noisy ellipse's, L.
    logged : ndarray, shape (m,)
        Perimeters before each of m steps.

    Returns
    -------
    EnergyDecrease
    """
    ellipse = REPORT_ELLIPSE.at(sampling_parameters(REPORT_POINTS))
    descent = perimeter_descent(REPORT_RADIUS)
    return EnergyDecrease(
        _energies(Descent("volume", _SQUARE_RADIUS, _AREA_STEP), square, _ITERATIONS),
        _energies(Descent("volume", REPORT_RADIUS, _AREA_STEP), ellipse, _ITERATIONS),
        _energies(descent, noisy, len(logged) - 1),
        logged,
    )


def draw_energy_decrease(found: EnergyDecrease) -> Figure:
    """Draw the energies over the iterations (Figure 216)."""
    figure = new_figure(12.0, 4.2)
    flows = (
        (f"square, r = {_SQUARE_RADIUS:g}, area flow", found.square),
        (f"ellipse, r = {REPORT_RADIUS:g}, area flow", found.ellipse),
    )
    for number, (title, energies) in enumerate(flows, 1):
        axes = figure.add_subplot(1, 3, number)
        axes.plot(energies, color=AREA)
        axes.set_ylabel("area of the union [length²]")
        axes.set_title(title)
    axes = figure.add_subplot(1, 3, 3)
    axes.plot(found.perimeters, color=PERIMETER, label="pcsmooth")
    axes.plot(found.logged, ".", color="black", markersize=3, label="author's log")
    axes.set_ylabel("perimeter of the union [length]")
    axes.set_title(f"noisy ellipse, r = {REPORT_RADIUS:g}, perimeter flow")
    axes.legend()
    for axes in figure.axes:
        axes.set_xlabel("iteration")
        axes.grid(alpha=0.3)
    return figure


def _energies(descent: Descent, points: Array, iterations: int) -> Array:
    return np.array([s.evaluation.value for s in descent.states(points, iterations)])


def _read_log(inputs: Inputs) -> Array:
    path = inputs.folder / _LOG
    if not path.is_file():
        raise CloudFileError(
            str(path), "it is not there", "name the folder of the thesis' clouds (--data)"
        )
    try:
        energies = [float(word) for word in path.read_text().split()]
    except ValueError:
        energies = []
    if not energies or not np.isfinite(energies).all():
        raise CloudFileError(str(path), "is no list of energies", "take the thesis'")
    return np.array(energies)


def _run(inputs: Inputs) -> Outcome:
    found = measure_energy_decrease(
        inputs.points("square.xy"), inputs.points("ellipse-noisy-dense.xy"), _read_log(inputs)
    )
    rises = [int(np.count_nonzero(np.diff(area) > 0.0)) for area in (found.square, found.ellipse)]
    difference = float(found.relative_differences.max())
    decreases, repeats = max(rises) == 0, difference <= _SAME
    ratios = [area[-1] / area[0] for area in (found.square, found.ellipse)]
    return Outcome(
        verdict=verdict_on([decreases, repeats]),
        caption=(
            f"Area falls to {ratios[0]:.1%} (square) and {ratios[1]:.1%} (ellipse) in "
            f"{_ITERATIONS} steps, rising in {rises[0]} and {rises[1]}: {in_words(decreases)}. "
            f"The author's {len(found.logged)} logged perimeters are met within {difference:.1e}."
        ),
        draw=lambda: draw_energy_decrease(found),
        tables={
            "energy-decrease": {
                "iteration": np.arange(_ITERATIONS + 1),
                "square_area": found.square,
                "ellipse_area": found.ellipse,
            },
            "energy-log": {
                "iteration": np.arange(len(found.logged)),
                "perimeter": found.perimeters,
                "logged_perimeter": found.logged,
                "relative_difference": found.relative_differences,
            },
        },
    )


EXPERIMENT = Experiment(
    name="energy-decrease",
    place="Figure 216",
    title="energies along the flows, and the author's log",
    run=_run,
)
