from __future__ import annotations

import pytest

from pcsmooth.kernels.threads import thread_limit


def test_an_interrupt_inside_a_kernels_wrapper_is_an_interrupt() -> None:
    with pytest.raises(KeyboardInterrupt), thread_limit(1):
        raise SystemError("returned a result with an exception set") from KeyboardInterrupt()


def test_another_system_error_passes() -> None:
    with pytest.raises(SystemError, match="other"), thread_limit(1):
        raise SystemError("other")
