"""Text read and written piece by piece: what all rows decide is decided by all of them."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest

from formats.chunked import assert_same, check_reading, joined, saved
from pcsmooth.errors import CloudFileError
from pcsmooth.formats import (
    open_chunks,
    read_cloud,
    write_chunks,
    write_cloud,
    write_template,
)
from pcsmooth.formats.text.layout import TextLayout

N = 250


def rows(more: str = "", late: str = "", last: str = "", delimiter: str = " ") -> str:
    """Points with something behind them, which differs in row 200 and in the last one."""
    after = dict.fromkeys(range(N), more) | {200: late or more, N - 1: last or more}
    lines = (
        delimiter.join([f"{0.1 * row:.4g}", f"{row % 7}.5", f"-{row % 5}", *after[row].split()])
        for row in range(N)
    )
    return "".join(f"{line}\n" for line in lines)


TEXTS = {
    "plain": ("xyz", rows()),
    "whole numbers, then others": ("csv", "x,y,z,a\n" + rows("7", "0.5", delimiter=",")),
    "whole numbers, then long ones": ("txt", rows("7", "-3000000000")),
    "intensities, then longer ones": ("txt", "//X Y Z intensity\n" + rows("7", "70000")),
    "numbers, then missing ones": ("txt", "//X Y Z a\n" + rows("7", "#N/A")),
    "numbers, then words": ("csv", "x,y,z,a\n" + rows("7", "seven", delimiter=",")),
    "words of many lengths": ("txt", "//X Y Z a\n" + rows("b", "much-longer-than-before", "c")),
    "a word that is far too long": ("txt", "//X Y Z a\n" + rows("7", "w" * 20_000)),
    "fixed late": ("xyz", rows("1", "1 fixed", "1 FIXED")),
    "decimal commas late": ("csv", "x;y;z;a\n" + rows("7", "7,5", "0,5", delimiter=";")),
    "commas, then a point": ("csv", "x;y;z;a\n" + rows("7,5", "7", "0.5", delimiter=";")),
    "coordinates with commas": ("txt", rows("3,5").replace(".", ",")),
    "thousands": ("csv", "x,y,z,a\n" + rows('"1,000"', delimiter=",")),
    "thousands in coordinates": ("csv", "x,y,z,a\n" + rows("1", delimiter=",") + '"1,000",2,3,4\n'),
    "normals": ("xyz", rows("0 0 1", "0 0.6 0.8", "0 0 0")),
    "normals, but for one": ("xyz", rows("0 0 1", "0 1 1")),
    "zeros, then normals": ("xyz", rows("0 0 0", "0 0 1")),
    "blocks": ("pts", f"{N}\n" + rows() + "2\n1 2 3\n4 5 6\n0\n"),
    "too few points": ("pts", f"{N + 7}\n" + rows()),
    "comments": ("xyz", "# above\n" + rows() + "# below\n1 2 3\n% 1 2 3\n"),
    "odd spelling": ("xyz", rows() + "NaN 1 inf\n-1.#IND -Infinity 1e400\n"),
    "empty columns at the ends": ("csv", "".join(f"{r},2,3,,\n" for r in range(N))),
    "empty but for one": ("csv", "".join(f"{r},2,3,{r // 240 or ''},\n" for r in range(N))),
    "degrees": ("csv", "lon,lat,h\n" + rows(delimiter=",")),
    "perhaps a height": ("csv", "x,y,level\n" + rows(delimiter=",")),
    "running numbers": ("xyz", "".join(f"{r} 2.5 3 {r}.5\n" for r in range(N))),
    "running numbers, but for one": (
        "xyz", "".join(f"{r if r != 200 else 7} 2.5 3 {r}.5\n" for r in range(N))
    ),
    "times": ("xyz", "".join(f"{1.6e9 + r // 2} 2.5 3 {r}.5\n" for r in range(N))),
    "times, but for one": (
        "xyz", "".join(f"{1.6e9 + r - 90 * (r == 200)} 2.5 3 {r}.5\n" for r in range(N))
    ),
    "a row that is too short": ("xyz", rows("1", "1 2")),
    "a coordinate that is none": ("xyz", rows() + "\n\n# so\n1 2 x\n"),
    "other bytes": ("txt", "//X Y Z a\n" + rows("\udce4h", "\udcf6h")),
    "binary": ("txt", rows("\udce4h", "\x01")),
    "zero bytes": ("txt", rows("1", "\0")),
    "marks of the byte order": ("xyz", "\ufeff" + rows() + "\ufeff1 2 3\n"),
    "grid": ("asc", "# by hand\n\nncols 3\nnrows 2\n" + rows()),
    "nothing but comments": ("xyz", "# one\n# two\n"),
    "no end of the last line": ("xyz", rows() + "1 2 3"),
}  # fmt: skip


@pytest.fixture(autouse=True)
def _small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pcsmooth.formats.text.reader._ROWS_LOOKED_THROUGH", 100)
    monkeypatch.setattr("pcsmooth.formats.byte_source._SMALL_BLOCK", 64)
    monkeypatch.setattr("pcsmooth.formats.byte_source.BLOCK", 128)


def file_of(folder: Path, name: str, newline: str = "\n") -> Path:
    suffix, text = TEXTS[name]
    return saved(folder, text.replace("\n", newline).encode(errors="surrogateescape"), suffix)


def outcome(read: object) -> str:
    try:
        read()  # type: ignore[operator]
    except CloudFileError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("name", TEXTS)
def test_the_same_cloud_or_the_same_error(tmp_path: Path, name: str, newline: str) -> None:
    path = file_of(tmp_path, name, newline)

    def in_pieces() -> None:
        with open_chunks(path) as chunks:
            list(chunks.read(7))

    said = outcome(lambda: read_cloud(path))
    assert outcome(in_pieces) == said
    if said:
        return
    for at_a_time in (1, 7, N):
        check_reading(path, at_a_time)
    whole = read_cloud(path)
    with open_chunks(path) as chunks:
        mine, layout = chunks.template.layout, whole.layout
        assert isinstance(mine, TextLayout)
        assert isinstance(layout, TextLayout)
        assert (mine.names, mine.labels, mine.blocks) == (
            layout.names,
            layout.labels,
            layout.blocks,
        )
        assert mine.decimal_commas == layout.decimal_commas
        assert (mine.comments, mine.comments_below) == (layout.comments, layout.comments_below)
        for column, words in whole.columns.items():
            assert chunks.template.columns[column].dtype == words.dtype


@pytest.mark.parametrize("target", ["xyz", "csv", "pts", "ply", "pcd", "las"])
@pytest.mark.parametrize("name", TEXTS)
def test_the_same_file_or_the_same_error(tmp_path: Path, name: str, target: str) -> None:
    path, out = file_of(tmp_path, name), tmp_path / f"out.{target}"
    if target == "las":
        pytest.importorskip("laspy")
    if outcome(lambda: read_cloud(path)):
        return
    whole = read_cloud(path)
    stream = io.BytesIO()

    def in_pieces() -> None:
        with open_chunks(path) as chunks:
            template = write_template(out, chunks.template, chunks.read(7))
            write_chunks(out, template, chunks.count, chunks.read(7))

    said = outcome(lambda: write_cloud(whole, stream, format=target))
    assert outcome(in_pieces) == said.replace("<stdout>", str(out))
    if not said:
        assert out.read_bytes() == stream.getvalue()


def test_chosen_columns(tmp_path: Path) -> None:
    path = file_of(tmp_path, "whole numbers, then others")
    with open_chunks(path, columns=["a", 2, 3]) as chunks:
        cloud = joined(chunks.read(7), chunks.template)
    assert_same(cloud, read_cloud(path, columns=["a", 2, 3]))
    assert cloud.points[200].tolist() == [0.5, 4.5, -0.0]


def test_marks_of_chunks_without_fixed_points(tmp_path: Path) -> None:
    with open_chunks(file_of(tmp_path, "fixed late")) as chunks:
        first = next(chunks.read(7, columns=False))
        assert first.fixed_marks is not None
        assert not first.fixed_marks.any()
        marks = [part.fixed_marks for part in chunks.read(100)]
    found = np.concatenate([each for each in marks if each is not None])
    assert np.flatnonzero(found).tolist() == [200, N - 1]
