"""Points selected by an expression: what it means, what is refused, and that only they move."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pcsmooth.cloud import PointCloud
from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth.files.denoise_file import denoise_file
from pcsmooth.files.selection import Selection
from pcsmooth.files.where import Where

CLOUD = PointCloud(
    np.array([[0.0, 5.0], [1.0, 6.0], [2.0, 7.0], [3.0, 8.0]]),
    {
        "v": np.array([1.0, np.nan, 3.0, 0.0]),
        "kind": np.array(["a", "b", "2", "a"]),
        "class": np.array([1, 2, 3, 4]),
        "scan angle": np.array([-2, -1, 1, 2]),
        "column": np.array([0, 0, 0, 1]),
        "many": np.array([[1], [2], [3], [4]], dtype=object)[:, 0],
    },
)


@pytest.mark.parametrize(
    ("text", "rows"),
    [
        ("x > 1", [2, 3]),
        ("0 < x <= 2 and not y == 6", [2]),
        ("v != 1", [2, 3]),
        ("not v > 2", [0, 3]),
        ("v", [0, 2]),
        ("kind == 'a' or kind == 2", [2]),
        ("kind == 'a'", [0, 3]),
        ("-x + y // 2 ** 2 % 3 * 1 < 0 / 1", [2, 3]),
        ("x / 0 != x", [1, 2, 3]),
        ("9 ** 9 ** 9 > +x", [0, 1, 2, 3]),
        ("(x > 1) + (y > 7) == 1", [2]),
        ("'b' == kind", [1]),
        ("x + 1 == '1.0'", [0]),
        ("x + 'a' == x", []),
        ("`class` > 1 and `scan angle` < 2", [1, 2]),
        ("`class`not in(1, 4)", [1, 2]),
        ("`column` == 1", [3]),
        ("column == 1 or `scan angle`*-1 == 2", [0, 3]),
        ("kind == '`class`' or kind == \"'\"", []),
        ("kind in ('a', 2)", [0, 2, 3]),
        ("kind not in ['a']", [1, 2]),
        ("'a' in ('a', kind)", [0, 1, 2, 3]),
        ("x in (0, 1 + 1)", [0, 2]),
        ("v not in (1, 9)", [2, 3]),
        ("0 <= x not in (1,)", [0, 2, 3]),
        (r"kind == '\d'", []),
        (f"kind == '{'long' * 200}'", []),
        ("0x" + "f" * 900 + " > x", [0, 1, 2, 3]),
    ],
)
def test_rows_that_are_selected(text: str, rows: list[int]) -> None:
    assert np.flatnonzero(Where(text).selected(CLOUD, "f")).tolist() == rows


@pytest.mark.parametrize(
    "text",
    [
        *("", "x >", "f(x)", "x.real", "[x]", "x if y else 1", "None", "x in y", "lambda: 1"),
        *("x in ()", "x in 1", "x in (1, (2, 3))", "x == (1, 2)", "(1, 2)", "x in (f(x),)"),
        *("`x", "``", "`x` `y`", "`a\nb`", "f(`x y`)", "x in {1, 2}", "x is 1", "x := 1"),
        *("-" * 60 + "x", "x" * 1001, "(" * 500, "\0", "1j"),
    ],
)
def test_anything_else_is_refused(text: str) -> None:
    with pytest.raises(InvalidInputError):
        Where(text)


def test_what_is_refused_is_shown_as_it_was_written() -> None:
    with pytest.raises(InvalidInputError, match=r"^'f\(`x y`\)' in 'f\(`x y`\)' is neither"):
        Where("f(`x y`)")


@pytest.mark.parametrize("name", ["z", "many", "none"])
def test_unknown_columns_are_named_with_the_known(name: str) -> None:
    with pytest.raises(
        CloudFileError,
        match=f"no column '{name}'.*choose of x, y, v, kind, class, scan angle, column$",
    ):
        Where(f"{name} > 1").selected(CLOUD, "f")


def test_only_selected_points_move_as_if_the_others_were_fixed(tmp_path: Path) -> None:
    angles = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    points = np.c_[np.cos(angles), np.sin(angles)]
    points += np.random.default_rng(0).normal(0, 0.01, points.shape)
    source = tmp_path / "in.csv"
    rows = [f"{x:.9f},{y:.9f},{int(y > 0)}" for x, y in points]
    source.write_text("\n".join(["x,y,top", *rows]) + "\n")
    selected, fixed = tmp_path / "selected.csv", tmp_path / "fixed.csv"
    denoise_file(source, selected, selection=Selection("not top"))
    denoise_file(source, fixed, fixed="top")
    assert selected.read_bytes() == fixed.read_bytes()
    moved = np.loadtxt(selected, delimiter=",", skiprows=1, usecols=(0, 1)) != np.loadtxt(
        source, delimiter=",", skiprows=1, usecols=(0, 1)
    )
    assert not moved[points[:, 1] > 0].any()
    assert moved[points[:, 1] < 0].any()
    tiled = tmp_path / "tiled.csv"
    denoise_file(source, tiled, selection=Selection("not top"), tile=100)
    assert tiled.read_bytes() == selected.read_bytes()


def test_a_selection_of_no_point_is_said(tmp_path: Path) -> None:
    source = tmp_path / "in.csv"
    source.write_text("x,y\n0,0\n1,0.1\n2,0\n3,0.1\n")
    said: list[str] = []
    denoise_file(source, tmp_path / "out.csv", selection=Selection("x > 9"), say=said.append)
    assert any("no point is selected by 'x > 9'" in line for line in said)


def test_the_file_says_what_was_selected(tmp_path: Path) -> None:
    source, target = tmp_path / "in.csv", tmp_path / "out.ply"
    points = np.random.default_rng(2).normal(0, 1, (50, 3)) * [1, 1, 0.01]
    np.savetxt(source, points, "%.6f", ",", header="x,y,z", comments="")
    denoise_file(source, target, selection=Selection("(x % 2\n == 1)"))
    assert b" where=(x%20%25%202%0A%20==%201)\n" in target.read_bytes()
