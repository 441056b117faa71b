"""The options of `pcsmooth denoise`, and what it says."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pcsmooth
from cli.clouds import (
    DATA,
    Points,
    brute_force_spacing,
    circle,
    load_ply,
    positions,
    save_ply,
    save_text,
    sphere,
    vertices,
)
from cli.commands import forked, succeeds
from cli.commands import pcsmooth as pcsmooth_runs

DEFAULTS: dict[str, Any] = {}
OPTIONS = {
    "defaults": ([], DEFAULTS),
    "area": (["--energy", "area"], {"energy": "area"}),
    "unweighted": (["--weight", "none", "--step", "0.3"], {"weight": "none", "step": 0.3}),
    "boundary": (["--weight", "boundary"], {"weight": "boundary"}),
    "radius": (["--radius", "0.5"], {"radius": 0.5}),
    "local radius": (["--radius", "local"], {"radius": "local"}),
    "no iteration": (["--iterations", "0"], {"iterations": 0}),
    "iterations": (["--iterations", "2"], {"iterations": 2}),
    "step": (["--step", "0.001"], {"step": 0.001}),
    "support": (["--support", "40"], {"support": 40}),
    "orient": (["--orient", "propagate"], {"orient": "propagate"}),
    "step auto": (["--step", "auto"], {"step": "auto"}),
    "filter": (["--scheme", "filter"], {"scheme": "filter"}),
    "filter with radius": (
        ["--scheme", "filter", "--radius", "3x"],
        {"scheme": "filter", "radius": "3x"},
    ),
    "noise": (["--noise", "0.05"], {"noise": 0.05}),
    "noise in spacings": (["--noise", "0.2x"], {"noise": "0.2x"}),
    "noise in the extent": (["--noise", "1%"], {"noise": "1%"}),
    "closed": (["--closed"], {"closed": True}),
    "implicit with noise": (
        ["--scheme", "implicit", "--noise", "0.1x"],
        {"scheme": "implicit", "noise": "0.1x"},
    ),
    "euler": (["--scheme", "euler"], {"scheme": "euler"}),
    "implicit": (["--scheme", "implicit"], {"scheme": "implicit"}),
    "first order": (
        ["--scheme", "implicit", "--order", "1", "--iterations", "1"],
        {"scheme": "implicit", "order": 1, "iterations": 1},
    ),
    "normal motion": (["--motion", "normal"], {"motion": "normal"}),
    "max move": (["--max-move", "0.1x"], {"max_move": "0.1x"}),
    "keep volume": (["--keep-volume"], {"keep_volume": True}),
    "stop": (["--stop", "0.05", "--iterations", "30"], {"stop": 0.05, "iterations": 30}),
}


@pytest.fixture
def scan(tmp_path: Path) -> Path:
    """A sphere as double PLY."""
    return save_ply(tmp_path / "scan.ply", vertices(sphere(), "f8"))


@pytest.mark.slow
@pytest.mark.parametrize(("arguments", "keywords"), OPTIONS.values(), ids=OPTIONS)
@pytest.mark.parametrize("points", [circle(), sphere()], ids=["2D", "3D"])
def test_flow_options_mean_what_they_mean_in_python(
    tmp_path: Path, points: Points, arguments: list[str], keywords: dict[str, Any]
) -> None:
    cloud = save_text(tmp_path / "cloud.txt", points)
    succeeds("denoise", cloud, "-o", tmp_path / "out.ply", "--double", *arguments)
    expected = pcsmooth.denoise(points, **keywords)
    dimension = points.shape[1]
    np.testing.assert_array_equal(positions(tmp_path / "out.ply")[:, :dimension], expected.points)
    vertex = load_ply(tmp_path / "out.ply")["vertex"]
    for axis, name in enumerate(("nx", "ny", "nz")[:dimension]):
        np.testing.assert_array_equal(vertex[name], np.float32(expected.normals[:, axis]))
    for name in ("quality", "scalar_mean_curvature", "curvature"):
        np.testing.assert_array_equal(vertex[name], np.float32(expected.mean_curvature))
    np.testing.assert_array_equal(vertex["scalar_displacement"], np.float32(expected.displacement))
    assert ("scalar_outlier" in vertex) == (expected.method.name == "filter")
    if expected.outliers is not None:
        np.testing.assert_array_equal(vertex["scalar_outlier"], np.float32(expected.outliers))
    curvature = expected.curvature
    np.testing.assert_array_equal(vertex["scalar_confidence"], np.float32(curvature.confidence))
    names = {prop.name for prop in vertex.properties}
    assert ("scalar_gaussian_curvature" in names) == (dimension == 3)
    if dimension == 3:
        np.testing.assert_array_equal(
            vertex["scalar_gaussian_curvature"], np.float32(curvature.gaussian_curvature)
        )
        for name, values in zip(
            ("scalar_k1", "scalar_k2"), curvature.principal_curvatures.T, strict=True
        ):
            np.testing.assert_array_equal(vertex[name], np.float32(values))


def test_the_defaults_bring_the_points_nearer_to_the_surface(tmp_path: Path) -> None:
    points = sphere(2000, noise=0.015)
    cloud = save_ply(tmp_path / "noisy.ply", vertices(points, "f8"))
    succeeds("denoise", cloud, "-o", tmp_path / "out.ply")

    def scatter(cloud: Points) -> float:
        return float(np.linalg.norm(cloud, axis=1).std())

    assert scatter(positions(tmp_path / "out.ply")) < scatter(points) / 3
    succeeds("denoise", cloud, "-o", tmp_path / "flow.ply", "--scheme", "euler")
    assert scatter(positions(tmp_path / "flow.ply")) < scatter(points) / 3


SPACING = brute_force_spacing(sphere())
DIAGONAL = float(np.linalg.norm(np.ptp(sphere(), axis=0)))
RADII = {
    "0.5": 0.5,
    "5e-1": 0.5,
    "3x": 3 * SPACING,
    "1.5X": 1.5 * SPACING,
    "20%": 0.2 * DIAGONAL,
    "auto": 2 * SPACING,
}


@pytest.mark.parametrize(("form", "length"), RADII.items(), ids=RADII)
def test_radius_forms_equal_the_length_they_stand_for(
    tmp_path: Path, scan: Path, form: str, length: float
) -> None:
    relative, absolute = tmp_path / "relative.ply", tmp_path / "absolute.ply"
    euler = ["--scheme", "euler"]
    finished = succeeds("denoise", scan, "-o", relative, "--radius", form, "--json", *euler)
    radius = finished.json["radius"]
    assert radius == pytest.approx(length, rel=1e-12)
    succeeds("denoise", scan, "-o", absolute, "--radius", repr(radius), *euler)
    assert relative.read_bytes() == absolute.read_bytes()


def test_energy_log_holds_the_history_to_the_last_digit(tmp_path: Path, scan: Path) -> None:
    log = tmp_path / "energy.csv"
    succeeds("denoise", scan, "-o", tmp_path / "o.ply", "--iterations", "3", "--energy-log", log)
    header, *rows = log.read_text().splitlines()
    assert header == "iteration,volume,area,mean_move,max_move"
    history = pcsmooth.denoise(sphere(), iterations=3).history
    assert [row.split(",")[0] for row in rows] == ["0", "1", "2", "3"]
    assert [tuple(map(float, row.split(","))) for row in rows] == list(
        map(dataclasses.astuple, history)
    )


def test_energy_log_of_an_unmoved_cloud_has_one_row(tmp_path: Path, scan: Path) -> None:
    log = tmp_path / "energy.csv"
    succeeds("denoise", scan, "-o", tmp_path / "o.ply", "--iterations", 0, "--energy-log", log)
    assert len(log.read_text().splitlines()) == 2


def test_the_perimeters_of_the_report_are_reproduced(tmp_path: Path) -> None:
    log = tmp_path / "energy.csv"
    succeeds(
        "denoise", DATA / "report/ellipse-noisy-dense.xy", "-o", tmp_path / "smooth.xy",
        "--energy", "area", "--weight", "none", "--radius", 15, "--step", 1, "--iterations", 59,
        "--energy-log", log,
    )  # fmt: skip
    perimeters = np.loadtxt(log, delimiter=",", skiprows=1, usecols=2)
    expected = np.loadtxt(DATA / "report/perimeter-dense.log")
    assert len(expected) == 60
    np.testing.assert_allclose(perimeters, expected, rtol=1e-5)


#: Arguments that flows alone have: each makes a flow of the default.
FLOWS = {
    "energy": ["--energy", "volume"],
    "weight": ["--weight", "cell"],
    "iterations": ["--iterations", "6"],
    "step": ["--step", "0.01"],
    "stop": ["--stop", "0.01"],
    "polyhedron": ["--polyhedron", "cube"],
    "radius": ["--radius", "2x"],
}


class TestScheme:
    def scheme(self, scan: Path, *arguments: object) -> str:
        finished = succeeds(
            "denoise", scan, "-o", scan.parent / "o.ply", "--json", "--overwrite", *arguments
        )
        done, *_ = load_ply(scan.parent / "o.ply").comments
        scheme: str = finished.json["scheme"]
        assert f" denoise scheme={scheme} " in done
        return scheme

    @pytest.mark.parametrize(
        "arguments",
        [
            [],
            ["--scheme", "auto"],
            ["--radius", "AUTO"],
            ["--step", "auto"],
            ["--noise", "0.1x"],
            ["--motion", "normal", "--max-move", "1x", "--keep-volume"],
            ["--scheme", "filter", "--radius", "3x"],
        ],
        ids=" ".join,
    )
    def test_the_filter(self, scan: Path, arguments: list[str]) -> None:
        assert self.scheme(scan, *arguments) == "filter"

    @pytest.mark.parametrize("arguments", FLOWS.values(), ids=FLOWS)
    def test_a_flow(self, scan: Path, arguments: list[str]) -> None:
        assert self.scheme(scan, *arguments) == "euler"
        assert self.scheme(scan, "--scheme", "implicit", *arguments) == "implicit"


@pytest.mark.parametrize(
    ("noise", "tells_apart"), [(0.02, True), (0.002, False)], ids=["thin", "little noise"]
)
def test_closed_surfaces_are_said(tmp_path: Path, noise: float, tells_apart: bool) -> None:
    points = sphere(600)
    points += noise * np.random.default_rng(0).normal(size=points.shape)
    scan = save_ply(tmp_path / "scan.ply", vertices(points, "f8"))
    options = ("--closed", "--noise", noise, "--json")
    finished = succeeds("denoise", scan, "-o", tmp_path / "out.ply", *options)
    assert finished.json["sides"] is tells_apart
    assert ("both sides of thin parts told apart" in finished.stderr) == tells_apart
    assert ("sides of thin parts not told apart" in finished.stderr) != tells_apart
    assert "closed=yes" in (tmp_path / "out.ply").read_bytes()[:2000].decode("latin-1")


class TestOutliers:
    @pytest.fixture
    def stray(self, tmp_path: Path) -> Path:
        """A sphere, a row that is not finite, an outlier, and the outlier again."""
        far = [[np.nan, 0.0, 0.0], [2.5, 0.0, 0.0], [2.5, 0.0, 0.0]]
        return save_ply(tmp_path / "stray.ply", vertices(np.r_[sphere(300), far], "f8"))

    def test_they_are_marked_counted_and_left(self, tmp_path: Path, stray: Path) -> None:
        finished = succeeds("denoise", stray, "-o", tmp_path / "out.ply", "--json")
        marks = load_ply(tmp_path / "out.ply")["vertex"]["scalar_outlier"]
        assert marks.dtype == np.float32
        np.testing.assert_array_equal(marks, np.arange(303) > 300)
        assert finished.json["outliers"] == 2
        assert "  2 outliers left where they are (column outlier)\n" in finished.stderr
        np.testing.assert_array_equal(positions(tmp_path / "out.ply")[301:], [[2.5, 0.0, 0.0]] * 2)

    def test_in_text(self, tmp_path: Path, stray: Path) -> None:
        succeeds("denoise", stray, "-o", tmp_path / "out.csv")
        header, *rows = (tmp_path / "out.csv").read_text().splitlines()
        assert header.endswith(",displacement,outlier")
        marks = np.array([row.rsplit(",", 1)[1] for row in rows], float)
        np.testing.assert_array_equal(marks, np.arange(303) > 300)

    @pytest.mark.parametrize("suffix", ["ply", "csv"])
    def test_a_later_flow_drops_the_column(self, tmp_path: Path, stray: Path, suffix: str) -> None:
        name = {"ply": "scalar_outlier", "csv": "outlier"}[suffix]
        first, second, third = (tmp_path / f"{number}.{suffix}" for number in (1, 2, 3))
        succeeds("denoise", stray, "-o", first)
        finished = succeeds("denoise", first, "-o", second, "--scheme", "euler")
        assert f"columns of an earlier run are left out: {name}\n" in finished.stderr
        assert columns_of(second) == [n for n in columns_of(first) if n != name]
        finished = succeeds("denoise", first, "-o", third)
        assert "left out" not in finished.stderr
        assert columns_of(third) == columns_of(first)

    @pytest.mark.parametrize("suffix", ["ply", "csv"])
    def test_the_inputs_own_is_kept(self, tmp_path: Path, suffix: str) -> None:
        name = {"ply": "scalar_outlier", "csv": "outlier"}[suffix]
        source = tmp_path / f"scan.{suffix}"
        own = np.arange(150.0) / 8
        if suffix == "ply":
            save_ply(source, vertices(sphere(), "f8", scalar_outlier=own.astype("f4")))
        else:
            rows = [["x", "y", "z", name], *np.c_[sphere(), own].tolist()]
            save_text(source, rows, ",")
        first, second = (tmp_path / f"{number}.{suffix}" for number in (1, 2))
        for before, after, options in ((source, first, []), (first, second, ["--scheme", "euler"])):
            finished = succeeds("denoise", before, "-o", after, *options)
            told = f"column '{name}' is the input's own and kept" in finished.stderr
            assert told == (not options)
            assert columns_of(after).count(name) == 1
            assert "left out" not in finished.stderr
            if suffix == "ply":
                kept = load_ply(after)["vertex"][name]
            else:
                kept = np.loadtxt(after, delimiter=",", skiprows=1, usecols=3)
            np.testing.assert_array_equal(kept, own)


def columns_of(path: Path) -> list[str]:
    """Names of the columns of a PLY or CSV file."""
    if path.suffix == ".csv":
        return path.read_text().splitlines()[0].split(",")
    return [prop.name for prop in load_ply(path)["vertex"].properties]


@pytest.mark.parametrize(
    ("points", "words"),
    [
        (sphere(5), "  too few points to filter: none moved\n"),
        (np.c_[np.arange(40.0), np.zeros(40)], "  no noise found, or too few points to tell: "),
        (
            np.indices((12, 12, 12)).reshape(3, -1).T.astype(float),
            "warning: no surface shows at any scale, the points fill a volume: none moved; "
            "--noise or a flow moves them all the same\n",
        ),
    ],
    ids=["few", "clean", "solid"],
)
def test_what_the_filter_cannot_or_need_not_do_is_said(
    tmp_path: Path, points: Points, words: str
) -> None:
    cloud = save_text(tmp_path / "cloud.txt", points)
    finished = succeeds("denoise", cloud, "-o", tmp_path / "out.txt", "--json")
    assert words in finished.stderr
    assert finished.json["max_displacement"] == 0.0
    assert finished.json["outliers"] == 0
    moved = np.loadtxt(tmp_path / "out.txt", comments="//", usecols=range(points.shape[1]))
    np.testing.assert_array_equal(moved, points)


class TestFixed:
    HELD = np.arange(60) % 7 == 0

    def expected(self, **options: Any) -> Points:
        return pcsmooth.denoise(circle(), fixed=self.HELD, **options).points

    @pytest.mark.parametrize("column", ["control", "5"])
    def test_by_name_or_number_in_csv(self, tmp_path: Path, column: str) -> None:
        rows: list[list[object]] = [["x", "y", "id", "note", "control"]]
        rows += [
            [*point, row, "n/a", "0.5" if held else "0"]
            for row, (point, held) in enumerate(zip(circle().tolist(), self.HELD, strict=True))
        ]
        cloud = save_text(tmp_path / "survey.csv", rows, ",")
        succeeds("denoise", cloud, "-o", tmp_path / "out.csv", "--fixed", column)
        out = np.loadtxt(tmp_path / "out.csv", delimiter=",", skiprows=1, usecols=(0, 1))
        np.testing.assert_array_equal(out, self.expected())
        np.testing.assert_array_equal(out[self.HELD], circle()[self.HELD])

    @pytest.mark.parametrize(("column", "number"), [("id", 1), ("control", 4)])
    def test_numbers_count_the_columns_of_the_file(
        self, tmp_path: Path, column: str, number: int
    ) -> None:
        rows: list[list[object]] = [["id", "x", "y", "control"]]
        rows += [
            [row % 2, *point, int(held)]
            for row, (point, held) in enumerate(zip(circle().tolist(), self.HELD, strict=True))
        ]
        cloud = save_text(tmp_path / "survey.csv", rows, ",")
        succeeds("denoise", cloud, "-o", tmp_path / "name.csv", "--fixed", column)
        succeeds("denoise", cloud, "-o", tmp_path / "number.csv", "--fixed", number)
        assert (tmp_path / "number.csv").read_bytes() == (tmp_path / "name.csv").read_bytes()

    @pytest.mark.parametrize(
        "marks",
        [HELD.astype("u1"), HELD * 3.0, np.where(HELD, -1, 0).astype("i4")],
        ids=["uchar", "double", "negative int"],
    )
    def test_by_name_in_ply(self, tmp_path: Path, marks: Any) -> None:
        cloud = save_ply(tmp_path / "c.ply", vertices(circle(), "f8", held=marks))
        succeeds("denoise", cloud, "-o", tmp_path / "out.ply", "--fixed", "held")
        vertex = load_ply(tmp_path / "out.ply")["vertex"]
        np.testing.assert_array_equal(np.stack([vertex["x"], vertex["y"]], axis=1), self.expected())
        np.testing.assert_array_equal(vertex["held"], marks)

    @pytest.mark.parametrize("option", [[], ["--fixed", "fixed"], ["--fixed", "3"]])
    def test_rows_that_end_in_the_word_are_held(self, tmp_path: Path, option: list[str]) -> None:
        rows = [
            [*point, *(["fixed"] if held else [])]
            for point, held in zip(circle().tolist(), self.HELD, strict=True)
        ]
        cloud = save_text(tmp_path / "curve.xy", rows)
        succeeds("denoise", cloud, "-o", tmp_path / "out.xy", *option)
        words = [line.split() for line in (tmp_path / "out.xy").read_text().splitlines()]
        assert [word[-1] == "fixed" for word in words] == self.HELD.tolist()
        out = np.array([word[:2] for word in words], dtype=float)
        np.testing.assert_array_equal(out, self.expected())

    @pytest.mark.parametrize("free", ["", "0", "nan"])
    def test_the_word_in_a_column(self, tmp_path: Path, free: str) -> None:
        rows: list[list[object]] = [["x", "y", "state"]]
        rows += [
            [*point, "Fixed" if held else free]
            for point, held in zip(circle().tolist(), self.HELD, strict=True)
        ]
        cloud = save_text(tmp_path / "curve.csv", rows, ",")
        succeeds("denoise", cloud, "-o", tmp_path / "out.csv", "--fixed", "state")
        out = np.loadtxt(tmp_path / "out.csv", delimiter=",", skiprows=1, usecols=(0, 1))
        np.testing.assert_array_equal(out, self.expected())

    def test_an_empty_mark_is_not_a_mark(self, tmp_path: Path) -> None:
        marks = np.where(self.HELD, 1.0, np.nan)
        cloud = save_ply(tmp_path / "c.ply", vertices(circle(), "f8", held=marks))
        finished = succeeds("denoise", cloud, "-o", tmp_path / "o.ply", "--fixed", "held", "--json")
        assert finished.json["fixed"] == int(self.HELD.sum())

    def test_the_reports_line_keeps_its_ends(self, tmp_path: Path) -> None:
        source = DATA / "report/line_fixed.xy"
        finished = succeeds("denoise", source, "-o", tmp_path / "out.xy", "--scheme", "euler")
        before = [line.split() for line in source.read_text().splitlines()]
        after = [line.split() for line in (tmp_path / "out.xy").read_text().splitlines()]
        held = [row for row, words in enumerate(before) if words[-1] == "fixed"]
        assert len(held) == 2
        for row, (old, new) in enumerate(zip(before, after, strict=True)):
            assert (new[-1] == "fixed") == (row in held)
            assert (new[:2] == old[:2]) == (row in held)
        assert "15 points in 2D, 2 fixed" in finished.stderr


@pytest.mark.parametrize("code", ["f4", "f8"])
@pytest.mark.parametrize(("flag", "written"), [("--float", "f4"), ("--double", "f8"), (None, None)])
def test_position_type(tmp_path: Path, code: str, flag: str | None, written: str | None) -> None:
    cloud = save_ply(tmp_path / "scan.ply", vertices(sphere(), code))
    succeeds("denoise", cloud, "-o", tmp_path / "out.ply", *([flag] if flag else []))
    out = positions(tmp_path / "out.ply")
    expected = pcsmooth.denoise(sphere().astype(code)).points.astype(written or code)
    assert out.dtype == expected.dtype
    np.testing.assert_array_equal(out, expected)


def test_float_in_text_writes_fewer_digits(tmp_path: Path) -> None:
    cloud = save_text(tmp_path / "scan.xyz", sphere())
    succeeds("denoise", cloud, "-o", tmp_path / "out.xyz", "--float")
    words = (tmp_path / "out.xyz").read_text().split()[::6]
    expected = pcsmooth.denoise(sphere()).points[:, 0].astype(np.float32)
    assert words == [str(value) for value in expected]


def test_whole_number_positions_are_written_as_double_and_it_is_said(tmp_path: Path) -> None:
    points = np.round(100 * sphere())
    cloud = save_ply(tmp_path / "scan.ply", vertices(points, "i4"))
    finished = succeeds("denoise", cloud, "-o", tmp_path / "out.ply")
    assert "positions are int32 in the input; they are written as double" in finished.stderr
    np.testing.assert_array_equal(positions(tmp_path / "out.ply"), pcsmooth.denoise(points).points)


class TestFarFromTheOrigin:
    UTM = np.array([432_100.25, 5_412_300.5, 210.0])

    @pytest.mark.parametrize(
        ("code", "option", "warned"),
        [
            ("f4", None, True),
            ("f4", "--double", False),
            ("f8", None, False),
            ("f8", "--float", True),
        ],
    )
    def test_floats_that_cannot_hold_the_result_are_warned_about(
        self, tmp_path: Path, code: str, option: str | None, warned: bool
    ) -> None:
        cloud = save_ply(tmp_path / "utm.ply", vertices(10 * sphere() + self.UTM, code))
        options = [option] if option else []
        finished = succeeds("denoise", cloud, "-o", tmp_path / "out.ply", *options)
        assert ("warning: float positions round" in finished.stderr) == warned
        assert ("--double keeps them" in finished.stderr) == warned

    def test_floats_near_the_origin_are_not_warned_about(self, tmp_path: Path) -> None:
        cloud = save_ply(tmp_path / "near.ply", vertices(sphere(), "f4"))
        finished = succeeds("denoise", cloud, "-o", tmp_path / "out.ply")
        assert "warning" not in finished.stderr

    def test_doubles_lose_nothing(self, tmp_path: Path) -> None:
        points = np.vstack([sphere(), [[50.1, 0.2, 0.3]]]) + self.UTM
        held = np.arange(len(points)) % 5 == 0
        held[-1] = False  # far from all others: isolated
        cloud = save_ply(tmp_path / "utm.ply", vertices(points, "f8", held=held.astype("u1")))
        succeeds("denoise", cloud, "-o", tmp_path / "out.ply", "--fixed", "held")
        out = positions(tmp_path / "out.ply")
        resting = np.append(np.flatnonzero(held), len(points) - 1)
        assert out[resting].tobytes() == points[resting].tobytes()
        local = pcsmooth.denoise(points - self.UTM, fixed=held).points
        np.testing.assert_allclose(out - self.UTM, local, rtol=0, atol=4e-9)
        assert (np.linalg.norm(out - points, axis=1)[~held][:-1] > 1e-4).all()


@pytest.mark.parametrize("height", [0.0, 7.25])
def test_dim_2_keeps_the_third_coordinate(tmp_path: Path, height: float) -> None:
    points = np.column_stack([circle(), np.full(60, height)])
    cloud = save_ply(tmp_path / "plane.ply", vertices(points, "f8"))
    finished = succeeds("denoise", cloud, "-o", tmp_path / "out.ply", "--dim", "2", "--json")
    assert finished.json["dimension"] == 2
    expected = pcsmooth.denoise(circle())
    out = positions(tmp_path / "out.ply")
    np.testing.assert_array_equal(out[:, :2], expected.points)
    np.testing.assert_array_equal(out[:, 2], height)
    vertex = load_ply(tmp_path / "out.ply")["vertex"]
    np.testing.assert_array_equal(vertex["nz"], 0.0)
    np.testing.assert_array_equal(vertex["curvature"], np.float32(expected.mean_curvature))


@pytest.mark.parametrize("options", [[], ["--dim", "3"]])
def test_a_planar_cloud_is_3d_unless_asked(tmp_path: Path, options: list[str]) -> None:
    points = np.column_stack([circle(), np.zeros(60)])
    cloud = save_text(tmp_path / "plane.xyz", points)
    finished = succeeds("denoise", cloud, "-o", tmp_path / "out.xyz", "--json", *options)
    assert finished.json["dimension"] == 3


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["filter", "euler"])
def test_the_number_of_threads_does_not_change_a_byte(tmp_path: Path, scheme: str) -> None:
    cloud = save_ply(tmp_path / "scan.ply", vertices(sphere(4000), "f8"))
    outputs = []
    for threads in (1, 2):
        out, log = tmp_path / f"{threads}.ply", tmp_path / f"{threads}.csv"
        succeeds(
            "denoise", cloud, "-o", out, "--threads", threads, "--energy-log", log,
            "--scheme", scheme,
        )  # fmt: skip
        outputs.append((out.read_bytes(), log.read_bytes()))
    assert outputs[0] == outputs[1]


def test_overwrite_replaces_output_and_log(tmp_path: Path, scan: Path) -> None:
    out, log = tmp_path / "out.ply", tmp_path / "log.csv"
    arguments = ["denoise", scan, "-o", out, "--energy-log", log]
    succeeds(*arguments)
    expected = out.read_bytes(), log.read_bytes()
    out.write_bytes(b"old")
    log.write_bytes(b"old")
    succeeds(*arguments, "--overwrite")
    assert (out.read_bytes(), log.read_bytes()) == expected


@pytest.mark.parametrize("code", ["f4", "f8"])
def test_a_file_can_be_replaced_by_its_own_result(tmp_path: Path, code: str) -> None:
    cloud = save_ply(tmp_path / "scan.ply", vertices(sphere(600), code))
    succeeds("denoise", cloud, "-o", tmp_path / "expected.ply")
    succeeds("denoise", cloud, "-o", cloud, "--overwrite")
    assert cloud.read_bytes() == (tmp_path / "expected.ply").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["expected.ply", "scan.ply"]


class TestRowsThatCannotTakePart:
    @pytest.mark.parametrize("suffix", ["ply", "xyz", "csv"])
    def test_rows_that_are_not_finite_pass_unmoved_and_are_counted(
        self, tmp_path: Path, suffix: str
    ) -> None:
        points = sphere()
        points[[3, 77, 149]] = [[np.nan] * 3, [0.5, np.inf, 0.25], [-np.inf, np.nan, 1.5]]
        cloud = tmp_path / f"scan.{suffix}"
        if suffix == "ply":
            save_ply(cloud, vertices(points, "f8"))
        else:
            save_text(cloud, points, {"xyz": " ", "csv": ","}[suffix])
        finished = succeeds("denoise", cloud, "-o", tmp_path / "out.ply", "--json")
        out = positions(tmp_path / "out.ply")
        broken = ~np.isfinite(points).all(axis=1)
        np.testing.assert_array_equal(out[broken], points[broken])
        np.testing.assert_array_equal(out[~broken], pcsmooth.denoise(points[~broken]).points)
        assert finished.json["not_finite"] == 3
        assert "150 points in 3D, 3 not finite (passed through)" in finished.stderr
        vertex = load_ply(tmp_path / "out.ply")["vertex"]
        for name in ("nx", "ny", "nz", "curvature", "scalar_displacement"):
            np.testing.assert_array_equal(vertex[name][broken], 0.0)
            assert np.isfinite(vertex[name]).all()

    @pytest.mark.parametrize("code", ["f4", "f8"])
    def test_coincident_points_move_together(self, tmp_path: Path, code: str) -> None:
        points = sphere()[[*range(150), 10, 20, 10]]
        cloud = save_ply(tmp_path / "scan.ply", vertices(points, code))
        succeeds("denoise", cloud, "-o", tmp_path / "out.ply")
        vertex = load_ply(tmp_path / "out.ply")["vertex"].data
        assert vertex[150] == vertex[152] == vertex[10]
        assert vertex[151] == vertex[20]
        single = pcsmooth.denoise(sphere().astype(code)).points.astype(code)
        np.testing.assert_allclose(positions(tmp_path / "out.ply")[:150], single, rtol=0, atol=1e-6)
        assert (vertex["scalar_displacement"] > 0).all()


class TestMessages:
    def test_quiet_says_nothing(self, tmp_path: Path) -> None:
        foreign = vertices(sphere() + 1e6, "f4", quality=np.zeros(150, "f4"))
        cloud = save_ply(tmp_path / "scan.ply", foreign)
        loud = succeeds("denoise", cloud, "-o", tmp_path / "loud.xyz", "-v")
        assert loud.stderr.count("warning: ") == 2
        for flag in ("-q", "--quiet"):
            finished = succeeds("denoise", cloud, "-o", tmp_path / f"{flag}.xyz", flag, "-v")
            assert (finished.stdout, finished.stderr) == (b"", "")

    def test_what_was_chosen_is_printed_on_stderr(self, tmp_path: Path, scan: Path) -> None:
        finished = succeeds("denoise", scan, "-o", tmp_path / "out.ply")
        assert finished.stdout == b""
        result = pcsmooth.denoise(sphere())
        assert f"{scan}: 150 points in 3D\n" in finished.stderr
        assert result.plan is not None
        noise, left = result.plan.noise.deviation, result.sigma_after
        assert left is not None
        assert (
            f"  noise {noise:.4g}, {noise / result.plan.spacing:.2g} of the local spacing "
            f"sqrt(area/points); {np.median(left):.4g} left\n"
            f"  filtered in neighbourhoods of {result.plan.support:.0f} points\n"
            f"  points moved {result.displacement.mean():.4g} on average, "
            f"{result.displacement.max():.4g} at most\n  RMS "
        ) in finished.stderr
        for word in ("radius", "volume", "energy", "weight"):  # of flows
            assert word not in finished.stderr
        assert (
            f"  normals from {result.curvature.normal_support:.0f} points, "
            f"curvature from {result.curvature.curvature_support:.0f}\n"
            "  normals: 1 component outward\n"
            f"  median |H| {np.median(np.abs(result.mean_curvature)):.4g}, H=(k1+k2)/2\n"
        ) in finished.stderr
        assert f"wrote {tmp_path / 'out.ply'} in" in finished.stderr

    def test_steps_of_a_flow_are_printed(self, tmp_path: Path, scan: Path) -> None:
        finished = succeeds("denoise", scan, "-o", tmp_path / "out.ply", "--scheme", "euler")
        result = pcsmooth.denoise(sphere(), scheme="euler")
        assert (
            f"  radius {result.radius:.6g} (2x the mean spacing {result.spacing:.6g})\n"
            f"  6 euler steps of {result.step:.6g} on the volume, weight cell\n"
        ) in finished.stderr
        assert "noise" not in finished.stderr
        assert "outliers" not in finished.stderr

    def test_local_radii_are_printed(self, tmp_path: Path, scan: Path) -> None:
        finished = succeeds(
            "denoise", scan, "-o", tmp_path / "out.ply", "--radius", "local:3x", "--json"
        )
        result = pcsmooth.denoise(sphere(), scheme="euler", radius="local:3x")
        assert result.radii is not None
        least, largest = result.radii.min(), result.radii.max()
        assert (
            f"  local radius {least:.6g} to {largest:.6g}, median {result.radius:.6g}\n"
        ) in finished.stderr
        assert finished.json["radius"] == pytest.approx(result.radius, rel=1e-6)
        assert finished.json["radius_range"] == pytest.approx([least, largest], rel=1e-6)

    def test_verbose_prints_a_line_per_state(self, tmp_path: Path, scan: Path) -> None:
        finished = succeeds("denoise", scan, "-o", tmp_path / "o.ply", "--iterations", 4, "-v")
        pattern = r"^ +(\d+)  volume (\S+)  area (\S+)  moved (\S+) \(at most (\S+)\)$"
        states = np.array(re.findall(pattern, finished.stderr, re.MULTILINE), dtype=float)
        history = pcsmooth.denoise(sphere(), iterations=4).history
        expected = np.array([dataclasses.astuple(record) for record in history])
        np.testing.assert_allclose(states[:, :3], expected[:, :3], rtol=1e-7)
        np.testing.assert_allclose(states[:, 3:], expected[:, 3:], rtol=1e-2)
        assert "  moved " not in succeeds("denoise", scan, "-o", tmp_path / "2.ply").stderr

    @pytest.mark.parametrize("quiet", [[], ["-q"]])
    def test_json_is_alone_on_stdout(self, tmp_path: Path, scan: Path, quiet: list[str]) -> None:
        finished = succeeds(
            "denoise", scan, "-o", tmp_path / "out.ply", "--energy", "area", "--json", *quiet
        )
        result = pcsmooth.denoise(sphere(), energy="area")
        vectors = result.points - sphere()
        heights = np.sum(vectors * result.normals, axis=1)
        along = np.sqrt(np.mean(heights**2))
        across = np.sqrt(np.mean(np.sum(vectors**2, axis=1) - heights**2))
        facts = finished.json
        assert facts.pop("seconds") > 0
        assert facts == {
            "input": str(scan),
            "output": str(tmp_path / "out.ply"),
            "points": 150,
            "dimension": 3,
            "coordinates": ["x", "y", "z"],
            "not_finite": 0,
            "noise_class": 0,
            "fixed": 0,
            "tiles": None,
            "spacing": result.spacing,
            "radius": result.radius,
            "energy": "area",
            "weight": "cell",
            "step": result.step,
            "iterations": 6,
            "noise": None,
            "noise_range": None,
            "noise_ratio": None,
            "surface": None,
            "density_variation": None,
            "filter_support": None,
            "outliers": None,
            "at_limit": None,
            "sides": None,
            "volume_before": result.history[0].volume,
            "volume_after": result.history[-1].volume,
            "area_before": result.history[0].area,
            "area_after": result.history[-1].area,
            "mean_displacement": result.displacement.mean(),
            "max_displacement": result.displacement.max(),
            "rms_along_normal": pytest.approx(along, rel=1e-9),
            "rms_along_surface": pytest.approx(across, rel=1e-6),
            "noise_after": None,
            "normal_support": result.curvature.normal_support,
            "curvature_support": result.curvature.curvature_support,
            "orientation": {"outward": 1},
            "without_normal": 0,
            "mean_convention": "half",
            "median_abs_mean_curvature": np.median(np.abs(result.mean_curvature)),
            "outliers_as": "mark",
            "outliers_marked": True,
            "removed": 0,
            "scheme": "euler",
            "order": None,
            "motion": "free",
            "max_move": None,
            "keep_volume": False,
            "strength": 1.0,
            "stop": None,
            "gradient": "analytic",
            "stopped_early": False,
            "solver_iterations": [],
            "solver_error": 0.0,
            "rounding": 0.0,
        }
        assert (finished.stderr == "") == bool(quiet)

    def test_what_moves_otherwise_is_told(self, tmp_path: Path, scan: Path) -> None:
        finished = succeeds(
            "denoise", scan, "-o", tmp_path / "out.ply", "--scheme", "implicit",
            "--motion", "normal", "--keep-volume", "--max-move", "20%", "--stop", "0.3",
            "--iterations", 9, "--json",
        )  # fmt: skip
        result = pcsmooth.denoise(
            sphere(), scheme="implicit", motion="normal", keep_volume=True, max_move="20%",
            stop=0.3, iterations=9,
        )  # fmt: skip
        facts = finished.json
        assert facts["max_move"] == pytest.approx(0.2 * DIAGONAL)
        assert (facts["scheme"], facts["order"], facts["motion"]) == ("implicit", 2, "normal")
        assert (facts["keep_volume"], facts["stop"], facts["stopped_early"]) == (True, 0.3, True)
        assert facts["solver_iterations"] == list(result.solver_iterations)
        assert facts["iterations"] == len(facts["solver_iterations"]) < 9
        assert facts["solver_error"] == result.solver_error > 0
        assert result.plan is not None
        noise = result.plan.noise.deviation
        assert (facts["noise"], facts["outliers"]) == (noise, None)
        steps = len(result.solver_iterations)
        assert (
            f"  noise {noise:.4g}, {facts['noise_ratio']:.2g} of the local spacing "
            "sqrt(area/points)\n"
            f"  {steps} implicit steps of {result.step:.6g} on the volume, weight cell\n"
            f"  of order 2, {sum(result.solver_iterations)} solver iterations\n"
            f"  motion: along the normals, volume kept, at most {0.2 * DIAGONAL:.4g} in all\n"
            "  stopped: the last step moved the points by less than 0.3 spacings\n"
        ) in finished.stderr
        done, *_ = load_ply(tmp_path / "out.ply").comments
        assert (
            f"denoise scheme=implicit noise={noise:.9g} energy=volume weight=cell order=2 "
            f"step={result.step:.9g} iterations={steps} motion=normal "
            f"max_move={result.motion.max_move:.9g} keep_volume=yes stop=0.3 radius="
        ) in done

    def test_usual_motion_is_not_told(self, tmp_path: Path, scan: Path) -> None:
        finished = succeeds("denoise", scan, "-o", tmp_path / "out.ply")
        for words in ("implicit", "motion: ", "stopped", "solver", "outliers", "steps"):
            assert words not in finished.stderr
        done, *_ = load_ply(tmp_path / "out.ply").comments
        assert " denoise scheme=filter noise=" in done
        for name in ("energy", "weight", "order", "step", "iterations", "motion", "keep_volume"):
            assert f" {name}=" not in done

    @pytest.mark.slow
    def test_a_step_that_is_not_solved_is_an_error(self, tmp_path: Path, scan: Path) -> None:
        finished = pcsmooth_runs(
            "denoise", scan, "-o", tmp_path / "out.ply", "--scheme", "implicit", "--order", "1",
            "--polyhedron", "cube", "--step", "1e30",
        )  # fmt: skip
        assert finished.status == 1
        assert f"Error: {scan}: an implicit step has not been solved in " in finished.stderr
        assert finished.stderr.endswith("choose a shorter step\n")
        assert not (tmp_path / "out.ply").exists()

    def test_real_streams(self, tmp_path: Path, scan: Path) -> None:
        finished = forked("denoise", scan, "-o", tmp_path / "out.ply", "--json", "-v")
        assert finished.status == 0
        assert finished.json["points"] == 150
        assert finished.stderr.count("  moved ") == 2
        finished = forked(
            "denoise", scan, "-o", tmp_path / "flow.ply", "--json", "-v", "--scheme", "euler"
        )
        assert finished.stderr.count("  moved ") == 7
