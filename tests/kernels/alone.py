"""Inner functions of kernels, as Python can call them."""

from __future__ import annotations

from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
from numba import njit
from numba.core.dispatcher import Dispatcher

from pcsmooth.kernels.cache import cache_of


def alone(function: Any) -> Any:
    """An inner function, compiled by itself; kept, like the kernels of its family."""
    *_, family, module = function.py_func.__module__.split(".")
    with cache_of(family, f"{module}.{function.py_func.__qualname__}"):
        return njit(cache=True, error_model="numpy")(function.py_func)


def all_alone(module: ModuleType) -> Any:
    """What a module of kernels has, its inner functions compiled by themselves."""
    return SimpleNamespace(
        **{
            name: alone(value) if isinstance(value, Dispatcher) else value
            for name, value in vars(module).items()
        }
    )


def let_python_call(module: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have what runs as Python, being no longer compiled, call the module's inner functions."""
    for name, value in list(vars(module).items()):
        if isinstance(value, Dispatcher):
            monkeypatch.setattr(module, name, alone(value))
