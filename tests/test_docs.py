"""What the documentation says of commands and messages is so."""

from __future__ import annotations

import ast
import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import pytest

from pcsmooth.cli.main import main

ROOT = Path(__file__).parent.parent
PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").rglob("*.md")])
PAGES = [page for page in PAGES if not {"auto_gallery", "generated"} & set(page.parts)]

#: Options of other programs that pages name.
OF_OTHERS = {
    "--host", "--nthreads", "--rm", "--user", "--build-arg", "--index-url", "--extra-index-url",
}  # fmt: skip


#: As the group has it: commands keep the option that they are first asked for.
HELP: Any = {"help_option_names": ["-h", "--help"]}


def commands() -> Iterator[click.Command]:
    yield from main.commands.values()
    yield main


def known_options() -> set[str]:
    found = {"--help", "--version"}
    for command in commands():
        for parameter in command.get_params(click.Context(command, **HELP)):
            found |= {*parameter.opts, *parameter.secondary_opts}
    return found


def commands_of(page: Path) -> list[str]:
    """Lines of blocks of code that call pcsmooth, without what goes on around them."""
    blocks = re.findall(r"^```(?:sh|console|bash)\n(.*?)^```", page.read_text(), re.M | re.S)
    lines = "\n".join(blocks).replace("\\\n", " ").splitlines()
    found = []
    for line in lines:
        if match := re.search(r"(?:^|\$ |\| |-0 )(pcsmooth \w.*)", line):
            names = " x" if "xargs" in line else ""
            words = re.split(r" #| \| | > | >> | && |; ", match[1])[0]
            found.append(words.removesuffix(" \\").strip() + names)
    return found


LINES = [(page.relative_to(ROOT), line) for page in PAGES for line in commands_of(page)]


def messages() -> str:
    """All words of the program that it may say, with braces where values go; not its docstrings."""
    found = []
    for path in (ROOT / "src").rglob("*.py"):
        nodes = list(ast.walk(ast.parse(path.read_text())))
        described = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
        for node in nodes:
            if id(node) in described:
                continue
            if isinstance(node, ast.JoinedStr):
                parts = node.values
                found.append(
                    "".join(
                        str(part.value) if isinstance(part, ast.Constant) else "{}"
                        for part in parts
                    )
                )
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                found.append(node.value)
    return "\n".join(found)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_options_that_pages_name_are_there(page: Path) -> None:
    named = set(re.findall(r"(?<![\w-])--[a-z][a-z-]*[a-z]", page.read_text()))
    assert named - known_options() - OF_OTHERS == set()


@pytest.mark.parametrize(("page", "line"), LINES, ids=[line for _, line in LINES])
def test_command_lines_of_pages_are_understood(
    page: Path, line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("night.toml").touch()
    words = shlex.split(line.replace("{}", "x"))[1:]
    with main.make_context("pcsmooth", words) as context:
        name, called, rest = main.resolve_command(context, words)
        assert isinstance(called, click.Command)
        with called.make_context(name, rest, parent=context, resilient_parsing="--help" in rest):
            pass


def test_pages_have_command_lines() -> None:
    assert len(LINES) > 20


def test_messages_of_the_page_on_trouble_are_said() -> None:
    page = (ROOT / "docs" / "troubleshooting.md").read_text()
    said = re.sub(r"\{\}", " ", messages())
    quoted = re.findall(r"\*\*(.+?)\*\*", page)
    assert len(quoted) > 25
    missing = [
        quote
        for quote in quoted
        if not all(
            part.strip() in said for part in re.split(r"\.\.\.|[:(]", quote) if part.strip(" )")
        )
    ]
    assert missing == []
