"""Blocks of numbers of a page, unpacked as its program does it."""

from __future__ import annotations

import zlib
from base64 import b64decode

import numpy as np
import numpy.typing as npt

from pcsmooth.plots.point_blocks import Block, Numbers

Floats = npt.NDArray[np.float64]


def unpacked(block: Block) -> Numbers:
    """The numbers of a block, shape (n, c)."""
    data = zlib.decompress(b64decode(block.text, validate=True), wbits=-zlib.MAX_WBITS)
    planes = np.frombuffer(data, np.uint8).reshape(block.columns, block.bits // 8, -1)
    numbers = np.zeros((planes.shape[2], block.columns), np.uint64)
    for plane in range(planes.shape[1]):
        numbers |= planes[:, plane].T.astype(np.uint64) << np.uint64(8 * plane)
    if block.is_running:
        numbers = np.cumsum(numbers, axis=0, dtype=np.uint64)
    return (numbers & np.uint64(2**block.bits - 1)).astype(np.uint32)


def unpacked_places(numbers: Numbers, bits: int) -> Floats:
    return np.asarray(numbers * (2.0 / (2**bits - 1)) - 1.0)


def unpacked_normals(numbers: Numbers) -> Floats:
    x, y = (numbers / 127.0 - 1.0).T
    across, along = 0.5 * (x + y), 0.5 * (x - y)
    normals = np.stack([across, along, 1.0 - np.abs(across) - np.abs(along)], axis=1)
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))


def unpacked_values(numbers: Numbers, limits: tuple[float, float]) -> Floats:
    shares = numbers[:, 0].astype(np.uint16).view(np.float16).astype(np.float64)
    low, high = limits
    values = 0.5 * (low + high) + 0.5 * (high - low) * shares
    return np.where(shares > 65_000.0, np.nan, values)
