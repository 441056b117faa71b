"""Meshes are read and written at once: faces refer to any of their points."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import BinaryIO

from pcsmooth.cloud import PointCloud
from pcsmooth.formats.byte_source import ByteSource
from pcsmooth.formats.cloud_file import FileAtOnce


def open_mesh(
    source: ByteSource, dim: int | None, *, read: Callable[[bytes, str, int | None], PointCloud]
) -> FileAtOnce:
    """Open a mesh that a function of its bytes, its name and its coordinates reads."""
    return FileAtOnce(source, lambda data: read(data, source.path, dim), "a mesh")


def write_mesh(
    cloud: PointCloud,
    _count: int,
    _chunks: Iterable[PointCloud],
    file: BinaryIO,
    path: str,
    *,
    write: Callable[[PointCloud, BinaryIO, str], None],
) -> None:
    """Write a mesh, of which the template is all, by a function of the cloud."""
    write(cloud, file, path)
