"""Polygons: which points are in them, and the files that they are read from."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.path import Path as Outline

from pcsmooth.errors import CloudFileError
from pcsmooth.files.polygon import Polygon
from pcsmooth.files.polygon_file import read_polygon

SQUARE = [[0, 0], [4, 0], [4, 4], [0, 4], [0, 0]]
HOLE = [[1, 1], [1, 2], [2, 2], [2, 1], [1, 1]]
FAR = [[10, 0], [12, 0], [11, 2], [10, 0]]

ASKED = np.array([
    [0.5, 0.5], [1.5, 1.5], [1.0, 1.5], [4.0, 2.0], [0.0, 0.0], [11.0, 1.0], [10.5, 1.0],
    [5.0, 0.0], [np.nan, 1.0], [3.0, np.inf],
])  # fmt: skip
IN_SQUARE = [0, 2, 3, 4]


def saved(tmp_path: Path, text: str | bytes) -> Path:
    path = tmp_path / "area"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def polygon(*rings: Any) -> dict[str, Any]:
    return {"type": "Polygon", "coordinates": list(rings)}


def feature(geometry: Any) -> dict[str, Any]:
    return {"type": "Feature", "properties": {}, "geometry": geometry}


def wkt(*rings: Any) -> str:
    return "(" + ", ".join(
        "(" + ", ".join(" ".join(map(str, place)) for place in ring) + ")" for ring in rings
    ) + ")"  # fmt: skip


BOTH = {"type": "MultiPolygon", "coordinates": [[SQUARE, HOLE], [FAR]]}
BOTH_WKT = f"({wkt(SQUARE, HOLE)}, {wkt(FAR)})"


@pytest.mark.parametrize(
    ("text", "rows"),
    [
        (json.dumps(polygon(SQUARE, HOLE)), IN_SQUARE),
        (json.dumps(BOTH), [*IN_SQUARE, 5, 6]),
        (json.dumps(feature(BOTH)), [*IN_SQUARE, 5, 6]),
        (json.dumps({"type": "GeometryCollection", "geometries": [polygon(FAR)]}), [5, 6]),
        (
            json.dumps({"type": "FeatureCollection",
                        "features": [feature(polygon(FAR)), feature(None)]}),
            [5, 6],
        ),
        (json.dumps(polygon([[*place, 7.0] for place in SQUARE])), [0, 1, 2, 3, 4]),
        (json.dumps(polygon()), []),
        ('{"type": "FeatureCollection", "features": []}', []),
        ("\ufeff" + json.dumps(polygon(FAR)), [5, 6]),
        (f"POLYGON {wkt(SQUARE, HOLE)}", IN_SQUARE),
        (f" multipolygon{BOTH_WKT}\n", [*IN_SQUARE, 5, 6]),
        (f"GEOMETRYCOLLECTION (POLYGON{wkt(FAR)}, MULTIPOLYGON EMPTY)", [5, 6]),
        (f"SRID=32632;POLYGON{wkt(FAR)}", [5, 6]),
        ("POLYGON Z ((10 0 1, 12 0 1, 11 2 1, 10 0 1))", [5, 6]),
        ("POLYGONZM ((10 0 1 0, 1.2e1 0 1 0, 11. 2 1 0, +10 -0 1 0))", [5, 6]),
        ("POLYGON EMPTY", []),
        ("MULTIPOLYGON (EMPTY, ((10 0, 12 0, 11 2, 10 0)))", [5, 6]),
    ],
)  # fmt: skip
def test_points_that_are_in(tmp_path: Path, text: str, rows: list[int]) -> None:
    area = read_polygon(saved(tmp_path, text))
    assert np.flatnonzero(area.contains(ASKED)).tolist() == rows


@pytest.mark.parametrize(
    ("text", "cause"),
    [
        ("", "is empty"),
        (b"\xff\xfe\x00", "it is no text"),
        (json.dumps(polygon(SQUARE))[:-9], "is no JSON"),
        ('{"type": "Polygon", "coordinates": ' + "[" * 100_000, "nested too deeply"),
        ("{" * 10, "is no JSON"),
        (f'{{"type": "Polygon", "coordinates": [[[{"9" * 5000}, 1]]]}}', "is no JSON"),
        ("[1, 2]", "no GeoJSON object"),
        ('{"type": 3}', "no GeoJSON object"),
        ('{"type": "Point", "coordinates": [1, 2]}', "holds a Point, which is no polygon"),
        ('{"type": "Topology"}', "holds a Topology"),
        (json.dumps({"type": "FeatureCollection", "features": 3}), "no list of its parts"),
        (json.dumps({"type": "MultiPolygon"}), "a MultiPolygon has no list of its parts"),
        (json.dumps({"type": "Polygon"}), "polygon 1 has no list of rings"),
        (json.dumps(polygon(3)), "ring 1 of polygon 1 is no list of positions"),
        (json.dumps(polygon(SQUARE, [[1, "2"]])), "ring 2 of polygon 1 has a position"),
        (json.dumps(polygon([[True, 1]] * 4)), "a position that is not two numbers"),
        (json.dumps(polygon([[1]] * 4)), "a position that is not two numbers"),
        (json.dumps(polygon(SQUARE[:-1])), "ring 1 of polygon 1 is not closed"),
        (json.dumps(polygon(SQUARE[:3])), "has 3 positions; a ring has four at least"),
        (json.dumps(polygon([[math.nan, 1]] * 4)), "not finite or too large"),
        (json.dumps(polygon([[1e200, 1]] * 4)), "not finite or too large"),
        (json.dumps(polygon([[10**400, 1]] * 4)), "not finite or too large"),
        ("POLYGON ((0 0, 1 0, 1 1, 0 1))", "is not closed"),
        ("POLYGON ((0 0, 1 0, 1 1, 0", "there is its end in place of two to four numbers"),
        ("POLYGON ((0 0, 1 0, 1 1, 0 0)", r"there is its end in place of '\)'"),
        ("POLYGON ((0 0, 1 0, 1 1, 0 0)) x", "there is 'x' in place of the end"),
        ("POLYGON ((0 0, 1 0, 1 1, 0 0)) ;", "there is ';' in place of the end"),
        ("POLYGON ((0 0 0 0 0))", "there is '[)]' in place of two to four numbers"),
        ("POLYGON 1", r"there is '1' in place of '\('"),
        ("POLYGON ((1e999 0, 1 0, 1 1, 0 0))", "not finite or too large"),
        ("LINESTRING (0 0, 1 1)", "holds a LINESTRING, which is no polygon"),
        ("<svg/>", "there is '<svg/>' in place of a polygon"),
        ("GEOMETRYCOLLECTION (" * 60, "nested too deeply"),
    ],
)
def test_what_is_no_polygon(tmp_path: Path, text: str | bytes, cause: str) -> None:
    path = saved(tmp_path, text)
    with pytest.raises(CloudFileError, match=cause) as caught:
        read_polygon(path)
    assert caught.value.path == str(path)


def test_there_must_be_a_file(tmp_path: Path) -> None:
    with pytest.raises(CloudFileError, match="none"):
        read_polygon(tmp_path / "none")


def star(n_points: int, center: tuple[float, float], size: float) -> Any:
    """Give the ring of a star with uneven points."""
    angles = np.linspace(0.0, 2.0 * np.pi, n_points, endpoint=False)
    lengths = size * np.random.default_rng(n_points).uniform(0.2, 1.0, n_points)
    ring = np.c_[np.cos(angles), np.sin(angles)] * lengths[:, np.newaxis] + center
    return np.r_[ring, ring[:1]]


def test_stars_are_what_matplotlib_says() -> None:
    center = (5e5, 5.4e6)
    ring = star(1001, center, 300.0)
    points = np.random.default_rng(0).uniform(-320.0, 320.0, (20_000, 2)) + center
    actual = Polygon("", ((ring,),)).contains(points)
    expected = Outline(ring).contains_points(points)
    assert 0.1 < expected.mean() < 0.9
    np.testing.assert_array_equal(actual, expected)


def test_a_point_is_in_or_not_whatever_is_beside_it() -> None:
    points = np.round(np.random.default_rng(1).uniform(-2.0, 2.0, (500, 2)), 1)
    area = Polygon("", ((np.round(star(9, (0.0, 0.0), 2.0), 1),),))
    alone = [bool(area.contains(point[np.newaxis])[0]) for point in points]
    assert area.contains(points).tolist() == alone
    assert 0 < sum(alone) < 500


def test_the_boundary_is_in_as_far_as_decimals_tell() -> None:
    ring = np.array([[500_000.1, 5_400_000.2], [500_100.4, 5_400_033.7], [500_050.3, 5_400_099.9]])
    ring = np.r_[ring, ring[:1]]
    shares = np.linspace(0.0, 1.0, 11)[:, np.newaxis]
    sides = [start + shares * (end - start) for start, end in pairwise(ring)]
    points = np.round(np.concatenate(sides), 9)
    center = ring[:-1].mean(axis=0)
    area = Polygon("", ((ring,),))
    assert area.contains(points).all()
    assert not area.contains(points + 1e-3 * (points - center)).any()


def test_areas_that_overlap_are_one() -> None:
    square = np.array(SQUARE, float)
    area = Polygon("", ((square,), (square + 1.0,)))
    assert area.contains(np.array([[0.5, 0.5], [2.0, 2.0], [4.5, 4.5]])).all()
    assert area.extent is not None
    assert area.extent.tolist() == [[0.0, 0.0], [5.0, 5.0]]
