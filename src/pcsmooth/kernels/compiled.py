"""How kernels are declared, and when they are compiled."""

import os
import re
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import update_wrapper
from typing import Any

import numba
import numpy as np
from numba import njit, types
from numba.core.dispatcher import Dispatcher

from pcsmooth.kernels.cache import cache_of, is_kept
from pcsmooth.kernels.claims import claimed
from pcsmooth.kernels.inner_functions import InnerCompiler, KernelCompiler

#: All kernels of the modules that have been imported, by family and name.
KERNELS: dict[tuple[str, str], "Kernel"] = {}

_COMMON = {"error_model": "numpy", "no_cfunc_wrapper": True}

_compiling = threading.RLock()


def _forget_lock() -> None:
    global _compiling
    _compiling = threading.RLock()  # in a forked process nobody would release it


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_lock)

_listeners: list[Callable[["Kernel"], None]] = []

#: Types by the letters that signatures have for them.
_TYPES = {
    "f": types.float64,
    "z": types.complex128,
    "i": types.int64,
    "j": types.int32,
    "s": types.int8,
    "b": types.boolean,
    "n": types.none,
}


class Kernel:
    """A compiled function that Python calls; it releases the GIL.

    Compiled when it is first called, or loaded from the cache; of processes that need it at the
    same time one compiles it, and the others wait.

    Parameters
    ----------
    function : callable
        What is compiled.
    signatures : sequence of tuple of numba types
        Types of the arguments, the usual ones first: for these it is made ready at once. It is
        compiled for others when it gets them.
    """

    def __init__(
        self, function: Callable[..., Any], signatures: Sequence[tuple[types.Type, ...]]
    ) -> None:
        self.family = function.__module__.rsplit(".", 2)[1]
        self.name = f"{function.__module__.rsplit('.', 1)[1]}.{function.__qualname__}"
        self.signatures = signatures
        update_wrapper(self, function)
        self.py_func = function
        with cache_of(self.family, self.name, len(signatures)):
            self._compiled = njit(cache=True, nogil=True, pipeline_class=KernelCompiler, **_COMMON)(
                function
            )
        self._is_ready = not isinstance(self._compiled, Dispatcher)  # NUMBA_DISABLE_JIT is set
        KERNELS[self.family, self.name] = self

    def __call__(self, *arguments: Any) -> Any:
        """Run it."""
        if not self._is_ready:
            self.make_ready()
        try:
            return self._compiled(*arguments)
        except OSError:  # it is compiled for further types, but could not be kept
            return self._compiled(*arguments)

    @property
    def compiled_for(self) -> list[tuple[types.Type, ...]]:
        """Types of arguments that it has been compiled for."""
        return list(self._compiled.signatures)

    def make_ready(self, *, for_all: bool = False, wait: bool = True) -> None:
        """Load it from the cache, or compile and keep it.

        Parameters
        ----------
        for_all : bool
            For all its signatures, not only the usual one.
        wait : bool
            Whether to wait for another process that compiles it; if not, nothing may be done.
        """
        if not isinstance(self._compiled, Dispatcher):
            return
        signatures = self.signatures if for_all else self.signatures[:1]
        with _compiling:
            if is_kept(self.family, self.name, len(signatures)):
                self._compile(signatures)
                return
            for listener in _listeners:
                listener(self)
            with claimed(self.family, self.name, wait=wait) as is_ours:
                if is_ours:
                    self._compile(signatures)

    def _compile(self, signatures: Sequence[tuple[types.Type, ...]]) -> None:
        for signature in signatures:
            with suppress(OSError):  # it is compiled, but could not be kept: the disk is full
                self._compiled.compile(signature)
        self._is_ready = True


@contextmanager
def on_compilation(listener: Callable[[Kernel], None]) -> Iterator[None]:
    """Within the block, tell a function which kernel is to be compiled: not found in the cache."""
    _listeners.append(listener)
    try:
        yield
    finally:
        _listeners.remove(listener)


def kernel(*signatures: str, **others: Any) -> Callable[[Callable[..., Any]], Kernel]:
    """Declare a kernel; other kernels cannot call it.

    Parameters
    ----------
    *signatures : str
        Types of the arguments, like ``"f2 i1 f (f2 i2)"``: f float64, z complex128, i int64, j
        int32, s int8, b bool, n None; a number says how many axes an array has, ``~`` that its
        strides may be any, brackets a tuple. The usual types come first.
    **others : dtype or numba type
        Further types by name: of the elements of structured arrays, or of arguments.
    """

    def declare(function: Callable[..., Any]) -> Kernel:
        return Kernel(function, [_parse(signature, others) for signature in signatures])

    return declare


def inner(function: Callable[..., Any]) -> Any:
    """Declare a function that only kernels call, and that becomes a part of them."""
    return njit(pipeline_class=InnerCompiler, no_cpython_wrapper=True, **_COMMON)(function)


def _parse(signature: str, others: Mapping[str, Any]) -> tuple[types.Type, ...]:
    """Turn the words of a signature into numba's types."""
    found: list[types.Type] = []
    for group, word in re.findall(r"\(([^)]*)\)|(\S+)", signature):
        if group:
            found.append(types.Tuple(_parse(group, others)))
            continue
        name, axes, strided = re.fullmatch(r"([a-z]+)(\d?)(~?)", word).groups()
        element = others.get(name) or _TYPES[name]
        if isinstance(element, np.dtype):
            element = numba.from_dtype(element)
        layout = "A" if strided else "C"
        found.append(types.Array(element, int(axes), layout) if axes else element)
    return tuple(found)
