"""Well-formed files of every kind, as a start for damaged ones.

A further format needs one more entry in `SEEDS`.
"""

import io
from collections.abc import Iterator

import numpy as np
import plyfile
from fuzz_mesh_seeds import obj_files, off_files, stl_files
from fuzz_scan_seeds import e57_files, las_files, pcd_files, ptx_files

from pcsmooth import PointCloud, write_cloud

SCALARS = ("i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8")
BYTE_ORDERS = ((True, "="), (False, "<"), (False, ">"))


def _ply_files() -> Iterator[bytes]:
    for text, order in BYTE_ORDERS:
        yield _ply(text, order, _scalars())
        yield _ply(text, order, _positions("f4"))
        yield _ply(text, order, _positions("f8", 0))
        yield _ply(text, order, _lists("vertex", "u1", "i4"))
        yield _ply(text, order, _lists("vertex", "i4", "f8"), _lists("face", "u2", "u1"))
        yield _ply(text, order, _camera(), _positions("i2"), _lists("face", "i1", "u4"))
        yield _ply(text, order, _lists("tristrips", "u4", "i2", 1), _positions("f4", 3))
    mesh = _ply(True, "=", _positions("f4", 3), _lists("face", "u1", "i4", 2))
    yield mesh.replace(b"\n", b"\r\n")
    yield mesh.replace(b"\n", b"\r")
    yield mesh.replace(b"end_header\n", b"comment last\nelement none 0\nend_header\n")
    yield mesh.replace(b"comment made by hand", "comment façade ½".encode())
    yield mesh.replace(b"float", b"float32").replace(b"uchar", b"uint8")
    yield mesh.replace(b"property float z", b"property float Z")
    yield mesh.rstrip(b"\n")
    yield (
        b"ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\n"
        b"end_header\nnan -inf\n1e-320 -0.0\n"
    )
    yield (
        b"ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty char x\n"
        b"property list float uchar near\nproperty short y\nend_header\n\1\0\0\0\0\0\2"
    )
    yield b""
    yield b"ply\n"


def _ply(text: bool, order: str, *elements: plyfile.PlyElement) -> bytes:
    """Compose a file; the numbers beside lists, which plyfile writes as they are, are turned."""
    native = "=<" if np.little_endian else "=>"
    if order not in native:
        for element in elements:
            table = element.data
            if any(table.dtype[name].kind == "O" for name in table.dtype.names):
                for name in table.dtype.names:
                    if table.dtype[name].kind != "O":
                        table[name] = table[name].byteswap()
    file = io.BytesIO()
    plyfile.PlyData(
        elements,
        text=text,
        byte_order=order,
        comments=["made by hand", "unit metre"],
        obj_info=["num_cols 5"],
    ).write(file)
    return file.getvalue()


def _positions(code: str, n: int = 4) -> plyfile.PlyElement:
    table = np.zeros(n, [(axis, code) for axis in "xyz"])
    for shift, axis in enumerate("xyz"):
        table[axis] = (np.arange(n) * 7 + shift * 3) % 5
    return plyfile.PlyElement.describe(table, "vertex", comments=["of points"])


def _scalars() -> plyfile.PlyElement:
    table = np.zeros(3, [("x", "f4"), ("y", "f4"), ("z", "f4"), *((f"s_{c}", c) for c in SCALARS)])
    for name in table.dtype.names or ():
        table[name] = [1, 0, 100]
    table["s_f8"] = [np.nan, -0.0, np.inf]
    return plyfile.PlyElement.describe(table, "vertex")


def _lists(name: str, length: str, item: str, n: int = 3) -> plyfile.PlyElement:
    table = np.zeros(n, [("x", "f4"), ("near", "O"), ("y", "f8"), ("more", "O")])
    table["x"] = np.arange(n)
    for row in range(n):
        table["near"][row] = np.arange(row + 1, dtype=item)
        table["more"][row] = np.arange(3, dtype="i2")
    return plyfile.PlyElement.describe(
        table,
        name,
        len_types={"near": length, "more": "u1"},
        val_types={"near": item, "more": "i2"},
    )


def _camera() -> plyfile.PlyElement:
    return plyfile.PlyElement.describe(
        np.array([(1.5, 2)], [("focal", "f8"), ("id", "i2")]), "camera", comments=["one lens"]
    )


_TEXTS = (
    "",
    "1 2 3\n-4.5 5e-3 6\n",
    "1 2 3\n-4.5 5e-3 6",
    "1 2\n3 4\n5 6\n",
    "  1   2\t3  \n\n-4.5 5e-3 6 \n\n\n",
    "1,2,3\n-4.5,5e-3,6\n",
    "1, 2, 3\n-4.5, 5e-3, 6\n",
    "1;2;3;a b\n-4.5;5e-3;6;\n",
    "1\t2\t3\ta b\n-4.5\t5e-3\t6\t\n",
    '"1","2","3"\n"-4.5","5e-3","6"\n',
    "2\n1 2 3 8\n-4.5 5e-3 6 9\n",
    "0\n",
    "# scan\n// by hand\n1 2 3\n# half\n-4.5 5e-3 6\n",
    "x y z\n1 2 3\n-4.5 5e-3 6\n",
    "x,y,z,intensity\n1,2,3,7\n-4.5,5e-3,6,8\n",
    '"X","Y","Z","I t"\n1,2,3,"a,b"\n-4.5,5e-3,6,"say ""so"""\n',
    "id;Z;y;X\n7;3;2;1\nb;6;5e-3;-4.5\n",
    "//X Y Z R G B sf Nx Ny Nz\n1 2 3 4 5 6 7 0 0 1\n-4.5 5e-3 6 4 5 6 7 0 1 0\n",
    "//X,Y,Z,R\n2\n1,2,3,4\n-4.5,5e-3,6,5\n",
    "# made on Monday\n# x y z nx ny nz\n1 2 3 0 0 1\n-4.5 5e-3 6 0 0 1\n",
    "Easting,Northing,Height,Code\n1,2,3,7\n-4.5,5e-3,6,8\n",
    "x,y,z,,a,a,column_4\n1,2,3,4,5,6,7\n-4.5,5e-3,6,4,5,6,7\n",
    "1 2 3 0.6 0 0.8\n-4.5 5e-3 6 0 0 0\n",
    "1 2 fixed\n3 4\n5 6 FIXED\n",
    "# x y i\n1 2 9 fixed\n3 4 9\n",
    "x,y,state\n1,2,fixed,fixed\n3,4,a\n",
    "nan inf -INF\n1e-320 -0.0 1e308\n",
    "# nothing\n",
    "x,y,i\n",
    "x,y,z,i\n,2,3,\n-nan(ind),1.#QNAN,-1.#INF,NULL\n4,5,#N/A,n/a\n#NA,5,6,7\n",
    "x,y,z\n1,2,3,\n4,5,6,\n",
    "1;2;3;\n4;5;6;\n",
    "X;Y;Z;s\n0,5;-1,5;2,25;1,5\n1,5;NA;3;2,5\n",
    "0,5 1,5 2,5\n3,5 4,5 5,5\n",
    "1.0D+00 -2.5d-01 3.0D+00\n4.0D+00 5.0D+00 6.0D+00\n",
    "% by hand\n%x y z\n1 2 3\n! half\n4 5 6\n",
    "; by hand\n1 2 3\n4 5 6\n",
    ";x;y;z\n0;1;2;3\n1;4;5;6\n",
    "2\n1 2 3 8\n4 5 6 9\n1\n7 8 9 1\n",
    "9\n1 2 3\n4 5 6\n",
    "PointID,Easting [m],Northing [m],Elevation\n1000,4,5,6\n1001,7,8,9\n",
    '"Scalars_","Points:0","Points:1","Points:2"\n7,1,2,3\n8,4,5,6\n',
    "//Easting Northing Elevation R G B\n1 2 3 4 5 6\n7 8 9 4 5 6\n",
    "x [m] y [m] z [m] t\n1 2 3 4\n5 6 7 8\n",
    "lon\tlat\theight\n7.5\t51.9\t100\n7.6\t52.0\t101\n",
    "a b c d\n1 2 3 4\n5 6 7 8\n",
    "1 0.5 2.5 3.5\n2 4.5 5.5 6.5\n3 7.5 8.5 9.5\n",
    "ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n",
)


def _text_files() -> Iterator[bytes]:
    for text in _TEXTS:
        yield text.encode()
    for text in _TEXTS[5:20:5]:
        yield text.replace("\n", "\r\n").encode()
        yield text.replace("\n", "\r").encode()
        yield text.encode("utf-8-sig")
        yield text.encode("utf-16")
    yield b"1 2 3 word\n" * 600
    yield "x,y,z,Größe\n1,2,3,½\n4,5,6,日本\n".encode()
    yield "# Höhen\nx,y,Höhe,Größe\n1,2,3,½\n4,5,6,\xa0\n".encode("latin-1")
    file = io.BytesIO()
    rng = np.random.default_rng(0)
    write_cloud(PointCloud(rng.normal(size=(40, 3))), file, format="xyz")
    yield file.getvalue()


_TEXT = tuple(_text_files())

SEEDS: dict[str, tuple[bytes, ...]] = {
    "ply": tuple(_ply_files()),
    **dict.fromkeys(("xyz", "xy", "txt", "asc", "csv", "pts"), _TEXT),
    "las": tuple(las_files(packed=False)),
    "laz": tuple(las_files(packed=True)),
    "pcd": tuple(pcd_files()),
    "e57": tuple(e57_files()),
    "ptx": tuple(ptx_files()),
    "obj": tuple(obj_files()),
    "off": tuple(off_files()),
    "stl": tuple(stl_files()),
}
"""Well-formed files by the name of their format."""
