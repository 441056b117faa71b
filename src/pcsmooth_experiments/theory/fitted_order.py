"""How fast an error falls: the exponent of the power law through it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt


def ranges_in_words(ranges: Mapping[str, npt.NDArray[np.float64]]) -> str:
    """Say over what range an order was fitted, for each shape.

    Examples
    --------
    >>> ranges_in_words({"circle": np.array([0.31, 0.1, 0.0097]), "torus": np.array([0.4, 0.1])})
    '0.31 to 0.0097 (circle), 0.4 to 0.1 (torus)'
    """
    return ", ".join(
        f"{values[0]:.2g} to {values[-1]:.2g} ({name})" for name, values in ranges.items()
    )


def fitted_order(sizes: npt.ArrayLike, errors: npt.ArrayLike) -> float:
    """Exponent p of the power law error ~ size^p, by least squares of the logarithms.

    Parameters
    ----------
    sizes : array_like, shape (n,)
        What becomes small, > 0, not all the same; n >= 2.
    errors : array_like, shape (n,)
        The errors; signs do not matter.

    Returns
    -------
    float
        The exponent; NaN if an error is 0.

    Examples
    --------
    >>> round(fitted_order([0.1, 0.2, 0.4], [0.02, 0.08, 0.32]), 6)
    2.0
    """
    x = np.log(np.asarray(sizes, np.float64))
    magnitudes = np.abs(np.asarray(errors, np.float64))
    if (magnitudes == 0.0).any():
        return float("nan")
    y = np.log(magnitudes)
    x = x - x.mean()
    return float(x @ y / (x @ x))
