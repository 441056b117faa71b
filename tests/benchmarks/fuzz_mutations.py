"""Damage to files: bytes, words, numbers and lines, all of it drawn from one generator."""

import random
import re
import struct
from collections.abc import Callable, Sequence

LARGEST = 1 << 18
"""Bytes that a damaged file may have."""

_NUMBERS = (
    *("0", "-1", "1", "2", "3", "127", "128", "255", "256", "65535", "65536", "-32769"),
    *("2147483647", "2147483648", "4294967295", "4294967296", "-2147483649", "1000000000000"),
    *("9" * 19, "1" + "0" * 30, "9" * 400, "9" * 5000, "-" + "9" * 30, "1e400", "-1e400", "1e39"),
    *("nan", "-nan", "NaN", "nan(7)", "inf", "-Infinity", "1e-400", "1e-45", "5e-324", "-0", "+7"),
    *("1.5", "1.", ".5", ".", "-", "+", "1e", "1e+", "0x10", "0b1", "1_000", "1,5", "1d5", "00012"),
    *("", '"', '"7"', '""', "'7'", "١٢", "１", "½", "−5", "é", "\ufeff", "\xa0", "\u2028", "\x85"),
    *("True", "None", "null", "fixed", "FIXED", "#", "//", "a b", "1 2", "1;2", "1\t2", "\\", "\0"),
)

_WORDS = (
    *(b"ply", b"format", b"ascii", b"binary_little_endian", b"binary_big_endian", b"1.0"),
    *(b"element", b"vertex", b"face", b"property", b"list", b"comment", b"obj_info", b"end_header"),
    *(b"char", b"uchar", b"short", b"ushort", b"int", b"uint", b"float", b"double"),
    *(b"int8", b"uint8", b"int16", b"uint16", b"int32", b"uint32", b"float32", b"float64"),
    *(b"x", b"y", b"z", b"X", b"nx", b"near", b"", b"int64", b"f4", b"x,y,z", b"fixed", b"fixed 1"),
    *(b"VERSION", b"FIELDS", b"SIZE", b"TYPE", b"COUNT", b"WIDTH", b"HEIGHT", b"POINTS", b"DATA"),
    *(b"binary", b"binary_compressed", b"rgb", b"rgba", b"_", b"I", b"U", b"F"),
    *(b"OFF", b"COFF", b"NOFF", b"STOFF", b"nOFF", b"BINARY", b"v", b"vn", b"vt", b"f"),
    *(b"solid", b"endsolid", b"facet", b"normal", b"loop", b"LASF_Spec", b"copc", b"pcsmooth"),
    *(b"Float", b"Integer", b"ScaledInteger", b"String", b"minimum", b"maximum", b"recordCount"),
)

_BYTES = (
    *(b"\0", b"\xff", b"\n", b"\r", b"\r\n", b"\t", b" ", b",", b";", b'"', b"#", b"//", b"\x1a"),
    *(
        b"\xef\xbb\xbf",
        b"\xff\xfe",
        b"\xc3",
        b"\x0b",
        b"\x0c",
        b"\x1c",
        b"\xc2\x85",
        b"\xe2\x80\xa8",
    ),
    *(b"ply\n", b"\nend_header\n", b"\nelement vertex 1000000000000\n", b"\nelement x 5\n"),
    *(b"\nelement q 1000000000000\nproperty int i\n",),
    *(b"\nproperty list float float l\n", b"\nproperty uchar q\n", b"\nproperty list uint int l\n"),
    *(
        b"\ncomment \xe9\n",
        b"\nobj_info\n",
        b"\ncomment\n",
        b"\n# x y z\n",
        b"\n// y x\n",
        b"\n7\n",
    ),
)

_FIELDS = tuple(
    struct.pack(order + code, value)
    for order in "<>"
    for code, values in (
        ("i", (-1, 0, 1, 255, 256, 65536, 2**31 - 1, -(2**31))),
        ("h", (-1, 256, 2**15 - 1, -(2**15))),
        ("f", (float("nan"), float("inf"), -0.0, 3e38, 1e-45, 2.5)),
        ("d", (float("nan"), float("-inf"), 1e300, 5e-324, 7.0)),
        ("Q", (0x7FF0000000000001, 0x7F800001, 2**63, 2**64 - 1, 10**12)),
    )
    for value in values
)

Rng = random.Random


def damaged(seeds: Sequence[bytes], rng: Rng, *, in_place: bool = False) -> bytes:
    """Damage one of the files, in one to several ways; in place its length stays."""
    data = rng.choice(seeds)
    damages = (_flip_bit, _overwrite) if in_place else _DAMAGES
    while True:
        data = rng.choice(damages)(data, seeds, rng)[:LARGEST]
        if rng.random() < 0.6:
            return data


def _place(data: bytes, rng: Rng) -> int:
    """Anywhere, but as often in the header as in the rows."""
    size = len(data)
    return rng.randint(0, min(size, 400) if rng.random() < 0.5 else size)


def _slice(data: bytes, rng: Rng) -> tuple[int, int]:
    start = _place(data, rng)
    return start, min(len(data), start + int(rng.expovariate(1 / rng.choice((1, 4, 30)))) + 1)


def _flip_bit(data: bytes, _seeds: Sequence[bytes], rng: Rng) -> bytes:
    if not data:
        return data
    place = min(_place(data, rng), len(data) - 1)
    return data[:place] + bytes([data[place] ^ 1 << rng.randrange(8)]) + data[place + 1 :]


def _insert(data: bytes, _seeds: Sequence[bytes], rng: Rng) -> bytes:
    place = _place(data, rng)
    piece = rng.choice(_BYTES) if rng.random() < 0.8 else rng.randbytes(rng.randint(1, 8))
    return data[:place] + piece + data[place:]


def _overwrite(data: bytes, _seeds: Sequence[bytes], rng: Rng) -> bytes:
    place, field = _place(data, rng), rng.choice(_FIELDS)
    return data[:place] + field + data[place + len(field) :]


def _delete(data: bytes, _seeds: Sequence[bytes], rng: Rng) -> bytes:
    start, end = _slice(data, rng)
    return data[:start] + data[end:]


def _duplicate(data: bytes, _seeds: Sequence[bytes], rng: Rng) -> bytes:
    start, end = _slice(data, rng)
    return data[:end] + data[start:end] * rng.choice((1, 1, 2, 50)) + data[end:]


def _truncate(data: bytes, _seeds: Sequence[bytes], rng: Rng) -> bytes:
    return data[: _place(data, rng)]


def _splice(data: bytes, seeds: Sequence[bytes], rng: Rng) -> bytes:
    other = rng.choice(seeds)
    return data[: _place(data, rng)] + other[_place(other, rng) :]


def _replaced(pattern: bytes, data: bytes, new: bytes, rng: Rng) -> bytes:
    found = list(re.finditer(pattern, data))
    if not found:
        return data
    start, end = rng.choice(found[:40] if rng.random() < 0.7 else found).span()
    return data[:start] + new + data[end:]


def _number(data: bytes, _seeds: Sequence[bytes], rng: Rng) -> bytes:
    pattern = rb"(?<![A-Za-z_])-?[0-9][0-9.e+-]*"
    return _replaced(pattern, data, rng.choice(_NUMBERS).encode(), rng)


def _word(data: bytes, _seeds: Sequence[bytes], rng: Rng) -> bytes:
    return _replaced(rb"[A-Za-z_][A-Za-z_0-9]*", data, rng.choice(_WORDS), rng)


def _delimiter(data: bytes, _seeds: Sequence[bytes], rng: Rng) -> bytes:
    old, new = rng.sample((b" ", b",", b";", b"\t", b"\n", b"\r", b"\r\n", b'"', b"."), 2)
    return data.replace(old, new, rng.choice((-1, -1, 1, 5)))


def _lines(data: bytes, _seeds: Sequence[bytes], rng: Rng) -> bytes:
    lines = data.split(b"\n")
    one, other = rng.randrange(len(lines)), rng.randrange(len(lines))
    match rng.randrange(4):
        case 0:
            lines[one], lines[other] = lines[other], lines[one]
        case 1:
            lines.insert(other, lines[one])
        case 2:
            del lines[one]
        case _:
            rng.shuffle(lines)
    return b"\n".join(lines)


def _giant(data: bytes, _seeds: Sequence[bytes], rng: Rng) -> bytes:
    """Something short, again and again: a long line, a long word, many lines."""
    start, end = _slice(data, rng)
    pieces = (data[start:end], rng.choice(_BYTES), b"1,", b"a,", b'"a', b"9", b"1 ", b"1 2 3\n")
    piece = rng.choice(pieces) or b" "
    size = int(2 ** rng.uniform(8, 17))
    return data[:start] + piece * (size // len(piece)) + data[start:]


_DAMAGES: tuple[Callable[[bytes, Sequence[bytes], Rng], bytes], ...] = (
    *(_flip_bit, _insert, _insert, _overwrite, _delete, _duplicate, _truncate, _splice),
    *(_number, _number, _number, _word, _word, _word, _delimiter, _lines, _lines),
) * 3 + (_giant,)
