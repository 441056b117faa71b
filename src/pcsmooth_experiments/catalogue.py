"""All experiments, in the order of the thesis."""

from __future__ import annotations

from pcsmooth_experiments.experiment import Experiment
from pcsmooth_experiments.plane import (
    corners,
    ellipse_curvature,
    ellipse_flows,
    energy_decrease,
    gradients_2d,
    noise,
    oscillations,
    outliers,
    segment,
    spacing_gaps,
)
from pcsmooth_experiments.space import (
    estimated_normals,
    polyhedral_flows,
    polyhedral_gradients,
    union_of_polyhedra,
)
from pcsmooth_experiments.theory import area_convergence, gradient_convergence, tubes

#: Every experiment of the gallery.
EXPERIMENTS: tuple[Experiment, ...] = (
    gradients_2d.EXPERIMENT,
    ellipse_curvature.EXPERIMENT,
    ellipse_flows.EXPERIMENT,
    corners.EXPERIMENT,
    outliers.EXPERIMENT,
    noise.EXPERIMENT,
    spacing_gaps.EXPERIMENT,
    oscillations.EXPERIMENT,
    segment.EXPERIMENT,
    energy_decrease.EXPERIMENT,
    union_of_polyhedra.EXPERIMENT,
    polyhedral_gradients.EXPERIMENT,
    estimated_normals.EXPERIMENT,
    polyhedral_flows.EXPERIMENT,
    tubes.EXPERIMENT,
    area_convergence.EXPERIMENT,
    gradient_convergence.EXPERIMENT,
)
