"""`pcsmooth presets`."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from cli.clouds import save_ply, sphere, vertices
from cli.commands import pcsmooth as command
from cli.commands import succeeds
from pcsmooth import load_presets, read_cloud


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An own folder with a file of presets and a mesh that exists."""
    tmp_path = tmp_path / "own"
    tmp_path.mkdir()
    monkeypatch.chdir(tmp_path)
    Path("bodies.toml").write_text(
        '[brick]\ndescription = "flat"\nbase = "cube"\nscale = [1, 1, 0.5]\n'
        "[kite]\nvertices = [[2, 0], [0, 1], [-1, 0], [0, -1]]\n"
    )
    Path("wrong.toml").write_text('[brick]\nbase = "cuve"\n')
    Path("existing.ply").write_bytes(b"precious")
    return tmp_path


def facts(*arguments: object) -> dict[str, Any]:
    finished = succeeds("presets", *arguments, "--json")
    assert finished.stderr == ""
    assert finished.stdout.count(b"\n") == 1
    return finished.json


def words_of(*arguments: object) -> list[str]:
    finished = succeeds("presets", *arguments)
    assert finished.stderr == ""
    return finished.stdout.decode().splitlines()


def test_json_lists_every_preset() -> None:
    found = facts()["presets"]
    bodies = load_presets()
    assert [preset["name"] for preset in found] == list(bodies)
    assert found[0] == {
        "name": "cube",
        "dimension": 3,
        "facets": 6,
        "vertices": 8,
        "symmetric": True,
        "inradius": 1.0,
        "circumradius": pytest.approx(3**0.5),
        "defined_in": "shipped",
    }


def test_the_table_holds_the_same() -> None:
    head, *rows = words_of("--presets", "bodies.toml")
    assert head.split() == [
        "name", "dimension", "facets", "vertices", "symmetric", "inradius", "circumradius",
        "defined", "in",
    ]  # fmt: skip
    found = facts("--presets", "bodies.toml")["presets"]
    assert len(rows) == len(found) == len(load_presets()) + 2
    for row, preset in zip(rows, found, strict=True):
        assert row.split() == [
            preset["name"],
            *(str(preset[key]) for key in ("dimension", "facets", "vertices")),
            "yes" if preset["symmetric"] else "no",
            *(f"{preset[key]:.6g}" for key in ("inradius", "circumradius")),
            preset["defined_in"],
        ]
    assert rows[-1].split()[0] == "kite"
    assert rows[-1].endswith("bodies.toml")
    assert (
        len({row.index(preset["defined_in"]) for row, preset in zip(rows, found, strict=True)}) == 1
    )


def test_json_of_one() -> None:
    found = facts("brick", "--presets", "bodies.toml")
    body = load_presets("bodies.toml")["brick"]
    assert list(found)[:2] == ["description", "name"]
    assert (found["description"], found["name"]) == ("flat", "brick")
    assert (found["defined_in"], found["volume"]) == ("bodies.toml", 4.0)
    assert found["normals"] == body.normals.tolist()
    assert found["offsets"] == body.offsets.tolist()


def test_text_of_one() -> None:
    lines = words_of("brick", "--presets", "bodies.toml")
    said = dict(line.split("  ", 1) for line in lines[: lines.index("normal . x <= offset:")])
    assert {key.strip(): value.strip() for key, value in said.items()} == {
        "description": "flat",
        "name": "brick",
        "dimension": "3",
        "facets": "6",
        "vertices": "8",
        "symmetric": "yes",
        "inradius": "0.5",
        "circumradius": "1.5",
        "defined in": "bodies.toml",
        "volume": "4",
    }
    half_spaces = [line.split() for line in lines[-6:]]
    assert ["0.000000000", "0.000000000", "-1.000000000", "<=", "0.5"] in half_spaces
    assert words_of("kite", "--presets", "bodies.toml")[0] == "description"


class TestControlCharacters:
    NAME = "red\x1b[31m\nbrick"

    @pytest.fixture(autouse=True)
    def _file(self) -> None:
        Path("red.toml").write_text(
            '["red\\u001b[31m\\nbrick"]\ndescription = "a\\u0007b"\nbase = "cube"\n'
        )

    def test_are_spelled_out(self) -> None:
        rows = words_of("--presets", "red.toml")
        assert len(rows) == len(load_presets()) + 2
        assert rows[-1].startswith(r"red\x1b[31m\nbrick  ")
        lines = words_of(self.NAME, "--presets", "red.toml")
        assert [line.split("  ")[-1].strip() for line in lines[:2]] == [
            r"a\x07b",
            r"red\x1b[31m\nbrick",
        ]
        assert all(line.isprintable() for line in (*rows, *lines))

    def test_json_has_them_as_they_are(self) -> None:
        assert facts("--presets", "red.toml")["presets"][-1]["name"] == self.NAME

    def test_comments_of_clouds_spell_them_out(self) -> None:
        save_ply(Path("scan.ply"), vertices(sphere(), "f8"))
        options = ("--presets", "red.toml", "--polyhedron", self.NAME, "--iterations", "1")
        told = succeeds("denoise", "scan.ply", "-o", "out.ply", *options).stderr
        assert r"polyhedron red\x1b[31m\nbrick, " in told
        (comment,) = (line for line in read_cloud("out.ply").comments if "polyhedron=" in line)
        assert r" polyhedron=red\x1b[31m-brick " in comment


def test_long_bodies_are_cut_short() -> None:
    lines = words_of("sphere-100")
    assert lines[-1] == "  and 80 more, which --json shows"
    assert len(lines) < 40
    assert len(facts("sphere-100")["normals"]) == 100


@pytest.mark.parametrize("suffix", ["ply", "stl", "obj", "off", "PLY"])
@pytest.mark.parametrize("name", ["tetrahedron", "sphere-50", "brick"])
def test_export(name: str, suffix: str) -> None:
    path = Path(f"body.{suffix}")
    assert facts(name, "--presets", "bodies.toml", "-o", path)["name"] == name
    body = load_presets("bodies.toml")[name]
    mesh: Any = trimesh.load_mesh(path)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(body.volume, rel=1e-6)  # > 0: it looks outward
    assert len(mesh.vertices) == len(body.vertices)
    np.testing.assert_allclose(mesh.bounds[1], body.support(np.eye(3)), rtol=1e-6)


def test_export_replaces_only_when_told_to() -> None:
    finished = command("presets", "cube", "-o", "existing.ply")
    assert finished.status == 1
    assert Path("existing.ply").read_bytes() == b"precious"
    succeeds("presets", "cube", "-o", "existing.ply", "--overwrite")
    mesh: Any = trimesh.load_mesh("existing.ply")
    assert mesh.volume == 8.0


#: Arguments, exit status, what the message must say.
FAULTS = {
    "unknown": (["cub"], 1, "there is no preset 'cub'; did you mean cube?"),
    "none like it": (["torus"], 1, "there is no preset 'torus'; use one of bipyramid, circle-16"),
    "no file": (["--presets", "none.toml"], 1, "none.toml: no such file or folder; check the path"),
    "wrong file": (
        ["cube", "--presets", "wrong.toml"],
        1,
        "wrong.toml: preset 'brick': there is no preset 'cuve' to base it on; did you mean cube?",
    ),
    "exists": (["cube", "-o", "existing.ply"], 1, "existing.ply: exists already; pass --overwri"),
    "no folder": (["cube", "-o", "none/cube.ply"], 1, "none/cube.ply: there is no folder"),
    "suffix": (
        ["cube", "-o", "cube.xyz"],
        1,
        "cube.xyz: its suffix '.xyz' is of no mesh; use one of .ply .stl .obj .off",
    ),
    "2D": (["square", "-o", "a.ply"], 1, "a.ply: a body in 2D is no mesh; choose a preset in 3D"),
    "output of all": (["-o", "all.ply"], 2, "-o needs the NAME of a body; see pcsmooth presets"),
    "stdout": (["cube", "-o", "-"], 2, "-o needs the name of a file; see pcsmooth presets --help"),
    "two": (["cube", "square"], 2, "square"),
    "allowed nothing": (["--allow-outside"], 2, "--allow-outside needs --presets; see pcsmooth pr"),
    "a pipe": (["--presets", "pipe"], 1, "pipe: is a named pipe; name a file"),
    "a device": (["--presets", "/dev/zero"], 1, "/dev/zero: is a device; name a file"),
    "huge": (["--presets", "huge"], 1, "huge: has more than 256 MB; give a smaller file"),
    "huge mesh": (
        ["--presets", "outside.toml", "--allow-outside"],
        1,
        "outside.toml: preset 'it': mesh ../huge.stl: has more than 256 MB; give a smaller file",
    ),
    "outside": (
        ["--presets", "outside.toml"],
        1,
        "outside.toml: preset 'it': mesh '../huge.stl' lies outside of the folder of this file; "
        "pass --allow-outside if you trust it",
    ),
}


@pytest.mark.parametrize(("arguments", "status", "message"), FAULTS.values(), ids=FAULTS)
def test_faults(folder: Path, arguments: list[str], status: int, message: str) -> None:
    os.mkfifo("pipe")
    Path("outside.toml").write_text("[it]\nmesh = '../huge.stl'\n")
    for path in ("huge", "../huge.stl"):
        with open(path, "wb") as file:
            file.truncate(256_000_001)
    before = sorted(folder.iterdir())
    finished = command("presets", *arguments)
    assert (finished.status, finished.stdout) == (status, b"")
    assert finished.stderr.startswith("Error: ")
    assert finished.stderr.count("\n") == 1
    assert message in finished.stderr
    assert sorted(folder.iterdir()) == before
