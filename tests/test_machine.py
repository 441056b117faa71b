import os
from pathlib import Path

import pytest

from pcsmooth import machine


def test_memory_is_that_of_the_machine() -> None:
    assert 2**26 < machine.memory() < 2**50


@pytest.mark.parametrize("text", ["123456789", "max"])
def test_memory_of_a_container(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    unlimited = machine.memory()
    limit = tmp_path / "memory.max"
    limit.write_text(text + "\n")
    monkeypatch.setattr(machine, "_CONTAINER_LIMIT", str(limit))
    assert machine.memory() == (123456789 if text != "max" else unlimited)


def test_cores_are_those_that_may_be_used(monkeypatch: pytest.MonkeyPatch) -> None:
    assert 1 <= machine.cores() <= (os.cpu_count() or 1)
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert machine.cores() == 1
