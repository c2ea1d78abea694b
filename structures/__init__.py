# SPDX-License-Identifier: GPL-3.0-or-later
"""Structures: from the [structure] table of a scene to checked blocks. Several of them, [[structures]], are put side by side by
:mod:`structures.site`.

Each kind is a module of :mod:`structures.kinds` that ends with its ``KIND`` (:mod:`structures.kind`), has the module's name, and is
imported on first use. Its ``build(table, density, folder)`` returns the blocks, or, where it has changed something in making them,
the blocks and lines on that; a bridge returns its fill as well.
Whatever a kind builds passes :mod:`structures.geometry.checks` before it is returned, and :mod:`structures.summary` says what it is.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from masonry_cd.foundation.extensions import Extensions

if TYPE_CHECKING:  # a child process that reads a file comes by here, and needs no more
    from masonry_cd.mechanics.model.blocks import Block
    from masonry_cd.mechanics.model.fill import Fill
    from structures.kind import StructureKind
    from structures.ties import PlacedBar

KINDS: Extensions[StructureKind] = Extensions("structures.kinds", "KIND")


class MadeStructure(NamedTuple):
    """Structure and loads that the tables of a scene make."""

    blocks: list[Block]
    notes: list[str]  # on what was changed in making them: curved faces made flat, gaps closed; and on floors and ties
    ties: Sequence[PlacedBar] = ()
    fills: Sequence[Fill] = ()  # of bridges: what is no blocks, and loads ask
    floors: Sequence[tuple[str, dict[str, Any]]] = ()  # that a kind asks for: its key, and the keys of the floor


def build(table: Mapping[str, Any], density: float | None, folder: Path) -> list[Block]:
    """The blocks of a structure, see :func:`make`."""
    return make(table, density, folder).blocks


def make(table: Mapping[str, Any], density: float | None, folder: Path) -> MadeStructure:
    """Build the blocks of a structure and check them.

    Args:
        table: the scene's [structure] table, with ``kind``, and the keys of every kind (:mod:`structures.tables`) where they are given.
        density: of the material [kg/m3]; the entries of a block file may state their own, and where all of them do there may be none.
        folder: where the scene file lies; the path of a block file is relative to it.

    Raises:
        InputError: an unknown kind; all keys that are wrong and what is wrong with the kind's structure; blocks that are unsound; then what
            is wrong with floors, and with ties, the first fault of each.
    """
    from masonry_cd.foundation.errors import Faults, InputError
    from structures import size
    from structures.floors import FloorTable, with_floors
    from structures.geometry.checks import Unsound, check
    from structures.tables import own_keys, rows_of
    from structures.ties import TieRowTable, ties_of

    if "kind" not in table:
        raise InputError("structure.kind", f"missing; one of {', '.join(KINDS)}")
    kind = kind_of(str(table["kind"]), folder)
    faults, keys = Faults(), Faults()
    floors = rows_of(FloorTable, table.get("floors", ()), "structure.floors", keys)
    ties = rows_of(TieRowTable, table.get("ties", ()), "structure.ties", keys)
    try:
        with size.limited(table.get(size.KEY, size.MOST)):
            made = kind.build(own_keys(table), math.nan if density is None else density, folder)
            if not kind.checks:
                check(made[0] if isinstance(made, tuple) else made)
    except InputError as error:
        if isinstance(error, Unsound) and not keys.found:  # it knows its blocks, which can be drawn
            raise
        faults.found += error.faults
    faults.found += keys.found
    faults.refuse()
    fills = made.fills if isinstance(made, MadeStructure) else ()
    blocks, notes = made[:2] if isinstance(made, tuple) else (made, [])
    from structures.layout.ground import needs_ground, with_ground

    if "ground" in table:
        blocks = with_ground(blocks, table["ground"])
    if "foundations" in table:
        from structures.layout.foundations import in_pieces

        with size.limited(table.get(size.KEY, size.MOST)):
            blocks = in_pieces(blocks, table["foundations"])
    bars = list(made.ties) if isinstance(made, MadeStructure) else []
    asked = made.floors if isinstance(made, MadeStructure) else ()
    if floors or asked:
        places = [*(f"structure.floors[{i}]" for i in range(len(floors))), *(place for place, _ in asked)]
        floors += [FloorTable.model_validate(keys) for _, keys in asked]
        blocks, anchors, more = with_floors(blocks, floors, places)
        bars, notes = [*bars, *anchors], [*notes, *more]
    rods, more = ties_of(blocks, ties)
    bars, notes = [*bars, *rods], [*notes, *more]
    if "ground" not in table and kind.grounded and needs_ground(blocks):  # last, since it bears nothing
        blocks = with_ground(blocks, True)
    return MadeStructure(blocks, notes, bars, fills)


def kind_of(name: str, folder: Path | None = None) -> StructureKind:
    """A kind of structure by its name: one of ours, of an installed package, or of a file next to the scene, "my_file.py:name".

    What a package or a file names may be a function ``build(table, density, folder)`` alone; the model of its keys is then the class
    ``NameTable`` of its module, where there is one.

    Args:
        name: as the scene gives it.
        folder: of the scene; without it no file is looked for.

    Raises:
        InputError: no such kind, or one that is not a function.
    """
    from masonry_cd.foundation.errors import InputError
    from masonry_cd.foundation.plugins import find
    from structures.kind import StructureKind

    found = find("structures", name, "structure.kind", KINDS, folder)
    if isinstance(found, StructureKind):
        return found
    build = getattr(found, "build", found)
    if not callable(build):
        raise InputError("structure.kind", f'"{name}" is not a function build(table, density, folder)')
    return StructureKind(build, getattr(sys.modules.get(build.__module__), f"{name.capitalize()}Table", None))


def every_kind() -> Iterator[StructureKind]:
    """Our own kinds and those of installed packages; all of them are imported."""
    from masonry_cd.foundation.plugins import names

    return (kind_of(name) for name in (*KINDS, *names("structures")))
