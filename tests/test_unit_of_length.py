"""Lengths near those of the cloud, and clouds of any size."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

import oracles
import pcsmooth
from oracles import Array
from pcsmooth.bodies.presets import load_presets
from pcsmooth.energies.protocol import Quantity, UnionName, Weight
from pcsmooth.energies.weighting import power_of_step
from pcsmooth.errors import InvalidInputError
from pcsmooth.unit_of_length import power_of_two_near, unit_for, unit_near
from tiling.whole_and_tiled import differences, in_tiles, states

#: From 1e-100 to 1e100, and where units other than 1 begin.
EXPONENTS = (-332, -211, -31, 34, 150, 332)

every_scale = pytest.mark.parametrize("scale", [math.ldexp(1.0, e) for e in EXPONENTS])
#: Where runs take longer: the ends, and the last without a unit of its own and the first with one.
some_scales = pytest.mark.parametrize("scale", [math.ldexp(1.0, e) for e in (-332, -31, 34, 332)])
every_dimension = pytest.mark.parametrize("dimension", [2, 3])


@pytest.mark.parametrize(
    ("length", "unit"),
    [
        (1.0, 1.0), (2.0**32, 1.0), (2.0**-32, 1.0), (3 * 2.0**31, 2.0**33),
        (0.7 * 2.0**-32, 2.0**-32), (1e100, 2.0**333), (0.0, 1.0),
        (-1.0, 1.0), (math.nan, 1.0), (math.inf, 1.0),
    ],
)  # fmt: skip
def test_unit_near(length: float, unit: float) -> None:
    assert unit_near(length) == unit


@pytest.mark.parametrize("length", [1.01e100, 1e300, 0.99e-103, 5e-324])
def test_what_cannot_be_measured(length: float) -> None:
    with pytest.raises(InvalidInputError, match=r"between 1e-103 and 1e\+100; give the cloud in"):
        unit_near(length)


@pytest.mark.parametrize(
    ("size", "power"), [(0.0, 1.0), (1.0, 2.0), (0.75, 1.0), (5e-324, 5e-324 * 2)]
)
def test_power_of_two(size: float, power: float) -> None:
    assert power_of_two_near(size) == power


def test_stray_points_have_coordinates() -> None:
    points = np.array([[0.0, 1e-60], [1e-60, 0.0], [1e140, 0.0]])
    unit = unit_for(points, 1e-60)
    assert np.abs(points / unit).max() <= 1e150
    assert unit == unit_for(-points, 1e-60) == pytest.approx(1e-10, rel=1)
    assert unit_for(points[:2], 1e-60) == unit_near(1e-60)


def noisy(dimension: int) -> Array:
    """A closed shape with noise and a point that is there twice."""
    points = oracles.random_sphere(350, dimension=dimension)
    points *= 1 + 0.02 * np.random.default_rng(4).normal(size=(350, 1))
    points[7] = points[8]
    return points


Measures = dict[str, tuple[Any, int]]
"""Values with the power of length in them."""


def of_union(union: Any, d: int) -> Measures:
    return {
        "volume": (union.volume, d), "area": (union.area, d - 1),
        "cell_volumes": (union.cell_volumes, d), "visible_areas": (union.visible_areas, d - 1),
        "volume_gradient": (union.volume_gradient, d - 1),
        "area_gradient": (union.area_gradient, d - 2),
        "volume_diagonal": (union.volume_diagonal, d - 2),
        "area_diagonal": (union.area_diagonal, d - 3),
    }  # fmt: skip


def of_estimate(estimate: Any, d: int) -> Measures:
    return {
        "normals": (estimate.normals, 0), "confidence": (estimate.confidence, 0),
        "mean": (estimate.mean_curvature, -1), "gaussian": (estimate.gaussian_curvature, 1 - d),
        "principal": (estimate.principal_curvatures, -1),
        "radius": (estimate.radius, 1), "spacing": (estimate.spacing, 1),
        "supports": ((estimate.normal_support, estimate.curvature_support), 0),
    }  # fmt: skip


def of_result(result: Any, d: int) -> Measures:
    found: Measures = {
        **of_estimate(result.curvature, d),
        "points": (result.points, 1), "displacement": (result.displacement, 1),
        "volumes": ([state.volume for state in result.history], d),
        "areas": ([state.area for state in result.history], d - 1),
        "moves": ([(state.mean_move, state.max_move) for state in result.history], 1),
        "step": (result.step, 0 if result.method.name == "filter" else power_of_step(
            result.method.shapes.quantity, result.method.shapes.weight, d)),
        "solver": (result.solver_error, 0),
        "outliers": (0.0 if result.outliers is None else result.outliers, 0),
        "longest": (result.motion.max_move or 0.0, 1),
    }  # fmt: skip
    if result.plan is not None:
        widths = [
            (width.thickness, width.max_radius) for width in (*result.plan.passes, result.plan.last)
        ]
        found["plan"] = ([result.plan.noise.deviation, result.plan.spacing], 1)
        found["widths"] = (widths, 1)
    return found


def assert_same(found: Measures, expected: Measures, scale: float) -> None:
    """Equal to the last bit, times powers of the scale."""
    exponent = math.frexp(scale)[1] - 1
    assert found.keys() == expected.keys()
    for name, (values, power) in expected.items():
        actual = np.asarray(found[name][0], np.float64)
        half = -(exponent * power) // 2  # neither factor overflows
        back = np.ldexp(np.ldexp(actual, half), -exponent * power - half)
        np.testing.assert_array_equal(back, np.asarray(values, np.float64), err_msg=name)


@every_scale
@every_dimension
def test_balls(dimension: int, scale: float) -> None:
    points, radius = noisy(dimension), 0.3
    expected = pcsmooth.measure_balls(points, radius)
    found = pcsmooth.measure_balls(points * scale, radius * scale)
    assert_same(of_union(found, dimension), of_union(expected, dimension), scale)
    tensors = (found.normal_tensors, dimension - 1), (expected.normal_tensors, dimension - 1)
    assert_same({"tensors": tensors[0]}, {"tensors": tensors[1]}, scale)
    np.testing.assert_array_equal(found.grid.coordinates / scale, expected.grid.coordinates)


@every_scale
@every_dimension
@pytest.mark.parametrize("union", get_args(UnionName))
def test_polyhedra(union: UnionName, dimension: int, scale: float) -> None:
    body = load_presets()["cube" if dimension == 3 else "square"]
    points, radius = noisy(dimension), 0.3
    expected = pcsmooth.measure_polyhedra(points, radius, body, union)
    found = pcsmooth.measure_polyhedra(points * scale, radius * scale, body, union)
    assert_same(of_union(found, dimension), of_union(expected, dimension), scale)


@some_scales
@every_dimension
@pytest.mark.parametrize(
    "options", [{}, {"estimator": "gradient"}, {"orient": "viewpoint"}], ids=str
)
def test_curvature(options: dict[str, Any], dimension: int, scale: float) -> None:
    def estimate(factor: float) -> Any:
        eye = ",".join(["0"] * (dimension - 1) + [repr(3.0 * factor)])
        orient = {"orient": f"viewpoint={eye}"} if "orient" in options else {}
        return pcsmooth.estimate_curvature(
            noisy(dimension) * factor, threads=1, **{**options, **orient}
        )

    expected = of_estimate(estimate(1.0), dimension)
    assert_same(of_estimate(estimate(scale), dimension), expected, scale)


FLOWS: dict[str, Callable[[float, int], dict[str, Any]]] = {
    "filter": lambda scale, d: {},
    "told": lambda scale, d: {"noise": 0.03 * scale, "max_move": 0.02 * scale, "motion": "normal"},
    "euler": lambda scale, d: {"scheme": "euler", "motion": "normal", "keep_volume": True},
    "stopped": lambda scale, d: {"scheme": "euler", "radius": 0.3 * scale, "stop": 0.05},
    "implicit": lambda scale, d: {"scheme": "implicit"},
    "implicit area": lambda scale, d: {"scheme": "implicit", "energy": "area", "weight": "none"},
    "long": lambda scale, d: {"scheme": "implicit", "order": 1, "step": 1e9 * scale**2},
    "polyhedra": lambda scale, d: {
        "iterations": 1, "polyhedron": load_presets()["cube" if d == 3 else "square"]
    },
    "implicit polyhedra": lambda scale, d: {
        "scheme": "implicit", "iterations": 1,
        "polyhedron": load_presets()["cube" if d == 3 else "square"],
    },
    "autodiff": lambda scale, d: {"gradient": "autodiff", "iterations": 1},
}  # fmt: skip


def denoised(name: str, dimension: int, scale: float) -> Any:
    points = noisy(dimension)[: 80 if name == "autodiff" else None]
    return pcsmooth.denoise(points * scale, threads=1, **FLOWS[name](scale, dimension))


@cache
def denoised_as_it_is(name: str, dimension: int) -> Any:
    return denoised(name, dimension, 1.0)


@pytest.mark.slow
@some_scales
@every_dimension
@pytest.mark.parametrize("name", FLOWS)
def test_denoise(name: str, dimension: int, scale: float) -> None:
    expected, found = denoised_as_it_is(name, dimension), denoised(name, dimension, scale)
    assert_same(of_result(found, dimension), of_result(expected, dimension), scale)
    assert expected.displacement.max() > 0


@some_scales
@every_dimension
@pytest.mark.parametrize("quantity", get_args(Quantity))
@pytest.mark.parametrize("weight", get_args(Weight))
def test_given_steps(weight: Weight, quantity: Quantity, dimension: int, scale: float) -> None:
    power = power_of_step(quantity, weight, dimension)
    expected, found = (
        pcsmooth.denoise(
            noisy(dimension) * by, threads=1, iterations=1, energy=quantity, weight=weight,
            step=1e-3 * by**power, support=12,
        )
        for by in (1.0, scale)
    )  # fmt: skip
    assert_same(of_result(found, dimension), of_result(expected, dimension), scale)


@pytest.mark.slow
@pytest.mark.parametrize("scale", [math.ldexp(1.0, -320), math.ldexp(1.0, 320)])
@pytest.mark.parametrize("options", [{"scheme": "filter"}, {}, {"step": "given"}], ids=str)
def test_tiles(options: dict[str, Any], scale: float, tmp_path: Path) -> None:
    """As the whole, to the last bit, and as tiles of the cloud before it was scaled."""
    points = noisy(3)
    expected, found = (
        {**options, **({"step": 1e-3 * by**2} if options.get("step") else {})}
        for by in (1.0, scale)
    )
    whole = pcsmooth.denoise(points * scale, threads=1, **{"scheme": "euler", **found})
    tiled = in_tiles(points * scale, 120, tmp_path, threads=1, **found)
    assert tiled.store.partition.n_tiles > 2
    assert differences(whole, tiled, points * scale) == []
    (other := tmp_path / "other").mkdir()
    before = in_tiles(points, 120, other, threads=1, **expected)
    np.testing.assert_array_equal(
        states(tiled.overall) / scale ** np.array([0, 3, 2, 1, 1]), states(before.overall)
    )
    actual, wanted = tiled.denoised.facts(), before.denoised.facts()
    assert actual == dataclasses.replace(
        wanted,
        mean_displacement=wanted.mean_displacement * scale,
        max_displacement=wanted.max_displacement * scale,
        rms_along_normal=_times(wanted.rms_along_normal, scale),
        rms_along_surface=_times(wanted.rms_along_surface, scale),
        noise_after=_times(wanted.noise_after, scale),
    )


def _times(length: float | None, scale: float) -> float | None:
    return None if length is None else length * scale


@pytest.mark.parametrize("scale", [1e-105, 1e103, 1e140])
def test_clouds_beyond_are_refused(scale: float, tmp_path: Path) -> None:
    points = noisy(3) * scale
    for act in (
        lambda: pcsmooth.denoise(points),
        lambda: pcsmooth.estimate_curvature(points),
        lambda: pcsmooth.measure_balls(points, 0.3 * scale),
        lambda: pcsmooth.measure_polyhedra(points, 0.3 * scale, load_presets()["cube"]),
        lambda: in_tiles(points, 100, tmp_path),
    ):
        with pytest.raises(InvalidInputError, match=r" 1e-103 (and|to) 1e\+100"):
            act()
