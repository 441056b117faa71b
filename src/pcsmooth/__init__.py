"""Denoise point clouds: by a filter that measures their noise, or by flows of unions of shapes.

The names below are loaded when they are first used, so that ``import pcsmooth`` stays light.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pcsmooth.bodies.convex_body import ConvexBody
    from pcsmooth.bodies.presets import load_presets
    from pcsmooth.cloud import PointCloud
    from pcsmooth.curvature.estimate import CurvatureEstimate
    from pcsmooth.energies.balls import BallEnergy, BallUnion, measure_balls
    from pcsmooth.energies.polyhedra.union import (
        PolyhedronEnergy,
        PolyhedronUnion,
        measure_polyhedra,
    )
    from pcsmooth.errors import CloudFileError, InvalidInputError, PcsmoothError
    from pcsmooth.files.denoise_file import denoise_file
    from pcsmooth.files.report import DenoiseReport
    from pcsmooth.files.selection import Selection
    from pcsmooth.files.writing import Writing
    from pcsmooth.formats import read_cloud, write_cloud
    from pcsmooth.methods.estimate import Estimate
    from pcsmooth.methods.filter import Filter
    from pcsmooth.methods.flows import EulerFlow, ImplicitFlow
    from pcsmooth.methods.motion import Motion
    from pcsmooth.methods.shapes import Balls, Polyhedra
    from pcsmooth.neighbors.local_spacing import local_spacings
    from pcsmooth.progress import Progress
    from pcsmooth.python.denoising import denoise
    from pcsmooth.python.estimating import estimate_curvature
    from pcsmooth.python.noise import MeasuredNoise, measure_noise
    from pcsmooth.python.results import CurvatureResult, DenoiseResult

_HOMES = {
    "ConvexBody": "pcsmooth.bodies.convex_body",
    "load_presets": "pcsmooth.bodies.presets",
    "PointCloud": "pcsmooth.cloud",
    "CurvatureEstimate": "pcsmooth.curvature.estimate",
    "estimate_curvature": "pcsmooth.python.estimating",
    "DenoiseReport": "pcsmooth.files.report",
    "DenoiseResult": "pcsmooth.python.results",
    "denoise": "pcsmooth.python.denoising",
    "denoise_file": "pcsmooth.files.denoise_file",
    "Selection": "pcsmooth.files.selection",
    "Writing": "pcsmooth.files.writing",
    "BallEnergy": "pcsmooth.energies.balls",
    "BallUnion": "pcsmooth.energies.balls",
    "measure_balls": "pcsmooth.energies.balls",
    "PolyhedronEnergy": "pcsmooth.energies.polyhedra.union",
    "PolyhedronUnion": "pcsmooth.energies.polyhedra.union",
    "measure_polyhedra": "pcsmooth.energies.polyhedra.union",
    "CloudFileError": "pcsmooth.errors",
    "InvalidInputError": "pcsmooth.errors",
    "PcsmoothError": "pcsmooth.errors",
    "read_cloud": "pcsmooth.formats",
    "write_cloud": "pcsmooth.formats",
    "Balls": "pcsmooth.methods.shapes",
    "Estimate": "pcsmooth.methods.estimate",
    "EulerFlow": "pcsmooth.methods.flows",
    "Filter": "pcsmooth.methods.filter",
    "ImplicitFlow": "pcsmooth.methods.flows",
    "Motion": "pcsmooth.methods.motion",
    "Polyhedra": "pcsmooth.methods.shapes",
    "local_spacings": "pcsmooth.neighbors.local_spacing",
    "Progress": "pcsmooth.progress",
    "CurvatureResult": "pcsmooth.python.results",
    "MeasuredNoise": "pcsmooth.python.noise",
    "measure_noise": "pcsmooth.python.noise",
}

__all__ = [
    "BallEnergy",
    "BallUnion",
    "Balls",
    "CloudFileError",
    "ConvexBody",
    "CurvatureEstimate",
    "CurvatureResult",
    "DenoiseReport",
    "DenoiseResult",
    "Estimate",
    "EulerFlow",
    "Filter",
    "ImplicitFlow",
    "InvalidInputError",
    "MeasuredNoise",
    "Motion",
    "PcsmoothError",
    "PointCloud",
    "Polyhedra",
    "PolyhedronEnergy",
    "PolyhedronUnion",
    "Progress",
    "Selection",
    "Writing",
    "denoise",
    "denoise_file",
    "estimate_curvature",
    "load_presets",
    "local_spacings",
    "measure_balls",
    "measure_noise",
    "measure_polyhedra",
    "read_cloud",
    "write_cloud",
]

__version__ = "0.1.0"


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOMES])
