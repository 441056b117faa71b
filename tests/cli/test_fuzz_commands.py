"""Random command lines and presets: a part of the run, and that it finds what it looks for."""

from __future__ import annotations

import subprocess
import sys
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import click
import fuzz_command_trial
import pytest
from fuzz_command_trial import CommandTrial, command_trial, judged_command

from pcsmooth.cli.info import info
from pcsmooth.cli.main import main
from pcsmooth.errors import CloudFileError

pytestmark = pytest.mark.slow

GOOD = CommandTrial(("info", "sphere.xyz", "--json"), b"")


def test_random_command_lines() -> None:
    cases = [command_trial(2026, index) for index in range(120)]
    endings = [judged_command(case) for case in cases]
    assert [ending for ending in endings if ending.failed] == []
    kinds = Counter(ending.kind for ending in endings)
    assert kinds.keys() == {"status 0", "status 1", "status 2"}
    assert min(kinds.values()) > 15


def test_command_lines_are_the_same_for_the_same_seed() -> None:
    assert [command_trial(1, index) for index in range(50)] == [
        command_trial(1, index) for index in range(50)
    ]
    assert command_trial(2, 3) != command_trial(1, 3)


def test_every_command_and_option_has_its_turn() -> None:
    words = {word for index in range(9000) for word in command_trial(0, index).arguments}
    for name, command in main.commands.items():
        assert name in words
        for parameter in command.params:
            if isinstance(parameter, click.Option):
                assert words.intersection(parameter.opts), (name, parameter.opts)


def failing(error: BaseException) -> Callable[..., None]:
    def fail(**_options: object) -> None:
        raise error

    return fail


def warning(**_options: object) -> None:
    warnings.warn("overflow", RuntimeWarning, stacklevel=2)


def ringing(**_options: object) -> None:
    click.echo("\a", err=True)


def spinning(**_options: object) -> None:
    while True:
        pass


def two_errors(**_options: object) -> None:
    click.echo("Error: one", err=True)
    raise click.UsageError("two")


def telling_of_a_bug(**_options: object) -> None:
    raise CloudFileError("a.ply", "KeyError: 'oops'", "please report this")


@pytest.mark.parametrize(
    ("callback", "kind"),
    [
        (failing(ZeroDivisionError("oops")), "ZeroDivisionError in test_fuzz_commands.py:"),
        (failing(KeyboardInterrupt()), "status 130"),
        (warning, "RuntimeWarning in test_fuzz_commands.py:"),
        (ringing, "control characters"),
        (spinning, "OverTimeError in "),
        (two_errors, "more than one error"),
        (telling_of_a_bug, "a bug that is told"),
    ],
    ids=["exception", "status", "warning", "control", "time", "lines", "bug"],
)
def test_what_a_command_may_not_do(
    monkeypatch: pytest.MonkeyPatch, callback: Callable[..., None], kind: str
) -> None:
    assert judged_command(GOOD).kind == "status 0"
    monkeypatch.setattr(fuzz_command_trial, "CPU_SECONDS", 0.3)
    monkeypatch.setattr(info, "callback", callback)
    ending = judged_command(GOOD)
    assert ending.failed
    assert ending.kind.startswith(kind)


def test_the_command(tmp_path: Path) -> None:
    script = Path(fuzz_command_trial.__file__).with_name("fuzz_commands.py")
    done = subprocess.run(
        [sys.executable, str(script), "--runs", "4", "--seed", "5"],
        capture_output=True, cwd=tmp_path, timeout=240,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"4 command lines, seed 5, " in done.stdout
    assert b"| all | 4 | " in done.stdout
    assert list(tmp_path.iterdir()) == []
