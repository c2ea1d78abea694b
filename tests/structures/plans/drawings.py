# SPDX-License-Identifier: GPL-3.0-or-later
"""Small drawings made by the tests, read without a process of their own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from structures.plans.dxf_file import read
from structures.plans.entities import Entity
from structures.plans.keys import PlanKeys
from structures.plans.recognised import Recognised, recognise

HIGH = PlanKeys(wall_height=5.0)


class Drawing:
    """A drawing in metres whose calls of ezdxf are those that a test needs."""

    def __init__(self) -> None:
        import ezdxf

        self.document = ezdxf.new("R2010")
        self.document.header["$INSUNITS"] = 6
        self.space: Any = self.document.modelspace()

    def outline(self, points: Sequence[Sequence[float]], layer: str = "WALLS") -> None:
        """A closed outline; a third number is the bulge of the side that begins there."""
        self.space.add_lwpolyline([(*p, 0.0)[:3] for p in points], format="xyb", close=True, dxfattribs={"layer": layer})

    def box(self, low: Sequence[float], high: Sequence[float], layer: str = "WALLS") -> None:
        """An upright rectangle."""
        self.outline([low, (high[0], low[1]), high, (low[0], high[1])], layer)

    def lines(self, *points: Sequence[float], layer: str = "WALLS") -> None:
        """Lines from point to point."""
        for a, b in pairwise(points):
            self.space.add_line(a, b, dxfattribs={"layer": layer})

    def text(self, words: str, place: Sequence[float], layer: str = "HEIGHTS") -> None:
        """A text whose lower left corner is a place."""
        self.space.add_text(words, height=0.1, dxfattribs={"layer": layer}).set_placement(tuple(place))

    def entities(self, folder: Path) -> list[Entity]:
        """Return the entities in the file of the drawing."""
        path = folder / "plan.dxf"
        self.document.saveas(path)
        return list(read(path).pieces)

    def plan(self, folder: Path, keys: PlanKeys = HIGH) -> Recognised:
        """The plan that it shows."""
        return recognise(self.entities(folder), keys, "plan.dxf")


def turned(points: Sequence[Sequence[float]], degrees: float) -> list[tuple[float, float]]:
    """Points turned about the origin."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return [(c * x - s * y, s * x + c * y) for x, y in points]


def axes(found: Recognised) -> list[tuple[Any, ...]]:
    """Ends and thickness of each straight wall, to a tenth of a millimetre."""
    rounded: Callable[[Sequence[float]], tuple[float, ...]] = lambda p: tuple(round(x, 4) + 0.0 for x in p)  # noqa: E731
    return [(*(rounded(p) for p in wall["axis"]), wall["thickness"]) for wall in found.tables["walls"]]
