"""A street, scanned by a laser from one place, as a PTX file.

Usage: python street.py STREET.ptx
"""

import sys

import numpy as np

COLUMNS, ROWS = 900, 260  #: directions around and upwards
LOWEST, HIGHEST = -50.0, 45.0  #: degrees
SCANNER = np.array([512_340.0, 5_402_118.0, 311.7])  #: in the coordinates of the survey, m
HEIGHT = 1.7  #: of the scanner above the street, m
NOISE = 0.012  #: standard deviation of the ranges, m
MIXED = 0.002  #: share of rays that hit two things at once, and return what is between
FARTHEST = 35.0  #: range, m

#: Boxes in the frame of the scanner, lowest and highest corner, m: facades, a van, a kiosk.
BOXES = [
    ((-40.0, 7.0, -HEIGHT), (18.0, 15.0, 9.0)),
    ((-22.0, -15.0, -HEIGHT), (40.0, -6.0, 7.5)),
    ((4.0, 3.0, -HEIGHT), (8.5, 4.9, 0.4)),
    ((-7.0, -4.5, -HEIGHT), (-5.0, -2.5, 0.9)),
]
POST = (2.5, -3.0, 0.12)  #: a lamp: x, y and radius, m


def ranges(directions):
    """Distance from the scanner to what each ray meets first, m; infinite where it meets none."""
    with np.errstate(divide="ignore", invalid="ignore"):
        nearest = np.where(directions[:, 2] < 0.0, -HEIGHT / directions[:, 2], np.inf)
        for low, high in BOXES:
            ends = np.stack([np.divide(corner, directions) for corner in (low, high)])
            enter, leave = ends.min(axis=0).max(axis=1), ends.max(axis=0).min(axis=1)
            nearest = np.where((enter > 0) & (enter < leave) & (enter < nearest), enter, nearest)
        x, y, radius = POST
        flat = np.linalg.norm(directions[:, :2], axis=1)
        along = directions[:, :2] @ [x, y] / flat
        beside = radius**2 - (x**2 + y**2 - along**2)
        hit = (along - np.sqrt(beside)) / flat
        met = (beside > 0) & (hit > 0) & (hit * directions[:, 2] < 4.0) & (hit < nearest)
    return np.where(met, hit, nearest)


def scan(rng):
    """Points in the frame of the scanner, (n, 3), 0 0 0 where nothing comes back; intensities."""
    around = np.linspace(0.0, 2.0 * np.pi, COLUMNS, endpoint=False)
    upwards = np.radians(np.linspace(LOWEST, HIGHEST, ROWS))
    azimuth, elevation = (grid.ravel() for grid in np.meshgrid(around, upwards, indexing="ij"))
    flat = np.cos(elevation)
    directions = np.stack(
        [flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)], axis=1
    )
    true = ranges(directions)
    far = true + NOISE * rng.normal(size=len(true))
    mixed = rng.uniform(size=len(true)) < MIXED
    far[mixed] *= rng.uniform(0.5, 1.0, np.count_nonzero(mixed))
    back = true < FARTHEST
    points = np.where(back, far, 0.0)[:, np.newaxis] * directions
    return points, np.where(back, 1.0 / (1.0 + 0.02 * np.minimum(true, FARTHEST) ** 2), 0.0)


if __name__ == "__main__":
    points, intensities = scan(np.random.default_rng(0))
    with open(sys.argv[1], "x") as file:
        print(COLUMNS, ROWS, sep="\n", file=file)
        print(*SCANNER, file=file)
        print("1 0 0\n0 1 0\n0 0 1", file=file)
        print("1 0 0 0\n0 1 0 0\n0 0 1 0", file=file)
        print(*SCANNER, 1, file=file)
        np.savetxt(file, np.column_stack([points, intensities]), fmt="%.4f")
