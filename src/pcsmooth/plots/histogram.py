"""Histograms of distributions that share a scale."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

#: Fewest and most bins; between them there are as many as the square root of the values.
_BINS = (24, 60)

#: Height of a histogram in units of its highest bar: leaves room for a legend.
_HEADROOM = 1.35


def histograms(
    distributions: Mapping[str, npt.NDArray[np.float64]], limits: tuple[float, float]
) -> tuple[dict[str, npt.NDArray[np.int64]], npt.NDArray[np.float64]]:
    """Count values in bins between two limits; the outermost bins also hold what is beyond.

    Parameters
    ----------
    distributions : mapping of str to ndarray
        Finite values, by name.
    limits : tuple of float
        Begin of the first bin and end of the last.

    Returns
    -------
    counts : dict of str to ndarray of int, shape (m,)
        They add up to the number of values. The more values, the more bins, from 24 to 60.
    edges : ndarray, shape (m + 1,)
        Where bins begin and end.

    Examples
    --------
    >>> counts, edges = histograms({"a": np.array([-7.0, 0.1, 0.2, 9.0])}, (0.0, 6.0))
    >>> counts["a"][[0, 1, -1]].tolist(), edges[[0, 1, -1]].tolist()
    ([3, 0, 1], [0.0, 0.25, 6.0])
    """
    most = max(len(values) for values in distributions.values())
    edges = np.linspace(*limits, int(np.clip(np.sqrt(most), *_BINS)) + 1)
    counts = {
        name: np.histogram(np.clip(values, *limits), edges)[0].astype(np.int64)
        for name, values in distributions.items()
    }
    return counts, edges


def height_of(counts: Mapping[str, npt.NDArray[np.int64]]) -> float:
    """Height of the axis of histograms, with room above the bars."""
    return _HEADROOM * max(1, *(int(bars.max()) for bars in counts.values()))
