"""Draw the pictures of the README into data/pictures."""

from io import BytesIO
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from clouds import noisy_torus
from matplotlib.figure import Figure
from PIL import Image

from pcsmooth import denoise, read_cloud

DATA = Path(__file__).resolve().parents[2] / "data"
BEFORE, AFTER = "#c0504d", "#1f4e79"
COLORS = 240  #: of a picture


def save(figure: Figure, name: str) -> None:
    """Write one picture, with a palette, which makes it a fraction of the size."""
    folder = DATA / "pictures"
    folder.mkdir(exist_ok=True)
    drawn = BytesIO()
    figure.savefig(drawn, dpi=110, bbox_inches="tight")
    plt.close(figure)
    palette = Image.open(drawn).convert("RGB").quantize(COLORS, dither=Image.Dither.NONE)
    palette.save(folder / name, optimize=True)


def kinect() -> None:
    """Show a slice through the milk carton of the Kinect scan, before and after."""
    points = read_cloud(DATA / "scans" / "kinect_milk.ply").points
    smooth = denoise(points).points
    height = np.median(points[:, 1])
    chosen = np.abs(points[:, 1] - height) < 0.0015
    figure, axes = plt.subplots(1, 2, figsize=(10, 3.6), sharex=True, sharey=True)
    for axis, cloud, color, title in zip(
        axes, (points, smooth), (BEFORE, AFTER), ("scan", "pcsmooth denoise"), strict=True
    ):
        axis.scatter(cloud[chosen, 0] * 1e3, cloud[chosen, 2] * 1e3, s=5, color=color, lw=0)
        axis.set_title(title)
        axis.set_aspect("equal")
        axis.set_xlabel("x, mm")
    axes[0].set_ylabel("depth, mm")
    save(figure, "kinect_slice.png")


def torus() -> None:
    """Show a noisy torus before and after, coloured by the distance to the truth."""
    points, spacing = noisy_torus(20_000, 0.36, seed=1)
    result = denoise(points)

    def error(cloud: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        ring = np.hypot(cloud[:, 0], cloud[:, 1]) - 1.0
        return np.asarray(np.abs(np.hypot(ring, cloud[:, 2]) - 0.4) / spacing)

    figure = plt.figure(figsize=(10, 4.2))
    for place, (cloud, title) in enumerate(((points, "noisy"), (result.points, "denoised")), 1):
        axis = figure.add_subplot(1, 2, place, projection="3d")
        front = np.argsort(cloud @ np.array([-0.5, -0.5, 0.7]))
        shown = axis.scatter(
            *cloud[front].T,
            c=error(cloud)[front],
            s=4,
            vmin=0,
            vmax=0.8,
            cmap="viridis",
            lw=0,
            depthshade=False,
        )
        axis.set_axis_off()
        axis.set_box_aspect((1.4, 1.4, 0.42), zoom=1.35)
        axis.view_init(38, -135)
        rms = np.sqrt(np.mean(error(cloud) ** 2))
        axis.set_title(f"{title}: RMS distance {rms:.2f} spacings", y=0.93)
    figure.colorbar(shown, ax=figure.axes, shrink=0.6, label="distance to the torus, spacings")
    save(figure, "torus.png")


def ellipse() -> None:
    """Show the report's noisy ellipse and what the defaults and the report's flow make of it."""
    points = read_cloud(DATA / "report" / "ellipse-noisy-dense.xy").points
    figure, axes = plt.subplots(1, 3, figsize=(10, 2.9), sharex=True, sharey=True)
    axes[0].plot(*points.T, ".", ms=3, color=BEFORE)
    axes[0].set_title("the report's 200 noisy points", fontsize=9)
    defaults = denoise(points)
    report = denoise(
        points, scheme="euler", energy="area", weight="none", radius=15.0, iterations=59, step=1.0
    )
    flow = "--scheme euler --energy area --weight none\n--radius 15 --step 1 --iterations 59"
    titles = ("pcsmooth denoise", flow)
    for axis, result, title in zip(axes[1:], (defaults, report), titles, strict=True):
        axis.plot(*result.points.T, ".", ms=3, color=AFTER)
        axis.quiver(*result.points.T, *result.normals.T, color="0.6", width=0.002, scale=25)
        axis.set_title(title, fontsize=9)
    for axis in axes:
        axis.set_aspect("equal")
    save(figure, "ellipse.png")


if __name__ == "__main__":
    kinect()
    torus()
    ellipse()
