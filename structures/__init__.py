# SPDX-License-Identifier: GPL-3.0-or-later
"""Structures: from the [structure] table of a scene to checked blocks. Several of them, [[structures]], are put side by side by
:mod:`structures.site`.

Each kind is a module of :mod:`structures.kinds` with a function ``build(table, density, folder)``, goes by the module's name, and is
imported when it is asked for. It returns the blocks, or, where it has changed something in making them, the blocks and lines on that;
a bridge returns its fill as well.
Whatever a kind builds passes :mod:`structures.geometry.checks` before it is returned, and :func:`report` says what it is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from masonry_cd.foundation.extensions import Extensions

if TYPE_CHECKING:  # a child process that reads a file comes by here, and needs no more
    from masonry_cd.mechanics.model.blocks import Block
    from masonry_cd.mechanics.model.fill import Fill
    from structures.ties import Bar

Build: TypeAlias = "Callable[[Mapping[str, Any], float, Path], list[Block] | tuple[list[Block], list[str]] | Made]"

FLOORS = "floors"  # key of the tables of structures/floors.py
FOUNDATIONS = "foundations"  # key of structures/layout/foundations.py
GROUND = "ground"  # key of structures/layout/ground.py
NOISE = "noise"  # key of the table of structures/noise.py
TIES = "ties"  # key of the tables of structures/ties.py

KINDS: Extensions[Build] = Extensions("structures.kinds", "build")


class Made(NamedTuple):
    """What the tables of a scene make."""

    blocks: list[Block]
    notes: list[str]  # on what was changed in making them: curved faces made flat, gaps closed, noise; and on floors and ties
    ties: Sequence[Bar] = ()
    fills: Sequence[Fill] = ()  # of bridges: what is no blocks, and loads ask


def build(table: Mapping[str, Any], density: float | None, folder: Path) -> list[Block]:
    """The blocks of a structure, see :func:`make`."""
    return make(table, density, folder).blocks


def build_with_notes(table: Mapping[str, Any], density: float | None, folder: Path) -> tuple[list[Block], list[str]]:
    """The blocks of a structure, and lines on what was changed in making them, see :func:`make`."""
    made = make(table, density, folder)
    return made.blocks, made.notes


def make(table: Mapping[str, Any], density: float | None, folder: Path) -> Made:
    """Build the blocks of a structure and check them.

    Args:
        table: the scene's [structure] table, with ``kind``, and the keys of every kind (:mod:`structures.tables`) where they are given.
        density: of the material [kg/m3]; the entries of a block file may state their own, and where all of them do there may be none.
        folder: where the scene file lies; the path of a block file is relative to it.

    Raises:
        InputError: an unknown kind, a key of that kind that is wrong, or blocks that are unsound.
    """
    from masonry_cd.foundation.errors import InputError
    from structures import size
    from structures.faults import ANYTHING, Faults, Incomplete

    if "kind" not in table:
        raise InputError("structure.kind", f"missing; one of {', '.join(KINDS)}")
    kind = str(table["kind"])
    added = None if kind in KINDS else _own_kind(kind, folder)
    rest = {key: value for key, value in table.items() if key not in ("kind", size.KEY, FLOORS, FOUNDATIONS, GROUND, NOISE, TIES)}
    faults = Faults()
    with size.limited(table.get(size.KEY, size.MOST)):
        try:
            made = (added or KINDS[kind])(rest, math.nan if density is None else density, folder)
        except Incomplete as failure:
            if not table.keys() & {FLOORS, TIES}:
                raise
            faults, made = failure.collected, [] if ANYTHING in failure.collected.left_out else failure.rest()
    fills = made.fills if isinstance(made, Made) else ()
    blocks, notes = made[:2] if isinstance(made, tuple) else (made, [])
    from structures.layout.ground import needs_ground, with_ground

    if GROUND in table and not faults.found:
        blocks = with_ground(blocks, table[GROUND])
    if FOUNDATIONS in table and not faults.found:
        from structures.layout.foundations import in_pieces

        with size.limited(table.get(size.KEY, size.MOST)):
            blocks = in_pieces(blocks, table[FOUNDATIONS])
    bars = list(made.ties) if isinstance(made, Made) else []
    if FLOORS in table:
        from structures.floors import with_floors

        blocks, bars, more = with_floors(blocks, table[FLOORS], faults)
        notes = [*notes, *more]
    if TIES in table:
        from structures.ties import ties_of

        own, more = ties_of(blocks, table[TIES], faults)
        bars, notes = [*bars, *own], [*notes, *more]
    faults.refuse()
    if GROUND not in table and kind != "file" and needs_ground(blocks):  # last, since it bears nothing
        blocks = with_ground(blocks, True)
    if NOISE in table:
        from structures import noise

        blocks, more = noise.with_noise(blocks, table[NOISE])
        notes = [*notes, *more]
    return Made(blocks, notes, bars, fills)


def _own_kind(kind: str, folder: Path) -> Build:
    """A kind that a package or a file of the user's adds; its blocks are checked as ours are.

    Raises:
        InputError: no such kind, or one that is no function.
    """
    from masonry_cd.foundation.errors import InputError
    from masonry_cd.foundation.plugins import find
    from structures.geometry.checks import check

    found = find("structures", kind, "structure.kind", KINDS, folder)
    build = getattr(found, "build", found)
    if not callable(build):
        raise InputError("structure.kind", f'"{kind}" is no function build(table, density, folder)')

    def checked(table: Mapping[str, Any], density: float, folder: Path) -> list[Block] | tuple[list[Block], list[str]]:
        made = build(table, density, folder)
        blocks, notes = made[:2] if isinstance(made, tuple) else (made, [])
        check(blocks)
        return list(blocks), list(notes)

    return checked


def report(blocks: Sequence[Block]) -> dict[str, Any]:
    """Blocks, joints, masses, contact graph and hyperstaticity of a structure, see :mod:`structures.summary`."""
    made: dict[str, Any] = import_module("structures.summary").report(blocks)
    return made
