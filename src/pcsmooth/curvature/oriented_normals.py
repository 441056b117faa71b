"""Signs of normals: handed on between neighbours, then one decision for each component."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.curvature.component_votes import ComponentVotes
from pcsmooth.curvature.orientation import Orientation
from pcsmooth.kernels.surface.component_sums import turn
from pcsmooth.kernels.surface.spanning_forest import signs_along_forest


def agree_in_components(
    normals: npt.NDArray[np.float64],
    links: npt.NDArray[np.int32],
    numbers: npt.NDArray[np.int64],
    block_starts: npt.NDArray[np.int64],
) -> tuple[npt.NDArray[np.int32], int]:
    """Turn normals so that neighbours agree; either sign is left to each connected component.

    Parameters
    ----------
    normals : ndarray, shape (d, n)
        Unit normals of either sign, or zero where there is none; they get their sign in place.
    links : ndarray of int32, shape (n, k)
        Numbers of the nearest other points, n for none.
    numbers : ndarray of int64, shape (n,)
        Distinct numbers that order links of equal weight.
    block_starts : ndarray of int64, shape (b + 1,)
        Blocks of points within which those that are alike are joined first, from 0 to n.

    Returns
    -------
    labels : ndarray of int32, shape (n,)
        The component of each point, from 0.
    count : int
        Number of components.

    Notes
    -----
    Signs are handed on along a minimum spanning forest of the graph of neighbours with weights
    1 - abs(n_i . n_j) (Hoppe et al. 1992), one tree in each connected component. The normal of the
    lowest number in a component stays as it is.
    """
    signs, roots = signs_along_forest(normals, links, numbers, block_starts)
    turn(normals, signs.astype(np.float64))
    is_root = roots == np.arange(len(roots))
    labels = (np.cumsum(is_root, dtype=np.int32) - np.int32(1))[roots]
    return labels, int(is_root.sum())


def orient_normals(
    points: npt.NDArray[np.float64],
    normals: npt.NDArray[np.float64],
    areas: npt.NDArray[np.float64],
    links: npt.NDArray[np.int32],
    orientation: Orientation,
    given: npt.NDArray[np.float64] | None = None,
    numbers: npt.NDArray[np.int64] | None = None,
    block_starts: npt.NDArray[np.int64] | None = None,
) -> dict[str, int]:
    """Turn each normal so that neighbours agree and components look where they should.

    Parameters
    ----------
    points : ndarray, shape (d, n)
        Positions, n >= 1.
    normals : ndarray, shape (d, n)
        Unit normals of either sign, or zero where there is none; they get their sign in place.
    areas : ndarray, shape (n,)
        Weight of each point in its component, such as its visible boundary.
    links : ndarray of int32, shape (n, k)
        Numbers of the nearest other points, n for none.
    orientation : Orientation
        The rule; a viewpoint is in the frame of the points.
    given : ndarray, shape (d, n), optional
        Normals of the input for the rules ``input`` and ``auto``; zero where there is none.
    numbers, block_starts : ndarray of int64, optional
        See `agree_in_components`; by default the points' places and one block.

    Returns
    -------
    dict of str to int
        How many components got their sign for which reason; those without normals do not count.

    Notes
    -----
    First neighbours are made to agree (see `agree_in_components`). Then each connected component
    gets one sign:

    - outward: that for which sum a_i (p_i - c) . n_i, c the centroid, is positive, which by the
      divergence theorem is outward;
    - viewpoint, direction: that for which most of its area looks there;
    - propagate: that for which the normal at its last point along the last axis looks up;
    - input: points have the sign of the input's normal, those without one follow the majority;
    - auto: as the input where that has normals. Else outward, but where the normals' mean is
      longer than a quarter and the flux is below a quarter of sum a_i abs(p_i - c), the
      component is an open sheet, such as a terrain: its normals look along the positive
      direction of the axis that their mean is nearest to.

    Where a rule leaves the sign open, but for rounding, the lowest number keeps its normal.
    """
    if numbers is None:
        numbers = np.arange(normals.shape[1])
    if block_starts is None:
        block_starts = np.array([0, normals.shape[1]])
    labels, count = agree_in_components(normals, links, numbers, block_starts)
    votes = ComponentVotes(orientation, len(points), count)
    votes.add_places(points, areas, labels)
    votes.add_votes(points, normals, areas, labels, given)
    decided = votes.decide()
    turn(normals, decided.flips_of(normals, labels, given))
    return decided.counts()
