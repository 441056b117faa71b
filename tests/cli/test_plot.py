"""`pcsmooth plot`: what it draws, says and refuses."""

from __future__ import annotations

import json
import os
import re
import struct
import sys
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from matplotlib.figure import Figure

import pcsmooth.plots.cloud_figure
import pcsmooth.plots.interactive
from cli.clouds import circle, load_ply, positions, save_ply, save_text, sphere, vertices
from cli.commands import pcsmooth as command
from cli.commands import succeeds
from cli.test_errors import check_line, fail_in_flow, snapshot
from pcsmooth import PointCloud, estimate_curvature, write_cloud
from pcsmooth.plots.figures import png_of
from pcsmooth.plots.valued_clouds import ValuedClouds
from pcsmooth.plots.views import View
from pcsmooth.printable import printable
from plots.pages import read_page, unrendered

Points = npt.NDArray[np.float64]

#: Clouds, options, and the figure.
Drawn = tuple[ValuedClouds, dict[str, Any], Figure]

#: Points coloured by how far they moved, in pictures as in pages.
MOVED = ("--color-by", "displacement")

GOOD = ["plot", "before.ply", "after.ply", "-o", "out.png", *MOVED]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An own folder with clouds before and after."""
    monkeypatch.chdir(tmp_path)
    save_ply(Path("before.ply"), vertices(sphere(), "f8"))
    save_ply(Path("after.ply"), vertices(sphere(noise=0.0), "f8"))
    save_text(Path("before.xy"), circle())
    save_text(Path("after.xy"), circle(noise=0.0))
    return tmp_path


@pytest.mark.parametrize("output", ["out.png", "out.html"])
@pytest.mark.parametrize(
    ("before", "after"),
    [("\x1b[31mred\a.ply", "点群 ☃.ply"), ("two\nlines.ply", "$x$<b>.ply")],
)
def test_names_of_any_kind(output: str, before: str, after: str, drawn: list[Drawn]) -> None:
    os.rename("before.ply", before)
    os.rename("after.ply", after)
    told = succeeds("plot", before, after, "-o", output, *MOVED)  # no warning, for none is allowed
    assert all(line.isprintable() for line in told.stderr.splitlines())
    if output == "out.html":
        page = Path(output).read_text(encoding="utf-8")
        assert "\x1b" not in page
        assert "\a" not in page
        names = [escape(printable(name)) for name in (before, after)]
        assert f"<h1>{names[0]} and {names[1]} by displacement</h1>" in page
    else:
        ((_, _, figure),) = drawn
        for axes, part, name in zip(
            figure.axes, ("before", "after"), (before, after), strict=False
        ):
            title = axes.get_title()
            assert title.startswith(f"{part}: {printable(name)}\n")
            assert title.count("\n") == 1
        assert png_of(figure)  # of which no warning is allowed either


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Drawn]]:
    """What is handed to the drawing, its options and the figure, which goes no further."""
    seen: list[Drawn] = []

    def figure(shown: ValuedClouds, **options: Any) -> Any:
        made = draw(shown, **options)
        seen.append((shown, options, made))
        return made

    draw = pcsmooth.plots.cloud_figure.cloud_figure
    monkeypatch.setattr(pcsmooth.plots.cloud_figure, "cloud_figure", figure)
    with unrendered():
        yield seen


@pytest.fixture
def _unrendered() -> Iterator[None]:
    with unrendered():
        yield


def numbers(values: Points, symbol: str = "") -> str:
    """The line that says the numbers of values, computed another way."""
    sizes = sorted(abs(float(value)) for value in values)
    middle = 0.5 * (sizes[(len(sizes) - 1) // 2] + sizes[len(sizes) // 2])
    root = (sum(size**2 for size in sizes) / len(sizes)) ** 0.5
    return (
        f"mean{symbol} {sum(sizes) / len(sizes):.4g}, median {middle:.4g}, "
        f"RMS {root:.4g}, max {sizes[-1]:.4g}\n"
    )


def nearest(points: Points, others: Points) -> Points:
    return np.asarray(np.linalg.norm(points[:, None] - others, axis=2).min(axis=1))


CLOUDS = pytest.mark.parametrize(
    ("before", "after", "suffix"),
    [(circle(), circle(noise=0.0), "xy"), (sphere(), sphere(noise=0.0), "ply")],
    ids=["2D", "3D"],
)


@CLOUDS
class TestValues:
    def test_displacement(
        self, before: Points, after: Points, suffix: str, drawn: list[Drawn]
    ) -> None:
        finished = succeeds("plot", f"before.{suffix}", f"after.{suffix}", "-o", "out.png", *MOVED)
        ((shown, _, _),) = drawn
        moves = np.linalg.norm(after - before, axis=1)
        for cloud, points in zip(shown.clouds, (before, after), strict=True):
            np.testing.assert_array_equal(cloud.points, points)
            np.testing.assert_allclose(cloud.values, moves)
        assert [cloud.title for cloud in shown.clouds] == [
            f"before: before.{suffix}", f"after: after.{suffix}"
        ]  # fmt: skip
        assert finished.stdout == b""
        # Of text files the columns of the coordinates are told before.
        assert finished.stderr[
            finished.stderr.index(f"before.{suffix}: {len(before)}") :
        ].startswith(
            f"before.{suffix}: {len(before)} points\nafter.{suffix}: {len(after)} points\n"
            "  colours: displacement, coordinate units\n"
            "  displacement: " + numbers(moves)
        )
        assert re.search(r"\n  wrote out\.png in \d+\.\d\d s\n$", finished.stderr)

    def test_distance_to_each_other(
        self, before: Points, after: Points, suffix: str, drawn: list[Drawn]
    ) -> None:
        paths = [f"before.{suffix}", f"after.{suffix}"]
        save_text(Path("part.xyz"), after[:40])
        paths[1] = "part.xyz"
        finished = succeeds("plot", *paths, "-o", "out.png", "--color-by", "distance")
        ((shown, _, _),) = drawn
        for name, points, others in (
            ("before", before, after[:40]),
            ("after", after[:40], before),
        ):
            expected = nearest(points, others)
            np.testing.assert_allclose(shown.distributions[name], expected)
            assert f"  {name}: " + numbers(expected) in finished.stderr

    def test_distance_to_a_reference(
        self, before: Points, after: Points, suffix: str, drawn: list[Drawn]
    ) -> None:
        reference = 1.1 * after[::2]
        save_text(Path("clean.xyz"), reference)
        succeeds(
            "plot", f"before.{suffix}", f"after.{suffix}", "-o", "out.png",
            "--color-by", "distance", "--reference", "clean.xyz",
        )  # fmt: skip
        ((shown, _, _),) = drawn
        for cloud, points in zip(shown.clouds, (before, after), strict=True):
            np.testing.assert_allclose(cloud.values, nearest(points, reference))

    def test_curvature_is_estimated(
        self, before: Points, after: Points, suffix: str, drawn: list[Drawn]
    ) -> None:
        finished = succeeds(
            "plot", f"before.{suffix}", f"after.{suffix}", "-o", "out.png",
            "--color-by", "curvature",
        )  # fmt: skip
        ((shown, _, _),) = drawn
        symbol = {2: " |k|", 3: " |H|"}[before.shape[1]]
        for name, points in (("before", before), ("after", after)):
            expected = estimate_curvature(points).mean_curvature
            np.testing.assert_array_equal(shown.distributions[name], expected)
            assert f"curvature {name}: estimated\n" in finished.stderr
            assert f"  {name}: " + numbers(expected, symbol) in finished.stderr
        known = np.concatenate(list(shown.distributions.values()))
        assert shown.limits == pytest.approx(tuple(np.percentile(known, [2.0, 98.0])))

    @pytest.mark.parametrize("output", ["out.ply", "out.csv"])
    def test_curvature_of_the_file(
        self, before: Points, after: Points, suffix: str, drawn: list[Drawn], output: str
    ) -> None:
        source = f"before.{suffix}"
        convention = (
            "half" if (suffix, output) in {("xy", "out.ply"), ("ply", "out.csv")} else "sum"
        )
        succeeds("curvature", source, "-o", output, "--mean-convention", convention)
        dim = ["--dim", before.shape[1]]
        finished = succeeds("plot", source, output, "-o", "p.png", "--color-by", "curvature", *dim)
        ((shown, _, _),) = drawn
        estimated = estimate_curvature(before).mean_curvature
        np.testing.assert_allclose(shown.clouds[1].values, estimated, rtol=1e-5, atol=1e-6)
        column = {"out.ply": "scalar_mean_curvature", "out.csv": "mean_curvature"}[output]
        assert f"curvature after: column {column} of {output}\n" in finished.stderr


class TestRows:
    def test_those_that_are_not_finite_are_left_out_and_counted(self, drawn: list[Drawn]) -> None:
        points = sphere()
        points[[3, 40]] = np.nan
        save_ply(Path("before.ply"), vertices(points, "f8"))
        finished = succeeds(*GOOD)
        ((shown, _, _),) = drawn
        assert [len(cloud.points) for cloud in shown.clouds] == [148, 148]
        for name in ("before.ply", "after.ply"):
            assert f"{name}: 148 points; 2 not finite, left out\n" in finished.stderr

    def test_points_without_normal_have_no_curvature(self, drawn: list[Drawn]) -> None:
        save_ply(Path("after.ply"), vertices(np.vstack([sphere(), [[50.0, 0.0, 0.0]]]), "f8"))
        finished = succeeds(*GOOD, "--color-by", "curvature")
        ((shown, _, _),) = drawn
        assert np.flatnonzero(np.isnan(shown.clouds[1].values)).tolist() == [150]
        assert "after.ply: 151 points; 1 of unknown value, grey\n" in finished.stderr

    @pytest.mark.usefixtures("_unrendered")
    def test_only_some_of_many_are_drawn(self, monkeypatch: pytest.MonkeyPatch) -> None:
        for module, name, out in (
            (pcsmooth.plots.cloud_figure, "MOST_DRAWN", "out.png"),
            (pcsmooth.plots.interactive, "MOST_TURNED", "out.html"),
        ):
            monkeypatch.setattr(module, name, 70)
            finished = succeeds("plot", "before.ply", "after.ply", "-o", out, *MOVED)
            assert "before.ply: 150 points; 70 of them drawn\n" in finished.stderr
            moves = np.linalg.norm(positions(Path("after.ply")) - sphere(), axis=1)
            assert numbers(moves) in finished.stderr

    @pytest.mark.usefixtures("_unrendered")
    def test_only_some_of_a_curve_are_drawn(self, monkeypatch: pytest.MonkeyPatch) -> None:
        for name in ("cloud", "curve"):
            monkeypatch.setattr(f"pcsmooth.plots.{name}_figure.MOST_DRAWN", 50)
        told = succeeds("plot", "before.xy", "after.xy", "-o", "out.png").stderr
        assert "before.xy: 60 points; 50 of them drawn\n" in told

    def test_dim_2(self, drawn: list[Drawn]) -> None:
        succeeds(*GOOD, "--dim", "2")
        ((shown, _, _),) = drawn
        np.testing.assert_array_equal(shown.clouds[0].points, sphere()[:, :2])

    def test_stdin(self, drawn: list[Drawn]) -> None:
        data = Path("before.ply").read_bytes()
        finished = succeeds("plot", "-", "after.ply", "-o", "out.png", *MOVED, stdin=data)
        assert finished.stderr.startswith("<stdin>: 150 points\n")
        np.testing.assert_array_equal(drawn[0][0].clouds[0].points, sphere())


class TestView:
    def test_as_told(self, drawn: list[Drawn]) -> None:
        succeeds(*GOOD, "--view", "-90, 12.5")
        assert drawn[0][1]["view"] == View(-90.0, 12.5)

    def test_a_common_one_without_normals(self, drawn: list[Drawn]) -> None:
        succeeds(*GOOD)
        assert drawn[0][1]["view"] == View()

    def test_from_the_side_of_the_normals_that_a_file_has(self, drawn: list[Drawn]) -> None:
        zeros = np.zeros(150, "f4")
        normals = {"nx": zeros, "ny": zeros, "nz": zeros - 1}
        save_ply(Path("before.ply"), vertices(sphere(), "f8", **normals))
        succeeds(*GOOD)
        assert drawn[0][1]["view"] == View(-90.0, -90.0)

    @pytest.mark.parametrize(
        "value", ["91,0", "-90.5,3", "30", "1,2,3", "up", "nan,0", "0,inf", ""]
    )
    def test_what_is_none(self, folder: Path, value: str) -> None:
        before = snapshot(folder)
        check_line(command(*GOOD, "--view", value), 2, "'--view'.*elevation.*such as 30,-60")
        assert snapshot(folder) == before

    def test_a_plane_has_none(self, folder: Path) -> None:
        before = snapshot(folder)
        finished = command("plot", "before.xy", "after.xy", "-o", "o.png", "--view", "0,0")
        check_line(finished, 1, "^Error: before.xy: is a plane curve")
        assert snapshot(folder) == before


class TestFiles:
    @pytest.mark.slow
    def test_a_picture(self) -> None:
        succeeds(*GOOD)
        data = Path("out.png").read_bytes()
        assert data.startswith(b"\x89PNG\r\n\x1a\n")
        width, height = struct.unpack(">II", data[16:24])
        assert width == 1320
        assert 400 < height < 1200

    def test_a_page(self) -> None:
        succeeds("plot", "before.ply", "after.ply", "-o", "out.HTML", "--color-by", "curvature")
        page = read_page(Path("out.HTML").read_text())
        assert page.headings == ["before.ply and after.ply by curvature"]
        assert page.links == []
        for name, path in (("before", "before.ply"), ("after", "after.ply")):
            mean = estimate_curvature(positions(Path(path))).mean_curvature
            count, *found = page.facts[name]
            assert count == "150"
            assert float(found[1]) == pytest.approx(np.median(np.abs(mean)), rel=1e-5)

    def test_a_page_has_the_columns_of_the_files(self) -> None:
        succeeds("denoise", "before.ply", "-o", "smooth.ply")
        succeeds("plot", "before.ply", "smooth.ply", "-o", "page.html", "--color-by", "distance")
        (scene,) = re.findall('id="scene">(.*)</script>', Path("page.html").read_text())
        labels = [column["label"] for column in json.loads(scene)["columns"]]
        assert labels[:3] == [
            "distance to the other cloud, coordinate units",
            "displacement, coordinate units",
            "displacement along the normal, coordinate units",
        ]
        assert {"quality", "scalar_k1"} <= set(labels)
        assert not {"nx", "scalar_mean_curvature"} & set(labels)  # drawn, and said by quality

    @pytest.mark.parametrize("color_by", ["displacement", "curvature", "distance"])
    def test_same_bytes(self, color_by: str) -> None:
        """Of pictures see `test_cloud_figure`."""
        for name in ("a", "b"):
            succeeds(*GOOD[:3], "-o", f"{name}.html", "--color-by", color_by)
        assert Path("a.html").read_bytes() == Path("b.html").read_bytes()

    def test_the_colormap(self, drawn: list[Drawn]) -> None:
        succeeds(*GOOD, "--colormap", "turbo")
        assert drawn[0][1]["colormap"] == "turbo"

    @pytest.mark.usefixtures("_unrendered")
    def test_quiet(self) -> None:
        assert succeeds(*GOOD, "-q").stderr == ""
        assert succeeds(*GOOD, "-q", "--overwrite", "--color-by", "curvature").stderr == ""

    def test_what_denoise_wrote(self, drawn: list[Drawn]) -> None:
        succeeds("denoise", "before.ply", "-o", "smooth.ply")
        told = succeeds("plot", "before.ply", "smooth.ply", "-o", "out.png", *MOVED).stderr
        after = load_ply(Path("smooth.ply"))["vertex"]
        normals = np.stack([after[name] for name in ("nx", "ny", "nz")], axis=1)
        ways = positions(Path("smooth.ply")) - positions(Path("before.ply"))
        shown = drawn[0][0]
        assert shown.label == "displacement along the normal, coordinate units"
        np.testing.assert_allclose(
            shown.distributions["displacement along the normal"],
            (ways * normals).sum(axis=1),
            atol=1e-6,
        )
        assert "moved: " + numbers(np.linalg.norm(ways, axis=1)) in told
        assert "  displacement along the normal: mean |d| " in told


#: Arguments, what the line says; status 2.
USAGE: dict[str, tuple[list[str], str]] = {
    "stdout": ([*GOOD[:3], "-o", "-"], "-o needs the name of a file"),
    "no output": (GOOD[:3], "-o"),
    "one cloud": (["plot", "before.ply", "-o", "out.png"], "AFTER"),
    "two streams": (["plot", "-", "-", "-o", "out.png"], "only one cloud can come from stdin"),
    "reference of displacement": (
        [*GOOD, "--reference", "after.ply"],
        "--reference needs --color-by distance",
    ),
    "color by": ([*GOOD, "--color-by", "height"], "'--color-by'.*'height'.*displacement"),
    "colormap": ([*GOOD, "--colormap", "rainboww"], "no color map 'rainboww'"),
    "dim": ([*GOOD, "--dim", "4"], "'--dim'.*'4'"),
    "over before": (["plot", "c.html", "after.ply", "-o", "c.html", "--overwrite"], "already read"),
    "over the reference": (
        [*GOOD[:3], "-o", "c.html", "--color-by", "distance", "--reference", "c.html"],
        "already read",
    ),
}

#: Arguments, the file that the line names, what it says; status 1.
REFUSALS: dict[str, tuple[list[str], str, str]] = {
    "exists": ([*GOOD[:3], "-o", "old.png"], "old.png", "exists.*--overwrite"),
    "is a folder": ([*GOOD[:3], "-o", "folder.png"], "folder.png", "is a folder"),
    "no folder": ([*GOOD[:3], "-o", "none/out.png"], "none/out.png", "there is no folder"),
    "suffix": ([*GOOD[:3], "-o", "out.pdf"], "out.pdf", r"suffix '\.pdf'.*use \.png or \.html"),
    "no suffix": ([*GOOD[:3], "-o", "out"], "out", r"suffix ''.*use \.png or \.html"),
    "missing": (["plot", "none.ply", "after.ply", "-o", "o.png"], "none.ply", "no such file"),
    "no points": (["plot", "before.ply", "empty.xyz", "-o", "o.png"], "empty.xyz", "no points"),
    "dimensions": (
        ["plot", "before.xy", "after.ply", "-o", "o.png"],
        "after.ply",
        "points of 3 coordinates, before.xy of 2; pass --dim 2",
    ),
    "rows": (
        ["plot", "before.ply", "part.xyz", "-o", "o.png"],
        "part.xyz",
        "9 points cannot be the 150 points before, moved; choose --color-by distance",
    ),
    "nothing finite": (
        ["plot", "nan.xyz", "nan.xyz", "-o", "o.png"],
        "nan.xyz",
        "no point with finite coordinates",
    ),
    "nothing finite in both": (
        ["plot", "left.xyz", "right.xyz", "-o", "o.png"],
        "right.xyz",
        "no point with finite coordinates is left",
    ),
    "reference": (
        [*GOOD, "--color-by", "distance", "--reference", "nan.xyz"],
        "nan.xyz",
        "no point with finite coordinates",
    ),
    "curvature of a place": (
        ["plot", "before.ply", "place.xyz", "-o", "o.png", "--color-by", "curvature"],
        "place.xyz",
        "all points are at one place",
    ),
}


@pytest.fixture
def odd_files() -> None:
    Path("old.png").write_bytes(b"precious")
    Path("folder.png").mkdir()
    Path("empty.xyz").write_bytes(b"")
    save_text(Path("part.xyz"), sphere()[:9])
    save_text(Path("place.xyz"), np.ones((4, 3)))
    Path("nan.xyz").write_text("nan 0 0\n0 nan 0\n")
    Path("left.xyz").write_text("nan 0 0\n0 1 0\n")
    Path("right.xyz").write_text("0 0 1\n0 nan 0\n")
    save_text(Path("c.html"), sphere())


@pytest.mark.usefixtures("odd_files", "_unrendered")
class TestErrors:
    @pytest.mark.parametrize(("arguments", "cause"), USAGE.values(), ids=USAGE)
    def test_usage(self, folder: Path, arguments: list[str], cause: str) -> None:
        before = snapshot(folder)
        check_line(command(*arguments), 2, cause)
        assert snapshot(folder) == before

    @pytest.mark.parametrize(("arguments", "name", "cause"), REFUSALS.values(), ids=REFUSALS)
    def test_refusals(self, folder: Path, arguments: list[str], name: str, cause: str) -> None:
        before = snapshot(folder)
        finished = command(*arguments, "-q")
        check_line(finished, 1, cause)
        assert finished.stderr.startswith(f"Error: {name}: ")
        assert snapshot(folder) == before

    @pytest.mark.parametrize(
        ("library", "suffix"),
        [("matplotlib.figure", "png"), ("matplotlib.figure", "html")],
    )
    def test_missing_libraries_are_named_before_the_work(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch, library: str, suffix: str
    ) -> None:
        before = snapshot(folder)
        monkeypatch.setitem(sys.modules, library, None)
        finished = command("plot", "none.ply", "after.ply", "-o", f"out.{suffix}")
        name = library.partition(".")[0]
        check_line(finished, 1, rf"need {name}, .*; pip install 'pcsmooth\[plot\]'")
        assert snapshot(folder) == before

    @pytest.mark.parametrize("error", [KeyboardInterrupt(), OSError(28, "No space left on device")])
    def test_a_write_that_is_cut_off_leaves_nothing(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException
    ) -> None:
        before = snapshot(folder)
        monkeypatch.setattr(os, "replace", fail_in_flow(error))
        finished = command(*GOOD[:3], "-o", "old.png", "--overwrite", "-q")
        assert finished.status == (130 if isinstance(error, KeyboardInterrupt) else 1)
        assert "Traceback" not in finished.stderr
        assert snapshot(folder) == before


def test_surfaces_are_shaded_where_that_can_be(drawn: list[Drawn]) -> None:
    told = succeeds("plot", "before.ply", "after.ply", "-o", "shaded.png").stderr
    assert drawn == []
    assert "no normals nx ny nz: both are lit by planes through 8 points" in told
    assert "displacement: mean" in told
    assert "colours" not in told
    succeeds("denoise", "before.ply", "-o", "smooth.ply")
    told = succeeds("plot", "before.ply", "smooth.ply", "-o", "lit.png", "--view", "90,-90").stderr
    assert "lit by planes" not in told
    succeeds("plot", "before.ply", "after.ply", "-o", "page.html")
    succeeds("plot", "before.xy", "after.xy", "-o", "curve.png")
    assert drawn == []


@pytest.mark.parametrize(
    ("arguments", "status", "cause"),
    [
        (["before.ply", "after.ply", "-o", "a.png", "--colormap", "turbo"], 2, "no --colormap"),
        (["before.xy", "short.xy", "-o", "a.png"], 1, "cannot be the 60 points before"),
    ],
)
def test_what_cannot_be_shaded(arguments: list[str], status: int, cause: str) -> None:
    save_text(Path("short.xy"), circle()[:50])
    finished = command("plot", *arguments, "--color-by", "shaded")
    assert finished.status == status
    assert cause in finished.stderr


@pytest.mark.parametrize("color_by", ["shaded", "displacement", "distance"])
def test_what_a_file_calls_noise_is_left_out(color_by: str) -> None:
    marks = np.zeros(150, np.uint8)
    marks[:4] = 7
    for name, noise in (("before", 0.05), ("after", 0.0)):
        cloud = PointCloud(sphere(noise=noise), {"classification": marks})
        write_cloud(cloud, Path(f"{name}.las"))
    told = succeeds(
        "plot", "before.las", "after.las", "-o", "out.png", "--color-by", color_by
    ).stderr  # fmt: skip
    assert told.count("146 points; 4 not finite, left out") == 2
