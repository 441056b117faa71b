"""One random command line: it must end with a status of its own and one line of what is wrong.

Commands and options are those that click knows; values are valid ones, and what people and
programs might write in their place. The preset file is random, too.
"""

import io
import os
import random
import sys
import tempfile
import traceback
import warnings
from contextlib import chdir
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import click
import helpers_path  # noqa: F401
import numpy as np
import numpy.typing as npt
from cpu_limit import OverTimeError, cpu_limit

from cli.commands import pcsmooth
from pcsmooth.cli.main import main

CPU_SECONDS = 300.0
"""Time that a command may take, also one that compiles."""

_ODD = (
    "", " ", "x", "%", "-", "--", "nan", "inf", "-inf", "-1", "0", "1e309", "5e-324", "1e-300",
    "1e300",
    "0x10", "1_0", "1,5", "٣", "9" * 30, "9" * 5000, "\x1b[2J", "a\nb", "\udcff", "None", "true",
    "☃",
)  # fmt: skip
_LENGTHS = ("auto", "0.3", "3x", "2%", "1e-90x", "1e99", "1e-100", "0.1 %", "1e12x", "2X")
_NUMBERS = ("1", "2", "0.25", "1e-3", "12", "1e12", "1e-90", "1e99", "1e200")
_COUNTS = ("1", "2", "3", "12", "30")
_INPUTS = ("sphere.xyz", "curve.xy", "scan.ply", "table.csv", "odd.csv", "one.xyz", "huge.xyz")
_ODD_INPUTS = (
    "missing.ply", "folder", "*.xyz", "**/*", "loop.ply", "by\udcfftes.xyz", "tiny.xyz", "-",
    "empty.ply",
    "two\nlines.xyz", "bodies.toml",
)  # fmt: skip
_OUTPUTS = ("out.ply", "out.xyz", "out.csv", "out.pcd", "out.obj", "out.off", "out.txt")
_PICTURES, _MESHES = ("out.html", "out.png"), ("out.stl", "out.obj", "out.ply")
_ODD_OUTPUTS = (
    "missing/out.ply", "folder", "loop.ply", "out\udcff.ply", "out.docx", "-", "out", "new\x1b.xyz",
)  # fmt: skip

#: What options take, by the last of their names; others are choices and flags.
_VALUES = {
    "output": (_OUTPUTS, _ODD_OUTPUTS),
    "output-dir": (("made", "folder"), ("loop.ply", "scan.ply", "a/b/c", ".")),
    "suffix": (("_s", ".ply", "_smooth.xyz"), ("/", "..", "_\udcff")),
    "radius": (_LENGTHS, _ODD), "noise": (_LENGTHS, _ODD), "max-move": (_LENGTHS, _ODD),
    "step": (("auto", *_NUMBERS), _ODD), "stop": (_NUMBERS, _ODD),
    "iterations": (("0", "1", "2"), tuple(word for word in _ODD if not word.isdigit())),
    "support": (("auto", *_COUNTS), _ODD), "threads": (("1", "2"), ("99", "0", "-1", "x", "")),
    "jobs": (("1",), ("0", "-1", "x", "")), "workers": (("1",), ("0", "-1", "x", "")),
    "tile": (("auto", "off", "20", "50"), _ODD), "tile-folder": (("folder",), ("loop.ply", "no")),
    "scheduler": (("tcp://127.0.0.1:1",), ("nowhere", "")),
    "orient": (
        ("auto", "outward", "propagate", "input", "viewpoint=0,0,3", "direction=0,1"),
        ("viewpoint=", "direction=0,0,0", "viewpoint=1e149,0,0", "viewpoint=nan,0,0", *_ODD),
    ),
    "polyhedron": (("cube", "square", "octagon", "a", "b"), ("kube", "c", *_ODD)),
    "presets": (("bodies.toml",), ("missing.toml", "folder", "loop.ply", "scan.ply")),
    "fixed": (("label", "4"), ("nx", *_ODD)),
    "columns": (("1,2,3", "x,y,z"), ("1,1,2", "z", *_ODD)),
    "energy-log": (("log.csv",), _ODD_OUTPUTS), "report": (("page.html",), _ODD_OUTPUTS),
    "colormap": (("viridis", "coolwarm"), ("virides", *_ODD)),
    "color-by": (("mean", "gaussian", "curvature", "distance", "displacement"), _ODD),
    "reference": (_INPUTS, _ODD_INPUTS),
    "view": (("30,-60", "90,-90"), ("1e300,0", "nan,1", *_ODD)),
    "out": (("made",), ("loop.ply",)), "data": (("folder",), ("missing",)),
}  # fmt: skip

#: Share of odd values among those of options, and how often some options are given.
_ODD_SHARE = 0.12
_USUAL = {"output": 0.95, "overwrite": 0.8, "presets": 0.1, "polyhedron": 0.1}

#: Options that would take long or forever.
_LEFT_OUT = ("help", "version")

_PRESET_KEYS = (
    "normals", "offsets", "vertices", "mesh", "center", "generator", "facets", "sides", "height",
    "base",
    "scale", "rotate", "description", "kind", "lengths", "odd key",
)  # fmt: skip
_PRESET_VALUES = (
    "1", "2", "0", "-1", "1e-200", "1e200", "nan", "inf", "0.5", "true", "12", "9" * 400,
    "9" * 5000,
    '"cube"', '"a"', '"b"', '"c"', '"sphere"', '"box"', '"polygon"', '"prism"', '"platonic"',
    '"\\u001b"',
    '"scan.ply"', '"/dev/zero"', '"../x.stl"', "[]", "[1, 1, 1]", "[1, 1, 0.5]",
    "[1e-200, 1, 1e200]",
    "[[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]",
    "[[1, 0], [-1, 1], [-1, -1]]",
    "[[1e200, 0], [0, 1e200], [-1e200, -1e200]]", "[[1, 2], [3]]", "[[nan, 1], [2, 3], [4, 5]]",
    "{ axis = [0, 0, 1], degrees = 30 }", "{ axis = [0, 0, 0], degrees = nan }", "30", "1979-05-27",
    "[" * 3000 + "]" * 3000,
)  # fmt: skip


@dataclass(frozen=True)
class CommandTrial:
    """A command line and the preset file it may name."""

    arguments: tuple[str, ...]
    presets: bytes

    @property
    def command(self) -> str:
        """Name of the command."""
        return self.arguments[0]


@dataclass(frozen=True)
class Ending:
    """How a command ended: by its status, or with a fault."""

    kind: str
    detail: str = ""
    failed: bool = False


def command_trial(seed: int, index: int) -> CommandTrial:
    """Make one command line of a run."""
    rng = random.Random(f"{seed} {index}")
    name = rng.choices(
        (
            "denoise", "curvature", "convert", "info", "plot", "undo", "presets", "experiments",
            "warmup", "help",
        ),
        (20, 8, 4, 4, 4, 3, 6, 2, 1, 1),
    )[0]  # fmt: skip
    arguments = [name]
    if name == "experiments":
        arguments.append("--list")  # they take minutes
    parameters = main.commands[name].params
    several = rng.choice((0, 1, 1, 2, 2, 3, 6))
    chosen = rng.sample(parameters, min(several, len(parameters)))
    for parameter in parameters:
        arguments += _given(rng, name, parameter, parameter in chosen)
    return CommandTrial(tuple(arguments), _random_presets(rng))


def judged_command(case: CommandTrial) -> Ending:
    """Run a command line in a folder of its own, in this process."""
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        _fill(case.presets)
        try:
            with cpu_limit(CPU_SECONDS), warnings.catch_warnings():
                warnings.simplefilter("error")
                finished = pcsmooth(*case.arguments, stdin=_files()["scan.ply"])
        except (Exception, OverTimeError) as error:
            place = traceback.extract_tb(error.__traceback__)[-1]
            kind = f"{type(error).__name__} in {Path(place.filename).name}:{place.lineno}"
            return Ending(kind, traceback.format_exc(), failed=True)
        os.chdir(folder)
    lines = finished.stderr.splitlines()
    if finished.status not in (0, 1, 2):
        return Ending(f"status {finished.status}", finished.stderr, failed=True)
    if finished.status and not (lines and lines[-1].startswith("Error: ")):
        return Ending("no line that says what is wrong", finished.stderr, failed=True)
    if finished.status and sum(line.startswith("Error: ") for line in lines) > 1:
        return Ending("more than one error", finished.stderr, failed=True)
    if "; please report this" in finished.stderr:  # a batch tells of an exception so
        return Ending("a bug that is told", finished.stderr, failed=True)
    if any(not line.isprintable() for line in lines):
        return Ending("control characters", finished.stderr, failed=True)
    return Ending(f"status {finished.status}", finished.stderr)


def _given(
    rng: random.Random, command: str, parameter: click.Parameter, is_chosen: bool
) -> list[str]:
    """Give an argument, or an option with its value or without, or not at all."""
    if isinstance(parameter, click.Argument):
        if command in ("presets", "experiments"):
            return [_one_of(rng, ("cube", "a", "b"), _ODD)] * (rng.random() < 0.5)
        count = 1 if parameter.nargs == 1 else rng.choice((1, 1, 1, 1, 1, 2))
        return [_one_of(rng, _INPUTS, _ODD_INPUTS) for _ in range(count)]
    name = parameter.opts[-1].lstrip("-")
    if name in _LEFT_OUT:
        return []
    if not is_chosen and rng.random() > _USUAL.get(name, 0.0):
        return []
    option = rng.choice([*parameter.opts, *parameter.secondary_opts])
    if isinstance(parameter, click.Option) and parameter.is_flag:
        return [option]
    if isinstance(parameter.type, click.Choice):
        return [option, _one_of(rng, tuple(map(str, parameter.type.choices)), _ODD)]
    if name == "output" and command in ("plot", "presets"):
        return [option, _one_of(rng, _PICTURES if command == "plot" else _MESHES, _ODD_OUTPUTS)]
    return [option, _one_of(rng, *_VALUES.get(name, (_NUMBERS, _ODD)))]


def _one_of(rng: random.Random, usual: tuple[str, ...], odd: tuple[str, ...]) -> str:
    return rng.choice(odd if rng.random() < _ODD_SHARE else usual)


def _random_presets(rng: random.Random) -> bytes:
    """Write bodies called a, b and c, some of them right, some files damaged."""
    parts = []
    for name in "abc"[: rng.randint(1, 3)]:
        source = rng.choice(
            ('base = "cube"', 'base = "square"', 'generator = "sphere"\nfacets = 30', "")
        )
        others = [
            f'"{rng.choice(_PRESET_KEYS)}" = {rng.choice(_PRESET_VALUES)}'
            for _ in range(rng.choice((0, 0, 1, 2)))
        ]
        parts.append("\n".join([f"[{name}]", source, *others]))
    data = bytearray("\n".join(parts).encode())
    if rng.random() < 0.1:
        for _ in range(rng.randint(1, 4)):
            data[rng.randrange(len(data))] = rng.randrange(256)
    return bytes(data)


@cache
def _files() -> dict[str, bytes]:
    """Contents of the files that commands find."""
    rng = np.random.default_rng(0)
    sphere = rng.normal(size=(60, 3))
    sphere *= (1 + 0.02 * rng.normal(size=(60, 1))) / np.linalg.norm(sphere, axis=1)[:, None]
    angles = np.sort(rng.uniform(0, 2 * np.pi, 40))
    curve = np.c_[np.cos(angles), np.sin(angles)]

    def text(rows: npt.NDArray[np.float64], delimiter: str = " ", header: str = "") -> bytes:
        file = io.BytesIO()
        np.savetxt(file, rows, "%.9g", delimiter, header=header, comments="")
        return file.getvalue()

    scan = b"ply\nformat ascii 1.0\nelement vertex 60\n" + b"".join(
        f"property double {name}\n".encode() for name in ("x", "y", "z", "nx", "ny", "nz")
    )
    return {
        "sphere.xyz": text(sphere), "curve.xy": text(curve), "one.xyz": b"1 2 3\n",
        "huge.xyz": text(sphere * 1e120), "tiny.xyz": text(sphere * 1e-102),
        "scan.ply": scan + b"end_header\n" + text(np.c_[sphere, sphere]),
        "table.csv": text(np.c_[sphere, np.arange(60) % 2], ",", "x,y,z,label"),
        "odd.csv": b"x,y,z\n1,2,nan\n1e140,0,0\n0,0,1e-300\n" + text(sphere, ","),
        "by\udcfftes.xyz": text(sphere), "two\nlines.xyz": text(sphere), "empty.ply": b"",
    }  # fmt: skip


def _fill(presets: bytes) -> None:
    """Put the files into the working folder."""
    for name, data in _files().items():
        Path(name).write_bytes(data)
    Path("bodies.toml").write_bytes(presets)
    Path("folder").mkdir()
    Path("folder/inner.xyz").write_bytes(_files()["sphere.xyz"])
    Path("loop.ply").symlink_to("loop.ply")


def shown(case: CommandTrial) -> str:
    """Write a command line so that a program can run it again."""
    return f"{case.arguments!r}\n{case.presets!r}"


if __name__ == "__main__":
    print(shown(command_trial(int(sys.argv[1]), int(sys.argv[2]))))
