# SPDX-License-Identifier: GPL-3.0-or-later
r"""The links of a run as equations of where the blocks are: c(q) = 0 and their rows G.

Each link has a frame f_0, f_1, f_2 on its second block b and one g_0, g_1, g_2 on its first block a, equal as built, and a point X_a, X_b
on each. Of its six rows those that the link holds are

    shift i     f_i . (X_a - X_b) = 0          (f_i, (X_a - x_a) x f_i)  on a,    -(f_i, (X_a - x_b) x f_i)  on b
    turn i      f_i . t = 0                    (0, f_i)                  on a,    -(0, f_i)                  on b

where t is half the sum of f_i x g_i, or f_0 x g_0 of a hinge that turns about f_0 by any angle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.linalg.triples import cross, inner
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.links import clusters
from masonry_cd.mechanics.model.state import State, rotation_matrices


@dataclass(frozen=True, eq=False)
class Linkage:
    """L links between U blocks, numbered among themselves."""

    used: np.ndarray  # (U,) blocks with links
    moved: np.ndarray  # (K,) places of the free ones among these
    free: np.ndarray  # (K,) and theirs among the free blocks
    ends: np.ndarray  # (L, 2) places of their blocks among these
    arms: np.ndarray  # (L, 2, 3) from the centres to the point, body frames [m]
    frames: np.ndarray  # (L, 3, 3) rows, body frames of both
    held: np.ndarray  # (L, 6) bool: shifts, turns
    clusters: tuple[tuple[np.ndarray, np.ndarray], ...]  # blocks that hang together (k,), by places among these, and their rows among 6 L
    body: np.ndarray  # (F,) of each free block: those that hang together are one

    @classmethod
    def of(cls, assembly: Assembly) -> Linkage | None:
        """That of an assembly; None where it has no links."""
        links, free = assembly.links_there, ~assembly.fixed
        if not links:
            return None
        ends = np.array([link.blocks for link in links])
        used, local = np.unique(ends, return_inverse=True)
        local, number = local.reshape(ends.shape), clusters(links, assembly.fixed)
        held = np.array([link.held for link in links])
        first_free = np.where(assembly.fixed[ends[:, 0]], ends[:, 1], ends[:, 0])
        hung = []
        for cluster in np.unique(number[first_free]):
            rows = np.flatnonzero((held & (number[first_free] == cluster)[:, None]).ravel())
            hung.append((np.flatnonzero((number[used] == cluster) & free[used]), rows))
        body = np.unique(number[free], return_inverse=True)[1].reshape(-1)
        arms = np.array([[link.point - assembly.centre[b] for b in link.blocks] for link in links])
        moved, place = np.flatnonzero(free[used]), np.cumsum(free) - 1
        return cls(used, moved, place[used[moved]], local, arms, np.array([link.frame for link in links]), held, tuple(hung), body)

    @property
    def bodies(self) -> int:
        """How many bodies there are."""
        return int(self.body.max()) + 1

    @property
    def largest(self) -> int:
        """Free blocks of the largest set that hangs together."""
        return max(len(members) for members, _ in self.clusters)

    def rows(self, position: np.ndarray, orientation: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """c of all six rows of each link, held or not, (L, 6) [m, rad], and G by link, row and block, (L, 6, 2, 6).

        Positions (U, 3) and orientations (U, 4).
        """
        value, out = np.empty(self.held.shape), np.zeros((*self.held.shape, 2, 6))
        fill_links(position, rotation_matrices(orientation), self.ends, self.arms, self.frames, self.held, value, out)
        return value, out

    def largest_violation(self, state: State) -> float:
        """Return the largest error of the links in a state, in position or in angle [m, rad]."""
        value, _ = self.rows(state.position[self.used], state.orientation[self.used])
        return float(np.abs(np.where(self.held, value, 0.0)).max())


@entry()
def fill_links(
    position: np.ndarray,
    rotation: np.ndarray,
    ends: np.ndarray,
    arms: np.ndarray,
    frames: np.ndarray,
    held: np.ndarray,
    value: np.ndarray,
    rows: np.ndarray,
) -> None:
    """Fill c ``value`` (L, 6) and G ``rows`` (L, 6, 2, 6), zeros before, see the head of this file; rotations (U, 3, 3) body to world."""
    for k in range(len(ends)):
        a, b = ends[k]
        f, g, apart, t = np.empty((3, 3)), np.empty((3, 3)), np.zeros(3), np.zeros(3)
        at = np.empty((2, 3))  # from the centres of a and b to X_a
        for d in range(3):
            own = other = 0.0
            for j in range(3):
                own += rotation[a, d, j] * arms[k, 0, j]
                other += rotation[b, d, j] * arms[k, 1, j]
            at[0, d], at[1, d] = own, own + position[a, d] - position[b, d]
            apart[d] = at[1, d] - other
            for i in range(3):
                f[i, d] = g[i, d] = 0.0
                for j in range(3):
                    f[i, d] += rotation[b, d, j] * frames[k, i, j]
                    g[i, d] += rotation[a, d, j] * frames[k, i, j]
        every = 3 if held[k, 3] else 1
        for i in range(every):
            x, y, z = cross((f[i, 0], f[i, 1], f[i, 2]), (g[i, 0], g[i, 1], g[i, 2]))
            share = 0.5 if every == 3 else 1.0
            t[0], t[1], t[2] = t[0] + share * x, t[1] + share * y, t[2] + share * z
        for i in range(3):
            along = f[i, 0], f[i, 1], f[i, 2]
            value[k, i], value[k, 3 + i] = inner(along, (apart[0], apart[1], apart[2])), inner(along, (t[0], t[1], t[2]))
            for side in range(2):
                sign, moment = 1.0 - 2.0 * side, cross((at[side, 0], at[side, 1], at[side, 2]), along)
                for d in range(3):
                    rows[k, i, side, d], rows[k, i, side, 3 + d] = sign * along[d], sign * moment[d]
                    rows[k, 3 + i, side, 3 + d] = sign * along[d]
