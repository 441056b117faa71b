"""The gallery: files, page, the same bytes twice, and experiments that fail."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from experiments.galleries import PLANE, made_up, plane_experiments, read_page
from experiments.thesis_clouds import INPUTS
from pcsmooth.errors import CloudFileError, InvalidInputError
from pcsmooth_experiments.catalogue import EXPERIMENTS
from pcsmooth_experiments.experiment import Experiment, Inputs
from pcsmooth_experiments.gallery import Finished, table_csv, write_gallery

if TYPE_CHECKING:
    from matplotlib.figure import Figure

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Finished]]:
    folder = tmp_path_factory.mktemp("gallery") / "made" / "for it"
    return folder, write_gallery(plane_experiments(), INPUTS, folder)


def test_the_catalogue() -> None:
    names = [experiment.name for experiment in EXPERIMENTS]
    assert len(set(names)) == len(names)
    assert [name for name in names if name in PLANE] == list(PLANE)
    for experiment in EXPERIMENTS:
        assert experiment.name == experiment.name.lower().replace("_", "-").replace(" ", "-")
        assert experiment.title
        assert experiment.place


def test_no_experiment_fails(written: tuple[Path, list[Finished]]) -> None:
    _, gallery = written
    assert [finished.experiment.name for finished in gallery] == list(PLANE)
    assert [finished.failure for finished in gallery] == [""] * len(PLANE)


def test_every_experiment_has_a_section(written: tuple[Path, list[Finished]]) -> None:
    folder, gallery = written
    sections = read_page(folder).by_anchor
    assert list(sections) == list(PLANE)
    for finished in gallery:
        section, outcome = sections[finished.experiment.name], finished.outcome
        assert outcome is not None
        assert finished.experiment.title in section.title
        ((source, described),) = section.images
        assert source == f"{finished.experiment.name}.png"
        assert len(described) > 20
        place, _, caption = section.paragraphs[:3]
        assert place == f"{finished.experiment.place}; {outcome.verdict}."
        assert caption == outcome.caption
        if outcome.explanation:
            assert outcome.explanation in section.paragraphs[3]
        assert section.links == [f"{name}.csv" for name in outcome.tables] != []


def test_captions_are_one_line_with_numbers(written: tuple[Path, list[Finished]]) -> None:
    _, gallery = written
    assert len(gallery) == len(PLANE)
    for finished in gallery:
        caption = finished.summary
        assert caption.splitlines() == [caption]
        assert 40 < len(caption) <= 200
        assert sum(character.isdigit() for character in caption) >= 4
        assert caption.endswith(".")


def test_what_disagrees_is_explained(written: tuple[Path, list[Finished]]) -> None:
    _, gallery = written
    partly = [f.outcome for f in gallery if f.outcome and f.outcome.verdict != "agrees"]
    assert len(partly) >= 3
    assert all(len(outcome.explanation) > 100 for outcome in partly)


def test_the_table_on_top(written: tuple[Path, list[Finished]]) -> None:
    folder, gallery = written
    top = read_page(folder).sections[0]
    head, *rows = top.cells
    assert head == ["experiment", "place in the thesis", "what is looked at", "verdict"]
    assert rows == [
        [f.experiment.name, f.experiment.place, f.experiment.title, f.verdict] for f in gallery
    ]
    assert top.links == [f"#{name}" for name in PLANE]
    counts = {verdict: [row[3] for row in rows].count(verdict) for _, _, _, verdict in rows}
    for verdict, count in counts.items():
        assert f"{count} {verdict}" in top.paragraphs[0]


def test_files_are_those_that_the_page_names(written: tuple[Path, list[Finished]]) -> None:
    folder, _ = written
    named = ["index.html"]
    for section in read_page(folder).by_anchor.values():
        named += [source for source, _ in section.images] + section.links
    assert sorted(path.name for path in folder.iterdir()) == sorted(named)  # each but once
    for path in folder.glob("*.png"):
        data = path.read_bytes()
        assert data.startswith(b"\x89PNG\r\n\x1a\n")
        width, height = (int.from_bytes(data[at : at + 4], "big") for at in (16, 20))
        assert 500 < width < 1600
        assert 300 < height < 1700


def test_tables_read_back_to_the_last_digit(written: tuple[Path, list[Finished]]) -> None:
    folder, gallery = written
    compared = 0
    for finished in gallery:
        assert finished.outcome is not None
        for name, table in finished.outcome.tables.items():
            with (folder / f"{name}.csv").open(newline="", encoding="utf-8") as file:
                head, *rows = csv.reader(file)
            assert head == list(table)
            for column, texts in zip(table.values(), zip(*rows, strict=True), strict=True):
                back = np.array(texts).astype(column.dtype)
                np.testing.assert_array_equal(back, column)
                compared += len(back)
    assert compared > 1000


def test_the_same_bytes_again(written: tuple[Path, list[Finished]], tmp_path: Path) -> None:
    folder, _ = written
    write_gallery(plane_experiments(), INPUTS, tmp_path)
    names = sorted(path.name for path in folder.iterdir())
    assert sorted(path.name for path in tmp_path.iterdir()) == names
    assert len(names) > 20
    for name in names:
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes(), name


def test_csv_quotes_by_rfc_4180() -> None:
    table = {"a, b": np.array(['say "x"', "two\nlines", "ä"]), "x": np.array([0.1, -0.0, 1e300])}
    assert (
        table_csv(table)
        == ('"a, b",x\r\n"say ""x""",0.1\r\n"two\nlines",-0.0\r\nä,1e+300\r\n').encode()
    )


def test_columns_of_different_lengths() -> None:
    with pytest.raises(ValueError, match="zip"):
        table_csv({"x": np.zeros(2), "y": np.zeros(3)})


def broken_drawing() -> Figure:
    raise ArithmeticError("no ink")


FAILURES = {
    "on purpose": (made_up("bad", failure=InvalidInputError("no points;\n give some")),
                   "no points; give some"),
    "cloud": (made_up("bad", failure=CloudFileError("a.xy", "gone", "look")), "a.xy: gone; look"),
    "by mistake": (made_up("bad", failure=ZeroDivisionError("by\nzero")),
                   "ZeroDivisionError: by zero"),
    "drawing": (made_up("bad", draw=broken_drawing), "ArithmeticError: no ink"),
    "table": (made_up("bad", tables={"t": {"x": np.zeros(2), "y": np.zeros(3)}}), "ValueError: "),
}  # fmt: skip


@pytest.mark.parametrize(("bad", "message"), FAILURES.values(), ids=FAILURES)
def test_one_failure_does_not_lose_the_others(
    tmp_path: Path, bad: Experiment, message: str
) -> None:
    told: list[Finished] = []
    gallery = write_gallery([made_up("first"), bad, made_up("last")], INPUTS, tmp_path, told.append)
    assert told == gallery
    assert [finished.verdict for finished in gallery] == ["agrees", "failed", "agrees"]
    assert message in gallery[1].failure
    assert gallery[1].summary.splitlines() == [gallery[1].failure]
    names = ["first.png", "index.html", "last.png", "t_first.csv", "t_last.csv"]
    assert sorted(path.name for path in tmp_path.iterdir()) == names
    sections = read_page(tmp_path).by_anchor
    assert list(sections) == ["first", "bad", "last"]
    assert sections["bad"].images == []
    assert message in sections["bad"].paragraphs[1]
    assert "1 failed" in read_page(tmp_path).sections[0].paragraphs[0]


def test_no_experiment_overwrites_another_s_numbers(tmp_path: Path) -> None:
    same = {"numbers": {"x": np.array([2.0])}}
    experiments = [made_up("a", tables={"numbers": {"x": np.ones(1)}}), made_up("b", tables=same)]
    _, second = write_gallery(experiments, INPUTS, tmp_path)
    assert second.failure == "numbers.csv: written by an experiment before it"
    assert (tmp_path / "numbers.csv").read_text() == "x\n1.0\n"
    assert not (tmp_path / "b.png").exists()


def test_files_are_written_as_each_experiment_ends(tmp_path: Path) -> None:
    seen: list[list[str]] = []

    def look(_: Finished) -> None:
        seen.append(sorted(path.name for path in tmp_path.iterdir()))

    write_gallery([made_up("a"), made_up("b")], INPUTS, tmp_path, look)
    assert seen == [["a.png", "t_a.csv"], ["a.png", "b.png", "t_a.csv", "t_b.csv"]]


def test_an_interrupt_is_no_failure_of_the_experiment(tmp_path: Path) -> None:
    interrupted = made_up("x", failure=KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt):
        write_gallery([interrupted], INPUTS, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_texts_are_escaped(tmp_path: Path) -> None:
    caption, explanation = "1 < 2 & <b>not bold</b>.", '"quoted" <script>'
    write_gallery([made_up("x", caption=caption, explanation=explanation)], INPUTS, tmp_path)
    section = read_page(tmp_path).by_anchor["x"]
    assert caption in section.paragraphs
    assert explanation in section.paragraphs
    assert "<b>" not in (tmp_path / "index.html").read_text()


def test_no_folder_can_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("here")
    with pytest.raises(CloudFileError, match="file"):
        write_gallery([made_up("x")], INPUTS, tmp_path / "file" / "below")
    assert (tmp_path / "file").read_text() == "here"


def test_a_file_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "x.png").mkdir()
    with pytest.raises(CloudFileError, match=r"x\.png"):
        write_gallery([made_up("x")], INPUTS, tmp_path)


@pytest.mark.parametrize("name", PLANE)
def test_clouds_that_are_missing_are_named(tmp_path: Path, name: str) -> None:
    (experiment,) = (e for e in EXPERIMENTS if e.name == name)
    if name in ("ellipse-curvature", "ellipse-flows"):  # these make their points
        assert experiment.run(Inputs(tmp_path)).caption
        return
    with pytest.raises(CloudFileError, match=r"\.xy: it is not there; name the folder"):
        experiment.run(Inputs(tmp_path))
