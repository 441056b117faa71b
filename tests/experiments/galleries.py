"""Pages read back, and experiments that are none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pcsmooth.plots.figures import new_figure
from pcsmooth_experiments.catalogue import EXPERIMENTS
from pcsmooth_experiments.experiment import Experiment, Inputs, Outcome, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: The experiments of the thesis' second chapter.
PLANE = (
    "gradients-2d",
    "ellipse-curvature",
    "ellipse-flows",
    "corners",
    "outliers",
    "noise",
    "spacing",
    "oscillations",
    "segment",
    "energy-decrease",
)


def plane_experiments() -> list[Experiment]:
    return [experiment for experiment in EXPERIMENTS if experiment.name in PLANE]


@dataclass
class Section:
    """What is between two headings of a page."""

    anchor: str
    title: str = ""
    images: list[tuple[str, str]] = field(default_factory=list)
    links: list[str] = field(default_factory=list)
    paragraphs: list[str] = field(default_factory=list)
    cells: list[list[str]] = field(default_factory=list)


class Page(HTMLParser):
    """A page by its second-level headings; what comes before the first has no anchor."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.sections = [Section("")]
        self._text: list[str] = []
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = {name: value or "" for name, value in attrs}
        if tag == "h2":
            self.sections.append(Section(values["id"]))
        elif tag == "img":
            self.sections[-1].images.append((values["src"], values["alt"]))
        elif tag == "a":
            self.sections[-1].links.append(values["href"])
        elif tag == "tr":
            self.sections[-1].cells.append([])
        if tag in ("h2", "p", "td", "th"):
            self._text = []

    def handle_data(self, data: str) -> None:
        self._text.append(data)

    def handle_endtag(self, tag: str) -> None:
        text = "".join(self._text)
        if tag == "h2":
            self.sections[-1].title = text
        elif tag == "p":
            self.sections[-1].paragraphs.append(text)
        elif tag in ("td", "th"):
            self.sections[-1].cells[-1].append(text)

    @property
    def by_anchor(self) -> dict[str, Section]:
        return {section.anchor: section for section in self.sections[1:]}


def read_page(folder: Path) -> Page:
    return Page((folder / "index.html").read_text(encoding="utf-8"))


def blank() -> Figure:
    return new_figure(1.0, 1.0)


def made_up(
    name: str,
    *,
    tables: dict[str, Table] | None = None,
    caption: str = "Nothing: as reported.",
    explanation: str = "",
    draw: Callable[[], Figure] = blank,
    failure: BaseException | None = None,
) -> Experiment:
    """Make an experiment that finds what it is told, or fails."""

    def run(_: Inputs) -> Outcome:
        if failure is not None:
            raise failure
        return Outcome("agrees", caption, draw, tables or {"t_" + name: numbers()}, explanation)

    return Experiment(name, "nowhere", f"About {name}", run)


def numbers() -> Table:
    return {"x": np.array([0.1, 1 / 3, -0.0]), "n": np.array([1, 2, 3])}
