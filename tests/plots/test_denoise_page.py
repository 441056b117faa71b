from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import pcsmooth
from cli.clouds import circle, sphere
from pcsmooth.denoised_rows import DenoisedRows
from pcsmooth.denoising import Denoised, denoise_parts
from pcsmooth.files.denoise_file import Sample
from pcsmooth.files.output_columns import Convention
from pcsmooth.files.report import DenoiseReport, PointFacts, ShapeFacts
from pcsmooth.methods.keywords import resolve_keywords
from pcsmooth.parts.whole_cloud import WholeCloud
from pcsmooth.plots import denoise_page as module
from pcsmooth.plots.cloud_figure import cloud_figure
from pcsmooth.plots.denoise_page import denoise_page
from pcsmooth.plots.valued_clouds import ValuedClouds
from pcsmooth.positions import usable_rows
from plots.pages import BLANK, Page, read_page, unrendered

pytestmark = pytest.mark.slow

Points = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Run:
    """A denoised cloud, and what the command would tell of it."""

    points: Points
    denoised: Denoised
    result: DenoisedRows
    report: DenoiseReport

    def html(self, **changes: Any) -> str:
        result = self.result
        sample = Sample(self.points, result.points, result.normals, result.mean_curvature)
        return denoise_page(sample, self.denoised, replace(self.report, **changes))

    def page(self, **changes: Any) -> Page:
        """The page without the pictures, which take long."""
        with unrendered():
            return read_page(self.html(**changes))


def run(points: Points, convention: Convention = "half", **options: Any) -> Run:
    keywords: Any = options
    method, motion, estimate = resolve_keywords(None, "free", None, keywords)
    finite = usable_rows(points)
    cloud = WholeCloud.of(points, finite)
    denoised = denoise_parts(cloud, method, motion, estimate)
    result = denoised.result(points, finite, cloud.input_rows, denoised.read(0, cloud.count))
    n, dimension = points.shape
    facts = PointFacts(n, dimension, [*"xyz"[:dimension]], n - cloud.count, 0)
    report = DenoiseReport.of(
        denoised, denoised.facts(), convention, input="scans/a <b>.ply", output="out.ply",
        points=facts, tiles=None, shape=None, seconds=0.0,
    )  # fmt: skip
    return Run(points, denoised, result, report)


CLOUDS = {"2D": circle(), "3D": sphere()}


@cache
def filter_run(name: str) -> Run:
    return run(CLOUDS[name])


@cache
def filtered(name: str) -> tuple[Points, DenoisedRows, Page]:
    """A cloud, what came of it, and the page on that."""
    found = filter_run(name)
    return found.points, found.result, found.page()


@pytest.mark.parametrize("name", CLOUDS)
class TestFilter:
    def test_choices(self, name: str) -> None:
        points, result, page = filtered(name)
        assert result.plan is not None
        assert result.outliers is not None
        facts = page.facts
        assert facts["input"] == ["scans/a <b>.ply"]
        assert facts["output"] == ["out.ply"]
        assert facts["points"] == [f"{len(points)} in {points.shape[1]}D"]
        assert facts["scheme"] == ["filter"]
        assert facts["noise"][0].startswith(f"{result.plan.noise.deviation:.4g}, ")
        assert facts["neighbourhoods"] == [f"{result.plan.support:.0f} points"]
        said = f"{result.outliers.sum()} outliers left where they are (column outlier)"
        assert facts["outliers"] == [said]
        assert "radius" not in facts  # of flows
        assert facts["normals from"] == [f"{result.curvature.normal_support:.0f} points"]
        assert facts["version"] == [f"pcsmooth {pcsmooth.__version__}"]
        assert (
            not {"energy", "weight", "gradient", "step", "iterations", "union", "order"}
            & facts.keys()
        )

    def test_displacement_in_units_and_spacings(self, name: str) -> None:
        points, result, page = filtered(name)
        moves = np.linalg.norm(result.points - points, axis=1)
        numbers = {
            "mean": moves.mean(),
            "median": np.median(moves),
            "RMS": np.sqrt((moves**2).mean()),
            "max": moves.max(),
        }
        for key, number in numbers.items():
            assert page.facts[key] == [f"{number:.6g}", f"{number / result.spacing:.4g}"]

    def test_start_and_end_without_a_curve(self, name: str) -> None:
        points, result, page = filtered(name)
        first, last = result.history
        measures = {2: ("area", "perimeter"), 3: ("volume", "area")}[points.shape[1]]
        for measure, start, end in zip(
            measures, (first.volume, first.area), (last.volume, last.area), strict=True
        ):
            before, after, change = page.facts[measure]
            assert (float(before), float(after)) == pytest.approx((start, end))
            assert float(change.removesuffix("%")) == pytest.approx(
                100 * (end / start - 1), abs=1e-3
            )
        assert "follows the gradient of neither" in page.text
        assert len(page.pictures) == 3
        assert not any("every state" in text for text in page.described)

    def test_it_needs_no_other_file(self, name: str) -> None:
        _, _, page = filtered(name)
        assert page.links == page.scripts == []
        assert page.headings[0] == "a <b>.ply, denoised"
        assert all(page.described)

    def test_pictures_show_displacement_and_curvature(
        self, name: str, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        seen: list[tuple[ValuedClouds, float | None]] = []

        def drawn(shown: ValuedClouds, **options: Any) -> Any:
            seen.append((shown, options.get("spacing")))
            return cloud_figure(shown, **options)

        monkeypatch.setattr(module, "cloud_figure", drawn)
        found = filter_run(name)
        points, result = found.points, found.result
        found.page()
        (moved, spacing), (curved, _) = seen
        assert spacing == result.spacing
        np.testing.assert_array_equal(moved.clouds[0].points, points)
        np.testing.assert_array_equal(moved.clouds[1].points, result.points)
        along = ((result.points - points) * result.curvature.normals).sum(axis=1)
        np.testing.assert_allclose(moved.clouds[0].values, along)
        assert moved.is_signed
        np.testing.assert_array_equal(curved.clouds[0].points, result.points)
        np.testing.assert_array_equal(curved.clouds[0].values, result.mean_curvature)


def test_same_bytes_whatever_time_it_took() -> None:
    """Of a page that has every kind of picture."""
    found = run(circle(), energy="area", iterations=1)
    first, second = (found.html(seconds=seconds) for seconds in (1.0, 2.0))
    assert first == second
    pictures = read_page(first).pictures
    assert len(pictures) == 4
    assert all(picture.startswith(BLANK) and len(picture) > 10_000 for picture in pictures)


class TestFlows:
    @pytest.mark.parametrize("energy", ["volume", "area"])
    def test_euler(self, energy: str) -> None:
        page = run(sphere(), energy=energy, iterations=3).page()
        assert page.facts["energy"] == [energy]
        assert page.facts["iterations"] == ["3"]
        assert page.facts["weight"] == ["cell"]
        assert page.facts["gradient"] == ["analytic"]
        assert float(page.facts["step"][0]) > 0.0
        assert f"goes down the gradient of the {energy}." in page.text
        assert len(page.pictures) == 4
        assert page.described[2] == "Volume and area of every state of the flow"

    def test_the_perimeter_of_curves(self) -> None:
        page = run(circle(), energy="area", iterations=1).page()
        assert "gradient of the perimeter." in page.text

    def test_without_steps_there_is_no_curve(self) -> None:
        assert len(run(sphere(), iterations=0).page().pictures) == 3

    def test_implicit(self) -> None:
        found = run(sphere(), scheme="implicit")
        facts = found.page().facts
        assert facts["order"] == ["2"]
        assert facts["solver iterations"] == [str(sum(found.result.solver_iterations))]

    def test_restraints_and_polyhedra(self) -> None:
        facts = run(sphere(), iterations=1).page(
            shape=ShapeFacts("cube", "exact"), max_move=0.25, motion="normal", keep_volume=True,
            stopped_early=True, stop=0.5, fixed=4,
        ).facts  # fmt: skip
        assert facts["polyhedron"] == ["cube"]
        assert facts["union"] == ["exact"]
        assert facts["motion"] == ["along the normals, volume kept, at most 0.25 in all"]
        assert facts["iterations"] == [
            "1, stopped: the last step moved the points by less than 0.5 spacings"
        ]
        assert facts["points"] == ["150 in 3D, 4 fixed"]


def test_rows_that_are_not_finite_are_left_out_of_the_numbers() -> None:
    points = sphere()
    points[[4, 9]] = np.nan
    found = run(points)
    page = found.page()
    assert page.facts["points"] == ["150 in 3D, 2 not finite (passed through)"]
    moves = np.delete(found.result.displacement, [4, 9])
    assert page.facts["mean"][0] == f"{moves.mean():.6g}"


def test_the_convention_of_the_file_is_told() -> None:
    page = run(CLOUDS["3D"], "sum").page()
    assert "the file has k1+k2" in page.text
    assert "the file has" not in filtered("3D")[2].text
