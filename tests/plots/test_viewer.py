"""The program of the interactive page, run by node without a browser."""

from __future__ import annotations

import json
import shutil
import subprocess
from importlib.resources import files
from typing import Any

import numpy as np
import pytest

from pcsmooth.plots.interactive import SCRIPTS, interactive_page
from pcsmooth.plots.valued_clouds import by_distance
from plots.opened_page import moved, opened, ranks
from plots.pages import read_page

pytestmark = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")


def node(program: str, *options: str) -> str:
    return subprocess.run(
        ["node", *options, "-"],
        input=program,
        capture_output=True,
        check=True,
        timeout=60,
        text=True,
    ).stdout


def test_the_program_is_valid() -> None:
    node(read_page(interactive_page(moved(2), "t")).scripts[-1], "--check")


#: Stands for a page in which the program looks for its data.
DOCUMENT = """
const document = {
  getElementById: (id) => ({ textContent: texts[id], remove() { delete texts[id]; } }),
};
"""


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("is_paired", [True, False])
def test_the_program_unpacks_what_is_packed(dimension: int, is_paired: bool) -> None:
    shown = moved(dimension)
    if not is_paired:
        before, after = (cloud.points for cloud in shown.clouds)
        shown = by_distance(before, after[:90])
    html = interactive_page(shown, "t")
    page = opened(html)
    texts = {f"block-{number}": text for number, text in enumerate(page.texts)}
    texts["scene"] = json.dumps(page.scene)
    parts = [(files("pcsmooth.plots") / "viewer" / name).read_text() for name in SCRIPTS[:2]]
    last = """
      Scene.read().then(async (scene) => {
        const found = [];
        for (const k of [0, 1]) {
          const { set, share } = scene.layer(k);
          const bits = (await scene.valuesOf(scene.columns[0], set))[share];
          found.push(Array.from({ length: set.count }, (_, i) =>
            [...scene.coordinates(set.ends[share].slice(3 * i, 3 * i + 3)), halfValue(bits[i])]));
        }
        console.log(JSON.stringify(found));
      });
    """
    told = node("\n".join([f"const texts = {json.dumps(texts)};", DOCUMENT, *parts, last]))
    for rows, cloud in zip(json.loads(told), shown.clouds, strict=True):
        found = np.array(rows)
        order = ranks(found[:, :dimension], cloud.points)
        assert not np.array_equal(order, np.arange(len(order)))  # in an order of its own
        step = 0.02 * page.scene["spacing"] * page.scene["scale"]
        assert np.abs(found[:, :dimension] - cloud.points[order]).max() <= 0.6 * step
        high = shown.limits[1]
        expected = cloud.values[order] / (0.5 * high) - 1.0
        np.testing.assert_allclose(found[:, dimension], expected, atol=0.002)


def result(names: str, program: str) -> Any:
    """What an expression is, after some parts of the program."""
    parts = [
        (files("pcsmooth.plots") / "viewer" / f"{name}.js").read_text() for name in names.split()
    ]
    last = f"Promise.resolve({program}).then((found) => console.log(JSON.stringify(found)));"
    return json.loads(node("\n".join([*parts, last])))


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("position", [0.1, 0.5, 0.8])
def test_a_slice_is_where_it_says(axis: int, position: float) -> None:
    places = np.random.default_rng(axis).uniform(-1.0, 1.0, (400, 3))
    place, width, inside = result(
        "vectors camera slab measure",
        f"""(() => {{
          const scene = {{ origin: [100, -2000, 30], scale: 4, spacing: 0.05 }};
          const slab = new Slab(scene, [[-1, -1, -1], [1, 1, 1]]);
          slab.choose("{"xyz"[axis]}");
          Object.assign(slab, {{ position: {position}, thickness: 0.5 }});
          const inside = {json.dumps(places.tolist())}.map((p) => isInside(slab.shape, p));
          return [...slab.words, inside];
        }})()""",
    )
    coordinates = ([100, -2000, 30] + 4 * places)[:, axis]
    assert float(place) == pytest.approx([100, -2000, 30][axis] + 8 * position - 4, abs=0.01)
    apart = np.abs(coordinates - float(place))
    np.testing.assert_array_equal(inside, apart <= 0.5 * float(width))
    assert 0 < sum(inside) < 400


@pytest.mark.parametrize(
    ("low", "high", "least"),
    [(0.0, 1.0, 0.09), (637_000.2, 637_010.9, 1.3), (-3e-9, 2e-9, 1e-9), (-1e17, 3e17, 3e16)],
)
def test_ticks_are_round_and_no_two_are_alike(low: float, high: float, least: float) -> None:
    found = result("vectors labels", f"ticks({low}, {high}, {least})")
    values = np.array([tick["value"] for tick in found])
    texts = [tick["text"] for tick in found]
    assert len(set(texts)) == len(texts) >= 3
    np.testing.assert_allclose([float(text.replace("−", "-")) for text in texts], values, rtol=1e-9)
    steps = np.diff(values)
    np.testing.assert_allclose(steps, steps[0], rtol=1e-6)
    assert least <= steps[0] * (1 + 1e-9) < 2.6 * least
    assert values[0] >= low - 1e-6 * least
    assert values[-1] <= high + 1e-6 * least


def test_no_label_touches_another_or_leaves_the_panel() -> None:
    wanted = np.random.default_rng(0).uniform([0, 0], [300, 200], (300, 2)).tolist()
    boxes = result(
        "vectors labels",
        f"""(() => {{
          const measureText = (text) => ({{ width: 7 * text.length }});
          const context = {{ measureText, fillRect() {{}}, fillText() {{}} }};
          const labels = new Labels(context, "#000", "#fff");
          const panel = {{ x: 0, y: 0, width: 300, height: 200 }};
          for (const [x, y] of {json.dumps(wanted)}) labels.place("123.45", x, y, panel);
          return labels.taken;
        }})()""",
    )
    found = np.array(boxes)
    assert len(found) > 20
    assert found.min() >= 0
    assert (found[:, 2] <= 300).all()
    assert (found[:, 3] <= 200).all()
    low, high = found[:, :2], found[:, 2:]
    touching = (low[:, None] < high) & (low < high[:, None])
    np.testing.assert_array_equal(touching.all(axis=2), np.eye(len(found), dtype=bool))


@pytest.mark.parametrize(
    "start", [[[1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 0, 1], [1, 0, 0], [0, 1, 0]]]
)
def test_turning_keeps_axes_at_right_angles_and_zooming_what_is_below_the_pointer(
    start: list[list[int]],
) -> None:
    axes, before, after = result(
        "vectors camera",
        f"""(() => {{
          const panel = {{ x: 10, y: 20, width: 400, height: 300 }};
          const camera = new Camera({start}, [[-1, -1, -1], [1, 1, 1]]);
          camera.fit(panel);
          for (let i = 0; i < 500; i++) camera.turn(17, -9, panel);
          const place = [0.3, -0.2, 0.7];
          const before = camera.seen(place, panel);
          camera.zoom(3, before[0], before[1], panel);
          return [camera.axes, before, camera.seen(place, panel)];
        }})()""",
    )
    turned = np.array(axes)
    np.testing.assert_allclose(turned @ turned.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(turned) == pytest.approx(1.0)
    np.testing.assert_allclose(after[:2], before[:2], atol=1e-9)


def test_the_last_column_that_was_chosen_is_shown_though_another_takes_longer() -> None:
    shown = result(
        "viewer",
        """(async () => {
          const shown = [];
          const late = (column) => new Promise((done) => setTimeout(done, column.wait, column.name));
          const columns = [{ values: [0], wait: 50, name: "slow" }, { values: [1], wait: 1, name: "quick" }];
          const viewer = Object.assign(Object.create(Viewer.prototype), {
            scene: { columns, sets: ["points"], valuesOf: late },
            frames: { redraw() {}, renderer: { setValues: (set, values) => shown.push(values) } },
          });
          await Promise.all([viewer.color(0), viewer.color(1)]);
          const last = viewer.columnNumber;
          await viewer.color(0);
          return [shown, last, viewer.columnNumber];
        })()""",  # noqa: E501
    )
    assert shown == [["quick", "slow"], 1, 0]
