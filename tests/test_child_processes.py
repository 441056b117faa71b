from __future__ import annotations

import signal
import time

import pytest

from pcsmooth.child_processes import deaf_to_interrupts, end_children, spawning


def sleep_on(ready: object, *, is_stubborn: bool) -> None:
    if is_stubborn:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.raise_signal(number)  # as from a terminal, and when it is closed
    ready.set()  # type: ignore[attr-defined]
    time.sleep(600.0)


@pytest.mark.parametrize("is_stubborn", [False, True])
def test_children_hear_no_interrupt_and_end(is_stubborn: bool) -> None:
    context = spawning()
    ready = context.Event()
    child = context.Process(target=sleep_on, args=(ready,), kwargs={"is_stubborn": is_stubborn})
    with deaf_to_interrupts():
        child.start()
    while not ready.wait(0.5):
        assert child.is_alive()
    assert child.is_alive()
    end_children(0.2 if is_stubborn else 60.0)
    child.join(60.0)
    assert child.exitcode == -(signal.SIGKILL if is_stubborn else signal.SIGTERM)


def test_the_mask_is_lifted() -> None:
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [])
    with deaf_to_interrupts():
        assert {signal.SIGINT, signal.SIGHUP} <= signal.pthread_sigmask(signal.SIG_BLOCK, [])
    assert signal.pthread_sigmask(signal.SIG_BLOCK, []) == before
