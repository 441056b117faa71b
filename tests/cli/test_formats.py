"""`denoise`, `curvature`, `info` and `convert` through every format."""

from __future__ import annotations

import io
import json
import re
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import numpy.typing as npt
import pytest
import trimesh

import pcsmooth
from cli.clouds import load_ply, save_ply, sphere, vertices
from cli.commands import pcsmooth as command
from cli.commands import succeeds
from formats.e57_files import Scan, save_e57
from formats.peers import opened_by_open3d, opened_by_pymeshlab
from formats.test_pcd import pcd
from pcsmooth.formats import read_cloud

N = 300
CURVATURES = ["mean_curvature", "gaussian_curvature", "k1", "k2", "confidence"]
ESTIMATES = [*CURVATURES, "displacement", "outlier"]
NORMALS = ["NormalX", "NormalY", "NormalZ"]

#: What colors are made of in these tests.
COLORS = ("red", "green", "blue")


def save_las(path: Path, point_format: int = 1, scale: float = 1e-6) -> Any:
    """Write a noisy sphere with random other dimensions, far from the origin."""
    rng = np.random.default_rng(1)
    header = laspy.LasHeader(version="1.4", point_format=point_format)
    header.scales, header.offsets = np.full(3, scale), np.array([5e5, 4e6, 100.0])
    header.add_extra_dim(laspy.ExtraBytesParams("amplitude", "f4"))
    header.vlrs.append(laspy.VLR("LASF_Projection", 2112, "WKT", b"none"))
    las = laspy.LasData(header)
    las.xyz = sphere(N) + header.offsets
    las.intensity = rng.integers(0, 65536, N)
    las.classification = rng.integers(0, 7, N)
    las.return_number = rng.integers(1, 8, N)
    las.gps_time = rng.random(N)
    las.amplitude = rng.random(N).astype("f4")
    las.write(str(path))
    return laspy.read(path)


def save_pcd(path: Path, encoding: str = "binary") -> npt.NDArray[np.float32]:
    """Write a noisy sphere with colors, a ring number and a row without position, organised."""
    points = sphere(N).astype("f4")
    points[17] = np.nan
    fields = [(name, points[:, axis]) for axis, name in enumerate("xyz")]
    fields += [("rgb", np.arange(N, dtype="u4").view("f4")), ("ring", np.arange(N, dtype="u2"))]
    path.write_bytes(pcd(fields, encoding, (30, 10), "1 2 3 1 0 0 0"))
    return points


COLORED = ("--colormap", "viridis", "--color-by", "gaussian")


def colors_in_ply(source: Path) -> dict[str, npt.NDArray[np.uint8]]:
    """Write colors of the file in PLY too, in which they are as they were made."""
    target = source.with_name("colors.ply")
    succeeds("curvature", source, "-o", target, *COLORED)
    vertex = load_ply(target)["vertex"]
    assert np.ptp(vertex["red"]) > 20
    return {name: np.array(vertex[name]) for name in COLORS}


class TestLas:
    @pytest.mark.parametrize("suffix", ["las", "laz"])
    def test_denoise(self, tmp_path: Path, suffix: str) -> None:
        before = save_las(tmp_path / f"a.{suffix}")
        finished = succeeds("denoise", tmp_path / f"a.{suffix}", "-o", tmp_path / f"b.{suffix}")
        after = laspy.read(tmp_path / f"b.{suffix}")
        assert after.header.are_points_compressed == (suffix == "laz")
        result = pcsmooth.denoise(np.asarray(before.xyz))
        moved = np.abs(np.asarray(after.xyz) - result.points)
        assert moved.max() <= 0.5001e-6
        integers = np.rint((result.points - before.header.offsets) / before.header.scales)
        np.testing.assert_array_equal(np.stack([after.X, after.Y, after.Z], axis=1), integers)
        for name in ("intensity", "classification", "return_number", "gps_time", "amplitude"):
            np.testing.assert_array_equal(np.array(after[name]), np.array(before[name]))
        extras = list(after.point_format.extra_dimension_names)
        assert extras == ["amplitude", *NORMALS, *ESTIMATES]
        curvature = result.curvature
        for axis, name in enumerate(NORMALS):
            np.testing.assert_array_equal(after[name], curvature.normals[:, axis].astype("f4"))
        for name, values in (
            ("mean_curvature", curvature.mean_curvature),
            ("gaussian_curvature", curvature.gaussian_curvature),
            ("k1", curvature.principal_curvatures[:, 0]),
            ("displacement", result.displacement),
        ):
            np.testing.assert_array_equal(after[name], values.astype("f4"))
            assert values.any()
        assert "warning" not in finished.stderr

    def test_twice_does_not_double_dimensions(self, tmp_path: Path) -> None:
        save_las(tmp_path / "a.laz")
        succeeds("denoise", tmp_path / "a.laz", "-o", tmp_path / "b.laz")
        finished = succeeds("denoise", tmp_path / "b.laz", "-o", tmp_path / "c.laz")
        first, second = (laspy.read(tmp_path / f"{name}.laz") for name in "bc")
        names = list(first.point_format.dimension_names)
        assert list(second.point_format.dimension_names) == names
        assert "kept" not in finished.stderr
        assert np.any(np.asarray(second.k1) != np.asarray(first.k1))
        lines = read_cloud(tmp_path / "c.laz").comments
        assert sum(" denoise " in line for line in lines) == 2
        assert sum(" columns: " in line for line in lines) == 1
        succeeds("curvature", tmp_path / "c.laz", "-o", tmp_path / "d.laz")
        third = laspy.read(tmp_path / "d.laz")
        np.testing.assert_array_equal(third.displacement, second.displacement)
        np.testing.assert_array_equal(third.X, second.X)

    def test_coarse_steps_are_warned_about(self, tmp_path: Path) -> None:
        save_las(tmp_path / "a.las", scale=0.01)
        finished = succeeds("denoise", tmp_path / "a.las", "-o", tmp_path / "b.las")
        assert re.search(
            r"warning: LAS positions in steps of 0\.01 round these coordinates by up to 0\.005, "
            r"against a mean displacement of 0\.0\d+; \.ply keeps them\n",
            finished.stderr,
        )
        # A tenth of the mean displacement and less is no matter; the JSON says it all the same.
        save_las(tmp_path / "fine.las", scale=0.002)
        finished = succeeds("denoise", tmp_path / "fine.las", "-o", tmp_path / "d.las", "--json")
        assert "warning" not in finished.stderr
        assert 0.0009 < finished.json["rounding"] <= 0.001
        assert finished.json["mean_displacement"] > 10 * finished.json["rounding"]
        finished = succeeds("curvature", tmp_path / "a.las", "-o", tmp_path / "c.las")
        assert "warning" not in finished.stderr
        before, after = (laspy.read(tmp_path / name) for name in ("a.las", "c.las"))
        np.testing.assert_array_equal(after.X, before.X)

    def test_outliers_keep_their_integers(self, tmp_path: Path) -> None:
        save_las(tmp_path / "a.las", scale=1e-3)
        las = laspy.read(tmp_path / "a.las")
        las.X[5] += 5000
        las.write(str(tmp_path / "a.las"))
        succeeds("denoise", tmp_path / "a.las", "-o", tmp_path / "b.las")
        after = laspy.read(tmp_path / "b.las")
        held = np.flatnonzero(after.outlier)
        assert 5 in held
        for name in "XYZ":
            np.testing.assert_array_equal(after[name][held], las[name][held])
        assert np.any(np.asarray(after.X) != np.asarray(las.X))

    @pytest.mark.parametrize(("before", "after"), [(1, 3), (3, 3), (6, 7)])
    def test_colors(self, tmp_path: Path, before: int, after: int) -> None:
        save_las(tmp_path / "a.las", before)
        succeeds("curvature", tmp_path / "a.las", "-o", tmp_path / "b.las", *COLORED)
        las = laspy.read(tmp_path / "b.las")
        assert las.point_format.id == after
        for name, values in colors_in_ply(tmp_path / "a.las").items():
            np.testing.assert_array_equal(las[name], values.astype("u2") * 257)
        assert not set(COLORS) & set(las.point_format.extra_dimension_names)

    def test_pipe(self, tmp_path: Path) -> None:
        save_las(tmp_path / "a.laz")
        succeeds("denoise", tmp_path / "a.laz", "-o", tmp_path / "b.laz")
        finished = succeeds("denoise", "-", "-o", "-", stdin=(tmp_path / "a.laz").read_bytes())
        piped = laspy.read(io.BytesIO(finished.stdout))
        assert piped.points.array.tobytes() == laspy.read(tmp_path / "b.laz").points.array.tobytes()

    def test_from_and_to_ply(self, tmp_path: Path) -> None:
        save_ply(tmp_path / "a.ply", vertices(sphere(N), "f8", label=np.arange(N, dtype="i2")))
        finished = succeeds("denoise", tmp_path / "a.ply", "-o", tmp_path / "b.laz")
        assert re.search(r"LAS positions are written in steps of 1e-0\d\n", finished.stderr)
        las = laspy.read(tmp_path / "b.laz")
        result = pcsmooth.denoise(sphere(N))
        assert np.abs(np.asarray(las.xyz) - result.points).max() < 1e-4 * result.spacing
        np.testing.assert_array_equal(las.label, np.arange(N))
        succeeds("convert", tmp_path / "b.laz", "-o", tmp_path / "c.ply")
        vertex = load_ply(tmp_path / "c.ply")["vertex"]
        np.testing.assert_array_equal(vertex["x"], las.x)
        np.testing.assert_array_equal(vertex["nx"], las.NormalX)
        np.testing.assert_array_equal(vertex["mean_curvature"], las.mean_curvature)

    def test_records_that_ply_cannot_hold(self, tmp_path: Path) -> None:
        save_las(tmp_path / "a.las")
        finished = succeeds("denoise", tmp_path / "a.las", "-o", tmp_path / "b.ply")
        words = "warning: ply files cannot hold 1 LAS record (such as the coordinate system)\n"
        assert words in finished.stderr

    def test_info(self, tmp_path: Path) -> None:
        save_las(tmp_path / "a.laz")
        facts = succeeds("info", tmp_path / "a.laz", "--json").json
        assert facts["points"] == N
        assert facts["columns"]["classification"] == "uint8"
        assert facts["minimum"][0] > 499_998


class TestPcd:
    @pytest.mark.parametrize("encoding", ["ascii", "binary", "binary_compressed"])
    def test_denoise(self, tmp_path: Path, encoding: str) -> None:
        points = save_pcd(tmp_path / "a.pcd", encoding)
        succeeds("denoise", tmp_path / "a.pcd", "-o", tmp_path / "b.pcd")
        head = (tmp_path / "b.pcd").read_bytes().split(b"\nDATA ")[0].decode()
        assert "\nWIDTH 30\nHEIGHT 10\nVIEWPOINT 1 2 3 1 0 0 0\nPOINTS 300" in head
        fields = ["x", "y", "z", "rgb", "ring", "normal_x", "normal_y", "normal_z"]
        assert f"\nFIELDS {' '.join([*fields, 'curvature', *ESTIMATES])}\n" in head
        assert f"# pcsmooth {pcsmooth.__version__} denoise scheme=filter " in head
        result = pcsmooth.denoise(points.astype("f8"))
        opened = opened_by_open3d(tmp_path / "b.pcd")
        close = 1e-6 if encoding == "ascii" else 0.0
        kept = np.arange(N) != 17
        expected = result.points.astype("f4")
        np.testing.assert_allclose(opened["points"], expected, rtol=0, atol=close)
        assert np.isnan(opened["points"][17]).all()
        normals = result.normals.astype("f4")
        np.testing.assert_allclose(opened["normals"][kept], normals[kept], rtol=0, atol=close)
        mean = result.mean_curvature.astype("f4")
        for name in ("curvature", "mean_curvature"):
            np.testing.assert_array_equal(opened[name][kept], mean[kept])
        np.testing.assert_array_equal(opened["ring"], np.arange(N))
        np.testing.assert_allclose(opened["colors"][:, 2] * 255, np.arange(N) % 256, atol=1e-3)

    def test_twice_does_not_double_fields(self, tmp_path: Path) -> None:
        save_pcd(tmp_path / "a.pcd")
        succeeds("denoise", tmp_path / "a.pcd", "-o", tmp_path / "b.pcd")
        finished = succeeds("denoise", tmp_path / "b.pcd", "-o", tmp_path / "c.pcd")
        first, second = (read_cloud(tmp_path / f"{name}.pcd") for name in "bc")
        assert list(first.columns) == list(second.columns)
        assert "kept" not in finished.stderr
        assert np.any(first.columns["k1"] != second.columns["k1"])

    def test_a_curvature_of_pcl_is_kept(self, tmp_path: Path) -> None:
        points = sphere(N).astype("f4")
        fields = [(name, points[:, axis]) for axis, name in enumerate("xyz")]
        (tmp_path / "a.pcd").write_bytes(pcd([*fields, ("curvature", np.full(N, 0.25, "f4"))]))
        finished = succeeds("curvature", tmp_path / "a.pcd", "-o", tmp_path / "b.pcd")
        assert "column 'curvature' is the input's own and kept" in finished.stderr
        columns = read_cloud(tmp_path / "b.pcd").columns
        assert np.all(columns["curvature"] == 0.25)
        expected = pcsmooth.estimate_curvature(points.astype("f8")).mean_curvature
        np.testing.assert_array_equal(columns["mean_curvature"], expected.astype("f4"))

    def test_colors_replace_those_of_the_file(self, tmp_path: Path) -> None:
        save_pcd(tmp_path / "a.pcd")
        finished = succeeds("curvature", tmp_path / "a.pcd", "-o", tmp_path / "b.pcd", *COLORED)
        assert "colors of the input are replaced: red, green, blue" in finished.stderr
        opened = opened_by_open3d(tmp_path / "b.pcd")
        for rank, values in enumerate(colors_in_ply(tmp_path / "a.pcd").values()):
            np.testing.assert_allclose(opened["colors"][:, rank] * 255, values, atol=1e-3)

    @pytest.mark.parametrize(("option", "code"), [(None, "f4"), ("--double", "f8")])
    def test_a_new_file_is_what_pcl_reads(
        self, tmp_path: Path, option: str | None, code: str
    ) -> None:
        save_ply(tmp_path / "a.ply", vertices(sphere(N), "f8"))
        options = [option] if option else []
        for name, verb in (("b.pcd", "denoise"), ("c.pcd", "convert")):
            succeeds(verb, tmp_path / "a.ply", "-o", tmp_path / name, *options)
            assert read_cloud(tmp_path / name).position_type == code
        expected = sphere(N).astype(code)
        np.testing.assert_array_equal(read_cloud(tmp_path / "c.pcd").points, expected)

    def test_survey_coordinates_are_warned_about(self, tmp_path: Path) -> None:
        save_las(tmp_path / "a.las")
        finished = succeeds("denoise", tmp_path / "a.las", "-o", tmp_path / "b.pcd")
        assert "warning: float positions round these coordinates by up to" in finished.stderr
        finished = succeeds("convert", tmp_path / "a.las", "-o", tmp_path / "c.pcd")
        assert "float positions round these coordinates by up to 0." in finished.stderr

    def test_pipe(self, tmp_path: Path) -> None:
        save_pcd(tmp_path / "a.pcd")
        succeeds("curvature", tmp_path / "a.pcd", "-o", tmp_path / "b.pcd")
        data = (tmp_path / "a.pcd").read_bytes()
        finished = succeeds("curvature", "-", "-o", "-", stdin=data)
        assert finished.stdout == (tmp_path / "b.pcd").read_bytes()


class TestMeshes:
    SPHERE = trimesh.creation.icosphere(subdivisions=2)

    @pytest.fixture
    def noisy(self) -> Any:
        mesh = self.SPHERE.copy()
        mesh.vertices += np.random.default_rng(1).normal(scale=0.02, size=mesh.vertices.shape)
        return mesh

    @pytest.mark.parametrize("suffix", ["obj", "off"])
    def test_denoise(self, tmp_path: Path, noisy: Any, suffix: str) -> None:
        source, target = tmp_path / f"a.{suffix}", tmp_path / f"b.{suffix}"
        noisy.export(source, **({"digits": 17} if suffix == "off" else {}))
        before = opened_by_pymeshlab(source)
        finished = succeeds("denoise", source, "-o", target)
        opened = opened_by_pymeshlab(target)
        expected = pcsmooth.denoise(read_cloud(source).points).points
        np.testing.assert_allclose(opened["points"], expected, rtol=0.0, atol=1e-7)
        np.testing.assert_array_equal(opened["faces"], before["faces"])
        np.testing.assert_array_equal(opened["faces"], noisy.faces)
        words = f"warning: {suffix} files hold no curvatures, and normals only where they had them"
        assert words in finished.stderr
        assert "cannot hold" not in finished.stderr

    @pytest.mark.parametrize("kind", ["stl", "stl_ascii"])
    def test_corners_move_together(self, tmp_path: Path, noisy: Any, kind: str) -> None:
        (tmp_path / "a.stl").write_bytes(b"")
        noisy.export(tmp_path / "a.stl", file_type=kind)
        succeeds("denoise", tmp_path / "a.stl", "-o", tmp_path / "b.stl")
        before, after = (
            trimesh.load_mesh(tmp_path / name, process=True, validate=False)
            for name in ("a.stl", "b.stl")
        )
        before.merge_vertices()
        after.merge_vertices()
        assert len(before.vertices) == len(after.vertices) == len(noisy.vertices)
        assert after.is_watertight
        radii = [np.linalg.norm(mesh.vertices, axis=1).std() for mesh in (before, after)]
        assert radii[1] < 0.7 * radii[0]

    def test_normals_of_obj_are_made_anew(self, tmp_path: Path, noisy: Any) -> None:
        lines = [f"v {x!r} {y!r} {z!r}\nvn 0 0 1" for x, y, z in noisy.vertices.tolist()]
        lines += ["f " + " ".join(f"{i + 1}//{i + 1}" for i in face) for face in noisy.faces]
        (tmp_path / "a.obj").write_text("\n".join(lines))
        succeeds("curvature", tmp_path / "a.obj", "-o", tmp_path / "b.obj", "--orient", "outward")
        opened = opened_by_pymeshlab(tmp_path / "b.obj")
        np.testing.assert_array_equal(opened["points"], noisy.vertices)
        normals = np.array(
            [row.split()[1:] for row in (tmp_path / "b.obj").read_text().splitlines()
             if row.startswith("vn")], "f8",
        )  # fmt: skip
        assert np.sum(normals * noisy.vertices, axis=1).min() > 0.8

    def test_colors_of_obj(self, tmp_path: Path, noisy: Any) -> None:
        noisy.export(tmp_path / "a.obj")
        succeeds("curvature", tmp_path / "a.obj", "-o", tmp_path / "b.obj", *COLORED)
        opened = opened_by_pymeshlab(tmp_path / "b.obj")
        for rank, values in enumerate(colors_in_ply(tmp_path / "a.obj").values()):
            np.testing.assert_allclose(opened["colors"][:, rank] * 255, values, atol=1e-3)

    def test_faces_that_are_lost(self, tmp_path: Path, noisy: Any) -> None:
        noisy.export(tmp_path / "a.off")
        finished = succeeds("denoise", tmp_path / "a.off", "-o", tmp_path / "b.ply")
        words = "warning: ply files cannot hold faces and all but the vertices of the OFF file\n"
        assert words in finished.stderr
        assert load_ply(tmp_path / "b.ply")["vertex"].count == len(noisy.vertices)

    def test_points_are_no_triangles(self, tmp_path: Path) -> None:
        save_ply(tmp_path / "a.ply", vertices(sphere(N)))
        finished = command("denoise", tmp_path / "a.ply", "-o", tmp_path / "b.stl")
        assert finished.status == 1
        assert re.fullmatch(
            r"Error: \S+b\.stl: an \.stl file holds triangles, which these points are not; write "
            r"\.ply instead\n",
            finished.stderr,
        )
        assert not (tmp_path / "b.stl").exists()


class TestE57:
    def scans(self, path: Path) -> npt.NDArray[np.float64]:
        """Two halves of a sphere from two stations, with a point that is not valid."""
        points = sphere(N)
        parts = []
        for part, shift in ((points[:200], 0.0), (points[200:], 10.0)):
            fields: dict[str, Any] = {
                f"cartesian{axis}": part[:, rank] - shift for rank, axis in enumerate("XYZ")
            }
            fields["cartesianInvalidState"] = (np.arange(len(part)) == 50).astype("i1")
            fields["intensity"] = np.linspace(0, 1, len(part)).astype("f4")
            parts.append(Scan(fields, translation=[shift] * 3))
        save_e57(path, *parts)
        points[[50, 250]] = np.nan
        return points

    def test_denoise(self, tmp_path: Path) -> None:
        points = self.scans(tmp_path / "a.e57")
        finished = succeeds("denoise", tmp_path / "a.e57", "-o", tmp_path / "b.ply")
        assert "300 points in 3D, 2 not finite (passed through)" in finished.stderr
        vertex = load_ply(tmp_path / "b.ply")["vertex"]
        expected = pcsmooth.denoise(points).points
        for axis, name in enumerate("xyz"):
            np.testing.assert_allclose(vertex[name], expected[:, axis], rtol=0.0, atol=1e-9)
        np.testing.assert_array_equal(vertex["scan"], np.arange(N) >= 200)
        assert vertex["intensity"][-1] == 1.0

    def test_pipe(self, tmp_path: Path) -> None:
        points = self.scans(tmp_path / "a.e57")
        finished = succeeds("curvature", "-", "-o", "-", stdin=(tmp_path / "a.e57").read_bytes())
        vertex = load_ply(finished.stdout)["vertex"]
        np.testing.assert_allclose(vertex["x"], points[:, 0], atol=1e-9)

    def test_it_cannot_be_written(self, tmp_path: Path) -> None:
        self.scans(tmp_path / "a.e57")
        for verb in ("denoise", "convert"):
            finished = command(verb, tmp_path / "a.e57", "-o", tmp_path / "b.e57")
            assert finished.status == 1
            assert "b.e57: .e57 can be read but not written; use one of .ply, " in finished.stderr

    def test_las_holds_no_invalid_points(self, tmp_path: Path) -> None:
        self.scans(tmp_path / "a.e57")
        finished = command("denoise", tmp_path / "a.e57", "-o", tmp_path / "b.las")
        assert finished.status == 1
        assert "b.las: point 51 is not finite, and LAS holds integers; write" in finished.stderr


class TestConvert:
    def test_there_and_back(self, tmp_path: Path) -> None:
        rng = np.random.default_rng(1)
        columns = {
            "nx": rng.normal(size=N).astype("f4"),
            "ny": rng.normal(size=N).astype("f4"),
            "nz": rng.normal(size=N).astype("f4"),
            **{name: rng.integers(0, 256, N, "u1") for name in COLORS},
            "label": rng.integers(-9, 9, N, "i2"),
        }
        save_ply(tmp_path / "0.ply", vertices(sphere(N), "f4", **columns))
        path = tmp_path / "0.ply"
        for step, suffix in enumerate(("pcd", "las", "csv", "laz", "ply"), 1):
            target = tmp_path / f"{step}.{suffix}"
            finished = succeeds("convert", path, "-o", target)
            assert "warning" not in finished.stderr
            assert finished.stderr.endswith(f"{path}: 300 points written to {target}\n")
            path = target
        after = read_cloud(path)
        np.testing.assert_allclose(after.points, sphere(N), atol=1e-5)
        for name in ("nx", "ny", "nz", "label"):
            np.testing.assert_array_equal(after.columns[name].astype("f4"), columns[name])
        for name in COLORS:
            np.testing.assert_array_equal(after.columns[name], columns[name].astype("u2") * 257)

    def test_what_is_lost_and_rounded_is_said(self, tmp_path: Path) -> None:
        save_las(tmp_path / "a.las")
        finished = succeeds("convert", tmp_path / "a.las", "-o", tmp_path / "b.ply", "--float")
        assert "warning: ply files cannot hold 1 LAS record" in finished.stderr
        assert re.search(
            r"float positions round these coordinates by up to 0\.\d+", finished.stderr
        )
        quiet = succeeds("convert", tmp_path / "a.las", "-o", tmp_path / "c.xyz", "-q")
        assert quiet.stderr == ""
        assert len((tmp_path / "c.xyz").read_text().splitlines()) == N

    @pytest.mark.parametrize(("origin", "is_much"), [(5.8e6, True), (10.0, False)])
    def test_much_rounding_is_a_warning(self, tmp_path: Path, origin: float, is_much: bool) -> None:
        np.savetxt(tmp_path / "a.xyz", sphere(N) + origin, fmt="%.9f")
        finished = succeeds("convert", tmp_path / "a.xyz", "-o", tmp_path / "b.pcd")
        words = r"float positions round these coordinates by up to [\d.e-]+; --double keeps them\n"
        assert re.search(f"^{'warning: ' if is_much else ''}{words}", finished.stderr, re.M)

    def test_stream(self, tmp_path: Path) -> None:
        points = save_pcd(tmp_path / "a.pcd")
        finished = succeeds("convert", "-", "-o", "-", stdin=(tmp_path / "a.pcd").read_bytes())
        assert finished.stdout == (tmp_path / "a.pcd").read_bytes()
        assert "<stdin>: 300 points written to -\n" in finished.stderr
        assert np.isnan(points[17]).all()

    def test_existing_files_need_overwrite(self, tmp_path: Path) -> None:
        save_pcd(tmp_path / "a.pcd")
        (tmp_path / "b.csv").write_text("precious")
        finished = command("convert", tmp_path / "a.pcd", "-o", tmp_path / "b.csv")
        assert (finished.status, (tmp_path / "b.csv").read_text()) == (1, "precious")
        succeeds("convert", tmp_path / "a.pcd", "-o", tmp_path / "b.csv", "--overwrite")
        assert (tmp_path / "b.csv").read_text().startswith("x,y,z,red,green,blue,ring\n")


@pytest.mark.parametrize("suffix", ["las", "laz", "pcd", "obj", "off", "stl", "e57"])
def test_nothing_is_left_of_a_damaged_file(tmp_path: Path, suffix: str) -> None:
    (tmp_path / f"a.{suffix}").write_bytes(b"\x93 this is not what its name says\n")
    for verb in ("denoise", "curvature", "convert"):
        finished = command(verb, tmp_path / f"a.{suffix}", "-o", tmp_path / "b.ply")
        assert finished.status == 1
        assert finished.stderr.startswith(f"Error: {tmp_path}/a.{suffix}: ")
        assert finished.stderr.count("\n") == 1
        assert "; " in finished.stderr
    assert [path.name for path in tmp_path.iterdir()] == [f"a.{suffix}"]


def test_summaries_are_json(tmp_path: Path) -> None:
    save_las(tmp_path / "a.laz")
    finished = succeeds("denoise", tmp_path / "a.laz", "-o", tmp_path / "b.laz", "--json", "-q")
    assert json.loads(finished.stdout)["points"] == N
