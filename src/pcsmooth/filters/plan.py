"""What was found of a cloud, and what a filter does to it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.winding_field import WindingField
from pcsmooth.filters.design import FilterDesign
from pcsmooth.filters.neighborhoods import Width
from pcsmooth.filters.noise import Noise
from pcsmooth.filters.scales import ScaleMap, Scales

#: Share by which a way may be shorter than its limit for rounding: it is scaled to it, and added to
#: coordinates of a few hundred times its length, or more.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class FilterPlan:
    """What was found of a cloud, and how it is to be filtered.

    Attributes
    ----------
    noise : Noise
        Its noise, measured, or as it was told.
    has_surface : bool
        Whether a surface shows at any scale (see `shows_surface`), or the noise was told: points
        that fill a volume have none to be moved to.
    spacing : float
        Median spacing of the points as if on a square lattice, sqrt(area / number), L.
    density_variation : float
        Ratio of the local spacings at the 95th and the 5th percentile.
    passes : tuple of Width
        Neighbourhoods of the passes.
    last : Width
        Neighbourhoods of the last step.
    support : float
        Points of a neighbourhood of the first pass at the median.
    design : FilterDesign
        By which this was found, and by which all steps go.
    scale_map : ScaleMap or None
        Noise and spacing as they differ from place to place; None if one of each does for the whole
        cloud.
    stray_share : float
        Share of the samples that were left out, as outliers that are many (see `has_crowd`).
    winding : WindingField or None
        Which side of the surface is outside; None where it is not known.
    is_closed : bool
        Whether the surface was told to be closed.
    """

    noise: Noise
    has_surface: bool
    spacing: float
    density_variation: float
    passes: tuple[Width, ...]
    last: Width
    support: float
    design: FilterDesign
    scale_map: ScaleMap | None = None
    stray_share: float = 0.0
    winding: WindingField | None = None
    is_closed: bool = False

    @property
    def moves_points(self) -> bool:
        """Whether there is anything to filter: noise, and a surface to take it from."""
        return self.has_surface and self.noise.deviation > 0.0

    @property
    def largest_noise(self) -> float:
        """Largest standard deviation of the noise at any point, L."""
        return (
            self.noise.deviation
            if self.scale_map is None
            else float(self.scale_map.scales.noise.max())
        )

    @property
    def noise_range(self) -> tuple[float, float] | None:
        """Noise at the 5th and the 95th percentile of the points, L; None if one noise does."""
        if self.scale_map is None:
            return None
        low, high = np.quantile(self.scale_map.scales.noise, (0.05, 0.95))
        return float(low), float(high)

    @property
    def max_move(self) -> float:
        """Most that a point ends up away from its start, in units of the noise there."""
        return self.design.max_move if self.scale_map is None else self.design.max_move_by_map

    @property
    def tells_sides_apart(self) -> bool | None:
        """Whether the sides of thin parts are told apart; None if that was not asked for."""
        return self.winding is not None if self.is_closed else None

    def scales_at(self, points: npt.NDArray[np.float64]) -> Scales | None:
        """Give noise and spacing at points (n, d), L; None if they are the same everywhere."""
        return None if self.scale_map is None else self.scale_map.at(points)

    def noise_at(self, scales: Scales | None, count: int) -> npt.NDArray[np.float64]:
        """Give the noise, L, at so many points, whose scales may be known."""
        return np.full(count, self.noise.deviation) if scales is None else scales.noise

    def limits_at(self, scales: Scales | None, count: int) -> npt.NDArray[np.float64]:
        """Give the most that so many points may end up away from their start, (n,), L."""
        taken = np.full(count, self.noise.deviation) if scales is None else scales.taken
        return self.max_move * taken

    def count_at_limit(
        self, noise: npt.NDArray[np.float64] | float, moved: npt.NDArray[np.float64]
    ) -> int:
        """Count points of a noise, (n,) or one, L, that have moved, (n,), L, as far as any may."""
        limits = (1.0 - _ROUNDING) * self.max_move * noise
        return int(np.count_nonzero((moved >= limits) & (moved > 0.0)))

    def largest_radius(self, width: Width) -> float:
        """Largest radius that a neighbourhood may have, L."""
        if self.scale_map is None:
            return width.max_radius
        dimension = self.scale_map.samples.shape[1]
        return float(width.radii(self.scale_map.scales.extreme(np.max), dimension).most[0])

    def scaled(self, factor: float) -> FilterPlan:
        """Return the same for a cloud times a factor."""
        return replace(
            self,
            noise=self.noise.scaled(factor),
            spacing=self.spacing * factor,
            passes=tuple(width.scaled(factor) for width in self.passes),
            last=self.last.scaled(factor),
            scale_map=None if self.scale_map is None else self.scale_map.scaled(factor),
            winding=None if self.winding is None else self.winding.scaled(factor),
        )
