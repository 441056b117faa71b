"""Check the built pages: links lead somewhere, every option has its place. See `make docs`."""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import click

from pcsmooth.cli.help import options_by_group
from pcsmooth.cli.main import main


class Page(HTMLParser):
    """What a page links to, and what can be linked to in it."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.feed(path.read_text())

    def handle_starttag(self, _tag: str, attributes: list[tuple[str, str | None]]) -> None:
        for name, value in attributes:
            if name in ("href", "src") and value:
                self.links.append(value)
            if name == "id" and value:
                self.anchors.add(value)


def broken_links(folder: Path) -> list[str]:
    """Say which links of the pages in a folder lead nowhere; those to elsewhere are not tried."""
    pages = {
        path.resolve(): Page(path) for path in folder.rglob("*.html") if "_static" not in path.parts
    }
    found = []
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.exists():
                found.append(f"{path.relative_to(folder.resolve())}: {link} is not there")
            elif (
                parts.fragment
                and target in pages
                and unquote(parts.fragment) not in pages[target].anchors
            ):
                found.append(f"{path.relative_to(folder.resolve())}: {link} has no such anchor")
    return found


def missing_options(folder: Path) -> list[str]:
    """Say which options of commands the pages of commands do not explain."""
    found = []
    for name, command in main.commands.items():
        if name == "help":
            continue  # explained on the first page of commands
        page = Page(folder / "commands" / f"{name}.html")
        groups = options_by_group(command, click.Context(command))
        for option in (option for group in groups.values() for option in group):
            if option.opts[-1] in ("--help", "--help-all"):
                continue
            if f"cmdoption-pcsmooth-{name}-{option.opts[0].lstrip('-')}" not in page.anchors:
                found.append(f"commands/{name}.html does not explain {option.opts[-1]}")
    return found


if __name__ == "__main__":
    built = Path(sys.argv[1])
    wrong = broken_links(built) + missing_options(built)
    print("\n".join(wrong) or "all links between pages lead somewhere, all options are explained")
    sys.exit(bool(wrong))
