"""Numbers of points packed for a page: whole numbers, the bytes of a kind together, deflated."""

from __future__ import annotations

import zlib
from base64 import b64encode
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.uint32]

#: Bits of a coordinate, the fewer if a step is at most this share of the spacing.
_BITS = (16, 24)
_STEP = 0.02

#: Steps of each of the two numbers of a normal, and the number of one that is unknown.
_STEPS = 254
_NO_NORMAL = 255

#: Largest value, in units of half the scale, and what stands for one that is unknown: both are
#: numbers of half precision.
_LARGEST = 60_000.0
_NO_VALUE = 65_504.0

#: Of deflate: higher ones take ten times as long for 1 % less.
_LEVEL = 6


def bits_for(spacing: float) -> int:
    """Choose how many bits coordinates between -1 and 1 get.

    Examples
    --------
    >>> bits_for(0.01), bits_for(0.0001)
    (16, 24)
    """
    least, most = _BITS
    return least if 2.0 / (2**least - 1) <= _STEP * spacing else most


def whole_numbers(places: Floats, bits: int) -> Numbers:
    """Turn coordinates between -1 and 1 into whole numbers from 0.

    Examples
    --------
    >>> whole_numbers(np.array([[-1.0, 0.0, 1.0]]), 16).tolist()
    [[0, 32768, 65535]]
    """
    steps: Numbers = np.rint((places + 1.0) * (0.5 * (2**bits - 1))).astype(np.uint32)
    return steps


def normal_numbers(normals: Floats) -> Numbers:
    """Turn normals of either sign into two numbers each, their places on half an octahedron.

    Parameters
    ----------
    normals : ndarray, shape (n, 3)
        Of any length; zero or NaN where unknown.

    Returns
    -------
    ndarray of uint32, shape (n, 2)
        Up to 254 each, 255 where the normal is unknown.

    Notes
    -----
    The mapping is that of Cigolle et al. (2014), "A Survey of Efficient Representations for
    Independent Unit Vectors", for half an octahedron.
    """
    known = np.nan_to_num(normals, posinf=0.0, neginf=0.0)
    size = np.abs(known).sum(axis=1)
    upwards = np.where(known[:, 2:] < 0.0, -known, known)
    x, y = (upwards[:, :2] / np.where(size, size, 1.0)[:, np.newaxis]).T
    places = np.stack([x + y, x - y], axis=1)
    numbers = np.rint((places + 1.0) * (0.5 * _STEPS)).astype(np.uint32)
    numbers[size == 0.0] = _NO_NORMAL
    return numbers


def value_numbers(values: Floats, limits: tuple[float, float]) -> Numbers:
    """Turn values into the bits of half precision, -1 and 1 being the limits of their scale.

    Parameters
    ----------
    values : ndarray, shape (n,)
        NaN where unknown.
    limits : tuple of float
        Values of the first and the last color.

    Returns
    -------
    ndarray of uint32, shape (n, 1)
    """
    low, high = limits
    shares = (values - (0.5 * low + 0.5 * high)) / (0.5 * high - 0.5 * low)
    halves = np.clip(shares, -_LARGEST, _LARGEST).astype(np.float16)
    halves[np.isnan(values)] = _NO_VALUE
    return halves.view(np.uint16).astype(np.uint32)[:, np.newaxis]


@dataclass(frozen=True)
class Block:
    """Numbers as a page holds them.

    Attributes
    ----------
    text : str
        In base64: deflated; for each column and each byte of its numbers, the lowest first, that
        byte of all rows.
    bits : int
        Of a number, whole bytes.
    columns : int
        Numbers of a row.
    is_running : bool
        Whether each row is the difference to the one before.
    """

    text: str
    bits: int
    columns: int
    is_running: bool


def packed(numbers: Numbers, bits: int, *, is_running: bool = False) -> Block:
    """Pack whole numbers, shape (n, c), of so many bits: see `Block`."""
    if is_running:
        numbers = np.diff(numbers, axis=0, prepend=np.zeros((1, numbers.shape[1]), np.uint32))
    planes = [
        (column >> np.uint32(shift)).astype(np.uint8).tobytes()
        for column in numbers.T
        for shift in range(0, bits, 8)
    ]
    deflate = zlib.compressobj(_LEVEL, wbits=-zlib.MAX_WBITS)
    data = deflate.compress(b"".join(planes)) + deflate.flush()
    return Block(b64encode(data).decode(), bits, numbers.shape[1], is_running)
