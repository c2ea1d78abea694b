# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of a structure before any run: blocks coloured by group."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from masonry_cd.analysis.deformed import Solids
from masonry_cd.mechanics.model.blocks import Block
from reports.drawing.figure import Sheet, in_metres
from reports.drawing.palette import EDGE, GROUPS, PULLING, SUPPORT
from reports.drawing.parts import RULER, Panel, Sign, Ties, rgb
from reports.drawing.scene import Scene
from reports.drawing.solids import block_layers, looking_at, structure_window, within_sight


def structure_picture(blocks: Sequence[Block], path: Path, title: str, view: str = "auto", ties: Sequence[np.ndarray] = ()) -> None:
    """Draw the blocks by group, and ties by their ends (2, 3) each [m], with a key and a scale bar, into a PNG.

    Args:
        blocks: of the structure.
        path: of the PNG.
        title: of the picture.
        view: auto (front where all blocks are prisms across y, else isometric), front, back, side, left, top or isometric.
        ties: their ends.

    Raises:
        InputError: an unknown view, no off-screen OpenGL, or a path that cannot be written.
    """
    structure_sheet(blocks, title, view, ties).save(path)


def structure_sheet(blocks: Sequence[Block], title: str, view: str = "auto", ties: Sequence[np.ndarray] = ()) -> Sheet:
    """The sheet that :func:`structure_picture` writes.

    Raises:
        InputError: an unknown view, or no off-screen OpenGL.
    """
    return Sheet.drawn(structure_scene(blocks, title, view, ties))


def structure_scene(blocks: Sequence[Block], title: str, view: str = "auto", ties: Sequence[np.ndarray] = ()) -> Scene:
    """What they show.

    Raises:
        InputError: an unknown view.
    """
    solids, families = Solids.from_blocks(blocks), families_of(blocks)
    looking, colours = looking_at(solids, view), np.empty((len(blocks), 3))
    for family in families:
        colours[family.members] = rgb(family.colour)
    extent = " × ".join(in_metres(v) for v in np.ptp(solids.vertices[~solids.fixed[solids.vertex_block]], axis=0))
    rows = [Sign("box", family.text, (family.colour, EDGE)) for family in families]
    rows += [Sign("line", f"ties ({len(ties)})", (PULLING,))] if ties else []
    return Scene(
        view=looking,
        window=structure_window(solids, looking),
        layers=block_layers(solids, within_sight(solids, solids.vertices), colours),
        ties=Ties(np.array(ties, dtype=float).reshape(-1, 2, 3), ("",) * len(ties), np.ones(len(ties))),
        title=title,
        facts=f"{len(blocks)} blocks · {extent} (x, y, z) without supports · {looking.name} view",
        key=[Panel(rows, wide=4), RULER],
    )


@dataclass(frozen=True, eq=False)
class Family:
    """Blocks that one colour stands for: a group, or numbered groups (pier1, pier2 ...) taken together."""

    text: str
    members: np.ndarray  # indices of blocks
    colour: str


def families_of(blocks: Sequence[Block]) -> list[Family]:
    """The groups of blocks; where they outnumber the colours, numbered groups together. Groups of supports are grey."""
    named = [b.group for b in blocks]
    if len(set(named)) > len(GROUPS) + 1:
        named = [re.sub(r"\d+", "#", name) for name in named]
    names = np.array(named, dtype=object)
    out: list[Family] = []
    for name in dict.fromkeys(named):
        members = np.flatnonzero(names == name)
        groups = list(dict.fromkeys(blocks[int(i)].group for i in members))
        text = groups[0] if len(groups) == 1 else f"{groups[0]} to {groups[-1]}"
        support = all(blocks[int(i)].fixed for i in members)
        free = sum(family.colour != SUPPORT for family in out)
        out.append(Family(f"{text} ({len(members)})", members, SUPPORT if support else GROUPS[free % len(GROUPS)]))
    return out
