"""Rooms use those below them, as the README's list of them says."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parent.parent
SOURCES = ROOT / "src" / "pcsmooth"

#: Modules that stand beside a room and belong to it.
BESIDE = {
    "estimating": "denoising",
    "denoise_result": "denoising",
    "progress": "parts",
    "record": "parts",
    "point_order": "parts",
}


def listed_rooms() -> list[str]:
    """The rooms of the README, the uppermost first."""
    text = (ROOT / "README.md").read_text()
    block = text.partition("```\nsrc/pcsmooth/\n")[2].partition("```")[0]
    return re.findall(r"^  ([a-z_]+)(?:/|\.py)  ", block, re.MULTILINE)


def room_of(module: str) -> str:
    name = module.split(".")[1] if "." in module else ""
    return BESIDE.get(name, name)


def imports() -> Iterator[tuple[str, str, Path]]:
    """Rooms that import, what they import from, and where."""
    for path in SOURCES.rglob("*.py"):
        own = room_of(".".join(["pcsmooth", *path.relative_to(SOURCES).with_suffix("").parts]))
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("pcsmooth"):
                yield own, room_of(node.module or ""), path


def test_all_rooms_are_listed() -> None:
    folders = {path.parent.name for path in SOURCES.glob("*/__init__.py")}
    assert folders <= set(listed_rooms())


def test_rooms_use_those_below_them() -> None:
    ranks = {room: rank for rank, room in enumerate(listed_rooms())}
    found = list(imports())
    assert len(found) > 500
    upwards = [
        f"{path.relative_to(SOURCES)} imports {used}"
        for own, used, path in found
        if own in ranks and used in ranks and ranks[used] < ranks[own]
    ]
    assert upwards == []
