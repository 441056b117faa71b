from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from pcsmooth.attributes import with_estimates
from pcsmooth.cloud import PointCloud

N = 4
CURVATURES = ["quality", "scalar_mean_curvature", "curvature"]
PLY_NAMES = ["nx", "ny", "nz", *CURVATURES, "scalar_displacement"]
NAMES = {
    (2, True): PLY_NAMES,
    (3, True): PLY_NAMES,
    (2, False): ["nx", "ny", "mean_curvature", "displacement"],
    (3, False): ["nx", "ny", "nz", "mean_curvature", "displacement"],
}
CASES = pytest.mark.parametrize(("dimension", "is_ply"), NAMES)


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


def estimates(dimension: int, seed: int = 0) -> dict[str, npt.NDArray[np.float64]]:
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(N, dimension))
    return {
        "points": rng.normal(size=(N, dimension)),
        "normals": normals / np.linalg.norm(normals, axis=1, keepdims=True),
        "mean_curvature": rng.normal(size=N),
        "displacement": rng.random(N),
    }


def added(
    before: PointCloud, is_ply: bool = True, provenance: str = "0.1 denoise", seed: int = 0
) -> tuple[PointCloud, list[str]]:
    values = estimates(before.dimension, seed)
    return with_estimates(before, **values, is_ply=is_ply, provenance=provenance)


@CASES
def test_names_and_types(dimension: int, is_ply: bool) -> None:
    after, kept = added(cloud(dimension), is_ply)
    assert list(after.columns) == NAMES[dimension, is_ply]
    assert {column.dtype for column in after.columns.values()} == {np.dtype(np.float32)}
    assert kept == []


@CASES
def test_values(dimension: int, is_ply: bool) -> None:
    after, _ = added(cloud(dimension), is_ply)
    values = estimates(dimension)
    expected = {
        name: values["normals"][:, axis] for axis, name in enumerate(["nx", "ny", "nz"][:dimension])
    }
    if dimension == 2 and is_ply:
        expected["nz"] = np.zeros(N)
    for name in CURVATURES if is_ply else ["mean_curvature"]:
        expected[name] = values["mean_curvature"]
    expected["scalar_displacement" if is_ply else "displacement"] = values["displacement"]
    assert list(after.columns) == list(expected)
    for name, column in expected.items():
        np.testing.assert_array_equal(after.columns[name], column.astype(np.float32))
    np.testing.assert_array_equal(after.points, values["points"])


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
    estimate = estimates(3)["mean_curvature"].astype(np.float32)
    for other in set(CURVATURES) - {name}:
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
    values = estimates(3, seed=1)
    for name in CURVATURES:
        np.testing.assert_array_equal(
            twice.columns[name], values["mean_curvature"].astype(np.float32)
        )


@pytest.mark.parametrize("name", ["quality", "curvature"])
def test_shared_names_of_another_program_survive_a_second_run(name: str) -> None:
    foreign = np.arange(N, dtype=np.float32) + 100
    once, _ = added(cloud(3, **{name: foreign}))
    twice, _ = added(once, seed=1)
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
    np.testing.assert_array_equal(
        after.columns["nz"], estimates(3)["normals"][:, 2].astype(np.float32)
    )


def test_estimates_too_large_for_float_are_not_infinite() -> None:
    values = {**estimates(3), "displacement": np.array([1e39, 1e300, 2.0, 0.0])}
    after, _ = with_estimates(cloud(3), **values, is_ply=True, provenance="0.1 denoise")
    largest = np.finfo(np.float32).max
    np.testing.assert_array_equal(after.columns["scalar_displacement"], [largest, largest, 2, 0])


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
