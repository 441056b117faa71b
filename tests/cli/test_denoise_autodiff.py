"""`pcsmooth denoise --gradient autodiff`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cli.clouds import circle, load_ply, positions, save_ply, save_text, sphere, vertices
from cli.commands import pcsmooth, succeeds
from pcsmooth.energies.by_autodiff import LARGEST_CLOUD


@pytest.mark.parametrize("options", [(), ("--polyhedron", "cube"), ("--energy", "area")])
def test_it_gives_the_same_cloud(tmp_path: Path, options: tuple[str, ...]) -> None:
    scan = save_ply(tmp_path / "scan.ply", vertices(sphere(24), "f8"))
    found = {}
    for gradient in ("analytic", "autodiff"):
        out = tmp_path / f"{gradient}.ply"
        told = succeeds(
            "denoise", scan, "-o", out, "--gradient", gradient, "--iterations", "2", "--json",
            *options,
        ).json  # fmt: skip
        assert (told["scheme"], told["gradient"]) == ("euler", gradient)
        comments = " ".join(load_ply(out).comments)
        assert ("gradient=autodiff " in comments) == (gradient == "autodiff")
        found[gradient] = positions(out)
    moved = np.linalg.norm(found["analytic"] - positions(scan), axis=1)
    assert moved.mean() > 0.01
    np.testing.assert_allclose(found["autodiff"], found["analytic"], rtol=0, atol=1e-11)


def test_the_filter_has_no_gradient(tmp_path: Path) -> None:
    scan = save_text(tmp_path / "scan.xy", circle())
    told = succeeds("denoise", scan, "-o", tmp_path / "out.xy", "--json").json
    assert (told["scheme"], told["gradient"]) == ("filter", None)


def test_large_clouds_are_refused(tmp_path: Path) -> None:
    scan = save_ply(tmp_path / "scan.ply", vertices(sphere(LARGEST_CLOUD + 1), "f8"))
    out = tmp_path / "out.ply"
    refused = pcsmooth("denoise", scan, "-o", out, "--gradient", "autodiff")
    assert refused.status == 1
    assert refused.stderr.count("\n") == 1
    assert f"{scan}: there are 1001 distinct points" in refused.stderr
    assert f"are for {LARGEST_CLOUD} at most; take analytic gradients" in refused.stderr
    assert not out.exists()
