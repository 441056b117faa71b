"""Clouds opened to be worked on: read into memory, or to be cut into tiles."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import gettempdir
from typing import BinaryIO, Literal

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.files.cloud_input import CloudInput, TiledInput, WholeInput
from pcsmooth.files.notes import Say, say_coordinates, say_warnings
from pcsmooth.files.result_file import Target
from pcsmooth.files.tiling import Tiling
from pcsmooth.formats import (
    WRITTEN_IN_PIECES,
    CloudChunks,
    is_text,
    open_chunks,
    output_format,
    read_cloud,
)
from pcsmooth.tiling.runner import Runner

#: Least bytes that a point takes in a file: no smaller file can hold a cloud that is too large.
_LEAST_BYTES = 4


@dataclass(frozen=True)
class InputFile:
    """A file that is to be read, and how.

    Attributes
    ----------
    path : str
        The file; its name in messages if there is a stream.
    stream : binary file, optional
        What is read in its place.
    dim : {"auto", 2, 3}
        Number of coordinates.
    columns : tuple of str or None
        Columns of the coordinates in a text file, by names or numbers; None if the file says.
    ignores_marks : bool
        Whether points that the file calls noise take part.
    """

    path: str
    stream: BinaryIO | None = None
    dim: Literal["auto", 2, 3] = "auto"
    columns: tuple[str, ...] | None = None
    ignores_marks: bool = False

    def read(self, say: Say) -> PointCloud:
        """Read the cloud, and say what of it is no matter of course.

        Raises
        ------
        CloudFileError
            It cannot be read, or holds no points.
        """
        source = self.path if self.stream is None else self.stream
        cloud = read_cloud(source, dim=self.dim, columns=self.columns)
        self.check_and_say(cloud, len(cloud), say)
        return cloud.without_marks() if self.ignores_marks else cloud

    def check_and_say(self, cloud: PointCloud, count: int, say: Say) -> None:
        """Say what of a cloud, perhaps without its points, is no matter of course.

        Raises
        ------
        CloudFileError
            It has no points.
        """
        if count == 0:
            raise CloudFileError(self.path, "it holds no points", "give a file with points")
        if is_text(output_format(None, cloud)):
            say_coordinates(cloud, self.path, say)
        say_warnings(cloud, self.path, say)


@contextmanager
def open_input(
    source: InputFile,
    target: Target | None = None,
    *,
    tiling: Tiling,
    whole_cloud_for: str = "",
    runner: Runner | None = None,
    threads: int | None = None,
    checks_active: bool = True,
    say: Say,
) -> Iterator[CloudInput]:
    """Open a cloud: in memory, or in tiles if that is asked for or it does not fit.

    Parameters
    ----------
    source : InputFile
        What to read.
    target : Target or None
        Where the result will go, if it is written.
    tiling : Tiling
        How clouds are cut up.
    whole_cloud_for : str
        What of what will be done needs the whole cloud; nothing if parts will do.
    runner : Runner, optional
        Works on tiles, in place of those of the tiling.
    threads : int, optional
        Threads of all workers together.
    checks_active : bool
        Whether it is an error that no point takes part.
    say : callable
        Takes each message.

    Yields
    ------
    CloudInput

    Raises
    ------
    CloudFileError
        It cannot be read or holds no point that takes part; or tiles are asked for and cannot be.
    """
    with ExitStack() as opened:
        found = _opened(source, target, tiling, whole_cloud_for)
        if found is None:
            cloud = source.read(say)
            if checks_active:
                _check_active([cloud], source.path)
            yield WholeInput(source.path, cloud)
            return
        chunks, tile_points = opened.enter_context(found[0]), found[1]
        if tiling.size not in ("auto", tile_points):
            say(f"--tile {tiling.size}: tiles of {tile_points} points, lest they are too many")
        source.check_and_say(chunks.template, chunks.count, say)
        parent = gettempdir() if target is None else str(Path(target.path).resolve().parent)
        folder = opened.enter_context(tiling.work_folder(parent, say))
        if runner is None:
            runner = opened.enter_context(tiling.runner(folder, tile_points, threads, say))
        tiled = TiledInput(source.path, chunks, folder, tile_points, runner, source.ignores_marks)
        if checks_active:
            _check_active(tiled.read(columns=False), source.path)
        yield tiled


def _check_active(parts: Iterable[PointCloud], name: str) -> None:
    """Raise `CloudFileError` if the file calls all its points noise; reads no more than it must."""
    if all(part.noise_marks is not None and part.noise_marks.all() for part in parts):
        raise CloudFileError(
            name, "all its points are of a noise class or withheld", "pass --keep-noise-class"
        )


def _opened(
    source: InputFile, target: Target | None, tiling: Tiling, whole_cloud_for: str
) -> tuple[CloudChunks, int] | None:
    """Open a cloud that is cut into tiles, of so many points; None if it is worked on as a whole.

    Raises
    ------
    CloudFileError
        If tiles are asked for and cannot be.
    """
    if tiling.size == "off":
        return None
    obstacle = _obstacle(source, target, whole_cloud_for)
    if obstacle is not None:
        if not tiling.is_asked_for:
            return None
        cause, remedy = obstacle
        raise CloudFileError(source.path, cause, remedy)
    if not tiling.is_asked_for:
        most = os.path.getsize(source.path) // _LEAST_BYTES if os.path.isfile(source.path) else 0
        if tiling.points_of_tile(most) is None:
            return None
    try:
        chunks = open_chunks(source.path, source.dim, source.columns)
    except CloudFileError:
        if tiling.is_asked_for:
            raise
        return None  # whatever is wrong with it, the reader of whole clouds says
    with ExitStack() as opened:
        opened.enter_context(chunks)
        tile_points = tiling.points_of_tile(chunks.count)
        if tile_points is None:
            return None
        opened.pop_all()
    return chunks, tile_points


def _obstacle(
    source: InputFile, target: Target | None, whole_cloud_for: str
) -> tuple[str, str] | None:
    """Say what stands against tiles, and what helps."""
    if source.stream is not None or (target is not None and target.stream is not None):
        return "a stream cannot be cut into tiles", "name files"
    if target is not None and output_format(target.path) not in WRITTEN_IN_PIECES:
        return (
            f"tiles cannot be put together to {output_format(target.path)}",
            f"write {', '.join(WRITTEN_IN_PIECES[:-1])} or {WRITTEN_IN_PIECES[-1]}",
        )
    if whole_cloud_for:
        return f"{whole_cloud_for} needs the whole cloud", "leave it out, or pass --tile off"
    return None
