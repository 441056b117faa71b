"""PLY read and written piece by piece: the same as all at once, in bounded memory."""

from __future__ import annotations

import io
import os
import tracemalloc
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formats.any_ply import File, files
from formats.chunked import Change, Dim, check, estimated, modified, saved, unchanged
from formats.ply_files import ENCODINGS, FACES, TRIANGLE, XYZ, as_bytes, ascii_ply, binary, rich_ply
from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.formats import CloudChunks, byte_source, open_chunks, read_cloud, write_chunks
from pcsmooth.formats.ply import cut as ply_cut
from pcsmooth.formats.ply import header as ply_header

LONG = "".join(f"{row}.5 {row / 3} {-row}e-3\n" for row in range(50))
DOUBLE = "double x, double y, double z"

VARIANTS = {
    **{f"rich {order}": as_bytes(rich_ply(text, order)) for text, order in ENCODINGS},
    "text": ascii_ply(XYZ, LONG),
    "text double": ascii_ply(DOUBLE, LONG),
    "text int": ascii_ply("int x, short y, uchar z", "1 2 3\n4 5 6\n"),
    "text mixed": ascii_ply("float x, double y, uchar z, int id", "1.1 2.1 3 4\n4.1 5.1 6 7\n"),
    "text 2D": ascii_ply("double x, double y, uchar red", "1 2 3\n4 5 6\n7 8 9\n"),
    "text z first": ascii_ply("float z, float X, float y", "1 2 3\n4 5 6\n7 8 9\n"),
    "text windows": ascii_ply(XYZ, "\n\n1 2 3 \n\n \n4 5 6", 2).replace(b"\n", b"\r\n"),
    "text old mac": ascii_ply(XYZ, LONG).replace(b"\n", b"\r"),
    "text more": ascii_ply(XYZ, LONG, 20),
    "text lists": ascii_ply(f"{XYZ}, list uchar int near", "1 2 3 0\n1 2 3 2 7 8\n1 2 3 1 9\n"),
    "text beyond float": ascii_ply(XYZ, LONG + "1e39 -1e39 nan\n"),
    "no points": ascii_ply(f"{XYZ}, uchar red", ""),
    "one point": ascii_ply(XYZ, "1 2 3\n"),
    "binary": binary(50, np.arange(150, dtype="<f4").tobytes()),
    "binary double": binary(50, np.arange(150, dtype="<f8").tobytes(), DOUBLE),
    "binary more": binary(20, np.arange(150, dtype="<f4").tobytes()),
    "binary none": binary(0, b""),
    "faces": binary(2, bytes(24) + 2 * TRIANGLE, tail=FACES),
    "lists": binary(
        30,
        b"".join(
            np.arange(3, dtype="<f4").tobytes() + bytes([row % 5]) + bytes(range(row % 5))
            for row in range(30)
        ),
        f"{XYZ}, list uchar uchar near",
    ),
}


@pytest.fixture
def _blocks(block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pieces of the file, perhaps so small that everything is cut by their ends."""
    for module in (byte_source, ply_cut):
        monkeypatch.setattr(module, "BLOCK", block)
    for module, name in ((byte_source, "_SMALL_BLOCK"), (ply_cut, "_SMALL_WINDOW")):
        monkeypatch.setattr(module, name, min(4, block))
    monkeypatch.setattr(ply_header, "_FIRST_LOOK", 11)


TINY, USUAL = 7, byte_source.BLOCK


# Every two of block, rows and dimension, together with every variant.
@pytest.mark.usefixtures("_blocks")
@pytest.mark.parametrize(
    ("block", "rows", "dim"),
    [
        (TINY, 1, "auto"),
        (TINY, 7, 2),
        (TINY, 1000, "auto"),
        (USUAL, 1, 2),
        (USUAL, 7, "auto"),
        (USUAL, 1000, 2),
    ],
)
@pytest.mark.parametrize("variant", VARIANTS)
def test_same_as_all_at_once(tmp_path: Path, variant: str, rows: int, dim: Dim) -> None:
    check(saved(tmp_path, VARIANTS[variant]), rows, dim)


@pytest.mark.slow
@settings(derandomize=True, deadline=None, max_examples=150, database=None)
@given(files(), st.integers(1, 4), st.sampled_from([modified, unchanged]))
def test_any_file(file: File, rows: int, change: Change) -> None:
    with TemporaryDirectory() as folder:
        check(saved(Path(folder), bytes(file)), rows, "auto", change)


@pytest.mark.parametrize("variant", ["rich =", "rich <", "rich >", "text double", "no points"])
def test_columns_of_estimates(tmp_path: Path, variant: str) -> None:
    check(saved(tmp_path, VARIANTS[variant]), 2, "auto", estimated)


@pytest.mark.parametrize("missing", [1, 5, 12])
@pytest.mark.parametrize("variant", ["binary", "text", "lists", "faces", "rich <", "rich ="])
def test_cut_short_is_refused_at_opening(tmp_path: Path, variant: str, missing: int) -> None:
    data = VARIANTS[variant].rstrip(b"\n") if variant == "text" else VARIANTS[variant]
    lines = data.decode("latin-1").splitlines(keepends=True)
    if data[4:].startswith(b"format ascii"):
        data = "".join(lines[:-missing]).encode("latin-1")
    else:
        data = data[:-missing]
    path = saved(tmp_path, data)
    with pytest.raises(CloudFileError) as expected:
        read_cloud(path)
    with pytest.raises(CloudFileError) as caught:
        open_chunks(path)
    assert str(caught.value) == str(expected.value)


@pytest.mark.parametrize("rows", [1, 7, 1000])
@pytest.mark.parametrize("last", ["1 two 3", "1 2", "1 2 3 4"])
@pytest.mark.parametrize("lists", [False, True])
def test_malformed_row_is_named(tmp_path: Path, lists: bool, last: str, rows: int) -> None:
    text, properties = LONG, XYZ
    if lists:
        text, properties = LONG.replace("\n", " 0\n"), f"{XYZ}, list uchar int near"
    path = saved(tmp_path, ascii_ply(properties, f"{text}{last}{' 0' * lists}\n"))
    with pytest.raises(CloudFileError, match="row 50: ") as expected:
        read_cloud(path)
    with open_chunks(path) as chunks, pytest.raises(CloudFileError) as caught:
        list(chunks.read(rows, columns=False))
    assert str(caught.value) == str(expected.value)


@pytest.mark.parametrize("rows", [1, 7])
def test_row_of_foreign_blanks_is_no_row(tmp_path: Path, rows: int) -> None:
    path = saved(tmp_path, ascii_ply(XYZ, LONG, 51) + b"\xa0\n")
    with open_chunks(path) as chunks, pytest.raises(CloudFileError, match="malformed PLY rows"):
        list(chunks.read(rows))


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.ply", b"", "the file is empty"),
        ("a.ply", b"solid cube\n", "not a PLY file"),
        ("a.ply", ascii_ply("float y, float z", "1 2\n"), "no number 'x'"),
        ("a.obj", b"v 1 2 3\n", "a mesh, which cannot be read piece by piece"),
    ],
)
def test_refused(tmp_path: Path, name: str, data: bytes, message: str) -> None:
    path = tmp_path / name
    path.write_bytes(data)
    with pytest.raises(CloudFileError, match=message) as caught:
        open_chunks(path)
    assert caught.value.path == str(path)


def test_content_comes_before_the_suffix(tmp_path: Path) -> None:
    path = tmp_path / "cloud.xyz"
    path.write_bytes(VARIANTS["text"])
    with open_chunks(path) as chunks:
        assert chunks.count == 50


def test_no_such_file_and_folder(tmp_path: Path) -> None:
    with pytest.raises(CloudFileError, match="no such file"):
        open_chunks(tmp_path / "none.ply")
    with pytest.raises(CloudFileError, match="a folder stands"):
        open_chunks(tmp_path)


def test_streams_are_refused() -> None:
    with pytest.raises(CloudFileError, match=r"<stdin>: a stream cannot .* save it to a file"):
        open_chunks(io.BytesIO(VARIANTS["text"]))
    reading, writing = os.pipe()
    with (
        open(reading, "rb"),
        open(writing, "wb"),
        pytest.raises(CloudFileError, match=f"/dev/fd/{reading}: a stream cannot"),
    ):
        open_chunks(f"/dev/fd/{reading}")


def test_unknown_dimension(tmp_path: Path) -> None:
    path: Any = saved(tmp_path, VARIANTS["text"])
    with pytest.raises(InvalidInputError, match="dim must be"):
        open_chunks(path, 4)  # type: ignore[arg-type]
    with pytest.raises(CloudFileError, match="no number 'z'"):
        open_chunks(saved(tmp_path, VARIANTS["text 2D"]), 3)


def test_lists_that_lose_their_end(tmp_path: Path) -> None:
    path = saved(tmp_path, VARIANTS["lists"])
    with open_chunks(path) as chunks:
        os.truncate(path, path.stat().st_size - 9)
        with pytest.raises(CloudFileError, match="has changed while it was read"):
            list(chunks.read(7))


def test_text_that_loses_lines(tmp_path: Path) -> None:
    path = saved(tmp_path, VARIANTS["text"])
    with open_chunks(path) as chunks:
        data = path.read_bytes()
        with open(path, "r+b") as file:
            file.write(data.replace(b"0.5 0.0 0e-3", b" " * 12))
        with pytest.raises(CloudFileError, match="has changed while it was read"):
            list(chunks.read(50))


def test_disk_that_fails(tmp_path: Path) -> None:
    class Failing(io.BytesIO):
        def read(self, size: int | None = -1, /) -> bytes:
            raise OSError(5, "Input/output error")

    with pytest.raises(CloudFileError, match=r"in\.ply: Input/output error"):
        byte_source.ByteSource(Failing(b"ply\n"), "in.ply").read(0, 4)


def test_header_without_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ply_header, "_LONGEST", 1 << 17)
    data = VARIANTS["text"].replace(b"1.0\n", b"1.0\ncomment " + b"a" * (1 << 17) + b"\n")
    with pytest.raises(CloudFileError, match="has no 'end_header' line"):
        open_chunks(saved(tmp_path, data))


@pytest.mark.parametrize("end", range(-12, 2))
def test_end_of_the_header_at_the_end_of_a_look(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, end: int
) -> None:
    data = ascii_ply(XYZ, LONG).replace(b"1.0\n", b"1.0\ncomment end_header_\n")
    data = data.replace(b"\n", b"\r\n")
    monkeypatch.setattr(ply_header, "_FIRST_LOOK", data.index(b"end_header\r\n") + 12 + end)
    with open_chunks(saved(tmp_path, data)) as chunks:
        assert chunks.count == 50
        assert chunks.template.comments == ("end_header_",)


class TestWritten:
    """What does not fit together leaves the folder as it was."""

    @pytest.fixture
    def chunks(self, tmp_path: Path) -> Iterator[CloudChunks]:
        with open_chunks(saved(tmp_path, VARIANTS["rich <"])) as chunks:
            yield chunks
        assert os.listdir(tmp_path) == ["in.ply"]
        assert (tmp_path / "in.ply").read_bytes() == VARIANTS["rich <"]

    def check(
        self,
        chunks: CloudChunks,
        message: str,
        change: Change,
        template: PointCloud,
    ) -> None:
        for path in (Path(chunks.name), Path(chunks.name).with_name("out.ply")):
            with pytest.raises(InvalidInputError, match=message):
                write_chunks(path, template, 5, map(change, chunks.read(2)))

    @pytest.mark.parametrize(
        "values", [np.array([1, 2**40]), np.array(["1", "2.5"])], ids=["long", "words"]
    )
    def test_type_that_depends_on_values(
        self, chunks: CloudChunks, values: npt.NDArray[Any]
    ) -> None:
        def with_new(cloud: PointCloud) -> PointCloud:
            return replace(cloud, columns={**cloud.columns, "new": values[: len(cloud)]})

        message = "property double new; the file in 3D has .*property int new"
        self.check(chunks, message, with_new, with_new(chunks.template))

    def test_lists_that_outgrow_their_length_type(self, chunks: CloudChunks) -> None:
        def with_lists(cloud: PointCloud) -> PointCloud:
            lists = np.empty(len(cloud), object)
            for row in range(len(cloud)):
                lists[row] = np.arange(256)
            return replace(cloud, columns={**cloud.columns, "new": lists})

        message = "list int int new; .*list uchar int new"
        self.check(chunks, message, with_lists, with_lists(chunks.template))

    def test_words(self, chunks: CloudChunks) -> None:
        template = replace(chunks.template, columns={"new": np.empty(0, np.complex128)})
        with pytest.raises(CloudFileError, match="type complex128, which PLY cannot hold"):
            write_chunks(chunks.name, template, 5, chunks.read(2))

    def test_folder_is_missing(self, chunks: CloudChunks) -> None:
        path = Path(chunks.name).with_name("none") / "out.ply"
        with pytest.raises(CloudFileError, match="no such file or folder"):
            write_chunks(path, chunks.template, 5, chunks.read(2))


@pytest.mark.parametrize("name", ["binary", "text", "lists"])
def test_memory(tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not even what comes after the points is ever in memory as a whole."""
    for module in (byte_source, ply_cut):
        monkeypatch.setattr(module, "BLOCK", 1 << 13)  # small beside small files
    edges = "element edge {}\nproperty int a\nproperty int b\n"
    if name == "binary":
        n, more, properties = 600_000, 400_000, XYZ
        body = np.random.default_rng(0).normal(size=3 * n).astype("<f4").tobytes()
        data = binary(n, body + bytes(8 * more), properties, edges.format(more))
    elif name == "lists":
        n, more, properties = 8_000, 100_000, f"{XYZ}, list uchar uchar near"
        body = (bytes(12) + b"\x50" + bytes(80)) * n
        data = binary(n, body + bytes(8 * more), properties, edges.format(more))
    else:
        n, more = 15_000, 75_000
        data = (
            ascii_ply(DOUBLE, "1.23456789012 2.34567890123 3.45678901234\n" * n).replace(
                b"end_header", edges.format(more).encode() + b"end_header"
            )
            + b"12345 67890\n" * more
        )
    path = saved(tmp_path, data)
    size = len(data)
    del data
    tracemalloc.start()
    try:
        with open_chunks(path) as chunks:
            write_chunks(path, chunks.template, n, chunks.read(n // 30))
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert path.stat().st_size == size
    assert peak < size / 4
