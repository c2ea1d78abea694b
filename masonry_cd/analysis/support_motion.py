# SPDX-License-Identifier: GPL-3.0-or-later
"""How the supports move: those that move alike together, each motion by its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_cd.analysis.deformed import Solids
from masonry_cd.io.results import SAME, SUPPORT_FRAMES, Results

NAMED = 4  # supports of a motion that are named
STILL = 1e-9  # what moves less is at rest [m]


@dataclass(frozen=True, eq=False)
class SupportMotion:
    """The motion of some supports over F frames."""

    names: tuple[str, ...]  # of the supports that move so
    displacement: np.ndarray  # (F, 3) from where they were built [m]
    velocity: np.ndarray  # (F, 3) [m/s]

    @property
    def largest(self) -> float:
        """Farthest from where they were built [m]."""
        return float(np.linalg.norm(self.displacement, axis=1).max(initial=0.0))

    @property
    def moves(self) -> bool:
        """Return True if it is one at all."""
        return self.largest > STILL

    @property
    def called(self) -> str:
        """``base1, base2`` or ``base1, base2, base3, base4 and 5 more``."""
        more = len(self.names) - NAMED
        return ", ".join(self.names[:NAMED]) + (f" and {more} more" if more > 0 else "")


def support_motions(results: Results, solids: Solids) -> tuple[SupportMotion, ...]:
    """The motions of the supports, those that go farthest first; none without supports."""
    fixed, frames = np.flatnonzero(solids.fixed), results.frames
    if not len(fixed):
        return ()
    groups = _alike(results, solids, fixed)
    first = fixed[[group[0] for group in groups]]
    displacement, velocity = np.empty((frames, len(first), 3)), np.empty((frames, len(first), 3))
    for rows in results.in_chunks(6 * len(solids.centre)):
        displacement[rows] = np.asarray(results.position[rows], dtype=float)[:, first] - solids.centre[first]
        velocity[rows] = np.asarray(results.velocity[rows], dtype=float)[:, first, :3]
    found = [
        SupportMotion(tuple(results.blocks[i].name for i in fixed[group]), displacement[:, k], velocity[:, k])
        for k, group in enumerate(groups)
    ]
    return tuple(sorted(found, key=lambda motion: -motion.largest))


def _alike(results: Results, solids: Solids, fixed: np.ndarray) -> list[list[int]]:
    """Places in ``fixed`` (S,) of the supports that move alike, over some frames evenly."""
    frames = np.unique(np.linspace(0, results.frames - 1, min(results.frames, SUPPORT_FRAMES)).round().astype(int))
    moved = np.array([np.asarray(results.position[frame], dtype=float)[fixed] - solids.centre[fixed] for frame in frames.tolist()])
    near = max(STILL, SAME * float(np.abs(moved).max()))
    groups: list[list[int]] = []
    left = np.arange(len(fixed))
    while len(left):
        same = np.abs(moved[:, left] - moved[:, left[:1]]).max(axis=(0, 2)) <= near
        groups.append(left[same].tolist())
        left = left[~same]
    return groups
