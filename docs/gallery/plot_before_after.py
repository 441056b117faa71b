"""
A cow, before and after
=======================

40,000 random points of the shipped cow, with noise in all three coordinates, and what
`pcsmooth.denoise` makes of them without a parameter.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
import trimesh
from PIL import Image
from shading import shaded
from shipped import DATA

import pcsmooth

# %%
# The noise is 1.2 % of the cow's size, and 0.8 times the mean spacing of its points.
mesh = trimesh.load_mesh(DATA / "meshes" / "spot.ply", process=False)
clean, _ = trimesh.sample.sample_surface(mesh, 40_000, seed=0)
noise = 0.012 * np.linalg.norm(clean, axis=1).max()
noisy = clean + noise * np.random.default_rng(0).normal(size=clean.shape)
result = pcsmooth.denoise(noisy)
print(f"noise {noise:.4f}, measured {result.plan.noise.deviation:.4f}")
print(f"noise in units of the mean spacing: {noise / result.spacing:.2f}")

# %%
# Every point is drawn as a small disc, lit by its normal. So that noise is seen as noise, normals
# are estimated from 12 points on both sides; those that `pcsmooth.denoise` gives are smoother.
figure, axes = plt.subplots(1, 2, figsize=(12, 6.6), layout="constrained")
for axis, title, points in zip(
    axes, ("noisy points", "pcsmooth denoise"), (noisy, result.points), strict=True
):
    normals = pcsmooth.estimate_curvature(points, support=12).normals
    picture = shaded(
        points,
        normals,
        view=(-0.6, 0.3, -0.9),
        up=(0, 1, 0),
        disc=1.25 * result.spacing,
        width=700,
        frame=noisy,
    )
    axis.imshow(picture)
    axis.set_title(title, fontsize=16)
    axis.set_axis_off()

if len(sys.argv) > 1:  # the picture of the README, see `make pictures`; few colours, few bytes
    figure.set_dpi(110)
    figure.canvas.draw()
    drawn = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())).convert("RGB")
    drawn.quantize(96, dither=Image.Dither.NONE).save(sys.argv[1], optimize=True)
