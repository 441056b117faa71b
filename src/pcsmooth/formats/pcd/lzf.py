"""LZF, the compression of PCD files: unpacking."""

from __future__ import annotations

LARGEST_RATIO = 88
"""Bytes that a byte of LZF can stand for at most: 264 by 3."""

_LITERALS = 32
_LONG = 7


def unpack_lzf(packed: bytes, size: int) -> bytes:
    r"""Unpack LZF data.

    Parameters
    ----------
    packed : bytes
        The data.
    size : int
        Length of what they stand for; memory is not taken before the data call for it.

    Returns
    -------
    bytes

    Raises
    ------
    ValueError
        The data are damaged, or stand for another length.

    Notes
    -----
    Instructions of two kinds follow one another. A byte below 32 is followed by as many bytes
    and one more, which are copied. Any other has a length in its upper 3 bits, continued in the
    next byte if it is 7, and a distance in its lower 5 bits and a further byte: 2 bytes more than
    the length are repeated from 1 byte farther back than the distance, overlaps included.

    Examples
    --------
    >>> unpack_lzf(b"\x01ab\x80\x01", 8)
    b'abababab'
    """
    unpacked = bytearray()
    position = 0
    try:
        while position < len(packed):
            control = packed[position]
            position += 1
            if control < _LITERALS:
                end = position + control + 1
                if end > len(packed):
                    raise ValueError("the compressed data end within a run")
                unpacked += packed[position:end]
                position = end
            else:
                length = control >> 5
                if length == _LONG:
                    length += packed[position]
                    position += 1
                start = len(unpacked) - ((control & 31) << 8) - packed[position] - 1
                position += 1
                if start < 0:
                    raise ValueError("the compressed data refer to what is before them")
                _repeat(unpacked, start, length + 2)
            if len(unpacked) > size:
                raise ValueError(f"the compressed data hold more than {size} bytes")
    except IndexError as error:
        raise ValueError("the compressed data end within a repetition") from error
    if len(unpacked) != size:
        raise ValueError(f"the compressed data hold {len(unpacked)} bytes, not {size}")
    return bytes(unpacked)


def _repeat(unpacked: bytearray, start: int, length: int) -> None:
    """Append what begins at a position; what is appended may itself be repeated."""
    piece = unpacked[start : start + length]
    unpacked += (piece * (length // len(piece) + 1))[:length]
