"""Answers of other programs, kept in out/peers: they are the same whenever they are asked."""

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from peers import Array, ask_peer

FOLDER = Path(__file__).resolve().parents[2] / "out" / "peers"


def recall_peer(name: str, arrays: Sequence[npt.NDArray[Any]], *parameters: float) -> Array:
    """Ask a program like `ask_peer`, or return what it answered before.

    Raises
    ------
    PeerError
        With a few words why there is no answer.
    """
    question = hashlib.sha256(repr((name, *map(float, parameters))).encode())
    for array in arrays:
        question.update(repr((array.shape, array.dtype.str)).encode())
        question.update(np.ascontiguousarray(array).tobytes())
    path = FOLDER / f"{name}-{question.hexdigest()[:24]}.npy"
    if not path.exists():
        answer = ask_peer(name, arrays, *parameters)
        FOLDER.mkdir(parents=True, exist_ok=True)
        part = path.with_suffix(".part")
        with part.open("wb") as file:
            np.save(file, answer)
        part.replace(path)
    return np.asarray(np.load(path), dtype=np.float64)
