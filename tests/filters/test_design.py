"""A design reaches all steps of the filter, and one that makes no sense is refused."""

from __future__ import annotations

import pickle
from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import oracles
from filters.whole import filter_whole, plan_of
from oracles import Array
from pcsmooth.errors import InvalidInputError
from pcsmooth.filters.design import DESIGN, ByDimension, FilterDesign
from pcsmooth.filters.plan import FilterPlan
from pcsmooth.methods.filter import Filter
from pcsmooth.python.denoising import denoise
from tiling.whole_and_tiled import compare


@cache
def cloud(name: str, dimension: int) -> Array:
    rng = np.random.default_rng(dimension)
    if name == "volume":
        return rng.random((1000, dimension))
    if name == "uneven":  # ten times as far apart at one end as at the other
        along = 1.1 ** np.linspace(0, 25, 4000 if dimension == 2 else 40)
        if dimension == 2:
            return np.stack([np.cumsum(along), 4 * rng.normal(size=4000)], axis=1)
        x, y = np.meshgrid(np.cumsum(along), np.arange(40.0))
        x, y = x.ravel(), y.ravel()
        return np.stack([x, y * x / 9, 0.1 * rng.normal(size=1600)], axis=1)
    if name == "cables":  # in the plane they are curves, as all else
        line, side = rng.random((600, 3)) * [10.0, 0.0, 0.0], rng.random((3000, 3)) * [10, 10, 0]
        line += 0.01 * rng.normal(size=(600, 3)) + [0.0, 5.0, 5.0]
        side[:, 2] += 0.02 * rng.normal(size=3000)
        return np.asarray(np.concatenate([line, side])[:, :dimension])
    if "steps" in name:  # curves in the plane have none
        x, y = (grid.ravel() for grid in np.meshgrid(np.arange(60.0), np.arange(60.0)))
        points = np.stack([x, y, np.floor(x / (11.0 if name == "wide steps" else 6.0))], axis=1)
        return points if dimension == 3 else cloud("noisy", 2)
    if name == "dense and sparse":
        sheet = np.zeros((6000, dimension))
        sheet[:, :-1] = rng.random((6000, dimension - 1))
        sheet[3000:] *= 1e-3
        return sheet
    if name == "sparse part":
        # Next to a dense sheet a sparser one, and few points that are sparser still.
        if dimension == 2:
            along = np.r_[rng.random(2600), 1 + 4 * rng.random(400)]
            return np.stack([along, 1e-4 * rng.normal(size=3000)], axis=1)
        halves = [scale * rng.random((1500, 2)) for scale in (0.4, 1.2)]
        few = np.stack(np.meshgrid(np.arange(7.0), np.arange(7.0)), axis=-1).reshape(-1, 2)
        few = 0.17 * (few + 0.2 * rng.random(few.shape))
        along = np.concatenate(
            [halves[0], halves[1] + np.array([0.41, 0]), few + np.array([1.7, 0])]
        )
        return np.asarray(np.c_[along, 1e-4 * rng.normal(size=len(along))])
    if name == "wall":  # ten times sparser than the ground
        ground, wall = np.zeros((8000, dimension)), np.zeros((120, dimension))
        ground[:, :-1] = 90 * rng.random((8000, dimension - 1))
        ground[:, -1] = 1e-3 * rng.normal(size=8000)
        wall[:, 0] = 1e-5 * rng.normal(size=120)
        if dimension == 2:
            wall[:, 1] = 0.06 * np.arange(120) + 0.5
        else:
            wall[:, 1:] = rng.random((120, 2)) * np.array([60, 20])
        return np.concatenate([ground, wall])
    if name == "clumps":
        circle = oracles.random_sphere(1000, dimension=dimension)
        return np.concatenate([circle, 3 + 1e-3 * rng.normal(size=(8, dimension))])
    if name == "strays":
        sphere = oracles.random_sphere(2000, dimension=dimension)
        sphere *= 1 + 1e-3 * rng.normal(size=(2000, 1))
        return np.concatenate([sphere, rng.uniform(-1.5, 1.5, (400, dimension))])
    if name == "large":
        return oracles.random_sphere(21_000, dimension=dimension) + 1e-3 * rng.normal(
            size=(21_000, dimension)
        )
    if name == "walls":  # four noises apart, these half a spacing
        n, noise = 3000, 0.5 * 3000 ** (1 / (1 - dimension))
        along = rng.random((2 * n, dimension - 1))
        heights = np.repeat([0.0, 4 * noise], n) + noise * rng.normal(size=2 * n)
        return np.column_stack([along, heights])
    if name == "thin":  # four noises between the faces of a shell
        shell = oracles.random_sphere(3000, dimension=dimension)
        shell[1500:] *= 0.92
        shell += 0.02 * rng.normal(size=shell.shape)
        return np.concatenate([shell, 30 * shell[:3]])
    surface = oracles.random_sphere(1000, dimension=dimension)
    spacing = (oracles.sphere_area(1, dimension) / 1000) ** (1 / (dimension - 1))
    noisy = surface + 0.1 * spacing * rng.normal(size=surface.shape)
    # Outliers that have neighbours on the surface, others that have no neighbours but those, and
    # some far from all.
    heights = rng.uniform(1.3, 2.5, (30, 1))
    beyond = heights + (4.0 if dimension == 2 else 2.0)
    near, farther = (surface[:30] * (1 + spacing * height) for height in (heights, beyond))
    return np.concatenate([noisy, near, farther, 3 * surface[:5]])


#: A noise that is told, in units of the radius: far more than there is.
LOUD = 0.6

#: Another value of each number, on which cloud it shows, and a noise that is told.
CHANGES: dict[str, tuple[Any, str, float | None]] = {
    "samples": (300, "noisy", None),
    "nearest": (400, "noisy", LOUD),
    "noise_supports": (ByDimension((16, 90), (36, 120)), "noisy", None),
    "noise_max_share": (1e-3, "noisy", None),
    "noise_max_residual": (ByDimension(1e-3, 1e-3), "noisy", None),
    "noise_kept": (ByDimension(((0.0, 1.0),), ((0.0, 1.0),)), "noisy", None),
    "uneven_quantiles": ((0.49, 0.51), "uneven", None),
    "uneven_spacing": (ByDimension(1e3, 1e3), "uneven", None),
    "uneven_noise": (ByDimension(1.01, 1.01), "noisy", None),
    "uneven_cover": (ByDimension(0.5, 1.0), "noisy", None),
    "map_samples": (300, "uneven", None),
    "map_nearest": (17, "uneven", None),
    "map_neighbors": (3, "uneven", None),
    "cover_supports": (ByDimension((8,), (9, 40)), "uneven", None),
    "cover_ratio": (0.9, "uneven", None),
    "cover_group": (8, "uneven", None),
    "cable_support": (12, "cables", None),
    "cable_width": (1e-9, "cables", None),
    "cable_roundness": (1.0, "cables", None),
    "layer_count": (200, "steps", None),
    "layer_thickness": (0.9, "steps", None),
    "layer_share": (1.0, "steps", None),
    "layer_supports": ((), "wide steps", None),
    "layer_rows": (9.0, "steps", None),
    "layer_slant": (1e-9, "steps", None),
    "stepped_share": (1.0, "wide steps", None),
    "noise_group": (ByDimension(64, 24), "uneven", None),
    "noise_wide_group": (ByDimension(0.5, 0.5), "uneven", None),
    "noise_wide_limit": (0.5, "uneven", None),
    "noise_quantile": (0.5, "uneven", None),
    "scale_quantile": (0.2, "uneven", None),
    "scale_limit": (0.5, "uneven", None),
    "radius_slack": (1.1, "uneven", None),
    "pilot_points": (500, "noisy", None),
    "pilot_least": (2000, "noisy", None),
    "pilot_most": (200, "large", None),
    "pilot_width": (100.0, "large", None),
    "pilot_max_extent": (1.0, "large", None),
    "pilot_step": (0.5, "walls", None),
    "pilot_steps": (2, "walls", None),
    "pilot_slope": (9.0, "walls", None),
    "pilot_support": (2.0, "walls", None),
    "pilot_max_support": (1.0, "noisy", None),
    "pilot_share": (0.9, "walls", None),
    "sides_samples": (500, "thin", 0.02),
    "sides_nearest": (40, "thin", 0.02),
    "sides_far": (1e6, "thin", 0.02),
    "sides_few": (1e-9, "thin", 0.02),
    "sides_noise": (0.1, "thin", 0.02),
    "sides_step": (4.0, "thin", 0.02),
    "sides_cells": (1000, "thin", 0.02),
    "sides_width": (4.0, "thin", 0.02),
    "flatness_supports": (ByDimension((3,), (4,)), "volume", None),
    "flatness_max_share": (1e-3, "volume", None),
    "solid_flatness": (ByDimension(0.9, 0.9), "volume", None),
    "surface_flatness": (0.9, "volume", None),
    "surface_share": (1e-3, "volume", None),
    "pass_count": (ByDimension(5.0, 14.0), "noisy", None),
    "pass_thickness": ((2.5, 2.0, 1.5), "noisy", None),
    "pass_exponents": ((2, 4, 2), "noisy", None),
    "pass_variances": ((0.5, 0.5, 0.5), "noisy", None),
    "normals_exponent": (2, "noisy", None),
    "last_count": (ByDimension(24.0, 96.0), "noisy", None),
    "last_thickness": (2.0, "noisy", None),
    "last_exponent": (4, "noisy", None),
    "radius_quantile": (0.5, "noisy", None),
    "radius_margin": (1.1, "noisy", None),
    "max_within": (20.0, "noisy", None),
    "radius_shrinkage": (0.7, "dense and sparse", 1e-9),
    "residual_variance": (0.3, "noisy", None),
    "energy_share": (1.0, "noisy", None),
    "max_move": (0.5, "noisy", None),
    "max_move_by_map": (0.5, "uneven", None),
    "left_kept": (0.5, "noisy", None),
    "left_heights": (0.5, "noisy", None),
    "left_pass": (2.0, "noisy", None),
    "left_last": (ByDimension(2.0, 2.0), "noisy", None),
    "left_detail": (0.1, "noisy", None),
    "outlier_rounds": (1, "noisy", None),
    "outlier_deviations": (50.0, "noisy", None),
    "outlier_max_height": (1e3, "noisy", None),
    "isolated_count": (ByDimension(4.0, 8.0), "noisy", None),
    "isolated_share": (ByDimension(0.9, 0.8), "noisy", None),
    "isolated_max_share": (1e-6, "noisy", None),
    "sheet_count": (ByDimension(5000, 5000), "sparse part", None),
    "sheet_thickness": (ByDimension(1e-9, 1e-9), "sparse part", None),
    "clear_sheet_thickness": (ByDimension(1e-12, 1e-12), "wall", None),
    "clump_size": (3, "clumps", None),
    "stray_counts": ((4, 30), "strays", None),
    "stray_distance": (8.0, "strays", None),
    "stray_slope": (20.0, "strays", None),
    "stray_group": (60, "strays", None),
    "stray_thickness": (ByDimension(0.5, 0.5), "strays", None),
    "stray_clear": (50.0, "strays", None),
    "stray_clear_share": (1.0, "strays", None),
    "stray_min_share": (0.9, "strays", None),
    "redistribution_width": (0.4, "noisy", None),
    "redistribution_steps": (3, "noisy", None),
    "redistribution_strength": (0.1, "noisy", None),
    "redistribution_max_move": (0.1, "noisy", None),
    "border_offset": (0.05, "noisy", None),
}


def planned(points: Array, name: str, noise: float | None, design: FilterDesign) -> FilterPlan:
    plan = plan_of(points, noise, design, closed=name == "thin")
    assert plan is not None
    assert plan.design is design
    return plan


def filtered(points: Array, plan: FilterPlan) -> bytes:
    """Where the points end, which are outliers, and what error is left."""
    result = filter_whole(points, plan)
    left = b"" if result.left is None else result.left.tobytes()
    return result.points.tobytes() + result.outliers.tobytes() + left


@cache
def filtered_as_ever(name: str, dimension: int, noise: float | None) -> bytes:
    points = cloud(name, dimension)
    return filtered(points, planned(points, name, noise, DESIGN))


def test_every_number_is_tried() -> None:
    assert list(CHANGES) == [field.name for field in fields(FilterDesign)]


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("changed", CHANGES)
def test_every_number_reaches_the_filter(changed: str, dimension: int) -> None:
    """Alone it changes the plan, or else the result."""
    value, name, noise = CHANGES[changed]
    design = replace(DESIGN, **{changed: value})
    points = cloud(name, dimension)
    plan, plan_as_ever = planned(points, name, noise, design), planned(points, name, noise, DESIGN)
    if dimension == 2 and changed in ("cover_ratio", "map_nearest"):
        pytest.skip("neighbourhoods of 16 points cover a curve, and hold its noise")
    if dimension == 2 and changed.startswith(("cable", "layer", "stepped")):
        pytest.skip("there are no cables and steps in the plane")
    if dimension == 2 and changed in ("pilot_steps", "pilot_slope", "pilot_support", "pilot_share"):
        pytest.skip("two curves that are merged stay so whatever is told")
    if name == "thin" or replace(plan, design=DESIGN) == plan_as_ever:
        is_same = filtered(points, plan) == filtered_as_ever(name, dimension, noise)
        assert not is_same


def test_a_method_has_a_design() -> None:
    points = cloud("noisy", 3)
    design = replace(DESIGN, max_move=0.5)
    result = denoise(points, Filter(design=design))
    assert result.plan is not None
    assert result.plan.design == design
    noise = result.plan.noise.deviation
    assert result.displacement.max() == pytest.approx(0.5 * noise, rel=1e-12)
    assert denoise(points).displacement.max() > noise


@pytest.mark.slow
def test_a_design_reaches_tiles(tmp_path: Path) -> None:
    """And with it how far steps look around: here farther than by the usual one."""
    design = replace(
        DESIGN,
        samples=100,
        nearest=500,
        pass_count=ByDimension(6.0, 30.0),
        pass_thickness=(3.0, 2.0),
        pass_exponents=(2, 2),
        pass_variances=(2.0, 1.0),
        redistribution_steps=12,
        redistribution_max_move=4.0,
        redistribution_strength=1.0,
        max_move=9.0,
    )
    points = oracles.torus_surface(3000).noisy(0.4)
    unlike, whole, tiled = compare(points, 500, tmp_path, method=Filter(design=design))
    assert unlike == []
    assert tiled.store.partition.n_tiles > 4
    assert np.abs(whole.points - denoise(points).points).max() > 1e-3


def test_designs_travel() -> None:
    design = replace(DESIGN, max_move=0.5, pass_count=ByDimension(5.0, 14.0))
    assert pickle.loads(pickle.dumps(design)) == design != DESIGN


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"max_move": -1.0}, "max_move of the filter's design is not positive"),
        ({"samples": 0}, "samples .* not positive"),
        ({"outlier_rounds": 0}, "outlier_rounds .* not positive"),
        ({"last_thickness": float("nan")}, "last_thickness .* not positive"),
        ({"radius_margin": float("inf")}, "radius_margin .* not positive"),
        ({"pass_count": ByDimension(4.0, -12.0)}, "pass_count .* not positive"),
        ({"pass_thickness": (2.5, 0.0, 1.25)}, "pass_thickness .* not positive"),
        ({"energy_share": 1.1}, "energy_share .* more than 1"),
        ({"radius_quantile": 95.0}, "radius_quantile .* more than 1"),
        ({"isolated_share": ByDimension(0.25, 40.0)}, "isolated_share .* more than 1"),
        ({"noise_quantile": 1.5}, "noise_quantile .* more than 1"),
        ({"cover_ratio": 0.0}, "cover_ratio .* not positive"),
        ({"uneven_quantiles": (0.9, 0.1)}, "uneven_quantiles .* not increasing"),
        ({"cover_supports": ByDimension((6,), (9, 9))}, "cover_supports .* not increasing"),
        ({"stray_counts": (22, 8)}, "stray_counts .* not increasing"),
        ({"stray_counts": (2, 4)}, "stray_counts .* no more than a plane has, and one"),
        ({"sheet_count": ByDimension(3, 13)}, "sheet_count .* no more than a plane has, and one"),
        ({"sheet_thickness": ByDimension(0.03, 1.6)}, "sheet_thickness .* more than 1"),
        ({"stray_min_share": 2.0}, "stray_min_share .* more than 1"),
        ({"map_nearest": 12}, "map_nearest .* less than the noise needs"),
        ({"pilot_max_extent": 0.9}, "pilot_max_extent .* less than 1"),
        ({"pilot_step": 1.0}, "pilot_step .* not below 1"),
        ({"radius_shrinkage": 1.0}, "radius_shrinkage .* not below 1"),
        ({"pass_exponents": (2, 3, 4)}, "pass_exponents .* not even"),
        ({"last_exponent": 7}, "last_exponent .* not even"),
        ({"normals_exponent": 1}, "normals_exponent .* not even"),
        ({"pass_thickness": (), "pass_exponents": ()}, "pass_thickness .* empty"),
        ({"pass_exponents": (2, 4)}, "pass_exponents .* not as many as pass_thickness"),
        ({"pass_variances": (2.0,)}, "pass_variances .* not as many as pass_thickness"),
        ({"noise_supports": ByDimension((6, 8), (36, 24))}, "noise_supports .* not increasing"),
        ({"noise_supports": ByDimension((3, 8), (16, 24))}, "noise_supports .* terms of a quadric"),
        ({"noise_supports": ByDimension((6, 8), (6, 24))}, "noise_supports .* terms of a quadric"),
        ({"nearest": 399}, "noise_supports .* more than nearest"),
        ({"flatness_supports": ByDimension((9, 9), (24,))}, "flatness_supports .* not increasing"),
        ({"flatness_supports": ByDimension((2,), (24,))}, "flatness_supports .* a plane has"),
        ({"flatness_supports": ByDimension((9,), (3,))}, "flatness_supports .* a plane has"),
        (
            {"noise_kept": ByDimension(((0.0, 1.0), (0.0, 0.9)), ((0.0, 1.0),))},
            "noise_kept .* not increasing",
        ),
        ({"noise_kept": ByDimension(((0.0, 1.0),), ((0.0, 0.0),))}, "noise_kept .* not a share"),
    ],
    ids=str,
)
def test_what_would_be_silently_wrong_is_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        replace(DESIGN, **changes)
