"""`pcsmooth denoise --tile`: the same files and words as without, from a cloud cut up on disk."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from cli.clouds import ENCODINGS, circle, load_ply, positions, save_ply, save_text, sphere, vertices
from cli.commands import interrupt, start, succeeds
from cli.commands import pcsmooth as command
from cli.test_batch_formats import ptx_file
from cli.test_denoise_files import rich_ply
from cli.test_errors import BAD_FILES, Content, check_line, snapshot
from pcsmooth import machine
from pcsmooth.cloud import PointCloud
from pcsmooth.files import cloud_input, result_file, tiling
from pcsmooth.files.tiling import Tiling
from pcsmooth.formats import write_cloud
from tiling.clouds import MAP_COORDINATES, curve, ribbon

AXES_OF_E57 = ("cartesianX", "cartesianY", "cartesianZ")
EULER = ["--scheme", "euler", "--iterations", "2", "--threads", "1"]


def few_rows(monkeypatch: pytest.MonkeyPatch, rows: int) -> None:
    for module in (cloud_input, result_file):
        monkeypatch.setattr(module, "ROWS", rows)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An own folder with clouds, of which few rows are read and written at a time."""
    monkeypatch.chdir(tmp_path)
    few_rows(monkeypatch, 77)
    rng = np.random.default_rng(9)
    points = ribbon(500, width=5.0)
    held = (rng.random(500) < 0.2).astype("u1")
    normals = dict(zip(("nx", "ny", "nz"), rng.normal(size=(3, 500)), strict=True))
    save_ply(Path("scan.ply"), vertices(points, "f4"))
    save_ply(Path("survey.ply"), vertices(points + MAP_COORDINATES, "f8", held=held, **normals))
    lost = np.r_[points, points[:9] + np.array([0.0, 0.0, 40.0])]
    save_ply(Path("lost.ply"), vertices(lost, "f8"))
    points[::50] = np.nan
    points[170:180, 1] = np.inf
    save_ply(Path("holes.ply"), vertices(points, "f4"))
    save_ply(Path("curve.ply"), vertices(curve(500), "f8"))
    save_ply(Path("far.ply"), vertices(np.r_[sphere(), [[1e300, 0.0, 0.0]]], "f8"))
    save_text(Path("circle.xy"), circle())
    Path("mesh.obj").write_text("v 1 2 3\nv 2 3 5\nv 3 3 3\n")
    return tmp_path


def facts_of(summary: dict[str, Any]) -> dict[str, Any]:
    """What a summary says of the cloud: but for where it is."""
    return {name: summary[name] for name in summary.keys() - {"output", "seconds", "tiles"}}


def said(stderr: str) -> list[str]:
    """What was said of the cloud."""
    return [
        re.sub(r"wrote \S+ in [\d.]+ s", "wrote", line)
        for line in stderr.splitlines()
        if not line.startswith(("  in ", "compiling"))
    ]


def check_same(cloud: str, *options: str, tile: int = 120, command: str = "denoise") -> None:
    """Check that files, summary and messages are those of the whole cloud."""
    whole = succeeds(command, cloud, "-o", "whole.ply", "--tile", "off", "--json", *options)
    tiled = succeeds(command, cloud, "-o", "tiled.ply", "--tile", str(tile), "--json", *options)
    assert Path("tiled.ply").read_bytes() == Path("whole.ply").read_bytes()
    assert whole.json["tiles"] is None
    tiles = tiled.json["tiles"]
    assert tiles >= 4
    assert tiled.json == {
        **facts_of(whole.json),
        **{name: tiled.json[name] for name in ("output", "seconds", "tiles")},
    }
    assert said(tiled.stderr) == said(whole.stderr)
    assert f"  in {tiles} tiles\n" in tiled.stderr
    assert " tiles\n" not in whole.stderr


@pytest.mark.parametrize("code", ["f4", "f8"])
@pytest.mark.parametrize("encoding", ENCODINGS)
def test_everything_in_a_file_is_kept(encoding: str, code: str) -> None:
    rich_ply(encoding, code).write("rich.ply")
    check_same("rich.ply", *EULER, tile=20)


def texts(points: npt.NDArray[np.float64]) -> str:
    """Rows of which the last say what the columns are."""
    rows = [",".join([*map(repr, row), "7", "1"]) for row in points.tolist()]
    return "\n".join(["x,y,z,a,held", *rows[:-2], rows[-2] + "0", rows[-1][:-3] + "0.5,1", ""])


@pytest.mark.parametrize(
    ("name", "target", "options"),
    [
        ("scan.xyz", "xyz", []),
        ("scan.csv", "ply", ["--fixed", "held"]),
        ("scan.csv", "csv", ["--columns", "y,x,z"]),
        ("scan.csv", "las", ["--colormap", "gray"]),
        ("scan.pcd", "pcd", []),
        ("scan.ptx", "ply", []),
        ("scan.e57", "xyz", []),
    ],
)
def test_other_formats(name: str, target: str, options: list[str]) -> None:
    points = ribbon(500, width=5.0)
    if name == "scan.csv":
        Path(name).write_text(texts(points))
    elif name == "scan.ptx":
        Path(name).write_text(ptx_file(points))
    elif name == "scan.e57":
        pytest.importorskip("pye57")
        from formats.e57_files import Scan, save_e57

        save_e57(Path(name), Scan(dict(zip(AXES_OF_E57, points.T, strict=True))))
    else:
        write_cloud(PointCloud(points), name)
    said_of = []
    for tile in ("off", "120"):
        output = f"out{tile}.{target}"
        finished = succeeds("denoise", name, "-o", output, "--tile", tile, *EULER, *options)
        said_of.append(said(finished.stderr))
    assert Path(f"outoff.{target}").read_bytes() == Path(f"out120.{target}").read_bytes()
    assert said_of[0] == said_of[1]
    whole, tiled = (
        succeeds("info", name, "--json", "--tile", tile).json for tile in ("off", "120")
    )
    assert tiled == whole


#: A file and options.
SAME: dict[str, tuple[str, list[str]]] = {
    "scan": ("scan.ply", ["--scheme", "euler", "--threads", "1"]),
    "filter": ("scan.ply", ["--threads", "1"]),
    "filter with outliers": ("lost.ply", ["--threads", "1", "--noise", "0.3x"]),
    "rows without position": ("holes.ply", EULER),
    "curve": ("curve.ply", EULER),
    "plane of a scan": ("scan.ply", [*EULER, "--dim", "2"]),
    "states are told": ("scan.ply", [*EULER, "-v"]),
    **{
        f"for {dialect}": ("survey.ply", [*EULER, "--dialect", dialect])
        for dialect in ("meshlab", "cloudcompare", "pcl")
    },
    "sum": ("scan.ply", [*EULER, "--mean-convention", "sum"]),
    "sum of a curve": ("curve.ply", [*EULER, "--mean-convention", "sum"]),
    "float": ("survey.ply", [*EULER, "--float"]),
    "double": ("scan.ply", [*EULER, "--double"]),
    "fixed": ("survey.ply", [*EULER, "--fixed", "held"]),
    "normals of the input": ("survey.ply", [*EULER, "--orient", "input"]),
    "normals by default": ("survey.ply", EULER),
    "viewpoint": ("survey.ply", [*EULER, "--orient", "viewpoint=400000,5500000,900"]),
    "support": ("scan.ply", [*EULER, "--support", "20"]),
    "no step": ("scan.ply", [*EULER, "--iterations", "0"]),
    "restrained": (
        "scan.ply", [*EULER, "--motion", "normal", "--max-move", "0.2x", "--stop", "1"],
    ),
    "energy": (
        "holes.ply", [*EULER, "--energy", "area", "--weight", "boundary", "--radius", "1.5x"],
    ),
    "polyhedron": ("scan.ply", [*EULER, "--polyhedron", "cube", "--union", "naive"]),
    "volume kept": ("survey.ply", [*EULER, "--keep-volume", "--fixed", "held"]),
    "volume kept by the filter": ("lost.ply", ["--keep-volume", "--threads", "1"]),
    "colors": ("scan.ply", [*EULER, "--colormap", "coolwarm"]),
    "colors of confidence": (
        "scan.ply", [*EULER, "--colormap", "gray", "--color-by", "confidence"],
    ),
    "colors of a curve": ("curve.ply", [*EULER, "--colormap", "turbo"]),
    "flow without its name": ("scan.ply", ["--energy", "area", "--step", "0.1", "--threads", "1"]),
}  # fmt: skip


@pytest.mark.parametrize(("cloud", "options"), SAME.values(), ids=SAME)
def test_same_as_the_whole(cloud: str, options: list[str]) -> None:
    check_same(cloud, *options)


@pytest.mark.slow
def test_rows_one_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    few_rows(monkeypatch, 1)
    check_same("holes.ply", *EULER)


def test_what_an_earlier_run_left_is_replaced() -> None:
    succeeds("denoise", "survey.ply", "-o", "once.ply", "--colormap", "gray", "-q")
    check_same("once.ply", *EULER, "--dialect", "meshlab")


@pytest.mark.slow
def test_tiles_are_not_very_many_and_very_small() -> None:
    count = len(positions(Path("scan.ply")))
    finished = succeeds("denoise", "scan.ply", "-o", "out.ply", *EULER, "--tile", "1", "--json")
    least = -(-count // 32)
    assert f"--tile 1: tiles of {least} points, lest they are too many\n" in finished.stderr
    assert 16 <= finished.json["tiles"] <= 64
    tiling = Tiling(1)
    assert tiling.points_of_tile(10**9) == 10_000
    assert replace(tiling, size=50_000).points_of_tile(10**9) == 50_000


def test_fixed_points_do_not_move() -> None:
    options = [*EULER, "--tile", "120", "--fixed", "held", "--json"]
    finished = succeeds("denoise", "survey.ply", "-o", "out.ply", *options)
    held = load_ply(Path("survey.ply"))["vertex"]["held"] != 0
    assert finished.json["fixed"] == np.count_nonzero(held) > 0
    moved = (positions(Path("out.ply")) != positions(Path("survey.ply"))).any(axis=1)
    assert not moved[held].any()
    assert moved[~held].mean() > 0.9


def test_energy_log() -> None:
    tables = []
    for tile in ("off", "120"):
        log = f"{tile}.csv"
        succeeds(
            "denoise", "holes.ply", "-o", f"{tile}.ply", "--tile", tile, "--energy-log", log, *EULER
        )
        head, *rows = Path(log).read_text().splitlines()
        assert head == "iteration,volume,area,mean_move,max_move"
        tables.append(np.array([row.split(",") for row in rows], np.float64))
    assert len(tables[0]) == 3
    np.testing.assert_allclose(tables[1], tables[0], rtol=1e-12, atol=0.0)


def test_output_may_be_the_input() -> None:
    succeeds("denoise", "holes.ply", "-o", "out.ply", "--tile", "off", *EULER)
    succeeds("denoise", "holes.ply", "-o", "holes.ply", "--overwrite", "--tile", "120", *EULER)
    assert Path("holes.ply").read_bytes() == Path("out.ply").read_bytes()


def test_many_files(folder: Path) -> None:
    names = ["scan.ply", "holes.ply", "mesh.obj"]
    finished = command("denoise", *names, "--output-dir", "out", "--tile", "120", *EULER)
    assert finished.status == 1
    assert "3 files: 2 done, 0 skipped, 1 failed" in finished.stderr
    assert sorted(os.listdir("out")) == [".pcsmooth-batch.jsonl", "holes.ply", "scan.ply"]
    succeeds("denoise", "scan.ply", "-o", "whole.ply", *EULER)
    assert Path("out/scan.ply").read_bytes() == Path("whole.ply").read_bytes()


#: Arguments after `denoise`, cause.
REFUSALS: dict[str, tuple[list[str], str]] = {
    "stdin": (["-", "-o", "out.ply", *EULER], "<stdin>: a stream cannot be cut.*; name files"),
    "stdout": (["scan.ply", "-o", "-", *EULER], "scan.ply: a stream cannot be cut.*; name files"),
    "mesh to write": (
        ["scan.ply", "-o", "out.obj", *EULER],
        "scan.ply: tiles cannot be put together to obj; write ply, .* or pcd$",
    ),
    "mesh to read": (
        ["mesh.obj", "-o", "out.ply", *EULER],
        "mesh.obj: it is a mesh, which cannot be read piece by piece; convert it to PLY first",
    ),
    "local radius": (
        ["scan.ply", "-o", "out.ply", "--scheme", "implicit", "--radius", "local"],
        "scan.ply: an implicit step with a local radius needs the whole cloud; leave it out, or",
    ),
    "autodiff": (
        ["scan.ply", "-o", "out.ply", *EULER, "--gradient", "autodiff"],
        "scan.ply: automatic differentiation needs the whole cloud; leave it out, or pass --tile",
    ),
    "no tile folder": (
        ["scan.ply", "-o", "out.ply", *EULER, "--tile-folder", "none"],
        "none: no such file or folder; check the path",
    ),
    "tile folder that is a file": (
        ["scan.ply", "-o", "out.ply", *EULER, "--tile-folder", "circle.xy"],
        "circle.xy: a folder stands where a file should, or a file where a folder should; ",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("arguments", "cause"), REFUSALS.values(), ids=REFUSALS)
def test_refusals(folder: Path, arguments: list[str], cause: str) -> None:
    before = snapshot(folder)
    finished = command("denoise", *arguments, "--tile", "120")
    check_line(finished, 1, f"^Error: {cause}")
    assert snapshot(folder) == before


USAGE: dict[str, tuple[list[str], str]] = {
    **{
        f"tile {value!r}": (
            ["--tile", value],
            f"'--tile': '{re.escape(value)}' is neither a number of points, nor auto, nor off",
        )
        for value in ("0", "-1", "1.5", "all", "", "1e6")
    },
    "workers and scheduler": (
        ["--workers", "2", "--scheduler", "tcp://host:8786"],
        "--workers are local, and --scheduler has its own",
    ),
    "workers without tiles": (["--workers", "2", "--tile", "off"], "need tiles, not --tile off"),
    "scheduler without tiles": (
        ["--scheduler", "tcp://host:8786", "--tile", "off"],
        "need tiles, not --tile off",
    ),
    "no workers": (["--workers", "0"], "'--workers'.*0"),
}


@pytest.mark.parametrize(("options", "cause"), USAGE.values(), ids=USAGE)
def test_usage(folder: Path, options: list[str], cause: str) -> None:
    before = snapshot(folder)
    finished = command("denoise", "scan.ply", "-o", "out.ply", *options)
    check_line(finished, 2, cause)
    assert "--help" in finished.stderr
    assert snapshot(folder) == before


#: Arguments after `denoise` that fail in tiles as they do without.
FAILURES: dict[str, list[str]] = {
    "far.ply as float": ["far.ply", "-o", "out.ply", "--float"],
    "no such column": ["survey.ply", "-o", "out.ply", "--fixed", "hold"],
    "nothing but positions": ["scan.ply", "-o", "out.ply", "--fixed", "hold"],
    "no normals": ["scan.ply", "-o", "out.ply", "--orient", "input"],
    "viewpoint of a plane": ["scan.ply", "-o", "out.ply", "--orient", "viewpoint=1,2"],
    "no such body": ["scan.ply", "-o", "out.ply", "--polyhedron", "blob"],
    "body of the plane": ["scan.ply", "-o", "out.ply", "--polyhedron", "square"],
    "3D of two columns": ["curve.ply", "-o", "out.ply", "--dim", "3"],
    "suffix": ["scan.ply", "-o", "out.doc"],
    "no folder": ["scan.ply", "-o", "none/out.ply"],
    "exists": ["scan.ply", "-o", "curve.ply"],
}


def check_fails_alike(folder: Path, *arguments: str) -> None:
    before = snapshot(folder)
    tiled = command("denoise", *arguments, *EULER, "-q", "--tile", "50")
    whole = command("denoise", *arguments, *EULER, "-q", "--tile", "off")
    assert (tiled.status, tiled.stderr) == (1, whole.stderr)
    assert snapshot(folder) == before


@pytest.mark.parametrize("arguments", FAILURES.values(), ids=FAILURES)
def test_failures_are_those_of_the_whole(folder: Path, arguments: list[str]) -> None:
    check_fails_alike(folder, *arguments)


BAD_PLY = {
    **{name: bad[:2] for name, bad in BAD_FILES.items() if bad[0].endswith(".ply")},
    "positions that are not finite": (
        "nan.ply",
        b"ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
        b"property float z\nend_header\nnan 0 0\n0 inf 0\n",
    ),
    "one place": (
        "one.ply",
        b"ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
        b"property float z\nend_header\n1 2 3\n1 2 3\n",
    ),
}


@pytest.mark.parametrize(("name", "content"), BAD_PLY.values(), ids=BAD_PLY)
def test_bad_files(folder: Path, name: str, content: Content) -> None:
    if content is not None:
        Path(name).write_bytes(content)
    elif name == "folder.ply":
        Path(name).mkdir()
    check_fails_alike(folder, name, "-o", "out.ply")


def test_the_page_is_that_of_the_whole() -> None:
    for name, tile in (("whole", "off"), ("tiled", "120")):
        report = ("--report", f"{name}.html", "--tile", tile)
        succeeds("denoise", "holes.ply", "-o", "out.ply", "--overwrite", *EULER, *report)
    assert Path("tiled.html").read_bytes() == Path("whole.html").read_bytes()


#: Options of curvature.
CURVATURE: dict[str, tuple[str, list[str]]] = {
    "scan": ("scan.ply", []),
    "rows without position": ("holes.ply", ["-v"]),
    "curve": ("curve.ply", ["--colormap", "gray"]),
    "gradient": ("scan.ply", ["--estimator", "gradient", "--energy", "area"]),
    "normals of the input": ("survey.ply", ["--orient", "input", "-v"]),
    "support": ("lost.ply", ["--support", "12", "--colormap", "coolwarm", "--color-by", "k2"]),
}


@pytest.mark.parametrize(("cloud", "options"), CURVATURE.values(), ids=CURVATURE)
def test_curvature_is_that_of_the_whole(cloud: str, options: list[str]) -> None:
    check_same(cloud, *options, "--threads", "1", command="curvature")


@pytest.mark.parametrize(
    "cloud", ["scan.ply", "survey.ply", "lost.ply", "holes.ply", "curve.ply", "far.ply"]
)
def test_info_is_that_of_the_whole(cloud: str) -> None:
    whole = succeeds("info", cloud, "--json", "--tile", "off")
    tiled = succeeds("info", cloud, "--json", "--tile", "120")
    assert tiled.json == whole.json
    assert succeeds("info", cloud, "--tile", "120").stdout == succeeds("info", cloud).stdout


class TestAuto:
    @pytest.fixture
    def _small_memory(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(machine, "memory", lambda: 1000)
        monkeypatch.setattr(tiling, "_TILE_POINTS", 120)

    def tiles(self, *arguments: str) -> int | None:
        output = "out.ply" if arguments[0] != "circle.xy" else "out.xy"
        summary = succeeds("denoise", *arguments, "-o", output, "--overwrite", "--json").json
        tiles: int | None = summary["tiles"]
        return tiles

    @pytest.mark.parametrize("option", [[], ["--tile", "auto"], ["--tile", "off"]])
    def test_small_clouds_are_not_cut(self, option: list[str]) -> None:
        assert self.tiles("scan.ply", *EULER, *option) is None

    @pytest.mark.usefixtures("_small_memory")
    def test_clouds_larger_than_memory_are_cut(self) -> None:
        tiles = self.tiles("scan.ply", *EULER)
        assert tiles is not None
        assert tiles >= 4
        assert self.tiles("scan.ply", *EULER, "--tile", "auto") == tiles
        assert self.tiles("scan.ply", *EULER, "--tile", "off") is None

    def test_half_of_the_memory_is_taken(self, monkeypatch: pytest.MonkeyPatch) -> None:
        for memory, is_cut in ((2 * 500 * 700, False), (2 * 500 * 700 - 2, True)):
            monkeypatch.setattr(machine, "memory", lambda memory=memory: memory)
            assert (self.tiles("scan.ply", *EULER) is not None) == is_cut

    @pytest.mark.usefixtures("_small_memory")
    def test_what_cannot_be_cut_is_not(self) -> None:
        assert self.tiles("scan.ply", *EULER, "--gradient", "autodiff") is None

    @pytest.mark.usefixtures("_small_memory")
    def test_text_is_cut(self) -> None:
        assert self.tiles("circle.xy", *EULER) is not None

    @pytest.mark.usefixtures("_small_memory")
    def test_streams_are_not_cut(self) -> None:
        data = Path("scan.ply").read_bytes()
        streamed = succeeds("denoise", "-", "-o", "-", *EULER, stdin=data).stdout
        succeeds("denoise", "scan.ply", "-o", "out.ply", *EULER)
        assert streamed == Path("out.ply").read_bytes()

    @pytest.mark.usefixtures("_small_memory")
    @pytest.mark.parametrize("name", ["missing", "PLY cut in the rows", "PLY with a word", "prose"])
    def test_bad_files_are_reported_as_ever(self, folder: Path, name: str) -> None:
        file, content, cause = BAD_FILES[name]
        if content is not None:
            Path(file).write_bytes(content)
        before = snapshot(folder)
        check_line(command("denoise", file, "-o", "out.ply", *EULER), 1, cause)
        assert snapshot(folder) == before


@contextlib.contextmanager
def at_every_write(
    monkeypatch: pytest.MonkeyPatch, happen: Callable[[int], None]
) -> Iterator[None]:
    """Let something happen before each write into the tiles, told how many there were."""
    count = 0
    pwrite = os.pwrite

    def write(file: int, data: bytes, start: int) -> int:
        nonlocal count
        happen(count)
        count += 1
        return pwrite(file, data, start)

    with monkeypatch.context() as patch:
        patch.setattr(os, "pwrite", write)
        yield


class TestTileFolder:
    RUN = ("denoise", "scan.ply", "-o", "out/out.ply", "--overwrite", "--tile", "120", *EULER)

    @pytest.fixture(autouse=True)
    def _folders(self, folder: Path) -> None:
        Path("out").mkdir()
        Path("tiles").mkdir()

    def left(self, folder: Path) -> set[str]:
        """What there is now that was not there in the beginning."""
        return {path for path in snapshot(folder) if path.startswith(("out/", "tiles/", "."))}

    @pytest.mark.slow
    @pytest.mark.parametrize(
        ("options", "parent"), [((), "out"), (("--tile-folder", "tiles"), "tiles")]
    )
    def test_tiles_lie_there_until_the_end(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch, options: tuple[str, ...], parent: str
    ) -> None:
        seen: set[str] = set()
        with at_every_write(monkeypatch, lambda _count: seen.update(self.left(folder))):
            succeeds(*self.RUN, *options)
        first, *_ = sorted(seen)
        assert re.fullmatch(rf"{parent}/\.pcsmooth-tiles-[\w-]+", first)
        assert all(path.startswith(first) for path in seen)
        assert self.left(folder) == {"out/out.ply"}

    def test_where_none_is_written_they_are_not_beside_the_input(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        temporary = folder / "temporary"
        temporary.mkdir()
        monkeypatch.setattr(tempfile, "tempdir", str(temporary))
        seen: set[str] = set()

        def look(_count: int) -> None:
            seen.update(path.name for path in temporary.iterdir())
            assert self.left(folder) == set()

        with at_every_write(monkeypatch, look):
            succeeds("info", "scan.ply", "--tile", "120")
        (name,) = seen
        assert name.startswith(".pcsmooth-tiles-")
        assert list(temporary.iterdir()) == []

    @pytest.mark.parametrize("after", [0, 7, 60])
    @pytest.mark.parametrize("existing", [True, False])
    def test_full_disk(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch, after: int, existing: bool
    ) -> None:
        if existing:
            Path("out/out.ply").write_bytes(b"precious")

        def fill(count: int) -> None:
            if count >= after:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        before = snapshot(folder)
        with at_every_write(monkeypatch, fill):
            finished = command(*self.RUN, "-q")
        check_line(finished, 1, r"\.pcsmooth-tiles-.*: No space left on device; check the disk")
        assert snapshot(folder) == before

    @pytest.mark.parametrize("renamed", [True, False])
    @pytest.mark.parametrize("existing", [True, False])
    def test_an_input_that_changes_between_two_passes(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch, existing: bool, renamed: bool
    ) -> None:
        if existing:
            Path("out/out.ply").write_bytes(b"precious")
        other = Path("scan.ply").read_bytes()[::-1]

        def change(count: int) -> None:
            if count == 7:
                Path("new.ply").write_bytes(other)
                os.utime("new.ply", ns=(0, 0))
                if renamed:
                    os.replace("new.ply", "scan.ply")
                else:
                    Path("scan.ply").write_bytes(other)
                    os.utime("scan.ply", ns=(0, 0))

        with at_every_write(monkeypatch, change):
            finished = command(*self.RUN, "-q")
        check_line(finished, 1, "scan.ply: it has changed while it was read; run again when nothi")
        assert self.left(folder) == ({"out/out.ply"} if existing else set())
        assert not existing or Path("out/out.ply").read_bytes() == b"precious"

    @pytest.mark.parametrize("after", [0, 60])
    def test_interrupt(self, folder: Path, monkeypatch: pytest.MonkeyPatch, after: int) -> None:
        def press(count: int) -> None:
            if count >= after:
                raise KeyboardInterrupt

        before = snapshot(folder)
        with at_every_write(monkeypatch, press):
            finished = command(*self.RUN, "-q")
        assert finished.status == 130
        assert finished.stderr.split("\n")[-2:] == ["Error: interrupted", ""]
        assert snapshot(folder) == before

    @pytest.mark.slow
    def test_interrupt_of_a_process(self, folder: Path) -> None:
        before = snapshot(folder)
        endless = ["--iterations", "1000000", "-v"]
        with start(*self.RUN, *endless) as child:
            assert child.stderr is not None
            while not re.match(rb" +1  volume ", line := child.stderr.readline()):
                assert line, "ended early"
            assert interrupt(child) == 130
            assert child.stderr.read().splitlines()[-1] == b"Error: interrupted"
        assert snapshot(folder) == before


def test_text_as_other_programs_write_it() -> None:
    """Rows over two lines, odd NaN, names with blanks, and normals by another name."""
    names = ["x", "y", "z", "normal_x", "normal_y", "normal_z", "two words"]
    header = "".join(f"property float {name}\n" for name in names)
    rows = "".join(f"{x} {y} {z}\n-0.6 0 0.8 7\n" for x, y, z in sphere(480).tolist())
    rows += "-nan(ind) 1.#QNAN NaN\n0 0 1 7\n" * 20
    text = f"ply\nformat ascii 1.0\n\nelement vertex 500\n{header}end_header\n{rows}"
    Path("odd.ply").write_text(text)
    check_same("odd.ply", *EULER)
    result = Path("tiled.ply").read_text()
    assert "property float normal_z\nproperty float two words\n" in result
    assert " nx\n" not in result
    assert result.count("\n-nan(ind) 1.#QNAN NaN 0.0 0.0 0.0 7.0 ") == 20
