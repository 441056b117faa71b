"""What Python callers give and get."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import pcsmooth
from pcsmooth import InvalidInputError, PcsmoothError, PointCloud

RNG = np.random.default_rng(7)
SHEET = np.c_[RNG.uniform(0, 1, (800, 2)), RNG.normal(0, 0.01, 800)]
INTENSITY = np.arange(800, dtype=np.uint16)


class Vector3dVector:
    """As Open3D has them: a sequence that becomes an array."""

    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        return np.array(SHEET, dtype)


class Tensor:
    def numpy(self) -> Any:
        return SHEET.copy()


CLOUDS = {
    "PointCloud": PointCloud(SHEET),
    "Open3D": SimpleNamespace(points=Vector3dVector()),
    "tensors of Open3D": SimpleNamespace(point={"positions": Tensor()}),
    "PyVista": SimpleNamespace(points=SHEET.view(type("pyvista_ndarray", (np.ndarray,), {}))),
    "trimesh": SimpleNamespace(vertices=SHEET.tolist()),
    "list": SHEET.tolist(),
}


@pytest.fixture(scope="module")
def result() -> pcsmooth.DenoiseResult:
    cloud = PointCloud(SHEET, {"intensity": INTENSITY}, np.dtype(np.float32), ("by hand",))
    return pcsmooth.denoise(cloud)


@pytest.mark.parametrize("name", CLOUDS)
def test_clouds_of_other_libraries(name: str, result: pcsmooth.DenoiseResult) -> None:
    np.testing.assert_array_equal(pcsmooth.denoise(CLOUDS[name]).points, result.points)


@pytest.mark.parametrize(("library", "make"), [
    ("open3d", lambda module: module.geometry.PointCloud(module.utility.Vector3dVector(SHEET))),
    ("pyvista", lambda module: module.PolyData(SHEET)),
    ("trimesh", lambda module: module.PointCloud(SHEET)),
])  # fmt: skip
def test_the_libraries_themselves(library: str, make: Any) -> None:
    cloud = make(pytest.importorskip(library))
    found = pcsmooth.measure_noise(cloud).noise
    assert found == pytest.approx(pcsmooth.measure_noise(SHEET).noise, rel=1e-5)


@pytest.mark.parametrize("name", ["scan.ply", Path("scan.ply")])
@pytest.mark.parametrize("act", [pcsmooth.denoise, pcsmooth.estimate_curvature])
def test_a_path_is_no_cloud(name: str | os.PathLike[str], act: Any) -> None:
    with pytest.raises(InvalidInputError, match=r"a name; give read_cloud\(.*denoise_file"):
        act(name)


def test_points_that_a_file_calls_noise_and_fixed_ones() -> None:
    noise, fixed = INTENSITY == 3, INTENSITY == 5
    cloud = PointCloud(SHEET, noise_marks=noise, fixed_marks=fixed)
    result = pcsmooth.denoise(cloud)
    np.testing.assert_array_equal(result.points[3], SHEET[3])
    np.testing.assert_array_equal(result.points[5], SHEET[5])
    assert not result.finite[3]
    assert result.facts()["took no part"] == "1"
    without = pcsmooth.denoise(SHEET[~noise], fixed=fixed[~noise])
    np.testing.assert_array_equal(result.points[~noise], without.points)


def test_saved_as_the_command_does(tmp_path: Path, result: pcsmooth.DenoiseResult) -> None:
    source = tmp_path / "scan.ply"
    pcsmooth.write_cloud(result.source, source)
    writing = pcsmooth.Writing(extra_columns=("sigma", "spacing"))
    again = pcsmooth.denoise(pcsmooth.read_cloud(source))
    for name in ("a.ply", "a.csv", "a.laz"):
        pcsmooth.denoise_file(source, tmp_path / f"file_{name}", writing=writing)
        again.save(tmp_path / name, writing)
        assert (tmp_path / name).read_bytes() == (tmp_path / f"file_{name}").read_bytes()
    pcsmooth.estimate_curvature(pcsmooth.read_cloud(source)).save(tmp_path / "curved.ply")
    curved = pcsmooth.read_cloud(tmp_path / "curved.ply")
    np.testing.assert_array_equal(curved.columns["intensity"], INTENSITY)
    np.testing.assert_array_equal(curved.points, pcsmooth.read_cloud(source).points)
    with pytest.raises(pcsmooth.CloudFileError, match="exists already"):
        again.save(tmp_path / "a.ply", overwrite=False)


def test_to_cloud(result: pcsmooth.DenoiseResult) -> None:
    cloud = result.to_cloud()
    assert list(cloud.columns)[:4] == ["intensity", "nx", "ny", "nz"]
    np.testing.assert_array_equal(cloud.points, result.points)
    assert "sigma" not in " ".join(cloud.columns)
    assert cloud.comments[0] == "by hand"
    estimate = pcsmooth.estimate_curvature(SHEET)
    np.testing.assert_array_equal(
        estimate.to_cloud().columns["nx"], estimate.normals[:, 0].astype(np.float32)
    )
    with pytest.raises(InvalidInputError, match="leave it out"):
        estimate.to_cloud(pcsmooth.Writing(extra_columns=("sigma",)))
    with pytest.raises(pcsmooth.CloudFileError, match="plane curve has no k1"):
        pcsmooth.denoise(SHEET[:, :2]).to_cloud(pcsmooth.Writing(colormap="viridis", color_by="k1"))


def test_shown_in_a_line_and_a_table(result: pcsmooth.DenoiseResult) -> None:
    noise = pcsmooth.measure_noise(SHEET)
    for shown in (result, pcsmooth.estimate_curvature(SHEET), noise):
        line = repr(shown)
        assert line.startswith(f"<{type(shown).__name__} points: 800")
        assert len(line) < 250
        html = shown._repr_html_()
        assert html.count("<tr>") == len(shown.facts())
    assert repr(result.source) == "<PointCloud of 800 points in 3D, columns intensity>"
    assert repr(PointCloud(SHEET)) == "<PointCloud of 800 points in 3D>"
    assert "|mean curvature|" in pcsmooth.estimate_curvature(SHEET)._repr_html_()


def test_plots(result: pcsmooth.DenoiseResult, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib")
    for found in (result, pcsmooth.estimate_curvature(SHEET), pcsmooth.denoise(SHEET[:, ::2])):
        assert len(found.plot().axes) >= 1
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(PcsmoothError, match="matplotlib"):
        result.plot()


def test_measured_noise_is_that_of_the_filter(result: pcsmooth.DenoiseResult) -> None:
    assert result.plan is not None
    assert result.sigma is not None
    found = pcsmooth.measure_noise(SHEET)
    assert found.noise == result.plan.noise.deviation == pytest.approx(0.01, rel=0.1)
    np.testing.assert_allclose(found.sigma, result.sigma, rtol=1e-12)
    assert found.spacing == result.plan.spacing
    assert found.has_surface
    few = pcsmooth.measure_noise(np.vstack([SHEET[:2], [[np.nan, 0, 0]]]))
    assert (few.noise, few.has_surface) == (0.0, False)
    assert few.facts()["surface"] == "none shows at any scale"
    # Where the noise differs from place to place, it is known of each point.
    uneven = np.c_[RNG.uniform(0, 1, (20000, 2)), RNG.normal(0, 1, 20000)]
    uneven[:, 2] *= np.where(uneven[:, 0] < 0.5, 0.003, 0.01)
    sigma = pcsmooth.measure_noise(uneven).sigma
    filtered = pcsmooth.denoise(uneven).sigma
    assert filtered is not None
    np.testing.assert_allclose(sigma, filtered, rtol=1e-12)
    assert np.median(sigma[uneven[:, 0] > 0.6]) > 2 * np.median(sigma[uneven[:, 0] < 0.4])


def test_progress_bar(capfd: pytest.CaptureFixture[str]) -> None:
    told: list[Any] = []
    quiet = pcsmooth.denoise(SHEET)
    assert capfd.readouterr().err == ""
    shown = pcsmooth.denoise(SHEET, progress=True, callback=told.append)
    assert "stage" in capfd.readouterr().err
    assert told
    np.testing.assert_array_equal(shown.points, quiet.points)
    pcsmooth.estimate_curvature(SHEET, progress=True)
    assert "stage" in capfd.readouterr().err


def test_figures_show_themselves_in_notebooks() -> None:
    figure: Any = pcsmooth.denoise(SHEET).plot()
    assert figure._repr_png_().startswith(b"\x89PNG")
