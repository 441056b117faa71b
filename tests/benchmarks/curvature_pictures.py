"""Draw normals and curvatures as the report does in its Figures 26, 27 and 37.

Usage: python curvature_pictures.py [--data DIR]
"""

import argparse
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from curvature_shapes import ellipse
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Line3DCollection
from readme_pictures import AFTER, BEFORE, save

from pcsmooth import estimate_curvature

Array = npt.NDArray[np.float64]

RADIUS = 15.0
ESTIMATORS: dict[str, dict[str, Any]] = {
    "the report, area of the union": {"estimator": "gradient", "energy": "volume"},
    "the report, perimeter": {"estimator": "gradient", "energy": "area"},
    "pcsmooth, default": {"estimator": "cells"},
}
COLORS = (BEFORE, "#c9971c", AFTER)


def ellipse_curvature() -> None:
    """Show the curvature of an ellipse with its normals, and the errors of the estimators."""
    surface, t = ellipse(200, 180.0, 120.0)
    figure = plt.figure(figsize=(10, 6.4), layout="constrained")
    grid = figure.add_gridspec(2, 3, height_ratios=(1, 1.4))
    errors = figure.add_subplot(grid[1, :])
    x, y = surface.points.T
    row = []
    for place, (name, options) in enumerate(ESTIMATORS.items()):
        estimate = estimate_curvature(surface.points, radius=RADIUS, **options)
        curvature = estimate.mean_curvature
        axis = figure.add_subplot(grid[0, place])
        tips = surface.points + 2500.0 * estimate.mean_curvature_vectors
        for start, tip in zip(surface.points[::2], tips[::2], strict=True):
            axis.plot(*zip(start, tip, strict=True), color="0.75", lw=0.7, zorder=1)
        shown = axis.scatter(x, y, c=curvature, s=7, cmap="RdYlGn_r", vmin=0.0035, vmax=0.0127)
        axis.set_title(name, fontsize=10)
        axis.set_aspect("equal")
        axis.set_axis_off()
        row.append(axis)
        share = 100.0 * (curvature - surface.mean) / surface.mean
        text = f"{name}: at most {np.abs(share).max():.2g} %"
        errors.plot(t, share, color=COLORS[place], lw=1.4, label=text)
    figure.colorbar(shown, ax=row, aspect=15, pad=0.01, label="curvature")
    errors.axhline(0.0, color="0.7", lw=0.8, zorder=0)
    errors.set_xlim(0.0, 2.0 * np.pi)
    errors.set_xticks(np.arange(5) * np.pi / 2, ["0", "π/2", "π", "3π/2", "2π"])
    errors.set_xlabel("t (the ends of the long axis are 0 and π)")
    errors.set_ylabel("error of the curvature, %")
    bottom, top = errors.get_ylim()
    errors.set_ylim(bottom, top + 0.15 * (top - bottom))
    errors.legend(frameon=False, ncols=3, loc="upper center", fontsize=8.5)
    save(figure, "ellipse_curvature.png")


def fandisk_normals(cloud: Array) -> None:
    """Show the normals of the report's fandisk (n, 6), from two sides."""
    points, given = cloud[:, :3], cloud[:, 3:]
    normals = estimate_curvature(points).normals
    along = np.sum(normals * given, axis=1)
    angles = np.degrees(np.arccos(np.clip(along, -1.0, 1.0)))
    figure = plt.figure(figsize=(10, 5.4))
    for place, (elevation, azimuth) in enumerate(((25, -60), (25, 120)), 1):
        axis = figure.add_subplot(1, 2, place, projection="3d")
        assert isinstance(axis, Axes3D)
        shown = draw_normals(axis, points, normals, given, angles, elevation, azimuth)
    bar = figure.add_axes((0.92, 0.2, 0.015, 0.6))
    figure.colorbar(shown, cax=bar, label="angle to the given normal, degrees")
    figure.subplots_adjust(left=0.0, right=0.9, bottom=0.0, top=0.95, wspace=0.0)
    figure.text(0.45, 0.9, f"estimated normals, median angle {np.median(angles):.1f}°", ha="center")
    save(figure, "fandisk_normals.png")


def draw_normals(
    axis: Axes3D,
    points: Array,
    normals: Array,
    given: Array,
    angles: Array,
    elevation: float,
    azimuth: float,
) -> Line3DCollection:
    """Draw the normals on the side that is seen."""
    up, around = np.radians([elevation, azimuth])
    view = np.array([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)])
    seen = given @ view > -0.1
    starts = points[seen]
    lines = np.stack([starts, starts + 0.06 * normals[seen]], axis=1)
    arrows = Line3DCollection(lines, array=angles[seen], cmap="viridis", lw=0.9)
    arrows.set_clim(0.0, 45.0)
    axis.add_collection3d(arrows)
    axis.scatter(*starts.T, c=angles[seen], s=7, cmap="viridis", vmin=0.0, vmax=45.0, lw=0)
    axis.set_box_aspect(np.ptp(points, axis=0), zoom=1.3)
    axis.view_init(elevation, azimuth)
    axis.patch.set_visible(False)  # it would hide the other view
    axis.set_axis_off()
    return arrows


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Draw normals and curvatures.")
    parser.add_argument("--data", type=Path, help="folder with report/fandisk_simplified.xyz")
    data = parser.parse_args().data
    ellipse_curvature()
    if data is None:
        print("Fandisk is not drawn: --data names no folder with report/fandisk_simplified.xyz.")
    else:
        fandisk_normals(np.loadtxt(data / "report" / "fandisk_simplified.xyz"))
