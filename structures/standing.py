# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of a structure that may not stand as it is built, judged from its contacts at rest: ``build`` and ``run`` warn alike.

Links count as contacts. A block that touches nothing falls until it meets something. A block *hangs* when no contact pushes it upwards:
then only friction on its sides holds it, as where no lintel or arch spans an opening. A *piece* is a set of blocks that touch one another;
one without a support falls as a whole. Where blocks hang and the supports are not below them, but would be if a horizontal axis pointed
upwards, so that hardly any hung, the structure *lies on its side*, as one from a file does whose upward axis is stated wrongly.
Spheres are left out: they are poured, and fall until they meet something.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.components import connected_components
from masonry_cd.mechanics.model.state import State, rotation_matrices
from structures.files.supports import HOW

UPRIGHT = 1e-4  # sine of the slope of a joint: less is upright
NAMED = 3  # blocks named in a line
FEW = 0.02  # share of the touching blocks that may hang in a structure that has been put upright
LYING = "far fewer would hang if {} pointed upwards; of a file that states no axis, structure.up says which does"
CLEAR = 1e-6  # of the smallest width of a block: centres closer than this are level
SIDES = {"+x": (1, 0, 0), "-x": (-1, 0, 0), "+y": (0, 1, 0), "-y": (0, -1, 0)}


@dataclass(frozen=True, eq=False)
class Standing:
    """How the blocks of a structure hold one another at rest."""

    contacts: ContactSet
    pieces: int  # with a free block in them that is not a sphere
    loose: tuple[str, ...]  # names of free blocks that touch nothing
    hanging: tuple[str, ...]  # of free blocks that nothing pushes upwards, the loose ones apart
    adrift: tuple[str, ...]  # of free blocks in pieces of two blocks or more without a support
    side: str  # axis that should point upwards where the structure lies on its side: +x, -x, +y or -y; else empty

    def warnings(self) -> list[str]:
        """The doubts as text, a line each."""
        return in_words(self.loose, self.hanging, self.adrift, self.side)


def in_words(loose: Sequence[str], hanging: Sequence[str], adrift: Sequence[str], side: str = "") -> list[str]:
    """Lines on blocks that touch nothing, hang, or are in a piece without a support, by their names; and on a structure on its side."""
    lines = []
    if loose:
        verbs = "touches no other block, and falls" if len(loose) == 1 else "touch no other block, and fall"
        lines.append(f"{_these(loose)} {verbs}; of a file, structure.gaps = WIDTH [m] closes gaps up to that width")
    if adrift:
        lines.append(f"{_these(adrift)}: in a piece of the structure that touches no support, and falls as a whole; of a file, {HOW}")
    if hanging:
        names = ", ".join(hanging[:NAMED]) + (" ..." if len(hanging) > NAMED else "")
        hang = "hangs" if len(hanging) == 1 else "hang"
        asked = f"does the structure lie on its side? {LYING.format(side)}" if side else "does something span the opening?"
        lines.append(f"{len(hanging)} {hang}: nothing is under {names}, only friction on the sides ({asked})")
    return lines


def standing(assembly: Assembly) -> Standing:
    """Judge a structure by its contacts at rest."""
    found = contacts_at_rest(assembly)
    spheres = np.array([block.radius > 0.0 for block in assembly.blocks])
    links = np.array([link.blocks for link in assembly.links], dtype=np.int64).reshape(-1, 2)
    pairs = np.concatenate([np.unique(found.bodies, axis=0).reshape(-1, 2), links])
    touched = np.zeros(assembly.count, dtype=bool)
    touched[pairs] = True
    label = connected_components(pairs[:, 0], pairs[:, 1], assembly.count)
    free = ~assembly.fixed & ~spheres
    held = np.isin(label, label[assembly.fixed])
    loose = free & ~touched
    hanging = _hanging(assembly, found, (0, 0, 1)) & free & ~loose & ~np.isin(np.arange(assembly.count), links)
    return Standing(
        contacts=found,
        pieces=len(np.unique(label[free])),
        loose=_names(assembly, loose),
        hanging=_names(assembly, hanging),
        adrift=_names(assembly, free & touched & ~held),
        side=_side(assembly, found, free & touched, int(hanging.sum())),
    )


def _side(assembly: Assembly, contacts: ContactSet, touching: np.ndarray, hanging: int) -> str:
    """The axis that should point upwards where many of the touching blocks (B,) hang; empty where none would do better."""
    if not hanging or not assembly.fixed.any() or _stands_on_supports(assembly, touching, (0, 0, 1)):
        return ""
    most = min(hanging - 1, int(FEW * touching.sum()))
    for name, up in SIDES.items():
        if _stands_on_supports(assembly, touching, up) and (_hanging(assembly, contacts, up) & touching).sum() <= most:
            return name
    return ""


def _stands_on_supports(assembly: Assembly, touching: np.ndarray, up: tuple[int, int, int]) -> bool:
    """Return True if the centres of all supports lie below those of the touching blocks (B,)."""
    height = assembly.centre @ np.array(up)
    return bool(height[assembly.fixed].max() < height[touching].min() - CLEAR * assembly.width)


def contacts_at_rest(assembly: Assembly) -> ContactSet:
    """The contacts at rest, over faces, edges or corners."""
    state = State.at_rest(assembly)
    still = np.zeros((assembly.count, 6))
    return Detector(assembly).detect(state.position, rotation_matrices(state.orientation), still, 0.0, 0.0, np.zeros(3))


def _hanging(assembly: Assembly, contacts: ContactSet, up: tuple[int, int, int]) -> np.ndarray:
    """(B,) True for the free blocks that no contact pushes upwards."""
    push, rising = np.zeros(assembly.count), contacts.normal @ np.array(up)  # steepest upward normal on each block
    np.maximum.at(push, contacts.bodies[:, 0], rising)  # normals point to the first of the two
    np.maximum.at(push, contacts.bodies[:, 1], -rising)
    return np.asarray((push < UPRIGHT) & ~assembly.fixed)


def _names(assembly: Assembly, mask: np.ndarray) -> tuple[str, ...]:
    return tuple(assembly.names[b] for b in np.flatnonzero(mask))


def _these(names: Sequence[str]) -> str:
    """One or some blocks, by name."""
    if len(names) == 1:
        return f'block "{names[0]}"'
    return f"{len(names)} blocks ({', '.join(names[:NAMED])}{' ...' if len(names) > NAMED else ''})"
