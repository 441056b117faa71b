"""A drone flight over fields and two barns, as a LAZ file with classes.

Usage: python flight.py FLIGHT.laz
"""

import sys

import laspy
import numpy as np

N_POINTS = 120_000
WIDE = 120.0  #: side of the square that is flown over, m
CORNER = np.array([431_200.0, 5_518_640.0, 0.0])  #: south-western, in UTM coordinates, m
NOISE = 0.05  #: standard deviation along each axis, m
BARNS = [(30.0, 40.0, 24.0, 12.0, 6.0), (70.0, 75.0, 16.0, 10.0, 5.0)]  #: x, y, sides, height
TREES = [(95.0, 25.0), (101.0, 33.0), (18.0, 95.0)]
CONTROL = [(10, 10), (110, 12), (60, 60), (12, 108), (108, 110)]  #: surveyed points, m

GROUND, TREE, ROOF, LOW_NOISE, HIGH_NOISE = 2, 5, 6, 7, 18


def ground(x, y):
    """Height of the fields, m."""
    return 212.0 + 3.0 * np.sin(x / 37.0) + 2.0 * np.cos(y / 29.0) + 0.02 * x


def fly(rng):
    """Points in the order of flight, (n, 3), in metres from the corner, and their classes."""
    x, y = rng.uniform(0.0, WIDE, (2, N_POINTS))
    order = np.lexsort((x, y // 20.0))
    x, y = x[order], y[order]
    z, classes = ground(x, y), np.full(N_POINTS, GROUND, dtype=np.uint8)
    for left, front, length, width, height in BARNS:
        inside = (abs(x - left - length / 2) < length / 2) & (
            abs(y - front - width / 2) < width / 2
        )
        gable = (1.0 - abs(y - front - width / 2) / (width / 2)) * 3.0
        base = ground(left, front) + height
        z[inside], classes[inside] = base + gable[inside], ROOF
    for trunk_x, trunk_y in TREES:
        crown = np.hypot(x - trunk_x, y - trunk_y) < 3.5
        z[crown] += rng.uniform(1.0, 9.0, np.count_nonzero(crown))
        classes[crown] = TREE
    points = np.stack([x, y, z], axis=1) + NOISE * rng.normal(size=(N_POINTS, 3))
    stray = rng.choice(N_POINTS, 300, replace=False)
    points[stray[:150], 2] -= rng.uniform(3.0, 20.0, 150)
    points[stray[150:], 2] += rng.uniform(15.0, 60.0, 150)
    classes[stray[:150]], classes[stray[150:]] = LOW_NOISE, HIGH_NOISE
    return points, classes


if __name__ == "__main__":
    rng = np.random.default_rng(0)
    points, classes = fly(rng)
    control = np.zeros(N_POINTS, dtype=np.uint8)
    for x, y in CONTROL:
        row = np.argmin(np.hypot(points[:, 0] - x, points[:, 1] - y))
        points[row] = x, y, ground(x, y)
        control[row], classes[row] = 1, GROUND
    cloud = laspy.LasData(laspy.LasHeader(version="1.4", point_format=6))
    cloud.header.scales, cloud.header.offsets = np.full(3, 0.001), CORNER
    cloud.add_extra_dim(laspy.ExtraBytesParams("control", "u1", "surveyed on the ground"))
    cloud.x, cloud.y, cloud.z = (points + CORNER).T
    cloud.classification, cloud.control = classes, control
    cloud.intensity = rng.integers(200, 4000, N_POINTS, dtype=np.uint16)
    cloud.gps_time = 3.1e8 + 2e-4 * np.arange(N_POINTS)
    cloud.return_number = cloud.number_of_returns = np.ones(N_POINTS, dtype=np.uint8)
    with open(sys.argv[1], "xb") as file:
        cloud.write(file, do_compress=True)
