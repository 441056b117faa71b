"""Denoise point clouds by gradient descent on the volume or area of a union of balls.

The names below are loaded when they are first used, so that ``import pcsmooth`` stays light.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pcsmooth.cloud import PointCloud
    from pcsmooth.curvature.estimate import CurvatureEstimate, estimate_curvature
    from pcsmooth.denoising import DenoiseResult, denoise
    from pcsmooth.energies.balls import BallEnergy, BallUnion, measure_balls
    from pcsmooth.errors import CloudFileError, InvalidInputError, PcsmoothError
    from pcsmooth.formats import read_cloud, write_cloud

_HOMES = {
    "PointCloud": "pcsmooth.cloud",
    "CurvatureEstimate": "pcsmooth.curvature.estimate",
    "estimate_curvature": "pcsmooth.curvature.estimate",
    "DenoiseResult": "pcsmooth.denoising",
    "denoise": "pcsmooth.denoising",
    "BallEnergy": "pcsmooth.energies.balls",
    "BallUnion": "pcsmooth.energies.balls",
    "measure_balls": "pcsmooth.energies.balls",
    "CloudFileError": "pcsmooth.errors",
    "InvalidInputError": "pcsmooth.errors",
    "PcsmoothError": "pcsmooth.errors",
    "read_cloud": "pcsmooth.formats",
    "write_cloud": "pcsmooth.formats",
}

__all__ = [
    "BallEnergy",
    "BallUnion",
    "CloudFileError",
    "CurvatureEstimate",
    "DenoiseResult",
    "InvalidInputError",
    "PcsmoothError",
    "PointCloud",
    "denoise",
    "estimate_curvature",
    "measure_balls",
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
