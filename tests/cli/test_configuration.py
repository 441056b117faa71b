"""Options from a configuration file."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from cli.clouds import save_ply, sphere, vertices
from cli.commands import Finished, pcsmooth, process, succeeds

#: Files that are refused, and what is said of them; the first part is the file.
WRONG = {
    "no command": ("[denois]\n", "there is no command 'denois'; did you mean denoise?"),
    "other command": ("[presets]\n", "there is no command 'presets'; use one of convert, "),
    "no table": ("denoise = 1\n", "'denoise' stands outside of a table; write .* [denoise]"),
    "no list": (
        "[denoise.files]\nnoise = 1\n",
        "'files' is no list of tables; write [[denoise.files]]",
    ),
    "no tables": ("[denoise]\nfiles = [1]\n", "'files' is no list of tables"),
    "no pattern": ("[[denoise.files]]\nnoise = 1\n", "number 1 has no pattern; write one"),
    "empty pattern": ("[[denoise.files]]\npattern = ''\n", "number 1 has no pattern; write one"),
    "no patterns": ("[[denoise.files]]\npattern = [1]\n", "number 1 has no pattern; write one"),
    "no option": ("[denoise]\nnois = 1\n", "no option 'nois' that a file can give; did you mean"),
    "output": ("[denoise]\noutput = 'a.ply'\n", "no option 'output' that a file can give; "),
    "twice": ("[denoise]\nfloat = true\ndouble = false\n", "has --double twice; leave out one"),
    "of the run": (
        "[[denoise.files]]\npattern = '*'\njobs = 2\n",
        "'jobs' is of the whole run; put it into [denoise]",
    ),
    "no flag": ("[denoise]\nclosed = 1\n", "'closed' is not true or false; correct it"),
    "flag": ("[denoise]\nnoise = true\n", "'noise' is not a number, a text or a list"),
    "date": ("[denoise]\nnoise = 2026-01-01\n", "'noise' is not a number, a text or a list"),
    "nothing": ("[denoise]\nbox = []\n", "'box' is not a number, a text or a list"),
    "lists": ("[denoise]\nbox = [[1]]\n", "'box' is not a number, a text or a list"),
    "flags": ("[denoise]\nbox = [true]\n", "'box' is not a number, a text or a list"),
    "value": ("[denoise]\nenergy = 'are'\n", "energy: 'are' is not one of 'volume', 'area'; "),
    "remedy": ("[denoise]\nnoise = 'x'\n", "noise: noise 'x' is not a positive length; give a "),
    "digits": (f"[denoise]\nnoise = 0x{5000 * 'f'}\n", "'noise' is not a number, a text or a list"),
    "null": ("[denoise]\npolygon = 'a\\u0000'\n".replace("'", '"'), "has a null character"),
    "elsewhere": ("[denoise]\nsuffix = '/../x'\n", "'/../x' is not part of a name; "),
    "fits nothing": ("[[denoise.files]]\npattern = '.'\n", "number 1: '.' fits no name; write"),
    "toml": ("[denoise\n", "is not TOML .*; correct it there"),
}

#: Options that are taken from a file that is named only, as anybody may have put down the other.
GUARDED = {
    "output-dir": "'x'",
    "overwrite": "true",
    "report": "'x.html'",
    "energy-log": "'x.csv'",
    "tile-folder": "'x'",
    "scheduler": "'tcp://host:1'",
    "allow-outside": "true",
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a few clouds in it."""
    monkeypatch.chdir(tmp_path)
    for seed, name in enumerate(("near_a", "near_b", "far")):
        save_ply(tmp_path / f"{name}.ply", vertices(sphere(60 + seed, seed=seed), "f8"))
    return tmp_path


def configured(text: str) -> None:
    Path("pcsmooth.toml").write_text(text)


def in_force(finished: Finished) -> dict[str, Any]:
    return tomllib.loads(finished.stdout.decode())


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_with_a_file(folder: Path, name: str) -> None:
    text, told = WRONG[name]
    Path("mine.toml").write_text(text)
    finished = pcsmooth("denoise", "far.ply", "-o", "out.ply", "--config", "mine.toml")
    assert finished.status == 1
    pattern = re.escape(told).replace(r"\.\*", ".*")
    assert re.search(rf"^Error: mine\.toml: .*{pattern}", finished.stderr)
    assert sorted(folder.glob("out*")) == []


@pytest.mark.usefixtures("folder")
def test_a_file_that_is_not_there() -> None:
    finished = pcsmooth("denoise", "far.ply", "-o", "out.ply", "--config", "none.toml")
    assert finished.status == 1
    assert finished.stderr.startswith("Error: none.toml: no such file")


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("name", GUARDED)
def test_a_file_that_was_only_found_neither_writes_nor_tells_others(name: str) -> None:
    configured(f"[denoise]\n{name} = {GUARDED[name]}\n")
    command = ["denoise", "--print-config"]
    finished = pcsmooth(*command)
    assert finished.status == 1
    assert f"{name!r} is not taken from a file that only lies in the folder" in finished.stderr
    assert finished.stderr.rstrip().endswith("name it by --config pcsmooth.toml")
    named = in_force(succeeds(*command, "--config", "pcsmooth.toml"))
    assert named["denoise"][name] == in_force(
        succeeds(*command, "--no-config", f"--{name}", *_value(name))
    )["denoise"].get(name)


def _value(name: str) -> list[str]:
    return [] if GUARDED[name] == "true" else [GUARDED[name].strip("'")]


@pytest.mark.usefixtures("folder")
def test_the_command_line_wins_over_patterns_and_these_over_the_rest() -> None:
    configured(
        "[denoise]\nstrength = 0.1\nmotion = 'normal'\n"
        "[[denoise.files]]\npattern = 'near*'\nstrength = 0.2\n"
        "[[denoise.files]]\npattern = ['*_b.ply', 'nothing']\nstrength = 0.3\n"
        "[curvature]\nsupport = 12\n"
    )
    command = ["denoise", "far.ply", "near_a.ply", "near_b.ply", "--output-dir", "out", "--json"]

    def strengths(*options: object) -> list[tuple[float, str]]:
        told = succeeds(*command, "--overwrite", *options).stdout.splitlines()
        return [(each["strength"], each["motion"]) for each in map(json.loads, told)]

    assert strengths() == [(0.1, "normal"), (0.2, "normal"), (0.3, "normal")]
    assert strengths("--strength", "0.4", "--motion", "free") == [(0.4, "free")] * 3
    assert strengths("--no-config") == [(1.0, "free")] * 3


@pytest.mark.usefixtures("folder")
def test_one_file_gets_what_a_batch_would_give_it() -> None:
    configured("[[denoise.files]]\npattern = 'near*'\nstrength = 0.2\nnoise = 0.01\n")
    one = succeeds("denoise", "near_a.ply", "-o", "one.ply", "--json")
    assert (one.json["strength"], one.json["noise"]) == (0.2, 0.01)
    assert (
        "options of pcsmooth.toml [[denoise.files]] number 1, for 1 file: strength = 0.2, "
        "noise = 0.01\n"
    ) in one.stderr
    succeeds("denoise", "near_a.ply", "--output-dir", "many", "-q")
    assert Path("one.ply").read_bytes() == Path("many/near_a.ply").read_bytes()
    stdin = Path("near_a.ply").read_bytes()
    configured("[[denoise.files]]\npattern = '*'\nstrength = 0.2\n")
    stream = succeeds("denoise", "-", "-o", "stream.ply", "--json", stdin=stdin)
    assert stream.json["strength"] == 1.0


@pytest.mark.usefixtures("folder")
@pytest.mark.usefixtures("quick_workers")
def test_files_that_are_worked_on_in_other_processes_get_theirs() -> None:
    configured("[[curvature.files]]\npattern = 'near_a.*'\nsupport = 14\n")
    command = ["curvature", "near_a.ply", "near_b.ply", "--output-dir", "out", "--json"]
    told = succeeds(*command, "--support", "auto", "--jobs", 2).stdout.splitlines()
    assert [json.loads(each)["curvature_support"] == 14 for each in told] == [False, False]
    told = succeeds(*command, "--overwrite", "--jobs", 2).stdout.splitlines()
    assert [json.loads(each)["curvature_support"] == 14 for each in told] == [True, False]


@pytest.mark.usefixtures("folder")
def test_what_the_file_gives_is_said_but_not_to_the_quiet() -> None:
    configured("[denoise]\nmotion = 'normal'\ncolumns-extra = ['sigma']\n")
    command = ["denoise", "far.ply", "-o", "out.ply"]
    assert succeeds(*command).stderr.startswith(
        'options of pcsmooth.toml [denoise]: motion = "normal", columns-extra = ["sigma"]\n'
    )
    assert b"property float scalar_sigma" in Path("out.ply").read_bytes()
    assert succeeds(*command, "-q", "--overwrite").stderr == ""
    assert "options of" not in succeeds(*command, "--no-config", "--overwrite").stderr


@pytest.mark.usefixtures("folder")
def test_options_that_do_not_go_together_name_the_file() -> None:
    configured("[[denoise.files]]\npattern = 'n*'\nenergy = 'area'\n")
    command = ["denoise", "far.ply", "near_a.ply", "--output-dir", "out"]
    finished = pcsmooth(*command, "--scheme", "filter")
    assert finished.status == 2
    assert (
        "Error: --energy needs --scheme euler or implicit, not --scheme filter; "
        'pcsmooth.toml [[denoise.files]] number 1 gives energy = "area"; see '
    ) in finished.stderr
    assert not Path("out").exists()  # before any work is done
    both = pcsmooth(*command, "--config", "pcsmooth.toml", "--no-config")
    assert both.status == 2
    assert "--config and --no-config exclude each other" in both.stderr


@pytest.mark.usefixtures("folder")
def test_a_single_output_has_no_options_of_batches() -> None:
    Path("night.toml").write_text(
        "[denoise]\noutput-dir = 'out'\nsuffix = '_s'\njobs = 2\nskip-existing = true\n"
    )
    succeeds("denoise", "far.ply", "--config", "night.toml", "-o", "one.ply")
    assert not Path("out").exists()
    succeeds("denoise", "far.ply", "--config", "night.toml")
    assert Path("out/far_s.ply").exists()


@pytest.mark.usefixtures("folder")
def test_what_is_in_force_is_shown_with_its_origin_and_can_be_used_again() -> None:
    configured(
        "[denoise]\nstrength = 0.5\ncolumns-extra = ['sigma']\nbox = [0, 0, 1, 1]\ndouble = true\n"
        "where = \"label == '\\\\n'\"\n[[denoise.files]]\npattern = 'near*'\nstrength = 0.25\n"
    )
    shown = succeeds("denoise", "--print-config", "--noise", "0.3x", "--closed", "-o", "a.ply")
    lines = shown.stdout.decode().splitlines()
    for line in (
        '# output = "a.ply"  # command line',
        'noise = "0.3x"  # command line',
        "closed = true  # command line",
        "strength = 0.5  # pcsmooth.toml [denoise]",
        'columns-extra = ["sigma"]  # pcsmooth.toml [denoise]',
        "float = false  # pcsmooth.toml [denoise]",
        "jobs = 1  # default",
        "# iterations is not given",
        "strength = 0.25  # pcsmooth.toml [[denoise.files]] number 1",
    ):
        assert line in lines
    assert shown.stderr == ""
    Path("saved.toml").write_bytes(shown.stdout)
    again = succeeds("denoise", "--print-config", "--config", "saved.toml")
    assert in_force(again) == in_force(shown)
    won = succeeds("denoise", "--print-config", "--strength", 1).stdout.decode()
    assert "strength = 0.25  # not in force: the command line wins" in won
    wrong = pcsmooth("denoise", "--print-config", "--noise", "x")
    assert wrong.status == 2
    assert "Invalid value for '--noise'" in wrong.stderr


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("command", ["convert", "curvature", "denoise", "info", "plot", "undo"])
def test_commands_that_read_clouds_can_be_configured(command: str) -> None:
    configured(f"[{command}]\ndim = 2\n")
    shown = succeeds(command, "--print-config").stdout.decode()
    assert 'dim = "2"  # pcsmooth.toml' in shown
    assert in_force(succeeds(command, "--print-config"))[command]["dim"] == "2"


@pytest.mark.usefixtures("folder")
def test_only_options_in_force_are_said() -> None:
    configured(
        "[denoise]\nsuffix = '_s'\nstrength = 0.5\nmotion = 'normal'\n"
        "[[denoise.files]]\npattern = 'far*'\nstrength = 0.6\n"
    )
    command = ["denoise", "far.ply", "-o", "out.ply", "--overwrite"]
    told = succeeds(*command).stderr.splitlines()
    assert told[:2] == [
        'options of pcsmooth.toml [denoise]: strength = 0.5, motion = "normal"',
        "options of pcsmooth.toml [[denoise.files]] number 1, for 1 file: strength = 0.6",
    ]
    told = succeeds(*command, "--strength", "0.7").stderr.splitlines()
    assert [line for line in told if line.startswith("options of")] == [
        'options of pcsmooth.toml [denoise]: motion = "normal"'
    ]
    assert "options of" not in succeeds(*command, "--strength", 1, "--motion", "free").stderr


@pytest.mark.usefixtures("folder")
def test_what_is_no_number_is_written_as_toml() -> None:
    found = in_force(succeeds("denoise", "--strength", "nan", "--print-config"))
    assert repr(found["denoise"]["strength"]) == "nan"


@pytest.mark.usefixtures("folder")
def test_help_does_not_mind_what_is_wrong_with_the_file() -> None:
    configured("[denoise\n")
    assert succeeds("denoise", "--help").stdout == succeeds("denoise", "-h", "--no-config").stdout
    succeeds("help", "denoise")
    assert pcsmooth("denoise", "--print-config").status == 1
    succeeds("denoise", "--print-config", "--no-config")


def test_a_process_of_its_own(folder: Path) -> None:
    configured("[info]\nthreads = 1\n")
    finished = process("info", folder / "far.ply")
    assert finished.status == 0
    assert finished.stderr.startswith("options of pcsmooth.toml [info]: threads = 1\n")
