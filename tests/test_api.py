from __future__ import annotations

import subprocess
import sys

import pytest

import pcsmooth


@pytest.mark.slow
def test_import_is_light() -> None:
    program = (
        "import sys, pcsmooth\n"
        "heavy = {'numba', 'scipy', 'plyfile', 'numpy', 'click', 'tqdm'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
        "assert pcsmooth.measure_balls([[0, 0]], 1.0).volume > 3\n"
        "assert 'numba' in sys.modules\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", pcsmooth.__all__)
def test_every_public_name_resolves(name: str) -> None:
    assert getattr(pcsmooth, name).__name__ == name
    assert name in dir(pcsmooth)


def test_public_names_are_sorted_and_complete() -> None:
    assert pcsmooth.__all__ == sorted(pcsmooth.__all__)
    assert set(pcsmooth.__all__) == set(pcsmooth._HOMES)


def test_unknown_name() -> None:
    with pytest.raises(AttributeError, match="module 'pcsmooth' has no attribute 'polish'"):
        pcsmooth.polish  # noqa: B018
