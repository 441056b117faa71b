"""PLY files, composed by hand and by plyfile, for the tests."""

from __future__ import annotations

import io

import numpy as np
import plyfile

SCALARS = ["i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8"]
ENCODINGS = [(True, "="), (False, "<"), (False, ">")]


def rich_ply(text: bool, byte_order: str) -> plyfile.PlyData:
    """A file with all that PLY offers; x y z are neither first nor together."""
    rng = np.random.default_rng(7)
    types = [("red", "u1"), ("x", "f4"), ("y", "f4")]
    types += [(f"s_{code}", code) for code in SCALARS] + [("z", "f4"), ("hits", "O")]
    vertex = np.empty(5, types)
    for name, code in types:
        if code == "O":
            vertex[name] = [np.arange(row, dtype="u2") for row in range(5)]
        elif code[0] == "f":
            vertex[name] = rng.normal(size=5)
        else:
            limits = np.iinfo(code)
            vertex[name] = [limits.min, limits.max, 0, 1, limits.max - 1]
    camera = np.array([(1.5, 2)], [("focal", "f8"), ("id", "i2")])
    face = np.empty(3, [("vertex_indices", "O"), ("flag", "u1")])
    face["vertex_indices"] = [np.array(v, "i4") for v in ([0, 1, 2], [0, 1, 2, 3], [4, 3, 2])]
    face["flag"] = [1, 2, 3]
    return plyfile.PlyData(
        [
            plyfile.PlyElement.describe(camera, "camera", comments=["one lens"]),
            plyfile.PlyElement.describe(
                vertex,
                "vertex",
                len_types={"hits": "u4"},
                val_types={"hits": "u2"},
                comments=["of points"],
            ),
            plyfile.PlyElement.describe(face, "face", len_types={"vertex_indices": "u1"}),
        ],
        text=text,
        byte_order=byte_order,
        comments=["made by hand", "unit metre"],
        obj_info=["num_cols 5"],
    )


def as_bytes(ply: plyfile.PlyData) -> bytes:
    if ply.text:
        buffer = io.BytesIO()
        ply.write(buffer)
        return buffer.getvalue()
    # plyfile itself writes the numbers beside a list in native order under any header.
    data = bytearray(ply.header.encode() + b"\n")
    for element in ply:
        for row in element.data:
            for prop in element.properties:
                value_type = ply.byte_order + prop.val_dtype
                if isinstance(prop, plyfile.PlyListProperty):
                    data += np.array(len(row[prop.name]), ply.byte_order + prop.len_dtype).tobytes()
                data += np.asarray(row[prop.name]).astype(value_type).tobytes()
    return bytes(data)


def ascii_ply(properties: str, rows: str, count: int | None = None) -> bytes:
    count = len(rows.splitlines()) if count is None else count
    lines = "".join(f"property {prop}\n" for prop in properties.split(", "))
    return f"ply\nformat ascii 1.0\nelement vertex {count}\n{lines}end_header\n{rows}".encode()


XYZ = "float x, float y, float z"


def binary(count: int, body: bytes, properties: str = XYZ, tail: str = "") -> bytes:
    header = ascii_ply(properties, "", count).replace(b"ascii", b"binary_little_endian")
    return header.replace(b"end_header", tail.encode() + b"end_header") + body


FACES = "element face 2\nproperty list uchar int vertex_indices\nproperty short flag\n"
TRIANGLE = b"\x03" + bytes(12) + bytes(2)
