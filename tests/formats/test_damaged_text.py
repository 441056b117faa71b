"""Text that is damaged, hostile or merely odd: a cloud that can be written, or an error."""

from __future__ import annotations

import contextlib
import io
import time
import tracemalloc
from typing import Any

import numpy as np
import pytest

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats import read_cloud, write_cloud


def read(text: str, format: str = "txt", **options: Any) -> PointCloud:
    return read_cloud(io.BytesIO(text.encode()), format=format, **options)


def written(cloud: PointCloud, format: str = "txt") -> str:
    buffer = io.BytesIO()
    write_cloud(cloud, buffer, format=format)
    return buffer.getvalue().decode()


@pytest.mark.parametrize("format", ["xyz", "pts", "csv", "txt"])
def test_comment_below_a_row_does_not_become_the_header(format: str) -> None:
    cloud = read("# scan\n1 2 3\n# y x z\n4 5 6\n", format)
    assert cloud.comments == ("scan", "y x z")
    again = read(written(cloud, format), format)
    np.testing.assert_array_equal(again.points, [[1, 2, 3], [4, 5, 6]])
    assert again.comments == cloud.comments


def test_names_are_all_different() -> None:
    cloud = read("x,y,z,column_6,a,,column_6,a\n1,2,3,4,5,6,7,8\n", "csv")
    assert [values.tolist() for values in cloud.columns.values()] == [[c] for c in "45678"]
    assert written(cloud, "csv") == "x,y,z,column_6,a,,column_6,a\n1.0,2.0,3.0,4,5,6,7,8\n"


@pytest.mark.parametrize("format", ["csv", "pts"])
def test_axis_without_a_label_gets_none(format: str) -> None:
    cloud = read(",y,i\n1,2,3\n", format, columns=[1, "y"])
    assert cloud.points.tolist() == [[1, 2]]
    once = written(cloud, format)
    assert once.startswith(",y,i\n")
    np.testing.assert_array_equal(read(once, format, columns=["1", "y"]).points, cloud.points)


def test_label_of_an_index_may_be_empty() -> None:
    cloud = read("\tx\ty\tz\n0\t1\t2\t3\n1\t4\t5\t6\n")
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert written(cloud) == "\tx\ty\tz\n0\t1.0\t2.0\t3.0\n1\t4.0\t5.0\t6.0\n"


@pytest.mark.parametrize("text", ["\ufeff\ufeffx y z\n1 2 3\n", "\n \ufeffx y z\n\ufeff1 2 3\n"])
def test_byte_order_marks_of_files_put_together(text: str) -> None:
    cloud = read(text)
    assert cloud.points.tolist() == [[1, 2, 3]]
    assert written(cloud) == "x y z\n1.0 2.0 3.0\n"


@pytest.mark.parametrize("format", ["csv", "xyz"])
def test_byte_order_marks_within_words_stay(format: str) -> None:
    delimiter = "," if format == "csv" else " "
    text = "x y z kind\n1.0 2.0 3.0 a\ufeffb\n4.0 5.0 6.0 \ufeff\n".replace(" ", delimiter)
    cloud = read(text, format)
    assert cloud.columns["kind"].tolist() == ["a\ufeffb", "\ufeff"]
    assert written(cloud, format) == text


def test_line_without_any_label_is_no_header() -> None:
    cloud = read(",\n# x y i\n3 4 9\n")
    assert cloud.points.tolist() == [[3, 4]]
    assert written(cloud) == "# x y i\n3.0 4.0 9\n"


@pytest.mark.parametrize(
    ("text", "n_titles"),
    [
        ("some title\nx y z\n1.0 2.0 3.0\n", 1),
        ("title\nx,y,z\n1.0,2.0,3.0\n", 1),
        ("some title\n\nby hand\n# by me\nx y z\n1.0 2.0 3.0\n", 2),
        ("some title\n# x y z\n1.0 2.0 3.0\n", 1),
        ("some title\n1.0 2.0 3.0\n", 1),
        ("title\n1.0,2.0,3.0\n", 1),
        ("some title\n1\n1.0 2.0 3.0\n", 1),
    ],
)
def test_titles_are_comments(text: str, n_titles: int) -> None:
    cloud = read(text, "xyz")
    assert cloud.points.tolist() == [[1, 2, 3]]
    assert not cloud.columns
    assert cloud.comments[0] == text.splitlines()[0]
    assert cloud.warnings[0] == "its line 1 names no columns and is taken for a comment"
    assert len(cloud.warnings) == n_titles
    assert written(cloud, "xyz") == text.replace("\n\n", "\n")
    for columns in ([1, 2, 3], ["x", "y", "z"][: 3 * ("x" in text)]):
        if columns:
            assert read(text, columns=columns).points.tolist() == [[1, 2, 3]]


@pytest.mark.parametrize("text", ["a,b,c\n1,2,3\n", "a,b,c,\n1,2,3\n", "a,b,c\n1,2,3,\n"])
def test_a_header_of_as_many_words_is_no_title(text: str) -> None:
    with pytest.raises(CloudFileError, match=r"names no coordinates \(a, b, c"):
        read(text, "csv")
    cloud = read(text, "csv", columns=["a", "b", "c"])
    assert cloud.points.tolist() == [[1, 2, 3]]
    assert cloud.comments == cloud.warnings == ()


def test_a_title_alone_is_no_point() -> None:
    assert len(read("some title\n")) == 0


@pytest.mark.parametrize("number", ["2019", "2019.5,7"])
def test_numbers_in_a_header(number: str) -> None:
    text = f"Easting,Northing,H,{number}\n" + "1.0,2.0,3.0" + ",4" * len(number.split(",")) + "\n"
    cloud = read(text, "csv")
    assert cloud.points.tolist() == [[1, 2, 3]]
    assert list(cloud.columns) == number.split(",")
    assert written(cloud, "csv") == text


def test_letters_of_hemispheres_are_no_header() -> None:
    text = "7.5 E 51.9 N 100\n7.6 E 51.8 N 101\n"
    assert read(text, columns=[1, 3, 5]).points.tolist() == [[7.5, 51.9, 100], [7.6, 51.8, 101]]


@pytest.mark.filterwarnings("error")
def test_huge_numbers_are_no_normals() -> None:
    assert list(read("1 2 3 1e308 0 1e308\n").columns) == ["column_4", "column_5", "column_6"]


@pytest.mark.parametrize(
    ("row", "kind", "note"),
    [
        ('1,2,5",a', '5"', "a"),
        ('1,2,"a,b",c', '"a,b"', "c"),
        ('1,2,"say ""x,y""",c', '"say ""x,y"""', "c"),
        ('1,2, "a,b" ,c', '"a,b"', "c"),
        ('"1","2",""a",b', '""a"', "b"),
        ('1,2,",b', '"', "b"),
    ],
)
def test_a_quote_in_one_field_is_no_matter_of_others(row: str, kind: str, note: str) -> None:
    cloud = read(f"x,y,kind,note\n{row}\n", "csv")
    assert [values.tolist() for values in cloud.columns.values()] == [[kind], [note]]
    again = read(written(cloud, "csv"), "csv")
    assert [values.tolist() for values in again.columns.values()] == [[kind], [note]]


@pytest.mark.parametrize("word", ['""so"""', '"', '"a""', '"a"b"', '""'])
def test_words_with_quotes_can_change_the_delimiter(word: str) -> None:
    cloud = read(f"1 2 3 {word} 5\n", "xyz")
    row = written(cloud, "csv").splitlines()[1]
    again = read(written(cloud, "csv"), "csv")
    assert list(again.columns) == ["column_4", "column_5"], row
    (kept,) = again.columns["column_4"].tolist()
    assert kept == word or kept[1:-1].replace('""', '"') == word


def test_labels_can_change_the_delimiter() -> None:
    cloud = read('"X" "Y" "Z" "I t"\n1 2 3 a b\n', "csv")
    assert written(cloud, "csv") == "X,Y,Z,I,t\n1.0,2.0,3.0,a,b\n"
    cloud = read('"// by hand\n1 2 3\n', "csv", columns=[1, 2, 3])
    assert len(read(written(cloud, "csv"), "csv", columns=[1, 2, 3])) == 1


def test_word_with_a_line_break_is_refused() -> None:
    cloud = PointCloud(np.zeros((1, 3)), {"note": np.array(["a\nb"])})
    with pytest.raises(CloudFileError, match=r"column 'note' holds 'a\\nb'.*remove the line break"):
        written(cloud, "csv")


@pytest.mark.parametrize("word", ["9" * 99999 + "e", "\x1b[2J" * 9])
def test_message_is_short_and_printable(word: str) -> None:
    with pytest.raises(CloudFileError, match=r"line 2: .* is not a number") as caught:
        read(f"1 2 3\n1 2 {word}\n")
    assert len(str(caught.value)) < 400
    assert str(caught.value).isprintable()


N = 100_000


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        '1,2,"a' + ",a" * N + "\n",
        '1,2,"a"' + ',"a' * N + "\n",
        '1,2,"a"' + ',""a' * N + "\n",
        '1,2,"a"' + '""' * N + "\n",
        "# x,y," + '"a,' * N + "\n1,2\n",
        "1 2 3" + " #" * N + "\n",
        "1 2\n" + "# c\n" * N,
        "7\n" + "#\n" * N + "7\n" * N,
        "#" + " " * N + "\n" + " " * N + "1 2\n",
    ],
    ids=["open", "opened", "pairs", "doubled", "header", "words", "notes", "counts", "blanks"],
)
def test_long_lines_take_no_more_time_than_many(text: str) -> None:
    started = time.process_time()
    with contextlib.suppress(CloudFileError):
        written(read(text, "csv"), "csv")
    assert time.process_time() - started < 5


def test_many_columns_take_no_more_time_than_many_rows() -> None:
    cells = ",".join(map(str, range(14_000)))
    cloud = read(f"x,y,{cells}\n1,2,{cells}\n", "csv")
    started = time.process_time()
    again = read(written(cloud, "csv"), "csv")
    assert list(again.columns) == list(cloud.columns)
    assert time.process_time() - started < 2


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 2 3 a\n" * 20_000 + "1 2 3 " + "b" * 100_000 + "\n", "words of up to 100000 char"),
        ("1;2;3" + ";" * 200_000 + "9\n", "200000 columns of words .* much for 1 rows"),
    ],
    ids=["word", "columns"],
)
def test_memory_is_that_of_the_file(text: str, message: str) -> None:
    tracemalloc.start()
    try:
        with pytest.raises(CloudFileError, match=message):
            read(text)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 64 * len(text) + (64 << 20)
