# SPDX-License-Identifier: GPL-3.0-or-later
"""Content of a deck for another program: blocks, the joints between them, gravity, and the motion of the supports.

A deck holds only what the other program computes in the same way: the rest is refused by name.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Assembly

AXES = "xyz"


@dataclass(frozen=True, eq=False)
class Deck:
    """A scene for another program."""

    title: str
    assembly: Assembly
    support_velocity: np.ndarray  # (N + 1, S, 3) of each support motion at t_k = k dt [m/s]
    gravity: np.ndarray  # (3,) [m/s2]
    dt: float  # [s]
    theta: float
    tolerance: float

    def __post_init__(self) -> None:
        """Check the blocks.

        Raises:
            InputError: a sphere, or blocks that deform.
        """
        for block in self.assembly.blocks:
            if block.radius or block.carried is not None:
                what = "is a sphere, but decks have polyhedra only" if block.radius else "carries fill, which decks cannot represent"
                raise InputError("--format", f'block "{block.name}" {what}')
        if self.assembly.planes is not None:
            raise InputError("--format", "decks have intact stones only, but those of this scene crack (material.stones)")
        if self.assembly.deformation is not None:
            raise InputError("--format", "decks have rigid blocks only, but those of this scene deform (material.deformable)")

    @property
    def steps(self) -> int:
        """N."""
        return len(self.support_velocity) - 1

    def group_of(self, b: int) -> str:
        """The group of a block; supports of a group that move in several ways get a number behind it."""
        a = self.assembly
        group, motion = a.blocks[b].group, int(a.support_of[b])
        ways = sorted({int(a.support_of[i]) for i in range(a.count) if a.blocks[i].group == group and a.fixed[i]})
        return f"{group}.{ways.index(motion)}" if a.fixed[b] and len(ways) > 1 else group

    def groups(self) -> dict[str, list[int]]:
        """Numbers of blocks by the names of :meth:`group_of`."""
        found: dict[str, list[int]] = {}
        for b in range(self.assembly.count):
            found.setdefault(self.group_of(b), []).append(b)
        return found

    def pairs(self) -> Iterator[tuple[str, str, int, int]]:
        """Every two groups, not both of supports, once: their names, and their numbers in the tables of the assembly."""
        a, groups = self.assembly, self.groups()
        names = list(groups)
        for i, one in enumerate(names):
            for other in names[i:]:
                if not (a.fixed[groups[one]].all() and a.fixed[groups[other]].all()):
                    yield one, other, int(a.group_of[groups[one][0]]), int(a.group_of[groups[other][0]])

    def moving(self, motion: int) -> list[int]:
        """The axes along which supports of a motion move at some time."""
        return [d for d in range(3) if self.support_velocity[:, motion, d].any()]
