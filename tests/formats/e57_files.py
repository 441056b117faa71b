"""E57 files made by the reference library, for the tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from pye57 import libe57


@dataclass(frozen=True)
class Scan:
    """Fields of a scan, its pose (w x y z, x y z), its name, and steps of scaled integers."""

    fields: Mapping[str, npt.NDArray[Any]]
    rotation: Sequence[float] | None = None
    translation: Sequence[float] | None = None
    name: str | None = None
    steps: Mapping[str, float] = field(default_factory=dict)


def save_e57(path: Path, *scans: Scan, metadata: str = "") -> Path:
    """Write scans to a file."""
    image = libe57.ImageFile(str(path), "w")
    image.extensionsAdd("", libe57.E57_V1_0_URI)
    image.extensionsAdd("nor", "http://www.libe57.org/E57_NOR_surface_normals.txt")
    root = image.root()
    root.set("formatName", libe57.StringNode(image, "ASTM E57 3D Imaging Data File"))
    root.set("guid", libe57.StringNode(image, "{none}"))
    root.set("versionMajor", libe57.IntegerNode(image, libe57.E57_FORMAT_MAJOR))
    root.set("versionMinor", libe57.IntegerNode(image, libe57.E57_FORMAT_MINOR))
    root.set("coordinateMetadata", libe57.StringNode(image, metadata))
    data = libe57.VectorNode(image, True)
    root.set("data3D", data)
    for scan in scans:
        _add_scan(image, data, scan)
    image.close()
    return path


def _add_scan(image: Any, data: Any, scan: Scan) -> None:
    node = libe57.StructureNode(image)
    if scan.name is not None:
        node.set("name", libe57.StringNode(image, scan.name))
    if scan.rotation is not None or scan.translation is not None:
        node.set("pose", _pose(image, scan))
    prototype = libe57.StructureNode(image)
    for name, values in scan.fields.items():
        prototype.set(name, _prototype(image, values, scan.steps.get(name)))
    points = libe57.CompressedVectorNode(image, prototype, libe57.VectorNode(image, True))
    node.set("points", points)
    data.append(node)
    n = len(next(iter(scan.fields.values())))
    if n == 0:
        return
    buffers = libe57.VectorSourceDestBuffer()
    kept = [
        np.ascontiguousarray(values, np.longlong if values.dtype.kind in "iu" else values.dtype)
        for values in scan.fields.values()
    ]
    for name, values in zip(scan.fields, kept, strict=True):
        buffers.append(libe57.SourceDestBuffer(image, name, values, n, True, True))
    writer = points.writer(buffers)
    writer.write(n)
    writer.close()


def _pose(image: Any, scan: Scan) -> Any:
    pose = libe57.StructureNode(image)
    for name, axes, values in (
        ("rotation", "wxyz", scan.rotation),
        ("translation", "xyz", scan.translation),
    ):
        if values is not None:
            part = libe57.StructureNode(image)
            for axis, value in zip(axes, values, strict=True):
                part.set(axis, libe57.FloatNode(image, value))
            pose.set(name, part)
    return pose


def _prototype(image: Any, values: npt.NDArray[Any], step: float | None) -> Any:
    if step is not None:
        low, high = (round(float(end) / step) for end in (values.min(), values.max()))
        return libe57.ScaledIntegerNode(image, low, low, high, step, 0.0)
    if values.dtype.kind == "U":
        return libe57.StringNode(image)
    if values.dtype.kind == "f":
        single = values.dtype.itemsize == 4
        return libe57.FloatNode(image, 0.0, libe57.E57_SINGLE if single else libe57.E57_DOUBLE)
    limits = np.iinfo(values.dtype)
    return libe57.IntegerNode(image, 0, int(limits.min), int(limits.max))
