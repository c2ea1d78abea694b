"""Structures: from the [structure] table of a scene to checked blocks.

Each kind has a module with a function ``build(table, density, folder) -> list[Block]``, named in :data:`KINDS` and
imported when it is asked for. Whatever a kind builds passes :mod:`structures.checks` before it is returned, and
:func:`report` says what it is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from masonry_cd.blocks import Block
from masonry_cd.errors import InputError, suggest

KINDS = {
    "arch": "structures.arch",
    "aqueduct": "structures.aqueduct",
    "wall": "structures.wall",
    "tower": "structures.tower",
    "column": "structures.column",
    "vault": "structures.vault",
    "dome": "structures.dome",
    "church": "structures.church",
    "file": "structures.blockfile",
}


def build(table: Mapping[str, Any], density: float, folder: Path) -> list[Block]:
    """Build the blocks of a structure and check them.

    Args:
        table: the scene's [structure] table, ``kind`` included.
        density: of the material [kg/m3]; the entries of a block file may state their own.
        folder: where the scene file lies; the path of a block file is relative to it.

    Raises:
        InputError: an unknown kind, a key of that kind that is wrong, or blocks that are unsound.
    """
    kinds = ", ".join(KINDS)
    if "kind" not in table:
        raise InputError(f"structure.kind: missing; one of {kinds}")
    kind = str(table["kind"])
    if kind not in KINDS:
        hint = suggest(kind, KINDS)
        raise InputError(f'structure.kind: unknown kind "{kind}"{hint}; one of {kinds}')
    rest = {key: value for key, value in table.items() if key != "kind"}
    blocks: list[Block] = import_module(KINDS[kind]).build(rest, density, folder)
    return blocks


def report(blocks: Sequence[Block]) -> dict[str, Any]:
    """Blocks, joints, masses, contact graph and hyperstaticity of a structure, see :mod:`structures.summary`.

    Raises:
        InputError: a free block that touches nothing.
    """
    made: dict[str, Any] = import_module("structures.summary").report(blocks)
    return made
