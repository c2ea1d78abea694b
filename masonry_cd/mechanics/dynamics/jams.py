# SPDX-License-Identifier: GPL-3.0-or-later
r"""Jams: steps that no motion of the blocks solves without penetration, as where supports close on a block between them.

A step asks for H_n v + b_n >= 0 of every rigid contact, with the velocity of the supports and the gap over the step in b_n. The least speed
at which some contact goes on closing, whatever the blocks do, is a linear program,

    least t >= 0   such that   H_n v + b_n + t >= 0   for some v.

t > 0 proves that there is no solution (Farkas' lemma): the multipliers are forces on the normals that balance one another on every free
block while the supports close against them, and so name the jam. Only contacts around the one that closes fastest are looked at; leaving
some out can only make t smaller, so what is found is certain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_cd.foundation.quantities import length
from masonry_cd.mechanics.friction.problem import FrictionProblem
from masonry_cd.mechanics.model.blocks import Assembly

MOST = 400  # contacts looked at
JAMMED = 0.01  # least t that counts, as a share of the closing speed that the step has left
PRESSED = 1e-3  # share of all forces from which on a contact belongs to the jam


@dataclass(frozen=True, eq=False)
class Closing:
    """A rigid contact that a step has left closing, faster than any other."""

    problem: FrictionProblem  # of the rigid contacts of the step
    blocks: np.ndarray  # (C, 2) on which they are
    contact: int
    speed: float  # [m/s]


@dataclass(frozen=True)
class Jam:
    """Blocks that press on one another without a way out."""

    speed: float  # t: some of their contacts close at least that fast [m/s]
    blocks: tuple[int, ...]  # supports among them

    def in_words(self, assembly: Assembly) -> str:
        """Which supports close on which blocks, and how fast."""
        supports, free = ([assembly.names[b] for b in self.blocks if assembly.fixed[b] == held] for held in (True, False))
        verb, on = "closes" if len(supports) == 1 else "close", f" on {named(free)}" if free else ""
        return f"{named(supports)} {verb}{on} with {length(self.speed)}/s or more in a contact"


def named(names: Sequence[str]) -> str:
    """Up to three names, and how many more there are."""
    *first, last = [f'"{name}"' for name in names[:3]] + ([f"{len(names) - 3} more"] if len(names) > 3 else [])
    return f"{', '.join(first)} and {last}" if first else last


def find_jam(closing: Closing) -> Jam | None:
    """The jam around a contact that goes on closing, or None if the blocks could give way."""
    from scipy import sparse  # of use to hardly any run
    from scipy.optimize import linprog

    near = _near(closing.problem, closing.contact)
    part = closing.problem.subset(near)
    normal = part.jacobian_matrix()[:: part.dimension]
    touched = np.unique(normal.indices)
    matrix = -sparse.hstack([normal[:, touched], np.ones((len(near), 1))], format="csr")
    cost = np.append(np.zeros(len(touched)), 1.0)
    bounds = [(None, None)] * len(touched) + [(0.0, None)]
    found = linprog(cost, matrix, part.offset[:, 0] / closing.speed, bounds=bounds, method="highs")
    if not found.success or found.fun < JAMMED:
        return None
    force = -found.ineqlin.marginals
    blocks = np.unique(closing.blocks[near[force > PRESSED * force.sum()]])
    return Jam(closing.speed * float(found.fun), tuple(blocks.tolist()))


def _near(problem: FrictionProblem, around: int) -> np.ndarray:
    """The contacts around one (indices), from body to body, up to MOST."""
    on = np.zeros(len(problem.v_free) + 1, dtype=np.bool_)  # the last entry stands for all supports
    near = np.array([around])
    while True:
        on[problem.bodies[near]] = True
        on[-1] = False
        wider = np.flatnonzero(on[problem.bodies].any(axis=1))
        if len(wider) == len(near) or len(wider) > MOST:
            return near if len(near) > 1 else wider[:MOST]
        near = wider
