# SPDX-License-Identifier: GPL-3.0-or-later
r"""Islands: blocks that touch one another only through supports do not feel each other, so each island is solved by itself.

The contact graph, with supports left out, falls into components: columns side by side, a tower next to a church, pieces on the ground.
The friction problem falls apart with it. An island so takes the iterations that it needs and not those of the hardest one, by the method
and with the parameters that suit it, and one at rest is not solved at all: while the impulses of its last step still do, it sleeps.

**Tolerance.** The judge is the natural map error of the whole step, residual / size, with squares that add up over the islands. Island i
with C_i of the C contacts may leave

    residual_i^2 = tolerance^2 (size_i^2 + size^2 C_i / C) / 2,

which adds up to tolerance^2 size^2: half of it is shared out by size, half by contacts, so that an island that hardly moves is not solved
to more digits than the others leave.

**What is solved together.** Calling a solver costs as much as some hundred contacts do. In every REVIEW-th step the islands are found again
and gathered: those that are easy (no solve took more than EASY iterations since the last review) and those at rest in groups of up to FULL
contacts each; hard ones are solved alone. If all are easy there is nothing to win, and they stay one problem. Each group has a memory of
its own, with a factorisation that fits its blocks. Groups that come into touch are one until the next review, or else a piece that bounces
would have a church analysed again each time.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.arrays import Stored
from masonry_cd.foundation.jit import borrower, entry
from masonry_cd.mechanics.friction.law_terms import errors_by_group
from masonry_cd.mechanics.friction.problem import FrictionProblem, Solution, natural_map_error
from masonry_cd.mechanics.friction.solver_state import SolverState
from masonry_cd.mechanics.solvers import Options, Solver
from masonry_cd.mechanics.solvers.memory_checks import check_memory

REVIEW = 20  # steps
EASY = 40  # iterations
FULL = 400  # contacts
FORCES, IMPACTS = "forces", "impacts"
EMPTY = SolverState()
HARD = 2  # kind of an island; of others whether they are at rest


class _Groups(NamedTuple):
    """The G groups of a friction problem with C contacts."""

    of_contact: np.ndarray  # (C,) group of each contact
    first: np.ndarray  # (G,) first block of each
    awake: np.ndarray  # those that are to be solved
    tolerance: np.ndarray  # (G,) natural map error to which


class Islands:
    """Solves friction problems island by island, small ones in groups; a group is identified by the first of its blocks.

    Args:
        solver: of each island.
        bodies: B, free blocks.
        apart: False takes all blocks as one island.
    """

    def __init__(self, solver: Solver, bodies: int, apart: bool = True) -> None:
        self.solver, self._apart, self._age = solver, apart, 0
        self._root = np.arange(bodies) if apart else np.zeros(bodies, dtype=np.int64)  # first block of the group of each
        self._several = apart and bodies > 1  # whether there are several groups
        self._hard = np.zeros(bodies, dtype=np.bool_)  # by first block: took more than EASY iterations since the last review
        self._asleep = np.zeros(bodies, dtype=np.bool_)  # by first block: the impulses of the step before did
        self._memory: dict[str, dict[int, SolverState]] = {FORCES: {}, IMPACTS: {}}  # of the solver, by first block
        self.count = 0  # islands at the last review
        self.sleeping = 0.0  # share of all blocks whose group was not solved in the last problem

    def link(self, problem: FrictionProblem, impulse: np.ndarray, tolerance: float) -> None:
        """Take in the contacts of a step, with the impulses (C, m) to start from and the natural map error that it has to reach."""
        before, review = self._root, self._age % REVIEW == 0
        self._age += 1
        if not self._apart:
            self.count = 1
        if not self._apart or not (review or self._several):  # all one island, and no other to meet
            return
        self._root = np.arange(len(before)) if review else before.copy()
        _link(problem.bodies, self._root)
        if review:
            self._review(problem, impulse, tolerance, self._hard[before])
        self._several = bool(self._root.any())
        for first in np.flatnonzero(_changed(before, self._root)).tolist():
            self._asleep[first] = False
            for memory in self._memory.values():
                old = memory.pop(first, None)
                if old is not None and self._root[first] == first:
                    memory[first] = old.that_outlives()

    def _review(self, problem: FrictionProblem, impulse: np.ndarray, tolerance: float, hard: np.ndarray) -> None:
        """Gather the islands into groups; ``hard`` (B,) is by block."""
        group, first = _groups(problem.bodies, self._root)
        residual, allowed, _ = _measure(problem, impulse, tolerance, group, len(first))
        kind = np.where(hard[first], HARD, residual <= allowed)
        self.count, self._hard[:] = len(first), False
        if kind.any():
            order = np.argsort(first)
            gather_islands(first[order], kind[order], np.bincount(group)[order], FULL, self._root)
        else:
            self._root[:] = 0

    def solve(self, problem: FrictionProblem, options: Options, start: Solution, kind: str = FORCES) -> Solution:
        """Solve each island that does not sleep. The start is the first iterate, memories are kept here.

        Args:
            problem: over bodies.
            options: ``tolerance`` holds for the whole problem, ``max_iterations`` for each island.
            start: impulses (C, m), and maybe velocities, to start from.
            kind: FORCES, the problem of the step, or IMPACTS, what is solved apart from it.
        """
        if problem.contacts == 0:
            self.sleeping = 0.0
            return self.solver(problem, options, start)
        if not self._several:
            return self._solve_whole(problem, options, start, kind)
        group, first = _groups(problem.bodies, self._root)
        residual, allowed, size = _measure(problem, start.impulse, options.tolerance, group, len(first))
        at_rest = residual <= allowed
        if kind == FORCES:
            at_rest &= self._asleep[first]
        groups = _Groups(group, first, np.flatnonzero(~at_rest), allowed / np.where(size > 0.0, size, 1.0))
        out = self._solve_awake(problem, options, start, kind, groups)
        blocks = np.bincount(self._root)
        self.sleeping = float(blocks[first[self._asleep[first]]].sum()) / len(self._root)
        return out

    def _solve_whole(self, problem: FrictionProblem, options: Options, start: Solution, kind: str) -> Solution:
        """Solve all blocks together."""
        memory, moved = self._memory[kind], int(not self._asleep[0])
        out = self.solver(problem, options, Solution(start.impulse, start.velocity, moved, memory=memory.get(0, EMPTY)))
        memory[0] = out.memory
        self._hard[0] |= out.iterations > EASY
        if kind == FORCES:
            self._asleep[0] = out.iterations == 0
            self.sleeping = float(self._asleep[0])
        return out

    def _solve_awake(self, problem: FrictionProblem, options: Options, start: Solution, kind: str, groups: _Groups) -> Solution:
        """Solve the groups that are awake, each to a tolerance of its own; the others keep the impulses of the start."""
        number, first = np.full(len(self._root), -1), groups.first
        number[first] = np.arange(len(first))
        contacts, contact_start = _sorted(groups.of_contact, len(first))
        blocks, block_start = _sorted(number[self._root], len(first))
        place, impulse, memory = np.empty(len(self._root), dtype=np.int64), start.impulse.copy(), self._memory[kind]
        hardest = Solution(impulse, None, 0, "as in the last step: converged")
        for i in groups.awake.tolist():
            own, members = contacts[contact_start[i] : contact_start[i + 1]], blocks[block_start[i] : block_start[i + 1]]
            place[members] = np.arange(len(members))
            name = int(first[i])
            velocity = None if start.velocity is None else start.velocity[members]
            begin = Solution(impulse[own], velocity, 1, memory=memory.get(name, EMPTY))  # at rest it would not be awake
            own_tolerance = float(groups.tolerance[i])
            accept = options.accept * own_tolerance / options.tolerance
            to_do = replace(options, tolerance=own_tolerance, accept=accept)
            solved = self.solver(problem.part(own, members, place), to_do, begin)
            impulse[own], memory[name] = solved.impulse, solved.memory
            self._hard[name] |= solved.iterations > EASY
            if kind == FORCES:
                self._asleep[name] = solved.iterations == 0
            if solved.iterations >= hardest.iterations:
                hardest = solved
        return Solution(
            impulse, None, hardest.iterations, hardest.reason, error=natural_map_error(problem, impulse, threads=options.threads)
        )

    def snapshot(self) -> dict[str, np.ndarray]:
        """All that the next step depends on, as arrays for a checkpoint."""
        arrays = {"root": self._root, "hard": self._hard, "asleep": self._asleep, "counts": np.array([self._age, self.count])}
        for kind, memory in self._memory.items():
            for first, own in memory.items():
                arrays |= {f"{kind} {first} {name}": array for name, array in own.arrays().items()}
        return arrays

    def check(self, stored: Stored, unknowns: int) -> None:
        """Check what :meth:`restore` takes, with a given number of unknowns per block.

        Raises:
            InputError: an array that no run of these blocks leaves.
        """
        bodies = len(self._root)
        root = stored.whole("root", bodies, high=max(1, bodies))
        if (root > np.arange(bodies)).any() or (root[root] != root).any():
            stored.refuse("root", "not the first blocks of groups")
        for name in ("hard", "asleep"):
            stored.flags(name, bodies)
        stored.whole("counts", 2)
        groups: dict[tuple[str, str], dict[str, np.ndarray]] = {}
        for key in stored.names():
            kind, first, name = key.split(" ") if key.count(" ") == 2 else ("", "", "")
            if kind not in (FORCES, IMPACTS) or not re.fullmatch("[0-9]{1,9}", first) or int(first) >= bodies:
                stored.refuse(key, "unknown")
            groups.setdefault((kind, first), {})[name] = stored.any(key)
        for (kind, first), arrays in groups.items():
            check_memory(Stored(arrays, f"islands/{kind} {first} "), bodies, unknowns)

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Take back what :meth:`snapshot` gave."""
        self._root, self._hard, self._asleep = arrays["root"], arrays["hard"], arrays["asleep"]
        self._several = bool(self._root.any())
        self._age, self.count = arrays["counts"].tolist()
        groups: dict[tuple[str, int], dict[str, np.ndarray]] = {}
        for key, array in arrays.items():
            if " " in key:
                kind, first, name = key.split(" ")
                groups.setdefault((kind, int(first)), {})[name] = array
        self._memory = {FORCES: {}, IMPACTS: {}}
        for (kind, block), own in groups.items():
            self._memory[kind][block] = SolverState.read(own)


def compile_kernels() -> None:
    """Have those kernels compiled, or loaded from their cache, that only a run with several groups calls."""
    one = np.zeros(1, dtype=np.int64)
    gather_islands(one, one, one, FULL, one.copy())
    _sorted(one, 1)


def _measure(
    problem: FrictionProblem, impulse: np.ndarray, tolerance: float, group: np.ndarray, groups: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the violation left by impulses in each group, the one allowed, and the group's size, see the head of this file; (G,) each."""
    residual, size = errors_by_group(problem.arrays(), np.ascontiguousarray(impulse), group, groups)
    share = np.bincount(group, minlength=groups) / max(problem.contacts, 1)
    return residual, tolerance * np.sqrt(0.5 * (size**2 + np.sum(size**2) * share)), size


@borrower()
def _find(root, body):
    """First block of the group of a body, by way of what ``root`` says so far."""
    while root[body] != body:
        root[body] = root[root[body]]
        body = root[body]
    return body


@entry()
def _link(bodies, root):
    """Unite what contacts (C, 2) join; -1: a support."""
    for c in range(bodies.shape[0]):
        if bodies[c, 0] >= 0 and bodies[c, 1] >= 0:
            first, second = _find(root, bodies[c, 0]), _find(root, bodies[c, 1])
            root[max(first, second)] = min(first, second)
    for b in range(root.shape[0]):
        root[b] = root[root[b]]


@entry()
def gather_islands(first, kind, contacts, full, root):
    """Gather islands of one kind into groups, but for HARD ones.

    First block (ascending), kind and number of contacts are by island (I,); ``root`` (B,) holds the first block of the island of each
    block, then that of its group. A block without contacts stays alone.
    """
    group, load, leader = np.full(HARD, -1), np.zeros(HARD, dtype=np.int64), np.arange(root.shape[0])
    for i in range(first.shape[0]):
        k = kind[i]
        if k < HARD and contacts[i] < full:
            if group[k] < 0 or load[k] + contacts[i] > full:
                group[k], load[k] = first[i], 0
            leader[first[i]] = group[k]
            load[k] += contacts[i]
    for b in range(root.shape[0]):
        root[b] = leader[root[b]]


@borrower()
def _host(pair):
    """The block, or one of the two, that a contact is on."""
    return pair[0] if pair[0] >= 0 else pair[1]


@entry()
def _changed(before, now):
    """(B,) True where b is the first block of a group now or was it before, and not of the same blocks."""
    out = np.zeros(before.shape[0], dtype=np.bool_)
    for b in range(before.shape[0]):
        if before[b] != now[b]:
            out[before[b]] = out[now[b]] = True
    return out


@entry()
def _groups(bodies, root):
    """Group of each contact (C,), numbered in their order, and the first block of each group (G,)."""
    number, group, first = np.full(root.shape[0], -1), np.empty(bodies.shape[0], dtype=np.int64), np.empty(root.shape[0], dtype=np.int64)
    count = 0
    for c in range(bodies.shape[0]):
        r = root[_host(bodies[c])]
        if number[r] < 0:
            number[r], first[count] = count, r
            count += 1
        group[c] = number[r]
    return group, first[:count]


@entry()
def _sorted(group, groups):
    """Entries by group, in their order, and where each group begins (G + 1,); entries of the group -1 are left out."""
    start = np.zeros(groups + 1, dtype=np.int64)
    for g in group:
        if g >= 0:
            start[g + 1] += 1
    for g in range(groups):
        start[g + 1] += start[g]
    at, order = start.copy(), np.empty(start[groups], dtype=np.int64)
    for k in range(group.shape[0]):
        if group[k] >= 0:
            order[at[group[k]]] = k
            at[group[k]] += 1
    return order, start
