"""
Curvature of an ellipse
=======================

An ellipse of 200 even points, whose curvature is known, by the two estimators of the thesis and by
the default. The thesis divides one gradient by one visible boundary, which leaves an error where
gaps are uneven or the radius is not small; the default fits the shape of neighbourhoods.
"""

import matplotlib.pyplot as plt
import numpy as np

import pcsmooth

LONG, SHORT = 180.0, 120.0

t = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
points = np.stack([LONG * np.cos(t), SHORT * np.sin(t)], axis=1)
speed = np.hypot(LONG * np.sin(t), SHORT * np.cos(t))
truth = LONG * SHORT / speed**3

estimators = {
    "the thesis, area of the union": {"estimator": "gradient", "energy": "volume"},
    "the thesis, perimeter": {"estimator": "gradient", "energy": "area"},
    "pcsmooth, default": {},
}

# %%
# Above, curvature as colour and as the length of the lines; below, the error along the ellipse.
figure = plt.figure(figsize=(10, 6.4), layout="constrained")
grid = figure.add_gridspec(2, 3, height_ratios=(1, 1.4))
errors = figure.add_subplot(grid[1, :])
for place, (name, options) in enumerate(estimators.items()):
    estimate = pcsmooth.estimate_curvature(points, radius=15.0, **options)
    axis = figure.add_subplot(grid[0, place])
    tips = points + 2500.0 * estimate.mean_curvature_vectors
    axis.plot(*np.stack([points, tips]).T.swapaxes(1, 2), color="0.75", lw=0.7, zorder=1)
    shown = axis.scatter(
        *points.T, c=estimate.mean_curvature, s=7, cmap="RdYlGn_r", vmin=0.0035, vmax=0.0127
    )
    axis.set_title(name, fontsize=10)
    axis.set_aspect("equal")
    axis.set_axis_off()
    share = 100.0 * (estimate.mean_curvature - truth) / truth
    errors.plot(t, share, lw=1.4, label=f"{name}: at most {np.abs(share).max():.2g} %")
figure.colorbar(shown, ax=axis, aspect=15, label="curvature")
errors.axhline(0.0, color="0.7", lw=0.8, zorder=0)
errors.set_xlim(0.0, 2.0 * np.pi)
errors.set_xticks(np.arange(5) * np.pi / 2, ["0", "π/2", "π", "3π/2", "2π"])
errors.set_xlabel("t (the ends of the long axis are 0 and π)")
errors.set_ylabel("error of the curvature, %")
errors.margins(y=0.15)
errors.legend(frameon=False, ncols=3, loc="upper center", fontsize=8.5)
