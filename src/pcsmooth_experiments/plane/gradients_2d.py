"""Gradients of area and perimeter on an ellipse and on a square."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pcsmooth.energies.balls import measure_balls
from pcsmooth.plots.figures import new_figure
from pcsmooth_experiments.claims import in_words, verdict_on
from pcsmooth_experiments.experiment import Experiment, Inputs, Outcome
from pcsmooth_experiments.plane.ellipse import (
    REPORT_ELLIPSE,
    REPORT_POINTS,
    REPORT_RADIUS,
    Array,
    sampling_parameters,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: The thesis' radius for the square.
_SQUARE_RADIUS = 30.0

#: Agreement: largest angle to the normal in degrees, least correlation with the curvature.
_LARGEST_ANGLE = 5.0
_LEAST_CORRELATION = 0.99

#: Gradients shorter than this, in units of the longest, have no direction to speak of.
_NO_GRADIENT = 1e-9

#: Longest arrow, in units of the extent.
_LONGEST_ARROW = 0.16


@dataclass(frozen=True)
class ShapeGradients:
    """Gradients at the points of a shape.

    Attributes
    ----------
    name : str
        The shape.
    radius : float
        Of the disks, L.
    points, normals : ndarray, shape (n, 2)
        Where they are, L, and the outward normals of the shape there.
    area, perimeter : ndarray, shape (n, 2)
        Gradients of the area, L, and of the perimeter, 1, of the union of disks.
    """

    name: str
    radius: float
    points: Array
    normals: Array
    area: Array
    perimeter: Array

    @property
    def largest_angle(self) -> float:
        """Largest angle between a gradient, of either, and the normal, degrees."""
        return max(
            float(_angles(gradient, self.normals).max()) for gradient in (self.area, self.perimeter)
        )

    @property
    def magnitude_ratio(self) -> float:
        """Mean norm of the area's gradients over that of the perimeter's, L."""
        return float(_norms(self.area).sum() / _norms(self.perimeter).sum())


@dataclass(frozen=True)
class Gradients:
    """What the experiment measures.

    Attributes
    ----------
    ellipse, square : ShapeGradients
        The two shapes.
    correlations : tuple of float
        Of the norms of the ellipse's gradients (area, perimeter) with its curvature.
    """

    ellipse: ShapeGradients
    square: ShapeGradients
    correlations: tuple[float, float]


def measure_gradients(square: Array) -> Gradients:
    """Measure both gradients on the thesis' ellipse and on a square around the origin.

    Parameters
    ----------
    square : ndarray, shape (n, 2)
        Points on the sides of a square with centre 0 and sides along the axes, corners included.

    Returns
    -------
    Gradients
    """
    t = sampling_parameters(REPORT_POINTS)
    ellipse = _gradients_of(
        "ellipse", REPORT_ELLIPSE.at(t), REPORT_ELLIPSE.normals(t), REPORT_RADIUS
    )
    outward = np.where(np.abs(square) == np.abs(square).max(), np.sign(square), 0.0)
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    curvatures = REPORT_ELLIPSE.curvatures(t)
    return Gradients(
        ellipse,
        _gradients_of("square", square, outward, _SQUARE_RADIUS),
        (
            float(np.corrcoef(_norms(ellipse.area), curvatures)[0, 1]),
            float(np.corrcoef(_norms(ellipse.perimeter), curvatures)[0, 1]),
        ),
    )


def draw_gradients(found: Gradients) -> Figure:
    """Draw the gradients as arrows, coloured by their norms (Figures 24 and 25)."""
    figure = new_figure(11.0, 8.6)
    number = 0
    for quantity, unit in (("area", "length"), ("perimeter", "1")):
        for shape in (found.ellipse, found.square):
            number += 1
            gradient = shape.area if quantity == "area" else shape.perimeter
            norms = _norms(gradient)
            axes = figure.add_subplot(2, 2, number)
            extent = float(np.ptp(shape.points, axis=0).max())
            arrows = axes.quiver(
                *shape.points.T, *(gradient * (_LONGEST_ARROW * extent / norms.max())).T, norms,
                cmap="turbo", angles="xy", scale_units="xy", scale=1.0, width=0.005,
            )  # fmt: skip
            axes.plot(*shape.points.T, ".", color="black", markersize=2.5)
            axes.set_aspect("equal")
            axes.margins(0.22)
            axes.set_title(f"gradient of the {quantity}, {shape.name}, r = {shape.radius:g}")
            figure.colorbar(arrows, ax=axes, label=f"norm of the gradient [{unit}]", shrink=0.85)
    return figure


def _gradients_of(name: str, points: Array, normals: Array, radius: float) -> ShapeGradients:
    union = measure_balls(points, radius)
    return ShapeGradients(name, radius, points, normals, union.volume_gradient, union.area_gradient)


def _norms(vectors: Array) -> Array:
    return np.asarray(np.linalg.norm(vectors, axis=1))


def _angles(gradient: Array, normals: Array) -> Array:
    """Angles between gradients that do not vanish and the normals, degrees."""
    norms = _norms(gradient)
    seen = norms > _NO_GRADIENT * norms.max()
    cosines = np.sum(gradient * normals, axis=1)[seen] / norms[seen]
    return np.asarray(np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0))))


def _run(inputs: Inputs) -> Outcome:
    found = measure_gradients(inputs.points("square.xy"))
    shapes = (found.ellipse, found.square)
    angles = [shape.largest_angle for shape in shapes]
    correlation = min(found.correlations)
    longer = [shape.magnitude_ratio for shape in shapes]
    are_normal = max(angles) <= _LARGEST_ANGLE
    are_curvature = correlation >= _LEAST_CORRELATION
    is_area_longer = min(longer) > 1.0
    return Outcome(
        verdict=verdict_on([are_normal, are_curvature, is_area_longer]),
        caption=(
            f"Off the normals by up to {angles[0]:.2g}° (ellipse) and {angles[1]:.2g}° (square): "
            f"{in_words(are_normal)}; correlation with curvature {correlation:.4f}: "
            f"{in_words(are_curvature)}; area's {longer[0]:.3g}x and {longer[1]:.3g}x as long: "
            f"{in_words(is_area_longer)}."
        ),
        draw=lambda: draw_gradients(found),
        tables={f"gradients-{shape.name}": _table(shape) for shape in shapes},
        explanation=(
            "That the area's gradients are longer says nothing of the two flows: they are lengths, "
            "the perimeter's are pure numbers, and on dense points their ratio is the radius. In a "
            "unit in which r is below 1 the perimeter's are longer. Flat parts of the square have "
            "no gradient. At its corners both follow the diagonal; only the perimeter's gradients "
            "at the points beside them turn towards the corner, which is nearer than the radius."
        ),
    )


def _table(shape: ShapeGradients) -> dict[str, Array]:
    return {
        "x": shape.points[:, 0],
        "y": shape.points[:, 1],
        "area_gradient_x": shape.area[:, 0],
        "area_gradient_y": shape.area[:, 1],
        "perimeter_gradient_x": shape.perimeter[:, 0],
        "perimeter_gradient_y": shape.perimeter[:, 1],
    }


EXPERIMENT = Experiment(
    name="gradients-2d",
    place="Figures 24 and 25",
    title="gradients of area and perimeter on an ellipse and a square",
    run=_run,
)
