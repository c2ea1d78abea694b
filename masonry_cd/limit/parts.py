# SPDX-License-Identifier: GPL-3.0-or-later
"""Macro-elements: the parts of a structure, each with all other blocks held.

Asked for are those of the structure's kind and those of ``[[limit.mechanism]]``. Those that may go along the push of the whole are looked
at in any case, as rigid bodies: there the search for the least factor begins, and a check has their mechanisms in its table.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from masonry_cd.analysis.limit.macro import Effort, ElementAnalysis, analyse_element
from masonry_cd.analysis.limit.part import Whole
from masonry_cd.app.limit_table import LimitTable, MechanismTable
from masonry_cd.app.progress import Progress
from masonry_cd.foundation import system
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.workers import workers
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints
from structures.macro_elements import MacroElement, groups, macro_elements, rests
from structures.macro_elements.element import AROUND, HORIZONTAL_BENDING, OVERTURNING, VERTICAL_BENDING

if TYPE_CHECKING:
    from masonry_cd.app.limit_structure import LimitStructure
    from masonry_cd.app.static_loads import StaticLoads
    from masonry_cd.limit.kept import KeptParts

STARTS = 2  # of the free search within a part, in addition to those at the mechanisms of practice
SEARCHED = 2_500  # contact points of a part up to which it is made by default: some 10 s of processor time for a push
TOWARDS = 0.7  # cosine of the angle between a push and the line of one of a part's own up to which it may go that way: 45 degrees

Push = tuple[MacroElement, tuple[float, float, float]]  # a part, and the direction


def whole_of(structure: LimitStructure, loads: StaticLoads) -> Whole:
    """A structure whose parts are looked at under gravity along -z."""
    gravity = math.hypot(*structure.scene.run.gravity)
    return Whole(structure.assembly, structure.joints, loads.at().dead, loads.bars, gravity, rests, loads.masses, loads.arms)


def effort_of(asked: LimitTable, seed: int) -> Effort:
    """The effort of the search in a part that a scene requests."""
    most = SEARCHED if asked.starts is None else 2**62
    displacements = asked.check is not None and asked.check.checks_displacements
    return Effort(STARTS if asked.starts is None else asked.starts, most, seed, displacements)


def asked_for(structure: LimitStructure, every: bool) -> list[Push]:
    """The parts that a scene asks for under their pushes: those of its kind where ``every`` one is, and those of its tables.

    Raises:
        InputError: a table that names no block, an unknown part, group or block.
    """
    found = elements_of(structure.asked.mechanism, named_in(structure), every, structure.assembly)
    return [(element, way) for element in found for way in element.directions]


def along(structure: LimitStructure, push: Sequence[float]) -> list[Push]:
    """The parts of a structure's kind that may go along a push (3,), each under it."""
    x, y, z = push
    way = np.asarray(push)
    return [
        (element, (x, y, z))
        for element in named_in(structure)
        if max(abs(float(np.sum(own * way))) for own in element.directions) >= TOWARDS
    ]


def named_in(structure: LimitStructure) -> list[MacroElement]:
    """The parts that the kind of a structure names."""
    kind = structure.scene.kind
    return macro_elements(structure.made.blocks, groups if kind is None else kind.parts)


def analysed(
    whole: Whole, pushes: Sequence[Push], effort: Effort, how: tuple[int, bool], kept: KeptParts | None = None
) -> Iterator[ElementAnalysis]:
    """Analyse parts, in their order.

    Args:
        whole: their structure.
        pushes: the parts, each with its direction.
        effort: how much is looked for.
        how: number of processes, which share the structure, and whether no progress is reported.
        kept: the parts that are done already.

    Raises:
        InputError: joints of a part that crush under the dead loads alone.
    """
    whole.prepare()
    (jobs, quiet), known = how, [None if kept is None else kept.of(push) for push in pushes]
    several = jobs > 1 and known.count(None) > 1
    with workers(jobs, system.INHERITS, _set_shared, whole, effort) if several else nullcontext() as pool:
        runs = {k: pool.submit(_one, pushes[k]) for k, one in enumerate(known) if one is None} if pool else {}
        with Progress(len(pushes), quiet, what="push of a part") as progress:
            for k, one in enumerate(known):
                yield one or (runs[k].result() if runs else analyse_element(whole, *pushes[k], effort))
                progress(k + 1)


_SHARED: list[Any] = []  # structure and effort, in each process of a pool


def _set_shared(whole: Whole, effort: Effort) -> None:
    _SHARED[:] = [whole, effort]


def _one(push: Push) -> ElementAnalysis:
    """A part, in a process of the pool."""
    whole, effort = _SHARED
    return analyse_element(whole, *push, effort)


def elements_of(tables: Sequence[MechanismTable], named: Sequence[MacroElement], every: bool, assembly: Assembly) -> list[MacroElement]:
    """The parts to look at.

    Args:
        tables: of the scene.
        named: the parts of the structure.
        every: look at all of these, in addition to those of the tables.
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
    """A line on each part in several pieces that no joint connects: as one body they turn about one line."""
    out = []
    for one in elements:
        inside = np.isin(joints.block_a, one.blocks) & np.isin(joints.block_b, one.blocks)
        row, column = (np.searchsorted(one.blocks, ends[inside]) for ends in (joints.block_a, joints.block_b))
        pieces, _ = connected_components(coo_matrix((np.ones(len(row)), (row, column)), (len(one.blocks),) * 2), directed=False)
        if pieces > 1:
            out.append(
                f"{one.name}: its {len(one.blocks)} blocks are {pieces} pieces that do not touch, taken as one body; give each a part?"
            )
    return out


def _chosen(table: MechanismTable, where: str, named: Sequence[MacroElement], assembly: Assembly) -> MacroElement:
    """The part of a table."""
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
