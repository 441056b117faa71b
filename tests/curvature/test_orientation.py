from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

import oracles
from curvature.oriented import orient
from oracles import Array
from pcsmooth.curvature.orientation import Orientation, Rule, parse_orientation
from pcsmooth.errors import InvalidInputError

TORUS, TORUS_NORMALS = oracles.random_torus(3000)
SPHERE = oracles.random_sphere(1500)
CIRCLE = oracles.random_sphere(300, dimension=2)
TWO_SPHERES = np.r_[SPHERE + 5, 0.5 * SPHERE - 5]
TWO_NORMALS = np.r_[SPHERE, SPHERE]

CLOSED = {
    "sphere": (SPHERE, SPHERE),
    "torus": (TORUS, TORUS_NORMALS),
    "two spheres": (TWO_SPHERES, TWO_NORMALS),
    "circle": (3 * CIRCLE + 7, CIRCLE),
}


def with_random_signs(normals: Array, seed: int) -> Array:
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], len(normals))
    return signs[:, np.newaxis] * normals


def random_areas(n: int) -> Array:
    return np.random.default_rng(9).uniform(0.5, 1.5, n)


# --- outward and axis -----------------------------------------------------------------------


@pytest.mark.parametrize("rule", ["auto", "outward"])
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("shape", CLOSED)
def test_closed_shapes_look_outward_everywhere(shape: str, seed: int, rule: Rule) -> None:
    points, outward = CLOSED[shape]
    signed = with_random_signs(outward, seed)
    oriented, reasons = orient(points, signed, Orientation(rule), areas=random_areas(len(points)))
    np.testing.assert_array_equal(oriented, outward)
    assert reasons == {"outward": 2 if shape == "two spheres" else 1}


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("relief", [0.02, 0.1, -0.1])
def test_open_sheets_look_along_the_positive_axis(axis: int, seed: int, relief: float) -> None:
    x, y = oracles.uniform_cloud(2000, 2).T
    slope_x, slope_y = 6 * relief * np.cos(6 * x), -6 * relief * np.sin(6 * y)
    points = np.c_[relief * (np.sin(6 * x) + np.cos(6 * y)), x, y]
    normals = np.c_[np.ones(2000), -slope_x, -slope_y]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points, normals = np.roll(points, axis, axis=1), np.roll(normals, axis, axis=1)
    oriented, reasons = orient(points, with_random_signs(normals, seed))
    np.testing.assert_array_equal(oriented, normals)
    assert reasons == {"axis": 1}


@pytest.mark.parametrize("axis", [0, 1])
def test_open_curves_look_along_the_positive_axis(axis: int) -> None:
    x = np.linspace(0, 1, 200)
    normals = np.c_[np.ones(200), -0.6 * np.cos(6 * x)]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points = np.roll(np.c_[0.1 * np.sin(6 * x), x], axis, axis=1)
    normals = np.roll(normals, axis, axis=1)
    oriented, reasons = orient(points, with_random_signs(normals, 0))
    np.testing.assert_array_equal(oriented, normals)
    assert reasons == {"axis": 1}


def test_each_component_is_decided_on_its_own() -> None:
    sheet = np.c_[oracles.uniform_cloud(800, 2), np.full(800, -9.0)]
    up = np.tile([0.0, 0.0, 1.0], (800, 1))
    points, normals = np.r_[SPHERE, sheet], np.r_[SPHERE, up]
    oriented, reasons = orient(points, with_random_signs(normals, 3))
    np.testing.assert_array_equal(oriented, normals)
    assert reasons == {"axis": 1, "outward": 1}


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_has_more_area_decides_not_what_has_more_points(sign: float) -> None:
    """Two faces of a ridge, most points on the one and most of the area on the other."""
    width, height = oracles.uniform_cloud(1000, 2).T
    many = np.arange(1000) < 800
    slopes = np.where(many, -1.0, 1.0)
    points = np.c_[slopes * width, height, -0.1 * width]
    normals = np.c_[0.1 * slopes, np.zeros(1000), np.ones(1000)] / np.sqrt(1.01)
    areas = np.where(many, 0.1, 1.0)
    direction = Orientation("direction", (sign, 0.0, 0.0))
    for weights, factor in ((None, -1.0), (areas, 1.0)):
        oriented, reasons = orient(points, with_random_signs(normals, 13), direction, areas=weights)
        np.testing.assert_array_equal(oriented, factor * sign * normals)
        assert reasons == {"direction": 1}


def test_missing_normals_stay_missing() -> None:
    normals = with_random_signs(SPHERE, 2)
    normals[::50] = 0
    oriented, _ = orient(SPHERE, normals)
    known = normals.any(axis=1)
    np.testing.assert_array_equal(oriented[known], SPHERE[known])
    assert not oriented[~known].any()


def test_one_point_looks_along_the_positive_axis() -> None:
    oriented, reasons = orient(np.ones((1, 3)), np.array([[0.6, -0.8, 0.0]]))
    np.testing.assert_array_equal(oriented, [[-0.6, 0.8, 0.0]])
    assert reasons == {"axis": 1}


# --- viewpoint and direction ----------------------------------------------------------------


@pytest.mark.parametrize(
    ("viewpoint", "sign"), [((5.0, 5.0, 5.0), -1), ((40.0, 5.0, 5.0), 1), ((0.0, 0.0, 0.0), 1)]
)
def test_what_is_seen_looks_at_the_viewpoint(
    viewpoint: tuple[float, float, float], sign: int
) -> None:
    """From within a sphere its inside is seen; from without, the side towards the viewpoint."""
    sphere = SPHERE + 5
    seen = (np.asarray(viewpoint) - sphere) @ np.eye(3)
    facing = sign * np.einsum("ij,ij->i", seen, SPHERE) > 0
    points, normals = sphere[facing], SPHERE[facing]
    view = Orientation("viewpoint", viewpoint)
    oriented, reasons = orient(points, with_random_signs(normals, 1), view)
    np.testing.assert_array_equal(oriented, sign * normals)
    assert reasons == {"viewpoint": 1}


def test_a_viewpoint_decides_for_every_component() -> None:
    """Between two sheets one looks up and one down."""
    x = oracles.uniform_cloud(800, 2)
    points = np.r_[np.c_[x, np.zeros(800)], np.c_[x, np.full(800, 9.0)]]
    up = np.tile([0.0, 0.0, 1.0], (1600, 1))
    view = Orientation("viewpoint", (0.5, 0.5, 4.0))
    oriented, reasons = orient(points, with_random_signs(up, 2), view)
    np.testing.assert_array_equal(oriented, np.r_[up[:800], -up[800:]])
    assert reasons == {"viewpoint": 2}


def test_a_point_at_the_viewpoint_has_no_say() -> None:
    points = np.c_[oracles.uniform_cloud(300, 2), np.zeros(300)]
    points[7] = [0.5, 0.5, 0.0]
    down = np.tile([0.0, 0.0, -1.0], (300, 1))
    view = Orientation("viewpoint", (0.5, 0.5, 0.0))
    oriented, _ = orient(points, down, view)
    assert len(set(oriented[:, 2])) == 1


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("dimension", [2, 3])
def test_most_of_a_component_looks_along_the_direction(dimension: int, sign: int) -> None:
    sphere = SPHERE if dimension == 3 else oracles.even_circle(300)
    direction = np.arange(1.0, dimension + 1)
    cap = sphere[sphere @ direction > 0.3 * np.linalg.norm(direction)]
    along = Orientation("direction", tuple(sign * direction))
    oriented, reasons = orient(cap, with_random_signs(cap, 4), along)
    np.testing.assert_array_equal(oriented, sign * cap)
    assert reasons == {"direction": 1}


@pytest.mark.parametrize("rule", ["viewpoint", "direction"])
@pytest.mark.parametrize("vector", [(1.0, 2.0), (1.0,), (1.0, 2.0, 3.0, 4.0)])
def test_a_vector_has_as_many_coordinates_as_the_points(
    rule: Rule, vector: tuple[float, ...]
) -> None:
    with pytest.raises(InvalidInputError, match=f"{len(vector)} coordinates and the points 3"):
        orient(SPHERE, SPHERE, Orientation(rule, vector))


def test_only_a_viewpoint_is_a_place() -> None:
    origin = np.array([5e5, 5e6, 100.0])
    seen = Orientation("viewpoint", (5e5 + 1, 5e6 + 2, 97.0)).seen_from(origin)
    assert seen == Orientation("viewpoint", (1.0, 2.0, -3.0))
    rules: list[Rule] = ["auto", "outward", "propagate", "input"]
    for orientation in (*map(Orientation, rules), Orientation("direction", (1.0, 2.0, 3.0))):
        assert orientation.seen_from(origin) == orientation
    with pytest.raises(InvalidInputError, match="coordinates"):
        Orientation("viewpoint", (1.0, 2.0)).seen_from(origin)


# --- propagate ------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", CLOSED)
def test_the_last_point_along_the_last_axis_looks_up(shape: str) -> None:
    """So do closed shapes look outward."""
    points, outward = CLOSED[shape]
    signed = with_random_signs(outward, 5)
    oriented, reasons = orient(points, signed, Orientation("propagate"))
    np.testing.assert_array_equal(oriented, outward)
    assert reasons == {"propagate": 2 if shape == "two spheres" else 1}


def test_a_bowl_looks_inward_when_its_rim_does_not_lie_flat() -> None:
    """The rule looks at one point only: where the normals of the highest one lead."""
    points = SPHERE[SPHERE[:, 2] < -0.2]
    top = points[points[:, 2].argmax()]
    oriented, _ = orient(points, with_random_signs(points, 6), Orientation("propagate"))
    np.testing.assert_array_equal(oriented, np.sign(top[2]) * points)


# --- input ----------------------------------------------------------------------------------


@pytest.mark.parametrize("rule", ["auto", "input"])
def test_each_point_takes_the_sign_of_its_own_normal(rule: Rule) -> None:
    given = with_random_signs(SPHERE + 0.3, 7)  # roughly the normals
    oriented, reasons = orient(SPHERE, with_random_signs(SPHERE, 8), Orientation(rule), given)
    agreement = np.einsum("ij,ij->i", given, oriented)
    assert (agreement > 0).all()
    assert reasons == {"input": 1}


@pytest.mark.parametrize("rule", ["auto", "input"])
def test_points_without_a_given_normal_follow_the_majority(rule: Rule) -> None:
    given = -SPHERE
    given[100:] = 0
    given[:20] *= -1  # 20 of 100 disagree, and keep to it
    oriented, reasons = orient(SPHERE, with_random_signs(SPHERE, 9), Orientation(rule), given)
    np.testing.assert_array_equal(oriented, np.r_[SPHERE[:20], -SPHERE[20:]])
    assert reasons == {"input": 1}


@pytest.mark.parametrize("rule", ["auto", "input"])
def test_a_component_without_given_normals_looks_outward(rule: Rule) -> None:
    given = np.r_[-SPHERE, 0 * SPHERE]
    signed = with_random_signs(TWO_NORMALS, 10)
    oriented, reasons = orient(TWO_SPHERES, signed, Orientation(rule), given)
    np.testing.assert_array_equal(oriented, np.r_[-SPHERE, SPHERE])
    assert reasons == {"input": 1, "outward": 1}


@pytest.mark.parametrize("rule", ["outward", "propagate"])
def test_other_rules_ignore_given_normals(rule: Rule) -> None:
    oriented, _ = orient(SPHERE, with_random_signs(SPHERE, 11), Orientation(rule), -SPHERE)
    np.testing.assert_array_equal(oriented, SPHERE)


# --- words ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("auto", Orientation()),
        (" outward ", Orientation("outward")),
        ("propagate", Orientation("propagate")),
        ("input", Orientation("input")),
        ("viewpoint=1,2.5,-3e2", Orientation("viewpoint", (1.0, 2.5, -300.0))),
        ("viewpoint=0, 0", Orientation("viewpoint", (0.0, 0.0))),
        ("direction=0,0,-1", Orientation("direction", (0.0, 0.0, -1.0))),
    ],
)
def test_rules_are_read(text: str, expected: Orientation) -> None:
    assert parse_orientation(text) == expected


@pytest.mark.parametrize(
    "text",
    [
        "",
        "up",
        "Auto",
        "auto=1",
        "outward=0,0,1",
        "viewpoint",
        "viewpoint=",
        "viewpoint=1",
        "viewpoint=1,2,3,4",
        "viewpoint=1,,3",
        "viewpoint=1;2;3",
        "viewpoint=nan,0,0",
        "direction=inf,0,0",
        "direction=0,0,0",
        "direction=0,-0",
    ],
)
def test_other_words_are_refused(text: str) -> None:
    with pytest.raises(InvalidInputError, match="orientation is"):
        parse_orientation(text)


def test_normals_do_not_move_but_for_their_signs() -> None:
    normals: npt.NDArray[np.float64] = with_random_signs(TORUS_NORMALS, 12)
    oriented, _ = orient(TORUS, normals)
    np.testing.assert_array_equal(np.abs(oriented), np.abs(normals))
