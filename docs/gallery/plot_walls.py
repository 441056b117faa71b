"""
Walls: a floor plan by discs and by squares
===========================================

400 points of the walls of a floor plan with noise of 1.5 mean spacings. A flow of unions of
discs rounds corners as it smooths. With squares in place of the discs, walls turn towards the
sides of the square: they become straight, and corners stay.
"""

import matplotlib.pyplot as plt
import numpy as np
from floor_plan import WALLS, distance_to_walls, noisy_walls

import pcsmooth

noisy, spacing = noisy_walls(400, 1.5)
square = pcsmooth.load_presets()["square"]
flow = {"scheme": "euler", "radius": "5x", "iterations": 30}
clouds = {
    "noisy": noisy,
    "discs": pcsmooth.denoise(noisy, **flow).points,
    "squares": pcsmooth.denoise(noisy, polyhedron=square, **flow).points,
}

# %%
# The number is the distance to the walls in units of the mean spacing (root of the mean square).
figure, axes = plt.subplots(1, 3, figsize=(11, 3.1), sharex=True, sharey=True, layout="constrained")
for axis, (title, cloud) in zip(axes, clouds.items(), strict=True):
    rms = np.sqrt(np.mean(distance_to_walls(cloud) ** 2)) / spacing
    axis.plot(*np.append(WALLS, WALLS[:1], axis=0).T, color="0.75", lw=0.8, zorder=0)
    axis.plot(*cloud.T, ".", ms=2.5, color="tab:red" if cloud is noisy else "tab:blue")
    axis.set_title(f"{title}: RMS distance {rms:.2f}", fontsize=10)
    axis.set_aspect("equal")
    axis.set_axis_off()
