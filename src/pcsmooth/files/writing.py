"""How estimates are to be written, as it is asked for."""

from __future__ import annotations

from dataclasses import dataclass

from pcsmooth.files.output_columns import Convention, Dialect


@dataclass(frozen=True)
class Writing:
    """How estimates are to be written.

    Attributes
    ----------
    convention : {"half", "sum"}
        Which mean curvature.
    dialect : {"generic", "meshlab", "cloudcompare", "pcl"}
        Which program the columns of a PLY file are for.
    colormap : str or None
        Color map, None for no colors.
    color_by : {"mean", "gaussian", "k1", "k2", "confidence"}
        The estimate shown in colors.
    single : bool or None
        Whether positions are float; None leaves it to input and dialect. LAS has its steps.
    """

    convention: Convention = "half"
    dialect: Dialect = "generic"
    colormap: str | None = None
    color_by: str = "mean"
    single: bool | None = None
