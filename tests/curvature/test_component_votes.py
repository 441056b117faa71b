from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
import pytest

import oracles
from oracles import Array
from pcsmooth.curvature import component_votes
from pcsmooth.curvature.component_votes import ComponentSigns, ComponentVotes
from pcsmooth.curvature.orientation import Orientation, parse_orientation
from pcsmooth.errors import InvalidInputError

Numbers = npt.NDArray[np.int64]

RULES = ["auto", "outward", "propagate", "input", "viewpoint=0.1,0.2,0.3", "direction=1,-1,0"]


@dataclass(frozen=True)
class Parts:
    """Points of several components with areas, their normals, and those of the input."""

    points: Array  # (n, d)
    normals: Array
    areas: Array
    labels: Numbers
    given: Array

    def taken(self, rows: Numbers) -> Parts:
        points, normals, given = (array[rows] for array in (self.points, self.normals, self.given))
        return Parts(points, normals, self.areas[rows], self.labels[rows], given)


@dataclass
class Pile:
    """Components one after the other, each moved away from the origin."""

    rows: list[Array] = field(default_factory=list)

    def add(self, points: Array, normals: Array, center: Array) -> None:
        label = np.full(len(points), len(self.rows))
        self.rows.append(np.c_[points + center, normals, label])

    def parts(self) -> Parts:
        rows = np.concatenate(self.rows)
        rng = np.random.default_rng(7)
        normals = np.ascontiguousarray(rows[:, 3:6])
        given = (
            np.where(np.arange(len(rows)) % 2 == 0, 1.0, -1.0)[:, np.newaxis] * normals
        )  # as many each way
        given[rng.random(len(rows)) < 0.2] = 0.0
        given[rows[:, 6] % 2 == 0] = 0.0
        areas = rng.choice([0.1, 0.3, 0.7], len(rows) // 2).repeat(2)
        return Parts(
            np.ascontiguousarray(rows[:, :3]), normals, areas, rows[:, 6].astype(np.int64), given
        )


def mirrored(points: Array) -> Array:
    """Each point followed by its image in the origin."""
    return np.stack([points, -points], axis=1).reshape(-1, 3)


def tied_components() -> Parts:
    """Shapes for which some rule finds as much for one sign as for the other."""
    pile = Pile()
    flat = mirrored(np.c_[oracles.uniform_cloud(300, 2) - 0.5, np.zeros(300)])
    sphere = mirrored(oracles.random_sphere(300))
    bent = flat + np.c_[np.zeros((600, 2)), 0.3 * flat[:, 0] * flat[:, 1]]
    saddle = np.c_[-0.3 * flat[:, 1], -0.3 * flat[:, 0], np.ones(600)]
    saddle /= np.linalg.norm(saddle, axis=1, keepdims=True)
    quarter = np.repeat([1.0, 1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0], 2)  # mean just 1/4
    for seed, up in enumerate([(1, 1, 0), (-1, 1, 0), (0, -1, 1), (1, -1, 1), (0, 0, -1)]):
        rng = np.random.default_rng(seed)
        side = np.cross(up, [0.3, 0.5, 0.8])
        frame = np.array([side, np.cross(up, side), up], np.float64)
        frame /= np.linalg.norm(frame, axis=1, keepdims=True)
        for sign in (1.0, -1.0):
            center = 10.0 * rng.random(3)
            pile.add(flat @ frame, sign * np.tile(frame[2], (600, 1)), center)
            pile.add(sphere, sign * sphere, center)
            pile.add(bent @ frame, sign * saddle @ frame, center)
            pile.add(np.outer([0.0, 1e-3], np.ones(3)), sign * frame[:2], center)
            pile.add(flat[:16] @ frame, sign * np.outer(quarter, frame[2]), center)
        # All at the same height, and all around the viewpoint.
        pile.add(flat, mirrored(oracles.random_sphere(300, seed=seed)), center)
        around = mirrored(oracles.uniform_cloud(300, 3, seed))
        pile.add(around, np.tile(frame[2], (600, 1)), np.array([0.1, 0.2, 0.3]))
    pile.add(flat, np.zeros_like(flat), np.zeros(3))
    return pile.parts()


TIED = tied_components()


def decide(
    parts: list[Parts], rule: str, count: int = 1 + int(TIED.labels.max())
) -> ComponentSigns:
    votes = ComponentVotes(parse_orientation(rule), 3, count)
    for part in parts:
        votes.add_places(part.points, part.areas, part.labels)
    for part in reversed(parts):
        votes.add_votes(part.points, part.normals, part.areas, part.labels, part.given)
    return votes.decide()


def orders() -> Iterator[list[Numbers]]:
    """Ways to go over the points: backwards, and at random in parts, of which some are empty."""
    n = len(TIED.labels)
    yield [np.arange(n)[::-1]]
    for seed in range(10):
        rng = np.random.default_rng(seed)
        cuts = np.sort(rng.integers(0, n, 20 * seed))
        yield np.split(rng.permutation(n), cuts)


@pytest.mark.parametrize("rule", RULES)
def test_the_order_of_points_and_parts_does_not_matter(rule: str) -> None:
    expected = decide([TIED], rule)
    expected_flips = expected.flips_of(TIED.normals, TIED.labels, TIED.given)
    for order in orders():
        parts = [TIED.taken(rows) for rows in order]
        decided = decide(parts, rule)
        np.testing.assert_array_equal(decided.signs, expected.signs)
        np.testing.assert_array_equal(decided.reasons, expected.reasons)
        assert decided.counts() == expected.counts()
        flips = np.zeros_like(expected_flips)
        for rows, part in zip(order, parts, strict=True):
            flips[rows] = decided.flips_of(part.normals, part.labels, part.given)
        np.testing.assert_array_equal(flips, expected_flips)


@pytest.mark.parametrize("rule", RULES)
def test_rounding_would_decide_if_it_were_let(rule: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The test above does see ties."""
    monkeypatch.setattr(component_votes, "_EQUAL", 0.0)
    expected = decide([TIED], rule)
    others = [decide([TIED.taken(rows) for rows in order], rule) for order in orders()]
    assert any(
        (other.signs != expected.signs).any() or (other.reasons != expected.reasons).any()
        for other in others
    )


def decide_one(rule: str, points: Array, normals: Array, areas: Array | None = None) -> float:
    """Sign of a single component."""
    areas = np.ones(len(points)) if areas is None else areas
    labels = np.zeros(len(points), np.int64)
    decided = decide([Parts(points, normals, areas, labels, 0.0 * normals)], rule, 1)
    return float(decided.signs[0])


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_tie_leaves_the_sign_as_it_is(sign: float) -> None:
    sphere = mirrored(oracles.random_sphere(300)) + 5.0
    assert decide_one("direction=1,2,3", sphere, sign * (sphere - 5.0)) == 1.0
    flat = np.c_[oracles.uniform_cloud(300, 2), np.full(300, 0.3)]
    assert decide_one("outward", flat, np.tile([0.0, 0.0, sign], (300, 1))) == 1.0


def test_the_first_of_equal_axes_leads() -> None:
    tilted = oracles.uniform_cloud(300, 3)
    tilted[:, 2] = tilted[:, 0] - tilted[:, 1]
    for normal, sign in (([1.0, -1.0, -1.0], 1.0), ([-1.0, 1.0, 1.0], -1.0)):
        normals = np.tile(np.array(normal) / np.sqrt(3), (300, 1))
        normals[:, 1:] *= 1 + 1e-13  # rounding, say
        assert decide_one("auto", tilted, normals) == sign
        normals[:, 1:] *= 1.01
        assert decide_one("auto", tilted, normals) == -sign


@pytest.mark.parametrize("seed", range(5))
def test_a_point_on_its_own_is_a_sheet_wherever_it_is(seed: int) -> None:
    """Its distance to its centroid is rounding."""
    rng = np.random.default_rng(seed)
    n = 1000
    normals = oracles.random_sphere(n, 1.0, seed)
    alone = Parts(1e3 * rng.random((n, 3)), normals, rng.random(n), np.arange(n), 0.0 * normals)
    decided = decide([alone], "auto", n)
    assert decided.counts() == {"axis": n}
    assert (decide([alone], "outward", n).signs == 1.0).all()


def test_components_without_normals_do_not_count() -> None:
    decided = decide([TIED], "direction=0,0,1")
    assert decided.counts() == {"direction": int(TIED.labels.max())}  # the last has none


def test_a_vector_of_another_dimension_is_refused() -> None:
    with pytest.raises(InvalidInputError, match="3 coordinates and the points 2"):
        ComponentVotes(Orientation("viewpoint", (1.0, 2.0, 3.0)), 2, 1)
