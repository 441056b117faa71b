from __future__ import annotations

import numpy as np
import pytest

from pcsmooth.formats.pcd.lzf import LARGEST_RATIO, unpack_lzf


def pack_lzf(data: bytes) -> bytes:
    """Greedy LZF, by the description of the format: runs and repetitions."""
    packed, run = bytearray(), bytearray()
    seen: dict[bytes, int] = {}
    position = 0

    def end_run() -> None:
        for start in range(0, len(run), 32):
            packed.append(len(run[start : start + 32]) - 1)
            packed.extend(run[start : start + 32])
        run.clear()

    while position < len(data):
        key = data[position : position + 3]
        start = seen.get(key, -1)
        seen[key] = position
        distance = position - start - 1
        if len(key) < 3 or start < 0 or distance >= 2**13:
            run.append(data[position])
            position += 1
            continue
        end_run()
        length = 3
        while (
            length < 264
            and position + length < len(data)
            and data[start + length] == data[position + length]
        ):
            length += 1
        code = length - 2
        packed.append((min(code, 7) << 5) | (distance >> 8))
        if code >= 7:
            packed.append(code - 7)
        packed.append(distance & 255)
        position += length
    end_run()
    return bytes(packed)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"a",
        b"abababababab",
        b"\0" * 5000,
        bytes(range(256)) * 40,
        np.random.default_rng(1).bytes(3000),
        np.random.default_rng(2).integers(0, 3, 20_000, np.uint8).tobytes(),
        np.linspace(0, 1, 4000, dtype="f4").tobytes(),
    ],
    ids=["empty", "one", "overlap", "zeros", "counting", "noise", "three values", "floats"],
)
def test_what_is_packed_is_unpacked(data: bytes) -> None:
    packed = pack_lzf(data)
    assert unpack_lzf(packed, len(data)) == data
    assert len(data) <= LARGEST_RATIO * len(packed)


def test_repetitive_data_are_packed() -> None:
    assert len(pack_lzf(b"\0" * 26_400)) < 26_400 / 80  # so that repetitions are tried above


@pytest.mark.parametrize(
    ("packed", "size", "message"),
    [
        (b"\x02ab", 3, "end within a run"),
        (b"\x00a\x20", 4, "end within a repetition"),
        (b"\x00a\xe0\x00", 10, "end within a repetition"),
        (b"\x00a\x20\x01", 4, "refer to what is before them"),
        (b"\x20\x00", 3, "refer to what is before them"),
        (b"\x00a\xe0\xff\x00", 10, "hold more than 10 bytes"),
        (b"\x02abc", 2, "hold more than 2 bytes"),
        (b"\x00a", 3, "hold 1 bytes, not 3"),
    ],
)
def test_damaged_data(packed: bytes, size: int, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        unpack_lzf(packed, size)
