"""Arrays of numbers as callers give them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError

Numbers = npt.NDArray[np.float64]


def real_array(values: npt.ArrayLike, name: str, *, may_be_bool: bool = False) -> Numbers:
    """Copy real numbers into a new array, in C order.

    Parameters
    ----------
    values : array_like of int or float
        Numbers; masked ones become NaN.
    name : str
        What they are, in the plural, for messages.
    may_be_bool : bool
        Whether truth values are numbers, too.

    Returns
    -------
    ndarray of float64

    Raises
    ------
    InvalidInputError
        They are something else, such as complex numbers, words or objects.

    Examples
    --------
    >>> real_array(np.ma.masked_equal([[1, 2], [3, -9]], -9), "points").tolist()
    [[1.0, 2.0], [3.0, nan]]
    """
    try:
        given = np.ma.asanyarray(values) if np.ma.isMaskedArray(values) else np.asarray(values)
    except (TypeError, ValueError) as error:
        raise InvalidInputError(f"{name} are not an array of real numbers ({error})") from error
    if given.dtype.kind not in ("biuf" if may_be_bool else "iuf"):
        raise InvalidInputError(
            f"{name} are not an array of real numbers, but of {given.dtype}; convert them to float"
        )
    numbers = np.array(given, dtype=np.float64, order="C")
    if np.ma.is_masked(given):
        numbers[np.ma.getmaskarray(given)] = np.nan
    return numbers
