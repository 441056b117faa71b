"""What kernels are compiled for."""

from __future__ import annotations

import os
import subprocess
import sys

import numba
import pytest
from llvmlite import binding

from pcsmooth.kernels import level

FEATURES = {name: True for needed in level._LEVELS.values() for name in needed}


@pytest.fixture(autouse=True)
def _as_before(monkeypatch: pytest.MonkeyPatch) -> None:
    settings = vars(numba.config)
    monkeypatch.setattr(numba.config, "CPU_NAME", settings["CPU_NAME"])
    monkeypatch.setattr(numba.config, "CPU_FEATURES", settings["CPU_FEATURES"])


def compiled_for(before: str = "", **environment: str) -> str:
    """What a process with an environment compiles for, and with which features."""
    program = (
        f"{before}\nimport numba; from pcsmooth.kernels.level import COMPILED_FOR; "
        "print(COMPILED_FOR, repr(numba.config.CPU_FEATURES))"
    )
    inherited = {k: v for k, v in os.environ.items() if not k.startswith("NUMBA_CPU")}
    done = subprocess.run(
        [sys.executable, "-c", program], env={**inherited, **environment},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return done.stdout.strip()


@pytest.mark.parametrize(
    ("missing", "reached"),
    [
        ("", "x86-64-v4"),
        ("avx512vl", "x86-64-v3"),
        ("fma", "x86-64-v2"),
        ("sse4.2", "x86-64"),
    ],
)
def test_the_level_is_the_highest_that_a_processor_reaches(
    monkeypatch: pytest.MonkeyPatch, missing: str, reached: str
) -> None:
    monkeypatch.setattr(binding, "get_process_triple", lambda: "x86_64-unknown-linux-gnu")
    monkeypatch.setattr(binding, "get_host_cpu_features", lambda: {**FEATURES, missing: False})
    assert level.processor_level() == reached


def test_others_have_one_level(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(binding, "get_process_triple", lambda: "aarch64-unknown-linux-gnu")
    assert level.processor_level() == "generic"


def test_kernels_are_compiled_for_the_level() -> None:
    assert compiled_for() == f"{level.processor_level()} ''"


@pytest.mark.slow
def test_the_users_choice_is_heeded() -> None:
    assert compiled_for(NUMBA_CPU_NAME="x86-64-v2") == "x86-64-v2 ''"
    assert compiled_for(NUMBA_CPU_NAME="x86-64", NUMBA_CPU_FEATURES="+sse3") == "x86-64 '+sse3'"
    assert compiled_for(NUMBA_CPU_NAME="znver3") == "znver3 None"


def test_a_level_that_the_processor_does_not_reach_is_not_taken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(binding, "get_process_triple", lambda: "x86_64-unknown-linux-gnu")
    monkeypatch.setattr(binding, "get_host_cpu_features", lambda: {**FEATURES, "fma": False})
    for chosen, taken in (("x86-64-v3", "x86-64-v2"), ("x86-64", "x86-64")):
        monkeypatch.setattr(numba.config, "CPU_NAME", chosen)
        assert level._compile_for_level() == taken
    monkeypatch.setattr(binding, "get_process_triple", lambda: "aarch64-unknown-linux-gnu")
    monkeypatch.setattr(numba.config, "CPU_NAME", "x86-64-v3")
    assert level._compile_for_level() == "generic"


@pytest.mark.slow
def test_what_has_been_compiled_before_decides() -> None:
    before = "import numba; numba.njit(lambda: 0)()"
    assert compiled_for(before) == f"{binding.get_host_cpu_name()} None"
