"""What the filter does to clouds as scanners make them, of which the truth is known: tables.

RMS distance to the surface after the filter over that before, of all points but outliers, and by
class.
pcsmooth runs with its defaults and knows nothing but the points.
Usage: python bench_scans.py [--seeds N,...] [--only PART,...] [SECTION ...]
"""

import argparse
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np
from known_clouds import KNOWN_CLOUDS, KnownCloud, Marks
from machine import machine_line
from simulated_scans import SIMULATED_SCANS
from surface_distances import Array, root_mean_square
from tables import header, percent, row

from pcsmooth import DenoiseResult, denoise

Makers = Mapping[str, Callable[[int], KnownCloud]]
Figures = Mapping[str, float]  #: by the name of the column, NaN where there is nothing to tell

ERRORS = "after / before"


def scores(cloud: KnownCloud, classes: Sequence[str]) -> Figures:
    """What becomes of a cloud."""
    result = denoise(cloud.points)
    after, before = cloud.distances(result.points), cloud.errors
    good = ~cloud.outliers
    figures = {"noise found / true": noise_ratio(cloud, result), ERRORS: ratio(after, before, good)}
    for name in classes:
        marks = cloud.classes.get(name)
        figures[name] = np.nan if marks is None else ratio(after, before, good & marks)
    figures["within sigma_after"] = within(after, result, good)
    figures["normals off"] = normals_off(cloud, result)
    found = np.zeros(len(good), np.bool_) if result.outliers is None else result.outliers
    figures["outliers marked"] = share(found, cloud.outliers)
    figures["falsely"] = share(found, good)
    return figures


def ratio(after: Array, before: Array, marks: Marks) -> float:
    """RMS of some errors over what it was."""
    return root_mean_square(after[marks]) / root_mean_square(before[marks])


def noise_ratio(cloud: KnownCloud, result: DenoiseResult) -> float:
    """Median over the points of what the filter found of the noise, over the truth."""
    good = ~cloud.outliers
    return 0.0 if result.sigma is None else float(np.median((result.sigma / cloud.noise)[good]))


def within(after: Array, result: DenoiseResult, marks: Marks) -> float:
    """Share of some points whose error is less than the standard deviation that is told."""
    told = result.sigma_after
    return np.nan if told is None else float(np.mean(after[marks] <= told[marks]))


def normals_off(cloud: KnownCloud, result: DenoiseResult) -> float:
    """Median angle of the normals to the true ones, whatever their signs, degrees."""
    if cloud.normals is None:
        return np.nan
    cosines = np.abs(np.einsum("ij,ij->i", result.normals, cloud.normals))
    return float(np.degrees(np.median(np.arccos(np.minimum(cosines, 1.0)))))


def share(found: Marks, marks: Marks) -> float:
    """Share of some points that were found."""
    return float(found[marks].mean()) if marks.any() else np.nan


def section(
    title: str, makers: Makers, classes: Sequence[str], chosen: Sequence[str], seeds: Sequence[int]
) -> None:
    """Print a table of clouds."""
    shown = ", ".join(map(str, seeds))
    print(
        f"\n{title}, {'means over the seeds' if len(seeds) > 1 else 'seed'} {shown}:\n", flush=True
    )
    named = False
    for name, make in makers.items():
        if chosen and not any(part in name for part in chosen):
            continue
        clouds = [make(seed) for seed in seeds]
        found = [scores(cloud, classes) for cloud in clouds]
        if not named:
            header("cloud", "points", *found[0])
            named = True
        means = {column: float(np.mean([one[column] for one in found])) for column in found[0]}
        cells = (written(column, value) for column, value in means.items())
        row(name, f"{np.mean([len(cloud.points) for cloud in clouds]):,.0f}", *cells)


def written(column: str, value: float) -> str:
    """Write a figure as its column has them."""
    if np.isnan(value):
        return ""
    if column == "within sigma_after":
        return f"{100.0 * value:.0f} %"
    if column in ("outliers marked", "falsely"):
        return percent(value)
    return f"{value:.1f}°" if column == "normals off" else f"{value:.2f}"


def names_of(text: str) -> list[str]:
    """Split at commas."""
    return text.split(",")


def main() -> None:
    """Print the sections asked for."""
    parser = argparse.ArgumentParser(description="Print tables of what becomes of scans.")
    parser.add_argument("--seeds", type=names_of, default=["1", "2", "3"], help="seeds [1,2,3]")
    parser.add_argument("--only", type=names_of, default=[], help="parts of names [all]")
    parser.add_argument("section", nargs="*", help="clouds, scans")
    options = parser.parse_args()
    seeds = [int(seed) for seed in options.seeds]
    sections: Mapping[str, Callable[[Sequence[str], Sequence[int]], None]] = {
        "clouds": partial(
            section, "Clouds that are hard in one way each", KNOWN_CLOUDS, ("cables", "ground")
        ),
        "scans": partial(
            section, "Simulated scans", SIMULATED_SCANS, ("near", "far", "edges", "smooth")
        ),
    }
    unknown = set(options.section) - set(sections)
    if unknown:
        parser.error(f"no section {', '.join(sorted(unknown))}; there are {', '.join(sections)}")
    print(machine_line())
    for name in options.section or sections:
        sections[name](options.only, seeds)


if __name__ == "__main__":
    main()
