"""Some rows of a cloud, with what the layout of their file knows of each."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from pcsmooth.formats.las.positions import LasLayout
from pcsmooth.formats.pcd.layout import PcdLayout
from pcsmooth.formats.ply.layout import PlyLayout
from pcsmooth.formats.text.layout import TextLayout

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from pcsmooth.cloud import PointCloud

#: Formats whose files are written around the lines of the one that was read.
_MESHES = ("obj", "off", "stl")


def some_rows(cloud: PointCloud, kept: npt.NDArray[np.bool_]) -> PointCloud:
    """Keep some rows of a cloud in their order.

    Parameters
    ----------
    cloud : PointCloud
        All points of a file, or some of them.
    kept : ndarray of bool, shape (n,)
        Which stay.

    Returns
    -------
    PointCloud
        What else a file holds, such as faces, is as it was; `refers_to_rows` tells whether it
        names rows by their numbers.
    """
    layout = cloud.layout
    if isinstance(layout, PlyLayout | PcdLayout | TextLayout | LasLayout):
        layout = layout.of_rows(kept)
    fixed, noise = cloud.fixed_marks, cloud.noise_marks
    return replace(
        cloud,
        points=cloud.points[kept],
        columns={name: column[kept] for name, column in cloud.columns.items()},
        fixed_marks=None if fixed is None else fixed[kept],
        noise_marks=None if noise is None else noise[kept],
        layout=layout,
    )


def grid_of_rows(cloud: PointCloud, format: str) -> str:
    """Name the order in rows and columns that a file has, and that is lost with any of its rows.

    Parameters
    ----------
    cloud : PointCloud
        What was read, perhaps without its points.
    format : str
        The format of the file to be written.

    Returns
    -------
    str
        Such as ``640 x 480 points``; nothing if there is none.
    """
    layout = cloud.layout
    if format != "pcd" or not isinstance(layout, PcdLayout) or layout.header.height == 1:
        return ""
    return f"{layout.header.width} x {layout.header.height} points"


def refers_to_rows(cloud: PointCloud, format: str) -> str:
    """Name what a file of a format would hold that names rows by their numbers.

    Parameters
    ----------
    cloud : PointCloud
        What is to be written, perhaps without its points.
    format : str
        The format of the file.

    Returns
    -------
    str
        Such as ``element 'face'``; nothing if there is no such thing.
    """
    layout = cloud.layout
    if format in _MESHES and getattr(layout, "format", "") == format:
        return "a face"
    if format == "ply" and isinstance(layout, PlyLayout):
        return layout.names_vertices
    return ""
