"""Any text file of points comes back, in its own dialect; numpy is the judge."""

from __future__ import annotations

import io
import string
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from pcsmooth.cloud import PointCloud
from pcsmooth.formats import read_cloud, write_cloud
from pcsmooth.formats.axis_names import named_axes

HEADERLESS = ("xyz", "pts")
LETTERS = string.ascii_letters + string.digits + "._:-+éß日"

SPELLINGS = (
    repr,
    "{:.17e}".format,
    "{:+.20g}".format,
    "{:.17E}".format,
    lambda number: f"  {number!r}",
    lambda number: f'"{number!r}"',
)
"""Ways to write a float64 that name it exactly."""

NUMBERS = st.floats(width=64) | st.sampled_from((0.0, -0.0, 5e-324, 1e308, 2**53 + 0.0, 1 / 3))
WORDS = st.text(LETTERS, min_size=1, max_size=6).filter(lambda word: word.lower() != "fixed")
NAMES = st.text(string.ascii_letters, min_size=2, max_size=6).filter(
    lambda name: name.lower() not in ("nx", "ny", "nz", "nan", "inf", "infinity", "fixed")
)


@dataclass(frozen=True)
class File:
    """A text file and what is in it."""

    text: str
    format: str
    points: tuple[tuple[float, ...], ...]
    columns: tuple[tuple[str, ...], ...]
    marks: tuple[bool, ...]
    comments: tuple[str, ...]
    header: str


@st.composite
def files(draw: st.DrawFn) -> File:
    dimension = draw(st.sampled_from((2, 3)))
    format = draw(st.sampled_from(("xyz", "txt", "asc", "csv", "pts")))
    delimiter = draw(st.sampled_from((" ", ",", ";", "\t")))
    if delimiter == " " and format == "csv":
        format = "txt"  # which may be written with spaces
    n_rows = draw(st.integers(1, 6))
    points = draw(st.lists(st.tuples(*[NUMBERS] * dimension), min_size=n_rows, max_size=n_rows))
    n_more = draw(st.integers(0, 3))
    rows = [draw(st.tuples(*[WORDS] * n_more)) for _ in points]
    marks = draw(st.lists(st.booleans(), min_size=n_rows, max_size=n_rows))
    if draw(st.booleans()):
        marks = [False] * n_rows
    spell = draw(st.sampled_from(SPELLINGS))
    if delimiter == " " and '"' in spell(1.0):
        spell = repr

    names = [*"xyz"[:dimension], *draw(st.lists(NAMES, min_size=n_more, max_size=n_more))]
    axes = named_axes(names).candidates
    assume(axes == tuple([axis] for axis in range(dimension)))  # no other word names one
    must_name = dimension == 2 and n_more > 0  # else the third column is z
    mark = draw(st.sampled_from(("", "#", "# ", "//") + (None,) * (not must_name)))
    header = "" if mark is None else mark + delimiter.join(names)
    comments = draw(st.lists(st.text(string.ascii_letters, min_size=3, max_size=9), max_size=2))
    lines = [f"# {comment}" for comment in comments]
    lines += [header] if header else []
    if draw(st.booleans()):
        lines.append(str(n_rows))
    for point, words, marked in zip(points, rows, marks, strict=True):
        lines.append(delimiter.join([*map(spell, point), *words, *["fixed"] * marked]))
        lines += [""] * draw(st.integers(0, 1))
    newline = draw(st.sampled_from(("\n", "\r\n", "\r")))
    text = draw(st.sampled_from(("", "\ufeff"))) + newline.join(lines)
    return File(
        text + newline * draw(st.integers(0, 2)),
        format,
        tuple(points),
        tuple(zip(*rows, strict=True)),
        tuple(marks),
        tuple(comments),
        header,
    )


def read(data: bytes, format: str) -> PointCloud:
    return read_cloud(io.BytesIO(data), format=format)


def written(cloud: PointCloud, format: str) -> bytes:
    buffer = io.BytesIO()
    write_cloud(cloud, buffer, format=format)
    return buffer.getvalue()


def assert_same_bits(one: np.ndarray[tuple[int, ...], np.dtype[np.float64]], other: object) -> None:
    expected = np.asarray(other, np.float64)
    np.testing.assert_array_equal(one, expected)
    numbers = ~np.isnan(expected)
    np.testing.assert_array_equal(np.signbit(one)[numbers], np.signbit(expected)[numbers])


@pytest.mark.slow
@settings(derandomize=True, deadline=None, max_examples=500, database=None)
@given(files())
def test_any_file_comes_back(file: File) -> None:
    cloud = read(file.text.encode(), file.format)
    assert_same_bits(cloud.points, file.points)
    assert [tuple(column.tolist()) for column in cloud.columns.values()] == list(file.columns)
    marks = (False,) * len(cloud) if cloud.fixed_marks is None else cloud.fixed_marks.tolist()
    assert tuple(marks) == file.marks
    assert cloud.comments == file.comments

    once = written(cloud, file.format)
    lines = once.decode().splitlines()
    assert (file.header in lines) == bool(file.header)
    rows = lines[-len(cloud) :]
    judged = np.loadtxt(
        [row.translate({ord(","): " ", ord(";"): " ", ord('"'): None}) for row in rows],
        usecols=range(cloud.dimension),
        comments=None,
        ndmin=2,
    )
    assert_same_bits(judged, file.points)
    again = read(once, file.format)
    assert_same_bits(again.points, file.points)
    assert written(again, file.format) == once


@pytest.mark.slow
@settings(derandomize=True, deadline=None, max_examples=200, database=None)
@given(
    st.lists(st.tuples(NUMBERS, NUMBERS, NUMBERS), max_size=5),
    st.sampled_from(("xyz", "txt", "asc", "csv", "pts")),
    st.sampled_from((np.float32, np.float64)),
)
def test_points_in_memory_come_back(
    rows: list[tuple[float, float, float]], format: str, dtype: type[np.floating]
) -> None:
    with np.errstate(over="ignore"):
        points = np.array(rows, dtype).astype(np.float64).reshape(-1, 3)
    cloud = PointCloud(points, position_type=np.dtype(dtype))
    again = read(written(cloud, format), format)
    assert_same_bits(again.points.astype(dtype).astype(np.float64), points)
