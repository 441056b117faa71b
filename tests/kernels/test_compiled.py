"""Kernels as they are declared, compiled, kept and shared."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, get_args

import numba
import numpy as np
import pytest
from numba import types

import pcsmooth.kernels
from pcsmooth.energies.protocol import UnionName
from pcsmooth.kernels import cache, claims
from pcsmooth.kernels.ahead import usual_kernels
from pcsmooth.kernels.compiled import KERNELS, Kernel, _parse, inner, kernel, on_compilation

EDGE = np.dtype([("weight", np.float64), ("sign", np.int8)])

MODULES = [
    f"pcsmooth.kernels.{path.parent.name}.{path.stem}"
    for path in sorted(Path(pcsmooth.kernels.__path__[0]).glob("*/*.py"))
    if path.stem != "__init__"
]


def c_array(element: Any, axes: int) -> Any:
    return types.Array(element, axes, "C")


@pytest.mark.parametrize(
    ("signature", "expected"),
    [
        ("", ()),
        ("f i", (types.float64, types.int64)),
        ("b j s z", (types.boolean, types.int32, types.int8, types.complex128)),
        ("f2 i1", (c_array(types.float64, 2), c_array(types.int64, 1))),
        ("f2~", (types.Array(types.float64, 2, "A"),)),
        (
            "(f2 i) i",
            (types.Tuple((c_array(types.float64, 2), types.int64)), types.int64),
        ),
        ("edge1", (c_array(numba.from_dtype(EDGE), 1),)),
    ],
)
def test_signatures_are_words(signature: str, expected: tuple[Any, ...]) -> None:
    assert _parse(signature, {"edge": EDGE}) == expected


@inner
def _half(x):  # type: ignore[no-untyped-def]
    return x / 2.0


@inner
def _quarter(x):  # type: ignore[no-untyped-def]
    return _half(_half(x))


@inner
def _longer(array, count):  # type: ignore[no-untyped-def]
    """Return an argument, or another array in its place."""
    if array.size >= count:
        return array
    array = np.zeros(count)
    return array


@inner
def _first_of(array):  # type: ignore[no-untyped-def]
    """Let go of an argument early."""
    value = array[0]
    array = np.full(3, value)
    return array[1]


def test_arguments_are_borrowed_and_what_is_returned_is_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def build(array, rounds):  # type: ignore[no-untyped-def]
        longest = array
        total = 0.0
        for count in range(1, rounds):
            longest = _longer(longest, count)
            again = _longer(longest, 1)
            again[count - 1] = count
            total += _first_of(again) + _first_of(np.full(2, 0.5))
        return longest, array, total

    build.__module__ = "pcsmooth.kernels.grid.building"
    monkeypatch.setitem(sys.modules, build.__module__, ModuleType(build.__module__))
    for module in (cache, claims):
        monkeypatch.setattr(module, "folder_of", lambda _family: tmp_path)
    runtime: Any = import_module("numba.core.runtime")
    declared = kernel("f1 i")(build)
    del KERNELS["grid", declared.name]
    declared.name = "test_compiled.building.locals.build"
    array = np.arange(4.0)
    declared(array, 1)
    references = sys.getrefcount(array)
    runtime._nrt_python.memsys_enable_stats()
    before = runtime.rtsys.get_allocation_stats()
    for rounds in (4, 50):
        longest, same, total = declared(array, rounds)
        assert same is array
        assert (longest is array) == (rounds == 4)
        assert len(longest) == max(4, rounds - 1)
        assert longest[rounds - 2] == rounds - 1
        expected = 1.5 * 4 + 0.5 * (rounds - 5) if rounds == 50 else 1.5 * 3
        assert total == pytest.approx(expected)
        del longest, same
        assert sys.getrefcount(array) == references
    after = runtime.rtsys.get_allocation_stats()
    runtime._nrt_python.memsys_disable_stats()
    assert after.alloc - before.alloc == after.free - before.free
    assert after.alloc > before.alloc


@pytest.fixture
def halving(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Kernel:
    """A kernel whose inner functions call each other."""

    def halve(array):  # type: ignore[no-untyped-def]
        for i in range(array.size):
            array[i] = _half(array[i]) + _quarter(array[i])

    halve.__module__ = "pcsmooth.kernels.grid.halving"
    monkeypatch.setitem(sys.modules, halve.__module__, ModuleType(halve.__module__))
    for module in (cache, claims):
        monkeypatch.setattr(module, "folder_of", lambda _family: tmp_path)
    declared = kernel("f1", "f1~")(halve)
    del KERNELS["grid", declared.name]
    declared.name = "test_compiled.halving.locals.halve"  # as numba calls its files
    return declared


def test_inner_functions_become_part_of_a_kernel(halving: Kernel) -> None:
    array = np.arange(8.0)
    halving(array)
    np.testing.assert_array_equal(array, np.arange(8.0) * 0.75)
    assert halving.compiled_for == [(c_array(types.float64, 1),)]
    every_second = np.arange(8.0)
    halving(every_second[::2])
    np.testing.assert_array_equal(every_second[::2], np.arange(0.0, 8.0, 2.0) * 0.75)
    np.testing.assert_array_equal(every_second[1::2], np.arange(1.0, 8.0, 2.0))


def test_a_kernel_that_cannot_be_kept_runs(
    halving: Kernel, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_arguments: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(halving._compiled._cache, "save_overload", fail)
    array = np.arange(8.0)
    halving(array)
    np.testing.assert_array_equal(array, np.arange(8.0) * 0.75)
    strided = np.arange(8.0)  # for which it is compiled only now
    halving(strided[::2])
    np.testing.assert_array_equal(strided[::2], np.arange(0.0, 8.0, 2.0) * 0.75)


def test_it_is_told_which_is_compiled_and_not_which_is_loaded(halving: Kernel) -> None:
    told: list[Kernel] = []
    with on_compilation(told.append):
        halving.make_ready(for_all=True)
        assert len(halving.compiled_for) == 2
        halving.make_ready(for_all=True)
    assert told == [halving]
    halving(np.ones(3))


@pytest.mark.parametrize("module", MODULES)
def test_every_kernel_has_signatures_for_its_arguments(module: str) -> None:
    import_module(module)
    for each in KERNELS.values():
        if each.py_func.__module__ == module:
            assert each.signatures
            assert len(set(each.signatures)) == len(each.signatures)
            for signature in each.signatures:
                assert len(signature) == each.py_func.__code__.co_argcount


PROGRAM = """
import json, sys
import numpy as np
import pcsmooth
from pcsmooth.kernels.compiled import KERNELS

points = np.random.default_rng(0).normal(size=(1000, 3))
points /= np.linalg.norm(points, axis=1, keepdims=True)
points *= np.random.default_rng(1).normal(1.0, 0.02, (1000, 1))
options = {"polyhedron": pcsmooth.load_presets()["cube"]} if sys.argv[1:] else {}
pcsmooth.denoise(points, **options, **{"union": union for union in sys.argv[1:]})
used = {"/".join(name): len(each.compiled_for) for name, each in KERNELS.items()}
print(json.dumps({name: count for name, count in used.items() if count}))
"""


@pytest.mark.slow
@pytest.mark.parametrize("union", [None, *get_args(UnionName)])
def test_the_usual_kernels_are_those_that_a_usual_run_needs(union: UnionName | None) -> None:
    """And each of them is compiled for one kind of arguments."""
    command = [sys.executable, "-c", PROGRAM, *([union] if union else [])]
    done = subprocess.run(command, capture_output=True, check=True)
    assert json.loads(done.stdout) == dict.fromkeys(usual_kernels(union), 1)


def test_without_a_compiler_they_are_plain_functions() -> None:
    program = (
        "import numpy as np; from pcsmooth.kernels.grid.grid import bounding_box; "
        "from pcsmooth.kernels.compiled import KERNELS; "
        "[each.make_ready() for each in KERNELS.values()]; "
        "print(*np.concatenate(bounding_box(np.array([[1.0, 5.0], [3.0, 2.0]]))))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, check=True,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
    )  # fmt: skip
    assert done.stdout.split() == [b"1.0", b"2.0", b"2.0", b"3.0", b"5.0", b"5.0"]
