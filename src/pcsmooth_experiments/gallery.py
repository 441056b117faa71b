"""The gallery: experiments done, their numbers, their pictures, and a page that shows them."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from pcsmooth.errors import PcsmoothError
from pcsmooth.formats.atomic import atomic_write
from pcsmooth.formats.system_errors import named_system_errors
from pcsmooth.plots import page
from pcsmooth.plots.figures import png_of
from pcsmooth_experiments.experiment import Experiment, Inputs, Outcome, Table

#: The page that shows them all.
INDEX = "index.html"

_TITLE = "The experiments of the thesis, done again"


@dataclass(frozen=True)
class Finished:
    """An experiment that came to its end.

    Attributes
    ----------
    experiment : Experiment
        Which.
    outcome : Outcome or None
        What it found; None if it failed.
    failure : str
        Why it failed, in one line; empty if it did not.
    """

    experiment: Experiment
    outcome: Outcome | None
    failure: str = ""

    @property
    def verdict(self) -> str:
        """How it compares with the thesis, or that it failed."""
        return "failed" if self.outcome is None else self.outcome.verdict

    @property
    def summary(self) -> str:
        """The caption, or why there is none."""
        return self.failure if self.outcome is None else self.outcome.caption


def write_gallery(
    experiments: Sequence[Experiment],
    inputs: Inputs,
    folder: Path,
    on_finished: Callable[[Finished], None] = lambda _: None,
) -> list[Finished]:
    """Do experiments and write what they found; one that fails does not keep the others.

    Parameters
    ----------
    experiments : sequence of Experiment
        Which, in the order of the page.
    inputs : Inputs
        The thesis' clouds.
    folder : Path
        Where to write NAME.png of each, a CSV file of each table and `INDEX`; made if it is not
        there. Every file is replaced as a whole or not at all, and the same input makes the same
        bytes.
    on_finished : callable, optional
        Called after each experiment, when its files are written.

    Returns
    -------
    list of Finished
        In the order of the experiments.

    Raises
    ------
    CloudFileError
        If a file cannot be written.
    """
    with named_system_errors(str(folder)):
        folder.mkdir(parents=True, exist_ok=True)
    gallery = []
    written: set[str] = set()
    for experiment in experiments:
        finished, files = _do(experiment, inputs)
        taken = sorted(written & files.keys())
        if taken:
            cause = f"{', '.join(taken)}: written by an experiment before it"
            finished, files = Finished(experiment, None, cause), {}
        for name, content in files.items():
            _write(folder / name, content)
        written |= files.keys()
        gallery.append(finished)
        on_finished(finished)
    _write(folder / INDEX, index_page(gallery).encode())
    return gallery


def index_page(gallery: Sequence[Finished]) -> str:
    """Make the page of a gallery: a table of all verdicts, then a section for each experiment."""
    verdicts = Counter(finished.verdict for finished in gallery)
    counted = ", ".join(f"{count} {verdict}" for verdict, count in verdicts.items())
    return page.page(_TITLE, [
        page.paragraph(f"Verdicts follow from the numbers. {len(gallery)} experiments: {counted}."),
        page.table(
            ["experiment", "place in the thesis", "what is looked at", "verdict"],
            [[done.experiment.name, done.experiment.place, done.experiment.title, done.verdict]
             for done in gallery],
        ),
        page.line(_joined(
            page.link(done.experiment.name, f"#{done.experiment.name}") for done in gallery
        )),
        *(part for finished in gallery for part in _section(finished)),
    ])  # fmt: skip


def table_csv(columns: Table) -> bytes:
    """Write columns as CSV (RFC 4180) with a header, numbers to the last digit.

    Raises
    ------
    ValueError
        If the columns are not of one length.
    """
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(columns)
    writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))
    return text.getvalue().encode()


def _do(experiment: Experiment, inputs: Inputs) -> tuple[Finished, dict[str, bytes]]:
    """Do one experiment; whatever goes wrong in it is its failure alone."""
    try:
        outcome = experiment.run(inputs)
        files = {_picture_name(experiment): png_of(outcome.draw())}
        files |= {f"{name}.csv": table_csv(table) for name, table in outcome.tables.items()}
    except PcsmoothError as error:
        return Finished(experiment, None, _one_line(str(error))), {}
    except Exception as error:
        return Finished(experiment, None, _one_line(f"{type(error).__name__}: {error}")), {}
    return Finished(experiment, outcome), files


def _section(finished: Finished) -> Iterator[str]:
    """Make the part of the page about one experiment."""
    experiment, outcome = finished.experiment, finished.outcome
    yield page.heading(f"{experiment.name}: {experiment.title}", experiment.name)
    yield page.paragraph(f"{experiment.place}; {finished.verdict}.")
    if outcome is None:
        yield page.paragraph(finished.failure)
        return
    described = f"{experiment.title}, {experiment.place}"
    yield page.line(page.picture_file(_picture_name(experiment), described))
    yield page.paragraph(outcome.caption)
    if outcome.explanation:
        yield page.paragraph(outcome.explanation)
    if outcome.tables:
        names = [f"{name}.csv" for name in outcome.tables]
        yield page.line("Numbers: " + _joined(page.link(name, name) for name in names))


def _picture_name(experiment: Experiment) -> str:
    return f"{experiment.name}.png"


def _joined(links: Iterator[str]) -> str:
    return ", ".join(links)


def _one_line(text: str) -> str:
    return " ".join(text.split())


def _write(path: Path, content: bytes) -> None:
    with named_system_errors(str(path)), atomic_write(str(path)) as file:
        file.write(content)
