"""PLY files that are damaged, hostile or merely odd: a cloud that can be written, or an error."""

from __future__ import annotations

import io
import time
import tracemalloc
from dataclasses import replace

import numpy as np
import plyfile
import pytest

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats import read_cloud, write_cloud

HEAD = b"ply\nformat ascii 1.0\n"
XY = b"element vertex 1\nproperty float x\nproperty float y\n"


def read(data: bytes) -> PointCloud:
    return read_cloud(io.BytesIO(data), format="ply")


def written(cloud: PointCloud) -> bytes:
    buffer = io.BytesIO()
    write_cloud(cloud, buffer, format="ply")
    return buffer.getvalue()


@pytest.mark.parametrize("newline", [b"\r", b"\r\n"])
def test_line_feed_within_a_line_cannot_promise_rows(newline: bytes) -> None:
    """plyfile would take the second line of the comment for an element and allocate it."""
    hidden = b"comment a\nelement q 1000000000000\nproperty double v\n"
    data = (HEAD + hidden.rstrip(b"\n").replace(b"\n", b"\0")).replace(b"\n", newline)
    data = data.replace(b"\0", b"\n") + newline
    data += (XY + b"end_header\n1 2\n").replace(b"\n", newline)
    cloud = read(data)
    assert cloud.points.tolist() == [[1, 2]]
    assert cloud.comments == ("a element q 1000000000000 property double v",)


@pytest.mark.parametrize("count", ["1" + "0" * 30, "9" * 4299, "9" * 5000])
@pytest.mark.parametrize("encoding", [b"ascii", b"binary_big_endian"])
def test_counts_beyond_all_memory(count: str, encoding: bytes) -> None:
    data = HEAD.replace(b"ascii", encoding) + XY.replace(b" 1\n", f" {count}\n".encode())
    with pytest.raises(CloudFileError, match="header is damaged") as caught:
        read(data + b"end_header\n1 2\n")
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0, 1e30, 2.0])
@pytest.mark.parametrize("order", "<>")
def test_length_of_a_list_is_a_whole_number(value: float, order: str) -> None:
    encoding = {"<": b"binary_little_endian", ">": b"binary_big_endian"}[order]
    header = HEAD.replace(b"ascii", encoding) + XY + b"property list float uchar near\nend_header\n"
    row = np.array([1, 2, value], order + "f4").tobytes() + b"\0\0"
    with pytest.raises(CloudFileError, match="length of the lists 'near' is no whole number"):
        read(header + row)


@pytest.mark.parametrize("length", ["u4", "i4"])
@pytest.mark.parametrize("text", [True, False])
def test_long_lists_of_every_wide_length_type(length: str, text: bool) -> None:
    table = np.zeros(1, [("x", "f4"), ("y", "f4"), ("near", "O")])
    table["near"][0] = np.arange(300, dtype="i4")
    element = plyfile.PlyElement.describe(table, "vertex", len_types={"near": length})
    buffer = io.BytesIO()
    plyfile.PlyData([element], text=text, byte_order="=" if text else "<").write(buffer)
    again = written(read(buffer.getvalue()))
    vertex = plyfile.PlyData.read(io.BytesIO(again), mmap=False)["vertex"]
    assert vertex.ply_property("near").len_dtype == length
    assert vertex["near"][0].tolist() == list(range(300))


def test_short_lists_keep_their_length_type() -> None:
    data = HEAD + XY + b"property list char int near\nend_header\n1 2 1 7\n"
    cloud = read(data)
    assert b"property list char int near" in written(cloud)
    lists = np.empty(1, object)
    lists[0] = np.arange(200)
    assert b"property list uchar int near" in written(replace(cloud, columns={"near": lists}))


@pytest.mark.filterwarnings("error")
def test_signalling_nan_is_a_quiet_nan() -> None:
    header = HEAD.replace(b"ascii", b"binary_little_endian") + XY + b"end_header\n"
    cloud = read(header + b"\x01\x00\x80\x7f" + b"\0\0\0\0")
    assert np.isnan(cloud.points[0, 0])
    once = written(cloud)
    assert written(read(once)) == once


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("more", [b"", b"property list uchar int near\n"])
def test_number_beyond_float_is_infinite_with_and_without_lists(more: bytes) -> None:
    data = HEAD + XY + more + b"end_header\n-1e39 2" + (b" 0" if more else b"") + b"\n"
    assert read(data).points.tolist() == [[-np.inf, 2]]


@pytest.mark.parametrize("blank", [b"\xa0", b"\x85", b"\x1c"])
def test_row_of_foreign_blanks_is_no_row(blank: bytes) -> None:
    data = HEAD + XY.replace(b" 1\n", b" 3\n") + b"end_header\n1.5 2.5\n" + blank + b"\n3.5 4.5\n"
    with pytest.raises(CloudFileError, match="malformed PLY rows"):
        read(data)


def test_rows_of_other_elements_have_all_their_values() -> None:
    faces = b"element face 2\nproperty list uchar int near\nproperty int a\nproperty int b\n"
    data = HEAD + XY + faces + b"end_header\n1 2\n0 1 2\n1 2\n3 4 5 6\n"
    with pytest.raises(CloudFileError, match="face row 1 has fewer values than properties"):
        read(data)


def test_control_characters_of_the_header_are_spelled_out() -> None:
    data = HEAD + b"comment a\x0cb\x07\n" + XY + b"property int i\x00d\nend_header\n1 2 3\n"
    cloud = read(data)
    assert cloud.comments == (r"a\x0cb\x07",)
    assert list(cloud.columns) == [r"i\x00d"]
    assert read(written(cloud)).columns[r"i\x00d"].dtype == np.int32


def test_carriage_return_in_a_comment_ends_it() -> None:
    cloud = read(HEAD + b"comment a \rb\nobj_info c\rd\n" + XY + b"end_header\n1 2\n")
    assert cloud.comments == ("a", "b")
    once = written(cloud)
    assert b"obj_info c\nobj_info d\n" in once
    assert written(read(once)) == once


@pytest.mark.parametrize(
    "data",
    [
        HEAD.replace(b"ascii", b"a" * 9999) + XY + b"end_header\n",
        HEAD + XY.replace(b"vertex", b"v" * 9999) + b"end_header\n1 2\n",
        HEAD + XY + b"element " + b"f" * 9999 + b" 7\nproperty int i\nend_header\n1 2\n",
        HEAD + XY + b"element " + b"f" * 9999 + b" 1\nproperty int i\nend_header\n1 2\n      \n",
        HEAD + XY + b"end_header\n1 " + b"9" * 9999 + b"e\n",
        HEAD + XY + b"property int \x1b[2J\nend_header\n1 2 \x1b[2J\n",
    ],
    ids=["format", "element", "count", "rows", "number", "escape"],
)
def test_message_is_short_and_printable(data: bytes) -> None:
    with pytest.raises(CloudFileError) as caught:
        read(data)
    assert len(str(caught.value)) < 600
    assert str(caught.value).isprintable()


@pytest.mark.parametrize("encoding", [b"ascii", b"binary_little_endian"])
@pytest.mark.parametrize(
    "elements",
    [
        XY.replace(b" 1\n", b" 1000000000000\n"),
        XY + b"property list uint double near\n",
        XY + b"element face 4000000000\nproperty list uchar int near\n",
        XY + b"element none 1000000000000\n",
    ],
    ids=["vertices", "list", "faces", "nothing"],
)
def test_promises_cost_nothing(encoding: bytes, elements: bytes) -> None:
    data = HEAD.replace(b"ascii", encoding) + elements + b"end_header\n" + b"\xff" * 40
    started = time.process_time()
    tracemalloc.start()
    try:
        written(read(data))
    except CloudFileError:
        pass
    finally:
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
    assert peak < 2 << 20
    assert time.process_time() - started < 2
