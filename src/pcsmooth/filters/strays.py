"""Crowds of outliers, found among the samples of a cloud, whose measures they would spoil."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.design import FilterDesign
from pcsmooth.filters.flatness import thicknesses
from pcsmooth.filters.scales import lattice_spacing
from pcsmooth.neighbors.k_nearest import k_nearest
from pcsmooth.neighbors.surroundings import Surroundings

#: Samples from which the spacing of the dense parts spreads to all, at most.
_SOURCES = 800


def has_crowd(around: Surroundings, design: FilterDesign) -> bool:
    """Whether so many samples of a cloud are strays that they spoil what is measured from them.

    They are a crowd of outliers if most are so clearly: the points of vegetation and of other
    sparse and ragged parts are of all densities.
    """
    strays = find_strays(around, design)
    clear = find_strays(around, design, design.stray_clear)
    return len(clear) >= max(
        design.stray_min_share * len(around.distances), design.stray_clear_share * len(strays)
    )


def leave_out_strays(around: Surroundings, design: FilterDesign) -> Surroundings:
    """Leave out the samples of a cloud that lie on no surface: see `find_strays`."""
    kept = np.ones(len(around.distances), np.bool_)
    kept[find_strays(around, design)] = False
    return replace(around, distances=around.distances[kept], positions=around.positions[kept])


def find_strays(
    around: Surroundings, design: FilterDesign, factor: float = 1.0
) -> npt.NDArray[np.int64]:
    """Tell which samples of a cloud lie on no surface.

    Parameters
    ----------
    around : Surroundings
        What is around samples of the cloud.
    design : FilterDesign
        Numbers to go by.
    factor : float
        By how much more they are to differ from those of a surface.

    Returns
    -------
    ndarray of int
        Their numbers.

    Notes
    -----
    Outliers that are spread over the space around a surface are farther apart than its points. So
    may points of a scan's sparse parts be; but their neighbourhoods are flat, or lines. A sample is
    a stray if it is more than twice as far from others as the dense parts let expect, and if, in
    the median over it and the like of it around, neighbourhoods are thick, or the sample lies off
    them. What the dense parts let expect is the least spacing of any sample, more with the distance
    from that one: by half the angle between the beams if all points had been seen from one place.
    """
    samples = np.ascontiguousarray(around.positions[:, 0])
    m, known, dimension = around.positions.shape
    counts = [min(count, known) for count in design.stray_counts]
    nobody = np.empty(0, np.int64)
    if m < design.stray_group or counts[1] <= dimension + 1:
        return nobody
    near, wide = (
        lattice_spacing(around.distances[:, count - 1], count, dimension) for count in counts
    )
    expected = _expected_spacings(samples, wide, around.count, design)
    suspects = np.flatnonzero(np.maximum(near, wide) > factor * design.stray_distance * expected)
    if len(suspects) < design.stray_group:
        return nobody
    seen = thicknesses(around.positions[suspects, : counts[1]])
    _, nearest = k_nearest(samples[suspects], samples[suspects], design.stray_group)
    typical = np.median(seen[nearest], axis=1)
    return suspects[typical > factor * design.stray_thickness[dimension]]


def _expected_spacings(
    samples: npt.NDArray[np.float64],
    spacings: npt.NDArray[np.float64],
    count: int,
    design: FilterDesign,
) -> npt.NDArray[np.float64]:
    """Spacing at samples (m, d) of so many points that the dense parts let expect, (m,), L."""
    dimension = samples.shape[1]
    angle = math.sqrt(4.0 * math.pi / count) if dimension == 3 else 2.0 * math.pi / count
    slope = design.stray_slope * angle
    # A few points that lie close together, as clumps of outliers do, are no dense part.
    _, nearest = k_nearest(samples, samples, design.stray_group)
    expected = np.maximum(spacings, np.median(spacings[nearest], axis=1))
    every = -(-len(samples) // _SOURCES)
    for point, spacing in zip(samples[::every], expected[::every], strict=True):
        farther = spacing + slope * np.linalg.norm(samples - point, axis=1)
        np.minimum(expected, farther, out=expected)
    return expected
