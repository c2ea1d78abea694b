"""Structures: from the [structure] table of a scene to checked blocks.

Each kind has a module with a function ``build(table, density, folder) -> list[Block]``, named in :data:`KINDS` and
imported when it is asked for; one that has something to tell has ``build_with_notes`` instead, which returns lines besides. Whatever a
kind builds passes :mod:`structures.geometry.checks` before it is returned, and :func:`report` says what it is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # a child process that reads a file comes by here, and needs no more
    from masonry_cd.model.blocks import Block

KINDS = {
    "arch": "structures.kinds.arch",
    "aqueduct": "structures.kinds.aqueduct",
    "wall": "structures.kinds.wall",
    "tower": "structures.kinds.tower",
    "column": "structures.kinds.column",
    "vault": "structures.kinds.vault",
    "dome": "structures.kinds.dome",
    "church": "structures.kinds.church",
    "file": "structures.files.blockfile",
    "solid": "structures.files.cut_solid",
}


def build(table: Mapping[str, Any], density: float, folder: Path) -> list[Block]:
    """The blocks of a structure, see :func:`build_with_notes`."""
    return build_with_notes(table, density, folder)[0]


def build_with_notes(table: Mapping[str, Any], density: float, folder: Path) -> tuple[list[Block], list[str]]:
    """Build the blocks of a structure and check them.

    Args:
        table: the scene's [structure] table, ``kind`` included.
        density: of the material [kg/m3]; the entries of a block file may state their own.
        folder: where the scene file lies; the path of a block file is relative to it.

    Returns:
        the blocks, and lines on what was changed in making them: curved faces made flat, gaps closed.

    Raises:
        InputError: an unknown kind, a key of that kind that is wrong, or blocks that are unsound.
    """
    from masonry_cd.errors import InputError, suggest

    kinds = ", ".join(KINDS)
    if "kind" not in table:
        raise InputError(f"structure.kind: missing; one of {kinds}")
    kind = str(table["kind"])
    if kind not in KINDS:
        hint = suggest(kind, KINDS)
        raise InputError(f'structure.kind: unknown kind "{kind}"{hint}; one of {kinds}')
    rest = {key: value for key, value in table.items() if key != "kind"}
    module = import_module(KINDS[kind])
    if hasattr(module, "build_with_notes"):
        told: tuple[list[Block], list[str]] = module.build_with_notes(rest, density, folder)
        return told
    return module.build(rest, density, folder), []


def report(blocks: Sequence[Block]) -> dict[str, Any]:
    """Blocks, joints, masses, contact graph and hyperstaticity of a structure, see :mod:`structures.summary`.

    Raises:
        InputError: a free block that touches nothing.
    """
    made: dict[str, Any] = import_module("structures.summary").report(blocks)
    return made
