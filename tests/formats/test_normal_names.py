"""Normals under the names that other programs give them: read as such, and called so again."""

from __future__ import annotations

import io

import numpy as np
import pytest

from pcsmooth.cloud import PointCloud
from pcsmooth.files.output_columns import normals_of
from pcsmooth.formats import read_cloud, write_cloud
from pcsmooth.formats.axis_names import normals_among

SPELLINGS = [
    "nx ny nz",
    "NX NY NZ",
    "Nx Ny Nz",
    "normal_x normal_y normal_z",
    "Normal_X Normal_Y Normal_Z",
    "normalx normaly normalz",
    "NormalX NormalY NormalZ",
    "n_x n_y n_z",
    "Normals:0 Normals:1 Normals:2",
    "normals_0 normals_1 normals_2",
]
NORMALS = np.array([[0, 0, 1], [0.6, 0, 0.8]])


def ply_file(names: list[str]) -> bytes:
    properties = "".join(f"property float {name}\n" for name in ["x", "y", "z", *names])
    rows = "".join(f"1.0 2.0 3.0 {a} {b} {c}\n" for a, b, c in NORMALS)
    return f"ply\nformat ascii 1.0\nelement vertex 2\n{properties}end_header\n{rows}".encode()


def pcd_file(names: list[str]) -> bytes:
    fields = ["x", "y", "z", *names]
    entries = f"FIELDS {' '.join(fields)}\nSIZE{6 * ' 4'}\nTYPE{6 * ' F'}\nCOUNT{6 * ' 1'}\n"
    rows = "".join(f"1.0 2.0 3.0 {a} {b} {c}\n" for a, b, c in NORMALS)
    return f"VERSION 0.7\n{entries}WIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n{rows}".encode()


def las_file(names: list[str]) -> bytes:
    laspy = pytest.importorskip("laspy")
    las = laspy.create(file_version="1.4", point_format=6)
    las.x = las.y = las.z = np.arange(2.0)
    for name, values in zip(names, NORMALS.T, strict=True):
        las.add_extra_dim(laspy.ExtraBytesParams(name, "f4"))
        las[name] = values
    buffer = io.BytesIO()
    las.write(buffer)
    return buffer.getvalue()


def names_in_las(data: bytes) -> list[str]:
    laspy = pytest.importorskip("laspy")
    return list(laspy.read(io.BytesIO(data)).point_format.extra_dimension_names)


@pytest.mark.parametrize(
    ("format", "spelling"),
    [
        (format, spelling)
        for format in ("ply", "pcd", "las")
        for spelling in SPELLINGS
        if format != "las" or ":" not in spelling  # which laspy would not write
    ],
)
def test_are_known_and_kept(format: str, spelling: str) -> None:
    names = spelling.split()
    data = {"ply": ply_file, "pcd": pcd_file, "las": las_file}[format](names)
    cloud = read_cloud(io.BytesIO(data), format=format)
    normals = normals_of(cloud)
    assert normals is not None
    np.testing.assert_allclose(normals, NORMALS, rtol=1e-6)
    assert [name for name in cloud.columns if name in ("nx", "ny", "nz")] == ["nx", "ny", "nz"]
    buffer = io.BytesIO()
    write_cloud(cloud, buffer, format=format)
    after = buffer.getvalue()
    if format == "las":
        assert names_in_las(after) == names
    elif format == "ply":
        assert after == data
    else:
        assert f"FIELDS x y z {spelling}\n".encode() in after


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["NX", "nx", "ny", "nz"], ["nx", "ny", "nz"]),
        (["normal_x", "normal_y", "normal_z", "nx", "ny", "nz"], ["nx", "ny", "nz"]),
        (["nx", "normal_x", "normal_y", "normal_z"], ["nx"]),
        (["NX", "NY", "NZ", "normal_x", "normal_y", "normal_z"], []),
        (["x", "y", "z", "n", "normal", "green", "nyx"], []),
        ([], []),
    ],
)
def test_which_of_several(names: list[str], expected: list[str]) -> None:
    assert normals_among(names) == {name: name for name in expected}


def test_new_files_call_them_as_their_programs_do() -> None:
    columns = dict(zip(("nx", "ny", "nz"), NORMALS.T.astype(np.float32), strict=True))
    cloud = PointCloud(np.zeros((2, 3)), columns)
    for format, name in (("ply", b"float nx\n"), ("pcd", b" normal_x ")):
        buffer = io.BytesIO()
        write_cloud(cloud, buffer, format=format)
        assert name in buffer.getvalue()
