"""The page on a batch of files: what came of each, with a picture and a link to its own page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from urllib.parse import quote

import pcsmooth
from pcsmooth.plots.page import Markup, heading, link, page, paragraph, picture_file, table
from pcsmooth.printable import counted


@dataclass(frozen=True)
class FileOnPage:
    """What is said of a file.

    Attributes
    ----------
    name : str
        What it is called.
    outcome : str
        done, failed, skipped or not done.
    cells : tuple of str
        What was found.
    page, thumbnail : str
        Names of its own page and its picture, from the folder of the page on; empty if there are
        none.
    warnings : list of str
        What was warned of.
    failure : str
        Why it failed; empty if it did not.
    """

    name: str
    outcome: str
    cells: tuple[str, ...] = ()
    page: str = ""
    thumbnail: str = ""
    warnings: list[str] = field(default_factory=list)
    failure: str = ""


def batch_page(files: Sequence[FileOnPage], titles: Sequence[str], seconds: float) -> str:
    """Write the page.

    Parameters
    ----------
    files : sequence of FileOnPage
        The files, in their order.
    titles : sequence of str
        What the cells of each say.
    seconds : float
        Time that all took.

    Returns
    -------
    str
        HTML that needs no other file but those that it names.
    """
    counts = Counter(file.outcome for file in files)
    words = ", ".join(f"{count} {outcome}" for outcome, count in counts.items())
    return page(
        f"{counted(len(files), 'file')}, denoised",
        [
            paragraph(
                f"{words}, in {seconds:.1f} s. Lengths are in the unit of each file's coordinates. "
                f"pcsmooth {pcsmooth.__version__}."
            ),
            table(
                ["", "file", "outcome", *titles, "warnings"],
                ([*_row(file, len(titles))] for file in files),
            ),
            *_list("Errors", ([file.failure] for file in files)),
            *_list(
                "Warnings",
                ([f"{file.name}: {words}" for words in file.warnings] for file in files),
            ),
        ],
    )


def _row(file: FileOnPage, n_cells: int) -> Iterator[str]:
    target = _address(file.page)
    shown: str = ""
    if file.thumbnail:
        shown = picture_file(_address(file.thumbnail), f"{file.name}, denoised")
    yield link(shown, target) if shown and target else shown
    yield link(file.name, target) if target else file.name
    yield file.outcome
    yield from file.cells or [""] * n_cells
    yield str(len(file.warnings) or "")


def _address(path: str) -> str:
    """Spell a name for a link; it may have bytes that are no UTF-8."""
    return quote(path, errors="surrogateescape")


def _list(title: str, lines_of_files: Iterable[list[str]]) -> Iterator[Markup | str]:
    """Write lines under a heading, if there are any."""
    found = [line for lines in lines_of_files for line in lines if line]
    if found:
        yield heading(title)
        yield table([], ([line] for line in found))
