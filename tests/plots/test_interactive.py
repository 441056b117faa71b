"""The page: its structure, its numbers unpacked again, what it may do and load."""

from __future__ import annotations

import re
from base64 import b64encode
from dataclasses import replace
from hashlib import sha256
from html import unescape
from importlib.resources import files

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
import pytest

from pcsmooth.plots import interactive as module
from pcsmooth.plots.histogram import histograms
from pcsmooth.plots.interactive import SCRIPTS, interactive_page
from pcsmooth.plots.rough_normals import rough_normals
from pcsmooth.plots.valued_clouds import (
    along_normals,
    by_curvature,
    by_displacement,
    by_distance,
)
from pcsmooth.plots.views import View
from plots.blocks import unpacked_normals
from plots.opened_page import moved, opened, ranks
from plots.pages import read_page

Points = npt.NDArray[np.float64]

DIMENSIONS = pytest.mark.parametrize("dimension", [2, 3])


@DIMENSIONS
class TestNumbers:
    def test_surfaces_may_be_seen_without_colors_at_first(self, dimension: int) -> None:
        shown = moved(dimension)
        first = [
            opened(interactive_page(shown, "t", starts_shaded=shaded)).scene["column"]
            for shaded in (False, True)
        ]
        assert first == [0, -1 if dimension == 3 else 0]

    @pytest.mark.parametrize("far", [0.0, 5_000_000.0, -5_000_000.0])
    def test_points_and_values_within_the_steps(self, dimension: int, far: float) -> None:
        shown = moved(dimension, far=far)
        page = opened(interactive_page(shown, "t"))
        (rows, others) = (
            ranks(places, cloud.points)
            for places, cloud in zip(page.places(), shown.clouds, strict=True)
        )
        np.testing.assert_array_equal(rows, others)  # a point has the same place in both
        for places, cloud in zip(page.places(), shown.clouds, strict=True):
            step = 0.02 * page.scene["spacing"] * page.scene["scale"]
            assert np.abs(places - cloud.points[rows]).max() <= 0.51 * step
        (values, again) = page.values()
        np.testing.assert_array_equal(values, again)
        np.testing.assert_allclose(values, shown.clouds[0].values[rows], rtol=2e-3, atol=1e-3)
        assert len(set(page.scene["columns"][0]["values"])) == 1  # written once
        frame = np.array(page.scene["frame"])[:, :dimension]
        looked_at = page.scene["origin"] + page.scene["scale"] * frame
        np.testing.assert_allclose(looked_at, shown.box, atol=1e-9 * (1.0 + abs(far)))

    @pytest.mark.parametrize("scale", [1e-90, 1e90])
    def test_extents_that_single_precision_does_not_hold(
        self, dimension: int, scale: float
    ) -> None:
        shown = moved(dimension)
        clouds = [replace(cloud, points=cloud.points * scale) for cloud in shown.clouds]
        page = opened(interactive_page(replace(shown, clouds=tuple(clouds)), "t"))
        for places, cloud in zip(page.places(), clouds, strict=True):
            ranks(places / scale, cloud.points / scale)

    def test_a_stray_point_costs_no_precision(self, dimension: int) -> None:
        shown = moved(dimension, n=2000)
        clouds = []
        for cloud in shown.clouds:
            points = cloud.points.copy()
            points[0] = 10_000.0
            clouds.append(replace(cloud, points=points))
        page = opened(interactive_page(replace(shown, clouds=tuple(clouds)), "t"))
        assert page.scene["blocks"][page.scene["clouds"][0]["positions"]]["bits"] == 24
        (places, _) = page.places()
        rows = ranks(places, clouds[0].points)
        assert np.abs(places - clouds[0].points[rows]).max() < 0.001
        low, high = np.array(page.scene["frame"])[:, :dimension] * page.scene["scale"]
        assert (high - low).max() < 50.0  # what is looked at is not made small, either

    def test_clouds_of_other_points(self, dimension: int) -> None:
        before, after = (cloud.points for cloud in moved(dimension).clouds)
        shown = by_distance(before, after[:90])
        page = opened(interactive_page(shown, "t"))
        assert not page.scene["is_paired"]
        values = page.values()
        for places, found, cloud in zip(page.places(), values, shown.clouds, strict=True):
            rows = ranks(places, cloud.points)
            np.testing.assert_allclose(found, cloud.values[rows], rtol=2e-3, atol=1e-3)

    def test_points_of_unknown_value(self, dimension: int) -> None:
        points = moved(dimension).clouds[0].points
        values = np.linspace(-1.0, 1.0, 200)
        values[:9] = np.nan
        clouds = {"before": (points, values), "after": (points, values)}
        page = opened(interactive_page(by_curvature(clouds), "t"))
        (places, _), (found, _) = page.places(), page.values()
        rows = ranks(places, points)
        np.testing.assert_array_equal(np.isnan(found), np.isnan(values[rows]))
        assert page.scene["columns"][0]["is_signed"]
        notes = [column["notes"][0] for column in page.scene["columns"]]
        assert notes[0] == "200 points; 9 of unknown value, grey"
        assert notes[1:] == ["200 points"] * dimension  # all have coordinates

    def test_only_some_of_many_are_drawn_and_all_are_counted(
        self, dimension: int, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(module, "MOST_TURNED", 50)
        shown = moved(dimension)
        page = opened(interactive_page(shown, "t"))
        for places, cloud in zip(page.places(), shown.clouds, strict=True):
            ranks(places, cloud.points[::4])
        assert page.scene["columns"][0]["notes"][0] == "200 points; 50 of them drawn"
        assert sum(page.scene["columns"][0]["counts"]["displacement"]) == 200

    def test_one_place(self, dimension: int) -> None:
        points = np.full((4, dimension), 7.0)
        page = opened(interactive_page(by_displacement(points, points), "t"))
        for places in page.places():
            np.testing.assert_allclose(places, points, atol=1e-4)

    def test_one_point_and_one_cloud(self, dimension: int) -> None:
        shown = by_curvature({"it": (np.ones((1, dimension)), np.zeros(1))}, ["it"])
        page = opened(interactive_page(shown, "t"))
        np.testing.assert_allclose(page.places()[0], np.ones((1, dimension)), atol=1e-4)
        assert not page.scene["is_paired"]

    def test_histograms_and_scales(self, dimension: int) -> None:
        shown = moved(dimension)
        columns = opened(interactive_page(shown, "t")).scene["columns"]
        counts, _ = histograms(shown.distributions, shown.limits)
        assert columns[0]["counts"] == {"displacement": counts["displacement"].tolist()}
        assert columns[0]["limits"] == list(shown.limits)
        assert [column["label"] for column in columns] == [
            "displacement, coordinate units",
            *(f"{name}, coordinate units" for name in "xyz"[:dimension]),
        ]
        together = np.concatenate([cloud.points[:, 0] for cloud in shown.clouds])
        np.testing.assert_allclose(columns[1]["limits"], np.percentile(together, [2, 98]))
        assert not columns[1]["is_signed"]

    @pytest.mark.parametrize("colormap", [None, "turbo"])
    def test_colors(self, dimension: int, colormap: str | None) -> None:
        maps = opened(interactive_page(moved(dimension), "t", colormap=colormap)).scene["maps"]
        for shades, name in zip(maps, ("viridis", "coolwarm"), strict=True):
            expected = mpl.colormaps[colormap or name](np.linspace(0, 1, 256), bytes=True)
            np.testing.assert_array_equal(shades, expected[:, :3])


class TestSurfaces:
    def test_normals_that_are_given_and_rough_ones(self) -> None:
        shown = moved(3)
        normals = np.random.default_rng(5).normal(size=(200, 3))
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        normals[3] = 0.0
        page = opened(interactive_page(shown, "t", normals=[None, normals]))
        rows = ranks(page.places()[0], shown.clouds[0].points)
        rough = rough_normals(shown.clouds[0].points)
        for cloud, expected in zip(page.scene["clouds"], (rough, normals), strict=True):
            numbers = page.numbers(cloud["normals"])
            known = (numbers != 255).all(axis=1)
            np.testing.assert_array_equal(known, expected[rows].any(axis=1))
            found = unpacked_normals(numbers[known])
            cosines = np.abs(np.einsum("ij,ij->i", found, expected[rows][known]))
            assert cosines.min() > 0.999

    def test_normals_follow_rows_that_are_left_out(self) -> None:
        before, after = (cloud.points.copy() for cloud in moved(3).clouds)
        before[:50] = np.nan
        shown = by_displacement(before, after)
        normals = np.tile([1.0, 0.0, 0.0], (200, 1))
        normals[50:] = [0.0, 0.0, 1.0]
        page = opened(interactive_page(shown, "t", normals=[None, normals]))
        found = unpacked_normals(page.numbers(page.scene["clouds"][1]["normals"]))
        np.testing.assert_allclose(found, np.tile([0.0, 0.0, 1.0], (150, 1)), atol=0.01)

    def test_other_values_can_be_chosen(self) -> None:
        shown = moved(3)
        normals = np.tile([0.0, 0.0, 2.0], (200, 1))
        page = opened(interactive_page(shown, "t", others=[along_normals(shown, normals)]))
        label = page.scene["columns"][1]["label"]
        assert label == "displacement along the normal, coordinate units"
        rows = ranks(page.places()[0], shown.clouds[0].points)
        steps = (shown.clouds[1].points - shown.clouds[0].points)[rows, 2]
        np.testing.assert_allclose(page.values(1)[0], steps, atol=1e-3)

    def test_the_view(self) -> None:
        view = View(20.0, 70.0)
        scene = opened(interactive_page(moved(3), "t", view=view)).scene
        np.testing.assert_allclose(scene["view"], view.axes)
        flat = opened(interactive_page(moved(2), "t")).scene
        np.testing.assert_allclose(flat["view"], np.eye(3), atol=1e-12)
        assert flat["clouds"][0]["normals"] is None


WILD = "</script><script>alert('<b>$1\\g<0> {{script}}')</script><!--"


@DIMENSIONS
class TestPage:
    def test_it_needs_no_other_file(self, dimension: int) -> None:
        html = interactive_page(moved(dimension), "A <b> & B")
        page = read_page(html)
        assert page.links == []
        assert page.headings == ["A <b> & B"]
        program = page.scripts[-1]
        for word in (
            "http:", "https:", "//cdn", "fetch(", "XMLHttpRequest", "WebSocket", "EventSource",
            "import(", "sendBeacon", "Worker", "eval(", "innerHTML", "document.write",
        ):  # fmt: skip
            assert word not in program, word
        assert not re.search(r'\s(src|href|on\w+|style)="', html.partition('id="scene"')[0])

    def test_the_policy_allows_this_program_and_style_only(self, dimension: int) -> None:
        html = interactive_page(moved(dimension), "t")
        (policy,) = re.findall(r'http-equiv="Content-Security-Policy" content="([^"]*)"', html)
        allowed = dict(rule.split(" ", 1) for rule in unescape(policy).split("; "))
        assert allowed["default-src"] == allowed["base-uri"] == allowed["form-action"] == "'none'"
        assert set(allowed) - {"script-src", "style-src"} == {
            "default-src", "base-uri", "form-action"
        }  # fmt: skip
        for kind, tag in (("script-src", "script"), ("style-src", "style")):
            (text,) = re.findall(rf"<{tag}>(.*?)</{tag}>", html, re.DOTALL)
            found = b64encode(sha256(text.encode()).digest()).decode()
            assert allowed[kind] == f"'sha256-{found}'"

    def test_the_table_has_the_numbers(self, dimension: int) -> None:
        shown = moved(dimension)
        moves = np.linalg.norm(shown.clouds[1].points - shown.clouds[0].points, axis=1)
        facts = read_page(interactive_page(shown, "t")).facts
        assert facts[""] == ["points", "mean", "median", "RMS", "max"]
        numbers = [moves.mean(), np.median(moves), np.sqrt((moves**2).mean()), moves.max()]
        assert facts["displacement"] == ["200", *(f"{number:.6g}" for number in numbers)]

    def test_titles_and_columns_are_text(self, dimension: int) -> None:
        points = moved(dimension).clouds[0].points
        shown = replace(by_displacement(points, points, [WILD, WILD]), label=WILD)
        html = interactive_page(shown, WILD)
        page = read_page(html)
        assert page.headings == [WILD]
        assert not any(script.startswith("alert") for script in page.scripts)
        assert page.scripts[-1] == read_page(interactive_page(moved(dimension), "t")).scripts[-1]
        scene = opened(html).scene
        assert [cloud["title"] for cloud in scene["clouds"]] == [WILD, WILD]
        assert scene["columns"][0]["label"] == WILD

    def test_same_bytes(self, dimension: int) -> None:
        assert interactive_page(moved(dimension), "t") == interactive_page(moved(dimension), "t")

    def test_every_control_has_a_name(self, dimension: int) -> None:
        html = interactive_page(moved(dimension), "t")
        for control in re.findall(r"<(?:input|select)[^>]*>", html):
            before = html.partition(control)[0]
            assert before.rpartition("<label")[2].count("</label>") == 0, control
            label = before.rpartition("<label")[2]
            assert re.search(r"<span[^>]*>\w", label), control
        for words in re.findall(r"<button[^>]*>(.*?)</button>", html):
            assert words.strip()


def test_the_program_finds_what_it_looks_for() -> None:
    html = interactive_page(moved(3), "t")
    program = read_page(html).scripts[-1]
    wanted = set(re.findall(r'(?:byId|onClick|onInput)\("([\w-]+)"', program))
    assert len(wanted) > 15
    assert wanted <= set(re.findall(r'\bid="([\w-]+)"', html))


def test_all_parts_are_joined() -> None:
    parts = [part.name for part in (files("pcsmooth.plots") / "viewer").iterdir()]
    assert sorted(part for part in parts if part.endswith(".js")) == sorted(SCRIPTS)


@pytest.mark.parametrize("n", [20_000])
def test_a_point_takes_few_bytes(n: int) -> None:
    rng = np.random.default_rng(0)
    before = rng.normal(size=(n, 3))
    before /= np.linalg.norm(before, axis=1, keepdims=True)
    after = before * (1.0 + rng.normal(scale=0.003, size=(n, 1)))
    empty = len(interactive_page(by_displacement(before[:1], after[:1]), "t"))
    whole = len(interactive_page(by_displacement(before, after), "t", normals=[None, before]))
    assert (whole - empty) / n < 20.0
