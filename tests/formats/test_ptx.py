from __future__ import annotations

import io
import time
import tracemalloc
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from formats.chunked import Dim, check_reading, saved
from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats import open_chunks, read_cloud
from pcsmooth.formats.byte_source import ByteSource
from pcsmooth.formats.stations.scans import Scan, ScanChunks, ScanPoints

STILL = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
TURNED = "0 1 0 0\n-1 0 0 0\n0 0 1 0\n100 200 300 1\n"
"""A quarter turn that takes x to y, then a shift."""


def scan(
    rows: str, columns: int = 1, matrix: str = STILL, place: str = "1 2 3", n: int | None = None
) -> str:
    n = len(rows.splitlines()) // columns if n is None else n
    return f"{columns}\n{n}\n{place}\n1 0 0\n0 1 0\n0 0 1\n{matrix}{rows}"


def read(text: str, dim: int | None = None) -> PointCloud:
    return read_cloud(io.BytesIO(text.encode()), format="ptx", dim=dim or "auto")  # type: ignore[arg-type]


def test_points_are_moved_by_the_matrix_of_their_scan() -> None:
    cloud = read(scan("1 2 3 0.5\n4 5 6 0.25\n", 2) + scan("1 2 3 0.75\n", matrix=TURNED))
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6], [98, 201, 303]]
    assert cloud.columns["scan"].tolist() == [0, 0, 1]
    assert cloud.columns["scan"].dtype == np.uint16
    assert cloud.columns["intensity"].tolist() == [0.5, 0.25, 0.75]
    assert cloud.comments == (
        "scan 0: 2 columns of 1 points, scanner at 1 2 3",
        "scan 1: 1 columns of 1 points, scanner at 1 2 3",
    )


def test_what_was_not_measured_is_not_finite() -> None:
    cloud = read(scan("0 0 0 0.5 7 8 9\n0 0 1 0.5 1 2 3\n", matrix=TURNED))
    np.testing.assert_array_equal(cloud.points, [[np.nan] * 3, [100, 200, 301]])
    colors = [cloud.columns[name] for name in ("red", "green", "blue")]
    assert [column.tolist() for column in colors] == [[7, 1], [8, 2], [9, 3]]
    assert {column.dtype.name for column in colors} == {"uint8"}


def test_columns_that_a_scan_lacks() -> None:
    rows = ("1 2 3\n", "1 2 3 0.5\n", "1 2 3 7 8 9\n", "1 2 3 0.25 255.0 0 1\n")
    cloud = read("".join(map(scan, rows)))
    np.testing.assert_array_equal(cloud.columns["intensity"], [np.nan, 0.5, np.nan, 0.25])
    assert cloud.columns["red"].tolist() == [0, 0, 7, 255]
    assert cloud.columns["scan"].tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r", " \n\n"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_ends_of_lines(newline: str, mark: str) -> None:
    text = scan("1 2 3 0.5\n") + scan("4 5 6 0.5\n")
    cloud = read(mark + text.rstrip("\n").replace("\n", newline))
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]


def test_scan_without_points() -> None:
    cloud = read(scan("", 0, n=5) + scan("1 2 3\n"))
    assert cloud.columns["scan"].tolist() == [1]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "scan 0: its header has 0 lines of 10"),
        (scan("1 2 3\n") + "1\n1\n", "scan 1: its header has 2 lines of 10"),
        (scan("1 2 3\n", n=2), r"it promises 2 points \(1 columns of 2\), but 1 lines follow"),
        (scan("1 2 3\n", 10**9, n=10**9), "promises 1000000000000000000 points"),
        (scan("1 2 3\n", n=-1), "line 2 of its header is '-1', not a whole number"),
        (scan("1 2 3\n").replace("1\n", "1.0\n", 1), "line 1 of its header is '1.0', not a whole"),
        (scan("1 2 3\n", n=10**18), "line 2 of its header is '1000000000000000000', not"),
        (scan("1 2 3\n", place="1 2"), "line 3 of its header is '1 2', not 3 numbers"),
        (scan("1 2 3\n", place="1 2 a"), "line 3 of its header is '1 2 a', not 3 numbers"),
        (scan("1 2 3\n4 5 6\n", n=1), "scan 1: its header has 1 lines of 10"),
        (scan("1 2 3\n4 5 six\n"), "scan 0: row 1: z is 'six', not a number"),
        (scan("1 2 3\n4 5 6 7\n"), "row 1: 4 values, expected 3"),
        (scan("1 2 3 4 5\n"), "a point has 5 values, '1 2 3 4 5', not 3, 4, 6 or 7"),
        (scan("1 2 3 1 2 256\n"), "row 0: blue is '256', not a number of type uint8"),
        (scan("1 2 3\n", matrix=STILL.replace("0 0 1 0", "1 1 0 0")), "is singular"),
        (scan("1 2 3\n", matrix=STILL.replace("0 0 1 0", "0 0 0 0")), "is singular"),
        (scan("1 2 3\n", matrix=STILL.replace("0 0 0 1", "0 0 0 2")), "is no affine map"),
        (scan("1 2 3\n", matrix=STILL.replace("0 0 1 0", "0 0 1 1")), "is no affine map"),
        (scan("1 2 3\n", matrix=STILL.replace("0 0 0 1", "nan 0 0 1")), "is no affine map"),
        (scan("1 2 3\n", matrix=STILL.replace("0 0 0 1", "1e200 0 0 1")), "is no affine map"),
    ],
)
def test_damaged_file(text: str, message: str) -> None:
    with pytest.raises(CloudFileError, match=message) as caught:
        read(text)
    assert str(caught.value).startswith("<stdin>: scan ")
    assert len(str(caught.value)) < 400


def test_numbers_beyond_all_are_infinite() -> None:
    matrix = STILL.replace("1 0 0 0", "1e10 0 0 0", 1)
    assert read(scan("1e300 2 3\n", matrix=matrix)).points.tolist() == [[np.inf, 2, 3]]


@pytest.mark.slow
def test_promises_and_many_scans_cost_little() -> None:
    many = (scan("", 0, n=0) * 2000).encode()
    started = time.process_time()
    tracemalloc.start()
    try:
        cloud = read_cloud(io.BytesIO(many), format="ptx")
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert len(cloud) == 0
    assert len(cloud.comments) == 2000
    assert peak < 50 * len(many)
    assert time.process_time() - started < 5


@pytest.mark.parametrize("rows", [1, 7, 100])
def test_scans_in_pieces(tmp_path: Path, rows: int) -> None:
    """A turn by which every number is rounded, columns that some scans lack, scans of no point."""
    rng = np.random.default_rng(4)
    turned = "0.6 0.8 0 0\n-0.8 0.6 0 0\n0 0 1 0\n1e5 2e5 0.3 1\n"
    texts = [
        scan("".join(f"{x!r} {y!r} {z!r}{more}\n" for x, y, z in rng.normal(size=(20, 3)).tolist()),
             matrix=turned)
        for more in ("", " 0.5", " 7 8 9", " 0.5 7 8 9")
    ]  # fmt: skip
    path = saved(tmp_path, "".join([*texts, scan("", n=0)]).encode(), "ptx")
    dims: tuple[Dim, ...] = ("auto", 2)
    for dim in dims:
        check_reading(path, rows, dim)


def test_points_come_before_the_next_header(tmp_path: Path) -> None:
    path = saved(tmp_path, (scan("1 2 3\n1 2\n") + "7\n").encode(), "ptx")
    readers: tuple[Callable[[Path], object], ...] = (read_cloud, open_chunks)
    for read_it in readers:
        with pytest.raises(CloudFileError, match="scan 0: row 1: 2 values, expected 3"):
            read_it(path)


class ManyScans(ScanChunks):
    def _blocks(self, rows: int) -> Iterator[tuple[int, ScanPoints]]:
        yield len(self._scans) - 1, ScanPoints(np.zeros((1, 3)), {})


def test_more_scans_than_16_bits_count() -> None:
    none, one = Scan(0, {}), Scan(1, {})
    source = ByteSource(io.BytesIO(), "many")
    scans = [none] * 65_535 + [one]
    assert ManyScans(source, None, scans, ()).whole().columns["scan"].dtype == np.uint16
    many = ManyScans(source, None, [none, *scans], ()).whole()
    assert many.columns["scan"].tolist() == [65_536]
