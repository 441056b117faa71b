"""Bad input: one line that says the file, the cause and the remedy; nothing else happens."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import pcsmooth.files.denoise_file
from cli.clouds import circle, save_ply, save_text, sphere, vertices
from cli.commands import Finished, process
from cli.commands import pcsmooth as command

Content = bytes | None


def snapshot(folder: Path) -> dict[str, Content]:
    """Every file and folder below, with its bytes."""
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in sorted(folder.rglob("*"))
    }


def check_line(finished: Finished, status: int, cause: str) -> None:
    """Check that a command failed with one line of the right kind."""
    assert finished.status == status, finished.stderr
    assert finished.stdout == b""
    lines = [line for line in finished.stderr.splitlines() if "coordinates:" not in line]
    assert len(lines) == 1, finished.stderr
    assert lines[0].startswith("Error: ")
    assert re.search(cause, lines[0]), finished.stderr
    cause_end, _, remedy = lines[0].rpartition("; ")
    assert cause_end, "no remedy"
    assert remedy


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An own folder with a good cloud, a good curve and files that exist."""
    monkeypatch.chdir(tmp_path)
    save_ply(Path("good.ply"), vertices(sphere(), "f4"))
    save_text(Path("good.xy"), circle())
    Path("existing.ply").write_bytes(b"precious")
    Path("existing.csv").write_bytes(b"precious")
    Path("folder.ply").mkdir()
    return tmp_path


HEADER = b"ply\nformat ascii 1.0\nelement vertex 3\n"
XYZ = b"property float x\nproperty float y\nproperty float z\n"
BINARY = HEADER.replace(b"ascii", b"binary_little_endian") + XYZ + b"end_header\n"

#: Name of the file, its bytes, cause.
BAD_FILES: dict[str, tuple[str, Content, str]] = {
    "missing": ("missing.ply", None, "no such file"),
    "in a missing folder": ("none/missing.xyz", None, "no such file"),
    "below a file": ("good.ply/scan.xyz", None, "folder"),
    "folder": ("folder.ply", None, "folder"),
    "picture": ("photo.png", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "not a point cloud"),
    "picture called ply": ("photo.ply", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "not a PLY file"),
    "utf-16": ("wide.txt", "0 1 2\n".encode("utf-16"), "UTF-16"),
    "prose": ("letter.txt", b"Dear all,\nthe scan is late.\n", "letter.txt"),
    "PLY cut in the header": ("cut.ply", HEADER + b"property flo", "end_header"),
    "PLY cut in the rows": ("cut.ply", BINARY + b"\0" * 35, "36 bytes, but 35 bytes follow"),
    "text PLY cut": ("cut.ply", HEADER + XYZ + b"end_header\n0 0 0\n1 1 1\n", "promises 3 vertex"),
    "PLY with a word": (
        "word.ply",
        HEADER + XYZ + b"end_header\n0 0 0\n1 one 1\n2 2 2\n",
        "row 1: y is 'one', not a number",
    ),
    "PLY without positions": (
        "faces.ply",
        HEADER + b"property float u\nend_header\n1\n2\n3\n",
        "no number 'x'",
    ),
    "PLY without vertices": (
        "none.ply",
        HEADER.replace(b"vertex 3", b"vertex 0") + XYZ + b"end_header\n",
        "no points",
    ),
    "PLY without vertex element": (
        "camera.ply",
        HEADER.replace(b"vertex", b"camera") + XYZ + b"end_header\n0 0 0\n1 1 1\n2 2 2\n",
        "no vertex element",
    ),
    "empty PLY": ("empty.ply", b"", "empty"),
    "empty text": ("empty.xyz", b"", "no points"),
    "blank lines": ("blank.txt", b"\n  \n\n", "no points"),
    "comments alone": ("notes.txt", b"# soon\n// later\n", "no points"),
    "header alone": ("head.csv", b"x,y,z\n", "no points"),
    "count of nothing": ("none.pts", b"0\n", "no points"),
    "ragged": ("ragged.xyz", b"0 0 0\n1 0 0\n\n1 1\n", "line 4 has 2 columns, expected 3"),
    "too many columns": ("ragged.csv", b"x,y\n0,0\n0,1,2\n", "line 3 has 3 columns, expected 2"),
    "one column": ("heights.txt", b"1\n2.5\n3\n", "1 column"),
    "word": ("word.xyz", b"0 0 0\n1 abc 0\n", r"line 2: 'abc' is not a number"),
    "word after a header": ("word.csv", b"#\nx,y\n0,0\n1,a\n", r"line 4: 'a' is not a number"),
    "mixed decimals": ("comma.csv", b"x;y\n0,5;1\n1.5;2\n", "line 3: '1.5' is not a number"),
    "unknown header": ("names.csv", b"a,b,c\n0,1,2\n", "names no coordinates .*--columns 1,2,3"),
    "running number": ("id.xyz", b"1 0 1 5\n2 1 0 5\n3 1 1 5\n", "running number.*--columns 2,"),
    "grid": ("dem.asc", b"ncols 2\nnrows 1\n0 1\n", "ESRI ASCII grid.*gdal_translate"),
    "NaN alone": ("nan.xyz", b"nan 0 0\n0 inf 0\nnan nan nan\n", "no point with finite"),
    "one point": ("one.xyz", b"1 2 3\n", "there is only one point"),
    "one place": ("one.xyz", b"1 2 3\n1 2 3\n1 2 3\n", "all points are at one place"),
}  # fmt: skip


@pytest.mark.parametrize(("name", "content", "cause"), BAD_FILES.values(), ids=BAD_FILES)
def test_curvature_fails_alike(folder: Path, name: str, content: Content, cause: str) -> None:
    if content is not None:
        Path(name).write_bytes(content)
    before = snapshot(folder)
    finished = command("curvature", name, "-o", "out.ply", "--json")
    check_line(finished, 1, cause)
    assert f"Error: {name}: " in finished.stderr
    assert snapshot(folder) == before


@pytest.mark.parametrize(("name", "content", "cause"), BAD_FILES.values(), ids=BAD_FILES)
def test_bad_files(folder: Path, name: str, content: Content, cause: str) -> None:
    if content is not None:
        Path(name).write_bytes(content)
    before = snapshot(folder)
    finished = command("denoise", name, "-o", "out.ply", "--energy-log", "log.csv", "--json")
    check_line(finished, 1, cause)
    assert f"Error: {name}: " in finished.stderr
    assert snapshot(folder) == before


UNREADABLE = {
    name: bad
    for name, bad in BAD_FILES.items()
    if not name.startswith(("NaN", "one p"))  # these hold facts
}


@pytest.mark.parametrize(("name", "content", "cause"), UNREADABLE.values(), ids=UNREADABLE)
def test_info_fails_alike(folder: Path, name: str, content: Content, cause: str) -> None:
    if content is not None:
        Path(name).write_bytes(content)
    finished = command("info", name)
    check_line(finished, 1, cause)
    assert f"Error: {name}: " in finished.stderr


@pytest.mark.parametrize(
    "arguments", [["denoise", "-", "-o", "-"], ["curvature", "-", "-o", "-"], ["info", "-"]]
)
@pytest.mark.parametrize(
    ("data", "cause"),
    [
        (b"", "no points"),
        (b"\0\1\2", "not a point cloud"),
        (b"0 0 0\n1 x 1\n", "line 2: 'x' is not a number"),
        (BINARY, "but 0 bytes follow"),
    ],
    ids=["empty", "binary", "word", "cut PLY"],
)
def test_bad_stdin(arguments: list[str], data: bytes, cause: str) -> None:
    finished = command(*arguments, stdin=data)
    check_line(finished, 1, cause)
    assert finished.stderr.startswith("Error: <stdin>: ")


GOOD = ["denoise", "good.ply", "-o", "out.ply"]

CURVE = ["curvature", "good.ply", "-o", "out.ply"]

#: Options that flows alone have.
FLOW_OPTIONS = {
    "--energy": "volume",
    "--weight": "cell",
    "--iterations": "6",
    "--step": "0.01",
    "--stop": "0.01",
    "--gradient": "autodiff",
    "--polyhedron": "cube",
}

#: What both commands refuse.
SHARED_USAGE: dict[str, tuple[list[str], str]] = {
    **{
        f"support {value}": (["--support", value], f"'--support'.*'{value}'.* 3 or more")
        for value in ("2", "0", "-5", "4.5", "many", "nan", "")
    },
    **{
        f"orient {value}": (["--orient", value], "'--orient'.*auto, outward, propagate")
        for value in (
            *("", "up", "viewpoint", "viewpoint=", "viewpoint=1", "viewpoint=1,2,3,4"),
            *("viewpoint=a,b,c", "viewpoint=nan,0,0", "direction=0,0,0", "outward=1,2,3"),
        )
    },
    "convention": (["--mean-convention", "whole"], "'--mean-convention'.*'whole'.*half.*sum"),
    "dialect": (["--dialect", "gom"], "'--dialect'.*'gom'.*generic.*meshlab.*cloudcompare.*pcl"),
    "colormap": (["--colormap", "rainboww"], "'--colormap'.*'rainboww'; try coolwarm, RdBu"),
    "color by": (
        ["--colormap", "gray", "--color-by", "height"],
        "'--color-by'.*'height'.*mean.*gaussian.*k1.*k2.*confidence",
    ),
    "color by without color map": (["--color-by", "k1"], "--color-by needs --colormap"),
}

#: Arguments, what the message must say.
USAGE: dict[str, tuple[list[str], str]] = {
    **{
        f"radius {value}": ([*GOOD, "--radius", value], f"'--radius'.*{re.escape(value)}")
        for value in ("0", "-1", "nan", "inf", "wide", "0x", "-2%", "nanx", "inf%", "1e999", "3y")
    },
    "radius nothing": ([*GOOD, "--radius", ""], "'--radius'"),
    **{
        f"step {value}": ([*GOOD, "--step", value], f"'--step'.*{value}")
        for value in ("0", "-1", "nan", "inf", "soon")
    },
    "iterations -1": ([*GOOD, "--iterations", "-1"], "'--iterations'.*-1"),
    "iterations 1.5": ([*GOOD, "--iterations", "1.5"], "'--iterations'.*1.5"),
    **{
        f"stop {value}": ([*GOOD, "--stop", value], f"'--stop'.*{value}.*positive number")
        for value in ("0", "-1", "nan", "auto")
    },
    **{
        f"max move {value}": ([*GOOD, "--max-move", value], f"'--max-move'.*{re.escape(value)}")
        for value in ("0", "-1x", "auto", "far")
    },
    "scheme": (
        [*GOOD, "--scheme", "verlet"],
        "'--scheme'.*'verlet'.*auto.*filter.*euler.*implicit",
    ),
    **{
        f"noise {value}": ([*GOOD, "--noise", value], f"'--noise'.*{re.escape(value)}")
        for value in ("0", "-1", "-1x", "0%", "auto", "loud", "nan", "inf")
    },
    "noise nothing": ([*GOOD, "--noise", ""], "'--noise'"),
    **{
        f"{option} of the filter": (
            [*GOOD, "--scheme", "filter", option, value],
            f"{option} needs --scheme euler or implicit, not --scheme filter",
        )
        for option, value in FLOW_OPTIONS.items()
    },
    **{
        f"noise with {option}": (
            [*GOOD, "--noise", "1x", option, value],
            "--noise needs --scheme filter or implicit",
        )
        for option, value in {**FLOW_OPTIONS, "--radius": "2x", "--scheme": "euler"}.items()
    },
    "closed with euler": (
        [*GOOD, "--scheme", "euler", "--closed"],
        "--closed needs --scheme filter, not --scheme euler",
    ),
    "order of the filter": (
        [*GOOD, "--scheme", "filter", "--order", "2"],
        "--order needs --scheme implicit",
    ),
    "order": ([*GOOD, "--scheme", "implicit", "--order", "3"], "'--order'.*'3'.*1.*2"),
    "order of euler": ([*GOOD, "--order", "1"], "--order needs --scheme implicit"),
    "autodiff of implicit": (
        [*GOOD, "--scheme", "implicit", "--gradient", "autodiff"],
        "gradient is 'autodiff' and the scheme is implicit.*; choose the scheme euler",
    ),
    "order of polyhedra": (
        [*GOOD, "--scheme", "implicit", "--order", "2", "--polyhedron", "cube"],
        "the order is 2, which is for balls, not polyhedra; use order 1",
    ),
    "motion": ([*GOOD, "--motion", "wild"], "'--motion'.*'wild'.*free.*normal"),
    "threads 0": ([*GOOD, "--threads", "0"], "'--threads'.*0"),
    "energy": ([*GOOD, "--energy", "mass"], "'--energy'.*'mass'.*volume.*area"),
    "weight": ([*GOOD, "--weight", "heavy"], "'--weight'.*'heavy'.*none.*cell.*boundary"),
    "dim": ([*GOOD, "--dim", "4"], "'--dim'.*'4'.*auto.*2.*3"),
    **{
        f"{name} {key}": ([*arguments, *options], cause)
        for name, arguments in (("denoise", GOOD), ("curvature", CURVE))
        for key, (options, cause) in SHARED_USAGE.items()
    },
    "curvature radius": ([*CURVE, "--radius", "0"], "'--radius'.*0"),
    "curvature estimator": (
        [*CURVE, "--estimator", "fit"],
        "'--estimator'.*'fit'.*cells.*gradient",
    ),
    "energy of no estimator": (
        [*CURVE, "--energy", "volume"],
        "--energy is for --estimator gradient",
    ),
    "energy of the cells": (
        [*CURVE, "--estimator", "cells", "--energy", "area"],
        "--energy is for --estimator gradient",
    ),
    "curvature energy": (
        [*CURVE, "--estimator", "gradient", "--energy", "mass"],
        "'--energy'.*'mass'.*volume.*area",
    ),
    **{
        f"{column} of the thesis": (
            [*CURVE, "--estimator", "gradient", "--colormap", "gray", "--color-by", column],
            f"gradient has no {column} to color by; choose mean or confidence",
        )
        for column in ("gaussian", "k1", "k2")
    },
    "curvature json on a taken stdout": (
        ["curvature", "good.ply", "-o", "-", "--json"],
        "--json and -o -",
    ),
    "curvature without output": (["curvature", "good.ply"], "-o"),
    "curvature iterates": ([*CURVE, "--iterations", "3"], "--iterations"),
    "json on a taken stdout": (["denoise", "good.ply", "-o", "-", "--json"], "--json and -o -"),
    "no output": (["denoise", "good.ply"], "-o"),
    "no input": (["denoise", "-o", "out.ply"], "INPUT"),
    "two inputs": ([*GOOD, "good.xy"], "-o is for one input; give --output-dir DIR for many"),
    "unknown option": ([*GOOD, "--smoothness", "3"], "--smoothness"),
    "no value": ([*GOOD, "--radius"], "--radius"),
    "unknown command": (["smooth", "good.ply"], "smooth"),
    "info without input": (["info"], "INPUT"),
}


@pytest.mark.parametrize(("arguments", "cause"), USAGE.values(), ids=USAGE)
def test_usage(folder: Path, arguments: list[str], cause: str) -> None:
    before = snapshot(folder)
    finished = command(*arguments)
    check_line(finished, 2, cause)
    assert "--help" in finished.stderr
    assert snapshot(folder) == before


#: Arguments after `denoise`, the file that the message names, the cause.
REFUSALS: dict[str, tuple[list[str], str, str]] = {
    "output exists": (["good.ply", "-o", "existing.ply"], "existing.ply", "exists.*--overwrite"),
    "output is the input": (["good.ply", "-o", "good.ply"], "good.ply", "exists.*--overwrite"),
    "output is a folder": (
        ["good.ply", "-o", "folder.ply"],
        "folder.ply",
        "is a folder.*--output-dir",
    ),
    "output is a folder, overwrite": (
        ["good.ply", "-o", "folder.ply", "--overwrite"],
        "folder.ply",
        "is a folder",
    ),
    "no output folder": (["good.ply", "-o", "none/out.ply"], "none/out.ply", "there is no folder"),
    "output below a file": (
        ["good.ply", "-o", "existing.csv/out.ply"],
        "existing.csv/out.ply",
        "there is no folder",
    ),
    "unknown suffix": (["good.ply", "-o", "out.doc"], "out.doc", "suffix.*use one of .*.ply"),
    "no suffix": (["good.ply", "-o", "out"], "out", "suffix"),
    "3D as xy": (["good.ply", "-o", "out.xy"], "out.xy", "no third coordinate"),
    "log exists": (
        ["good.ply", "-o", "out.ply", "--energy-log", "existing.csv"],
        "existing.csv",
        "exists.*--overwrite",
    ),
    "log is a folder": (
        ["good.ply", "-o", "out.ply", "--energy-log", "folder.ply"],
        "folder.ply",
        "is a folder",
    ),
    "no log folder": (
        ["good.ply", "-o", "out.ply", "--energy-log", "none/log.csv"],
        "none/log.csv",
        "there is no folder",
    ),
    "3D of two columns": (["good.xy", "-o", "out.xy", "--dim", "3"], "good.xy", "2 coordinates"),
    "no such column": (
        ["labels.csv", "-o", "out.csv", "--fixed", "hold"],
        "labels.csv",
        "no column 'hold'.*choose one of kind, number",
    ),
    "number of no column": (
        ["labels.csv", "-o", "out.csv", "--fixed", "6"],
        "labels.csv",
        "no column '6'",
    ),
    "column of no other": (
        ["good.xy", "-o", "out.xy", "--fixed", "fixed"],
        "good.xy",
        "no column 'fixed'.*nothing but positions",
    ),
    "words to fix by": (
        ["labels.csv", "-o", "out.csv", "--fixed", "kind"],
        "labels.csv",
        "column 'kind' of point 1 is 'tree'",
    ),
    "radius that the cloud makes zero": (
        ["place.xyz", "-o", "out.xyz", "--radius", "2%"],
        "place.xyz",
        "all points are at one place, which makes the radius '2%' 0",
    ),
    "noise that the cloud makes zero": (
        ["place.xyz", "-o", "out.xyz", "--scheme", "filter", "--radius", "1", "--noise", "1x"],
        "place.xyz",
        "all points are at one place, which makes the noise '1x' 0",
    ),
    "too large for float": (
        ["far.xyz", "-o", "far.ply", "--float"],
        "far.ply",
        "float cannot hold such coordinates; pass --double",
    ),
    "words to PLY": (["labels.csv", "-o", "out.ply"], "out.ply", "column 'kind' holds words"),
}


@pytest.mark.parametrize(("arguments", "name", "cause"), REFUSALS.values(), ids=REFUSALS)
def test_refusals(folder: Path, arguments: list[str], name: str, cause: str) -> None:
    rows = [[*point, "tree", row] for row, point in enumerate(sphere().tolist())]
    save_text(Path("labels.csv"), [["x", "y", "z", "kind", "number"], *rows], ",")
    save_text(Path("place.xyz"), np.ones((3, 3)))
    save_text(Path("far.xyz"), np.r_[sphere(), [[1e300, 0, 0]]])
    before = snapshot(folder)
    finished = command("denoise", *arguments, "-q")
    check_line(finished, 1, cause)
    assert f"Error: {name}: " in finished.stderr
    assert snapshot(folder) == before


#: Arguments after the command, the file that the message names, the cause.
SHARED_REFUSALS: dict[str, tuple[list[str], str, str]] = {
    "output exists": (["good.ply", "-o", "existing.ply"], "existing.ply", "exists.*--overwrite"),
    "unknown suffix": (["good.ply", "-o", "out.doc"], "out.doc", "suffix.*use one of .*.ply"),
    "no normals": (
        ["good.ply", "-o", "out.ply", "--orient", "input"],
        "good.ply",
        "no normals nx ny nz to orient by; choose another --orient",
    ),
    "no normals of a curve": (
        ["good.xy", "-o", "out.ply", "--orient", "input"],
        "good.xy",
        "no normals nx ny to orient by",
    ),
    "normals of words": (
        ["words.csv", "-o", "out.csv", "--orient", "input"],
        "words.csv",
        "no normals",
    ),
    "viewpoint of a plane": (
        ["good.ply", "-o", "out.ply", "--orient", "viewpoint=1,2"],
        "good.ply",
        "viewpoint has 2 coordinates and the points 3",
    ),
    "direction in space": (
        ["good.xy", "-o", "out.xy", "--orient", "direction=1,2,3"],
        "good.xy",
        "direction has 3 coordinates and the points 2",
    ),
    **{
        f"{column} of a curve": (
            ["good.xy", "-o", "out.ply", "--colormap", "gray", "--color-by", column],
            "good.xy",
            f"a plane curve has no {words}; choose --color-by mean or confidence",
        )
        for column, words in (("gaussian", "Gaussian curvature"), ("k1", "k1"), ("k2", "k2"))
    },
    "too large for PCL": (
        ["far.xyz", "-o", "far.ply", "--dialect", "pcl"],
        "far.ply",
        "float cannot hold such coordinates; pass --double",
    ),
}


@pytest.mark.parametrize("name", ["denoise", "curvature"])
@pytest.mark.parametrize(
    ("arguments", "file", "cause"), SHARED_REFUSALS.values(), ids=SHARED_REFUSALS
)
def test_shared_refusals(
    folder: Path, name: str, arguments: list[str], file: str, cause: str
) -> None:
    rows = [[*point, 0, 0, "up"] for point in sphere().tolist()]
    save_text(Path("words.csv"), [["x", "y", "z", "nx", "ny", "nz"], *rows], ",")
    save_text(Path("far.xyz"), np.r_[sphere(), [[1e300, 0, 0]]])
    before = snapshot(folder)
    finished = command(name, *arguments, "-q")
    check_line(finished, 1, cause)
    assert finished.stderr.startswith(f"Error: {file}: ")
    assert snapshot(folder) == before


@pytest.mark.parametrize("arguments", [GOOD, CURVE], ids=["denoise", "curvature"])
def test_colors_without_matplotlib(
    folder: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str]
) -> None:
    before = snapshot(folder)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    finished = command(*arguments, "--colormap", "coolwarm")
    check_line(finished, 1, r"matplotlib.*; pip install 'pcsmooth\[colors\]'")
    assert snapshot(folder) == before
    assert command(*arguments, "-q").status == 0


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may do anything")
@pytest.mark.parametrize(
    ("closed", "arguments", "name"),
    [
        ("good.ply", ["good.ply", "-o", "out.ply"], "good.ply"),
        ("folder.ply", ["good.ply", "-o", "folder.ply/out.ply"], "folder.ply/out.ply"),
    ],
    ids=["input", "output folder"],
)
def test_what_may_not_be_opened(closed: str, arguments: list[str], name: str) -> None:
    mode = Path(closed).stat().st_mode
    os.chmod(closed, 0)
    try:
        finished = command("denoise", *arguments)
    finally:
        os.chmod(closed, mode)
    check_line(finished, 1, f"^Error: {name}: ")


@pytest.mark.parametrize(
    "arguments",
    [["good.ply", "-o", "existing.ply"], ["good.ply", "-o", "out.doc"]],
    ids=["exists", "suffix"],
)
def test_the_output_is_checked_before_the_work(
    monkeypatch: pytest.MonkeyPatch, arguments: list[str]
) -> None:
    def work(*_args: object, **_options: object) -> None:
        pytest.fail("the flow was started")

    monkeypatch.setattr(pcsmooth.files.denoise_file, "denoise_input", work)
    assert command("denoise", *arguments).status == 1


def fail_in_flow(error: BaseException) -> Callable[..., None]:
    def fail(*_args: object, **_options: object) -> None:
        raise error

    return fail


@pytest.mark.parametrize(
    ("error", "status", "cause"),
    [
        (KeyboardInterrupt(), 130, "interrupted"),
        (MemoryError(), 1, "not enough memory; use a smaller radius"),
    ],
    ids=["Ctrl-C", "memory"],
)
def test_failures_of_the_run(
    folder: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException, status: int, cause: str
) -> None:
    before = snapshot(folder)
    monkeypatch.setattr(pcsmooth.files.denoise_file, "denoise_parts", fail_in_flow(error))
    finished = command(*GOOD)
    assert finished.status == status
    assert re.fullmatch(rf"\n?Error: [^\n]*{cause}[^\n]*\n", finished.stderr)
    assert snapshot(folder) == before


@pytest.mark.parametrize("error", [KeyboardInterrupt(), OSError(28, "No space left on device")])
def test_a_write_that_is_cut_off_leaves_nothing(
    folder: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException
) -> None:
    before = snapshot(folder)
    monkeypatch.setattr(os, "replace", fail_in_flow(error))
    finished = command("denoise", "good.ply", "-o", "existing.ply", "--overwrite", "-q")
    assert finished.status == (130 if isinstance(error, KeyboardInterrupt) else 1)
    assert "Traceback" not in finished.stderr
    assert snapshot(folder) == before


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "status", "cause"),
    [
        (["denoise", "missing.ply", "-o", "out.ply"], 1, "missing.ply: no such file"),
        (["denoise", "good.ply", "-o", "out.ply", "--radius", "-1"], 2, "'--radius'"),
    ],
    ids=["file", "usage"],
)
def test_the_shell_sees_status_and_line(arguments: list[str], status: int, cause: str) -> None:
    check_line(process(*arguments), status, cause)
