"""Whether points lie on a cable: a line in space that is no line of a scan of a surface."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pcsmooth.filters.design import FilterDesign
from pcsmooth.neighbors.surroundings import Surroundings


def on_cables(around: Surroundings, design: FilterDesign) -> npt.NDArray[np.bool_]:
    """Tell which points lie on cables.

    Parameters
    ----------
    around : Surroundings
        What is around some of the cloud's points.
    design : FilterDesign
        Numbers to go by.

    Returns
    -------
    ndarray of bool, shape (m,)
        None in the plane, where a curve is what a surface is in space.

    Notes
    -----
    The nearest points lie along a parabola, and are off it in all directions across. Points on a
    line of a scan are off it in one: along the beam.
    """
    samples, known, dimension = around.positions.shape
    if dimension == 2 or known < design.cable_support:
        return np.zeros(samples, np.bool_)
    neighborhoods = around.positions[:, : design.cable_support]
    offsets = neighborhoods - neighborhoods.mean(axis=1, keepdims=True)
    _, directions = np.linalg.eigh(offsets.transpose(0, 2, 1) @ offsets)
    local = offsets @ directions
    along, across = local[:, :, 2], local[:, :, :2]
    basis = np.stack([np.ones_like(along), along, along**2], axis=2)
    columns, _ = np.linalg.qr(basis)
    off = across - columns @ (columns.transpose(0, 2, 1) @ across)
    thin, wide = np.linalg.eigvalsh(off.transpose(0, 2, 1) @ off).T
    is_line = wide < design.cable_width * np.sum(along**2, axis=1)
    return np.asarray(is_line & (thin > design.cable_roundness * wide) & (wide > 0.0))
