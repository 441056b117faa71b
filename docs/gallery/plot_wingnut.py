"""
A wing nut with noise, and the errors that are left
===================================================

10,000 random points of the shipped wing nut with noise of 2 % of its radius: hollows, sharp edges
and thin wings. The mesh is known, so the error of every point is, too.
"""

import matplotlib.pyplot as plt
import numpy as np
import trimesh
from scipy.spatial import KDTree
from shading import shaded
from shipped import DATA

import pcsmooth

mesh = trimesh.load_mesh(DATA / "meshes" / "wingnut.ply", process=False)
mesh.apply_translation(-mesh.bounds.mean(axis=0))
mesh.apply_scale(1.0 / np.linalg.norm(mesh.vertices, axis=1).max())
clean, _ = trimesh.sample.sample_surface(mesh, 10_000, seed=1)
noisy = clean + 0.02 * np.random.default_rng(1).normal(size=clean.shape)
result = pcsmooth.denoise(noisy)

# %%
# Distances are those to the nearest of 500,000 points of the mesh, in percent of its radius.
dense = KDTree(trimesh.sample.sample_surface(mesh, 500_000, seed=2)[0])
figure, axes = plt.subplots(2, 2, figsize=(11, 7.4), layout="constrained")
scale = plt.cm.ScalarMappable(plt.Normalize(0.0, 4.0), "viridis")
for column, (title, points) in enumerate({"noisy": noisy, "denoised": result.points}.items()):
    errors = 100.0 * dense.query(points)[0]
    normals = pcsmooth.estimate_curvature(points, support=12).normals
    for line, colors in enumerate(({}, {"colors": scale.to_rgba(errors)[:, :3]})):
        picture = shaded(
            points,
            normals,
            view=(0.9, 0.25, 0.5),
            up=(0, 1, 0),
            disc=1.4 * result.spacing,
            width=500,
            frame=noisy,
            **colors,
        )
        axes[line, column].imshow(picture)
        axes[line, column].set_axis_off()
    axes[0, column].set_title(f"{title}: mean distance {errors.mean():.2f} %")
figure.colorbar(scale, ax=axes[1], shrink=0.8, label="distance, % of the radius", extend="max")
