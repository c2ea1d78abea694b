# SPDX-License-Identifier: GPL-3.0-or-later
"""Memory of a solver from one step to the next: factors, learnt parameters, and data of the solver's own.

A state is not changed: a solver returns a new one, but for the numbers of the factors, which the next step overwrites. A checkpoint holds
each of its arrays and numbers by its name.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace

import numpy as np

from masonry_cd.mechanics.linalg.ordering import FIELDS, Pattern

OWN = "own."  # begins the names of arrays of solvers from elsewhere
NUMBERS = ("bodies", "squares", "panels", "rho")  # of factors, next to the pattern


@dataclass(frozen=True, eq=False)
class Factors:
    """The factors of M + H^T R H of ADMM, and the symbolic analysis that the methods which linearise the law share with it."""

    pattern: Pattern
    bodies: np.ndarray  # (C, 2) of the contacts of the factors
    squares: np.ndarray  # of D^-1, flat, in single precision, but in double where W alone is given
    panels: np.ndarray  # of L, likewise
    rho: np.ndarray  # (C,) R

    @classmethod
    def empty(cls, pattern: Pattern, bodies: np.ndarray, n: int, kind: type[np.floating] = np.float32) -> Factors:
        """Unfilled factors by a pattern with n unknowns a body, of contacts between these bodies (C, 2)."""
        starts = (pattern.symbolic.square, pattern.symbolic.panel)
        squares, panels = (np.empty(n * n * int(start[-1]), dtype=kind) for start in starts)
        return cls(pattern, bodies, squares, panels, np.empty(len(bodies)))


@dataclass(frozen=True, slots=True)
class Learnt:
    """Parameters learnt from step to step; they outlive a change of the contacts."""

    k: float = 1e4  # of ADMM, that did best; see admm.py for the first
    stale: bool = True  # whether the next step is to factorise again
    steps: int = 0
    mean_iterations: float = 0.0  # of a step at this k
    rate: float = 1.0  # error over the change of p in the last iteration that was measured; 1: none was
    budget: int = 0  # iterations that ``auto`` gives ADMM in the next step; 0: none was solved


@dataclass(frozen=True, eq=False)
class SolverState:
    """All of it, of one group of blocks."""

    factors: Factors | None = None
    learnt: Learnt = Learnt()
    kept: np.ndarray | None = None  # (2 C m,) rows that add an unknown, see solvers/condensed.py
    unknowns: int = 0  # n of the condensed problem; 0: no block is condensed
    own: Mapping[str, np.ndarray] = field(default_factory=dict)  # arrays of a solver from elsewhere

    def that_outlives(self) -> SolverState:
        """Return the memory that remains where the group has other blocks."""
        return SolverState(learnt=replace(self.learnt, stale=True))

    def with_learnt(self, learnt: Learnt) -> SolverState:
        """The state with something else learnt."""
        return SolverState(self.factors, learnt, self.kept, self.unknowns, self.own)

    def arrays(self) -> dict[str, np.ndarray]:
        """The state by names, for a checkpoint."""
        out = {name: np.array([getattr(self.learnt, name)], dtype=float) for name in LEARNT}
        if self.factors is not None:
            out |= dict(zip(FIELDS, self.factors.pattern.arrays(), strict=True))
            out |= {name: getattr(self.factors, name) for name in NUMBERS}
        if self.kept is not None:
            out |= {"kept": self.kept, "unknowns": np.array([self.unknowns])}
        return out | {f"{OWN}{name}": array for name, array in self.own.items()}

    @classmethod
    def read(cls, arrays: Mapping[str, np.ndarray]) -> SolverState:
        """The state that :meth:`arrays` gave."""
        kinds = {name: type(getattr(Learnt(), name)) for name in LEARNT}
        learnt = Learnt(**{name: kind(arrays[name][0]) for name, kind in kinds.items()})
        factors = None
        if FIELDS[0] in arrays:
            factors = Factors(Pattern.read(tuple(arrays[name] for name in FIELDS)), *(arrays[name] for name in NUMBERS))
        own = {name.removeprefix(OWN): array for name, array in arrays.items() if name.startswith(OWN)}
        return cls(factors, learnt, arrays.get("kept"), int(arrays["unknowns"][0]) if "unknowns" in arrays else 0, own)


LEARNT = tuple(each.name for each in fields(Learnt))
