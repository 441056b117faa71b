"""Pages of HTML that need no other file: parts, and the whole."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Sequence
from html import escape

import pcsmooth
from pcsmooth.printable import printable

#: Bytes of a page in which its head says what made it.
_HEAD = 4096

GENERATOR = "pcsmooth"
"""What made the pages, as their heads say."""

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 62rem; margin: 2rem auto;
       padding: 0 1rem; }
h1, h2 { line-height: 1.2; }
h2 { margin-top: 2.5rem; border-top: 1px solid #ddd; padding-top: 1.2rem; }
img { max-width: 100%; height: auto; }
table { border-collapse: collapse; margin: 1rem 0; font-size: 14px; }
table { display: block; overflow-x: auto; }
td img { max-width: 9rem; max-height: 7rem; }
table.plain td { overflow-wrap: anywhere; }
td a { display: inline-block; min-width: 7rem; overflow-wrap: anywhere; }
th, td { border-bottom: 1px solid #ddd; padding: .2rem .8rem .2rem 0; text-align: left;
         vertical-align: top; }
""".strip()


class Markup(str):
    """HTML, by the functions of this module; other texts are plain."""

    __slots__ = ()


def page(title: str, body: Iterable[str]) -> str:
    """Make a whole page.

    Parameters
    ----------
    title : str
        Its title and first heading, as plain text.
    body : iterable of str
        HTML, by the functions of this module.

    Returns
    -------
    str
    """
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<meta name="generator" content="{GENERATOR} {pcsmooth.__version__}">\n'
        f"<title>{_shown(title)}</title>\n<style>\n{_STYLE}\n</style>\n</head>\n<body>\n"
        f"<h1>{_shown(title)}</h1>\n" + "\n".join(body) + "\n</body>\n</html>\n"
    )


def heading(text: str, anchor: str = "") -> str:
    """Make a heading, which links can name by its anchor."""
    mark = f' id="{_shown(anchor)}"' if anchor else ""
    return f"<h2{mark}>{_shown(text)}</h2>"


def paragraph(text: str) -> str:
    """Make a paragraph of plain text."""
    return f"<p>{_shown(text)}</p>"


def link(text: str, target: str) -> Markup:
    """Make a link; a text in `Markup`, such as a picture, can be one, too."""
    return Markup(f'<a href="{_shown(target)}">{_shown(text)}</a>')


def picture(png: bytes, described: str) -> str:
    """Put a picture into the page itself.

    Parameters
    ----------
    png : bytes
        The picture.
    described : str
        What it shows, for those who do not see it.
    """
    data = b64encode(png).decode()
    return f'<p><img src="data:image/png;base64,{data}" alt="{_shown(described)}"></p>'


def picture_file(name: str, described: str) -> Markup:
    """Show a picture that lies beside the page."""
    return Markup(f'<img src="{_shown(name)}" alt="{_shown(described)}" loading="lazy">')


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Make a table of plain texts, or `Markup`.

    Parameters
    ----------
    header : sequence of str
        Names of the columns; empty for a table without.
    rows : iterable of sequence of str
        The cells.
    """

    def row(cells: Sequence[str], kind: str) -> str:
        return "<tr>" + "".join(f"<{kind}>{_shown(cell)}</{kind}>" for cell in cells) + "</tr>"

    head = [row(header, "th")] if header else []
    opened = "<table>" if header else '<table class="plain">'
    return "\n".join([opened, *head, *(row(cells, "td") for cells in rows), "</table>"])


def line(html: str) -> str:
    """Make a paragraph of HTML, such as links between words that are escaped."""
    return f"<p>{html}</p>"


def _shown(text: str) -> str:
    """Spell out what is not visible, and what HTML would take for its own."""
    if isinstance(text, Markup):
        return text
    return escape(printable(text))


def is_own_page(path: str) -> bool:
    """Whether a file is a page of this module, so that another may take its place."""
    mark = f'<meta name="generator" content="{GENERATOR} '.encode()
    try:
        with open(path, "rb") as file:
            return mark in file.read(_HEAD)
    except OSError:
        return False
