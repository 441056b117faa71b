from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cli.clouds import save_ply, save_text, vertices
from cli.commands import pcsmooth


@pytest.mark.parametrize("suffix", [".xy", ".xyz", ".ply"])
@pytest.mark.parametrize(
    ("count", "message"),
    [
        (0, "it holds no points; give a file with points"),
        (1, "there is only one point, which has no spacing; give the radius as a length"),
        (3, "all points are at one place, which has no spacing; give the radius as a length"),
    ],
)
def test_a_cloud_without_extent_is_told_so(
    tmp_path: Path, suffix: str, count: int, message: str
) -> None:
    points = np.full((count, 2 if suffix == ".xy" else 3), 0.25)
    source = tmp_path / f"few{suffix}"
    if suffix == ".ply":
        save_ply(source, vertices(points, "f8"))
    else:
        save_text(source, points)
    commands = [["denoise"], ["denoise", "--scheme", "euler"], ["denoise", "--scheme", "implicit"]]
    if suffix == ".ply":
        commands += [["denoise", "--tile", "1"], ["denoise", "--tile", "9", "--scheme", "euler"]]
    for command in [*commands, ["curvature"]]:
        finished = pcsmooth(*command, source, "-o", tmp_path / f"out{suffix}", "-q")
        assert (finished.status, finished.stderr) == (1, f"Error: {source}: {message}\n")
    assert pcsmooth("info", source).status == (0 if count else 1)
