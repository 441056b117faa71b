"""Which files a command works on, and where the result of each goes."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pcsmooth.cli.options import STANDARD_STREAM
from pcsmooth.errors import CloudFileError

if TYPE_CHECKING:
    from pcsmooth.cli.batch_record import ResultRecord


@dataclass(frozen=True)
class Source:
    """A file to read.

    Attributes
    ----------
    path : str
        Where it is.
    folder : str
        The sub-folder that its result goes to, as deep as it lies below the folder that was named.
    """

    path: str
    folder: str = ""


@dataclass(frozen=True)
class Job:
    """One file to work on.

    Attributes
    ----------
    source : str
        Path of the input, or - for stdin.
    target : str or None
        Path of the output, or - for stdout; None for commands that write none.
    options : dict
        How it is worked on.
    in_force : dict
        What of that decides on the result, as JSON.
    known : ResultRecord or None
        What is known of the result of an earlier run.
    beside : tuple of str
        Files that are written with the result, without which it is not whole.
    """

    source: str
    target: str | None
    options: dict[str, Any] = field(default_factory=dict, repr=False)
    in_force: dict[str, Any] = field(default_factory=dict, repr=False)
    known: ResultRecord | None = field(default=None, repr=False)
    beside: tuple[str, ...] = field(default=(), repr=False)


def is_one_file(names: tuple[str, ...]) -> bool:
    """Whether a single name stands for a single file, so that this is no batch."""
    (first, *others) = names
    return not others and not Path(first).is_dir() and (Path(first).exists() or not _magic(first))


def find_sources(
    names: tuple[str, ...], *, recursive: bool = False, output: str | None = None
) -> list[Source]:
    """List the files that names stand for.

    Parameters
    ----------
    names : tuple of str
        Files; folders, for all files in them with a suffix of a known format; and patterns, such
        as ``'scans/**/*.ply'``, where ``**`` does not follow links. Folders and patterns leave out
        hidden files, named pipes and devices. A name that stands for nothing is kept, to fail
        when it is read.
    recursive : bool
        Whether files in sub-folders count too, but for those that are links or hidden, and results
        go to such sub-folders.
    output : str, optional
        Where results go; what lies there is no input.

    Returns
    -------
    list of Source
        In the order of the names, those of a folder or pattern sorted, each file once.

    Raises
    ------
    click.UsageError
        If - is one of several.
    CloudFileError
        If a folder cannot be read, or the only name is a folder without a cloud.
    """
    if STANDARD_STREAM in names:
        raise click.UsageError("- (stdin) is one cloud; give -o OUTPUT and no other input")
    found: list[Source] = []
    for name in names:
        path = Path(name)
        if path.is_dir():
            clouds = list(_clouds_below(path, output) if recursive else _clouds_in(path))
            if not clouds and len(names) == 1:
                remedy = "name another folder" + ("" if recursive else ", or give --recursive")
                raise CloudFileError(name, "the folder holds no file of a known format", remedy)
            found += clouds or [Source(name)]
        elif path.exists() or not _magic(name):
            found.append(Source(name))
        else:
            found += _matching(name, recursive) or [Source(name)]
    once: dict[Path, Source] = {}
    for source in found:
        once.setdefault(Path(source.path).absolute(), source)
    return list(once.values())


def plan_jobs(sources: list[Source], folder: str, suffix: str) -> list[Job]:
    """Choose where the result of each file goes.

    Parameters
    ----------
    sources : list of Source
        The files.
    folder : str
        Where results go, in the sub-folders of their sources, under the names of the files; those
        of a format that can only be read get the suffix of that in which such clouds are written,
        and those of COPC files, which become LAZ without an index, lose the ``.copc``.
    suffix : str
        What is put behind the stem of each name; if it ends in that of a format, such as
        ``_smooth.ply``, it takes the place of the file's own.

    Returns
    -------
    list of Job

    Raises
    ------
    click.UsageError
        If two results would get the same name, or be the same file, or one would take the place
        of an input.
    """
    from pcsmooth.formats import has_known_suffix, result_name
    from pcsmooth.formats.link_target import file_identity

    chooses_format = has_known_suffix(f"name{suffix}")
    inputs = {file_identity(source.path) for source in sources}
    jobs: dict[object, Job] = {}
    for source in sources:
        stem, own_suffix = result_name(Path(source.path).name)
        name = stem + suffix + ("" if chooses_format else own_suffix)
        target = str(Path(folder) / source.folder / name)
        identity = file_identity(target)
        if identity in jobs:
            raise click.UsageError(
                f"{jobs[identity].source} and {source.path} would both become {target}; run them "
                "apart, or name the folder above both and give --recursive"
            )
        if identity in inputs:
            raise click.UsageError(
                f"{source.path} would become {target}, which is one of the inputs; choose another "
                "--output-dir or --suffix"
            )
        jobs[identity] = Job(source.path, target)
    return list(jobs.values())


def _clouds_in(folder: Path, below: str = "") -> Iterator[Source]:
    """List the clouds that lie in a folder, whose results go to a sub-folder."""
    from pcsmooth.formats import has_known_suffix
    from pcsmooth.formats.system_errors import named_system_errors

    with named_system_errors(str(folder)):
        files = sorted(folder.iterdir())
    for file in files:
        if has_known_suffix(file.name) and file.is_file() and file.name[0] != ".":
            yield Source(str(file), below)


def _clouds_below(folder: Path, output: str | None) -> Iterator[Source]:
    """List the clouds that lie in a folder and below it, each folder after what lies in it."""
    from pcsmooth.formats.link_target import file_identity
    from pcsmooth.formats.system_errors import named_system_errors

    def refuse(error: OSError) -> None:
        with named_system_errors(str(error.filename)):
            raise error

    left_out = None if output is None else file_identity(output)
    for place, inner, _files in os.walk(folder, onerror=refuse):
        inner[:] = [
            name
            for name in sorted(inner)
            if name[0] != "." and file_identity(os.path.join(place, name)) != left_out
        ]
        yield from _clouds_in(Path(place), _below(Path(place), folder))


def _below(place: Path, folder: Path) -> str:
    """Spell a folder from another one on that it is in; nothing if it is this one."""
    return "" if place == folder else str(place.relative_to(folder))


def _matching(pattern: str, recursive: bool) -> list[Source]:
    path = Path(pattern)
    try:
        # The module glob would follow links, in circles too.
        found = list(Path(path.anchor).glob(str(path.relative_to(path.anchor))))
    except (ValueError, NotImplementedError) as error:
        raise click.UsageError(f"{pattern} is no pattern: {error}") from error
    shows_hidden = _hidden(path)
    files = sorted(file for file in found if file.is_file() and (shows_hidden or not _hidden(file)))
    above = next(part for part in (path, *path.parents) if not _magic(str(part)))
    return [Source(str(file), _below(file.parent, above) if recursive else "") for file in files]


def _hidden(path: Path) -> bool:
    return any(part.startswith(".") and part != ".." for part in path.parts)


def _magic(name: str) -> bool:
    return glob.has_magic(name)
