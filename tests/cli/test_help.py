"""Help, version, and what the command line costs before it works."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path

import click
import pytest

import pcsmooth
from cli.commands import pcsmooth as command
from cli.commands import process, succeeds
from pcsmooth.cli.help import COMMON, GROUPS, GroupedCommand, options_by_group
from pcsmooth.cli.main import main, run

COMMANDS = sorted(main.commands)
GROUPED = [name for name in COMMANDS if isinstance(main.commands[name], GroupedCommand)]
#: Arguments of commands that read no cloud, and what the help says of them.
ARGUMENTS = {
    "experiments": ("[NAME]...", "all or each NAME"),
    "plot": (
        "BEFORE AFTER",
        "BEFORE and AFTER side by side (PLY, LAS, PCD, E57, PTX, mesh or text; - is stdin)",
    ),
    "presets": ("[NAME]", "the body NAME"),
    "warmup": ("", ""),
    "help": ("[COMMAND]", "COMMAND with all its options"),
}
OPTIONS = [
    (name, parameter)
    for name in COMMANDS
    for parameter in main.commands[name].params
    if isinstance(parameter, click.Option)
]


def help_of(*names: str) -> str:
    finished = succeeds(*names, "--help")
    assert finished.stderr == ""
    return finished.stdout.decode()


def full_help_of(name: str) -> str:
    finished = succeeds("help", name)
    assert finished.stderr == ""
    return finished.stdout.decode()


def examples(text: str) -> list[str]:
    """Lines of help that a shell could run."""
    return [
        line.strip() for line in text.splitlines() if re.match(r" +(zcat \S+ \| )?pcsmooth ", line)
    ]


def test_the_commands() -> None:
    assert " ".join(COMMANDS) == (
        "convert curvature denoise experiments help info plot presets undo warmup"
    )
    text = help_of()
    for name in COMMANDS:
        assert re.search(rf"^  {name} +\S", text, re.MULTILINE)


@pytest.mark.parametrize("names", [[], *([name] for name in COMMANDS)], ids=str)
def test_h_is_help(names: list[str]) -> None:
    assert succeeds(*names, "-h").stdout.decode() == help_of(*names)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_says_what_it_does_and_takes(name: str) -> None:
    text = help_of(name)
    takes, words = ARGUMENTS.get(
        name, ("INPUT...", "INPUT (PLY, LAS, PCD, E57, PTX, mesh or text; - is stdin)")
    )
    assert text.startswith(f"Usage: pcsmooth {name} [OPTIONS] {takes}".rstrip() + "\n")
    assert words in " ".join(text.split())
    short_help = main.commands[name].get_short_help_str(200)
    assert short_help.endswith(".")


@pytest.mark.parametrize(
    ("name", "option"), OPTIONS, ids=[f"{name} {option.opts[-1]}" for name, option in OPTIONS]
)
def test_every_option_has_help(name: str, option: click.Option) -> None:
    assert option.help
    assert option.help.endswith((".", "]"))
    assert not option.hidden
    for text in (help_of(name), full_help_of(name)):
        assert re.search(rf"(?<!\S){option.opts[-1]}(?![\w-])", text)


def test_groups_name_options_of_commands_once() -> None:
    names = [name for group in GROUPS.values() for name in group]
    assert len(names) == len(set(names))
    assert set(names) <= {option.opts[0] for _, option in OPTIONS}


@pytest.mark.parametrize("name", GROUPED)
def test_the_short_help_explains_what_is_common(name: str) -> None:
    short, full = help_of(name), full_help_of(name)
    assert "Show this message and exit." in short
    assert short.count("\n") < 0.6 * full.count("\n")
    explained = [
        re.findall(r"^  (?:-\w, )?(--[\w-]+)", text.partition("Options:\n")[2], re.MULTILINE)
        for text in (short, full)
    ]
    command = main.commands[name]
    with click.Context(command, info_name=name) as context:
        groups = options_by_group(command, context)
    assert explained[0] == [option.opts[-1] for option in groups[COMMON]]
    assert explained[1] == [option.opts[-1] for group in groups.values() for option in group]


@pytest.mark.parametrize("name", COMMANDS)
def test_help_all_is_the_help_of_the_command_help(name: str) -> None:
    if name in GROUPED:
        assert succeeds(name, "--help-all").stdout.decode() == full_help_of(name)
    else:
        assert help_of(name) == full_help_of(name)


def test_help_without_a_command_lists_them() -> None:
    assert succeeds("help").stdout.decode() == help_of()


def test_help_of_no_command() -> None:
    finished = command("help", "smooth")
    assert finished.status == 2
    assert finished.stderr == (
        f"Error: there is no command 'smooth'; there are {', '.join(COMMANDS)}; "
        "see pcsmooth help --help\n"
    )


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ("pcsmooth den", ["plain,denoise"]),
        ("pcsmooth help cu", ["plain,curvature"]),
        ("pcsmooth denoise --keep-v", ["plain,--keep-volume"]),
        ("pcsmooth denoise --scheme f", ["plain,filter"]),
        ("pcsmooth denoise sc", ["file,sc"]),
        ("pcsmooth plot sc", ["file,sc"]),
        ("pcsmooth convert -o sc", ["file,sc"]),
        ("pcsmooth info --tile-folder sc", ["dir,sc"]),
    ],
)
def test_shells_can_complete(words: str, offered: list[str]) -> None:
    environment = {**os.environ, "_PCSMOOTH_COMPLETE": "bash_complete"}
    environment |= {"COMP_WORDS": words, "COMP_CWORD": str(words.count(" "))}
    program = "import sys; sys.argv[0] = 'pcsmooth'; from pcsmooth.cli.main import run; run()"
    done = subprocess.run(
        [sys.executable, "-c", program], env=environment, capture_output=True, text=True,
        timeout=60, check=True,
    )  # fmt: skip
    assert done.stdout.split() == offered


@pytest.mark.parametrize("names", [[], *([name] for name in COMMANDS)], ids=str)
def test_help_shows_examples_line_by_line(names: list[str]) -> None:
    text = help_of(*names)
    assert "Examples:\n" in text
    assert "\\b" not in text
    found = examples(text)
    assert len(found) >= 2
    assert all(" ".join(["pcsmooth", *names]) in example for example in found)


@pytest.mark.parametrize("names", [[], *([name] for name in COMMANDS)], ids=str)
def test_examples_are_commands(
    names: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("night.toml").touch()
    found = examples(help_of(*names))
    assert found
    for example in found:
        (words,) = (
            shlex.split(part) for part in example.split("|") if part.strip().startswith("pcsmooth")
        )
        with main.make_context("pcsmooth", words[1:]) as context:
            name, called, rest = main.resolve_command(context, words[1:])
            assert isinstance(called, click.Command)
            with called.make_context(name, rest, parent=context) as parsed:
                assert name in ARGUMENTS or parsed.params["names"]


@pytest.mark.parametrize("names", [[name] for name in COMMANDS], ids=str)
def test_help_fits_a_terminal(names: list[str]) -> None:
    for text in (help_of(*names), full_help_of(*names)):
        assert max(map(len, text.splitlines())) <= 80


def test_defaults_are_shown() -> None:
    text = " ".join(full_help_of("denoise").split())
    for default in ("volume", "cell", "auto", "6"):
        assert f"[default: {default}" in text


@pytest.mark.parametrize("name", ["curvature", "denoise"])
def test_commands_that_estimate_share_their_options(name: str) -> None:
    text = full_help_of(name)
    for option in (
        "--radius", "--support", "--orient", "--mean-convention", "--dialect", "--colormap",
        "--color-by", "--dim", "--threads", "--float / --double", "--overwrite", "--quiet",
        "--verbose", "--json",
    ):  # fmt: skip
        assert option in text


def test_version() -> None:
    finished = succeeds("--version")
    assert finished.stdout.decode().split() == ["pcsmooth,", "version", pcsmooth.__version__]


def test_without_arguments_the_help_is_shown() -> None:
    finished = command()
    assert finished.status in (0, 2)
    text = finished.stdout.decode() + finished.stderr
    assert text.startswith("Usage: pcsmooth [OPTIONS] COMMAND [ARGS]...\n")
    assert text.strip() == help_of().strip()


def test_the_module_can_be_run() -> None:
    finished = process("--version")
    assert (finished.status, finished.stderr) == (0, "")
    assert pcsmooth.__version__.encode() in finished.stdout


def test_the_console_script_is_the_same() -> None:
    (script,) = entry_points(group="console_scripts", name="pcsmooth")
    assert script.load() is run


@pytest.mark.parametrize(
    "arguments",
    [
        ["--help"],
        ["denoise", "--help"],
        ["curvature", "--help"],
        ["info", "-h"],
        ["convert", "-h"],
        ["plot", "-h"],
        ["presets", "-h"],
        ["experiments", "-h"],
        ["warmup", "-h"],
        ["help", "denoise"],
        ["--version"],
    ],
    ids=" ".join,
)
def test_help_loads_no_heavy_library(arguments: list[str]) -> None:
    program = (
        "import json, sys\n"
        "from pcsmooth.cli.main import run\n"
        "try:\n"
        "    run()\n"
        "except SystemExit as end:\n"
        "    assert end.code == 0\n"
        "    print(json.dumps(sorted(sys.modules)), file=sys.stderr)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments], capture_output=True, check=True, timeout=60
    )
    loaded = set(json.loads(done.stderr))
    assert "click" in loaded
    heavy = {"numba", "numpy", "scipy", "plyfile", "tqdm", "trimesh", "matplotlib"}
    heavy |= {"laspy", "lazrs", "pye57", "pcsmooth_experiments"}
    assert not loaded & heavy
