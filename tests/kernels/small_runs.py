"""Small clouds through every kernel, for runs without compilation.

As a program, ``python small_runs.py GROUP FILE``, it does a group of runs as plain Python, which
checks every index and fails where compiled code reads and writes beside an array, and saves the
results.
"""

from __future__ import annotations

import pickle
import sys
from collections.abc import Callable, Mapping
from functools import partial
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
Results = Mapping[str, Array]


def _sphere(count: int, dimension: int) -> Array:
    rng = np.random.default_rng(count)
    points = rng.normal(size=(count, dimension))
    points /= np.linalg.norm(points, axis=1)[:, np.newaxis]
    return np.asarray(points * (1 + 0.03 * rng.normal(size=(count, 1))))


def _lattice(*counts: int) -> Array:
    axes = [np.arange(float(count)) for count in counts]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(counts))


def _on_line(dimension: int) -> Array:
    return np.outer(np.arange(20.0) ** 1.2, np.arange(1.0, dimension + 1))


def _clump(dimension: int) -> Array:
    """Points within a hundredth of a radius, one of them twice, and one alone."""
    points = 0.01 * np.random.default_rng(7).normal(size=(30, dimension))
    return np.concatenate([points, points[:1], np.full((1, dimension), 9.0)])


def _strip(count: int) -> Array:
    """A long, rough strip, of which no tile sees both ends."""
    return np.random.default_rng(8).random((count, 3)) * [count / 2.0, 2.0, 1.0]


#: Clouds with a radius: in general position, in all ties of a grid, on a line, in a clump.
CLOUDS: dict[str, tuple[Array, float]] = {
    "random 2D": (_sphere(80, 2), 0.2),
    "random 3D": (_sphere(90, 3), 0.5),
    "deep 3D": (np.random.default_rng(3).random((60, 3)), 0.4),
    "grid 2D": (_lattice(5, 6), 1.3),
    "grid 3D": (_lattice(3, 4, 3), 1.1),
    "line 2D": (_on_line(2), 3.0),
    "line 3D": (_on_line(3), 5.0),
    "clump 2D": (_clump(2), 1.0),
    "clump 3D": (_clump(3), 1.0),
    "sheets": (_lattice(7, 6, 2) * [1.0, 1.0, 0.3] + [0.1, 0.7, 0.3], 1.45),
    "one point": (np.zeros((1, 3)), 1.0),
}


def measure_balls(cloud: str) -> Results:
    from pcsmooth.energies.balls import measure_balls

    points, radius = CLOUDS[cloud]
    return {"measures": measure_balls(points, radius).measures}


def measure_unequal_balls(cloud: str) -> Results:
    from pcsmooth.energies.balls import measure_balls
    from pcsmooth.energies.facet_laplacian import facet_laplacian

    points, radius = CLOUDS[cloud]
    radii = radius * np.random.default_rng(9).uniform(0.5, 1.0, len(points))
    union = measure_balls(points, radii)
    return {"measures": union.measures, "weights": facet_laplacian(union, "volume").weights}


def measure_polyhedra(cloud: str, rule: Any, is_unequal: bool = False) -> Results:
    from oracles import MEASURES
    from pcsmooth.bodies.presets import load_presets
    from pcsmooth.energies.polyhedra.union import measure_polyhedra

    points, radius = CLOUDS[cloud]
    body = load_presets()["hexagon" if points.shape[1] == 2 else "cube"]
    radii: Any = radius
    if is_unequal:
        radii = radius * np.random.default_rng(9).uniform(0.5, 1.0, len(points))
    union = measure_polyhedra(points, radii, body, union=rule)
    return {name: getattr(union, name) for name in (*MEASURES, "volume_diagonal", "area_diagonal")}


def local_spacing(cloud: str) -> Results:
    from pcsmooth.neighbors.local_spacing import local_spacings

    return {"spacings": local_spacings(CLOUDS[cloud][0])}


def denoise(points: Array, **options: Any) -> Results:
    from pcsmooth.python.denoising import denoise

    result = denoise(points, threads=2, **options)
    estimate = result.curvature
    return {"points": result.points, "normals": estimate.normals, "mean": estimate.mean_curvature}


def denoise_in_tiles(points: Array, **options: Any) -> Results:
    from pcsmooth.cloud import PointCloud
    from tiling.whole_and_tiled import in_tiles

    with TemporaryDirectory() as folder:
        result = in_tiles(points, 25, Path(folder), iterations=1, radius=1.0, **options)
        parts = [part for _, part in result.parts(iter([PointCloud(points)]))]
    return {
        "points": np.concatenate([part.points for part in parts]),
        "normals": np.concatenate([part.curvature.normals for part in parts]),
    }


def _with_outliers(points: Array) -> Array:
    far = 3.0 * np.random.default_rng(5).normal(size=(5, points.shape[1]))
    return np.concatenate([points, far])


_RANDOM = {2: CLOUDS["random 2D"][0], 3: CLOUDS["random 3D"][0]}

#: By group, what is done in one process.
RUNS: dict[str, dict[str, Callable[[], Results]]] = {
    "balls": {cloud: partial(measure_balls, cloud) for cloud in CLOUDS},
    "unequal balls": {
        cloud: partial(measure_unequal_balls, cloud)
        for cloud in ("random 2D", "random 3D", "deep 3D", "grid 2D", "grid 3D", "line 3D")
    },
    "local spacing": {cloud: partial(local_spacing, cloud) for cloud in CLOUDS},
    **{
        rule: {
            **{
                cloud: partial(measure_polyhedra, cloud, rule)
                for cloud in ("random 2D", "grid 2D", "grid 3D", "deep 3D", "line 3D", "clump 3D")
            },
            **{
                f"unequal, {cloud}": partial(measure_polyhedra, cloud, rule, is_unequal=True)
                for cloud in ("grid 2D", "deep 3D")
            },
        }
        for rule in ("naive", "inclusion-exclusion", "exact")
    },
    "denoise": {
        "filter 2D": partial(denoise, _RANDOM[2]),
        "filter 3D": partial(denoise, _with_outliers(_sphere(90, 3))),
        "euler 2D": partial(
            denoise, _RANDOM[2], energy="area", iterations=2, orient="direction=0,1"
        ),
        "euler 3D": partial(denoise, _RANDOM[3], energy="volume", iterations=1, orient="outward"),
        "implicit 3D": partial(denoise, _RANDOM[3], scheme="implicit", iterations=1),
        "implicit, grid": partial(
            denoise, CLOUDS["grid 2D"][0], scheme="implicit", iterations=1, order=1
        ),
        "given normals": partial(
            denoise, _RANDOM[2], energy="area", iterations=0, orient="input", normals=_RANDOM[2]
        ),
        "kept volume": partial(
            denoise, _RANDOM[3], energy="volume", iterations=1, motion="normal", keep_volume=True
        ),
        "in tiles": partial(denoise_in_tiles, _strip(60)),
        "kept volume in tiles": partial(denoise_in_tiles, _strip(60), keep_volume=True),
    },
    "shrunken": {
        **{
            f"balls, {cloud}": partial(measure_balls, cloud)
            for cloud in ("random 2D", "deep 3D", "grid 3D", "clump 3D")
        },
        "unequal balls, deep 3D": partial(measure_unequal_balls, "deep 3D"),
        "exact, deep 3D": partial(measure_polyhedra, "deep 3D", "exact"),
        "filter": partial(denoise, _RANDOM[2]),
        "in tiles": partial(denoise_in_tiles, _strip(60)),
        "implicit": partial(denoise, CLOUDS["deep 3D"][0], scheme="implicit", iterations=1),
    },
}

#: What may be small as well, by module: numbers of items from which on work is done another way,
#: arrays grow and blocks are parted. What comes out must be the same.
SHRUNKEN = {
    "threads": {"MANY": 16},
    "grid.radix_sort": {"BLOCK": 16},
    "grid.within_reach": {"_RUN": 8},
    "cells.hidden_neighbors": {"_MANY": 12},
    "balls.cells_2d": {"_MANY": 6},
    "balls.cells_3d": {"_FACETS_AT_FIRST": 2, "_MOST_NEIGHBORS": 40},
    "balls.facet_weights": {"_FACETS_AT_FIRST": 1},
    "polyhedra.visible_facets": {"_PIECES_AT_FIRST": 1},
    "surface.forest_pieces": {"_ROOM": 4},
}


def results_of(group: str) -> dict[str, Array]:
    return {
        f"{run}: {name}": values for run, do in RUNS[group].items() for name, values in do().items()
    }


def main() -> None:
    from kernels import plain_simd

    group, target = sys.argv[1:]
    sys.modules["pcsmooth.kernels.arithmetic.simd"] = plain_simd
    forest_pieces = import_module("pcsmooth.kernels.surface.forest_pieces")
    # Fields are attributes, as they are where records are compiled.
    vars(forest_pieces)["EDGE"] = np.dtype((np.record, forest_pieces.EDGE))
    if group == "shrunken":
        for module, numbers in SHRUNKEN.items():
            for name, number in numbers.items():
                vars(import_module(f"pcsmooth.kernels.{module}"))[name] = number
    Path(target).write_bytes(pickle.dumps(results_of(group)))


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))
    main()
