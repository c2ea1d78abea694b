# SPDX-License-Identifier: GPL-3.0-or-later
"""Which macro-elements a scene asks for: those of its structure's kind, and those of ``[[limit.mechanism]]``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from masonry_cd.app.macro_table import MechanismTable
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints

if TYPE_CHECKING:
    from structures.macro_elements import MacroElement


def elements_of(tables: Sequence[MechanismTable], named: Sequence[MacroElement], every: bool, assembly: Assembly) -> list[MacroElement]:
    """The parts to look at.

    Args:
        tables: of the scene.
        named: the parts of the structure.
        every: look at all of these, beside those of the tables.
        assembly: the blocks.

    Raises:
        InputError: a table that names no block, an unknown part, group or block.
    """
    chosen = [_chosen(table, f"limit.mechanism[{i}]", named, assembly) for i, table in enumerate(tables)]
    again = {one.name for one in chosen}
    found = [*(one for one in named if every and one.name not in again), *chosen]
    if not found:
        raise InputError("limit", "the structure has no macro-element; name one in [[limit.mechanism]]")
    return found


def in_pieces(elements: Sequence[MacroElement], joints: Joints) -> list[str]:
    """A line on each part that is in several pieces, which no joint of it joins: as one body they turn about one line."""
    out = []
    for one in elements:
        inside = np.isin(joints.block_a, one.blocks) & np.isin(joints.block_b, one.blocks)
        row, column = (np.searchsorted(one.blocks, ends[inside]) for ends in (joints.block_a, joints.block_b))
        pieces, _ = connected_components(coo_matrix((np.ones(len(row)), (row, column)), (len(one.blocks),) * 2), directed=False)
        if pieces > 1:
            out.append(
                f"{one.name}: its {len(one.blocks)} blocks are {pieces} pieces that do not touch: they count as one body; a part for each?"
            )
    return out


def _chosen(table: MechanismTable, where: str, named: Sequence[MacroElement], assembly: Assembly) -> MacroElement:
    """The part of a table."""
    from structures.macro_elements.element import AROUND, HORIZONTAL_BENDING, OVERTURNING, VERTICAL_BENDING, MacroElement

    if table.part is not None:
        known = {one.name: one for one in named}
        if table.part not in known:
            raise InputError(
                f"{where}.part", f'there is no "{table.part}"{suggest(table.part, known)}; one of {", ".join(known) or "none"}'
            )
        made = known[table.part]
    else:
        blocks, words = _blocks(table, where, assembly)
        blocks = blocks[~assembly.fixed[blocks]]
        if not len(blocks):
            raise InputError(where, f"names no block that is free to move: {words}")
        made = MacroElement(words, "chosen", blocks, AROUND, (OVERTURNING, VERTICAL_BENDING, HORIZONTAL_BENDING))
    if table.name is not None:
        made = replace(made, name=table.name)
    if table.mechanisms is not None:
        made = replace(made, mechanisms=table.mechanisms)
    if table.direction is not None:
        x, y, z = table.direction.vector
        if abs(z) > 1e-9:
            raise InputError(f"{where}.direction", f"must be level, got {table.direction.label}")
        made = replace(made, directions=((x, y, 0.0),))
    return made


def _blocks(table: MechanismTable, where: str, assembly: Assembly) -> tuple[np.ndarray, str]:
    """Numbers of the blocks of a table by group, names or box, and how it names them."""
    if table.group is not None:
        if table.group not in assembly.groups:
            raise InputError(f"{where}.group", f'there is no group "{table.group}"{suggest(table.group, assembly.groups)}')
        return np.flatnonzero(assembly.group_of == assembly.groups.index(table.group)), table.group
    if table.blocks is not None:
        number = {name: b for b, name in enumerate(assembly.names)}
        for name in table.blocks:
            if name not in number:
                raise InputError(f"{where}.blocks", f'there is no block "{name}"{suggest(name, assembly.names)}')
        return np.unique([number[name] for name in table.blocks]), f"{table.blocks[0]} and others" if len(
            table.blocks
        ) > 1 else table.blocks[0]
    assert table.box is not None
    one, other = np.array(table.box)
    inside = ((assembly.centre >= np.minimum(one, other)) & (assembly.centre <= np.maximum(one, other))).all(axis=1)
    return np.flatnonzero(inside), f"box {np.minimum(one, other).tolist()} to {np.maximum(one, other).tolist()}"
