"""The bar of a run, seen from the first second on."""

from __future__ import annotations

import io
import sys
import time
from typing import Any
from unittest import mock

import pytest

from pcsmooth.cli import progress_bar
from pcsmooth.cli.progress_bar import ProgressBar
from pcsmooth.files.notes import Say
from pcsmooth.progress import Progress
from pcsmooth.record import Record


class Terminal(io.StringIO):
    """A stream that says it is one."""

    def isatty(self) -> bool:
        return True


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    monkeypatch.setattr(progress_bar, "_TICK", 0.05)
    return Terminal()


def bar_on(stream: Terminal, say: Say, **options: Any) -> ProgressBar:
    with mock.patch.object(sys, "stderr", stream):
        return ProgressBar("folder/a\n.ply", 4, True, say, **options)


def ignored(_message: str) -> None:
    pass


def seen_soon(stream: Terminal, words: str) -> bool:
    end = time.monotonic() + 10.0
    while words not in stream.getvalue() and time.monotonic() < end:
        time.sleep(0.01)
    return words in stream.getvalue()


def test_it_is_seen_while_a_file_is_read_and_then_what_is_done(terminal: Terminal) -> None:
    with bar_on(terminal, ignored) as bar:
        assert seen_soon(terminal, "\ra\\n.ply: reading:   0%|")
        bar.tell(Progress("noise", 1, 1))
        assert seen_soon(terminal, "\ra\\n.ply: noise:  25%|")
        bar.begin("drawing the report")
        assert seen_soon(terminal, "\ra\\n.ply: drawing the report:  25%|")
        bar.tell(Progress("tiles", 0, 7))
        assert seen_soon(terminal, "0/7")
    length = len(terminal.getvalue())
    time.sleep(0.2)
    assert len(terminal.getvalue()) == length  # the clock has stopped


def test_messages_stand_above_it(terminal: Terminal) -> None:
    with (
        mock.patch.object(sys, "stderr", terminal),
        bar_on(terminal, lambda message: print(message, file=terminal)) as bar,
    ):
        assert seen_soon(terminal, "reading")
        bar.say("warning: so")
    assert "\rwarning: so\n" in terminal.getvalue()


def test_states_are_said_if_they_are_wanted() -> None:
    record = Record(1, 2.0, 3.0, 0.1, 0.2)
    said: list[str] = []
    for wanted in (False, True):
        with ProgressBar("a.ply", 4, False, said.append, says_states=wanted) as bar:
            bar.tell(Progress("steps", 1, 1, record))
    assert said == [record.in_words()]


def test_short_runs_show_none(terminal: Terminal, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress_bar, "_TICK", 5.0)
    with bar_on(terminal, ignored) as bar:
        bar.tell(Progress("noise", 1, 1))
    assert "reading" not in terminal.getvalue()
    assert "noise" not in terminal.getvalue()
