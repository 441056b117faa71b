"""How much error the filter leaves along the normal of each point, as far as it can know."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.design import FilterDesign

Values = npt.NDArray[np.float64]


def after_pass(before: Values, shares: Values, heights: Values, design: FilterDesign) -> Values:
    """Find the variance of the errors after a pass.

    Parameters
    ----------
    before : ndarray, shape (n,)
        The same before it, L^2.
    shares : ndarray, shape (n,)
        Share of its move that each point took.
    heights : ndarray, shape (n,)
        Variances of the heights of the neighbours over the tangent plane, L^2.
    design : FilterDesign
        Numbers to go by.

    Returns
    -------
    ndarray, shape (n,)
        What a point keeps of its own error, and what the errors of its neighbours, and detail and
        other sheets among them, bring.
    """
    kept = 1.0 - (1.0 - design.left_kept) * shares
    return np.asarray(kept * before + design.left_heights * shares * heights)


def after_last_step(
    before: Values,
    noise: Values,
    sizes: tuple[Values, Values],
    shares: Values,
    heights: Values,
    dimension: int,
    design: FilterDesign,
) -> Values:
    """Find the standard deviation of the errors after the last step.

    Parameters
    ----------
    before : ndarray, shape (n,)
        Variance of the errors after the passes, L^2.
    noise : ndarray, shape (n,)
        Standard deviation of the noise, L.
    sizes : tuple of ndarray, shape (n,)
        Points of the neighbourhoods in the last of the passes, and in this step.
    shares : ndarray, shape (n,)
        Share of its move that each point took.
    heights : ndarray, shape (n,)
        Variances of the heights of the neighbours over the tangent plane, L^2.
    dimension : int
        d.
    design : FilterDesign
        Numbers to go by.

    Returns
    -------
    ndarray, shape (n,)
        L.
    """
    in_pass, in_last = sizes
    averaged = design.left_pass * (1.0 - shares) ** 2 / in_pass
    averaged += design.left_last[dimension] * shares**2 / in_last
    square = noise**2
    detail = design.left_detail * np.minimum(heights, square)
    return np.asarray(np.sqrt(before + square * averaged + detail))


def where_held_back(left: Values, noise: Values, shares: Values) -> Values:
    """Find the standard deviation where points went only a share of their way, (n,), L.

    The rest of it they keep of the noise of the input.
    """
    return np.asarray(np.hypot(shares * left, (1.0 - shares) * noise))
