"""Well-formed OBJ, OFF and STL files, as a start for damaged ones."""

from collections.abc import Iterator

import helpers_path  # noqa: F401

from formats.test_meshes import CUBE, OBJ, OFF, binary_stl, text_stl

_CORNERS = b"1 0 0\n0 1 0\n0 0 1e-3\n"


def obj_files() -> Iterator[bytes]:
    """OBJ files with and without colors, normals and faces."""
    yield OBJ
    yield OBJ.replace(b"\n", b"\r\n")
    yield OBJ.rstrip(b"\n")
    yield b"v 1 2 3\nv -4.5 5e-3 6\n"
    yield b"v 1 2 3 0.5 0 1\nv 4 5 6 1 1 0.25\nf 1 2 1\n"
    yield b"v 1 2 3 1\nv 4 5 6 0.5\n"
    yield b"v 1 2 3\nvn 0 0 1\nv 4 5 6\nvn 0 1 0\nf 1//1 2//2 1//1\n"
    yield b"v 1 2 3\nv 4 5 6 7 8\n#\n"
    yield b"# nothing\n"


def off_files() -> Iterator[bytes]:
    """OFF files with and without colors, normals and faces."""
    yield OFF
    yield OFF.replace(b"\n", b"\r\n")
    yield OFF.rstrip(b"\n")
    yield b"OFF 3 1 3\n" + _CORNERS + b"3 0 1 2\n"
    yield b"COFF\n2 0 0\n1 2 3 255 0 7 255\n4 5 6 1 2 3 4\n"
    yield b"COFF\n2 0 0\n1 2 3 0.5 0 1\n4 5 6 1 0 0\n"
    yield b"NOFF\n2 0 0\n1 2 3 0 0 1\n4 5 6 0 1 0\n"
    yield b"CNOFF\n1 0 0\n1 2 3 0 0 1 5 6 7\n"
    yield b"OFF\n0 0 0\n"


def stl_files() -> Iterator[bytes]:
    """STL files, binary and text."""
    yield binary_stl(CUBE)
    yield binary_stl(CUBE) + b"tail"
    yield text_stl(CUBE)
    yield text_stl(CUBE).replace(b"\n", b"\r\n")
    yield (
        b"solid\nfacet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1 0\n"
        b" endloop\nendfacet\nendsolid\n"
    )
    yield bytes(84)
