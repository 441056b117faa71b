"""A floor plan as a scanner sees its walls from inside: noisy points, coordinates of a survey.

Usage: python floor_plan.py PLAN.csv
"""

import sys

import numpy as np

#: Corners of a floor plan, m.
WALLS = np.array([[0, 0], [10, 0], [10, 4], [6, 4], [6, 7], [3, 7], [3, 5], [0, 5]], dtype=float)

#: Where the building stands in the coordinates of the survey, m.
ORIGIN = np.array([372_150.0, 5_804_320.0])


def noisy_walls(n_points, noise, seed=0):
    """Sample the walls at random, with noise in units of the mean spacing; return both."""
    rng = np.random.default_rng(seed)
    along = np.roll(WALLS, -1, axis=0) - WALLS
    ends = np.cumsum(np.linalg.norm(along, axis=1))
    spacing = ends[-1] / n_points
    place = rng.uniform(0.0, ends[-1], n_points)
    wall = np.searchsorted(ends, place)
    share = 1.0 - (ends[wall] - place) / np.linalg.norm(along, axis=1)[wall]
    points = WALLS[wall] + share[:, np.newaxis] * along[wall]
    return points + noise * spacing * rng.standard_normal(points.shape), spacing


def distance_to_walls(points):
    """Distance of each point to the nearest wall."""
    distances = []
    for start, end in zip(WALLS, np.roll(WALLS, -1, axis=0), strict=True):
        along = end - start
        share = np.clip((points - start) @ along / (along @ along), 0.0, 1.0)
        nearest = start + share[:, np.newaxis] * along
        distances.append(np.linalg.norm(points - nearest, axis=1))
    return np.min(distances, axis=0)


if __name__ == "__main__":
    points, _ = noisy_walls(400, 1.5)
    with open(sys.argv[1], "x") as file:
        print("Id,Easting,Northing,Height", file=file)
        for number, (east, north) in enumerate(points + ORIGIN, 1):
            print(f"{number},{east:.3f},{north:.3f},34.200", file=file)
