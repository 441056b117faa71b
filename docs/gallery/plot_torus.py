"""
A torus, before and after
=========================

20,000 random points on a torus with noise of 0.36 spacings, and what the default makes of them.
"""

import matplotlib.pyplot as plt
import numpy as np

import pcsmooth

rng = np.random.default_rng(0)
u, v = rng.uniform(0, 2 * np.pi, (2, 20_000))
points = np.stack(
    [(1 + 0.4 * np.cos(v)) * np.cos(u), (1 + 0.4 * np.cos(v)) * np.sin(u), 0.4 * np.sin(v)], axis=1
)
noisy = points + 0.01 * rng.normal(size=points.shape)
result = pcsmooth.denoise(noisy)

# %%
# The shading comes from the normals that `pcsmooth.denoise` gives for every point.
figure, axes = plt.subplots(1, 2, figsize=(9, 4))
for axis, cloud in zip(axes, (noisy, result.points), strict=True):
    axis.scatter(cloud[:, 0], cloud[:, 1], s=1, c=cloud[:, 2])
    axis.set_aspect("equal")
