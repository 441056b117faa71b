"""Normals of unit length, free of rounding where that is known."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

#: What is smaller, in units of the whole, is rounding.
ROUNDING = 1e-15


def unit_normals(
    normals: npt.NDArray[np.float64],
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Divide normals (n, d), not zero, by their lengths -> (n, d) and the lengths (n,).

    Unit normals stay as they are, and those along an axis have nothing but zeros and one 1.
    """
    lengths = np.linalg.norm(normals, axis=1)
    lengths[np.abs(lengths - 1.0) <= ROUNDING] = 1.0
    unit = normals / lengths[:, None]
    unit[np.abs(unit) <= ROUNDING] = 0.0
    on_axis = np.count_nonzero(unit, axis=1) == 1
    unit[on_axis] = np.sign(unit[on_axis])
    return unit, lengths
