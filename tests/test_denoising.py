from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import pytest

import oracles
from oracles import Array
from pcsmooth.bodies.presets import load_presets
from pcsmooth.denoising import Record, denoise
from pcsmooth.energies.balls import BallEnergy, measure_balls
from pcsmooth.errors import InvalidInputError
from pcsmooth.flows.conjugate_gradients import TOLERANCE
from pcsmooth.flows.euler import Euler
from pcsmooth.flows.flow import run_flow
from pcsmooth.flows.implicit import AUTOMATIC_STEP, Implicit
from pcsmooth.flows.motion import Motion
from pcsmooth.neighbors import mean_spacing

REPORT = Path(__file__).parents[1] / "data" / "report"


def noisy_sphere(n: int, noise: float = 0.02, dimension: int = 3) -> Array:
    rng = np.random.default_rng(1)
    return (1 + noise * rng.normal(size=(n, 1))) * oracles.random_sphere(n, dimension=dimension)


def on_lattice(points: Array) -> Array:
    """Coordinates rounded to multiples of 2^-20."""
    return np.asarray(np.round(points * 2**20) / 2**20)


def test_perimeters_logged_by_the_author_of_the_report() -> None:
    points = np.loadtxt(REPORT / "ellipse-noisy-dense.xy")
    logged = np.loadtxt(REPORT / "perimeter-dense.log")
    result = denoise(points, energy="area", weight="none", radius=15, step=1.0, iterations=59)
    # the log has six digits
    np.testing.assert_allclose([record.area for record in result.history], logged, rtol=4e-6)


@pytest.mark.parametrize(
    ("surface", "area", "distance"),
    [
        (
            lambda n: (oracles.random_sphere(n),) * 2,
            oracles.sphere_area(1.0, 3),
            lambda points: np.linalg.norm(points, axis=1) - 1,
        ),
        (oracles.random_torus, 4 * np.pi**2 * 0.4, oracles.distance_to_torus),
    ],
    ids=["sphere", "torus"],
)
def test_noise_falls_threefold_with_the_defaults(
    surface: Callable[[int], tuple[Array, Array]], area: float, distance: Callable[[Array], Array]
) -> None:
    n = 20_000
    points, normals = surface(n)
    noise = 0.36 * np.sqrt(area / n) * np.random.default_rng(7).normal(size=(n, 1))
    noisy = points + noise * normals
    result = denoise(noisy)
    before, after = (np.sqrt(np.mean(distance(p) ** 2)) for p in (noisy, result.points))
    assert 3 * after < before


@pytest.mark.parametrize("dimension", [2, 3])
def test_rows_that_are_not_finite_pass_through_and_do_not_matter(dimension: int) -> None:
    points = noisy_sphere(300, dimension=dimension)
    bad = np.ones((5, dimension))
    bad[0, 0], bad[1, 1], bad[2, 0] = np.nan, np.inf, -np.inf
    bad[3] = np.nan
    bad[4, 0] = np.array([0x7FF8_0000_0000_0BAD], np.uint64).view(np.float64)[0]
    rows = np.array([0, 100, 200, 300, 300])
    mixed = np.insert(points, rows, bad, axis=0)
    fixed = np.arange(len(mixed)) % 5 == 0
    result = denoise(mixed, fixed=fixed)
    finite = np.isfinite(mixed).all(axis=1)
    np.testing.assert_array_equal(result.finite, finite)
    assert result.points[~finite].tobytes() == mixed[~finite].tobytes()
    assert not result.normals[~finite].any()
    assert not result.mean_curvature[~finite].any()
    assert not result.displacement[~finite].any()

    expected = denoise(points, fixed=fixed[finite])
    for name in ("points", "normals", "mean_curvature", "displacement"):
        assert getattr(result, name)[finite].tobytes() == getattr(expected, name).tobytes()
    assert result.history == expected.history
    assert (result.spacing, result.radius, result.step) == (
        expected.spacing,
        expected.radius,
        expected.step,
    )


@pytest.mark.parametrize("dimension", [2, 3])
def test_map_coordinates_cost_no_digit(dimension: int) -> None:
    points = on_lattice(noisy_sphere(1000, dimension=dimension))
    offsets = np.array([2.0**19, 2.0**22, -(2.0**21)])[:dimension]
    at_home, far, farther = (denoise(points + offset) for offset in (0, offsets, 2 * offsets))
    # both are computed about their centres: the same bits
    assert far.history == farther.history
    assert far.displacement.tobytes() == farther.displacement.tobytes()
    assert far.normals.tobytes() == farther.normals.tobytes()
    # at home about 0: the same up to rounding, which the final sum alone adds to
    np.testing.assert_allclose(far.displacement, at_home.displacement, atol=1e-13)
    for offset, result in ((offsets, far), (2 * offsets, farther)):
        rounding = 0.5 * np.spacing(abs(points + offset))
        assert (abs(result.points - (at_home.points + offset)) <= 2 * rounding + 1e-13).all()


@pytest.mark.parametrize("dimension", [2, 3])
def test_same_bytes_on_any_number_of_threads(dimension: int) -> None:
    points = noisy_sphere(5000, dimension=dimension)
    one, two = (denoise(points, threads=threads, iterations=3) for threads in (1, 2))
    for name in ("points", "normals", "mean_curvature", "displacement"):
        assert getattr(one, name).tobytes() == getattr(two, name).tobytes()
    assert one.history == two.history
    assert one.spacing == two.spacing


@pytest.mark.parametrize("dimension", [2, 3])
def test_result_describes_the_run(dimension: int) -> None:
    points = noisy_sphere(400, dimension=dimension)
    seen: list[Record] = []
    result = denoise(points, iterations=4, on_state=seen.append)
    assert tuple(seen) == result.history
    assert [record.iteration for record in seen] == [0, 1, 2, 3, 4]
    assert result.spacing == mean_spacing(points)
    assert result.radius == 2 * result.spacing
    assert result.step > 0
    assert result.finite.all()
    for record, cloud in ((seen[0], points), (seen[-1], result.points)):
        union = measure_balls(cloud, result.radius)
        assert record.volume == pytest.approx(union.volume, rel=1e-12)
        assert record.area == pytest.approx(union.area, rel=1e-12)
    moves = np.linalg.norm(denoise(points, iterations=1).points - points, axis=1)
    assert (seen[0].mean_move, seen[0].max_move) == (0, 0)
    assert seen[1].mean_move == pytest.approx(moves.mean(), rel=1e-12)
    assert seen[1].max_move == pytest.approx(moves.max(), rel=1e-12)
    expected = np.linalg.norm(result.points - points, axis=1)
    np.testing.assert_allclose(result.displacement, expected, atol=1e-15)


def test_options_reach_the_flow() -> None:
    points = noisy_sphere(300)
    one_by_one = points
    for _ in range(3):
        one_by_one = denoise(
            one_by_one, energy="area", weight="boundary", radius=0.3, iterations=1, step=1e-4
        ).points
    at_once = denoise(
        points, energy="area", weight="boundary", radius="0.3", iterations=3, step=1e-4
    )
    np.testing.assert_allclose(at_once.points, one_by_one, atol=1e-14)
    assert (at_once.radius, at_once.step) == (0.3, 1e-4)


def test_input_is_left_alone() -> None:
    points = noisy_sphere(100)
    before = points.copy()
    result = denoise(points)
    np.testing.assert_array_equal(points, before)
    assert (result.points != points).any()


def test_lists_of_integers_are_points() -> None:
    square = [[0, 0], [0, 10], [10, 10], [10, 0]]
    result = denoise(square, radius=6, iterations=1)
    assert result.points.dtype == np.float64
    assert (np.ptp(result.points, axis=0) < 10).all()


def test_fixed_points_stay() -> None:
    points = noisy_sphere(200)
    fixed = np.arange(200) < 50
    result = denoise(points, fixed=fixed.astype(int).tolist())
    assert result.points[:50].tobytes() == points[:50].tobytes()
    assert (result.displacement[50:] > 0).all()


def test_zeros_of_points_that_stay_keep_their_sign() -> None:
    points = noisy_sphere(100)
    points[0], points[1] = [-0.0, 0.6, 0.8], [np.nan, -0.0, 1.0]
    result = denoise(points, fixed=np.arange(100) == 0)
    assert result.points[:2].tobytes() == points[:2].tobytes()


@pytest.mark.parametrize(
    "distance",
    [1e12, 1e150, 1e300],
)
def test_outliers_stay_and_do_not_matter(distance: float) -> None:
    points = noisy_sphere(300)
    outlier = np.array([[distance, 0.0, 0.0]])
    result, expected = denoise(np.r_[points, outlier]), denoise(points)
    np.testing.assert_array_equal(result.points[-1:], outlier)
    np.testing.assert_allclose(result.points[:-1], expected.points, rtol=0, atol=1e-13)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_single_point_stays(dimension: int) -> None:
    point = np.full((1, dimension), 3.0)
    result = denoise(point, radius=0.5)
    np.testing.assert_array_equal(result.points, point)
    assert not result.normals.any()
    assert not result.mean_curvature.any()
    assert result.history[-1].volume == pytest.approx(oracles.ball_volume(0.5, dimension))


SQUARE = [[0, 0], [0, 1], [1, 1], [1, 0]]


@pytest.mark.parametrize(
    ("points", "options", "message"),
    [
        ([1.0, 2.0, 3.0], {}, r"shape \(3,\); they must be \(n, 2\) or \(n, 3\)"),
        (np.zeros((2, 4)), {}, r"shape \(2, 4\)"),
        (np.zeros((2, 3, 3)), {}, r"shape \(2, 3, 3\)"),
        (np.zeros((0, 3)), {}, "no point with finite coordinates"),
        ([[np.nan, 0.0], [0.0, np.inf]], {}, "no point with finite coordinates"),
        (SQUARE, {"energy": "mass"}, "energy is 'mass'; it must be volume or area"),
        (SQUARE, {"weight": "heavy"}, "weight is 'heavy'; it must be none, cell or boundary"),
        (SQUARE, {"radius": "wide"}, "radius 'wide' is not a positive length"),
        (SQUARE, {"radius": -1}, "radius '-1' is not a positive length"),
        (SQUARE, {"iterations": -1}, "iterations is -1; it must be 0 or more and whole, or auto"),
        (SQUARE, {"iterations": 1.5}, "iterations is 1.5"),
        (SQUARE, {"scheme": "verlet"}, "scheme is 'verlet'; it must be euler or implicit"),
        (SQUARE, {"order": 2}, "order is 2; only the scheme implicit has an order"),
        (SQUARE, {"order": 3, "scheme": "implicit"}, "order is 3; it must be 1 or 2"),
        (SQUARE, {"motion": "wild"}, "motion is 'wild'; it must be free or normal"),
        (SQUARE, {"max_move": "auto"}, "max_move 'auto' is not a positive length"),
        ([[1.0, 2.0]] * 5, {"radius": 1, "max_move": "1x"}, "max_move '1x' is 0 for this cloud"),
        (SQUARE, {"stop": 0}, "stop is 0; it must be positive and finite, or None"),
        (SQUARE, {"stop": "soon"}, "stop is 'soon'"),
        (SQUARE, {"stop": np.inf}, "stop is inf"),
        (SQUARE, {"step": 0.0}, "step is 0.0; it must be positive and finite, or auto"),
        (SQUARE, {"step": -1}, "step is -1"),
        (SQUARE, {"step": np.nan}, "step is nan"),
        (SQUARE, {"step": np.inf}, "step is inf"),
        (SQUARE, {"step": "big"}, "step is 'big'"),
        (SQUARE, {"fixed": [True]}, r"fixed has shape \(1,\); it must have one value per point"),
        (SQUARE, {"fixed": [[True]] * 4}, r"fixed has shape \(4, 1\)"),
        ([[1.0, 2.0]], {}, "radius 'auto' is 0 for this cloud"),
        ([[1.0, 2.0]] * 5, {"radius": "3x"}, "radius '3x' is 0 for this cloud"),
        ([[1.0, 2.0]] * 5, {"radius": "2%"}, "radius '2%' is 0 for this cloud"),
    ],
)
def test_bad_input_is_refused(points: npt.ArrayLike, options: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        denoise(points, **options)


@pytest.mark.parametrize("points", [[[0.0, 1.0], [2.0]], [["a", "b"]]])
def test_points_that_are_no_numbers_are_refused(points: list[list[object]]) -> None:
    with pytest.raises(InvalidInputError, match="points are not an array of numbers"):
        denoise(points)  # type: ignore[arg-type]


def test_numpy_numbers_are_options() -> None:
    points = noisy_sphere(100)
    plain = denoise(points, iterations=2, step=0.25)
    typed = denoise(points, iterations=np.int64(2), step=np.float32(0.25))  # type: ignore[arg-type]
    np.testing.assert_array_equal(typed.points, plain.points)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("order", [1, 2])
def test_implicit_scheme(dimension: int, order: Literal[1, 2]) -> None:
    points = noisy_sphere(800, dimension=dimension)
    result = denoise(points, scheme="implicit", order=order)
    assert [record.iteration for record in result.history] == [0, 1, 2]
    assert result.order == order
    assert result.step == pytest.approx(AUTOMATIC_STEP[order] * result.spacing**2)
    assert len(result.solver_iterations) == 2
    assert min(result.solver_iterations) > 1
    assert 0 < result.solver_error < TOLERANCE
    spread = np.linalg.norm(result.points, axis=1).std()
    assert spread < 0.8 * np.linalg.norm(points, axis=1).std()
    by_hand = Implicit(result.spacing, order)
    *_, expected = run_flow(BallEnergy(result.radius), points, by_hand, 2)
    np.testing.assert_allclose(result.points, expected.points, atol=1e-13)


def test_euler_solves_no_equations() -> None:
    result = denoise(noisy_sphere(100))
    assert (result.order, result.solver_iterations, result.solver_error) == (None, (), 0)
    assert (result.max_move, result.stopped_early) == (None, False)


def test_restraints_reach_the_flow() -> None:
    points = noisy_sphere(500)
    result = denoise(points, motion="normal", max_move="0.1x", keep_volume=True)
    assert result.max_move == pytest.approx(0.1 * result.spacing)
    motion = Motion(along_normals=True, keeps_volume=True, longest=0.1 * result.spacing)
    *_, expected = run_flow(BallEnergy(result.radius), points, Euler(), 6, motion=motion)
    np.testing.assert_allclose(result.points, expected.points, atol=1e-13)
    assert result.displacement.max() == pytest.approx(result.max_move)
    # the automatic numbers of steps and the orders are what they say
    implicit = denoise(points, scheme="implicit", motion="normal")
    assert (
        implicit.points.tobytes()
        == denoise(
            points, scheme="implicit", order=2, iterations=2, motion="normal"
        ).points.tobytes()
    )


def test_stop_counts_in_spacings() -> None:
    points = noisy_sphere(500)
    free = denoise(points, iterations=20)
    limit = 1.001 * free.history[10].mean_move / free.spacing
    result = denoise(points, iterations=20, stop=limit)
    assert result.stopped_early
    last = result.history[-1]
    assert last.iteration <= 10
    assert last.mean_move < limit * result.spacing
    assert all(record.mean_move >= limit * result.spacing for record in result.history[1:-1])
    assert result.points.tobytes() == denoise(points, iterations=last.iteration).points.tobytes()


FLOWS: dict[str, dict[str, Any]] = {
    "first order": {"scheme": "implicit", "order": 1, "keep_volume": True},
    "second order": {"scheme": "implicit", "motion": "normal", "max_move": "1x"},
    "restrained": {"motion": "normal", "keep_volume": True},
}


@pytest.mark.parametrize("options", FLOWS.values(), ids=FLOWS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_other_flows_do_not_depend_on_threads_or_map_coordinates(
    dimension: int, options: dict[str, Any]
) -> None:
    points = on_lattice(noisy_sphere(3000, dimension=dimension))
    offset = np.array([2.0**19, 2.0**22, -(2.0**21)])[:dimension]
    one, two = (denoise(points, threads=threads, **options) for threads in (1, 2))
    assert one.points.tobytes() == two.points.tobytes()
    far = denoise(points + offset, **options)
    np.testing.assert_allclose(far.displacement, one.displacement, atol=1e-9)
    rounding = np.spacing(abs(points + offset))
    assert (abs(far.points - (one.points + offset)) <= rounding + 1e-9).all()


def test_implicit_steps_with_polyhedra_are_of_first_order() -> None:
    points = noisy_sphere(200)
    cube = load_presets()["cube"]
    result = denoise(points, polyhedron=cube, scheme="implicit")
    assert result.order == 1
    assert result.history[-1].volume < result.history[0].volume
    with pytest.raises(InvalidInputError, match="the order is 2, which is for balls"):
        denoise(points, polyhedron=cube, scheme="implicit", order=2)
