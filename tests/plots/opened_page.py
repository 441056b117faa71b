"""Interactive pages opened: the numbers that their program finds in them."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.plots.point_blocks import Block
from pcsmooth.plots.valued_clouds import ValuedClouds, by_displacement
from plots.blocks import unpacked, unpacked_places, unpacked_values

Points = npt.NDArray[np.float64]


def moved(dimension: int, n: int = 200, far: float = 0.0) -> ValuedClouds:
    rng = np.random.default_rng(dimension)
    before = rng.normal(size=(n, dimension)) * [4.0, 1.0, 2.0][:dimension]
    after = before + rng.normal(scale=0.1, size=before.shape)
    return by_displacement(before + far, after + far, ["b & b", "a"])


@dataclass
class Opened:
    """What the program of a page finds in it."""

    scene: dict[str, Any]
    texts: list[str]

    def numbers(self, number: int) -> npt.NDArray[np.uint32]:
        return unpacked(Block(self.texts[number], **self.scene["blocks"][number]))

    def places(self) -> list[Points]:
        """The points of the clouds, in the order of the page."""
        found: list[Points] = []
        first = np.zeros((0, 0), np.uint32)
        for cloud in self.scene["clouds"]:
            number = cloud["positions"]
            bits = self.scene["blocks"][number]["bits"]
            whole = self.numbers(number)
            if found and self.scene["is_paired"]:
                whole = (whole + first) & np.uint32(2**bits - 1)
            first = whole
            places = unpacked_places(whole, bits)
            found.append(self.scene["origin"] + self.scene["scale"] * places)
        return found

    def values(self, column: int = 0) -> list[Points]:
        described = self.scene["columns"][column]
        return [
            unpacked_values(self.numbers(number), described["limits"])
            for number in described["values"]
        ]


def opened(html: str) -> Opened:
    (scene,) = re.findall(r'<script type="application/json" id="scene">(.*)</script>', html)
    blocks = re.findall(
        r'<script type="application/octet-stream" id="block-(\d+)">(.*)</script>', html
    )
    assert [int(number) for number, _ in blocks] == list(range(len(blocks)))
    return Opened(json.loads(scene), [text for _, text in blocks])


def ranks(found: Points, expected: Points) -> npt.NDArray[np.int64]:
    """Rows of the expected points that are nearest to those found, each of them once."""
    rows = np.asarray(np.linalg.norm(found[:, None] - expected, axis=2).argmin(axis=1))
    assert sorted(rows) == list(range(len(expected)))
    return rows
