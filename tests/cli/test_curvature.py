"""`pcsmooth curvature`: what it writes, keeps and says."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import pcsmooth
from cli.clouds import (
    DATA,
    ENCODINGS,
    PLY_CURVATURES,
    TEXT_CURVATURES,
    Points,
    circle,
    load_ply,
    positions,
    save_ply,
    save_text,
    sphere,
    vertices,
)
from cli.commands import forked, succeeds
from pcsmooth import CurvatureEstimate, estimate_curvature

OPTIONS: dict[str, tuple[list[str], dict[str, Any]]] = {
    "defaults": ([], {}),
    "radius": (["--radius", "3x"], {"radius": "3x"}),
    "local radius": (["--radius", "local:1.5x"], {"radius": "local:1.5x"}),
    "support": (["--support", "40"], {"support": 40}),
    "gradient": (["--estimator", "gradient"], {"estimator": "gradient"}),
    "report on the area": (
        ["--estimator", "gradient", "--energy", "area"],
        {"estimator": "gradient", "energy": "area"},
    ),
    "propagate": (["--orient", "propagate"], {"orient": "propagate"}),
    "threads": (["--threads", "1"], {"threads": 1}),
}


def columns_of(estimate: CurvatureEstimate, factor: float = 1.0) -> dict[str, Points]:
    """What PLY should hold, by column."""
    dimension = estimate.normals.shape[1]
    columns = dict.fromkeys(("nx", "ny", "nz"), np.zeros(len(estimate.normals)))
    columns.update(zip(("nx", "ny", "nz"), estimate.normals.T, strict=False))
    means = ("quality", "scalar_mean_curvature", "curvature")
    columns.update(dict.fromkeys(means, factor * estimate.mean_curvature))
    if dimension == 3 and not np.isnan(estimate.gaussian_curvature).any():
        columns["scalar_gaussian_curvature"] = estimate.gaussian_curvature
        columns["scalar_k1"], columns["scalar_k2"] = estimate.principal_curvatures.T
    columns["scalar_confidence"] = estimate.confidence
    return columns


def check_columns(path: Path, expected: dict[str, Points], *before: str) -> None:
    """Check the columns of a PLY file, all of them but those before."""
    vertex = load_ply(path)["vertex"]
    names = [prop.name for prop in vertex.properties]
    assert names == ["x", "y", "z", *before, *expected]
    for name, values in expected.items():
        assert vertex[name].dtype == np.float32
        np.testing.assert_array_equal(vertex[name], values.astype(np.float32))


@pytest.fixture
def scan(tmp_path: Path) -> Path:
    """A sphere as double PLY."""
    return save_ply(tmp_path / "scan.ply", vertices(sphere(), "f8"))


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """Where to write."""
    return tmp_path / "out.ply"


@pytest.mark.parametrize(("arguments", "keywords"), OPTIONS.values(), ids=OPTIONS)
@pytest.mark.parametrize("points", [circle(), sphere()], ids=["2D", "3D"])
def test_options_mean_what_they_mean_in_python(
    tmp_path: Path, out: Path, points: Points, arguments: list[str], keywords: dict[str, Any]
) -> None:
    cloud = save_text(tmp_path / "cloud.txt", points)
    succeeds("curvature", cloud, "-o", out, *arguments)
    check_columns(out, columns_of(estimate_curvature(points, **keywords)))
    np.testing.assert_array_equal(positions(out)[:, : points.shape[1]], points)


def test_a_sphere_has_its_curvatures(tmp_path: Path, out: Path) -> None:
    cloud = save_ply(tmp_path / "scan.ply", vertices(2 * sphere(2000, noise=0), "f4"))
    succeeds("curvature", cloud, "-o", out)
    vertex = load_ply(out)["vertex"]
    assert (sum(vertex["n" + axis] * vertex[axis] for axis in "xyz") > 0).all()
    for name, value in (("mean_curvature", 1 / 2), ("gaussian_curvature", 1 / 4), ("k1", 1 / 2)):
        assert np.median(vertex["scalar_" + name]) == pytest.approx(value, rel=0.1)
    assert np.median(vertex["scalar_confidence"]) > 0.9


class TestPositions:
    UTM = np.array([432_100.25, 5_412_300.5, 210.0])

    @pytest.mark.parametrize("encoding", ENCODINGS)
    @pytest.mark.parametrize("code", ["f4", "f8"])
    @pytest.mark.parametrize("offset", [0 * UTM, UTM], ids=["near", "far"])
    def test_they_keep_every_byte(
        self, tmp_path: Path, out: Path, encoding: str, code: str, offset: Points
    ) -> None:
        points = 10 * sphere() + offset
        points[[3, 77]] = [[np.nan] * 3, [0.5, np.inf, -0.0]]
        labels = np.arange(150, dtype=np.int32)
        element = vertices(points, code, label=labels)
        cloud = save_ply(tmp_path / "scan.ply", element, encoding=encoding)
        finished = succeeds("curvature", cloud, "-o", out, "--json")
        after = load_ply(out)
        assert (after.text, after.byte_order) == ENCODINGS[encoding]
        assert positions(out).dtype.newbyteorder("=") == np.dtype(code)
        assert positions(out).tobytes() == positions(cloud).tobytes()
        np.testing.assert_array_equal(after["vertex"]["label"], labels)
        assert "warning" not in finished.stderr
        assert "150 points in 3D, 2 not finite (passed through)" in finished.stderr
        assert finished.json["not_finite"] == 2
        broken = ~np.isfinite(points).all(axis=1)
        for name in PLY_CURVATURES:
            values = after["vertex"][name]
            np.testing.assert_array_equal(values[broken], 0.0)
            assert np.isfinite(values).all()

    @pytest.mark.parametrize("suffix", ["xyz", "csv", "txt"])
    def test_text_holds_the_same_numbers(self, tmp_path: Path, suffix: str) -> None:
        delimiter = "," if suffix == "csv" else " "
        cloud = save_text(tmp_path / f"scan.{suffix}", sphere(), delimiter)
        out = tmp_path / f"out.{suffix}"
        succeeds("curvature", cloud, "-o", out)
        rows = out.read_text().splitlines()[0 if suffix == "xyz" else 1 :]
        before = cloud.read_text().splitlines()
        assert [row.split(delimiter)[:3] for row in rows] == [
            row.split(delimiter) for row in before
        ]

    def test_rounding_to_float_is_warned_about_against_the_spacing(
        self, tmp_path: Path, out: Path
    ) -> None:
        cloud = save_ply(tmp_path / "utm.ply", vertices(10 * sphere() + self.UTM, "f8"))
        finished = succeeds("curvature", cloud, "-o", out, "--float")
        assert re.search(
            r"warning: float positions round .* against a mean spacing of", finished.stderr
        )
        assert "warning" not in succeeds("curvature", cloud, "-o", "-").stderr

    def test_whole_numbers_become_double(self, tmp_path: Path, out: Path) -> None:
        points = np.round(100 * sphere())
        cloud = save_ply(tmp_path / "scan.ply", vertices(points, "i4"))
        finished = succeeds("curvature", cloud, "-o", out)
        assert "int32 in the input; they are written as double" in finished.stderr
        np.testing.assert_array_equal(positions(out), points)

    def test_points_without_neighbours_are_counted(self, tmp_path: Path, out: Path) -> None:
        points = np.vstack([sphere(), [[50.0, 0.0, 0.0]]])
        cloud = save_ply(tmp_path / "scan.ply", vertices(points, "f8"))
        finished = succeeds("curvature", cloud, "-o", out, "--radius", "0.5", "--json")
        assert finished.json["without_normal"] == 1
        assert "; 1 point without normal" in finished.stderr
        assert load_ply(out)["vertex"]["curvature"][-1] == 0.0


class TestDimensions:
    @pytest.mark.parametrize("height", [0.0, 7.25])
    def test_dim_2_keeps_the_third_coordinate(
        self, tmp_path: Path, out: Path, height: float
    ) -> None:
        points = np.column_stack([circle(), np.full(60, height)])
        cloud = save_ply(tmp_path / "plane.ply", vertices(points, "f8"))
        finished = succeeds("curvature", cloud, "-o", out, "--dim", "2", "--json")
        assert finished.json["dimension"] == 2
        assert finished.json["mean_convention"] is None
        assert "  median |k| " in finished.stderr
        np.testing.assert_array_equal(positions(out), points)
        check_columns(out, columns_of(estimate_curvature(circle())))

    def test_a_curve_in_text(self, tmp_path: Path) -> None:
        cloud = save_text(tmp_path / "curve.csv", circle(), ",")
        succeeds("curvature", cloud, "-o", tmp_path / "out.csv")
        header = (tmp_path / "out.csv").read_text().splitlines()[0]
        assert header == "x,y,nx,ny,mean_curvature,confidence"


#: Columns of a scan by dialect.
DIALECTS = {
    "generic": PLY_CURVATURES,
    "meshlab": ["nx", "ny", "nz", "quality"],
    "cloudcompare": [
        *("nx", "ny", "nz", "scalar_mean_curvature", "scalar_gaussian_curvature"),
        *("scalar_k1", "scalar_k2", "scalar_confidence"),
    ],
    "pcl": ["nx", "ny", "nz", "curvature"],
}


@pytest.mark.parametrize("command", ["curvature", "denoise"])
class TestDialects:
    @pytest.mark.parametrize("dialect", DIALECTS)
    def test_columns(self, scan: Path, out: Path, command: str, dialect: str) -> None:
        succeeds(command, scan, "-o", out, "--dialect", dialect)
        names = [prop.name for prop in load_ply(out)["vertex"].properties]
        moved = command == "denoise" and dialect in ("generic", "cloudcompare")
        moves = ["scalar_displacement", "scalar_outlier"] if moved else []
        assert names == ["x", "y", "z", *DIALECTS[dialect], *moves]

    @pytest.mark.parametrize("dialect", DIALECTS)
    def test_text_is_the_same_in_all(
        self, tmp_path: Path, scan: Path, command: str, dialect: str
    ) -> None:
        for name, options in (("a.csv", []), ("b.csv", ["--dialect", dialect])):
            succeeds(command, scan, "-o", tmp_path / name, *options)
        assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()

    @pytest.mark.parametrize(
        ("options", "type_name"),
        [([], np.float32), (["--double"], np.float64), (["--float"], np.float32)],
        ids=["pcl", "double", "float"],
    )
    def test_pcl_gets_float_positions_unless_told_otherwise(
        self, scan: Path, out: Path, command: str, options: list[str], type_name: type
    ) -> None:
        succeeds(command, scan, "-o", out, "--dialect", "pcl", *options)
        assert positions(out).dtype == type_name

    def test_pcl_warns_of_what_its_floats_lose(
        self, tmp_path: Path, out: Path, command: str
    ) -> None:
        points = 10 * sphere() + TestPositions.UTM
        cloud = save_ply(tmp_path / "utm.ply", vertices(points, "f8"))
        finished = succeeds(command, cloud, "-o", out, "--dialect", "pcl")
        assert "warning: float positions round" in finished.stderr

    def test_the_columns_of_another_dialect_do_not_go_stale(
        self, tmp_path: Path, scan: Path, out: Path, command: str
    ) -> None:
        succeeds("curvature", scan, "-o", tmp_path / "1.ply")
        finished = succeeds(command, tmp_path / "1.ply", "-o", out, "--dialect", "meshlab")
        names = [prop.name for prop in load_ply(out)["vertex"].properties]
        assert names == ["x", "y", "z", *DIALECTS["meshlab"]]
        left = [name for name in PLY_CURVATURES if name not in DIALECTS["meshlab"]]
        assert f"columns of an earlier run are left out: {', '.join(left)}\n" in finished.stderr


@pytest.mark.parametrize("command", ["curvature", "denoise"])
class TestConvention:
    @pytest.mark.parametrize(
        ("convention", "formula", "factor"), [("half", "(k1+k2)/2", 1.0), ("sum", "k1+k2", 2.0)]
    )
    def test_ply_json_and_summary_agree(
        self, scan: Path, out: Path, command: str, convention: str, formula: str, factor: float
    ) -> None:
        finished = succeeds(command, scan, "-o", out, "--mean-convention", convention, "--json")
        vertex = load_ply(out)["vertex"]
        estimate = (
            estimate_curvature(sphere())
            if command == "curvature"
            else pcsmooth.denoise(sphere()).curvature
        )
        mean = factor * estimate.mean_curvature
        for name in ("quality", "scalar_mean_curvature", "curvature"):
            np.testing.assert_array_equal(vertex[name], mean.astype("f4"))
        assert f" H={formula}, positive" in load_ply(out).comments[-1]
        median = np.median(np.abs(mean))
        assert finished.json["mean_convention"] == convention
        assert finished.json["median_abs_mean_curvature"] == median
        assert f"  median |H| {median:.4g}, H={formula}\n" in finished.stderr

    def test_text(self, tmp_path: Path, scan: Path, command: str) -> None:
        tables = []
        for convention in ("half", "sum"):
            path = tmp_path / f"{convention}.csv"
            succeeds(command, scan, "-o", path, "--mean-convention", convention)
            tables.append(np.genfromtxt(path, delimiter=",", names=True))
        half, both = tables
        np.testing.assert_allclose(both["mean_curvature"], 2 * half["mean_curvature"], rtol=1e-6)
        np.testing.assert_array_equal(both["k1"], half["k1"])

    def test_the_last_run_decides(
        self, tmp_path: Path, scan: Path, out: Path, command: str
    ) -> None:
        succeeds("curvature", scan, "-o", tmp_path / "1.ply", "--mean-convention", "sum")
        succeeds(command, tmp_path / "1.ply", "-o", out)
        signs = [comment for comment in load_ply(out).comments if " signs: " in comment]
        assert len(signs) == 1
        assert "H=(k1+k2)/2" in signs[0]


#: Options, keywords, and where the normals of a flat sheet then point along z.
RULES: dict[str, tuple[list[str], dict[str, Any], int]] = {
    "auto": ([], {}, 1),
    "direction": (["--orient", "direction=0,0,-1"], {"orient": "direction=0,0,-1"}, -1),
    "viewpoint": (["--orient", "viewpoint=3, 4,-50"], {"orient": "viewpoint=3,4,-50"}, -1),
}


class TestOrientation:
    @staticmethod
    def sheet() -> Points:
        rng = np.random.default_rng(4)
        return np.asarray(rng.random((400, 3)) * [10, 10, 0.1] + np.array([1000.0, 2000.0, 0.0]))

    def cloud(self, folder: Path, normal: float | None = None) -> Path:
        columns: dict[str, npt.NDArray[Any]] = {}
        if normal is not None:
            columns = dict.fromkeys(("nx", "ny"), np.zeros(400, "f4"))
            columns["nz"] = np.full(400, normal, "f4")
        return save_ply(folder / "sheet.ply", vertices(self.sheet(), "f8", **columns))

    @pytest.mark.parametrize(("options", "keywords", "sign"), RULES.values(), ids=RULES)
    def test_rules(
        self, tmp_path: Path, out: Path, options: list[str], keywords: dict[str, Any], sign: int
    ) -> None:
        succeeds("curvature", self.cloud(tmp_path), "-o", out, *options)
        estimate = estimate_curvature(self.sheet(), **keywords)
        check_columns(out, columns_of(estimate))
        assert (sign * load_ply(out)["vertex"]["nz"] > 0).all()

    @pytest.mark.parametrize("command", ["curvature", "denoise"])
    @pytest.mark.parametrize("options", [[], ["--orient", "input"]], ids=["auto", "input"])
    @pytest.mark.parametrize("normal", [1.0, -1.0])
    def test_normals_of_the_input_are_followed(
        self, tmp_path: Path, out: Path, command: str, options: list[str], normal: float
    ) -> None:
        cloud = self.cloud(tmp_path, normal)
        finished = succeeds(command, cloud, "-o", out, *options, "--json")
        assert (normal * load_ply(out)["vertex"]["nz"] > 0).all()
        assert set(finished.json["orientation"]) == {"input"}
        assert re.search(r"  normals: 1 component as in the input\n", finished.stderr)

    @pytest.mark.parametrize("suffix", ["csv", "xyz", "txt"])
    def test_normals_of_text_are_followed(self, tmp_path: Path, out: Path, suffix: str) -> None:
        delimiter = "," if suffix == "csv" else " "
        rows: list[list[object]] = [["x", "y", "z", "Nx", "Ny", "Nz"]] if suffix != "xyz" else []
        rows += [[*point, 0, 0, -1] for point in self.sheet().tolist()]
        cloud = save_text(tmp_path / f"sheet.{suffix}", rows, delimiter)
        succeeds("curvature", cloud, "-o", out, "--orient", "input")
        assert (load_ply(out)["vertex"]["nz"] < 0).all()

    def test_a_rule_comes_before_the_normals_of_the_input(self, tmp_path: Path, out: Path) -> None:
        cloud = self.cloud(tmp_path, -1.0)
        succeeds("curvature", cloud, "-o", out, "--orient", "direction=0,0,1")
        assert (load_ply(out)["vertex"]["nz"] > 0).all()

    def test_components_are_counted_by_reason(self, tmp_path: Path, out: Path) -> None:
        points = np.vstack([sphere(), sphere() + 9.0, self.sheet()])
        cloud = save_text(tmp_path / "scan.txt", points)
        finished = succeeds("curvature", cloud, "-o", out, "--radius", "0.6", "--json")
        counts = finished.json["orientation"]
        assert counts == estimate_curvature(points, radius=0.6).orientation
        assert counts["outward"] >= 2
        assert f"{counts['outward']}" in finished.stderr.split("normals: ")[1]
        assert " outward" in finished.stderr

    def test_the_comment_holds_the_rule_without_spaces(self, tmp_path: Path, out: Path) -> None:
        rule = " viewpoint=1,\n2, -3 "
        succeeds("curvature", self.cloud(tmp_path), "-o", out, "--orient", rule)
        assert load_ply(out).comments[0].endswith(" orient=viewpoint=1,2,-3")


class TestComments:
    def test_ply_says_what_was_done(self, scan: Path, out: Path) -> None:
        succeeds("curvature", scan, "-o", out)
        done, columns, units, signs = load_ply(out).comments
        estimate = estimate_curvature(sphere())
        assert done == (
            f"pcsmooth {pcsmooth.__version__} curvature estimator=cells "
            f"radius={estimate.radius:.9g} spacing={estimate.spacing:.9g} "
            f"support={estimate.normal_support:.4g},{estimate.curvature_support:.4g} orient=auto"
        )
        assert columns == "pcsmooth columns: " + " ".join(PLY_CURVATURES)
        assert "Gaussian curvature in 1/unit^2" in units
        assert "+1/R on a sphere" in signs

    def test_the_report_is_named(self, scan: Path, out: Path) -> None:
        succeeds("curvature", scan, "-o", out, "--estimator", "gradient", "--energy", "area")
        comment = load_ply(out).comments[0]
        estimate = estimate_curvature(sphere())
        assert "curvature estimator=gradient energy=area radius=" in comment
        assert f" support={estimate.normal_support:.4g} orient=auto" in comment


class TestChaining:
    def test_twice_is_once(self, tmp_path: Path, scan: Path, out: Path) -> None:
        succeeds("curvature", scan, "-o", tmp_path / "1.ply")
        finished = succeeds("curvature", tmp_path / "1.ply", "-o", out)
        assert "kept" not in finished.stderr
        first, second = load_ply(tmp_path / "1.ply"), load_ply(out)
        assert first["vertex"].data.tobytes() == second["vertex"].data.tobytes()
        assert second.comments == [first.comments[0], *first.comments]

    def test_the_displacement_of_a_denoised_cloud_stays(
        self, tmp_path: Path, scan: Path, out: Path
    ) -> None:
        succeeds("denoise", scan, "-o", tmp_path / "1.ply")
        finished = succeeds("curvature", tmp_path / "1.ply", "-o", out)
        assert "left out" not in finished.stderr
        moved = load_ply(tmp_path / "1.ply")["vertex"]["scalar_displacement"]
        np.testing.assert_array_equal(load_ply(out)["vertex"]["scalar_displacement"], moved)
        assert "scalar_outlier" in load_ply(out)["vertex"]
        succeeds("denoise", out, "-o", tmp_path / "3.ply", "--iterations", "1")
        again = load_ply(tmp_path / "3.ply")["vertex"]["scalar_displacement"]
        assert (again < moved).any()
        assert (again != moved).all()

    def test_the_principal_curvatures_of_another_estimator_are_left_out(
        self, tmp_path: Path, scan: Path, out: Path
    ) -> None:
        succeeds("curvature", scan, "-o", tmp_path / "1.ply")
        finished = succeeds("curvature", tmp_path / "1.ply", "-o", out, "--estimator", "gradient")
        assert (
            "columns of an earlier run are left out: scalar_gaussian_curvature, scalar_k1, "
            "scalar_k2\n"
        ) in finished.stderr
        assert "scalar_k1" not in {prop.name for prop in load_ply(out)["vertex"].properties}

    def test_the_report_leaves_stale_columns_out_of_text(self, tmp_path: Path) -> None:
        cloud = save_text(tmp_path / "scan.csv", sphere(), ",")
        succeeds("curvature", cloud, "-o", tmp_path / "1.csv")
        header = (tmp_path / "1.csv").read_text().splitlines()[0]
        assert header == ",".join(["x,y,z,nx,ny,nz", *TEXT_CURVATURES])
        report = ["--estimator", "gradient"]
        succeeds("curvature", tmp_path / "1.csv", "-o", tmp_path / "2.csv", *report)
        header = (tmp_path / "2.csv").read_text().splitlines()[0]
        assert header == "x,y,z,nx,ny,nz,mean_curvature,confidence"

    def test_a_confidence_of_another_program_is_kept_in_text(self, tmp_path: Path) -> None:
        rows: list[list[object]] = [["x", "y", "z", "confidence"]]
        rows += [[*point, "high"] for point in sphere().tolist()]
        cloud = save_text(tmp_path / "scan.csv", rows, ",")
        for source, target in ((cloud, "1.csv"), (tmp_path / "1.csv", "2.csv")):
            finished = succeeds("curvature", source, "-o", tmp_path / target)
            assert "column 'confidence' is the input's own and kept" in finished.stderr
            lines = (tmp_path / target).read_text().splitlines()
            assert {line.split(",")[3] for line in lines[1:]} == {"high"}

    def chain(self, folder: Path, suffix: str) -> list[bytes]:
        """What is in a file, in the one after `curvature`, and in the one after `denoise`."""
        cloud, one, two = (folder / f"{number}.{suffix}" for number in range(3))
        if suffix == "ply":
            save_ply(cloud, vertices(sphere(), "f4"), encoding="big")
        else:
            save_text(cloud, sphere())
        succeeds("curvature", cloud, "-o", one, "--colormap", "coolwarm")
        succeeds("denoise", one, "-o", two)
        return [path.read_bytes() for path in (cloud, one, two)]

    @pytest.mark.parametrize("suffix", ["ply", "txt"])
    def test_streams_are_a_chain_of_files(self, tmp_path: Path, suffix: str) -> None:
        cloud, one, two = self.chain(tmp_path, suffix)
        colored = ["--colormap", "coolwarm"]
        assert succeeds("curvature", "-", "-o", "-", "-q", *colored, stdin=cloud).stdout == one
        assert succeeds("denoise", "-", "-o", "-", "-q", stdin=one).stdout == two

    @pytest.mark.slow
    def test_pipes_of_a_shell_are_a_chain_of_files(self, tmp_path: Path) -> None:
        *_, expected = self.chain(tmp_path, "ply")
        program = f"'{sys.executable}' -m pcsmooth"
        done = subprocess.run(
            [
                *("bash", "-o", "pipefail", "-c"),
                f"cat 0.ply | {program} curvature - -o - -q --colormap coolwarm "
                f"| {program} denoise - -o - -q > out",
            ],
            cwd=tmp_path,
            capture_output=True,
            timeout=300,
        )
        assert (done.returncode, done.stderr) == (0, b"")
        assert (tmp_path / "out").read_bytes() == expected

    def test_xyz_through_pipes(self, tmp_path: Path) -> None:
        cloud = save_text(tmp_path / "scan.xyz", sphere())
        data = succeeds("curvature", cloud, "-o", "-").stdout
        assert {len(line.split(b" ")) for line in data.splitlines()} == {6}
        finished = succeeds("denoise", "-", "-o", tmp_path / "out.xyz", "--json", stdin=data)
        assert finished.json["orientation"] == {"input": 1}


class TestMessages:
    def test_summary(self, scan: Path, out: Path) -> None:
        finished = succeeds("curvature", scan, "-o", out)
        assert finished.stdout == b""
        estimate = estimate_curvature(sphere())
        assert finished.stderr.startswith(
            f"{scan}: 150 points in 3D\n"
            f"  radius {estimate.radius:.6g} (2x the mean spacing {estimate.spacing:.6g}), "
            "estimator cells\n"
            f"  normals from {estimate.normal_support:.0f} points, "
            f"curvature from {estimate.curvature_support:.0f}\n"
            "  normals: 1 component outward\n"
            f"  median |H| {np.median(np.abs(estimate.mean_curvature)):.4g}, H=(k1+k2)/2\n"
            f"  wrote {out} in "
        )

    def test_the_report_has_no_support_for_curvature(self, scan: Path, out: Path) -> None:
        finished = succeeds("curvature", scan, "-o", out, "--estimator", "gradient", "--json")
        assert ", estimator gradient on the volume\n" in finished.stderr
        assert re.search(r"  normals from \d+ points\n", finished.stderr)
        facts = finished.json
        assert (facts["energy"], facts["curvature_support"]) == ("volume", None)

    @pytest.mark.parametrize("quiet", [[], ["-q"]])
    def test_json_is_alone_on_stdout(self, scan: Path, out: Path, quiet: list[str]) -> None:
        finished = succeeds("curvature", scan, "-o", out, "--json", *quiet)
        estimate = estimate_curvature(sphere())
        facts = finished.json
        assert facts.pop("seconds") > 0
        assert facts == {
            "input": str(scan),
            "output": str(out),
            "points": 150,
            "dimension": 3,
            "coordinates": ["x", "y", "z"],
            "not_finite": 0,
            "noise_class": 0,
            "tiles": None,
            "estimator": "cells",
            "energy": None,
            "spacing": estimate.spacing,
            "radius": estimate.radius,
            "normal_support": estimate.normal_support,
            "curvature_support": estimate.curvature_support,
            "orientation": {"outward": 1},
            "without_normal": 0,
            "mean_convention": "half",
            "median_abs_mean_curvature": np.median(np.abs(estimate.mean_curvature)),
            "rounding": 0.0,
        }
        assert (finished.stderr == "") == bool(quiet)

    def test_verbose_prints_quantiles(self, scan: Path, out: Path) -> None:
        finished = succeeds("curvature", scan, "-o", out, "-v")
        lines = [line.split() for line in finished.stderr.splitlines()]
        (head,) = (line for line in lines if line[0] == "quantiles")
        assert head[1:] == ["5%", "25%", "50%", "75%", "95%"]
        start = lines.index(head) + 1
        rows = {line[0]: [float(word) for word in line[1:]] for line in lines[start : start + 5]}
        assert list(rows) == ["mean", "gaussian", "k1", "k2", "confidence"]
        expected = np.quantile(estimate_curvature(sphere()).mean_curvature, [0.05, 0.5, 0.95])
        np.testing.assert_allclose(rows["mean"][::2], expected, rtol=1e-3)
        assert "  quantiles " not in succeeds("curvature", scan, "-o", "-").stderr

    def test_the_number_of_threads_does_not_change_a_byte(self, tmp_path: Path) -> None:
        cloud = save_ply(tmp_path / "scan.ply", vertices(sphere(4000), "f8"))
        outputs = []
        for threads in (1, 2):
            path = tmp_path / f"{threads}.ply"
            succeeds("curvature", cloud, "-o", path, "--threads", threads)
            outputs.append(path.read_bytes())
        assert outputs[0] == outputs[1]

    def test_overwrite(self, scan: Path) -> None:
        points = positions(scan)
        succeeds("curvature", scan, "-o", scan, "--overwrite")
        assert positions(scan).tobytes() == points.tobytes()
        assert "curvature" in {prop.name for prop in load_ply(scan)["vertex"].properties}


class TestColors:
    NAMES = ("red", "green", "blue")

    def colors(self, path: Path) -> npt.NDArray[np.uint8]:
        vertex = load_ply(path)["vertex"]
        assert {str(prop) for prop in vertex.properties if prop.name in self.NAMES} == {
            f"property uchar {name}" for name in self.NAMES
        }
        return np.stack([vertex[name] for name in self.NAMES], axis=1)

    @pytest.mark.parametrize("command", ["curvature", "denoise"])
    def test_blue_is_hollow_and_red_is_round(self, tmp_path: Path, out: Path, command: str) -> None:
        cloud = save_ply(tmp_path / "scan.ply", vertices(sphere(1000, noise=0), "f4"))
        for rule, red in (("outward", True), ("viewpoint=0,0,0", False)):
            options = ["--colormap", "coolwarm", "--orient", rule, "--overwrite"]
            succeeds(command, cloud, "-o", out, *options)
            colors = self.colors(out).astype(int)
            assert ((colors[:, 0] > colors[:, 2]) == red).all()

    def test_the_range_is_said_and_kept(self, scan: Path, out: Path) -> None:
        finished = succeeds("curvature", scan, "-o", out, "--colormap", "RdBu", "--color-by", "k2")
        limit = np.percentile(np.abs(estimate_curvature(sphere()).principal_curvatures[:, 1]), 98)
        text = f"colors: k2 from {-limit:.4g} to {limit:.4g} by RdBu"
        assert text + "\n" in finished.stderr
        assert load_ply(out).comments[-1] == "pcsmooth " + text

    @pytest.mark.parametrize("column", ["mean", "gaussian", "k1", "k2", "confidence"])
    def test_every_estimate_can_be_shown(self, tmp_path: Path, out: Path, column: str) -> None:
        egg = sphere(600) * [1.0, 2.0, 4.0]
        scan = save_ply(tmp_path / "egg.ply", vertices(egg, "f4"))
        options = ["--colormap", "gray", "--color-by", column]
        succeeds("curvature", scan, "-o", out, *options)
        name = {"mean": "mean_curvature", "gaussian": "gaussian_curvature"}.get(column, column)
        values = load_ply(out)["vertex"]["scalar_" + name]
        colors = self.colors(out)
        shade = colors[np.argsort(values, kind="stable"), 0].astype(int)
        assert (np.diff(shade) >= 0).all()
        assert len(set(shade)) > 10
        if column == "confidence":
            np.testing.assert_allclose(colors[:, 0], 255 * values, atol=1.5)

    def test_points_without_normal_are_grey(self, tmp_path: Path, out: Path) -> None:
        points = np.vstack([sphere(), [[50.0, 0.0, 0.0], [np.nan, 0, 0]]])
        cloud = save_ply(tmp_path / "scan.ply", vertices(points, "f8"))
        succeeds("curvature", cloud, "-o", out, "--radius", "0.5", "--colormap", "viridis")
        np.testing.assert_array_equal(self.colors(out)[-2:], 128)

    @pytest.mark.parametrize("code", ["u1", "u2"])
    def test_colors_of_the_input_are_replaced_and_it_is_said(
        self, tmp_path: Path, out: Path, code: str
    ) -> None:
        given = {name: np.full(150, 7, code) for name in self.NAMES}
        cloud = save_ply(
            tmp_path / "s.ply", vertices(sphere(), "f4", **given, label=np.zeros(150, "i4"))
        )
        finished = succeeds("curvature", cloud, "-o", out, "--colormap", "coolwarm")
        assert "colors of the input are replaced: red, green, blue\n" in finished.stderr
        assert (self.colors(out) != 7).any()
        names = [prop.name for prop in load_ply(out)["vertex"].properties]
        assert names == ["x", "y", "z", *self.NAMES, "label", *PLY_CURVATURES]
        again = succeeds("curvature", out, "-o", tmp_path / "2.ply", "--colormap", "viridis")
        assert "replaced" not in again.stderr
        assert (self.colors(tmp_path / "2.ply") != self.colors(out)).any()

    def test_colors_of_an_earlier_run_do_not_go_stale(
        self, tmp_path: Path, scan: Path, out: Path
    ) -> None:
        succeeds("curvature", scan, "-o", tmp_path / "1.ply", "--colormap", "coolwarm")
        finished = succeeds("denoise", tmp_path / "1.ply", "-o", out)
        assert "columns of an earlier run are left out: red, green, blue\n" in finished.stderr
        assert not {prop.name for prop in load_ply(out)["vertex"].properties} & set(self.NAMES)
        assert not [comment for comment in load_ply(out).comments if " colors: " in comment]

    def test_without_curvature_there_is_one_color(self, tmp_path: Path, out: Path) -> None:
        cloud = save_text(tmp_path / "three.xyz", [[0, 0, 0], [1, 0, 0], [0, 1, 0]])
        finished = succeeds("curvature", cloud, "-o", out, "--colormap", "gray")
        assert "colors: mean curvature from 0 to 0 by gray\n" in finished.stderr
        np.testing.assert_allclose(self.colors(out), 127.5, atol=1)

    def test_what_an_earlier_run_left_is_not_called_lost(
        self, tmp_path: Path, scan: Path, out: Path
    ) -> None:
        succeeds("curvature", scan, "-o", out, "--colormap", "coolwarm")
        finished = succeeds("curvature", out, "-o", tmp_path / "out.xyz")
        assert "warning: xyz files cannot hold the comments\n" in finished.stderr
        left = [*PLY_CURVATURES[3:], *self.NAMES]
        assert f"columns of an earlier run are left out: {', '.join(left)}\n" in finished.stderr

    def test_text_with_header(self, tmp_path: Path, scan: Path, out: Path) -> None:
        succeeds("curvature", scan, "-o", out, "--colormap", "coolwarm")
        finished = succeeds("curvature", scan, "-o", tmp_path / "o.csv", "--colormap", "coolwarm")
        assert "cannot hold" not in finished.stderr
        table = np.genfromtxt(tmp_path / "o.csv", delimiter=",", names=True, dtype=None)
        assert (table.dtype.names or ())[-3:] == self.NAMES
        for channel, name in enumerate(self.NAMES):
            np.testing.assert_array_equal(table[name], self.colors(out)[:, channel])

    def test_a_header_of_capitals_is_followed(self, tmp_path: Path) -> None:
        rows: list[list[object]] = [["//X", "Y", "Z", "R", "G", "B"]]
        rows += [[*point, 1, 2, 3] for point in sphere().tolist()]
        cloud = save_text(tmp_path / "scan.txt", rows)
        finished = succeeds("curvature", cloud, "-o", tmp_path / "o.txt", "--colormap", "coolwarm")
        assert "colors of the input are replaced: R, G, B\n" in finished.stderr
        header, *lines = (tmp_path / "o.txt").read_text().splitlines()
        assert header == " ".join(["//X Y Z R G B Nx Ny Nz", *TEXT_CURVATURES])
        assert {line.split()[3] for line in lines} != {"1"}

    @pytest.mark.parametrize("suffix", ["xyz", "pts"])
    def test_formats_without_room_for_them(self, tmp_path: Path, scan: Path, suffix: str) -> None:
        out = tmp_path / f"out.{suffix}"
        finished = succeeds("curvature", scan, "-o", out, "--colormap", "coolwarm")
        assert (
            f"warning: {suffix} files cannot hold column 'red', column 'green', column 'blue'\n"
        ) in finished.stderr
        assert len(out.read_text().splitlines()[-1].split()) == 6

    def test_curves_have_colors_too(self, tmp_path: Path, out: Path) -> None:
        cloud = save_text(tmp_path / "curve.xy", circle())
        finished = succeeds("curvature", cloud, "-o", out, "--colormap", "coolwarm")
        assert "colors: mean curvature from " in finished.stderr
        assert self.colors(out).shape == (60, 3)
        finished = succeeds("curvature", cloud, "-o", tmp_path / "o.xy", "--colormap", "coolwarm")
        assert "warning: xy files cannot hold column 'red'" in finished.stderr


def test_local_radii_in_tiles(tmp_path: Path) -> None:
    cloud = save_ply(tmp_path / "scan.ply", vertices(sphere()))
    arguments = [cloud, "--radius", "local", "--json", "--tile"]
    whole = succeeds("curvature", *arguments, "off", "-o", tmp_path / "whole.ply").json
    tiled = succeeds("curvature", *arguments, "50", "-o", tmp_path / "tiled.ply").json
    assert tiled["radius_range"] == whole["radius_range"]
    assert (tmp_path / "tiled.ply").read_bytes() == (tmp_path / "whole.ply").read_bytes()


@pytest.mark.slow
def test_the_shipped_scan(out: Path) -> None:
    scan = DATA / "scans/kinect_milk.ply"
    finished = forked("curvature", scan, "-o", out, "--json", "-q")
    assert (finished.status, finished.stderr) == (0, "")
    assert json.loads(finished.stdout)["points"] == 13_704
    assert positions(out).tobytes() == positions(scan).tobytes()
