"""
A Kinect scan: layers, displacements, curvatures
================================================

The shipped scan of a milk carton, 13,704 points of a depth camera, in metres. A depth camera tells
distances in steps, and the steps are all that its noise is here.
"""

import matplotlib.pyplot as plt
import numpy as np
from shading import shaded
from shipped import DATA
from showing import show

import pcsmooth
from pcsmooth.plots.cloud_figure import cloud_figure
from pcsmooth.plots.valued_clouds import along_normals, by_displacement
from pcsmooth.plots.views import facing

CAMERA = {"view": (-0.5, -0.35, -1.0), "up": (0, -1, 0), "width": 500}

scan = pcsmooth.read_cloud(DATA / "scans" / "kinect_milk.ply").points
result = pcsmooth.denoise(scan)

# %%
# A slice 3 mm thick, seen from above: steps of the depth become two walls that meet in a corner.
height = np.median(scan[:, 1])
chosen = np.abs(scan[:, 1] - height) < 0.0015
figure, axes = plt.subplots(1, 2, figsize=(10, 3.6), sharex=True, sharey=True, layout="constrained")
for axis, title, cloud, color in zip(
    axes,
    ("scan", "pcsmooth denoise"),
    (scan, result.points),
    ("tab:red", "tab:blue"),
    strict=True,
):
    axis.scatter(*1e3 * cloud[chosen][:, [0, 2]].T, s=5, color=color, lw=0)
    axis.set_title(title)
    axis.set_aspect("equal")
    axis.set_xlabel("x, mm")
axes[0].set_ylabel("depth, mm")

# %%
# How far every point moved along its normal, as `pcsmooth plot --color-by displacement` draws it.
moved = along_normals(by_displacement(scan, result.points), result.normals)
show(cloud_figure(moved, view=facing(result.normals)))

# %%
# The same faces lit from the side. The bumps that are left are centimetres wide: depths of this
# camera bend over such lengths, which no neighbourhood can tell from shape.
figure, axes = plt.subplots(1, 2, figsize=(10, 5.6), layout="constrained")
for axis, title, cloud in zip(
    axes, ("scan", "pcsmooth denoise"), (scan, result.points), strict=True
):
    normals = pcsmooth.estimate_curvature(cloud, support=12).normals
    picture = shaded(cloud, normals, frame=scan, disc=1.3 * result.spacing, **CAMERA)
    axis.imshow(picture)
    axis.set_title(title)
    axis.set_axis_off()

# %%
# Mean curvature, in 1/m: what bends away from the viewer is red (a milk carton's edges), hollows
# are blue, and flat faces are grey.
figure, axis = plt.subplots(figsize=(6, 5.6), layout="constrained")
scale = plt.cm.ScalarMappable(plt.Normalize(-40.0, 40.0), "coolwarm")
colors = scale.to_rgba(result.mean_curvature)[:, :3]
picture = shaded(result.points, result.normals, disc=1.3 * result.spacing, colors=colors, **CAMERA)
axis.imshow(picture)
axis.set_axis_off()
figure.colorbar(scale, ax=axis, shrink=0.8, label="mean curvature, 1/m", extend="both")
