# SPDX-License-Identifier: GPL-3.0-or-later
"""Macro-elements: the parts of a structure that practice looks at, read from names, groups and places of its blocks.

A kind of structure says which it has by its ``parts`` (:mod:`structures.kind`); what stands free on top, parapets, is looked for in all.

element.py   a part: its blocks, where it is pushed to, which mechanisms are looked for
layout.py    walls, courses and openings
walls.py     walls in plan: whole, upper part, gable, piers, spandrels, corners
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from structures.macro_elements.element import AROUND, EAST, HINGES, NORTH, OVERTURNING, SOUTH, WEST, MacroElement
from structures.macro_elements.layout import BlockLayout

__all__ = ["AROUND", "EAST", "HINGES", "NORTH", "OVERTURNING", "SOUTH", "WEST"]
__all__ += ["BlockLayout", "MacroElement", "groups", "macro_elements", "rests", "whole"]

RESTING = ("roof", "vault")  # groups that rest on walls and load them, with floors
FREE = re.compile(r"(?:^|_)parapets?(?:_|$)")  # groups of what stands free on top


def rests(group: str) -> bool:
    """True for a group of blocks that rest on walls, as roofs and floors do, and are not bonded with them."""
    return group in RESTING or group.startswith("floor")


def whole(layout: BlockLayout) -> list[MacroElement]:
    """A structure that is one part."""
    return [MacroElement("whole", "whole", np.flatnonzero(~layout.fixed), AROUND, (OVERTURNING,))]


def groups(layout: BlockLayout) -> list[MacroElement]:
    """The groups of blocks, each a part."""
    return [MacroElement(name, "group", layout.of_groups(name), AROUND, (OVERTURNING,)) for name in layout.names]


def macro_elements(blocks: Sequence[Block], parts: Callable[[BlockLayout], list[MacroElement]] = groups) -> list[MacroElement]:
    """The parts of a structure that practice looks at: those of its kind, and parapets."""
    layout = BlockLayout.of(blocks)
    free = _parapets(layout)
    named = {one.name for one in free}
    return [one for one in (*(one for one in parts(layout) if one.name not in named), *free) if len(one.blocks)]


def _parapets(layout: BlockLayout) -> list[MacroElement]:
    """The parts that stand free on top, by their group, out of their plane."""
    found = []
    for name in layout.names:
        if FREE.search(name):
            own = layout.of_groups(name)
            ways = (NORTH, SOUTH) if layout.axis(own) == 0 else (EAST, WEST)
            found.append(MacroElement(name, "parapet", own, ways, (OVERTURNING,)))
    return found
