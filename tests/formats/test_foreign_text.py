"""Text as other programs and other languages write it."""

from __future__ import annotations

import io
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats import read_cloud, write_cloud
from pcsmooth.formats.number_text import is_missing, is_number, parsed


def read(text: str | bytes, format: str = "csv", **options: Any) -> PointCloud:
    data = text.encode() if isinstance(text, str) else text
    return read_cloud(io.BytesIO(data), format=format, **options)


def written(cloud: PointCloud, format: str = "csv") -> bytes:
    buffer = io.BytesIO()
    write_cloud(cloud, buffer, format=format)
    return buffer.getvalue()


NAN = [
    "nan", "NaN", "-nan", "nan(ind)", "-nan(ind)", "nan(snan)", "NaN(0x8000)", "1.#QNAN",
    "-1.#QNAN", "1.#SNAN", "-1.#IND", "1.#IND000", "1.#R", "-1.#J", "NULL", "null", "NA", "N/A",
    "n/a", "#N/A", "<NA>", "None", "nil", "#NUM!", "#DIV/0!", "#VALUE!", r"\N", ".", "-", "--",
    "?", "*******",
]  # fmt: skip
INFINITE = {"inf": 1, "-Infinity": -1, "1.#INF": 1, "-1.#INF": -1, "1.#INF00": 1, "1e999": 1}


@pytest.mark.parametrize("word", [*NAN, "", *INFINITE])
@pytest.mark.parametrize("place", [0, 1, 2])
@pytest.mark.parametrize("header", ["x,y,z,i\n", ""])
def test_what_is_not_finite_passes_through_as_it_is_spelled(
    word: str, place: int, header: str
) -> None:
    cells = ["01.50", "2.0", "-3e0"]
    cells[place] = word
    row = ",".join([*cells, "7"])
    for rows in ([row, "1.0,2.0,3.0,8"], ["1.0,2.0,3.0,8", row]):
        text = header + "\n".join(rows) + "\n"
        cloud = read(text)
        odd = rows.index(row)
        expected = INFINITE[word] * np.inf if word in INFINITE else np.nan
        np.testing.assert_equal(cloud.points[odd, place], expected)
        assert np.isfinite(np.delete(cloud.points[odd], place)).all()
        assert np.isfinite(cloud.points[1 - odd]).all()
        assert next(iter(cloud.columns.values())).tolist()[odd] == "7"
        again = written(cloud).decode().splitlines()[-2:]
        assert again == rows


def test_rows_in_the_default_spelling_are_not_kept() -> None:
    layout: Any = read("nan nan nan\n1 2 3\nnan nan 3\n", "xyz").layout
    assert layout.odd_rows == {2: ("nan", "nan", "3")}


def test_a_row_that_has_changed_is_not_spelled_as_before() -> None:
    cloud = read("1,NULL,3\n4,5,6\n7,n/a,9\n", "xyz")
    kept = replace(cloud, points=cloud.points[1:])
    assert written(kept, "xyz") == b"4.0,5.0,6.0\n7.0,nan,9.0\n"
    finite = replace(cloud, points=np.ones((3, 3)))
    assert written(finite, "xyz") == b"1.0,1.0,1.0\n" * 3


def test_missing_words_are_nan_in_other_formats() -> None:
    cloud = read("x,y,z,i\n1,2,,NULL\n4,5,6,2\n")
    assert written(cloud, "xyz") == b"1.0 2.0 nan NULL\n4.0 5.0 6.0 2\n"
    ply = read_cloud(io.BytesIO(written(cloud, "ply")))
    np.testing.assert_array_equal(ply.columns["i"], [np.nan, 2])
    np.testing.assert_array_equal(ply.points[0], [1, 2, np.nan])


def test_a_cell_of_a_spreadsheet_is_no_comment() -> None:
    cloud = read("x,y,z\n#N/A,2,3\n#NUM!,#NUM!,#NUM!\n# note\n")
    assert len(cloud) == 2
    assert cloud.comments == ("note",)


@pytest.mark.parametrize(
    "word",
    ["#NV", "#NAME?", "#NULL!", "#WERT!", "#ZAHL!", "#BEZUG!", "#NOMBRE!", "#NOM?", "#VALEUR!",
     "#¡VALOR!", "#¿NOMBRE?", "#N/D", "#RIF!", "#DIV/0!"],
)  # fmt: skip
def test_errors_of_spreadsheets_are_rows_in_their_place(word: str) -> None:
    text = f"x,y,z\n1.0,2.0,3.0\n{word},1.0,2.0\n2.0,3.0,4.0\n{word},{word},{word}\n3.0,4.0,5.0\n"
    cloud = read(text)
    assert np.isnan(cloud.points[:, 0]).tolist() == [False, True, False, True, False]
    assert cloud.comments == cloud.warnings == ()
    assert written(cloud).decode() == text
    assert len(read(text.replace("x,y,z\n1.0,2.0,3.0\n", ""))) == 4


def test_missing_words_make_no_header() -> None:
    assert np.isnan(read("NULL,NULL,NULL\n1,2,3\n").points[0]).all()
    assert read("Easting,Northing,NA\n1,2,3\n").points.tolist() == [[1, 2]]


@pytest.mark.parametrize("word", ["abc", "1.0.0", "0x1p3", "1_0", "nan(", "1.#", "1d", "d5", "#"])
def test_other_words_are_shown(word: str) -> None:
    with pytest.raises(CloudFileError, match=r"line 2: '.*' is not a number") as caught:
        read(f"1,2,3\n1,{word},3\n")
    assert f"'{word}'" in str(caught.value)


@pytest.mark.parametrize(
    ("word", "value"), [("1.5D+01", 15.0), ("-1d-2", -0.01), (".5D0", 0.5), ('"2.D1"', 20.0)]
)
def test_numbers_of_fortran(word: str, value: float) -> None:
    assert parsed([word]).tolist() == [value]
    assert is_number(word)
    assert not is_missing(word)
    assert read(f"{word} 2 3\n{word} 5 6\n", "txt").points[:, 0].tolist() == [value] * 2


def test_words_for_missing_numbers_are_no_numbers() -> None:
    assert [word for word in NAN if is_number(word) == is_missing(word)] == []
    assert {word for word in NAN if is_missing(word)} == {*NAN[NAN.index("NULL") :]}


@pytest.mark.parametrize(
    "text",
    [
        "x,y,z\n1,2,3,\n4,5,6,\n",
        "x,y,z,\n1,2,3,\n4,5,6,\n",
        "x,y,z,\n1,2,3\n4,5,6\n",
        "x,y,z\n1,2,3,\n4,5,6\n",
        "x,y,z\n1,2,3\n4,5,6,\n",
        "1,2,3,\n4,5,6,\n",
        "1;2;3;\n4;5;6; \n",
        "1\t2\t3\t\n4\t5\t6\t\n",
        "//X,Y,Z\n1,2,3,\n4,5,6,\n",
        "x,y,z,,\n1,2,3,,\n4,5,6,,\n",
        "1;2;3;;\n4;5;6;\n",
    ],
)
def test_trailing_delimiters(text: str) -> None:
    cloud = read(text, "xyz")
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert not cloud.columns
    again = read(written(cloud, "xyz"), "xyz")
    np.testing.assert_array_equal(again.points, cloud.points)
    assert not again.columns


def test_a_last_column_with_a_value_is_one() -> None:
    assert read("1,2,3,\n4,5,6,a\n").columns["column_4"].tolist() == ["", "a"]
    assert read("x,y,z,i\n1,2,3,\n4,5,6,\n").columns["i"].tolist() == ["", ""]
    marks = read("x,y,z\n1,2,3,fixed,\n4,5,6,\n").fixed_marks
    assert marks is not None
    assert marks.tolist() == [True, False]


@pytest.mark.parametrize(
    "text",
    [
        "X;Y;Z\n0,5;-1,25;2,0\n3,0;4,5;1e-07\n",
        "0,5\t-1,25\t2,0\n3,0\t4,5\t1e-07\n",
        "0,5 -1,25 2,0\n3,0 4,5 1e-07\n",
        "0,5, -1,25, 2,0\n3,0, 4,5, 1e-07\n",
        "X, Y, Z\n0,5, -1,25, 2,0\n3,0, 4,5, 1e-07\n",
        '0,5, -1,25, 2,0, 0,25\n3,0, 4,5, 1e-07, "a, b"\n',
        "X;Y;Z;s;note\n0,5;-1,25;2,0;1,50;a,b\n3,0;4,5;1e-07;7;c.d\n",
        "id;X;Y;Z\nP1;0,5;-1,25;2,0\nP2;3,0;4,5;1e-07\n",
        '"0,5","-1,25","2,0"\n"3,0","4,5",1e-07\n',
        'X,Y,Z,s,note\n"0,5","-1,25","2,0","1,50","a,b"\n"3,0","4,5",1e-07,7,c.d\n',
        "0,5;-1,25;2,0\n3,0;4,5;1e-07\n5,0;nan(ind);1,0\n;;\n",
    ],
)
def test_decimal_commas_come_back(text: str) -> None:
    cloud = read(text, "xyz")
    assert cloud.points[:2].tolist() == [[0.5, -1.25, 2], [3, 4.5, 1e-7]]
    assert written(cloud, "xyz").decode() == text
    numbers = {name: np.array([0.25] * len(cloud)) for name in ("nx", "ny", "nz")}
    more = written(replace(cloud, columns=cloud.columns | numbers), "xyz").decode()
    last = more.splitlines()[-1].translate(str.maketrans("\t;", "  ")).replace('","', '" "')
    assert last.replace('"', "").replace(", ", " ").endswith("0,25 0,25 0,25")
    np.testing.assert_array_equal(read(more, "xyz").points, cloud.points)


def test_columns_with_decimal_commas_are_numbers() -> None:
    cloud = read("X;Y;Z;s;t\n0,5;1;2;1,50;a\n3;4;5;7;1,5\n")
    assert cloud.columns["s"].tolist() == ["1.50", "7"]
    assert cloud.columns["t"].tolist() == ["a", "1,5"]
    assert written(cloud, "xyz") == b"0.5 1.0 2.0 1.50 a\n3.0 4.0 5.0 7 1,5\n"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("X;Y;Z;s;n\n1;2;3;0,5;a.b\n4;5;6;7;c\n",
         "X;Y;Z;s;n\n1,0;2,0;3,0;0,5;a.b\n4,0;5,0;6,0;7;c\n"),
        ('X,Y,Z,s\n1,2,3,"0,5"\n', 'X,Y,Z,s\n"1,0","2,0","3,0","0,5"\n'),
        ("X;Y;Z;s\n1;2;3.5;0,5\n", "X;Y;Z;s\n1.0;2.0;3.5;0,5\n"),
        ("X;Y;Z;s\n1;2;3;a,b\n4;5;6;0,5\n", "X;Y;Z;s\n1.0;2.0;3.0;a,b\n4.0;5.0;6.0;0,5\n"),
    ],
)  # fmt: skip
def test_whole_coordinates_beside_decimal_commas(text: str, expected: str) -> None:
    cloud = read(text)
    assert written(cloud).decode() == expected
    np.testing.assert_array_equal(read(expected).points, cloud.points)


@pytest.mark.parametrize(
    "rows", ['"1,234","2,345",7\n8,"-9,876",10\n', '"1,234,567.5",2,3\n', '5,6,7\n1,2,"3,000."\n']
)
@pytest.mark.parametrize("header", ["", "x,y,z\n"])
def test_commas_between_thousands_are_refused(rows: str, header: str) -> None:
    with pytest.raises(CloudFileError, match=r'such as "[^ ]*" may part thousands; write numbers'):
        read(header + rows)


def test_other_commas_part_no_thousands() -> None:
    assert read('"1,234","0,345",7\n').points.tolist() == [[1.234, 0.345, 7]]
    assert read('"1,234","2,345",7\n8,"9,87",7\n').points[0].tolist() == [1.234, 2.345, 7]
    assert read("1,234;2,345;3,456\n").points.tolist() == [[1.234, 2.345, 3.456]]
    text = 'x,y,z,s\n1.0,2.0,3.0,"1,234"\n'
    for rows in (text, text.replace(".0", "")):
        assert read(rows).columns["s"].tolist() == ['"1,234"']
        assert written(read(rows)).decode() == text


@pytest.mark.parametrize(
    ("text", "points"),
    [
        ("sep=;\nX;Y;Z\n1.0;2.0;3.0\n", [1, 2, 3]),
        ("SEP=,\n1.0,5.0,2.0\n", [1, 5, 2]),
        ("sep=;\nX;Y;Z\n1,5;2,0;3,0\n", [1.5, 2, 3]),
        ("sep=\t\nX\tY\tZ\tnote\n1.0\t2.0\t3.0\ta; b\n", [1, 2, 3]),
        ("sep=;\nX;Y;Z;a,b\n1.0;2.0;3.0;4,5,6\n", [1, 2, 3]),
    ],
)
def test_a_delimiter_may_be_stated(text: str, points: list[float]) -> None:
    cloud = read(text, "xyz")
    assert cloud.points.tolist() == [points]
    assert cloud.warnings == ()
    assert written(cloud, "xyz").decode() == text


def test_a_stated_delimiter_counts() -> None:
    assert read("sep=;\n1,5;2,5\n3,5;4,5\n").points.tolist() == [[1.5, 2.5], [3.5, 4.5]]
    with pytest.raises(CloudFileError, match="its rows have 1 column"):
        read("sep=;\n1,2,3\n")


def test_decimal_commas_between_commas_and_blanks() -> None:
    cloud = read("1,5e-07, 2e-07, 3,5, 0,5\n4,5, 5,5, 6,5, a,b\n", "txt")
    assert cloud.points.tolist() == [[1.5e-7, 2e-7, 3.5], [4.5, 5.5, 6.5]]
    assert written(cloud, "txt").endswith(b"1,5e-07, 2e-07, 3,5, 0,5\n4,5, 5,5, 6,5, a,b\n")
    assert written(cloud, "csv").splitlines()[-1] == b'4.5,5.5,6.5,"a,b"'


def test_decimal_commas_may_come_late(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pcsmooth.formats.text.values.ROWS_AT_A_TIME", 2)
    for rest in ("", " a"):
        cloud = read(f"1 2 3{rest}\n" * 5 + f"1,5 2,5 3,5{rest}\n", "xyz")
        assert cloud.points.tolist() == [[1, 2, 3]] * 5 + [[1.5, 2.5, 3.5]]


def test_commas_that_part_columns_are_no_decimals() -> None:
    assert read("1,5,2,5,3,5\n").points.tolist() == [[1, 5, 2]]
    assert read("1,5, 2.5,3,5\n").points.tolist() == [[1, 5, 2.5]]
    assert read("1,5, 2, 3,5\n").points.tolist() == [[1, 5, 2]]
    assert read("x,y,z,a,b,c\n1,5, 2,7, 3,5\n").points.tolist() == [[1, 5, 2]]


@pytest.mark.parametrize("mark", ["%", "%%", "!", ";", "#", "//"])
def test_comments(mark: str) -> None:
    text = f"{mark} by hand\n1.0 2.0 3.0\n{mark}second\n"
    cloud = read(text, "xyz")
    assert cloud.comments == ("by hand", "second")
    assert written(cloud, "xyz").decode() == text
    header = f"{mark}x y z i\n1.0 2.0 3.0 4\n"
    assert list(read(header, "xyz").columns) == ["i"]
    assert written(read(header, "xyz"), "xyz").decode() == header


OF_COMMENTS = "lines taken for comments that may have been meant as rows: {}"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("id,x,y,z\n%1,1.0,2.0,3.0\n!2,4.0,5.0,6.0\na,7.0,8.0,9.0\n", ["%1", "!2", "a"]),
        ("id,x,y,z\n%1,1.0,2.0,3.0\n!2,4.0,5.0,6.0\n;3,7.0,8.0,9.0\n", ["%1", "!2", ";3"]),
        ("id,x,y,z\n1,1.0,2.0,3.0\n!,4.0,5.0,6.0\n% 3,7.0,8.0,9.0\n", ["1", "!", "% 3"]),
        ("id,x,y,z\n#7,1.0,2.0,3.0\n//8,4.0,5.0,6.0\n#,7.0,8.0,9.0\n", ["#7", "//8", "#"]),
        ("id x y z\na 1.0 2.0 3.0\n#P7 4.0 5.0 6.0\n//b 7.0 8.0 9.0\n", ["a", "#P7", "//b"]),
        ("// id x y z\n%1 1.0 2.0 3.0\nb 4.0 5.0 6.0\n;3 7.0 8.0 9.0\n", ["%1", "b", ";3"]),
    ],
)
def test_words_may_begin_as_comments_do(text: str, words: list[str]) -> None:
    cloud = read(text, "txt")
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
    assert cloud.columns["id"].tolist() == words
    assert cloud.comments == cloud.warnings == ()
    assert written(cloud, "txt").decode() == text


@pytest.mark.parametrize("text", ["1,2,3\n{}4,5,6\n", "x y z i\n\n{}4 5 6 7\n1 2 3 4\n"])
@pytest.mark.parametrize("mark", ["%", "!", ";"])
def test_a_row_is_not_taken_for_a_comment(text: str, mark: str) -> None:
    with pytest.raises(CloudFileError, match=rf"'{mark}4' is not a number; correct or remove"):
        read(text.format(mark), "txt")


@pytest.mark.parametrize(
    ("text", "n"),
    [
        ("1 2 3\n% 4 5\n", 1),
        ("1 2 3\n%a word more\n!\n4 5 6\n", 2),
        ("1 2 3\n%4 5 6 7\n", 1),
        ("%1 1 2 3\n2 1 2 3\n3 1 2 4\n", 1),
        ("1 2 3\n# 4 5\n#\n//note\n", 0),
        ("1 2 3\n#4 5 6\n//4 5 6\n# 4 5 6\n7 8 9\n", 3),
        ("id x y z\na 1 2 3\n#7 1 2 3\n# b 4 5\nb 1 2 4\n", 1),
        ("id,x,y,z\na,1,2,3\n# comment, with, commas, too\n# 7,1,2,3\n", 1),
        ("x,y,z\n1,2,3\n#FAUX!,1,2\n2,3,4\n", 1),
        ("% by hand\n1 2 3\n", 0),
    ],
)
def test_comments_that_may_be_rows_are_counted(text: str, n: int) -> None:
    cloud = read(text, "xyz")
    assert len(cloud.comments) == text.count("\n") - len(cloud) - text.startswith(("id", "x"))
    assert cloud.warnings == ((OF_COMMENTS.format(n),) if n else ())


def test_a_semicolon_between_columns_begins_no_comment() -> None:
    cloud = read(";x;y;z\n0;1;2;3\n;4;5;6\n")
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert cloud.columns["column_1"].tolist() == ["0", ""]


ODD_BYTES = bytes(range(0x80, 0x100))


@pytest.mark.parametrize("format", ["csv", "txt", "xyz"])
@pytest.mark.parametrize("delimiter", [b",", b";", b"\t"])
def test_bytes_that_are_no_utf8_come_back(format: str, delimiter: bytes) -> None:
    header = delimiter.join([b"x", b"y", b"z", b"Gr\xf6\xdfe", ODD_BYTES])
    row = delimiter.join([b"1.0", b"2.0", b"3.0", b"a" + ODD_BYTES + b"b", "ä日".encode()])
    text = b"# H\xf6he \x81\n" + header + b"\n" + row + b"\n"
    cloud = read(text, format)
    assert cloud.comments == ("Höhe \x81",)
    assert next(iter(cloud.columns)) == "Größe"
    assert written(cloud, format) == text


def test_names_in_latin_1_are_known() -> None:
    cloud = read(b"id;Rechtswert;Hochwert;H\xf6he\n1;1.0;2.0;3.0\n")
    assert cloud.points.tolist() == [[1, 2, 3]]


def test_messages_show_other_encodings() -> None:
    cloud = read(b"x,y,z,kind\n1,2,3,M\xfcl0\n")
    with pytest.raises(CloudFileError, match=r"column 'kind' holds words .*'Mül0'"):
        written(cloud, "ply")


def test_words_in_other_encodings_become_utf8_in_other_files() -> None:
    cloud = read(b"x,y,z,kind\n1,2,3,L\xe4rche \x80\n")
    assert written(cloud, "asc").decode().endswith("1.0,2.0,3.0,Lärche €\n")


@pytest.mark.parametrize(
    "data", [b"1 2 3\n\xff\1", b"\x89PNG\r\n\x1a\n\1\2", b"\x1f\x8a\x08\x08 1 2 3"]
)
def test_no_text_is_refused(data: bytes) -> None:
    with pytest.raises(CloudFileError, match="neither PLY nor text"):
        read(data)


@pytest.mark.parametrize(
    ("text", "warnings"),
    [
        ("2\n1.0 2.0 3.0\n4.0 5.0 6.0\n", []),
        ("1\n1.0 2.0 3.0\n4.0 5.0 6.0\n",
         ["its count line promises 1 points, but 2 rows follow; all are read"]),
        ("3\n1.0 2.0 3.0\n4.0 5.0 6.0\n",
         ["its count line promises 3 points, but 2 rows follow, so that it may have been cut "
          "short; all are read"]),
        ("1\n1.0 2.0 3.0\n1\n4.0 5.0 6.0\n",
         ["its points come in 2 blocks, which are read as one cloud"]),
        ("1\n1.0 2.0 3.0\n9\n4.0 5.0 6.0\n",
         ["its points come in 2 blocks, which are read as one cloud",
          "its count lines promise 10 points, but 2 rows follow, so that it may have been cut "
          "short; all are read"]),
    ],
)  # fmt: skip
@pytest.mark.parametrize("format", ["pts", "txt", "xyz"])
def test_count_lines(text: str, warnings: list[str], format: str) -> None:
    cloud = read(text, format)
    assert cloud.points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert list(cloud.warnings) == warnings
    again = read(written(cloud, format), format)
    np.testing.assert_array_equal(again.points, cloud.points)
    assert list(again.warnings) == warnings[:1] * ("blocks" in "".join(warnings))


def test_blocks_come_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pcsmooth.formats.number_text.ROWS_AT_A_TIME", 2)
    rows = [f"{n}.0 2.0 3.0" for n in range(6)]
    text = "\n".join(["3", *rows[:3], "2", *rows[3:5], "1", rows[5], ""])
    cloud = read(text, "pts")
    assert written(cloud, "pts").decode() == text
    fewer = replace(cloud, points=cloud.points[:4])
    assert written(fewer, "pts").decode() == "\n".join(["4", *rows[:4], ""])
    with pytest.raises(CloudFileError, match="line 9: 'x' is not a number"):
        read(text.replace("5.0 2", "x 2"), "pts")


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9999\n1 2\n",
         "an ESRI ASCII grid"),
        ("NCOLS\t2\r\nNROWS\t1\r\nXLLCENTER 0\r\nYLLCENTER 0\r\nDX 1\r\nDY 1\r\n1 2\r\n",
         "an ESRI ASCII grid"),
        ("# c\n\n%c\r\n ncols 2\nnrows 1\nxllcorner 0\n1 2\n", "an ESRI ASCII grid"),
        ("DSAA\n2 1\n0 1\n0 1\n1 2\n1 2\n", "a Surfer grid"),
        ("north: 1\nsouth: 0\neast: 2\nwest: 0\nrows: 1\ncols: 2\n1 2\n", "a GRASS grid"),
    ],
)  # fmt: skip
def test_a_grid_is_recognised(text: str, kind: str) -> None:
    with pytest.raises(CloudFileError, match=f"it is {kind}, a raster .*; .* gdal_translate"):
        read(text, "asc")
