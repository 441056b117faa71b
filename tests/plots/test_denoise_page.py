from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import pcsmooth
from cli.clouds import circle, sphere
from pcsmooth import DenoiseResult
from pcsmooth.plots import denoise_page as module
from pcsmooth.plots.cloud_figure import cloud_figure
from pcsmooth.plots.denoise_page import denoise_page
from pcsmooth.plots.valued_clouds import ValuedClouds
from plots.pages import BLANK, Page, read_page, unrendered

pytestmark = pytest.mark.slow

Points = npt.NDArray[np.float64]


def summary_of(result: DenoiseResult, **changes: Any) -> dict[str, Any]:
    """A summary as the command makes it."""
    plan = result.plan
    return {
        "input": "scans/a <b>.ply",
        "output": "out.ply",
        "points": len(result.points),
        "dimension": result.points.shape[1],
        "not_finite": int((~result.finite).sum()),
        "noise_class": 0,
        "fixed": 0,
        "spacing": result.spacing,
        "radius": result.radius,
        "scheme": result.method.name,
        "energy": result.method.shapes.quantity,
        "weight": result.method.shapes.weight,
        "gradient": None if result.method.name == "filter" else "analytic",
        "step": result.step,
        "iterations": len(result.history) - 1,
        "noise": None if plan is None else plan.noise.deviation,
        "noise_ratio": None if plan is None else plan.noise.deviation / plan.spacing,
        "surface": None if plan is None else plan.has_surface,
        "filter_support": None if plan is None else plan.support,
        "outliers": None if result.outliers is None else int(result.outliers.sum()),
        "order": result.method.order,
        "motion": "free",
        "max_move": result.max_move,
        "keep_volume": False,
        "stop": None,
        "stopped_early": result.stopped_early,
        "solver_iterations": list(result.solver_iterations),
        "normal_support": result.curvature.normal_support,
        "curvature_support": result.curvature.curvature_support,
        "mean_convention": "half" if result.points.shape[1] == 3 else None,
        **changes,
    }


def page_of(points: Points, result: DenoiseResult, changes: dict[str, Any] | None = None) -> Page:
    """The page without the pictures, which take long."""
    with unrendered():
        return read_page(denoise_page(points, result, summary_of(result, **(changes or {}))))


def flow_page(points: Points, changes: dict[str, Any] | None = None, **options: Any) -> Page:
    return page_of(points, pcsmooth.denoise(points, **options), changes)


CLOUDS = {"2D": circle(), "3D": sphere()}


@cache
def filtered(name: str) -> tuple[Points, DenoiseResult, Page]:
    """A cloud, what came of it, and the page on that."""
    points = CLOUDS[name]
    result = pcsmooth.denoise(points)
    return points, result, page_of(points, result)


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
        assert facts["outliers"] == [f"{result.outliers.sum()}, left where they are"]
        assert facts["radius"] == [f"{result.radius:.6g}, 2 spacings"]
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
        assert len(page.pictures) == 2
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
        points, result, _ = filtered(name)
        page_of(points, result)
        (moved, spacing), (curved, _) = seen
        assert spacing == result.spacing
        np.testing.assert_array_equal(moved.clouds[0].points, points)
        np.testing.assert_array_equal(moved.clouds[1].points, result.points)
        np.testing.assert_allclose(moved.clouds[0].values, result.displacement)
        np.testing.assert_array_equal(curved.clouds[0].points, result.points)
        np.testing.assert_array_equal(curved.clouds[0].values, result.mean_curvature)


def test_same_bytes_whatever_time_it_took() -> None:
    """Of a page that has every kind of picture."""
    result = pcsmooth.denoise(circle(), energy="area", iterations=1)
    first, second = (
        denoise_page(circle(), result, summary_of(result, seconds=seconds)) for seconds in (1, 2)
    )
    assert first == second
    pictures = read_page(first).pictures
    assert len(pictures) == 3
    assert all(picture.startswith(BLANK) and len(picture) > 10_000 for picture in pictures)


class TestFlows:
    @pytest.mark.parametrize("energy", ["volume", "area"])
    def test_euler(self, energy: str) -> None:
        page = flow_page(sphere(), energy=energy, iterations=3)
        assert page.facts["energy"] == [energy]
        assert page.facts["iterations"] == ["3"]
        assert page.facts["weight"] == ["cell"]
        assert page.facts["gradient"] == ["analytic"]
        assert float(page.facts["step"][0]) > 0.0
        assert f"goes down the gradient of the {energy}." in page.text
        assert len(page.pictures) == 3
        assert page.described[1] == "Volume and area of every state of the flow"

    def test_the_perimeter_of_curves(self) -> None:
        assert "gradient of the perimeter." in flow_page(circle(), energy="area", iterations=1).text

    def test_without_steps_there_is_no_curve(self) -> None:
        assert len(flow_page(sphere(), iterations=0).pictures) == 2

    def test_implicit(self) -> None:
        result = pcsmooth.denoise(sphere(), scheme="implicit")
        facts = page_of(sphere(), result).facts
        assert facts["order"] == ["2"]
        assert facts["solver iterations"] == [str(sum(result.solver_iterations))]

    def test_restraints_and_polyhedra(self) -> None:
        changes = {
            "polyhedron": "cube", "union": "exact", "max_move": 0.25, "motion": "normal",
            "keep_volume": True, "stopped_early": True, "stop": 0.5, "fixed": 4,
        }  # fmt: skip
        facts = flow_page(sphere(), changes, iterations=1).facts
        assert facts["polyhedron"] == ["cube"]
        assert facts["union"] == ["exact"]
        assert facts["most that a point may move"] == ["0.25"]
        assert facts["motion"] == ["normal, volume kept"]
        assert facts["iterations"] == ["1, stopped at less than 0.5 spacings"]
        assert facts["points"] == ["150 in 3D, 4 fixed"]


def test_rows_that_are_not_finite_are_left_out_of_the_numbers() -> None:
    points = sphere()
    points[[4, 9]] = np.nan
    result = pcsmooth.denoise(points)
    page = page_of(points, result)
    assert page.facts["points"] == ["150 in 3D, 2 not finite (passed through)"]
    moves = np.delete(result.displacement, [4, 9])
    assert page.facts["mean"][0] == f"{moves.mean():.6g}"


def test_the_convention_of_the_file_is_told() -> None:
    points, result, _ = filtered("3D")
    assert "the file has k1+k2" in page_of(points, result, {"mean_convention": "sum"}).text
