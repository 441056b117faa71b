"""Measure the noise of a cloud in memory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.planning import plan_filter
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.measured import measure_cloud
from pcsmooth.parts.cloud_state import CloudState
from pcsmooth.parts.whole_cloud import WholeCloud
from pcsmooth.positions import as_positions, usable_rows
from pcsmooth.python.cloud_like import CloudLike, cloud_of
from pcsmooth.python.fact_table import FactTable


@dataclass(frozen=True, repr=False)
class MeasuredNoise(FactTable):
    """The noise of a cloud.

    Attributes
    ----------
    noise : float
        Standard deviation along the normal, L; the median where it differs from place to place.
    sigma : ndarray, shape (n,)
        That of each point, L; 0 for rows that are not finite.
    spacing : float
        Median spacing of the points as if on a square lattice, sqrt(area / number), L.
    has_surface : bool
        Whether a surface shows at any scale: the noise of points that fill a volume is none.
    """

    noise: float
    sigma: npt.NDArray[np.float64]
    spacing: float
    has_surface: bool

    def facts(self) -> dict[str, str]:
        """Say the most important numbers, in words by name."""
        told = {"points": str(len(self.sigma)), "noise": f"{self.noise:.4g}"}
        if self.spacing > 0.0:
            told["in local spacings"] = f"{self.noise / self.spacing:.2g}"
        return told | ({} if self.has_surface else {"surface": "none shows at any scale"})


def measure_noise(
    points: CloudLike, *, closed: bool = False, threads: int | None = None
) -> MeasuredNoise:
    """Measure the noise of a cloud as `denoise` does before it filters; no point moves.

    Parameters
    ----------
    points : array_like, shape (n, 2) or (n, 3), or a cloud
        Positions, L, or a cloud that has them, as `denoise` takes them.
    closed : bool
        Whether the surface is told to be closed (see `Filter`).
    threads : int, optional
        Threads to use, all by default. The result does not depend on it.

    Returns
    -------
    MeasuredNoise
        All zeros where there are too few points to measure noise.

    Raises
    ------
    InvalidInputError
        Wrong shapes, or no finite point.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> sheet = np.c_[rng.uniform(0, 1, (2000, 2)), rng.normal(0, 0.01, 2000)]
    >>> bool(abs(measure_noise(sheet).noise - 0.01) < 0.001)
    True
    """
    positions = as_positions(cloud_of(points).active_points)
    finite = usable_rows(positions)
    with thread_limit(threads):
        cloud = WholeCloud.of(positions, finite)
        plan = plan_filter(cloud, measure_cloud(cloud).distinct, closed=closed)
    sigma = np.zeros(len(positions))
    if plan is None:
        return MeasuredNoise(0.0, sigma, 0.0, has_surface=False)
    places = CloudState.at_start(cloud).points.read(0, cloud.count)
    scales = None if plan.scale_map is None else plan.scale_map.at(places)
    sigma[cloud.input_rows] = plan.noise_at(scales, cloud.count) * cloud.unit
    plan = plan.scaled(cloud.unit)
    return MeasuredNoise(plan.noise.deviation, sigma, plan.spacing, plan.has_surface)
