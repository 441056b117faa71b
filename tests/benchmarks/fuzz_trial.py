"""One damaged file: it must become a cloud that can be written and read again, or an error.

Time and memory are bounded, whatever the file says of itself.
"""

import contextlib
import io
import random
import re
import resource
import traceback
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from cpu_limit import OverTimeError, cpu_limit
from fuzz_mutations import damaged
from fuzz_seals import sealed, unsealed
from fuzz_seeds import SEEDS

from pcsmooth import CloudFileError, PointCloud, read_cloud, write_cloud
from pcsmooth.formats import WRITTEN_FORMATS, output_format

CPU_SECONDS = 2.0
"""Time to read, write and read again."""

MEMORY_PER_BYTE = 50
MEMORY_BESIDE = 64 << 20
"""Bytes of memory that a file may take for each of its own, and beside them."""

LONGEST_MESSAGE = 600

_BINARY = ("las", "laz", "e57")
_IN_PLACE = 0.6
"""Share of damaged files of these formats that are as long as before, so that they are read on."""

_SEALED = 0.8
"""Share of damaged E57 files whose checksums are right, so that they are looked into."""

_UNSEALED = tuple(map(unsealed, SEEDS["e57"]))

_PAGE = resource.getpagesize()

_GROUPS = [
    [name for name in SEEDS if SEEDS[name] is seeds]
    for seeds in {id(seeds): seeds for seeds in SEEDS.values()}.values()
]
"""Formats that share their seeds, and so the inputs."""

Dimension = Literal["auto", 2, 3]


@dataclass(frozen=True)
class Trial:
    """A damaged file and how it is to be read."""

    data: bytes
    format: str
    sniffed: bool
    dim: Dimension


@dataclass(frozen=True)
class Verdict:
    """What a file became.

    Attributes
    ----------
    kind : str
        "cloud", "error", or in what way and where it failed.
    failed : bool
        Whether it is neither of the first two.
    detail : str
        The traceback of a failure.
    """

    kind: str
    failed: bool = False
    detail: str = ""


class _ChangedError(Exception):
    """A cloud that did not come back as it was written."""


def trial(seed: int, index: int) -> Trial:
    """Damaged file number `index` of a run; the same for the same seed."""
    rng = random.Random(f"{seed}:{index}")
    format = rng.choice(rng.choice(_GROUPS))
    in_place = format in _BINARY and rng.random() < _IN_PLACE
    if format == "e57" and rng.random() < _SEALED:
        data = sealed(damaged(_UNSEALED, rng, in_place=in_place))
    else:
        data = damaged(SEEDS[format], rng, in_place=in_place)
    return Trial(data, format, rng.random() < 0.1, rng.choice(("auto", "auto", "auto", 2, 3)))


def judged(case: Trial) -> Verdict:
    """Read a file, write it and read it again, within bounds; every warning is a failure."""
    try:
        with _bounds(len(case.data)), warnings.catch_warnings():
            warnings.simplefilter("error")
            return Verdict(_tried(case))
    except OverTimeError as error:
        return _failure(f"more than {CPU_SECONDS:g} s", error)
    except MemoryError as error:
        return _failure("memory", error)
    except _ChangedError as error:
        return Verdict(f"changed: {error}", failed=True, detail=traceback.format_exc())
    except Exception as error:
        return _failure(type(error).__name__, error)


def _tried(case: Trial) -> str:
    try:
        cloud = read_cloud(
            io.BytesIO(case.data), dim=case.dim, format=None if case.sniffed else case.format
        )
    except CloudFileError as error:
        if not str(error).isprintable() or len(str(error)) > LONGEST_MESSAGE:
            raise _ChangedError("an error that is no line") from error
        return "error"
    once = _written(cloud, case)
    again = read_cloud(io.BytesIO(once), dim=case.dim, format=_format(cloud, case))
    _compare(cloud, again)
    if _written(again, case) != once:
        raise _ChangedError("bytes of the second file")
    return "cloud"


def _format(cloud: PointCloud, case: Trial) -> str:
    own = case.sniffed or case.format not in WRITTEN_FORMATS
    return output_format(None, cloud) if own else case.format


def _written(cloud: PointCloud, case: Trial) -> bytes:
    file = io.BytesIO()
    try:
        write_cloud(cloud, file, format=_format(cloud, case))
    except CloudFileError as error:
        raise _ChangedError(f"cannot be written ({error.cause})") from error
    return file.getvalue()


def _compare(before: PointCloud, after: PointCloud) -> None:
    if not _same(before.points, after.points):
        raise _ChangedError("points")
    if list(map(_plain, before.columns)) != list(map(_plain, after.columns)):
        raise _ChangedError("names of columns")
    for column, again in zip(before.columns.values(), after.columns.values(), strict=True):
        if column.dtype.kind != again.dtype.kind:
            raise _ChangedError("type of a column")
        if not _same(column, again):
            raise _ChangedError("a column")
    if before.comments != after.comments:
        raise _ChangedError("comments")
    if not _same(_marks(before), _marks(after)):
        raise _ChangedError("marks of fixed points")


def _plain(name: str) -> str:
    """A name without what a header of another delimiter cannot hold."""
    return re.sub(r'[\s",;#/%!]+', "_", name)


def _unquoted(word: str) -> str:
    """What a word means: words are quoted where their file gets another delimiter."""
    if re.fullmatch('"(?:[^"]|"")*"', word):
        return word[1:-1].replace('""', '"')
    return word


def _marks(cloud: PointCloud) -> npt.NDArray[np.bool_]:
    return np.zeros(len(cloud), np.bool_) if cloud.fixed_marks is None else cloud.fixed_marks


def _same(one: npt.NDArray[Any], other: npt.NDArray[Any]) -> bool:
    """Whether values are the same, -0.0 not being 0.0 and any NaN a NaN; bytes tell NaNs apart."""
    if one.shape != other.shape:
        return False
    if one.dtype.kind == "O":
        return all(_same(np.asarray(a), np.asarray(b)) for a, b in zip(one, other, strict=True))
    if one.dtype.kind == "U":
        return list(map(_unquoted, one.tolist())) == list(map(_unquoted, other.tolist()))
    if one.dtype.kind != "f":
        return bool((one == other).all())
    numbers = ~np.isnan(one)
    return np.array_equal(one, other, equal_nan=True) and bool(
        (np.signbit(one) == np.signbit(other))[numbers].all()
    )


@contextlib.contextmanager
def _bounds(size: int) -> Iterator[None]:
    with open("/proc/self/statm") as file:
        now = int(file.read().split()[0]) * _PAGE
    memory = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(
        resource.RLIMIT_AS, (now + MEMORY_PER_BYTE * size + MEMORY_BESIDE, memory[1])
    )
    try:
        with cpu_limit(CPU_SECONDS):
            yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, memory)


def _failure(kind: str, error: BaseException) -> Verdict:
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if "pcsmooth" in frame.filename]
    place = f"{Path(own[-1].filename).name}: {own[-1].name}" if own else "unknown place"
    return Verdict(f"{kind} in {place}", failed=True, detail=traceback.format_exc())
