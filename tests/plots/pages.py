"""Reading pages of HTML, by the parser of the standard library, and pages without the drawing."""

from __future__ import annotations

import contextlib
from base64 import b64decode
from collections.abc import Iterator
from dataclasses import dataclass, field
from html.parser import HTMLParser
from unittest import mock

from matplotlib.figure import Figure

from pcsmooth.plots import denoise_page, figures

#: Elements without an end.
VOID = {"meta", "img", "br", "input"}


@dataclass
class Page:
    """What a page holds."""

    text: str = ""
    links: list[str] = field(default_factory=list)
    pictures: list[bytes] = field(default_factory=list)
    described: list[str] = field(default_factory=list)
    rows: list[list[str]] = field(default_factory=list)
    scripts: list[str] = field(default_factory=list)
    headings: list[str] = field(default_factory=list)

    @property
    def facts(self) -> dict[str, list[str]]:
        """The rows of all tables, by their first cell."""
        return {row[0]: row[1:] for row in self.rows}


class _Reader(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.page = Page()
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        if tag == "img":
            kind, _, data = given["src"].partition("base64,")
            if data:
                assert kind == "data:image/png;"
                self.page.pictures.append(b64decode(data, validate=True))
                self.page.described.append(given["alt"])
        self.page.links += [
            given[name]
            for name in ("src", "href", "action", "data")
            if name in given and not given[name].startswith("data:")
        ]
        if tag == "tr":
            self.page.rows.append([])
        if tag in ("td", "th"):
            self.page.rows[-1].append("")
        if tag in ("h1", "h2"):
            self.page.headings.append("")
        if tag == "script":
            self.page.scripts.append("")
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        match self.open[-1] if self.open else "":
            case "script":
                self.page.scripts[-1] += data
            case "style":
                assert "url(" not in data
                assert "@import" not in data
            case _ if {"td", "th"} & set(self.open):
                self.page.rows[-1][-1] += data
            case "h1" | "h2":
                self.page.headings[-1] += data
            case _:
                self.page.text += data


def read_page(html: str) -> Page:
    """Parse a page, in which every element must end where it should."""
    reader = _Reader()
    reader.feed(html)
    reader.close()
    assert reader.open == []
    return reader.page


#: What stands in the place of each picture.
BLANK = b"\x89PNG\r\n\x1a\n"


@contextlib.contextmanager
def unrendered() -> Iterator[None]:
    """Have figures made but not drawn, which takes long, where nobody looks at the picture."""

    def blank(figure: Figure) -> bytes:
        assert figure.axes
        return BLANK

    with (
        mock.patch.object(figures, "png_of", blank),
        mock.patch.object(denoise_page, "png_of", blank),
    ):
        yield
