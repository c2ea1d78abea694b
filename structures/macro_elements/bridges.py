# SPDX-License-Identifier: GPL-3.0-or-later
"""Macro-elements of arches, vaults and bridges: spans in their plane, webs, piers along and across, what stands free on top."""

from __future__ import annotations

import re

import numpy as np

from structures.macro_elements.element import AROUND, EAST, HINGES, NORTH, OVERTURNING, SOUTH, WEST, MacroElement
from structures.macro_elements.layout import Layout

SPAN, PIER = re.compile(r"(?:tier\d+_)?arch\d*$"), re.compile(r"(?:tier\d+_)?pier\d+$")
FREE = re.compile(r"(?:^|_)parapets?(?:_|$)")  # groups of what stands free on top


def arch(layout: Layout) -> list[MacroElement]:
    """An arch, or a vault of one span, in its plane."""
    return [MacroElement("arch", "span", np.flatnonzero(~layout.fixed), (EAST, WEST), (HINGES,))]


def vault(layout: Layout) -> list[MacroElement]:
    """A vault as a whole, and the webs of one that crosses; by hinges, towards all sides."""
    own = np.flatnonzero(~layout.fixed)
    webs = list(dict.fromkeys(str(name) for name in layout.group[own]))
    found = [MacroElement("vault", "vault", own, AROUND, (HINGES,))]
    if len(webs) < 2:
        return found
    return [*found, *(MacroElement(name.replace("_", " "), "web", layout.of_groups(name), AROUND, (HINGES,)) for name in webs)]


def parapets(layout: Layout) -> list[MacroElement]:
    """What stands free on top, by its group, out of its plane."""
    found = []
    for name in dict.fromkeys(str(name) for name in layout.group[~layout.fixed]):
        if FREE.search(name):
            own = layout.of_groups(name)
            ways = (NORTH, SOUTH) if layout.axis(own) == 0 else (EAST, WEST)
            found.append(MacroElement(name, "parapet", own, ways, (OVERTURNING,)))
    return found


def aqueduct(layout: Layout) -> list[MacroElement]:
    """Spans with what rests on them, piers, parapets."""
    names = list(dict.fromkeys(str(name) for name in layout.group[~layout.fixed]))
    found = []
    for name in names:
        own = layout.of_groups(name)
        if SPAN.search(name):
            low, high = layout.low[own].min(axis=0), layout.high[own].max(axis=0)
            free = np.flatnonzero(~layout.fixed)
            over = free[(layout.low[free, 2] >= low[2]) & (layout.middle[free, 0] > low[0]) & (layout.middle[free, 0] < high[0])]
            over = over[[not PIER.search(str(layout.group[b])) for b in over]]
            found.append(MacroElement(f"span {name}", "span", np.union1d(own, over), (EAST, WEST, NORTH), (HINGES,)))
        elif PIER.search(name):
            above = np.flatnonzero(~layout.fixed & (layout.low[:, 2] >= layout.top(own) - 1e-6))
            reach = layout.low[own, 0].min(), layout.high[own, 0].max()
            over = above[(layout.middle[above, 0] >= reach[0]) & (layout.middle[above, 0] <= reach[1])]
            found.append(MacroElement(f"{name} with what stands on it", "pier", np.union1d(own, over), AROUND, (OVERTURNING,)))
    return found


def bridge(layout: Layout) -> list[MacroElement]:
    """Spans of one or several rings with what rests on them, piers, spandrel walls across the road, parapets."""
    found = []
    names = list(dict.fromkeys(str(name) for name in layout.group[~layout.fixed]))
    for span in dict.fromkeys(name.split("_")[0] for name in names if name.startswith("arch")):
        own = np.flatnonzero(~layout.fixed & np.array([str(name).split("_")[0] == span for name in layout.group]))
        found.append(MacroElement(f"span {span}", "span", own, (EAST, WEST), (HINGES,)))
    for name in names:
        if PIER.search(name):
            found.append(MacroElement(name, "pier", layout.of_groups(name), AROUND, (OVERTURNING,)))
        elif name.startswith(("spandrel", "wing")):
            way = SOUTH if name.endswith("front") else NORTH
            found.append(MacroElement(name.replace("_", " "), "wall", layout.of_groups(name), (way,), (OVERTURNING,)))
    return found
