"""Processes are no more than the machine has room for, and that is said."""

import pytest

from pcsmooth import machine
from pcsmooth.process_count import fitting_processes

GIGABYTE = 1_000_000_000


@pytest.fixture(autouse=True)
def _machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine, "cores", lambda: 8)
    monkeypatch.setattr(machine, "memory", lambda: 10 * GIGABYTE)


@pytest.mark.parametrize(
    ("wanted", "memory", "count", "told"),
    [
        (3, 0, 3, []),
        (8, 0, 8, []),
        (10_000, 0, 8, ["--jobs 10000: 8 at a time, as many as there are cores"]),
        (8, GIGABYTE, 4, ["--jobs 8: 4 at a time, as memory allows"]),
        (2, 100 * GIGABYTE, 1, ["--jobs 2: 1 at a time, as memory allows"]),
        (1, 100 * GIGABYTE, 1, []),
    ],
)
def test_processes_fit(wanted: int, memory: int, count: int, told: list[str]) -> None:
    said: list[str] = []
    assert fitting_processes("--jobs", wanted, memory, said.append) == count
    assert said == told
