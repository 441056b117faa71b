"""What `pcsmooth denoise` keeps of a file and adds to it, format by format, and its streams."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import plyfile
import pytest

import pcsmooth
from cli.clouds import (
    DATA,
    ENCODINGS,
    PLY_ESTIMATES,
    TEXT_CURVATURES,
    circle,
    load_ply,
    positions,
    save_ply,
    save_text,
    sphere,
    vertices,
)
from cli.commands import forked, succeeds

N = 150


def rich_ply(encoding: str, code: str = "f4") -> plyfile.PlyData:
    """A coloured mesh: x y z neither first nor together, a list, faces, comments, obj_info."""
    rng = np.random.default_rng(5)
    types: list[tuple[str, Any]] = [("red", "u1"), ("green", "u1"), ("blue", "u1"), ("x", code)]
    types += [("y", code), ("label", "i2"), ("z", code), ("hits", "O"), ("weight", "f8")]
    text, byte_order = ENCODINGS[encoding]
    vertex = np.empty(N, types)
    for name in ("red", "green", "blue"):
        vertex[name] = rng.integers(0, 256, N)
    for name, values in zip("xyz", sphere(N).T, strict=True):
        vertex[name] = values
    vertex["label"] = np.arange(N) - 70
    vertex["weight"] = rng.normal(size=N)
    if byte_order == ">":  # plyfile writes numbers beside lists as they are in memory
        for name in set(vertex.dtype.names or ()) - {"hits"}:
            vertex[name] = vertex[name].byteswap()
    vertex["hits"] = [np.arange(1 + row % 4, dtype="u2") for row in range(N)]
    face = np.empty(2, [("vertex_indices", "O"), ("flag", "u1")])
    face["vertex_indices"] = [np.array([0, 1, 2], "i4"), np.array([3, 4, 5, 6], "i4")]
    face["flag"] = [1, 255]
    return plyfile.PlyData(
        [
            plyfile.PlyElement.describe(vertex, "vertex", val_types={"hits": "u2"}),
            plyfile.PlyElement.describe(face, "face"),
        ],
        text=text,
        byte_order=byte_order,
        comments=["scanned by hand", "units are furlongs"],
        obj_info=["is_mesh 1"],
    )


@dataclass(frozen=True)
class Pair:
    """A rich file, before and after."""

    encoding: str
    code: str
    before: Any
    after: Any


@pytest.fixture(
    scope="module",
    params=[(encoding, code) for encoding in ENCODINGS for code in ("f4", "f8")],
    ids="-".join,
)
def pair(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Pair:
    folder = tmp_path_factory.mktemp("rich")
    encoding, code = request.param
    rich_ply(encoding, code).write(str(folder / "scan.ply"))
    succeeds("denoise", folder / "scan.ply", "-o", folder / "out.ply")
    return Pair(encoding, code, load_ply(folder / "scan.ply"), load_ply(folder / "out.ply"))


class TestPly:
    def test_encoding_names_and_types_are_those_of_the_input(self, pair: Pair) -> None:
        before, after = pair.before, pair.after
        assert (after.text, after.byte_order) == ENCODINGS[pair.encoding]
        described = [str(prop) for prop in after["vertex"].properties]
        kept = [str(prop) for prop in before["vertex"].properties]
        assert described == kept + [f"property float {name}" for name in PLY_ESTIMATES]

    def test_everything_but_the_positions_is_kept_in_order(self, pair: Pair) -> None:
        before, after = pair.before, pair.after
        for name in ("red", "green", "blue", "label", "weight"):
            np.testing.assert_array_equal(after["vertex"][name], before["vertex"][name])
        for old, new in zip(before["vertex"]["hits"], after["vertex"]["hits"], strict=True):
            np.testing.assert_array_equal(new, old)
        assert [str(element) for element in after.elements[1:]] == [str(before["face"])]
        for old, new in zip(before["face"], after["face"], strict=True):
            np.testing.assert_array_equal(new["vertex_indices"], old["vertex_indices"])
            assert new["flag"] == old["flag"]
        assert after.comments[:2] == before.comments
        assert after.obj_info == before.obj_info

    def test_positions_and_estimates_are_those_of_python(self, pair: Pair) -> None:
        result = pcsmooth.denoise(sphere(N).astype(pair.code))
        vertex = pair.after["vertex"]
        found = np.stack([vertex[name] for name in "xyz"], axis=1)
        np.testing.assert_array_equal(found, result.points.astype(pair.code))
        normals = np.stack([vertex[name] for name in ("nx", "ny", "nz")], axis=1)
        np.testing.assert_array_equal(normals, result.normals.astype("f4"))
        for name in ("quality", "scalar_mean_curvature", "curvature"):
            np.testing.assert_array_equal(vertex[name], result.mean_curvature.astype("f4"))
        np.testing.assert_array_equal(
            vertex["scalar_displacement"], result.displacement.astype("f4")
        )


class TestProvenance:
    def test_ply_says_what_was_done_with_units_and_signs(self, tmp_path: Path) -> None:
        cloud = save_ply(tmp_path / "scan.ply", vertices(sphere(), "f8"))
        succeeds(
            "denoise", cloud, "-o", tmp_path / "out.ply", "--scheme", "euler", "--energy", "area"
        )
        done, _, units, signs = load_ply(tmp_path / "out.ply").comments
        result = pcsmooth.denoise(sphere(), scheme="euler", energy="area")
        assert done == (
            f"pcsmooth {pcsmooth.__version__} denoise scheme=euler energy=area weight=cell "
            f"step={result.step:.9g} iterations=6 "
            f"radius={result.radius:.9g} spacing={result.spacing:.9g} "
            f"support={result.curvature.normal_support:.4g},"
            f"{result.curvature.curvature_support:.4g} orient=auto"
        )
        assert "coordinate units" in units
        assert "curvature in 1/unit, Gaussian curvature in 1/unit^2" in units
        assert "H=(k1+k2)/2" in signs
        assert "+1/R on a sphere with outward normals" in signs

    def test_ply_says_what_was_filtered(self, tmp_path: Path) -> None:
        cloud = save_ply(tmp_path / "scan.ply", vertices(sphere(), "f8"))
        succeeds("denoise", cloud, "-o", tmp_path / "out.ply")
        done, columns, _, _ = load_ply(tmp_path / "out.ply").comments
        result = pcsmooth.denoise(sphere())
        assert result.plan is not None
        assert done == (
            f"pcsmooth {pcsmooth.__version__} denoise scheme=filter "
            f"noise={result.plan.noise.deviation:.9g} "
            f"radius={result.radius:.9g} spacing={result.spacing:.9g} "
            f"support={result.curvature.normal_support:.4g},"
            f"{result.curvature.curvature_support:.4g} orient=auto"
        )
        assert columns.endswith(" scalar_displacement scalar_outlier")

    def test_signs_of_a_curve(self, tmp_path: Path) -> None:
        cloud = save_text(tmp_path / "curve.xy", circle())
        succeeds("denoise", cloud, "-o", tmp_path / "out.ply")
        assert "+1/R on a circle" in load_ply(tmp_path / "out.ply").comments[-1]

    def test_the_sign_is_as_said(self, tmp_path: Path) -> None:
        cloud = save_ply(tmp_path / "scan.ply", vertices(2 * sphere(2000, noise=0), "f8"))
        succeeds("denoise", cloud, "-o", tmp_path / "out.ply")
        vertex = load_ply(tmp_path / "out.ply")["vertex"]
        outward = sum(vertex["n" + axis] * vertex[axis] for axis in "xyz")
        assert (outward > 0).all()
        assert np.median(vertex["curvature"]) == pytest.approx(1 / 2, rel=0.1)


class TestChaining:
    def test_ply_twice_does_not_double_columns_or_units(self, tmp_path: Path) -> None:
        rich_ply("little").write(str(tmp_path / "scan.ply"))
        first, second = tmp_path / "1.ply", tmp_path / "2.ply"
        succeeds("denoise", tmp_path / "scan.ply", "-o", first, "--scheme", "euler")
        finished = succeeds("denoise", first, "-o", second, "--iterations", "3")
        assert "kept" not in finished.stderr
        before, after = load_ply(first), load_ply(second)
        assert [str(prop) for prop in after["vertex"].properties] == [
            str(prop) for prop in before["vertex"].properties
        ]
        normals = np.stack([before["vertex"][name] for name in ("nx", "ny", "nz")], axis=1)
        result = pcsmooth.denoise(positions(first), iterations=3, normals=normals)
        for name in ("quality", "scalar_mean_curvature", "curvature"):
            np.testing.assert_array_equal(after["vertex"][name], result.mean_curvature.astype("f4"))
        np.testing.assert_array_equal(after["vertex"]["nx"], result.normals[:, 0].astype("f4"))
        assert sum(" units: " in comment for comment in after.comments) == 1
        assert sum(" signs: " in comment for comment in after.comments) == 1
        runs = [comment for comment in after.comments if " denoise " in comment]
        assert [re.findall(r"iterations=(\d+)", run) for run in runs] == [["6"], ["3"]]

    @pytest.mark.parametrize("suffix", ["xyz", "txt", "asc", "csv", "pts", "xy"])
    def test_text_twice_does_not_double_columns(self, tmp_path: Path, suffix: str) -> None:
        points = circle() if suffix == "xy" else sphere()
        first, second = tmp_path / f"1.{suffix}", tmp_path / f"2.{suffix}"
        cloud = save_text(tmp_path / f"scan.{suffix}", points, "," if suffix == "csv" else " ")
        succeeds("denoise", cloud, "-o", first)
        succeeds("denoise", first, "-o", second)
        assert shape(second) == shape(first)

    def test_text_with_more_columns_twice_does_not_double_columns(self, tmp_path: Path) -> None:
        rows = [[*point, 9, 255, 0, 17] for point in sphere().tolist()]
        save_text(tmp_path / "scan.pts", rows)
        succeeds("denoise", tmp_path / "scan.pts", "-o", tmp_path / "1.pts")
        succeeds("denoise", tmp_path / "1.pts", "-o", tmp_path / "2.pts")
        assert shape(tmp_path / "2.pts") == shape(tmp_path / "1.pts")


def shape(path: Path) -> tuple[int, list[str], int]:
    """Number of lines, the first line if it is no row, and words in the last."""
    delimiter = "," if path.suffix == ".csv" else None
    lines = path.read_text().splitlines()
    head = [lines[0]] if any(letter.isalpha() for letter in lines[0]) else []
    return len(lines), head, len(lines[-1].split(delimiter))


class TestForeignNames:
    @pytest.fixture
    def confidence(self, tmp_path: Path) -> Path:
        """A scan whose `quality` is not a curvature."""
        quality = np.linspace(0, 1, N).astype("f4")
        return save_ply(tmp_path / "scan.ply", vertices(sphere(N), "f8", quality=quality))

    def test_quality_of_another_program_is_kept_and_announced(
        self, tmp_path: Path, confidence: Path
    ) -> None:
        finished = succeeds("denoise", confidence, "-o", tmp_path / "out.ply")
        vertex = load_ply(tmp_path / "out.ply")["vertex"]
        np.testing.assert_array_equal(vertex["quality"], load_ply(confidence)["vertex"]["quality"])
        estimate = pcsmooth.denoise(sphere(N)).mean_curvature.astype("f4")
        np.testing.assert_array_equal(vertex["scalar_mean_curvature"], estimate)
        np.testing.assert_array_equal(vertex["curvature"], estimate)
        assert "column 'quality' is the input's own and kept" in finished.stderr
        assert "column 'curvature'" not in finished.stderr

    def test_quality_of_another_program_is_kept_by_a_second_run(
        self, tmp_path: Path, confidence: Path
    ) -> None:
        succeeds("denoise", confidence, "-o", tmp_path / "1.ply")
        succeeds("denoise", tmp_path / "1.ply", "-o", tmp_path / "2.ply")
        np.testing.assert_array_equal(
            load_ply(tmp_path / "2.ply")["vertex"]["quality"],
            load_ply(confidence)["vertex"]["quality"],
        )

    def test_normals_are_replaced_in_their_place_and_type(self, tmp_path: Path) -> None:
        old = {name: np.full(N, 7.0) for name in ("nx", "ny", "nz")}
        cloud = save_ply(
            tmp_path / "scan.ply",
            vertices(sphere(N), "f8", **old, label=np.arange(N, dtype=np.int32)),
        )
        succeeds("denoise", cloud, "-o", tmp_path / "out.ply")
        vertex = load_ply(tmp_path / "out.ply")["vertex"]
        assert [prop.name for prop in vertex.properties][:7] == ["x", "y", "z", *old, "label"]
        assert vertex["nx"].dtype == np.float64
        given = np.full((N, 3), 7.0)
        expected = pcsmooth.denoise(sphere(N), normals=given).normals[:, 0].astype("f4")
        np.testing.assert_array_equal(vertex["nx"], expected)


SPACED = " ".join([*TEXT_CURVATURES, "displacement", "outlier"])
COMMAS, SEMICOLONS = SPACED.replace(" ", ","), SPACED.replace(" ", ";")

#: Suffix, lines before the rows, delimiter, columns after the position as they are spelled,
#: lines before the rows of the output, columns added.
DIALECTS = {
    "xyz": ("xyz", [], " ", [], [], 3),
    "xyz with more": ("xyz", [], " ", ["0.50", "12"], [], 3),
    "xyz with tabs": ("xyz", [], "\t", ["1e-3"], [], 3),
    "asc": ("asc", [], " ", [], [f"//X Y Z Nx Ny Nz {SPACED}"], 10),
    "txt with header": (
        "txt",
        ["//X Y Z R G B"],
        " ",
        ["255", "007", "0"],
        [f"//X Y Z R G B Nx Ny Nz {SPACED}"],
        10,
    ),
    "txt with header and count": (
        "txt",
        ["# made by hand", "//X Y Z Intensity", "150"],
        " ",
        ["0.10"],
        ["# made by hand", f"//X Y Z Intensity Nx Ny Nz {SPACED}", "150"],
        10,
    ),
    "txt with semicolons": (
        "txt",
        [],
        ";",
        ["3"],
        [f"//X;Y;Z;column_4;Nx;Ny;Nz;{SEMICOLONS}"],
        10,
    ),
    "csv": ("csv", [], ",", [], [f"x,y,z,nx,ny,nz,{COMMAS}"], 10),
    "csv with header": (
        "csv",
        ["X,Y,Z,Name,when"],
        ",",
        ["oak tree", "2021-05-03"],
        [f"X,Y,Z,Name,when,nx,ny,nz,{COMMAS}"],
        10,
    ),
    "csv quoted": (
        "csv",
        ['"X","Y","Z","note"'],
        ",",
        ['"left, lower"'],
        [f'"X","Y","Z","note",nx,ny,nz,{COMMAS}'],
        10,
    ),
    "pts": ("pts", ["150"], " ", ["-12", "1", "2", "3"], ["150"], 3),
}


@pytest.mark.parametrize(
    ("suffix", "head", "delimiter", "more", "new_head", "added"), DIALECTS.values(), ids=DIALECTS
)
def test_text_comes_back_as_it_was_written(
    tmp_path: Path,
    suffix: str,
    head: list[str],
    delimiter: str,
    more: list[str],
    new_head: list[str],
    added: int,
) -> None:
    cloud, out = tmp_path / f"scan.{suffix}", tmp_path / f"out.{suffix}"
    rows = [delimiter.join([*map(repr, point), *more]) for point in sphere().tolist()]
    cloud.write_text("\n".join([*head, *rows]) + "\n")
    succeeds("denoise", cloud, "-o", out)

    lines = out.read_text().splitlines()
    assert lines[: len(new_head)] == new_head
    result = pcsmooth.denoise(sphere())
    curvature = result.curvature
    estimates = np.column_stack(
        [
            curvature.normals,
            curvature.mean_curvature,
            curvature.gaussian_curvature,
            curvature.principal_curvatures,
            curvature.confidence,
            result.displacement,
            np.zeros(N) if result.outliers is None else result.outliers,
        ]
    )
    expected = [
        delimiter.join([*map(repr, point), *more, *map(str, estimate[:added])])
        for point, estimate in zip(result.points.tolist(), estimates.astype("f4"), strict=True)
    ]
    assert lines[len(new_head) :] == expected


def test_xy_gets_two_normals(tmp_path: Path) -> None:
    cloud = save_text(tmp_path / "curve.xy", circle())
    succeeds("denoise", cloud, "-o", tmp_path / "out.xy")
    result = pcsmooth.denoise(circle())
    expected = [
        " ".join([*map(repr, point), *map(str, normal)])
        for point, normal in zip(result.points.tolist(), result.normals.astype("f4"), strict=True)
    ]
    assert (tmp_path / "out.xy").read_text().splitlines() == expected


class TestConversion:
    def test_what_text_cannot_hold_is_named(self, tmp_path: Path) -> None:
        rich_ply("little").write(str(tmp_path / "scan.ply"))
        finished = succeeds("denoise", tmp_path / "scan.ply", "-o", tmp_path / "out.csv")
        (warning,) = [line for line in finished.stderr.splitlines() if "warning" in line]
        assert "csv files cannot hold" in warning
        for lost in ("element 'face' (2 rows)", "lists 'hits'", "the comments"):
            assert lost in warning
        header, *rows = (tmp_path / "out.csv").read_text().splitlines()
        assert len(rows) == N
        assert {"red", "green", "blue", "label", "weight", "nx"} <= set(header.split(","))

    def test_headerless_text_names_the_columns_it_drops(self, tmp_path: Path) -> None:
        cloud = save_ply(
            tmp_path / "s.ply", vertices(sphere(), "f8", label=np.arange(N, dtype=np.int32))
        )
        finished = succeeds("denoise", cloud, "-o", tmp_path / "out.xyz")
        assert "warning: xyz files cannot hold column 'label'" in finished.stderr
        words = (tmp_path / "out.xyz").read_text().splitlines()[0].split()
        assert len(words) == 6

    def test_text_to_ply_keeps_numbers(self, tmp_path: Path) -> None:
        rows: list[list[object]] = [["x", "y", "z", "id", "height"]]
        rows += [[*point, row, row / 4] for row, point in enumerate(sphere().tolist())]
        cloud = save_text(tmp_path / "scan.csv", rows, ",")
        finished = succeeds("denoise", cloud, "-o", tmp_path / "out.ply")
        assert "warning" not in finished.stderr
        vertex = load_ply(tmp_path / "out.ply")["vertex"]
        assert [prop.name for prop in vertex.properties] == [
            *("x", "y", "z", "id", "height"), *PLY_ESTIMATES
        ]  # fmt: skip
        np.testing.assert_array_equal(vertex["id"], np.arange(N))
        np.testing.assert_array_equal(vertex["height"], np.arange(N) / 4)

    def test_a_curve_becomes_flat_ply(self, tmp_path: Path) -> None:
        cloud = save_text(tmp_path / "curve.xy", circle())
        succeeds("denoise", cloud, "-o", tmp_path / "out.ply")
        vertex = load_ply(tmp_path / "out.ply")["vertex"]
        np.testing.assert_array_equal(vertex["z"], 0.0)
        np.testing.assert_array_equal(vertex["nz"], 0.0)


class TestStreams:
    @pytest.mark.parametrize("encoding", ENCODINGS)
    def test_ply_through_pipes_is_the_file(self, tmp_path: Path, encoding: str) -> None:
        rich_ply(encoding).write(str(tmp_path / "scan.ply"))
        succeeds("denoise", tmp_path / "scan.ply", "-o", tmp_path / "out.ply")
        data = (tmp_path / "scan.ply").read_bytes()
        finished = succeeds("denoise", "-", "-o", "-", stdin=data)
        assert finished.stdout == (tmp_path / "out.ply").read_bytes()
        assert "<stdin>: 150 points in 3D" in finished.stderr

    @pytest.mark.parametrize("delimiter", [" ", ",", ";", "\t"])
    def test_text_through_pipes_is_the_txt_file(self, tmp_path: Path, delimiter: str) -> None:
        cloud = save_text(tmp_path / "scan.txt", sphere(), delimiter)
        succeeds("denoise", cloud, "-o", tmp_path / "out.txt")
        finished = succeeds("denoise", "-", "-o", "-", stdin=cloud.read_bytes())
        assert finished.stdout == (tmp_path / "out.txt").read_bytes()

    def test_a_file_to_stdout_keeps_its_format(self, tmp_path: Path) -> None:
        cloud = save_text(tmp_path / "scan.xyz", sphere())
        succeeds("denoise", cloud, "-o", tmp_path / "out.xyz")
        finished = succeeds("denoise", cloud, "-o", "-")
        assert finished.stdout == (tmp_path / "out.xyz").read_bytes()

    def test_stdin_to_a_file_takes_the_suffix(self, tmp_path: Path) -> None:
        cloud = save_text(tmp_path / "scan.txt", sphere())
        succeeds("denoise", "-", "-o", tmp_path / "out.ply", stdin=cloud.read_bytes())
        np.testing.assert_array_equal(
            positions(tmp_path / "out.ply"), pcsmooth.denoise(sphere()).points
        )


@pytest.mark.slow
def test_the_shipped_scan(tmp_path: Path) -> None:
    scan = DATA / "scans/kinect_milk.ply"
    finished = forked("denoise", scan, "-o", tmp_path / "out.ply", "--json", "-q")
    assert (finished.status, finished.stderr) == (0, "")
    facts = finished.json
    assert facts["points"] == 13_704
    assert facts["volume_after"] < facts["volume_before"]
    assert 0 < facts["mean_displacement"] < facts["spacing"] / 2
    assert np.isfinite(positions(tmp_path / "out.ply")).all()
