"""
A torus, and how far the points are from it
===========================================

20,000 random points of a torus with noise of 0.36 mean spacings. As the torus is known, so is the
error of every point.
"""

import matplotlib.pyplot as plt
import numpy as np
from shading import shaded

import pcsmooth

RING, TUBE = 1.0, 0.4


def random_torus(n_points, rng):
    """Sample evenly: more points where the tube is farther from the axis."""
    tube = rng.uniform(0.0, 2.0 * np.pi, 4 * n_points)
    kept = rng.uniform(0.0, RING + TUBE, len(tube)) < RING + TUBE * np.cos(tube)
    around, tube = rng.uniform(0.0, 2.0 * np.pi, n_points), tube[kept][:n_points]
    far = RING + TUBE * np.cos(tube)
    return np.stack([far * np.cos(around), far * np.sin(around), TUBE * np.sin(tube)], axis=1)


def distance_to_torus(points):
    """Distance of each point to the torus without noise."""
    from_ring = np.hypot(points[:, 0], points[:, 1]) - RING
    return np.abs(np.hypot(from_ring, points[:, 2]) - TUBE)


rng = np.random.default_rng(0)
noisy = random_torus(20_000, rng) + 0.01 * rng.normal(size=(20_000, 3))
result = pcsmooth.denoise(noisy)

# %%
# Colours are distances to the torus, in units of the mean spacing. What is left is a sixth of the
# noise (RMS: root of the mean square).
figure, axes = plt.subplots(1, 2, figsize=(11, 3.9), layout="constrained")
scale = plt.cm.ScalarMappable(plt.Normalize(0.0, 0.8), "viridis")
for axis, title, points in zip(axes, ("noisy", "denoised"), (noisy, result.points), strict=True):
    errors = distance_to_torus(points) / result.spacing
    normals = pcsmooth.estimate_curvature(points, support=12).normals
    picture = shaded(
        points,
        normals,
        view=(0.0, -1.0, 0.9),
        up=(0, 0, 1),
        disc=1.4 * result.spacing,
        width=600,
        frame=noisy,
        colors=scale.to_rgba(errors)[:, :3],
    )
    axis.imshow(picture)
    axis.set_title(f"{title}: RMS distance {np.sqrt(np.mean(errors**2)):.2f} spacings")
    axis.set_axis_off()
figure.colorbar(scale, ax=axes, shrink=0.8, label="distance to the torus, spacings", extend="max")
