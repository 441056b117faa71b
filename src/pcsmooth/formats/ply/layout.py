"""What a PLY file holds besides its points."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt
from plyfile import PlyElement, PlyListProperty

from pcsmooth.cloud import PointCloud
from pcsmooth.formats.axis_names import normals_among
from pcsmooth.formats.ply.header import PlyHeader, name_in_header
from pcsmooth.formats.typed_rows import OddWords, renumbered
from pcsmooth.printable import counted


@dataclass(frozen=True)
class PlyLayout:
    """What a PLY file holds besides its points.

    Attributes
    ----------
    header : PlyHeader
        The header as read: encoding, elements and properties in their order, ``obj_info``.
    axes : tuple of str
        Names of the position properties, as spelled in the file.
    rows : tuple of iterable of bytes
        The rows of each element as they are in the file, in one or more pieces; none for the
        vertices.
    odd_words : dict
        Numbers of the vertices that are not finite and spelled in their own way, by row and
        property.
    """

    header: PlyHeader
    axes: tuple[str, ...]
    rows: tuple[Iterable[bytes], ...]
    odd_words: OddWords = field(default_factory=dict)

    @property
    def columns(self) -> dict[str, str]:
        """The column that each property of the vertices is, by what plyfile calls it."""
        spelled = {prop.name: name_in_header(prop) for prop in self.vertex.properties}
        normals = normals_among(spelled.values())
        return {prop: normals.get(name, name) for prop, name in spelled.items()}

    @property
    def vertex(self) -> PlyElement:
        """Description of the vertex element."""
        return next(element for element in self.header.elements if element.name == "vertex")

    @property
    def format(self) -> str:
        """Name of the format."""
        return "ply"

    @property
    def besides(self) -> list[str]:
        """Every element but the vertices, in words."""
        return [
            f"element '{element.name}' ({counted(element.count, 'row')})"
            for element in self.header.elements
            if element.name != "vertex"
        ]

    @property
    def names_vertices(self) -> str:
        """The first element that has rows, and lists or numbers of vertices; nothing if none."""
        for element in self.header.elements:
            if element.name != "vertex" and element.count:
                for prop in element.properties:
                    if isinstance(prop, PlyListProperty) or prop.name.startswith("vertex"):
                        return f"element '{element.name}'"
        return ""

    def of_rows(self, kept: npt.NDArray[np.bool_]) -> PlyLayout:
        """Give the layout of the vertices (n,) that stay."""
        return replace(self, odd_words=renumbered(self.odd_words, kept))


NEW_FILE = PlyLayout(
    PlyHeader(text=False, byte_order="<", elements=(PlyElement("vertex", (), 0),)),
    axes=("x", "y", "z"),
    rows=((),),
)
"""Layout of a cloud that did not come from a PLY file."""


def layout_of(cloud: PointCloud) -> PlyLayout:
    """Layout of the PLY file that a cloud came from, or that of a new one."""
    return cloud.layout if isinstance(cloud.layout, PlyLayout) else NEW_FILE
