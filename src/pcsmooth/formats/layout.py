"""What the layouts of all formats have in common."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from pcsmooth.cloud import PointCloud


@runtime_checkable
class Layout(Protocol):
    """What only the format that read a file knows of it.

    Attributes
    ----------
    format : str
        Name of the format, in which the cloud is written to a stream.
    besides : list of str
        What the file holds besides its points, in words; no other format takes it over.
    """

    @property
    def format(self) -> str: ...  # noqa: D102

    @property
    def besides(self) -> list[str]: ...  # noqa: D102


def lost_besides(cloud: PointCloud, own: type) -> list[str]:
    """Say what of a cloud's file, besides its points, a file with another layout cannot hold.

    Parameters
    ----------
    cloud : PointCloud
        What would be written.
    own : type
        The layout of the file to be written.

    Returns
    -------
    list of str
        Phrases; empty if the cloud has this layout, or none.
    """
    layout = cloud.layout
    return list(layout.besides) if isinstance(layout, Layout) and type(layout) is not own else []
