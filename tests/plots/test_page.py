from __future__ import annotations

from pcsmooth.plots.page import (
    heading,
    link,
    page,
    paragraph,
    picture,
    picture_file,
    table,
)
from plots.pages import read_page

WILD = """<b>"a" & 'b'</b>"""


def test_text_is_text_wherever_it_stands() -> None:
    html = page(
        WILD,
        [heading(WILD, 'an"chor'), paragraph(WILD), table([WILD], [[WILD, "1"]]), link(WILD, WILD)],
    )
    read = read_page(html)
    assert read.headings == [WILD, WILD]
    assert read.rows == [[WILD], [WILD, "1"]]
    assert read.links == [WILD]
    assert read.text.count(WILD) == 3  # title, paragraph, link


def test_pictures_are_in_the_page() -> None:
    read = read_page(page("t", [picture(b"\x89PNG\0", WILD)]))
    assert (read.pictures, read.described, read.links) == ([b"\x89PNG\0"], [WILD], [])


def test_a_picture_beside_the_page_is_linked() -> None:
    assert read_page(page("t", [picture_file("a&b.png", "c")])).links == ["a&b.png"]


def test_a_table_may_have_no_header() -> None:
    assert read_page(page("t", [table([], [["a", "b"]])])).rows == [["a", "b"]]
