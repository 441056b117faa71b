"""A small picture of a denoised cloud."""

from __future__ import annotations

from io import BytesIO
from typing import Any

import numpy as np

from pcsmooth.files.denoise_file import Sample
from pcsmooth.plots.cloud_figure import LINE_COLORS
from pcsmooth.plots.figures import new_figure, png_of
from pcsmooth.plots.rough_normals import rough_normals
from pcsmooth.plots.shaded_cloud import ShadedCloud
from pcsmooth.plots.views import facing
from pcsmooth.positions import usable_rows

#: Pixels along the longer side, and inches.
_PIXELS = 240
_INCHES = 2.2

#: Nothing of what would change with the version of matplotlib.
_PLAIN: dict[str, Any] = {"Software": None}


def thumbnail(sample: Sample) -> bytes:
    """Draw a cloud after denoising, a surface as light falls on it.

    Parameters
    ----------
    sample : Sample
        The points, or some of them.

    Returns
    -------
    bytes
        PNG.

    Raises
    ------
    PcsmoothError
        If matplotlib is not installed.
    """
    rows = usable_rows(sample.after)
    points, normals = sample.after[rows], sample.normals[rows]
    if points.shape[1] == 2 or len(points) == 0:
        figure = new_figure(_INCHES, _INCHES)
        axes = figure.add_subplot()
        axes.scatter(points[:, 0], points[:, 1], s=2.0, color=LINE_COLORS[1], lw=0)
        axes.set_aspect("equal", "datalim")
        axes.set_axis_off()
        return png_of(figure)
    from matplotlib.image import imsave

    unknown = np.flatnonzero(~normals.any(axis=1))
    if len(unknown):
        normals = normals.copy()
        normals[unknown] = rough_normals(points)[unknown]
    cloud = ShadedCloud.of(points, normals, facing(normals))
    frame = cloud.frame(_PIXELS)
    seen = cloud.seen_in(frame, cloud.spacing(frame))
    drawn = BytesIO()
    imsave(
        drawn, np.ma.masked_invalid(seen), format="png", origin="lower", cmap="gray", vmin=0.0,
        vmax=1.0, metadata=_PLAIN,
    )  # fmt: skip
    return drawn.getvalue()
