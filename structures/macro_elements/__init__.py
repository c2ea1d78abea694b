# SPDX-License-Identifier: GPL-3.0-or-later
"""The macro-elements of a structure: the parts that practice looks at one by one, each with all else held.

layout.py    stones by wall, and the openings of a wall, from the names and places of blocks
walls.py     walls in plan: whole, upper part, gable, piers, spandrels, corners
church.py    facade, side walls, arch, apse, tower and belfry
building.py  walls, corners, vaults and columns of a building from a plan
bridges.py   arches, spans and piers of bridges
by_kind.py   which parts a kind of structure has
"""

from structures.macro_elements.by_kind import macro_elements
from structures.macro_elements.element import MacroElement

__all__ = ["MacroElement", "macro_elements"]
