"""Any PLY file comes back bit for bit; plyfile is the judge."""

from __future__ import annotations

import io
import warnings
from typing import Any

import numpy as np
import plyfile
import pytest
from hypothesis import given, settings

from formats.any_ply import File, Property, files
from pcsmooth.cloud import PointCloud
from pcsmooth.formats import read_cloud, write_cloud


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


@pytest.mark.slow
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
