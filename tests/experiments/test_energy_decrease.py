"""Energies along the flows, digit by digit beside the author's log."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from experiments.thesis_clouds import INPUTS, REPORT
from pcsmooth.errors import CloudFileError
from pcsmooth_experiments.experiment import Inputs, Outcome
from pcsmooth_experiments.plane.energy_decrease import EXPERIMENT


@pytest.fixture(scope="module")
def outcome() -> Outcome:
    return EXPERIMENT.run(INPUTS)


def test_every_digit_of_the_log_comes_out(outcome: Outcome) -> None:
    printed = (REPORT / "perimeter-dense.log").read_text().split()
    assert len(printed) == 60
    table = outcome.tables["energy-log"]
    assert [f"{perimeter:.6g}" for perimeter in table["perimeter"].tolist()] == printed
    logged = np.array([float(word) for word in printed])
    np.testing.assert_array_equal(table["logged_perimeter"], logged)
    relative = np.abs(table["perimeter"] - logged) / logged
    np.testing.assert_allclose(table["relative_difference"], relative, rtol=1e-6)
    assert 0 < relative.max() < 1e-5
    assert f"within {relative.max():.1e}" in outcome.caption


def test_the_area_falls_from_what_a_grid_counts(outcome: Outcome) -> None:
    square = INPUTS.points("square.xy")
    axis = np.arange(-130, 130, 0.5) + 0.25
    grid = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    inside = np.zeros(len(grid), bool)
    for point in square:
        inside |= np.hypot(*(grid - point).T) <= 30
    table = outcome.tables["energy-decrease"]
    assert table["square_area"][0] == pytest.approx(inside.sum() / 4, rel=1e-3)
    for name in ("square_area", "ellipse_area"):
        assert len(table[name]) == 101
        assert np.all(np.diff(table[name]) <= 0)
    assert outcome.verdict == "agrees"


def copy_of_inputs(folder: Path) -> Path:
    for name in ("square.xy", "ellipse-noisy-dense.xy", "perimeter-dense.log"):
        shutil.copy(REPORT / name, folder)
    return folder


def test_another_log_disagrees(tmp_path: Path) -> None:
    log = copy_of_inputs(tmp_path) / "perimeter-dense.log"
    log.unlink()
    log.write_text("2135.02\n2072.0\n2036.45\n")
    outcome = EXPERIMENT.run(Inputs(tmp_path))
    assert outcome.verdict == "agrees in part"
    assert outcome.tables["energy-log"]["iteration"].tolist() == [0, 1, 2]


def test_no_log(tmp_path: Path) -> None:
    (copy_of_inputs(tmp_path) / "perimeter-dense.log").unlink()
    with pytest.raises(CloudFileError, match=r"perimeter-dense\.log: it is not there"):
        EXPERIMENT.run(Inputs(tmp_path))


@pytest.mark.parametrize("text", ["2135.02\nlots\n", "", "2135.02\nnan\n"], ids=repr)
def test_no_numbers_in_the_log(tmp_path: Path, text: str) -> None:
    log = copy_of_inputs(tmp_path) / "perimeter-dense.log"
    log.unlink()
    log.write_text(text)
    with pytest.raises(CloudFileError, match="is no list of energies"):
        EXPERIMENT.run(Inputs(tmp_path))
