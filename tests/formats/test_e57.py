from __future__ import annotations

import io
import struct
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pye57
import pytest

from formats.chunked import check_reading
from formats.e57_files import Scan, save_e57
from pcsmooth.errors import CloudFileError, PcsmoothError
from pcsmooth.formats import lost_in, open_chunks, output_format, read_cloud

N = 30
AXES = ("cartesianX", "cartesianY", "cartesianZ")


def cartesian(seed: int = 1, code: str = "f8", n: int = N) -> dict[str, npt.NDArray[Any]]:
    points = np.random.default_rng(seed).normal(size=(n, 3)).astype(code)
    return {name: points[:, axis] for axis, name in enumerate(AXES)}


def xyz(fields: dict[str, npt.NDArray[Any]]) -> npt.NDArray[np.float64]:
    return np.stack([fields[name] for name in AXES], axis=1).astype("f8")


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "a.e57"


@pytest.mark.parametrize("code", ["f4", "f8"])
def test_positions_bit_for_bit(path: Path, code: str) -> None:
    fields = cartesian(code=code)
    cloud = read_cloud(save_e57(path, Scan(fields)))
    np.testing.assert_array_equal(cloud.points, xyz(fields))
    assert list(cloud.columns) == ["scan"]
    assert cloud.position_type == np.float64
    assert output_format(None, cloud) == "ply"
    assert lost_in(cloud, "e57") == []


def test_every_type_of_column(path: Path) -> None:
    rng = np.random.default_rng(2)
    columns: dict[str, npt.NDArray[Any]] = {"intensity": rng.random(N).astype("f4")}
    for name in ("colorRed", "colorGreen", "colorBlue"):
        columns[name] = rng.integers(0, 256, N, "u1")
    for code, name in (("u2", "rowIndex"), ("u4", "columnIndex"), ("i1", "returnIndex"),
                       ("i2", "returnCount"), ("i4", "isIntensityInvalid")):  # fmt: skip
        info = np.iinfo(code)
        columns[name] = rng.integers(info.min, info.max, N, code, endpoint=True)
    columns["timeStamp"] = rng.random(N)
    for axis, name in enumerate(("nor:normalX", "nor:normalY", "nor:normalZ")):
        columns[name] = np.full(N, axis / 2, "f4")
    cloud = read_cloud(save_e57(path, Scan({**cartesian(), **columns})))
    names = {"colorRed": "red", "colorGreen": "green", "colorBlue": "blue", "nor:normalX": "nx",
             "nor:normalY": "ny", "nor:normalZ": "nz"}  # fmt: skip
    assert list(cloud.columns) == ["scan", *(names.get(name, name) for name in columns)]
    for name, values in columns.items():
        read = cloud.columns[names.get(name, name)]
        assert read.dtype == values.dtype
        np.testing.assert_array_equal(read, values)


def test_scaled_integers(path: Path) -> None:
    fields = {name: np.round(values, 3) for name, values in cartesian().items()}
    scan = Scan(fields, steps=dict.fromkeys(AXES, 0.001))
    cloud = read_cloud(save_e57(path, scan))
    np.testing.assert_allclose(cloud.points, xyz(fields), rtol=0.0, atol=1e-12)


def test_scans_are_moved_by_their_poses(path: Path) -> None:
    quaternion = np.array([0.9, 0.1, -0.3, 0.2])
    quaternion /= np.linalg.norm(quaternion)
    shift = [500_000.25, -3.0, 12.5]
    scans = [
        Scan(cartesian(1), name="tower"),
        Scan(cartesian(2, n=7), quaternion.tolist(), shift),
        Scan(cartesian(3), translation=[1.0, 2.0, 3.0], name="gate"),
        Scan(cartesian(4), rotation=[0.5, 0.5, 0.5, 0.5]),
        Scan(cartesian(5), rotation=[0.0, 0.0, 0.0, 0.0]),
    ]
    cloud = read_cloud(save_e57(path, *scans, metadata="somewhere"))
    assert cloud.columns["scan"].tolist() == [0] * N + [1] * 7 + [2] * N + [3] * N + [4] * N
    assert cloud.comments == ("coordinates: somewhere", "scan 0: tower", "scan 2: gate")
    parts = [cloud.points[cloud.columns["scan"] == index] for index in range(5)]
    np.testing.assert_array_equal(parts[0], xyz(cartesian(1)))
    expected = pye57.E57.to_global(xyz(cartesian(2, n=7)), quaternion, np.array(shift))
    np.testing.assert_allclose(parts[1], expected, rtol=0.0, atol=1e-9)
    np.testing.assert_array_equal(parts[2], xyz(cartesian(3)) + np.array([1.0, 2, 3]))
    np.testing.assert_allclose(parts[3], xyz(cartesian(4))[:, [2, 0, 1]], atol=1e-15)
    np.testing.assert_array_equal(parts[4], xyz(cartesian(5)))


def test_spherical_positions(path: Path) -> None:
    points = xyz(cartesian())
    length = np.linalg.norm(points, axis=1)
    fields = {
        "sphericalRange": length,
        "sphericalAzimuth": np.arctan2(points[:, 1], points[:, 0]),
        "sphericalElevation": np.arcsin(points[:, 2] / length),
        "sphericalInvalidState": (np.arange(N) == 4).astype("i1"),
    }
    cloud = read_cloud(save_e57(path, Scan(fields)))
    points[4] = np.nan
    np.testing.assert_allclose(cloud.points, points, rtol=0.0, atol=1e-14)


def test_invalid_points_are_nan_in_their_place(path: Path) -> None:
    fields = cartesian()
    state = np.zeros(N, "i1")
    state[[3, 9]] = [1, 2]
    intensity = np.arange(N, dtype="f4")
    cloud = read_cloud(
        save_e57(path, Scan({**fields, "cartesianInvalidState": state, "intensity": intensity}))
    )
    assert np.flatnonzero(np.isnan(cloud.points).all(axis=1)).tolist() == [3, 9]
    np.testing.assert_array_equal(cloud.points[state == 0], xyz(fields)[state == 0])
    np.testing.assert_array_equal(cloud.columns["intensity"], intensity)
    assert list(cloud.columns) == ["scan", "intensity"]


def test_fields_that_a_scan_lacks(path: Path) -> None:
    colors = {name: np.full(N, 7, "u1") for name in ("colorRed", "colorGreen", "colorBlue")}
    first = Scan({**cartesian(1), "intensity": np.ones(N, "f4")})
    second = Scan({**cartesian(2), **colors, "intensity": np.ones(N)})
    third = Scan(cartesian(3, n=2))
    cloud = read_cloud(save_e57(path, first, second, third))
    assert cloud.columns["intensity"].dtype == np.float64
    np.testing.assert_array_equal(cloud.columns["intensity"], [1.0] * 2 * N + [np.nan] * 2)
    assert cloud.columns["red"].dtype == np.uint8
    np.testing.assert_array_equal(cloud.columns["red"], [0] * N + [7] * N + [0, 0])


@pytest.mark.parametrize("scans", [(), (Scan(cartesian(n=0)),)], ids=["no scan", "empty scan"])
def test_no_points(path: Path, scans: tuple[Scan, ...]) -> None:
    cloud = read_cloud(save_e57(path, *scans))
    assert cloud.points.shape == (0, 3)


def test_fields_of_text_are_left_out(path: Path) -> None:
    fields = {**cartesian(n=0), "note": np.empty(0, "U1"), "intensity": np.empty(0)}
    cloud = read_cloud(save_e57(path, Scan(fields)))
    assert list(cloud.columns) == ["scan", "intensity"]
    assert cloud.comments == ("scan 0: text note is left out",)


def test_files_of_pye57(path: Path) -> None:
    fields = cartesian(code="f4")
    intensity = np.random.default_rng(1).random(N).astype("f4")
    with pye57.E57(str(path), "w") as file:
        file.write_scan_raw(
            {**fields, "intensity": intensity},
            rotation=np.array([0.0, 0.0, 0.0, 1.0]),
            translation=np.array([1.0, 0.0, 0.0]),
        )
    cloud = read_cloud(path)
    with pye57.E57(str(path)) as file:
        expected = file.read_scan(0, intensity=True, ignore_missing_fields=True)
    for axis, name in enumerate(AXES):
        np.testing.assert_allclose(cloud.points[:, axis], expected[name], atol=1e-12)
    np.testing.assert_array_equal(cloud.columns["intensity"], intensity)


# ----------------------------------------------------------------------------- damaged files

_PAGE, _DATA = 1024, 1020


def crc32c(data: bytes) -> int:
    """Checksum of a page: CRC-32C, bit by bit."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc >> 1) ^ (0x82F63B78 if crc & 1 else 0)
    return crc ^ 0xFFFFFFFF


def with_text(data: bytes, old: bytes, new: bytes) -> bytes:
    """Replace a piece of the description by one of the same length; checksums are made anew."""
    assert len(old) == len(new)
    pages = [data[start : start + _PAGE] for start in range(0, len(data), _PAGE)]
    plain = b"".join(page[:_DATA] for page in pages)
    assert plain.count(old) == 1
    plain = plain.replace(old, new)
    pieces = [plain[start : start + _DATA] for start in range(0, len(plain), _DATA)]
    return b"".join(piece + struct.pack(">I", crc32c(piece)) for piece in pieces)


def test_checksums_are_made_as_the_library_does(path: Path) -> None:
    data = save_e57(path, Scan(cartesian(), name="tower")).read_bytes()
    assert with_text(data, b"tower", b"tower") == data
    assert read_cloud(io.BytesIO(with_text(data, b"tower", b"gates"))).comments == (
        "scan 0: gates",
    )


def test_more_points_than_fit_into_the_file(path: Path) -> None:
    n = 20_000
    fields = {**cartesian(n=n), "rowIndex": np.zeros(n, "u1")}
    data = save_e57(path, Scan(fields)).read_bytes()
    endless = with_text(data, b'recordCount="20000"', b'recordCount="99999"')
    message = r"<stdin>: scan 0 promises 99999 points, which do not fit into the \d+ bytes of the"
    with pytest.raises(CloudFileError, match=message):
        read_cloud(io.BytesIO(endless))


def test_a_few_more_points_than_there_are(path: Path) -> None:
    data = save_e57(path, Scan(cartesian(n=57), name="x" * 3000)).read_bytes()
    more = with_text(data, b'recordCount="57"', b'recordCount="90"')
    with pytest.raises(CloudFileError, match=r"<stdin>: .*; "):
        read_cloud(io.BytesIO(more))


def test_scans_that_promise_the_same_bytes(path: Path) -> None:
    scans = Scan(cartesian(n=2000)), Scan(cartesian(n=2001))
    data = save_e57(path, *scans).read_bytes()
    more = with_text(data, b'recordCount="2001"', b'recordCount="3999"')
    with pytest.raises(CloudFileError, match="scan 1 promises 3999 points, which do not fit into"):
        read_cloud(io.BytesIO(more))


def constants(n: int, names: Sequence[str]) -> Scan:
    """A scan whose fields take no room in the file, but for a bit of each point."""
    fields: dict[str, npt.NDArray[Any]] = {name: np.zeros(n) for name in (*AXES, *names)}
    fields[AXES[0]] = np.arange(n) % 2 * 0.001
    return Scan(fields, steps=dict.fromkeys(fields, 0.001))


def test_what_takes_no_room_in_the_file(path: Path) -> None:
    names = [f"field{rank}" for rank in range(40)]
    cloud = read_cloud(save_e57(path, constants(3000, names)))
    assert len(cloud) == 3000
    assert set(names) < set(cloud.columns)
    data = save_e57(path, constants(30_000, names)).read_bytes()
    assert len(data) < 16_000
    message = r"30000 points of 344 bytes are too much for \d+ bytes of the file; export it again"
    with pytest.raises(CloudFileError, match=message):
        read_cloud(io.BytesIO(data))
    save_e57(
        path, Scan({**cartesian(n=1), **dict.fromkeys(names, np.ones(1))}), constants(30_000, [])
    )
    with pytest.raises(CloudFileError, match=r"30001 points of 328 bytes are too much for"):
        read_cloud(path)


def test_names_of_several_lines(path: Path) -> None:
    cloud = read_cloud(save_e57(path, Scan(cartesian(), name="front\n door "), metadata="a\nb"))
    assert cloud.comments == ("coordinates: a b", "scan 0: front door")


def test_a_scan_without_positions(path: Path) -> None:
    save_e57(path, Scan({"intensity": np.ones(3)}))
    with pytest.raises(CloudFileError, match=r"a\.e57: scan 0 has no positions; export it again"):
        read_cloud(path)


@pytest.mark.parametrize("part", [8, 60, 1000, 1024, 2000])
def test_cut_short(path: Path, part: int) -> None:
    data = save_e57(path, Scan(cartesian())).read_bytes()
    assert part < len(data)
    path.write_bytes(data[:part])
    message = r"a\.e57: cannot be read as E57 \(.+\); get the whole file again"
    with pytest.raises(CloudFileError, match=message):
        read_cloud(path)


def test_damaged(path: Path) -> None:
    data = bytearray(save_e57(path, Scan(cartesian())).read_bytes())
    data[200] ^= 1
    with pytest.raises(CloudFileError, match=r"cannot be read as E57 .*checksum"):
        read_cloud(io.BytesIO(data))


def test_something_else(path: Path) -> None:
    path.write_bytes(b"ASTM-E58")
    with pytest.raises(CloudFileError, match="not an E57 file; check the file or its suffix"):
        read_cloud(path)


def test_without_pye57(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    save_e57(path, Scan(cartesian()))
    monkeypatch.setitem(sys.modules, "pye57", None)
    message = r"\.e57 files need pye57, which is not installed; pip install 'pcsmooth\[e57\]'"
    with pytest.raises(PcsmoothError, match=message):
        read_cloud(path)


@pytest.mark.parametrize("rows", [1, 7, 100])
def test_scans_in_pieces(path: Path, rows: int) -> None:
    rng = np.random.default_rng(4)
    pose = ((0.5, -0.5, 0.7, 0.1), (1e5, 2e5, 0.3))
    save_e57(
        path,
        Scan({**cartesian(), "intensity": rng.random(N)}, *pose),
        Scan(cartesian(2, n=0)),
        Scan({**cartesian(3, n=5), "colorRed": rng.integers(0, 255, 5, "u1")}, *pose),
    )
    check_reading(path, rows)
    check_reading(path, rows, 2)


def test_damage_in_pieces(path: Path) -> None:
    data = save_e57(path, Scan(cartesian(n=2000))).read_bytes()
    with open_chunks(path) as chunks:
        path.write_bytes(data[:-1])
        with pytest.raises(CloudFileError, match="has changed while it was read"):
            list(chunks.read(7))
