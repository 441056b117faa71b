"""`--where` and `--box` on the command line."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cli.commands import pcsmooth, succeeds


def test_no_expression_is_an_error_of_usage() -> None:
    run = pcsmooth("denoise", "none.xyz", "-o", "out.xyz", "--where", "f(x)")
    assert run.status == 2
    assert "Invalid value for '--where': 'f(x)' in 'f(x)' is neither a column" in run.stderr


def test_points_that_are_not_selected_stay(tmp_path: Path) -> None:
    source, target = tmp_path / "in.csv", tmp_path / "out.csv"
    points = np.random.default_rng(1).normal(0, 1, (60, 2)) * [10, 0.05]
    np.savetxt(source, points, "%.6f", ",", header="x,y", comments="")
    run = succeeds("denoise", source, "-o", target, "--where", "x > 0")
    assert f"{(points[:, 0] <= 0).sum()} fixed" in run.stderr
    before, after = (np.loadtxt(p, delimiter=",", skiprows=1)[:, :2] for p in (source, target))
    assert np.array_equal(before[before[:, 0] <= 0], after[before[:, 0] <= 0])


def test_the_noise_that_is_left_is_that_of_points_that_may_move(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    source = tmp_path / "in.csv"
    points = np.c_[rng.uniform(0, 10, (2000, 2)), rng.normal(0, 0.1, 2000)]
    np.savetxt(source, points, "%.6f", ",", header="x,y,z", comments="")
    whole, part, none = (
        succeeds("denoise", source, "-o", tmp_path / f"{name}.csv", "--json", *options).json
        for name, options in (
            ("whole", ()), ("part", ("--box=0,0,2,2",)), ("none", ("--where", "z > 9")),
        )
    )  # fmt: skip
    assert part["fixed"] > 1800
    # Less is left where all move, as those that stay keep their noise beside the others.
    assert whole["noise_after"] < part["noise_after"] < 0.5 * whole["noise"]
    assert none["noise_after"] is None
