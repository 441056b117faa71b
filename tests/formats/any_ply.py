"""Any PLY file, for tests by hypothesis."""

from __future__ import annotations

import string
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np
import numpy.typing as npt
from hypothesis import strategies as st

SCALARS = ("i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8")
LENGTHS = SCALARS[:6]
ENCODINGS = {"=": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"}
SPELLINGS = {
    "i1": ("char", "int8"),
    "u1": ("uchar", "uint8"),
    "i2": ("short", "int16"),
    "u2": ("ushort", "uint16"),
    "i4": ("int", "int32"),
    "u4": ("uint", "uint32"),
    "f4": ("float", "float32"),
    "f8": ("double", "float64"),
}
NAMES = st.text(string.digits + string.ascii_letters + string.punctuation, min_size=1, max_size=8)
PROPERTY_NAMES = st.lists(NAMES, max_size=3, unique=True)
COLUMN_NAMES = st.lists(
    NAMES.filter(lambda name: name.lower() not in ("x", "y", "z")), max_size=3, unique=True
)
ELEMENT_NAMES = st.lists(NAMES.filter(lambda name: name != "vertex"), max_size=3, unique=True)
LINES = st.lists(st.text(string.ascii_letters + " /", max_size=9).map(str.strip), max_size=3)

Values = npt.NDArray[Any]


@dataclass(frozen=True)
class Property:
    """A property and its values; of a list, one array for each row."""

    name: str
    code: str
    values: Values | list[Values]
    length: str = ""


@dataclass(frozen=True)
class Element:
    """An element with its rows."""

    name: str
    count: int
    properties: tuple[Property, ...]
    comments: tuple[str, ...] = ()


@dataclass(frozen=True)
class File:
    """A PLY file."""

    order: str
    elements: tuple[Element, ...]
    comments: tuple[str, ...]
    obj_info: tuple[str, ...]
    long_names: bool

    def __bytes__(self) -> bytes:
        """Compose the file without the help of any library."""
        lines = ["ply", f"format {ENCODINGS[self.order]} 1.0"]
        lines += [f"comment {line}" for line in self.comments]
        lines += [f"obj_info {line}" for line in self.obj_info]
        for element in self.elements:
            lines.append(f"element {element.name} {element.count}")
            lines += [f"comment {line}" for line in element.comments]
            for prop in element.properties:
                length = f"list {self._type(prop.length)} " if prop.length else ""
                lines.append(f"property {length}{self._type(prop.code)} {prop.name}")
        body = b"".join(
            self._row(element, row) for element in self.elements for row in range(element.count)
        )
        return "\n".join([*lines, "end_header\n"]).encode() + body

    def _type(self, code: str) -> str:
        return SPELLINGS[code][self.long_names]

    def _row(self, element: Element, row: int) -> bytes:
        cells: list[Values] = []
        for prop in element.properties:
            values = np.atleast_1d(prop.values[row])
            if prop.length:
                cells.append(np.array([len(values)], prop.length))
            cells.append(values)
        if self.order == "=":
            return " ".join(_spelled(value) for cell in cells for value in cell).encode() + b"\n"
        return b"".join(cell.astype(self.order + cell.dtype.str[1:]).tobytes() for cell in cells)


def _spelled(value: Any) -> str:
    return f"{value:.17g}" if isinstance(value, np.floating) else str(value)


@cache
def arrays(code: str, size: int) -> st.SearchStrategy[Values]:
    """Values of any bits, often extreme ones; signalling NaNs, which casts change, are quiet."""
    return st.lists(_numbers(code), min_size=size, max_size=size).map(partial(_quiet, code))


@cache
def _numbers(code: str) -> st.SearchStrategy[Any]:
    dtype = np.dtype(code)
    if dtype.kind == "f":
        info = np.finfo(dtype)
        extremes = [0.0, -0.0, np.inf, -np.inf, np.nan, info.tiny, -info.max]
        extremes.append(float(info.smallest_subnormal))
    else:
        limits = np.iinfo(dtype)
        extremes = [0, 1, limits.min, limits.max]
    bits = st.binary(min_size=dtype.itemsize, max_size=dtype.itemsize).map(
        lambda raw: np.frombuffer(raw, dtype)[0]
    )
    return st.sampled_from(extremes) | bits


def _quiet(code: str, values: list[Any]) -> Values:
    with np.errstate(invalid="ignore"):
        array = np.array(values, code)
    if array.dtype.kind != "f":
        return array
    whole = array.view(f"u{array.dtype.itemsize}")
    quiet = whole.dtype.type(1 << (22 if array.dtype.itemsize == 4 else 51))
    return np.where(np.isnan(array), whole | quiet, whole).view(array.dtype)


@st.composite
def properties(draw: st.DrawFn, name: str, count: int) -> Property:
    code = draw(st.sampled_from(SCALARS))
    length = draw(st.sampled_from(("", "", *LENGTHS)))
    if not length:
        return Property(name, code, draw(arrays(code, count)))
    sizes = draw(st.lists(st.integers(0, 5), min_size=count, max_size=count))
    values = draw(arrays(code, sum(sizes)))
    return Property(name, code, np.split(values, np.cumsum(sizes, dtype=int))[:-1], length)


@st.composite
def elements(draw: st.DrawFn, name: str) -> Element:
    names = draw(PROPERTY_NAMES)
    count = draw(st.integers(0, 4)) if names else 0
    return Element(name, count, tuple(draw(properties(name, count)) for name in names))


@st.composite
def vertices(draw: st.DrawFn) -> Element:
    count = draw(st.integers(0, 5))
    axes = draw(st.sampled_from(("xy", "xyz", "XYZ", "zyx")))
    names = draw(st.permutations([*axes, *draw(COLUMN_NAMES)]))
    code = draw(st.sampled_from(SCALARS))
    return Element(
        "vertex",
        count,
        tuple(
            Property(name, code, draw(arrays(code, count)))
            if name in axes
            else draw(properties(name, count))
            for name in names
        ),
        tuple(draw(LINES)),
    )


@st.composite
def files(draw: st.DrawFn) -> File:
    names = draw(ELEMENT_NAMES)
    others = [draw(elements(name)) for name in names]
    place = draw(st.integers(0, len(others)))
    return File(
        draw(st.sampled_from(sorted(ENCODINGS))),
        (*others[:place], draw(vertices()), *others[place:]),
        tuple(draw(LINES)),
        tuple(draw(LINES)),
        draw(st.booleans()),
    )
