"""Draw what denoising does to a scan of many layers and to a noisy model.

Usage: python quality_pictures.py [--data DIR]
"""

import argparse
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Rectangle
from mesh_shapes import Shape, load_shapes
from peers import PeerError
from readme_pictures import AFTER, BEFORE, DATA, save
from smoothers import JETS, NOISY, OURS, SMOOTHERS
from surface_distances import distances_to_mesh

from pcsmooth import denoise, read_cloud
from pcsmooth.neighbors.spacing import mean_spacing

MODEL, NOISE = "wingnut", 0.02  #: noise in units of its radius
VIEW, UP = np.array([0.9, 0.0, 0.44]), np.array([0.0, 1.0, 0.0])  #: towards the eye, and upwards
HEIGHT, THICKNESS = 0.1, 0.0006  #: of the slice, metres


def bunny(scan: Path) -> None:
    """Show a slice through a scanned bunny: the whole, and its layers close up."""
    points = read_cloud(scan).points
    smooth = denoise(points).points
    figure, axes = plt.subplots(1, 3, figsize=(11, 2.6), width_ratios=(1, 2, 2))
    chosen = np.abs(points[:, 1] - HEIGHT) < 0.5 * THICKNESS
    window = ((-70.0, -42.0), (40.5, 45.5))
    for axis, cloud, color, title in zip(
        axes,
        (points, points, smooth),
        (BEFORE, BEFORE, AFTER),
        ("slice, ten range images", "close up", "pcsmooth denoise"),
        strict=True,
    ):
        axis.scatter(*(1e3 * cloud[chosen][:, [0, 2]].T), s=5, color=color, lw=0)
        axis.set_title(title, fontsize=10)
        axis.set_xlabel("x, mm")
    for axis in axes[1:]:
        axis.set(xlim=window[0], ylim=window[1])
    low = [edge[0] for edge in window]
    sizes = [edge[1] - edge[0] for edge in window]
    axes[0].add_patch(Rectangle((low[0], low[1]), *sizes, fill=False, color="0.4"))
    for axis in axes:
        axis.set_aspect("equal")
    axes[0].set_ylabel("z, mm")
    save(figure, "bunny_slice.png")


def model(shape: Shape) -> None:
    """Show a noisy model, and what jets and the defaults make of it."""
    clean, unit = shape.sample(10_000, seed=1)
    noisy, spacing = clean + NOISE * unit, mean_spacing(clean)
    right = np.cross(UP, VIEW) / np.linalg.norm(VIEW)
    figure, axes = plt.subplots(1, 3, figsize=(10, 2.5), sharex=True, sharey=True)
    for axis, name in zip(axes, (NOISY, JETS[24], *OURS), strict=False):
        cloud = SMOOTHERS[name](noisy, spacing)
        far = distances_to_mesh(cloud, shape.vertices, shape.faces)
        front = np.argsort(cloud @ VIEW)  # the nearest points hide the others
        shown = axis.scatter(
            cloud[front] @ right,
            cloud[front] @ UP,
            c=100.0 * far[front],
            s=6,
            vmin=0.0,
            vmax=100.0 * NOISE,
            cmap="viridis",
            lw=0,
        )
        axis.set_axis_off()
        axis.set_aspect("equal")
        axis.set_title(f"{name}\nmean distance {100.0 * far.mean():.2f} %", fontsize=10)
    figure.colorbar(shown, ax=axes, pad=0.01, label="distance, % of radius")
    save(figure, "denoised_model.png")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Draw what denoising does.")
    parser.add_argument("--data", type=Path, help="folder with meshes/ and scans/ [the shipped]")
    data = parser.parse_args().data or DATA
    scan = data / "scans" / "bunny_raw_all10.ply"
    if scan.exists():
        bunny(scan)
    else:
        print(f"The bunny is not drawn: --data names no folder with scans/{scan.name}.")
    try:
        model(load_shapes([MODEL], DATA)[0])
    except PeerError as failure:
        print(f"The noisy model is not drawn: a program {failure}.")
