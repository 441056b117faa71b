from __future__ import annotations

from collections.abc import Callable
from itertools import groupby
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt
import pytest

import oracles
from filters.whole import filter_whole, plan_of
from oracles import Array
from pcsmooth.bodies.presets import load_presets
from pcsmooth.energies.balls import BallEnergy, measure_balls
from pcsmooth.energies.protocol import Quantity
from pcsmooth.errors import InvalidInputError
from pcsmooth.filters.design import DESIGN
from pcsmooth.flows.conjugate_gradients import TOLERANCE
from pcsmooth.flows.euler import Euler
from pcsmooth.flows.flow import run_flow
from pcsmooth.flows.implicit import AUTOMATIC_STEP, STEP_OF_NOISE, Implicit
from pcsmooth.flows.restraint import Restraint
from pcsmooth.methods.filter import Filter
from pcsmooth.methods.keywords import SchemeName
from pcsmooth.methods.motion import Direction
from pcsmooth.neighbors.spacing import mean_spacing
from pcsmooth.point_order import take_in_order
from pcsmooth.positions import usable_rows
from pcsmooth.progress import Callback, Progress
from pcsmooth.python.denoising import denoise
from pcsmooth.python.estimating import estimate_curvature
from pcsmooth.record import Record

#: Least factor by which the error falls. Six Euler steps leave a third. The filter's passes leave
#: 1.2 of the noise's variance over the 15 points of a neighbourhood, 1 / 3.5 of the noise; its last
#: step, over 128 points, 1 / 10 where it can be taken in full.
FACTORS: dict[SchemeName, float] = {"auto": 5, "filter": 5, "euler": 3}

REPORT = Path(__file__).parents[1] / "data" / "report"


def noisy_sphere(n: int, noise: float = 0.02, dimension: int = 3) -> Array:
    rng = np.random.default_rng(1)
    return (1 + noise * rng.normal(size=(n, 1))) * oracles.random_sphere(n, dimension=dimension)


def states_into(seen: list[Record]) -> Callback:
    """What notes the states that are reached."""

    def tell(progress: Progress) -> None:
        if progress.record is not None:
            seen.append(progress.record)

    return tell


def in_order(points: Array) -> Array:
    """Finite points as they are taken."""
    return take_in_order(points, usable_rows(points)).points


def on_lattice(points: Array) -> Array:
    """Coordinates rounded to multiples of 2^-20."""
    return np.asarray(np.round(points * 2**20) / 2**20)


def test_perimeters_logged_by_the_author_of_the_report() -> None:
    points = np.loadtxt(REPORT / "ellipse-noisy-dense.xy")
    logged = np.loadtxt(REPORT / "perimeter-dense.log")
    result = denoise(points, energy="area", weight="none", radius=15, step=1.0, iterations=59)
    # the log has six digits
    np.testing.assert_allclose([record.area for record in result.history], logged, rtol=4e-6)


@pytest.mark.slow
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
def test_noise_falls_with_the_defaults(
    surface: Callable[[int], tuple[Array, Array]], area: float, distance: Callable[[Array], Array]
) -> None:
    n = 20_000
    points, normals = surface(n)
    noise = 0.36 * np.sqrt(area / n) * np.random.default_rng(7).normal(size=(n, 1))
    noisy = points + noise * normals
    before = np.sqrt(np.mean(distance(noisy) ** 2))
    for scheme, factor in FACTORS.items():
        result = denoise(noisy, scheme=scheme)
        assert factor * np.sqrt(np.mean(distance(result.points) ** 2)) < before


@pytest.mark.parametrize("scheme", ["filter", "euler"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_rows_that_are_not_finite_pass_through_and_do_not_matter(
    dimension: int, scheme: SchemeName
) -> None:
    points = noisy_sphere(300, dimension=dimension)
    bad = np.ones((5, dimension))
    bad[0, 0], bad[1, 1], bad[2, 0] = np.nan, np.inf, -np.inf
    bad[3] = np.nan
    bad[4, 0] = np.array([0x7FF8_0000_0000_0BAD], np.uint64).view(np.float64)[0]
    rows = np.array([0, 100, 200, 300, 300])
    mixed = np.insert(points, rows, bad, axis=0)
    fixed = np.arange(len(mixed)) % 5 == 0
    result = denoise(mixed, fixed=fixed, scheme=scheme)
    finite = np.isfinite(mixed).all(axis=1)
    np.testing.assert_array_equal(result.finite, finite)
    assert result.points[~finite].tobytes() == mixed[~finite].tobytes()
    assert not result.normals[~finite].any()
    assert not result.mean_curvature[~finite].any()
    assert not result.displacement[~finite].any()

    expected = denoise(points, fixed=fixed[finite], scheme=scheme)
    for name in ("points", "normals", "mean_curvature", "displacement"):
        assert getattr(result, name)[finite].tobytes() == getattr(expected, name).tobytes()
    assert result.history == expected.history
    assert (result.spacing, result.radius, result.step) == (
        expected.spacing,
        expected.radius,
        expected.step,
    )


@pytest.mark.parametrize("scheme", ["filter", "euler"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_map_coordinates_cost_no_digit(dimension: int, scheme: SchemeName) -> None:
    points = on_lattice(noisy_sphere(1000, dimension=dimension))
    offsets = np.array([2.0**19, 2.0**22, -(2.0**21)])[:dimension]
    at_home, far, farther = (
        denoise(points + offset, scheme=scheme) for offset in (0, offsets, 2 * offsets)
    )
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
    result = denoise(points, iterations=4, callback=states_into(seen))
    assert tuple(seen) == result.history
    assert [record.iteration for record in seen] == [0, 1, 2, 3, 4]
    assert result.spacing == mean_spacing(in_order(points))
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


@pytest.mark.parametrize("scheme", ["filter", "euler"])
def test_fixed_points_stay(scheme: SchemeName) -> None:
    points = noisy_sphere(200)
    fixed = np.arange(200) < 50
    result = denoise(points, fixed=fixed.astype(int).tolist(), scheme=scheme)
    assert result.points[:50].tobytes() == points[:50].tobytes()
    assert (result.displacement[50:] > 0).all()


@pytest.mark.parametrize("scheme", ["filter", "euler"])
def test_zeros_of_points_that_stay_keep_their_sign(scheme: SchemeName) -> None:
    points = noisy_sphere(100)
    points[0], points[1] = [-0.0, 0.6, 0.8], [np.nan, -0.0, 1.0]
    result = denoise(points, fixed=np.arange(100) == 0, scheme=scheme)
    assert result.points[:2].tobytes() == points[:2].tobytes()


@pytest.mark.parametrize(
    "distance",
    [1e12, 1e150, 1e300],
)
def test_outliers_stay_and_do_not_matter_to_a_flow(distance: float) -> None:
    points = noisy_sphere(300)
    outlier = np.array([[distance, 0.0, 0.0]])
    result, expected = (
        denoise(cloud, scheme="euler") for cloud in (np.r_[points, outlier], points)
    )
    np.testing.assert_array_equal(result.points[-1:], outlier)
    np.testing.assert_allclose(result.points[:-1], expected.points, rtol=0, atol=1e-13)


@pytest.mark.parametrize("scheme", ["filter", "euler", "implicit"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_single_point_stays(dimension: int, scheme: SchemeName) -> None:
    point = np.full((1, dimension), 3.0)
    result = denoise(point, radius=0.5, scheme=scheme)
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
        (SQUARE, {"iterations": "3"}, "iterations is '3'"),
        (SQUARE, {"iterations": True}, "iterations is True"),
        (SQUARE, {"iterations": np.inf}, "iterations is inf"),
        (
            SQUARE,
            {"scheme": "verlet"},
            "scheme is 'verlet'; it must be auto, filter, euler or",
        ),
        (SQUARE, {"order": 2}, "order is given and the scheme is filter, which has no such option"),
        (
            SQUARE,
            {"order": 1, "scheme": "filter"},
            "order is given and the scheme is filter, which has no such option",
        ),
        (SQUARE, {"order": 3, "scheme": "implicit"}, "order is 3; it must be 1 or 2"),
        (SQUARE, {"gradient": "exact"}, "gradient is 'exact'; it must be analytic or autodiff"),
        (
            SQUARE,
            {"gradient": "autodiff", "scheme": "implicit"},
            "gradient is 'autodiff' and the scheme is implicit.*choose the scheme euler",
        ),
        (SQUARE, {"motion": "wild"}, "motion is 'wild'; it must be free, normal or ray"),
        (SQUARE, {"max_move": "auto"}, "max_move 'auto' is not a positive length"),
        ([[1.0, 2.0]] * 5, {"radius": 1, "max_move": "1x"}, "makes the max_move '1x' 0; give"),
        (SQUARE, {"noise": "auto"}, "noise 'auto' is not a positive length"),
        (SQUARE, {"noise": 0.0}, "noise '0.0' is not a positive length"),
        (SQUARE, {"noise": "-1x"}, "noise '-1x' is not a positive length"),
        (SQUARE, {"noise": "0%"}, "noise '0%' is not a positive length"),
        (SQUARE, {"noise": np.nan}, "noise 'nan' is not a positive length"),
        (SQUARE, {"noise": np.inf}, "noise 'inf' is not a positive length"),
        (
            [[1.0, 2.0]] * 5,
            {"scheme": "filter", "radius": 1, "noise": "0.5x"},
            "makes the noise '0.5x' 0; give the noise as a length",
        ),
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
        ([[1.0, 2.0]], {}, "^there is only one point, which has no spacing; give the radius"),
        ([[1.0, 2.0]] * 5, {"radius": "3x"}, "^all points are at one place, which makes the"),
        ([[1.0, 2.0]] * 5, {"radius": "2%"}, "makes the radius '2%' 0; give the radius as a"),
    ],
)
def test_bad_input_is_refused(points: npt.ArrayLike, options: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        denoise(points, **options)


@pytest.mark.parametrize("points", [[[0.0, 1.0], [2.0]], [["a", "b"]]])
def test_points_that_are_no_numbers_are_refused(points: list[list[object]]) -> None:
    with pytest.raises(InvalidInputError, match=r"points are not an array of real numbers"):
        denoise(points)  # type: ignore[arg-type]


def test_numpy_numbers_are_options() -> None:
    points = noisy_sphere(100)
    plain = denoise(points, iterations=2, step=0.25)
    typed = denoise(points, iterations=np.int64(2), step=np.float32(0.25))  # type: ignore[arg-type]
    np.testing.assert_array_equal(typed.points, plain.points)


def outlier_cloud() -> Array:
    """A noisy sphere of 2,000 points, two points near it and one far from it."""
    far = [[1.4, 0.0, 0.0], [0.0, 1.3, 0.0], [3.0, 0.0, 0.0]]
    return np.concatenate([noisy_sphere(2000), np.array(far)])


#: Options that only flows have: each makes a flow of the default.
FLOWS: dict[str, dict[str, Any]] = {
    "energy": {"energy": "volume"},
    "weight": {"weight": "cell"},
    "iterations": {"iterations": 6},
    "step": {"step": 0.01},
    "stop": {"stop": 0.01},
    "gradient": {"gradient": "analytic"},
    "polyhedron": {"polyhedron": load_presets()["cube"]},
}


class TestChoice:
    def test_the_filter_is_the_default(self) -> None:
        points = noisy_sphere(200)
        result, told = denoise(points), denoise(points, scheme="filter")
        assert (result.method.name, result.step, len(result.history)) == ("filter", 0.0, 2)
        assert result.method == Filter()
        assert result.points.tobytes() == told.points.tobytes()

    @pytest.mark.parametrize(
        "options",
        [{"motion": "normal"}, {"max_move": "1x"}, {"keep_volume": True}, {"noise": "0.1x"},
         {"support": 30}, {"radius": "auto"}, {"radius": " AUTO"}, {"union": "naive"}],
        ids=str,
    )  # fmt: skip
    def test_what_filters_have_too_chooses_the_filter(self, options: dict[str, Any]) -> None:
        assert denoise(noisy_sphere(100), **options).method.name == "filter"

    @pytest.mark.parametrize("options", [*FLOWS.values(), {"radius": "2x"}], ids=[*FLOWS, "radius"])
    def test_options_of_flows_choose_the_flow(self, options: dict[str, Any]) -> None:
        points = noisy_sphere(100)
        result, told = denoise(points, **options), denoise(points, scheme="euler", **options)
        assert (result.method.name, result.plan, result.outliers) == ("euler", None, None)
        assert result.points.tobytes() == told.points.tobytes()

    @pytest.mark.parametrize(("name", "options"), FLOWS.items(), ids=FLOWS)
    def test_the_filter_refuses_them(self, name: str, options: dict[str, Any]) -> None:
        message = f"{name} is given and the scheme is filter, which has no such option"
        with pytest.raises(InvalidInputError, match=message):
            denoise(noisy_sphere(100), scheme="filter", **options)

    def test_the_filter_takes_a_radius_for_the_normals(self) -> None:
        points = noisy_sphere(300)
        result, other = (denoise(points, scheme="filter", radius=r) for r in ("2x", "4x"))
        assert other.radius == pytest.approx(2 * result.radius)
        np.testing.assert_allclose(other.points, result.points, rtol=0, atol=1e-13)
        assert other.history[0].volume > result.history[0].volume

    @pytest.mark.parametrize(
        "options", [{"scheme": "euler"}, {"radius": "2x"}, *FLOWS.values()], ids=str
    )
    def test_euler_refuses_noise(self, options: dict[str, Any]) -> None:
        with pytest.raises(InvalidInputError, match="noise is given and the scheme is euler"):
            denoise(noisy_sphere(100), noise=0.01, **options)


class TestNoise:
    def test_forms(self) -> None:
        points = noisy_sphere(300)
        diagonal = np.linalg.norm(np.ptp(points, axis=0))
        forms: list[tuple[float | str, float]] = [
            (0.03, 0.03),
            (np.float64(0.03), 0.03),
            ("0.03", 0.03),
            ("0.5x", 0.5 * mean_spacing(points)),
            ("1%", 0.01 * float(diagonal)),
        ]
        for form, length in forms:
            result, absolute = denoise(points, noise=form), denoise(points, noise=length)
            assert result.plan is not None
            assert result.plan.noise.deviation == pytest.approx(length, rel=1e-15)
            np.testing.assert_allclose(result.points, absolute.points, rtol=0, atol=1e-12)

    @pytest.mark.parametrize("dimension", [2, 3])
    def test_measured(self, dimension: int) -> None:
        points = noisy_sphere(2000, dimension=dimension)
        result = denoise(points)
        assert result.plan is not None
        assert result.plan.noise.deviation == pytest.approx(0.02, rel=0.1)
        told = denoise(points, noise=result.plan.noise.deviation)
        assert told.points.tobytes() == result.points.tobytes()

    @pytest.mark.slow
    @pytest.mark.parametrize("dimension", [2, 3])
    def test_more_smooths_more(self, dimension: int) -> None:
        points = noisy_sphere(2000, dimension=dimension)
        results = [denoise(points, noise=noise) for noise in (1e-12, 0.002, 0.008, 0.02)]
        spreads = [np.linalg.norm(result.points, axis=1).std() for result in results]
        assert (np.diff(spreads) < 0).all()
        moves = [result.displacement.mean() for result in results]
        assert (np.diff(moves) > 0).all()
        assert moves[0] < 1e-10

    def test_implicit_steps_are_made_of_it(self) -> None:
        points = noisy_sphere(300)
        result, twice = (denoise(points, scheme="implicit", noise=noise) for noise in (0.01, 0.02))
        assert twice.step == pytest.approx(2 * result.step)
        assert result.step == pytest.approx(STEP_OF_NOISE[2] * 0.01 * result.spacing)
        assert (result.plan is None, result.outliers) == (False, None)

    @pytest.mark.parametrize("noise", [1e-103, "99%"])
    def test_absurd_ones_do_no_harm(self, noise: float | str) -> None:
        points = noisy_sphere(300)
        result = denoise(points, noise=noise)
        assert np.isfinite(result.points).all()
        assert np.linalg.norm(result.points, axis=1).max() < 1.2


#: Stages of a run of the filter that finds no outliers, and how many states are known before; of
#: sparse points the spacing takes two.
STAGES = (
    *((0, stage) for stage in ("coincident points", "spacing", "noise", "energy")),
    (1, "outliers 1 of 2"),
    *((1, f"pass {number} of {DESIGN.n_passes}") for number in range(1, DESIGN.n_passes)),
    *((1, stage) for stage in ("redistribution", f"pass {DESIGN.n_passes} of {DESIGN.n_passes}")),
    *((1, stage) for stage in ("normals", "neighbourhoods", "curvature")),
)


class TestFilter:
    @pytest.mark.parametrize("dimension", [2, 3])
    def test_outliers_are_aligned_with_rows(self, dimension: int) -> None:
        points = noisy_sphere(1000, dimension=dimension)
        far = np.zeros((4, dimension))
        far[:, 0] = 2.0, 2.0, 1.5, np.nan
        rows = [0, 10, 500, 999]
        mixed = np.insert(points, rows, far, axis=0)
        mixed = np.r_[mixed, mixed[[7, 7, 0]]]
        result = denoise(mixed)
        assert result.outliers is not None
        assert result.outliers.dtype == np.bool_
        expected = np.zeros(len(mixed), np.bool_)
        expected[[0, 11, 502, len(mixed) - 1]] = True
        np.testing.assert_array_equal(result.outliers, expected)
        assert result.points[expected].tobytes() == mixed[expected].tobytes()
        assert not result.finite[1002]
        assert (result.displacement[~expected & result.finite] > 0).all()

    @pytest.mark.parametrize(
        "options",
        [{}, {"motion": "normal"}, {"max_move": "1x"}, {"keep_volume": True}],
        ids=str,
    )
    def test_outliers_stay_whatever_restrains_the_others(self, options: dict[str, Any]) -> None:
        points = outlier_cloud()
        result = denoise(points, **options)
        assert result.outliers is not None
        assert np.flatnonzero(result.outliers).tolist() == [2000, 2001, 2002]
        assert result.points[2000:].tobytes() == points[2000:].tobytes()

    @pytest.mark.parametrize("distance", [3.0, 1e12, 1e150])
    def test_an_outlier_hardly_matters_to_the_others(self, distance: float) -> None:
        points = noisy_sphere(700)  # so few that all are looked at: no sample changes
        outlier = np.array([[distance, 0.0, 0.0]])
        # redistributed, a point can become one of a border by the last digits, and its stay shows
        result = denoise(np.r_[points, outlier], motion="normal")
        expected = denoise(points, motion="normal")
        np.testing.assert_array_equal(result.points[-1:], outlier)
        assert result.outliers is not None
        assert np.flatnonzero(result.outliers).tolist() == [700]
        # the measures of the cloud are quantiles, of which one more point changes the last digits
        change = np.linalg.norm(result.points[:-1] - expected.points, axis=1)
        assert np.sqrt(np.mean(change**2)) < 0.01 * 0.02

    def test_fixed_points_act_on_the_others(self) -> None:
        points = noisy_sphere(500)
        fixed = np.arange(500) % 3 == 0
        result, alone = denoise(points, fixed=fixed), denoise(points[~fixed])
        assert result.points[fixed].tobytes() == points[fixed].tobytes()
        assert abs(result.points[~fixed] - alone.points).max() > 1e-3

    def test_everything_fixed(self) -> None:
        points = noisy_sphere(100)
        result = denoise(points, fixed=np.ones(100))
        assert result.points.tobytes() == points.tobytes()

    @pytest.mark.parametrize("dimension", [2, 3])
    def test_max_move(self, dimension: int) -> None:
        points = noisy_sphere(1000, dimension=dimension)
        free, result = denoise(points), denoise(points, max_move=0.01)
        assert free.displacement.max() > 0.02
        assert result.displacement.max() == pytest.approx(0.01, rel=1e-12)
        near = free.displacement < 0.01
        np.testing.assert_allclose(result.points[near], free.points[near], rtol=0, atol=1e-14)
        shares = (0.01 / free.displacement[~near])[:, np.newaxis]
        expected = points[~near] + shares * (free.points[~near] - points[~near])
        np.testing.assert_allclose(result.points[~near], expected, rtol=0, atol=1e-14)

    def test_keep_volume(self) -> None:
        # of the surface's cells, which the normals are of: the mean normal displacement vanishes
        points = noisy_sphere(2000, noise=0.02)
        free, kept = denoise(points), denoise(points, keep_volume=True)
        means = [np.linalg.norm(cloud.points, axis=1).mean() for cloud in (free, kept)]
        spreads = [np.linalg.norm(cloud.points, axis=1).std() for cloud in (free, kept)]
        shift = np.linalg.norm(kept.points - free.points, axis=1)
        assert shift.std() < 0.01 * shift.mean()  # all are moved alike, along their normals
        assert means[1] > means[0]
        assert spreads[1] == pytest.approx(spreads[0], rel=0.05)

    @pytest.mark.parametrize("dimension", [2, 3])
    def test_along_the_normals_nothing_is_spread_along_the_surface(self, dimension: int) -> None:
        rng = np.random.default_rng(3)
        noise = 1e-7
        plane = rng.random((2000, dimension))
        plane[:, -1] = noise * rng.normal(size=2000)
        free, normal = (denoise(plane, motion=motion) for motion in ("free", "normal"))
        for result, most in ((free, 1.0), (normal, 1e-2)):
            moves = (result.points - plane) / noise
            assert np.sqrt(np.mean(moves[:, -1] ** 2)) == pytest.approx(1.0, rel=0.1)
            along = np.linalg.norm(moves[:, :-1], axis=1)
            assert along.max() < most * 1.1
            assert (np.median(along) > 0.1) == (result is free)

    @pytest.mark.parametrize("dimension", [2, 3])
    @pytest.mark.parametrize("motion", ["free", "normal"])
    def test_it_is_the_filter(self, dimension: int, motion: Direction) -> None:
        points = noisy_sphere(500, dimension=dimension)
        held = np.arange(500) < 20
        result = denoise(points, motion=motion, fixed=held)
        expected = filter_whole(points, plan_of(points), held, redistribute=motion == "free")
        np.testing.assert_allclose(result.points, expected.points, rtol=0, atol=1e-13)
        assert result.outliers is not None
        np.testing.assert_array_equal(result.outliers, expected.outliers)

    @pytest.mark.parametrize("motion", ["free", "normal"])
    @pytest.mark.parametrize("dimension", [2, 3])
    def test_coincident_points_move_together(self, dimension: int, motion: Direction) -> None:
        points = noisy_sphere(500, dimension=dimension)
        rows = [*range(500), 10, 20, 10]
        result, single = denoise(points[rows], motion=motion), denoise(points, motion=motion)
        assert result.points[500:].tobytes() == result.points[[10, 20, 10]].tobytes()
        np.testing.assert_allclose(result.points[:500], single.points, rtol=0, atol=1e-13)
        held = denoise(points[rows], motion=motion, fixed=np.arange(503) == 502)
        assert held.points[[10, 500, 502]].tobytes() == points[[10, 10, 10]].tobytes()

    @pytest.mark.parametrize("dimension", [2, 3])
    def test_survey_coordinates(self, dimension: int) -> None:
        points = noisy_sphere(1000, dimension=dimension)
        offset = np.array([432_100.25, 5_412_300.5, 210.0])[:dimension]
        far, local = denoise(points + offset), denoise((points + offset) - offset)
        np.testing.assert_allclose(far.displacement, local.displacement, rtol=0, atol=1e-10)
        np.testing.assert_allclose(far.points - offset, local.points, rtol=0, atol=3e-9)

    @pytest.mark.parametrize("scale", [1e-100, 1e100])
    def test_any_unit(self, scale: float) -> None:
        points = noisy_sphere(300)
        result, expected = denoise(scale * points), denoise(points)
        np.testing.assert_allclose(result.points / scale, expected.points, rtol=0, atol=1e-9)

    @pytest.mark.parametrize("n", [2, 3, 5])
    @pytest.mark.parametrize("dimension", [2, 3])
    def test_few_points_stay(self, dimension: int, n: int) -> None:
        points = noisy_sphere(n, dimension=dimension)
        result = denoise(points)
        assert result.method.name == "filter"
        assert result.points.tobytes() == points.tobytes()
        assert result.outliers is not None
        assert not result.outliers.any()

    def test_one_point_without_a_radius_has_none(self) -> None:
        with pytest.raises(InvalidInputError, match="there is only one point, which has no"):
            denoise([[1.0, 2.0, 3.0]], scheme="filter")

    @pytest.mark.parametrize("turned", [False, True])
    @pytest.mark.parametrize("dimension", [2, 3])
    def test_a_plane_without_noise_does_not_move(self, dimension: int, turned: bool) -> None:
        axes = np.meshgrid(*[np.arange(20.0)] * (dimension - 1), [3.0], indexing="ij")
        points = np.stack(axes, axis=-1).reshape(-1, dimension)
        if turned:
            angles, _ = np.linalg.qr(np.random.default_rng(2).normal(size=(dimension, dimension)))
            points = points @ angles
        result = denoise(points)
        assert result.outliers is not None
        assert not result.outliers.any()
        if turned:
            assert result.displacement.max() < 1e-14
        else:
            assert result.points.tobytes() == points.tobytes()

    @pytest.mark.parametrize("dimension", [2, 3])
    def test_result_describes_the_run(self, dimension: int) -> None:
        points = noisy_sphere(400, dimension=dimension)
        seen: list[Record] = []
        stages: list[tuple[int, str, int]] = []

        def tell(progress: Progress) -> None:
            if progress.record is not None:
                assert (progress.stage, progress.done, progress.total) == ("steps", len(seen), 1)
                seen.append(progress.record)
            else:
                assert progress.total == 1
                stages.append((len(seen), progress.stage, progress.done))

        result = denoise(points, callback=tell)
        begun, ended = stages[::2], stages[1::2]
        assert [(*stage, 1) for *stage, _ in begun] == ended
        assert {done for *_, done in begun} == {0}
        assert tuple(stage for stage, _ in groupby((*stage,) for *stage, _ in begun)) == STAGES
        assert tuple(seen) == result.history
        first, last = seen
        assert (first.iteration, first.mean_move, first.max_move) == (0, 0, 0)
        assert last.iteration == 1
        assert last.mean_move == pytest.approx(result.displacement.mean())
        assert last.max_move == pytest.approx(result.displacement.max())
        for record, cloud in ((first, points), (last, result.points)):
            union = measure_balls(cloud, result.radius)
            assert record.volume == pytest.approx(union.volume, rel=1e-12)
            assert record.area == pytest.approx(union.area, rel=1e-12)
        assert (result.method.order, result.motion.max_move, result.stopped_early) == (
            None,
            None,
            False,
        )
        assert (result.solver_iterations, result.solver_error) == ((), 0)
        assert result.plan == plan_of(in_order(points))
        estimate = estimate_curvature(result.points, radius=result.radius)
        assert np.median(np.einsum("ij,ij->i", estimate.normals, result.normals)) > 0.99


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("order", [1, 2])
def test_implicit_scheme(dimension: int, order: Literal[1, 2]) -> None:
    points = noisy_sphere(800, dimension=dimension)
    result = denoise(points, scheme="implicit", order=order)
    assert [record.iteration for record in result.history] == [0, 1, 2]
    assert result.method.order == order
    assert result.plan is not None
    noise = result.plan.noise.deviation
    assert result.step == pytest.approx(STEP_OF_NOISE[order] * noise * result.spacing)
    assert len(result.solver_iterations) == 2
    assert min(result.solver_iterations) > 1
    assert 0 < result.solver_error < TOLERANCE
    spread = np.linalg.norm(result.points, axis=1).std()
    assert spread < 0.8 * np.linalg.norm(points, axis=1).std()
    by_hand = Implicit(result.spacing, order, noise=noise)
    *_, expected = run_flow(BallEnergy(result.radius), points, by_hand, 2)
    np.testing.assert_allclose(result.points, expected.points, atol=1e-13)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("quantity", get_args(Quantity))
def test_implicit_steps_without_a_weight_count_in_cells(
    quantity: Quantity, order: Literal[1, 2]
) -> None:
    points = in_order(noisy_sphere(400))
    result = denoise(points, scheme="implicit", order=order, weight="none", energy=quantity)
    assert result.plan is not None
    union = measure_balls(points, result.radius)
    cells = union.cell_volumes / (result.radius if quantity == "area" else 1.0)
    step = STEP_OF_NOISE[order] * result.plan.noise.deviation * result.spacing
    assert result.step == pytest.approx(step / np.median(cells), rel=1e-12)


def test_implicit_steps_of_polyhedra_do_not_count_in_noise() -> None:
    result = denoise(noisy_sphere(200), polyhedron=load_presets()["cube"], scheme="implicit")
    assert result.step == pytest.approx(AUTOMATIC_STEP[1] * result.spacing**2)


def test_euler_solves_no_equations() -> None:
    result = denoise(noisy_sphere(100), scheme="euler")
    assert (result.method.order, result.solver_iterations, result.solver_error) == (None, (), 0)
    assert (result.motion.max_move, result.stopped_early) == (None, False)


def test_restraints_reach_the_flow() -> None:
    points = in_order(noisy_sphere(500))
    result = denoise(points, scheme="euler", motion="normal", max_move="0.1x", keep_volume=True)
    assert result.motion.max_move == pytest.approx(0.1 * result.spacing)
    restraint = Restraint(along_normals=True, keeps_volume=True, longest=0.1 * result.spacing)
    *_, expected = run_flow(BallEnergy(result.radius), points, Euler(), 6, restraint=restraint)
    np.testing.assert_allclose(result.points, expected.points, atol=1e-13)
    assert result.displacement.max() == pytest.approx(result.motion.max_move)
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


OTHERS: dict[str, dict[str, Any]] = {
    "filter": {},
    "restrained filter": {"motion": "normal", "keep_volume": True, "max_move": "0.2x"},
    "told noise": {"noise": "0.5x"},
    "first order": {"scheme": "implicit", "order": 1, "keep_volume": True},
    # steps made of the noise here, 10 spacings in 2D, are so long that rounding changes the
    # number of the solver's iterations, and with that what its tolerance leaves
    "second order": {"scheme": "implicit", "noise": "0.4x", "motion": "normal", "max_move": "1x"},
    "restrained": {"scheme": "euler", "motion": "normal", "keep_volume": True},
}


@pytest.mark.slow
@pytest.mark.parametrize("options", OTHERS.values(), ids=OTHERS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_others_do_not_depend_on_threads_or_map_coordinates(
    dimension: int, options: dict[str, Any]
) -> None:
    points = on_lattice(noisy_sphere(3000, dimension=dimension))
    offset = np.array([2.0**19, 2.0**22, -(2.0**21)])[:dimension]
    one, two = (denoise(points, threads=threads, **options) for threads in (1, 2))
    assert one.points.tobytes() == two.points.tobytes()
    assert one.normals.tobytes() == two.normals.tobytes()
    assert one.history == two.history
    far = denoise(points + offset, **options)
    np.testing.assert_allclose(far.displacement, one.displacement, atol=1e-9)
    rounding = np.spacing(abs(points + offset))
    assert (abs(far.points - (one.points + offset)) <= rounding + 1e-9).all()


def test_implicit_steps_with_polyhedra_are_of_first_order() -> None:
    points = noisy_sphere(200)
    cube = load_presets()["cube"]
    result = denoise(points, polyhedron=cube, scheme="implicit")
    assert result.method.order == 1
    assert result.history[-1].volume < result.history[0].volume
    with pytest.raises(InvalidInputError, match="the order is 2, which is for balls"):
        denoise(points, polyhedron=cube, scheme="implicit", order=2)
