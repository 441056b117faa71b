"""Reading and writing for commands: `-` for a stream, checks before any work is done."""

from __future__ import annotations

import math
import os
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pcsmooth.cli.options import STANDARD_STREAM, Reading
from pcsmooth.cli.sources import find_sources, is_one_file
from pcsmooth.errors import CloudFileError
from pcsmooth.files.notes import WARNING, Say, remove_left_over
from pcsmooth.files.targets import check_target

if TYPE_CHECKING:
    from pcsmooth.cloud import PointCloud
    from pcsmooth.files.opening import InputFile
    from pcsmooth.files.result_file import Target


def display_name(path: str) -> str:
    """Name of an input in messages."""
    return "<stdin>" if path == STANDARD_STREAM else path


def source_of(path: str, reading: Reading, *, keeps_noise: bool = False) -> InputFile:
    """Say what a command reads from a path or stdin; if `keeps_noise`, noise is like any point."""
    from pcsmooth.files.opening import InputFile

    stream = sys.stdin.buffer if path == STANDARD_STREAM else None
    is_beside_text = reading.among_text and not _may_be_text(path)
    columns = None if is_beside_text else reading.columns
    return InputFile(display_name(path), stream, reading.dim, columns, keeps_noise)


def target_of(path: str, overwrite: bool) -> Target:
    """Say where a command writes: to a path or to stdout."""
    from pcsmooth.files.result_file import Target

    return Target(path, sys.stdout.buffer if path == STANDARD_STREAM else None, overwrite)


def reading_of_all(reading: Reading, names: tuple[str, ...], *, recursive: bool = False) -> Reading:
    """Let chosen columns be those of the text files, if any, among what names stand for."""
    if reading.columns is None or is_one_file(names):
        return reading
    paths = (
        names
        if STANDARD_STREAM in names
        else [source.path for source in find_sources(names, recursive=recursive)]
    )
    return replace(reading, among_text=any(map(_may_be_text, paths)))


def _may_be_text(path: str) -> bool:
    """Whether a file is text of points by its beginning, or cannot be looked at beforehand."""
    from pcsmooth.formats import format_of_file, is_text

    if not os.path.isfile(path):
        return True
    try:
        return is_text(format_of_file(path)[0])
    except OSError:
        return True


def check_output(path: str, overwrite: bool) -> None:
    """Raise an error if a cloud cannot be written there."""
    if path != STANDARD_STREAM:
        from pcsmooth.formats import output_format

        if os.path.isdir(path):
            raise CloudFileError(
                path, "is a folder", "give it as --output-dir, or name a file in it"
            )
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


@dataclass(frozen=True)
class Written:
    """What a file has become of a cloud.

    Attributes
    ----------
    format : str
        Name of its format.
    lost : list of str
        What it does not hold.
    rounding : float
        Most that a coordinate was rounded, L.
    """

    format: str
    lost: list[str]
    rounding: float


def write_and_say(
    cloud: PointCloud, path: str, overwrite: bool, say: Say, single: bool | None = None
) -> Written:
    """Write a cloud to a path or to stdout; say what is lost of it, and how far it is rounded."""
    from pcsmooth.files.estimates_output import with_position_type
    from pcsmooth.formats import lost_in, stored_positions
    from pcsmooth.formats.stored_positions import MUCH_ROUNDING

    check_writable(cloud, path)
    target = target_format(cloud, path)
    cloud = with_position_type(cloud, target, single)
    lost = lost_in(cloud, target)
    if lost:
        say(f"{WARNING} {target} files cannot hold {', '.join(lost)}")
    stored = stored_positions(cloud, target, path)
    if stored.note:
        say(stored.note)
    rounding = stored.rounding(cloud)
    if rounding > 0.0:
        words = stored.rounding_in_words(rounding)
        say(f"{WARNING} {words}" if rounding > MUCH_ROUNDING * _rough_spacing(cloud) else words)
    write_output(cloud, path, overwrite, say)
    return Written(target, lost, rounding)


def _rough_spacing(cloud: PointCloud) -> float:
    """Spacing of as many points on a flat sheet, or a line, of the same diagonal; 0 of none."""
    import numpy as np

    finite = cloud.points[np.isfinite(cloud.points).all(axis=1)]
    if len(finite) == 0:
        return 0.0
    with np.errstate(over="ignore"):
        extent = np.ptp(finite, axis=0).tolist()
    return math.hypot(*extent) / math.pow(len(finite), 1.0 / (cloud.dimension - 1))


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


def attribute_teller(path: str, say: Say) -> Say:
    """Return what says which attributes a replaced file has lost."""
    return lambda phrase: say(f"{WARNING} {path}: {phrase}")
