"""Values as colors, by the color maps of matplotlib, which is an optional library."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError, PcsmoothError
from pcsmooth.parts.streamed_median import Reader, streamed_percentile

GREY = 128
"""Red, green and blue of a point whose value is unknown."""

#: The largest color stands for this percentile of the absolute values, and what is beyond.
_PERCENTILE = 98.0


def check_colormap(name: str) -> None:
    """Find out whether there is such a color map.

    Raises
    ------
    InvalidInputError
        If there is not.
    PcsmoothError
        If matplotlib is not installed.
    """
    _colormap(name)


def largest_shown(sizes: Reader) -> float:
    """Size that has the last color: all but the largest 2 percent are within.

    Parameters
    ----------
    sizes : callable
        Gives the absolute values of all that is known, in parts; the same ones at each call.

    Returns
    -------
    float
        Their 98th percentile, as `numpy.percentile` finds it; 0 if there are none.

    Examples
    --------
    >>> round(largest_shown(lambda: [np.abs(np.linspace(-1, 1, 201))]), 3)
    0.98
    """
    if not any(len(part) for part in sizes()):
        return 0.0
    return streamed_percentile(sizes, _PERCENTILE)


def colors_of(
    values: npt.NDArray[np.float64],
    known: npt.NDArray[np.bool_],
    colormap: str,
    limits: tuple[float, float],
) -> npt.NDArray[np.uint8]:
    """Colors of values.

    Parameters
    ----------
    values : ndarray, shape (n,)
        What is to be shown.
    known : ndarray of bool, shape (n,)
        False for values that mean nothing; they get `GREY`.
    colormap : str
        Name of a color map of matplotlib.
    limits : tuple of float
        The values with the first and last color of the map; what is beyond has the same. If they
        are equal, every value has the color in the middle.

    Returns
    -------
    ndarray of uint8, shape (n, 3)
        Red, green and blue.

    Raises
    ------
    InvalidInputError, PcsmoothError
        As `check_colormap`.

    Examples
    --------
    >>> colors_of(np.array([-5.0, 1.0, 0.0]), np.array([True, True, False]), "gray", (-1, 1))
    array([[  0,   0,   0],
           [255, 255, 255],
           [128, 128, 128]], dtype=uint8)
    """
    shades = _colormap(colormap)
    low, high = limits
    shares = np.full(len(values), 0.5)
    if low < high:
        shares[known] = (np.clip(values[known], low, high) - low) / (high - low)
    colors = np.full((len(values), 3), GREY, np.uint8)
    colors[known] = shades(shares[known], bytes=True)[:, :3]
    return colors


def _colormap(name: str) -> Any:
    try:
        import matplotlib
    except ImportError as error:
        raise PcsmoothError(
            "colors need matplotlib, which is not installed; pip install 'pcsmooth[colors]'"
        ) from error
    if name not in matplotlib.colormaps:
        raise InvalidInputError(
            f"there is no color map {name!r}; try coolwarm, RdBu, seismic, viridis, turbo or "
            "another of matplotlib"
        )
    return matplotlib.colormaps[name]
