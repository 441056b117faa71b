"""Any PLY file comes back bit for bit; plyfile is the judge."""

from __future__ import annotations

import io
import string
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import plyfile
from hypothesis import given, settings
from hypothesis import strategies as st

from pcsmooth.cloud import PointCloud
from pcsmooth.formats import read_cloud, write_cloud

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


@st.composite
def arrays(draw: st.DrawFn, code: str, size: int) -> Values:
    """Values of any bits, often extreme ones; signalling NaNs, which casts change, are quiet."""
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
    values = draw(st.lists(st.sampled_from(extremes) | bits, min_size=size, max_size=size))
    with np.errstate(invalid="ignore"):
        array = np.array(values, dtype)
    if dtype.kind != "f":
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
    return Property(name, code, [draw(arrays(code, size)) for size in sizes], length)


@st.composite
def elements(draw: st.DrawFn, name: str) -> Element:
    names = draw(st.lists(NAMES, max_size=3, unique=True))
    count = draw(st.integers(0, 4)) if names else 0
    return Element(name, count, tuple(draw(properties(name, count)) for name in names))


@st.composite
def vertices(draw: st.DrawFn) -> Element:
    count = draw(st.integers(0, 5))
    axes = draw(st.sampled_from(("xy", "xyz", "XYZ", "zyx")))
    foreign = NAMES.filter(lambda name: name.lower() not in ("x", "y", "z"))
    names = draw(st.permutations([*axes, *draw(st.lists(foreign, max_size=3, unique=True))]))
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
    foreign = NAMES.filter(lambda name: name != "vertex")
    names = draw(st.lists(foreign, max_size=3, unique=True))
    others = [draw(elements(name)) for name in names]
    place = draw(st.integers(0, len(others)))
    return File(
        draw(st.sampled_from(sorted(ENCODINGS))),
        (*others[:place], draw(vertices()), *others[place:]),
        tuple(draw(LINES)),
        tuple(draw(LINES)),
        draw(st.booleans()),
    )


def read(data: bytes) -> PointCloud:
    return read_cloud(io.BytesIO(data), format="ply")


def written(cloud: PointCloud) -> bytes:
    buffer = io.BytesIO()
    write_cloud(cloud, buffer, format="ply")
    return buffer.getvalue()


def opened(data: bytes) -> plyfile.PlyData:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about lists without items, numbers beyond float
        return plyfile.PlyData.read(io.BytesIO(data), mmap=False)


def bits(values: Any, code: str, text: bool) -> bytes:
    """Values as bytes; text keeps of a NaN no more than that it is one."""
    with np.errstate(invalid="ignore"):
        array = np.asarray(values).astype(code)
    if text and array.dtype.kind == "f":
        array = np.where(np.isnan(array), np.array(np.nan, code), array)
    return array.tobytes()


def check_rows(prop: Property, result: plyfile.PlyElement, code: str, text: bool) -> None:
    column = result[prop.name]
    if not prop.length:
        assert bits(column, code, text) == bits(prop.values, code, text), prop.name
        return
    for mine, theirs in zip(column, prop.values, strict=True):
        assert bits(mine, code, text) == bits(theirs, code, text), prop.name


@settings(derandomize=True, deadline=None, max_examples=300, database=None)
@given(files())
def test_any_file_comes_back(file: File) -> None:
    data = bytes(file)
    text = file.order == "="
    cloud = read(data)
    once = written(cloud)
    result = opened(once)

    assert (result.text, result.byte_order) == (text, file.order)
    assert tuple(result.comments) == file.comments
    assert tuple(result.obj_info) == file.obj_info
    assert [element.name for element in result] == [element.name for element in file.elements]
    for element in file.elements:
        described = result[element.name]
        assert described.count == element.count
        assert tuple(described.comments) == element.comments
        assert [prop.name for prop in described.properties] == [p.name for p in element.properties]
        for prop in element.properties:
            is_position = element.name == "vertex" and prop.name.lower() in ("x", "y", "z")
            code = "f8" if is_position and prop.code[0] != "f" else prop.code
            kept = described.ply_property(prop.name)
            assert kept.val_dtype == code
            assert getattr(kept, "len_dtype", "") == prop.length
            check_rows(prop, described, code, text)

    vertex = opened(data)["vertex"]
    names = {prop.name.lower(): prop.name for prop in vertex.properties}
    axes = [names[axis] for axis in "xyz" if axis in names]
    np.testing.assert_array_equal(
        cloud.points, np.stack([vertex[axis].astype("f8") for axis in axes], axis=1)
    )
    assert written(read(once)) == once
    if not text and not file.long_names and cloud.position_type.kind == "f":
        assert once == data
