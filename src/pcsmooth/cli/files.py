"""Reading and writing for commands: `-` for a stream, checks before any work is done."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pcsmooth.cli.messages import WARNING, Say, say_coordinates, say_warnings
from pcsmooth.cli.options import STANDARD_STREAM, Reading
from pcsmooth.cli.sources import find_sources, is_one_file
from pcsmooth.errors import CloudFileError

if TYPE_CHECKING:
    from pcsmooth.cloud import PointCloud

_HEAD = 1 << 16
"""Bytes that say of what format a file is."""


def display_name(path: str) -> str:
    """Name of an input in messages."""
    return "<stdin>" if path == STANDARD_STREAM else path


def read_input(path: str, reading: Reading, say: Say, *, keeps_noise: bool = False) -> PointCloud:
    """Read a cloud from a path or stdin, and say what of it is no matter of course.

    If `keeps_noise`, points that the file calls noise are like any other.

    Raises
    ------
    CloudFileError
        It cannot be read, or holds no points.
    """
    from pcsmooth.formats import is_text, read_cloud

    source = sys.stdin.buffer if path == STANDARD_STREAM else path
    is_beside_text = reading.among_text and not _may_be_text(path)
    columns = None if is_beside_text else reading.columns
    cloud = read_cloud(source, dim=reading.dim, columns=columns)
    if len(cloud) == 0:
        raise CloudFileError(display_name(path), "it holds no points", "give a file with points")
    if is_text(target_format(cloud, STANDARD_STREAM)):
        say_coordinates(cloud, display_name(path), say)
    say_warnings(cloud, display_name(path), say)
    return without_marks(cloud) if keeps_noise else cloud


def reading_of_all(reading: Reading, names: tuple[str, ...]) -> Reading:
    """Let chosen columns be those of the text files, if any, among what names stand for."""
    if reading.columns is None or is_one_file(names):
        return reading
    sources = names if STANDARD_STREAM in names else find_sources(names)
    return replace(reading, among_text=any(map(_may_be_text, sources)))


def _may_be_text(path: str) -> bool:
    """Whether a file is text of points by its beginning, or cannot be looked at beforehand."""
    from pcsmooth.formats import format_of, is_text

    if not os.path.isfile(path):
        return True
    try:
        with open(path, "rb") as file:
            return is_text(format_of(path, file.read(_HEAD)))
    except OSError:
        return True


def without_marks(cloud: PointCloud) -> PointCloud:
    """Let points that the file calls noise take part."""
    return replace(cloud, noise_marks=None)


def check_active(parts: Iterable[PointCloud], name: str) -> None:
    """Raise `CloudFileError` if the file calls all its points noise; reads no more than it must."""
    if all(part.noise_marks is not None and part.noise_marks.all() for part in parts):
        raise CloudFileError(
            name, "all its points are of a noise class or withheld", "pass --keep-noise-class"
        )


def count_noise(cloud: PointCloud) -> int:
    """Count the points that the file calls noise and that take no part."""
    return 0 if cloud.noise_marks is None else int(cloud.noise_marks.sum())


def check_target(path: str, overwrite: bool) -> None:
    """Raise `CloudFileError` if a file cannot be, or must not be, written there."""
    from pcsmooth.formats.link_target import link_target
    from pcsmooth.formats.system_errors import named_system_errors

    with named_system_errors(path):
        target = Path(link_target(path))
    if target.is_dir():
        raise CloudFileError(path, "is a folder", "name a file in it")
    if target.exists() and not overwrite:
        raise CloudFileError(path, "exists already", "pass --overwrite to replace it")
    folder = target.parent
    if not folder.is_dir():
        raise CloudFileError(path, f"there is no folder {folder}", "create it first")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise CloudFileError(path, f"folder {folder} cannot be written", "choose another folder")


def check_output(path: str, overwrite: bool) -> None:
    """Raise an error if a cloud cannot be written there."""
    if path != STANDARD_STREAM:
        from pcsmooth.formats import output_format

        check_target(path, overwrite)
        output_format(path)


def check_beside(path: str, option: str, overwrite: bool, say: Say, *others: str) -> None:
    """Raise an error if a file beside the cloud cannot be written, or is one of the others.

    What killed runs have left in its folder is removed.
    """
    from pcsmooth.formats.link_target import file_identity

    if path == STANDARD_STREAM:
        raise click.UsageError(f"{option} needs the name of a file")
    if file_identity(path) in map(file_identity, others):
        raise click.UsageError(
            f"{option} names a file that is already read or written; choose another file"
        )
    check_target(path, overwrite)
    remove_left_over(os.path.dirname(os.path.realpath(path)), say)


def check_suffix(path: str, *suffixes: str) -> None:
    """Raise `CloudFileError` unless the name of a file ends in one of the suffixes."""
    if Path(path).suffix.lower() not in suffixes:
        raise CloudFileError(
            path,
            f"its suffix {Path(path).suffix!r} does not say what to write",
            f"use {' or '.join(suffixes)}",
        )


def target_format(cloud: PointCloud, path: str) -> str:
    """Name of the format in which a cloud that was read will be written."""
    from pcsmooth.formats import output_format

    return output_format(None if path == STANDARD_STREAM else path, cloud)


def with_position_type(
    cloud: PointCloud, target: str, single: bool | None, *, for_pcl: bool = False
) -> PointCloud:
    """Choose the type of the positions to write.

    Parameters
    ----------
    cloud : PointCloud
        What was read.
    target : str
        Format of the file to be written.
    single : bool or None
        Whether positions are to be float; None leaves them as they were read. But PCL, and
        Open3D, read none but float, so that a new PCD file gets these.
    for_pcl : bool
        Whether None is for PCL in any format.
    """
    import numpy as np

    from pcsmooth.formats import naming_of

    own = target_format(cloud, STANDARD_STREAM)
    is_new_pcd = naming_of(target) == "pcd" and target != own
    if single is None and not (for_pcl or is_new_pcd):
        return cloud
    double = single is False
    return replace(cloud, position_type=np.dtype(np.float64 if double else np.float32))


def check_writable(cloud: PointCloud, path: str) -> None:
    """Raise an error if a cloud cannot be written there, or would fill a terminal with bytes."""
    from pcsmooth.formats import check_cloud, is_text

    name = target_format(cloud, path)
    if path == STANDARD_STREAM and sys.stdout.isatty() and not is_text(name):
        raise CloudFileError("<stdout>", "is a terminal", "redirect it to a file or a command")
    check_cloud(cloud, name, "<stdout>" if path == STANDARD_STREAM else path)


def write_output(cloud: PointCloud, path: str, overwrite: bool, say: Say) -> None:
    """Write a cloud to a path or to stdout."""
    from pcsmooth.formats import write_cloud

    if path != STANDARD_STREAM:
        write_cloud(cloud, path, overwrite=overwrite, tell=attribute_teller(path, say))
        return
    write_cloud(cloud, sys.stdout.buffer)
    sys.stdout.buffer.flush()


def write_beside(data: bytes, path: str, overwrite: bool, say: Say) -> None:
    """Write a file that is no cloud, as a whole or not at all."""
    from pcsmooth.formats.atomic import atomic_write
    from pcsmooth.formats.system_errors import named_system_errors

    tell = attribute_teller(path, say)
    with (
        named_system_errors(path),
        atomic_write(path, overwrite=overwrite, tell=tell) as file,
    ):
        file.write(data)


def attribute_teller(path: str, say: Say) -> Callable[[str], None]:
    """Return what says which attributes a replaced file has lost."""
    return lambda phrase: say(f"{WARNING} {path}: {phrase}")


def remove_left_over(folder: str, say: Say) -> None:
    """Remove from a folder, if it is there, what runs have left that were killed."""
    from pcsmooth.temporaries import remove_abandoned

    removed = remove_abandoned(folder)
    if removed:
        what = "temporary file or folder" if len(removed) == 1 else "temporary files and folders"
        say(f"{folder}: removed {len(removed)} {what} of runs that were killed")
