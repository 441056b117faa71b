"""Presets: those that are shipped, those of a file, and every way in which a file is wrong."""

from __future__ import annotations

import math
import os
import re
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from pcsmooth import CloudFileError, ConvexBody, InvalidInputError, load_presets
from pcsmooth.bodies.presets import find_preset, read_presets

#: Dimension, facets and vertices of what is shipped.
SHIPPED = {
    "cube": (3, 6, 8),
    "octahedron": (3, 8, 6),
    "bipyramid": (3, 8, 6),
    "tetrahedron": (3, 4, 4),
    "dodecahedron": (3, 12, 20),
    "icosahedron": (3, 20, 12),
    "hexagonal-prism": (3, 8, 12),
    "sphere-50": (3, 50, 96),
    "sphere-100": (3, 100, 196),
    "sphere-200": (3, 200, 396),
    "square": (2, 4, 4),
    "diamond": (2, 4, 4),
    "hexagon": (2, 6, 6),
    "octagon": (2, 8, 8),
    "circle-16": (2, 16, 16),
    "circle-32": (2, 32, 32),
    "circle-64": (2, 64, 64),
}

CUBE = np.array(list(product((-1.0, 1.0), repeat=3)))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A path for presets."""
    return tmp_path / "bodies.toml"


def body_of(file: Path, text: str) -> ConvexBody:
    """Body of the preset `it` in a file with this text."""
    file.write_text(text if "[it]" in text else f"[it]\n{text}")
    return load_presets(file)["it"]


def test_what_is_shipped() -> None:
    bodies = load_presets()
    assert list(bodies) == list(SHIPPED)
    assert len(bodies) == len(SHIPPED)
    for name, body in bodies.items():
        assert (body.dimension, len(body.facets), len(body.vertices)) == SHIPPED[name]
        assert body.offsets.tolist() == [1.0] * len(body.facets)
        assert body.is_symmetric == (name != "tetrahedron")
        preset = read_presets()[name]
        assert (preset.name, preset.source) == (name, "shipped")
        assert preset.description


def test_where_the_shipped_bodies_lie() -> None:
    bodies = load_presets()
    assert np.count_nonzero(bodies["cube"].normals) == 6
    assert np.count_nonzero(bodies["square"].normals) == 4
    assert np.count_nonzero(bodies["octahedron"].vertices) == 6
    assert np.count_nonzero(np.abs(bodies["diamond"].vertices) > 1e-15) == 4
    assert np.array_equal(bodies["bipyramid"].normals, bodies["octahedron"].normals)
    assert np.ptp(bodies["hexagonal-prism"].vertices[:, 2]) == 2.0


def test_bodies_are_made_once_and_when_asked_for() -> None:
    presets = read_presets()
    assert "body" not in vars(presets["sphere-200"])
    assert presets["cube"].body is presets["cube"].body
    assert "body" not in vars(presets["sphere-200"])


def test_normals(file: Path) -> None:
    body = body_of(file, "normals = [[1, 1], [-1, 1], [-1, -1], [1, -1]]")
    assert body.offsets == pytest.approx(math.sqrt(0.5))  # n . x <= 1
    assert body.volume == pytest.approx(2.0)
    body = body_of(file, "normals = [[1, 0], [0, 1], [-3, -4]]\noffsets = [1, 2, 10.0]")
    assert body.offsets.tolist() == [1.0, 2.0, 2.0]


def test_vertices(file: Path) -> None:
    body = body_of(file, "vertices = [[1, 0], [0, 1], [-1, -1], [0, 0]]")
    assert len(body.vertices) == 3
    body = body_of(file, "vertices = [[0, 0], [3, 0], [0, 3]]\ncenter = true")
    np.testing.assert_allclose(body.vertices.sum(axis=0), 0.0, atol=1e-15)


@pytest.mark.parametrize("suffix", ["stl", "ply", "obj", "off"])
def test_mesh(file: Path, suffix: str) -> None:
    (file.parent / "meshes").mkdir()
    rock = trimesh.creation.box((1, 2, 3))
    rock.apply_translation((10, 20, 30))
    rock.export(file.parent / "meshes" / f"rock.{suffix}")
    body = body_of(file, f'mesh = "meshes/rock.{suffix}"\ncenter = true')
    assert sorted(body.offsets.tolist()) == pytest.approx([0.5, 0.5, 1.0, 1.0, 1.5, 1.5])
    assert body.is_symmetric


def test_a_mesh_in_single_precision(file: Path) -> None:
    exact = load_presets()["dodecahedron"].rotated(
        Rotation.from_rotvec([0.1, 0.2, 0.3]).as_matrix()
    )
    trimesh.Trimesh(exact.vertices, exact.simplices).export(file.parent / "rock.stl")
    body = body_of(file, 'mesh = "rock.stl"')
    assert len(body.facets) == 12
    assert body.volume == pytest.approx(exact.volume, rel=1e-6)


@pytest.mark.parametrize(
    ("text", "facets", "volume"),
    [
        ('generator = "box"\nedges = [1, 2, 4]', 6, 64.0),
        ('generator = "prism"\nsides = 4', 6, 8.0),
        ('generator = "prism"\nsides = 4\nheight = 1', 6, 4.0),
        ('generator = "platonic"\nfacets = 6', 6, 8.0),
        ('generator = "sphere"\nfacets = 6', 6, 8.0),
        ('generator = "polygon"\nsides = 4', 4, 4.0),
    ],
)
def test_generators(file: Path, text: str, facets: int, volume: float) -> None:
    body = body_of(file, text)
    assert len(body.facets) == facets
    assert body.volume == pytest.approx(volume)


def test_base(file: Path) -> None:
    text = '[it]\nbase = "brick"\nscale = 2\n[brick]\nbase = "cube"\nscale = [1, 1, 0.5]\n'
    body = body_of(file, text)
    assert np.abs(body.vertices).tolist() == [[2.0, 2.0, 1.0]] * 8


def test_scaling_comes_before_turning(file: Path) -> None:
    text = 'base = "cube"\nscale = [2, 1, 1]\nrotate = { axis = [0, 0, 3], degrees = 90 }'
    np.testing.assert_allclose(np.abs(body_of(file, text).vertices), [[1, 2, 1]] * 8)


def test_turning_is_counter_clockwise(file: Path) -> None:
    text = "vertices = [[2, 0], [-1, 1], [-1, -1]]\nrotate = 90"
    assert np.abs(body_of(file, text).vertices - [0, 2]).sum(axis=1).min() < 1e-14
    text = (
        "vertices = [[2, 0, 0], [-1, 1, 0], [-1, -1, 1], [-1, -1, -1]]\n"
        "rotate = { axis = [0, 0, 1], degrees = 90.0 }"
    )
    assert np.abs(body_of(file, text).vertices - [0, 2, 0]).sum(axis=1).min() < 1e-14
    assert body_of(file, 'base = "square"\nrotate = 0').volume == 4.0


def test_a_file_adds_to_what_is_shipped(file: Path) -> None:
    file.write_text('[brick]\nbase = "cube"\ndescription = "a brick"\n[other]\nbase = "brick"\n')
    presets = read_presets(file)
    assert list(presets) == [*SHIPPED, "brick", "other"]
    assert presets["brick"].source == str(file)
    assert presets["brick"].description == "a brick"
    assert presets["other"].description == ""
    assert presets["cube"].source == "shipped"
    assert read_presets(str(file)).keys() == presets.keys()


def test_the_shipped_file_is_an_example_of_a_users(file: Path) -> None:
    shipped = Path(read_presets()["cube"].path).read_text()
    file.write_text(re.sub(r"^\[|(?<=base = \")", r"\g<0>my-", shipped, flags=re.MULTILINE))
    presets = read_presets(file)
    for name in SHIPPED:
        assert presets[f"my-{name}"].body.volume == presets[name].body.volume


def test_find_preset(file: Path) -> None:
    file.write_text('[brick]\nbase = "cube"\n')
    assert find_preset("brick", file).name == "brick"
    assert find_preset("cube", dimension=3).body.dimension == 3
    with pytest.raises(InvalidInputError, match=r"no preset 'brik'; did you mean brick\?"):
        find_preset("brik", file)
    with pytest.raises(InvalidInputError, match="no preset 'torus'; use one of bipyramid, circle"):
        find_preset("torus")
    with pytest.raises(
        InvalidInputError,
        match=r"'cube' is a body in 3D, but the points have 2 coordinates; "
        "use one of square, diamond, hexagon, octagon, circle-16, circle-32, circle-64",
    ):
        find_preset("cube", file, dimension=2)


#: What the preset `it` says, fault and remedy.
FAULTS = {
    "nothing": ("", "it is made of nothing; give exactly one of normals, vertices, mesh, gen"),
    "two sources": (
        'base = "cube"\nvertices = [[1, 2]]',
        "it is made of base and vertices; give exactly one",
    ),
    "misspelt source": ("vertexes = [[1, 2]]", "no key 'vertexes'; did you mean vertices?"),
    "misspelt key": ('base = "cube"\nscal = 2', "no key 'scal'; did you mean scale?"),
    "strange key": ('base = "cube"\ncolour = 2', "no key 'colour'; use one of base, desc"),
    "key of another": ('base = "cube"\noffsets = [1]', "no key 'offsets'; use one of"),
    "inner table": ('base = "cube"\n[it.inner]', "no key 'inner'"),
    "description": ('base = "cube"\ndescription = 1', "description is 1; it must be a text"),
    "base a number": ("base = 3", "base is 3; it must be a text in quotes"),
    "center a word": ('vertices = [[1]]\ncenter = "yes"', "center is 'yes'; it must be true or"),
    "vertices a word": ('vertices = "many"', "vertices are not an array of real numbers"),
    "normals a number": ("normals = 3", r"normals have shape \(\)"),
    "offsets": ("normals = [[1, 0], [0, 1], [-1, -1]]\noffsets = [1, 1]", "offsets have shape"),
    "not inside": (
        "vertices = [[1, 1], [2, 1], [1, 2]]",
        "the origin must lie strictly inside the body; move or center it",
    ),
    "generator": ('generator = "spher"', "no generator 'spher'; did you mean sphere?"),
    "no such generator": ('generator = "torus"', "use one of box, platonic, polygon, prism, sph"),
    "missing parameter": ('generator = "sphere"', "generator 'sphere' lacks facets; add it"),
    "parameter": ('generator = "sphere"\nfacet = 9', "no key 'facet'; did you mean facets?"),
    "wrong parameter": ('generator = "sphere"\nfacets = 2', "facets is 2; it must be a whole"),
    "base": ('base = "cub"', "no preset 'cub' to base it on; did you mean cube"),
    "itself": ('base = "it"', "based on itself: it -> it; give one of them a shape"),
    "circle": (
        '[it]\nbase = "that"\n[that]\nbase = "this"\n[this]\nbase = "it"',
        "based on itself: it -> that -> this -> it; give",
    ),
    "base in a circle": (
        '[it]\nbase = "that"\n[that]\nbase = "that"',
        "based on itself: it -> that -> that; give",
    ),
    "scale": ('base = "cube"\nscale = [1, 2]', r"scale is \[1, 2\]; it must be a number or 3"),
    "no scale": ('base = "cube"\nscale = 0.0', "scale is 0.0; it must be finite and positive"),
    **{
        f"rotate {name}": (
            f'base = "cube"\nrotate = {rotate}',
            r"rotate is .*; in 3D write \{ axis = \[0, 0, 1\], degrees = 45 \}",
        )
        for name, rotate in {
            "number": "45",
            "no degrees": "{ axis = [0, 0, 1] }",
            "more": "{ axis = [0, 0, 1], degrees = 45, radians = 1 }",
            "short axis": "{ axis = [0, 1], degrees = 45 }",
            "zero axis": "{ axis = [0, 0, 0], degrees = 45 }",
            "word axis": '{ axis = ["x", 0, 0], degrees = 45 }',
            "NaN axis": "{ axis = [nan, 0, 1], degrees = 45 }",
            "infinite": "{ axis = [0, 0, 1], degrees = inf }",
            "word": '{ axis = [0, 0, 1], degrees = "45" }',
        }.items()
    },
    "rotate in a plane": (
        'base = "square"\nrotate = { axis = [0, 0, 1], degrees = 45 }',
        "rotate is .*; in 2D write a number of degrees",
    ),
    "no mesh": ('mesh = "none.stl"', "mesh .*none.stl: no such file or folder; check the path"),
    "mesh a folder": ('mesh = "folder.stl"', "mesh .*folder.stl: a folder stands where"),
    "mesh with a zero byte": (
        'mesh = "a\\u0000.stl"',
        r"mesh 'a\\x00\.stl' is no name of a file; correct it",
    ),
    "mesh a pipe": ('mesh = "pipe.stl"', "mesh .*pipe.stl: is a named pipe; name a file"),
    "mesh of no kind": ('mesh = "rock.doc"', "rock.doc: its suffix '.doc' is of no mesh; use one"),
    "broken mesh": ('mesh = "broken.off"', "broken.off: cannot be read as a mesh .*; check"),
    "empty mesh": ('mesh = "empty.stl"', "empty.stl: holds no triangles; give a mesh"),
    "flat mesh": ('mesh = "flat.off"', "the vertices lie in a plane; add others"),
}


@pytest.mark.parametrize(("text", "message"), FAULTS.values(), ids=FAULTS)
def test_faults_of_a_preset(file: Path, text: str, message: str) -> None:
    (file.parent / "folder.stl").mkdir()
    os.mkfifo(file.parent / "pipe.stl")
    (file.parent / "broken.off").write_text("not a mesh")
    (file.parent / "empty.stl").write_bytes(b"")
    square = "1 0 0\n0 1 0\n-1 0 0\n0 -1 0\n"
    (file.parent / "flat.off").write_text(f"OFF\n4 2 0\n{square}3 0 1 2\n3 0 2 3\n")
    with pytest.raises(CloudFileError, match=message) as found:
        body_of(file, text)
    assert str(found.value).startswith(f"{file}: preset 'it': ")
    assert found.value.path == str(file)


class TestMeshesOutside:
    """A file that somebody else wrote reads nothing of mine."""

    @pytest.fixture
    def inner(self, tmp_path: Path) -> Path:
        """A path for presets in a folder, beside which there is a mesh."""
        trimesh.creation.box((2, 2, 2)).export(tmp_path / "box.stl")
        (tmp_path / "inner").mkdir()
        return tmp_path / "inner" / "bodies.toml"

    @pytest.mark.parametrize("name", ["../box.stl", "{folder}/box.stl", "link.stl", "../none.stl"])
    def test_are_refused_unless_they_are_allowed(self, inner: Path, name: str) -> None:
        (inner.parent / "link.stl").symlink_to("../box.stl")
        name = name.format(folder=inner.parent.parent)
        inner.write_text(f"[it]\nmesh = '{name}'")
        message = "preset 'it': mesh .* lies outside of the folder .*; pass --allow-outside if you"
        with pytest.raises(CloudFileError, match=message):
            load_presets(inner)
        with pytest.raises(CloudFileError, match=message):
            find_preset("it", inner)
        if "none" in name:
            with pytest.raises(CloudFileError, match=r"none\.stl: no such file"):
                load_presets(inner, allow_outside=True)
        else:
            assert load_presets(inner, allow_outside=True)["it"].volume == 8.0
            assert find_preset("it", inner, allow_outside=True).body.volume == 8.0

    @pytest.mark.parametrize("name", ["box.stl", "{folder}/box.stl", "../inner/box.stl", "link"])
    def test_what_lies_in_the_folder_is_read(self, inner: Path, name: str) -> None:
        (inner.parent.parent / "box.stl").rename(inner.parent / "box.stl")
        (inner.parent.parent / "link").symlink_to("inner")
        inner.write_text(f"[it]\nmesh = '{name.format(folder=inner.parent)}'".replace(
            "'link'", "'box.stl'"
        ))  # fmt: skip
        path = inner.parent.parent / "link" / inner.name if name == "link" else inner
        assert load_presets(path)["it"].volume == 8.0


#: Bytes of the file, fault and remedy.
BROKEN_FILES = {
    "prose": (b"Dear all,", "is not TOML .*; correct it"),
    "bytes": (b"\xff\xfe", "is not TOML"),
    "twice": (b"[a]\n[a]\n", "is not TOML"),
    "outside": (b"scale = 2\n", r"'scale' stands outside of a table; write a table such as \[scal"),
    "several": (b"[[rock]]\n", "'rock' stands outside of a table"),
    "shipped": (b'[cube]\nbase = "square"\n', "preset 'cube' is shipped with pcsmooth; choose ano"),
}


@pytest.mark.parametrize(("content", "message"), BROKEN_FILES.values(), ids=BROKEN_FILES)
def test_broken_files(file: Path, content: bytes, message: str) -> None:
    file.write_bytes(content)
    with pytest.raises(CloudFileError, match=message) as found:
        load_presets(file)
    assert str(found.value).startswith(f"{file}: ")


def test_missing_files(tmp_path: Path) -> None:
    with pytest.raises(CloudFileError, match=r"none.toml: no such file or folder; check the path"):
        load_presets(tmp_path / "none.toml")
    with pytest.raises(CloudFileError, match="a folder stands where a file should"):
        read_presets(tmp_path)


@pytest.mark.parametrize("size", ["1e-200", "1e200", "1e-320", "1e31"])
@pytest.mark.parametrize(
    "text",
    [
        'base = "cube"\nscale = {}',
        "vertices = [[{0}, 0], [0, {0}], [-{0}, -{0}]]",
        "normals = [[1, 0], [-1, 1], [-1, -1]]\noffsets = [{0}, {0}, {0}]",
        'generator = "sphere"\nfacets = 12\nscale = {}',
    ],
)
def test_bodies_too_large_or_small_to_be_measured(file: Path, text: str, size: str) -> None:
    with pytest.raises(
        CloudFileError, match=r"preset 'it': .*bodies are from 1e-30 to 1e\+30 large; "
    ):
        body_of(file, text.format(size))


def test_bodies_of_the_largest_and_the_least_size(file: Path) -> None:
    for size in (1e-29, 1e29):
        body = body_of(file, f'base = "cube"\nscale = {size}')
        assert body.volume == pytest.approx(8 * size**3)


@pytest.mark.parametrize(
    ("text", "cause"),
    [
        ("vertices = " + "[" * 20_000 + "]" * 20_000, "is nested too deeply; correct it there"),
        (
            "vertices = " + "{ a = " * 20_000 + "1" + " }" * 20_000,
            "is nested too deeply; correct it",
        ),
        ('base = "cube"\nscale = ' + "9" * 5000, r"is not TOML \(.* 5000 digits.*\); correct it"),
    ],
    ids=["arrays", "tables", "digits"],
)
def test_files_that_go_too_far(file: Path, text: str, cause: str) -> None:
    with pytest.raises(CloudFileError, match=cause):
        body_of(file, text)


def chain(count: int) -> str:
    """Presets of which each is based on the next, and the last on the cube."""
    bases = [f'[b{k}]\nbase = "b{k + 1}"' for k in range(count - 1)]
    return "\n".join([*bases, f'[b{count - 1}]\nbase = "cube"'])


def test_long_chains_of_bases(file: Path) -> None:
    file.write_text(chain(100))
    assert load_presets(file)["b0"].volume == pytest.approx(8)
    file.write_text(chain(3000))
    with pytest.raises(
        CloudFileError, match="'b0': it is based on more than 100 others, one on the"
    ):
        load_presets(file)
