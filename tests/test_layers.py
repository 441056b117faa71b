"""Rooms use those below them, as the README's list of them says; the experiments stand beside."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parent.parent
SOURCES = ROOT / "src" / "pcsmooth"
EXPERIMENTS = ROOT / "src" / "pcsmooth_experiments"

#: Modules that stand beside a room and belong to it.
BESIDE = {
    "estimating": "denoising",
    "denoised_rows": "denoising",
    "progress": "parts",
    "record": "parts",
    "point_order": "parts",
}


def listed_rooms() -> list[str]:
    """The rooms of the README, the uppermost first."""
    text = (ROOT / "README.md").read_text()
    block = text.partition("```\nsrc/pcsmooth/\n")[2].partition("src/pcsmooth_experiments/\n")[0]
    return re.findall(r"^  ([a-z_]+)(?:/|\.py)  ", block, re.MULTILINE)


def room_of(module: str) -> str:
    name = module.split(".")[1] if "." in module else ""
    return BESIDE.get(name, name)


def imported(node: ast.AST) -> Iterator[str]:
    """Modules that are imported somewhere in a piece of source, whenever it runs."""
    for part in ast.walk(node):
        if isinstance(part, ast.ImportFrom):
            yield part.module or ""
        elif isinstance(part, ast.Import):
            yield from (alias.name for alias in part.names)


def imports(folder: Path) -> Iterator[tuple[Path, str]]:
    """Files of a package, and what they import."""
    for path in folder.rglob("*.py"):
        for module in imported(ast.parse(path.read_text())):
            yield path, module


def is_of(module: str, package: str) -> bool:
    return module.partition(".")[0] == package


def test_all_rooms_are_listed() -> None:
    folders = {path.parent.name for path in SOURCES.glob("*/__init__.py")}
    assert folders <= set(listed_rooms())


def test_rooms_use_those_below_them() -> None:
    ranks = {room: rank for rank, room in enumerate(listed_rooms())}
    found = [(path, module) for path, module in imports(SOURCES) if is_of(module, "pcsmooth")]
    assert len(found) > 500
    upwards = []
    for path, module in found:
        own = room_of(".".join(["pcsmooth", *path.relative_to(SOURCES).with_suffix("").parts]))
        used = room_of(module)
        if own in ranks and used in ranks and ranks[used] < ranks[own]:
            upwards.append(f"{path.relative_to(SOURCES)} imports {used}")
    assert upwards == []


def test_experiments_use_no_command_line() -> None:
    rooms = {room_of(module) for _, module in imports(EXPERIMENTS) if is_of(module, "pcsmooth")}
    assert {"energies", "flows", "plots"} <= rooms
    assert "cli" not in rooms


def test_one_command_uses_the_experiments_and_only_when_it_runs() -> None:
    users = {path for path, module in imports(SOURCES) if is_of(module, EXPERIMENTS.name)}
    command = SOURCES / "cli" / "experiments.py"
    assert users == {command}
    statements = [
        statement
        for statement in ast.parse(command.read_text()).body
        if any(is_of(module, EXPERIMENTS.name) for module in imported(statement))
    ]
    assert all(
        isinstance(statement, ast.FunctionDef)
        or (isinstance(statement, ast.If) and ast.unparse(statement.test) == "TYPE_CHECKING")
        for statement in statements
    )
