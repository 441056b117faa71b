from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from pcsmooth.cloud import PointCloud
from pcsmooth.curvature.estimate import CurvatureEstimate
from pcsmooth.files.output_columns import (
    Convention,
    Dialect,
    EstimatedCloud,
    color_names,
    mean_curvature_of,
    named_estimates,
    normals_of,
    values_of,
    with_estimates,
)
from pcsmooth.formats.text.layout import TextLayout

N = 4
MEANS = ["quality", "scalar_mean_curvature", "curvature"]
SCALARS = ["scalar_gaussian_curvature", "scalar_k1", "scalar_k2", "scalar_confidence"]
NORMALS = ["nx", "ny", "nz"]
MOVED = "scalar_displacement"
PLY_NAMES = [*NORMALS, *MEANS, *SCALARS, MOVED]
TEXT_NAMES = ["mean_curvature", "gaussian_curvature", "k1", "k2", "confidence", "displacement"]
NAMES = {
    (2, True): [*NORMALS, *MEANS, "scalar_confidence", MOVED],
    (3, True): PLY_NAMES,
    (2, False): ["nx", "ny", "mean_curvature", "confidence", "displacement"],
    (3, False): [*NORMALS, *TEXT_NAMES],
}
NAME_OF_OUTLIERS = {True: "scalar_outlier", False: "outlier"}
CASES = pytest.mark.parametrize(("dimension", "is_ply"), NAMES)

#: The columns of each dialect in 3D and 2D, with displacement.
DIALECTS: dict[Dialect, tuple[list[str], list[str]]] = {
    "generic": (PLY_NAMES, NAMES[2, True]),
    "meshlab": ([*NORMALS, "quality"], [*NORMALS, "quality"]),
    "cloudcompare": (
        [*NORMALS, "scalar_mean_curvature", *SCALARS, MOVED],
        [*NORMALS, "scalar_mean_curvature", "scalar_confidence", MOVED],
    ),
    "pcl": ([*NORMALS, "curvature"], [*NORMALS, "curvature"]),
}


def cloud(dimension: int = 3, *comments: str, **columns: npt.NDArray[Any]) -> PointCloud:
    layout = object()
    return PointCloud(
        points=np.zeros((N, dimension)),
        columns=dict(columns),
        position_type=np.dtype(np.float32),
        comments=comments,
        fixed_marks=np.array([True, False, False, True]),
        layout=layout,
    )


def text_cloud(**columns: npt.NDArray[Any]) -> PointCloud:
    layout = TextLayout("csv", ",", ("x", "y", "z", *columns))
    return PointCloud(np.zeros((N, 3)), columns=dict(columns), layout=layout)


def estimated(dimension: int = 3, seed: int = 0, **changes: Any) -> CurvatureEstimate:
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(N, dimension))
    fields: dict[str, Any] = {
        "normals": normals / np.linalg.norm(normals, axis=1, keepdims=True),
        "mean_curvature": rng.normal(size=N),
        "gaussian_curvature": rng.normal(size=N),
        "principal_curvatures": rng.normal(size=(N, dimension - 1)),
        "confidence": rng.random(N),
        "radius": 2.0,
        "spacing": 1.0,
        "normal_support": 30.0,
        "curvature_support": 60.0,
        "orientation": {"outward": 1},
        "finite": np.ones(N, np.bool_),
    }
    return CurvatureEstimate(**{**fields, **changes})


def without_principal(estimate: CurvatureEstimate) -> dict[str, Any]:
    """What the report's estimator leaves unknown."""
    return {
        "gaussian_curvature": np.full(N, np.nan),
        "principal_curvatures": np.full_like(estimate.principal_curvatures, np.nan),
        "has_principal": False,
    }


def positions(dimension: int, seed: int = 0) -> npt.NDArray[np.float64]:
    return np.random.default_rng(seed + 100).normal(size=(N, dimension))


def moves(seed: int = 0) -> npt.NDArray[np.float64]:
    return np.random.default_rng(seed + 200).random(N)


def add(before: PointCloud, is_ply: bool = True, seed: int = 0, **options: Any) -> EstimatedCloud:
    options = {"displacement": moves(seed), "provenance": "0.1 denoise", **options}
    dimension = before.dimension
    return with_estimates(
        before,
        positions(dimension, seed),
        estimated(dimension, seed),
        naming="ply" if is_ply else "text",
        **options,
    )


def added(before: PointCloud, is_ply: bool = True, **options: Any) -> tuple[PointCloud, list[str]]:
    result = add(before, is_ply, **options)
    assert result.replaced == []
    assert result.dropped == []
    return result.cloud, result.kept


@CASES
def test_names_and_types(dimension: int, is_ply: bool) -> None:
    after, kept = added(cloud(dimension), is_ply)
    assert list(after.columns) == NAMES[dimension, is_ply]
    assert {column.dtype for column in after.columns.values()} == {np.dtype(np.float32)}
    assert kept == []


@CASES
def test_values(dimension: int, is_ply: bool) -> None:
    after, _ = added(cloud(dimension), is_ply)
    estimate = estimated(dimension)
    expected = {name: estimate.normals[:, axis] for axis, name in enumerate(NORMALS[:dimension])}
    if dimension == 2 and is_ply:
        expected["nz"] = np.zeros(N)
    for name in MEANS if is_ply else ["mean_curvature"]:
        expected[name] = estimate.mean_curvature
    prefix = "scalar_" if is_ply else ""
    if dimension == 3:
        expected[f"{prefix}gaussian_curvature"] = estimate.gaussian_curvature
        expected[f"{prefix}k1"] = estimate.principal_curvatures[:, 0]
        expected[f"{prefix}k2"] = estimate.principal_curvatures[:, 1]
    expected[f"{prefix}confidence"] = estimate.confidence
    expected[f"{prefix}displacement"] = moves()
    assert list(after.columns) == list(expected)
    for name, column in expected.items():
        np.testing.assert_array_equal(after.columns[name], column.astype(np.float32))
    np.testing.assert_array_equal(after.points, positions(dimension))


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize("moved", [True, False])
@pytest.mark.parametrize("dimension", [2, 3])
def test_dialects(dialect: Dialect, moved: bool, dimension: int) -> None:
    displacement = moves() if moved else None
    after, _ = added(cloud(dimension), dialect=dialect, displacement=displacement)
    names = [name for name in DIALECTS[dialect][dimension == 2] if moved or name != MOVED]
    assert list(after.columns) == names
    assert "pcsmooth columns: " + " ".join(names) in after.comments


@pytest.mark.parametrize("dialect", DIALECTS)
def test_text_is_the_same_in_every_dialect(dialect: Dialect) -> None:
    after, _ = added(cloud(3), is_ply=False, dialect=dialect)
    assert list(after.columns) == NAMES[3, False]


@pytest.mark.parametrize("is_ply", [True, False])
def test_what_an_estimator_does_not_give_is_not_written(is_ply: bool) -> None:
    estimate = estimated(**without_principal(estimated()))
    after = with_estimates(
        cloud(3), positions(3), estimate, naming="ply" if is_ply else "text", provenance="x"
    ).cloud
    assert list(after.columns) == (
        [*NORMALS, *MEANS, "scalar_confidence"]
        if is_ply
        else [*NORMALS, "mean_curvature", "confidence"]
    )


class TestConvention:
    @pytest.mark.parametrize(
        ("convention", "dimension", "factor"),
        [("half", 3, 1), ("sum", 3, 2), ("half", 2, 1), ("sum", 2, 1)],
    )
    def test_only_the_mean_curvature_of_surfaces_depends_on_it(
        self, convention: Convention, dimension: int, factor: float
    ) -> None:
        estimate = estimated(dimension)
        named = named_estimates(estimate, convention)
        np.testing.assert_array_equal(named["mean"], factor * estimate.mean_curvature)
        assert (
            list(named)
            == {
                2: ["mean", "confidence"],
                3: ["mean", "gaussian", "k1", "k2", "confidence"],
            }[dimension]
        )
        for name in named.keys() - {"mean"}:
            np.testing.assert_array_equal(named[name], named_estimates(estimate, "half")[name])

    @pytest.mark.parametrize("is_ply", [True, False])
    def test_every_column_of_the_mean_follows_it(self, is_ply: bool) -> None:
        after, _ = added(cloud(3), is_ply, convention="sum")
        for name in MEANS if is_ply else ["mean_curvature"]:
            np.testing.assert_array_equal(
                after.columns[name], (2 * estimated().mean_curvature).astype(np.float32)
            )

    @pytest.mark.parametrize(
        ("first", "second"), [("half", "sum"), ("sum", "half"), ("sum", "sum")]
    )
    def test_the_comment_is_that_of_the_last_run(
        self, first: Convention, second: Convention
    ) -> None:
        once, _ = added(cloud(3), convention=first)
        twice, _ = added(once, convention=second)
        signs = [comment for comment in twice.comments if " signs: " in comment]
        formula, radius = {"half": ("H=(k1+k2)/2,", "+1/R"), "sum": ("H=k1+k2,", "+2/R")}[second]
        assert len(signs) == 1
        assert formula in signs[0]
        assert radius in signs[0]

    def test_a_curve_has_but_one(self) -> None:
        half, _ = added(cloud(2))
        both, _ = added(cloud(2), convention="sum")
        assert half.comments == both.comments


@CASES
def test_the_rest_of_the_cloud_is_kept(dimension: int, is_ply: bool) -> None:
    red = np.arange(N, dtype=np.uint8)
    words = np.array(["a", "b", "c", "d"])
    before = cloud(dimension, "by hand", red=red, words=words)
    after, _ = added(before, is_ply)
    assert list(after.columns)[:2] == ["red", "words"]
    assert after.columns["red"] is red
    assert after.columns["words"] is words
    assert after.position_type == np.float32
    assert after.fixed_marks is before.fixed_marks
    assert after.layout is before.layout
    assert after.comments[0] == "by hand"


@CASES
def test_the_cloud_that_came_in_is_not_changed(dimension: int, is_ply: bool) -> None:
    before = cloud(dimension, "by hand", nx=np.ones(N))
    added(before, is_ply)
    assert list(before.columns) == ["nx"]
    np.testing.assert_array_equal(before.columns["nx"], 1.0)
    assert before.comments == ("by hand",)
    np.testing.assert_array_equal(before.points, 0.0)


@pytest.mark.parametrize("name", ["quality", "curvature"])
def test_shared_names_of_another_program_are_kept_and_named(name: str) -> None:
    foreign = np.arange(N, dtype=np.float32) + 100
    after, kept = added(cloud(3, "pcsmoothly made by hand", **{name: foreign}))
    assert kept == [name]
    assert after.columns[name] is foreign
    estimate = estimated().mean_curvature.astype(np.float32)
    for other in set(MEANS) - {name}:
        np.testing.assert_array_equal(after.columns[other], estimate)


def test_both_shared_names_of_another_program_are_kept() -> None:
    foreign = np.arange(N)
    after, kept = added(cloud(3, quality=foreign, curvature=foreign))
    assert sorted(kept) == ["curvature", "quality"]
    assert "scalar_mean_curvature" in after.columns


def test_own_estimates_are_replaced_in_their_place() -> None:
    once, _ = added(cloud(3, red=np.arange(N)))
    twice, kept = added(once, seed=1)
    assert kept == []
    assert list(twice.columns) == list(once.columns) == ["red", *PLY_NAMES]
    estimate = estimated(seed=1)
    for name in MEANS:
        np.testing.assert_array_equal(
            twice.columns[name], estimate.mean_curvature.astype(np.float32)
        )
    np.testing.assert_array_equal(
        twice.columns["scalar_k2"], estimate.principal_curvatures[:, 1].astype(np.float32)
    )


@pytest.mark.parametrize("name", ["quality", "curvature", "scalar_confidence"])
def test_shared_names_of_another_program_survive_a_second_run(name: str) -> None:
    foreign = np.arange(N, dtype=np.float32) + 100
    once, _ = added(cloud(3, **{name: foreign}))
    twice, kept = added(once, seed=1)
    assert kept == [name]
    np.testing.assert_array_equal(twice.columns[name], foreign)


@pytest.mark.parametrize("name", ["quality", "curvature"])
def test_shared_names_mean_nothing_in_text(name: str) -> None:
    words = np.array(["good", "bad", "", "3"])
    after, kept = added(cloud(3, **{name: words}), is_ply=False)
    assert kept == []
    assert after.columns[name] is words
    assert list(after.columns) == [name, *NAMES[3, False]]


@pytest.mark.parametrize("is_ply", [True, False])
def test_normals_of_the_input_are_replaced_in_their_place(is_ply: bool) -> None:
    before = cloud(3, nz=np.full(N, 7.0), red=np.arange(N), nx=np.full(N, 7.0))
    after, _ = added(before, is_ply)
    assert list(after.columns)[:4] == ["nz", "red", "nx", "ny"]
    np.testing.assert_array_equal(after.columns["nz"], estimated().normals[:, 2].astype(np.float32))


def test_estimates_too_large_for_float_are_not_infinite() -> None:
    after, _ = added(cloud(3), displacement=np.array([1e39, 1e300, 2.0, 0.0]))
    largest = np.finfo(np.float32).max
    np.testing.assert_array_equal(after.columns[MOVED], [largest, largest, 2, 0])


class TestStaleColumns:
    @pytest.mark.parametrize("dialect", ["meshlab", "cloudcompare", "pcl"])
    def test_what_this_run_does_not_write_is_dropped_and_named(self, dialect: Dialect) -> None:
        once, _ = added(cloud(3, label=np.arange(N)))
        result = add(once, seed=1, dialect=dialect)
        expected = DIALECTS[dialect][0]
        assert list(result.cloud.columns) == ["label", *expected]
        assert result.dropped == [name for name in PLY_NAMES if name not in expected]
        assert "pcsmooth columns: " + " ".join(expected) in result.cloud.comments

    def test_what_the_other_estimator_gave_is_dropped(self) -> None:
        once, _ = added(cloud(3))
        estimate = estimated(**without_principal(estimated()))
        result = with_estimates(once, positions(3), estimate, naming="ply", provenance="x")
        assert result.dropped == ["scalar_gaussian_curvature", "scalar_k1", "scalar_k2"]

    @pytest.mark.parametrize("dialect", DIALECTS)
    def test_the_displacement_stays_until_points_move_again(self, dialect: Dialect) -> None:
        once, _ = added(cloud(3))
        twice = add(once, seed=1, displacement=None, dialect=dialect).cloud
        np.testing.assert_array_equal(twice.columns[MOVED], once.columns[MOVED])
        third = add(twice, seed=2)
        assert third.kept == []
        np.testing.assert_array_equal(third.cloud.columns[MOVED], moves(2).astype(np.float32))

    def test_other_names_that_a_comment_claims_are_not_touched(self) -> None:
        result = add(cloud(3, "pcsmooth columns: label scalar_k1", label=np.arange(N)))
        assert result.dropped == []
        assert "label" in result.cloud.columns

    def test_from_ply_to_text_no_column_is_doubled(self) -> None:
        once, _ = added(cloud(3))
        result = add(once, is_ply=False, seed=1)
        assert list(result.cloud.columns) == NAMES[3, False]

    def test_from_text_to_ply_no_column_is_doubled(self) -> None:
        before = text_cloud(**dict.fromkeys(["label", *NORMALS, *TEXT_NAMES], np.ones(N)))
        result = add(before)
        assert list(result.cloud.columns) == ["label", *PLY_NAMES]
        assert result.dropped == TEXT_NAMES


class TestText:
    def test_own_columns_stand_behind_the_mean_curvature(self) -> None:
        before = text_cloud(**dict.fromkeys([*NORMALS, *TEXT_NAMES], np.ones(N)))
        after, kept = added(before, is_ply=False)
        assert kept == []
        assert list(after.columns) == NAMES[3, False]
        np.testing.assert_array_equal(
            after.columns["confidence"], estimated().confidence.astype(np.float32)
        )

    @pytest.mark.parametrize("name", ["confidence", "k1"])
    def test_a_column_of_another_program_is_kept_and_survives(self, name: str) -> None:
        words = np.array(["0.1", "0.2", "", "high"])
        once, kept = added(text_cloud(**{name: words}), is_ply=False)
        assert kept == [name]
        again = text_cloud(**once.columns)
        twice, kept = added(again, is_ply=False, seed=1)
        assert kept == [name]
        assert twice.columns[name] is words

    def test_stale_columns_are_dropped(self) -> None:
        before = text_cloud(**dict.fromkeys([*NORMALS, *TEXT_NAMES], np.ones(N)))
        estimate = estimated(**without_principal(estimated()))
        result = with_estimates(before, positions(3), estimate, naming="text", provenance="x")
        assert result.dropped == ["gaussian_curvature", "k1", "k2"]
        np.testing.assert_array_equal(result.cloud.columns["displacement"], 1.0)


class TestColors:
    COLORS = np.arange(3 * N, dtype=np.uint8).reshape(N, 3)

    @pytest.mark.parametrize("is_ply", [True, False])
    def test_they_come_last_as_bytes(self, is_ply: bool) -> None:
        after, _ = added(cloud(3), is_ply, colors=self.COLORS)
        assert list(after.columns) == [*NAMES[3, is_ply], "red", "green", "blue"]
        for channel, name in enumerate(("red", "green", "blue")):
            assert after.columns[name].dtype == np.uint8
            np.testing.assert_array_equal(after.columns[name], self.COLORS[:, channel])

    @pytest.mark.parametrize(
        "names", [("red", "green", "blue"), ("Red", "Green", "Blue"), ("R", "G", "B")]
    )
    def test_those_of_the_input_are_replaced_in_their_place(
        self, names: tuple[str, str, str]
    ) -> None:
        before = text_cloud(**dict.fromkeys([*names, "label"], np.full(N, "7")))
        result = add(before, is_ply=False, colors=self.COLORS)
        assert result.replaced == list(names)
        assert list(result.cloud.columns)[:4] == [*names, "label"]
        assert "red" in names or "red" not in result.cloud.columns
        np.testing.assert_array_equal(result.cloud.columns[names[2]], self.COLORS[:, 2])

    def test_two_channels_are_no_color(self) -> None:
        assert color_names(cloud(3, r=np.ones(N), g=np.ones(N))) == ("red", "green", "blue")

    def test_own_colors_are_replaced_and_else_dropped(self) -> None:
        once, _ = added(cloud(3), colors=self.COLORS, color_note="mean curvature by x")
        assert once.comments[-1] == "pcsmooth colors: mean curvature by x"
        again, _ = added(once, colors=self.COLORS + 1, color_note="k1 by y")
        assert [c for c in again.comments if " colors: " in c] == ["pcsmooth colors: k1 by y"]
        np.testing.assert_array_equal(again.columns["red"], self.COLORS[:, 0] + 1)
        result = add(again)
        assert result.dropped == ["red", "green", "blue"]
        assert not [comment for comment in result.cloud.comments if " colors: " in comment]


class TestOutliers:
    OUTLIERS = np.array([False, True, False, True])

    @pytest.mark.parametrize("is_ply", [True, False])
    def test_they_come_last_as_ones_and_zeros(self, is_ply: bool) -> None:
        name = NAME_OF_OUTLIERS[is_ply]
        after, kept = added(cloud(3), is_ply, outliers=self.OUTLIERS)
        assert list(after.columns) == [*NAMES[3, is_ply], name]
        assert kept == []
        np.testing.assert_array_equal(after.columns[name], np.array([0, 1, 0, 1], np.float32))
        assert after.columns[name].dtype == np.float32

    @pytest.mark.parametrize("dialect", DIALECTS)
    def test_dialects(self, dialect: Dialect) -> None:
        after, _ = added(cloud(3), outliers=self.OUTLIERS, dialect=dialect)
        moves = dialect in ("generic", "cloudcompare")
        assert ("scalar_outlier" in after.columns) == (MOVED in after.columns) == moves

    @pytest.mark.parametrize("is_ply", [True, False])
    def test_a_run_that_moves_points_otherwise_drops_them(self, is_ply: bool) -> None:
        name = NAME_OF_OUTLIERS[is_ply]
        before = cloud(3) if is_ply else text_cloud()
        once, _ = added(before, is_ply, outliers=self.OUTLIERS)
        result = add(once, is_ply, seed=1)
        assert result.dropped == [name]
        assert name not in result.cloud.columns
        (columns,) = [line for line in result.cloud.comments if " columns: " in line]
        assert name not in columns.split()

    @pytest.mark.parametrize("is_ply", [True, False])
    def test_a_run_that_moves_nothing_keeps_them(self, is_ply: bool) -> None:
        name = NAME_OF_OUTLIERS[is_ply]
        before = cloud(3) if is_ply else text_cloud()
        once, _ = added(before, is_ply, outliers=self.OUTLIERS)
        still, _ = added(once, is_ply, seed=1, displacement=None)
        np.testing.assert_array_equal(still.columns[name], once.columns[name])
        assert list(still.columns) == list(once.columns)
        assert add(still, is_ply, seed=2).dropped == [name]

    @pytest.mark.parametrize("is_ply", [True, False])
    def test_a_run_that_filters_replaces_them(self, is_ply: bool) -> None:
        name = NAME_OF_OUTLIERS[is_ply]
        before = cloud(3) if is_ply else text_cloud()
        once, _ = added(before, is_ply, outliers=self.OUTLIERS)
        twice, kept = added(once, is_ply, seed=1, outliers=~self.OUTLIERS)
        assert kept == []
        assert list(twice.columns) == list(once.columns)
        np.testing.assert_array_equal(twice.columns[name], np.array([1, 0, 1, 0], np.float32))

    @pytest.mark.parametrize("is_ply", [True, False])
    def test_those_of_others_are_kept(self, is_ply: bool) -> None:
        name = NAME_OF_OUTLIERS[is_ply]
        theirs = np.array([5, 6, 7, 8], np.int32)
        columns: dict[str, Any] = {name: theirs}
        before = cloud(3, **columns) if is_ply else text_cloud(**columns)
        for options in ({"outliers": self.OUTLIERS}, {}):
            after, kept = added(before, is_ply, **options)
            assert kept == ([name] if options else [])
            np.testing.assert_array_equal(after.columns[name], theirs)
            before = after


class TestNormalsOf:
    @pytest.mark.parametrize("dimension", [2, 3])
    def test_numbers(self, dimension: int) -> None:
        columns = {name: np.full(N, axis, np.float32) for axis, name in enumerate(NORMALS)}
        normals = normals_of(cloud(dimension, **columns))
        np.testing.assert_array_equal(normals, np.tile(np.arange(dimension), (N, 1)))

    def test_words_that_are_numbers(self) -> None:
        words = np.array(["1", "-1e0", "", "nan"])
        normals = normals_of(cloud(2, nx=words, ny=words))
        np.testing.assert_array_equal(normals, np.transpose([[1, -1, np.nan, np.nan]] * 2))

    @pytest.mark.parametrize(
        "columns",
        [
            {},
            {"nx": np.ones(N), "ny": np.ones(N)},
            {"nx": np.ones(N), "ny": np.ones(N), "nz": np.array(["up", "up", "up", "1"])},
            {"nx": np.ones(N), "ny": np.ones(N), "nz": np.array([None] * N, object)},
        ],
        ids=["none", "two", "words", "lists"],
    )
    def test_none(self, columns: dict[str, npt.NDArray[Any]]) -> None:
        assert normals_of(cloud(3, **columns)) is None


class TestComments:
    def test_provenance_units_and_signs_follow_those_of_the_file(self) -> None:
        after, _ = added(cloud(3, "one", "two"), provenance="0.1 denoise radius=3")
        one, two, done, columns, units, signs = after.comments
        assert (one, two) == ("one", "two")
        assert done == "pcsmooth 0.1 denoise radius=3"
        assert columns == "pcsmooth columns: " + " ".join(PLY_NAMES)
        assert units.startswith("pcsmooth units: ")
        assert "curvature in 1/unit" in units
        assert signs.startswith("pcsmooth signs: ")

    @pytest.mark.parametrize("dimension", [2, 3])
    def test_only_surfaces_have_a_gaussian_curvature(self, dimension: int) -> None:
        after, _ = added(cloud(dimension))
        assert ("Gaussian curvature in 1/unit^2" in after.comments[-2]) == (dimension == 3)

    @pytest.mark.parametrize(
        ("dimension", "words"),
        [(2, "curvature k of the curve"), (3, "mean curvature H=(k1+k2)/2")],
    )
    def test_signs_say_which_curvature(self, dimension: int, words: str) -> None:
        after, _ = added(cloud(dimension))
        assert words in after.comments[-1]

    def test_provenance_is_collected_and_units_and_signs_are_not_doubled(self) -> None:
        once, _ = added(cloud(3, "one"), provenance="first")
        twice, _ = added(once, provenance="second")
        assert twice.comments == (
            "one",
            "pcsmooth first",
            "pcsmooth second",
            *once.comments[-3:],
        )

    def test_the_same_provenance_twice_is_two_runs(self) -> None:
        once, _ = added(cloud(3))
        twice, _ = added(once)
        assert twice.comments.count("pcsmooth 0.1 denoise") == 2


class TestMeanCurvatureOf:
    VALUES = np.array([0.5, -1.0, 2.0, 0.0])
    SUMMED = "pcsmooth signs: mean curvature H=k1+k2, positive where the surface bends away"

    @pytest.mark.parametrize("name", ["mean_curvature", "scalar_mean_curvature"])
    @pytest.mark.parametrize("kind", ["f4", "f8", "U"])
    def test_by_name(self, name: str, kind: str) -> None:
        found = mean_curvature_of(cloud(3, **{name: self.VALUES.astype(kind)}))
        assert found is not None
        np.testing.assert_array_equal(found[0], self.VALUES)
        assert found[1] == name

    @pytest.mark.parametrize("name", ["quality", "curvature"])
    def test_names_with_other_uses_need_a_comment(self, name: str) -> None:
        columns = {name: self.VALUES}
        assert mean_curvature_of(cloud(3, **columns)) is None
        found = mean_curvature_of(cloud(3, f"pcsmooth columns: nx {name}", **columns))
        assert found is not None
        assert found[1] == name

    @pytest.mark.parametrize("values", [np.array(["a"] * N), np.array([[1]] * N, object)])
    def test_what_is_no_number(self, values: npt.NDArray[Any]) -> None:
        assert mean_curvature_of(cloud(mean_curvature=values)) is None

    def test_a_sum_becomes_the_mean(self) -> None:
        found = mean_curvature_of(cloud(3, self.SUMMED, scalar_mean_curvature=self.VALUES))
        assert found is not None
        np.testing.assert_array_equal(found[0], self.VALUES / 2)

    @pytest.mark.parametrize("prefix", ["", "scalar_"])
    def test_principal_curvatures_tell_which_mean_it_is(self, prefix: str) -> None:
        named = {
            "mean_curvature": 2 * self.VALUES, "k1": self.VALUES + 1, "k2": self.VALUES - 1
        }  # fmt: skip
        columns = {prefix + name: values for name, values in named.items()}
        found = mean_curvature_of(cloud(3, "read", **columns))
        assert found is not None
        np.testing.assert_array_equal(found[0], self.VALUES)

    def test_points_without_normal_have_none(self) -> None:
        normal = np.array([0.0, 1.0, 0.0, 1.0])
        columns = {"nx": normal, "ny": 0 * normal, "nz": 0 * normal}
        found = mean_curvature_of(cloud(3, "read", mean_curvature=self.VALUES, **columns))
        assert found is not None
        np.testing.assert_array_equal(found[0], [np.nan, -1.0, np.nan, 0.0])


def test_columns_of_numbers_that_tell_points_apart() -> None:
    marks = np.array([1, 2, 2, 5], np.uint8)
    columns = {
        "nx": marks, "red": marks, "green": marks, "blue": marks, "dx": marks,
        "class": marks, "again": marks.astype("f4"), "words": np.array(["a", "b", "c", "d"]),
        "typed": np.array(["1", "2.5", "", "4"]), "same": np.array([3.0, np.nan, 3.0, 3.0]),
        "nothing": np.full(4, np.nan),
    }  # fmt: skip
    found = values_of(PointCloud(np.zeros((4, 3)), columns))
    assert list(found) == ["class", "typed"]
    np.testing.assert_array_equal(found["class"], marks)
    np.testing.assert_array_equal(found["typed"], [1.0, 2.5, np.nan, 4.0])
