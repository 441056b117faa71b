"""A cloud in one part and in many: the same byte for byte, whatever is done to it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt
import pytest
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from pcsmooth.bodies.presets import load_presets
from pcsmooth.curvature.orientation import parse_orientation
from pcsmooth.curvature.single_gradient import Estimator
from pcsmooth.curvature.support import Support
from pcsmooth.energies.balls import BallEnergy
from pcsmooth.energies.cell_reach import cell_reach
from pcsmooth.energies.protocol import Evaluation
from pcsmooth.estimating import estimate_parts, given_normals
from pcsmooth.methods.flows import EulerFlow
from pcsmooth.methods.shapes import Balls
from pcsmooth.positions import usable_rows
from pcsmooth.python.estimating import estimate_curvature
from pcsmooth.tiling.cutting import cut_cloud
from pcsmooth.tiling.input_order import in_input_order
from pcsmooth.tiling.runner import InProcess
from pcsmooth.tiling.tiled_cloud import TiledCloud
from tiling.clouds import MAP_COORDINATES, Points, battered, curve, ribbon
from tiling.whole_and_tiled import compare, source_of

CUBE, SQUARE = load_presets()["cube"], load_presets()["square"]


def marks(points: Points, share: float, seed: int = 5) -> npt.NDArray[np.bool_]:
    return np.random.default_rng(seed).random(len(points)) < share


def normals_for(points: Points, seed: int = 6) -> Points:
    """Normals that come with a cloud: mostly upward, some missing."""
    normals = np.random.default_rng(seed).normal(size=points.shape)
    normals[:, -1] += 1.5
    normals[::7] = 0.0
    normals[::501] = np.nan
    return normals


def tube(length: float, radius: float = 2.5, noise: float = 0.1, seed: int = 7) -> Points:
    """A closed surface far longer than wide, of spacing 1: a cylinder with half spheres on."""
    rng = np.random.default_rng(seed)
    n = int(2.0 * np.pi * radius * (length + 2.0 * radius))
    along, angles = rng.random(n) * (length + 2.0 * radius) - radius, 2.0 * np.pi * rng.random(n)
    beyond = along - np.clip(along, 0.0, length)
    width = np.sqrt(radius**2 - beyond**2)
    points = np.stack([along, width * np.cos(angles), width * np.sin(angles)], axis=1)
    return np.asarray(points + noise * rng.normal(size=points.shape))


def loop(length: float, width: float = 8.0, noise: float = 0.1, seed: int = 8) -> Points:
    """A closed curve far longer than wide, of spacing 1: two lines with half circles on."""
    rng = np.random.default_rng(seed)
    half = length + np.pi * width / 2.0
    place = rng.random(int(2.0 * half)) * 2.0 * half
    side, along = np.divmod(place, half)
    angle = np.maximum(along - length, 0.0) / (width / 2.0)
    x = np.minimum(along, length) + width / 2.0 * np.sin(angle)
    y = width / 2.0 * np.cos(angle)
    x, y = np.where(side == 0.0, x, length - x), np.where(side == 0.0, y, -y)
    return np.asarray(np.stack([x, y], axis=1) + noise * rng.normal(size=(len(x), 2)))


def at(place: list[float], points: Points) -> Points:
    return np.asarray(points + place)


def shuffled(*clouds: Points) -> Points:
    """Clouds as one, of which every thirtieth point is there twice, in no spatial order."""
    points = np.concatenate(clouds)
    points = np.concatenate([points, points[::30]])
    return np.random.default_rng(9).permutation(points)


#: Clouds of several closed components, each cut by tiles: no tile sees all of one.
TUBES = shuffled(
    tube(240.0), at([5.0, 14.0, 1.0], tube(220.0, seed=10)), at([50.0, 0.0, 20.0], tube(4.0))
)
LOOPS = shuffled(loop(1200.0), at([20.0, 40.0], loop(1300.0, seed=11)), at([90.0, 90.0], loop(5.0)))

SHEET, ROUGH = ribbon(3000), battered(ribbon(3000))
CURVE, ROUGH_CURVE = curve(), battered(curve())
NARROW = ribbon(1500, width=6.0)

#: Points, and options of `denoise`.
CASES: dict[str, tuple[Points, dict[str, Any]]] = {
    "filter": (ROUGH, {"scheme": "filter"}),
    "filter on the map": (ROUGH + MAP_COORDINATES, {"scheme": "filter"}),
    "filter, fixed points": (ROUGH, {"scheme": "filter", "fixed": marks(ROUGH, 0.1)}),
    "filter along normals": (ROUGH, {"scheme": "filter", "motion": "normal", "max_move": 0.3}),
    "filter in the plane": (ROUGH_CURVE, {"scheme": "filter"}),
    **{
        f"filter that keeps volume, {name}": (
            points, {"scheme": "filter", "keep_volume": True, **options},
        )
        for name, points, options in (
            ("sheet with outliers", ROUGH, {"max_move": 0.4}),
            ("tubes", TUBES, {}),
            ("tubes along normals", TUBES, {"motion": "normal", "fixed": marks(TUBES, 0.1)}),
            ("loops", LOOPS, {"fixed": marks(LOOPS, 0.1)}),
            ("loops along normals", LOOPS, {"motion": "normal", "max_move": "0.1x"}),
        )
    },
    **{
        f"{quantity}, weight {weight}, {place}": (points, {"energy": quantity, "weight": weight})
        for place, points in (("in space", ROUGH), ("in the plane", ROUGH_CURVE))
        for quantity in ("volume", "area")
        for weight in ("none", "cell", "boundary")
    },
    **{
        f"cubes, {union}, {quantity}": (
            NARROW, {"polyhedron": CUBE, "union": union, "energy": quantity, "iterations": 1},
        )
        for union in ("naive", "inclusion-exclusion", "exact")
        for quantity in ("volume", "area")
    },
    **{
        f"squares, {union}": (ROUGH_CURVE, {"polyhedron": SQUARE, "union": union})
        for union in ("naive", "inclusion-exclusion", "exact")
    },
    "cubes along normals": (
        NARROW, {"polyhedron": CUBE, "motion": "normal", "iterations": 1, "radius": 1.3},
    ),
    "cubes that keep volume": (
        NARROW, {"polyhedron": CUBE, "keep_volume": True, "iterations": 1, "radius": 1.3},
    ),
    "along normals": (ROUGH, {"motion": "normal"}),
    "along normals in the plane": (ROUGH_CURVE, {"motion": "normal"}),
    "short moves": (ROUGH, {"max_move": 0.05}),
    "short moves along normals": (ROUGH, {"max_move": "0.1x", "motion": "normal"}),
    "fixed points": (ROUGH, {"fixed": marks(ROUGH, 0.3)}),
    "all points fixed": (SHEET, {"fixed": marks(SHEET, 2.0), "keep_volume": True}),
    "kept volume": (TUBES, {"keep_volume": True, "radius": 1.2}),
    "kept volume along normals": (
        TUBES, {"keep_volume": True, "radius": 1.2, "motion": "normal", "energy": "area"},
    ),
    "kept volume, fixed points": (
        TUBES, {"keep_volume": True, "radius": 1.2, "fixed": marks(TUBES, 0.1)},
    ),
    "kept volume along normals, fixed points, short moves": (
        TUBES, {"keep_volume": True, "radius": 1.2, "motion": "normal", "max_move": 0.05,
                "fixed": marks(TUBES, 0.1)},
    ),
    "kept volume of a sheet with outliers": (ROUGH, {"keep_volume": True, "weight": "boundary"}),
    "kept volume in the plane": (LOOPS, {"keep_volume": True}),
    "kept volume along normals in the plane": (
        LOOPS, {"keep_volume": True, "motion": "normal", "weight": "none", "radius": 1.5},
    ),
    "kept volume in the plane, fixed points": (
        LOOPS, {"keep_volume": True, "fixed": marks(LOOPS, 0.1), "stop": 0.01, "iterations": 3},
    ),
}  # fmt: skip


def check(points: Points, options: dict[str, Any], tile_points: int, folder: Path) -> Points:
    """Denoise a cloud both ways, compare all that is told of it; give the displacements."""
    given = {} if options.get("scheme") == "filter" else {"iterations": 2}
    unlike, whole, tiled = compare(
        points, tile_points, folder, **{"threads": 1, **given, **options}
    )
    assert unlike == []
    assert tiled.store.partition.n_tiles >= 4
    return whole.displacement


@pytest.mark.slow
@pytest.mark.parametrize(("points", "options"), CASES.values(), ids=CASES)
def test_one_part_equals_many(points: Points, options: dict[str, Any], tmp_path: Path) -> None:
    moved = check(points, options, 1 + len(points) // 7, tmp_path)
    fixed = options.get("fixed")
    if fixed is not None:
        assert not moved[fixed].any()
    assert moved.any() == (fixed is None or not fixed.all())


#: What is tried of all that where time is short, each in well under a second.
QUICK: dict[str, tuple[Points, dict[str, Any]]] = {
    "filter": (battered(curve(900)), {"scheme": "filter"}),
    "flow": (ribbon(1600, width=4.0), {"radius": 1.0, "iterations": 1}),
    "kept volume": (LOOPS, {"keep_volume": True, "motion": "normal", "radius": 1.5}),
}


def test_filter_of_one_part_equals_that_of_many(tmp_path: Path) -> None:
    check(*QUICK["filter"], 200, tmp_path)


def test_flow_of_one_part_equals_that_of_many(tmp_path: Path) -> None:
    check(*QUICK["flow"], 200, tmp_path)


def test_kept_volume_of_one_part_equals_that_of_many(tmp_path: Path) -> None:
    check(*QUICK["kept volume"], 1200, tmp_path)


# --- estimates


#: Points, and options of `estimate_curvature`.
ESTIMATES: dict[str, tuple[Points, dict[str, Any]]] = {
    **{
        f"{orient}, {estimator}, {place}": (
            points, {"orient": orient.replace("*", vector), "estimator": estimator},
        )
        for place, points, vector in (
            ("in space", ROUGH, "30,5,9"), ("in the plane", ROUGH_CURVE, "9,70"),
        )
        for orient in ("auto", "outward", "propagate", "input", "viewpoint=*", "direction=*")
        for estimator in ("cells", "gradient")
    },
    "of the area": (ROUGH, {"estimator": "gradient", "energy": "area"}),
    "of the area in the plane": (ROUGH_CURVE, {"estimator": "gradient", "energy": "area"}),
    "normals that are not wanted": (ROUGH, {"orient": "outward", "normals": normals_for(ROUGH)}),
    "normals that are there": (ROUGH, {"orient": "auto", "normals": normals_for(ROUGH)}),
    **{
        f"support of {support}": (ROUGH, {"support": support}) for support in (3, 20, 60)
    },
    "support of 40 in the plane": (ROUGH_CURVE, {"support": 40}),
    "smooth sheet": (ribbon(3000, noise=0.0), {}),
    "smooth curve": (curve(noise=0.0), {}),
    "on the map": (ROUGH + MAP_COORDINATES, {"orient": "viewpoint=400200,5500000,200"}),
    "small": (ROUGH * 2.0**-100, {"radius": 2.0**-99, "orient": "viewpoint=0,0,1"}),
    "components": (TUBES, {"radius": 1.2, "orient": "outward"}),
    "components in the plane": (LOOPS, {"radius": 1.5, "orient": "propagate"}),
    "radius": (ROUGH, {"radius": "1%"}),
}  # fmt: skip


def check_estimate(points: Points, options: dict[str, Any], tiles: int, folder: Path) -> None:
    """Estimate both ways, and compare all that is told."""
    given: dict[str, Any] = {"radius": "auto", "support": "auto", "orient": "auto", **options}
    if given["orient"] == "input":
        given["normals"] = normals_for(points)
    estimator: Estimator = given.pop("estimator", "cells")
    support: Support = given["support"]
    whole = estimate_curvature(points, estimator=estimator, threads=1, **given)
    orientation = parse_orientation(given["orient"])
    normals = given_normals(given.get("normals"), points.shape, orientation)
    source = source_of(points, normals=normals)
    cloud = TiledCloud(cut_cloud(source, folder, 1 + len(points) // tiles), InProcess())
    assert cloud.n_parts >= 4
    found = estimate_parts(
        cloud, radius=given["radius"], support=support, estimator=estimator,
        quantity=given.get("energy", "volume"), orientation=orientation,
    )  # fmt: skip
    rows = in_input_order(cloud.store, {"estimate": found.fitted.estimates}).read(0, cloud.count)
    finite = usable_rows(points)
    tiled = found.of_rows(rows["estimate"], np.flatnonzero(finite), finite)
    for name, values in vars(tiled).items():
        expected = getattr(whole, name)
        if isinstance(expected, np.ndarray):
            assert values.tobytes() == expected.tobytes(), name
        else:
            assert values == expected, name


@pytest.mark.slow
@pytest.mark.parametrize(("points", "options"), ESTIMATES.values(), ids=ESTIMATES)
def test_estimates_of_one_part_equal_those_of_many(
    points: Points, options: dict[str, Any], tmp_path: Path
) -> None:
    check_estimate(points, options, 6, tmp_path)


@pytest.mark.parametrize("estimator", ["cells", "gradient"])
def test_estimates_of_a_strip_equal_those_of_its_parts(estimator: str, tmp_path: Path) -> None:
    options = {"estimator": estimator, "radius": 1.0, "support": 12}
    check_estimate(ribbon(1600, width=4.0), options, 8, tmp_path)


# --- an energy of other makers


@dataclass(frozen=True)
class FarSighted:
    """Balls whose gradient at a point has the mean of those within the reach of cells added."""

    radius: float
    share: float = 1.0

    local: ClassVar[None] = None

    def reach(self, dimension: int) -> float:
        """Twice that of cells: means over their reach of what depends on points within it."""
        return self.share * 2.0 * cell_reach(self.radius, dimension)

    def evaluate(self, points: Points, box: Points | None = None) -> Evaluation:
        """Evaluate the energy at finite points."""
        found = BallEnergy(self.radius).evaluate(points, box)
        tree, around = cKDTree(points), cell_reach(self.radius, points.shape[1])
        near = tree.query_ball_point(points, around, p=np.inf, return_sorted=True)
        counts = np.array([len(numbers) for numbers in near])
        columns, starts = np.concatenate(near), np.append(0, np.cumsum(counts))
        sums = csr_array((np.ones(len(columns)), columns, starts)) @ found.gradient
        gradient = found.gradient + sums / counts[:, np.newaxis]
        return Evaluation(
            found.union, found.value, gradient, found.diagonal, found.masses, "volume", "cell"
        )


@dataclass(frozen=True, kw_only=True)
class FarSightedBalls(Balls):
    """Shapes that have this energy."""

    share: float = 1.0

    def energy(self, radius: float, _local: object = None) -> Any:
        """Make the energy."""
        return FarSighted(radius, self.share)


@pytest.mark.parametrize("options", [{}, {"motion": "normal"}, {"keep_volume": True}], ids=str)
def test_an_energy_of_twice_the_reach_is_the_same_in_parts(
    options: dict[str, Any], tmp_path: Path
) -> None:
    method = EulerFlow(shapes=FarSightedBalls(radius=1.0), iterations=2)
    points = ribbon(900, width=4.0)
    unlike, _, tiled = compare(points, 110, tmp_path, method=method, threads=1, **options)
    assert unlike == []
    assert tiled.store.partition.n_tiles >= 8


def test_an_energy_that_sees_farther_than_it_says_is_not(tmp_path: Path) -> None:
    method = EulerFlow(shapes=FarSightedBalls(radius=1.0, share=0.5), iterations=1)
    unlike, _, _ = compare(ribbon(900, width=4.0), 110, tmp_path, method=method, threads=1)
    assert "points" in unlike
