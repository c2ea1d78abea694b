# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of a limit analysis: an optimum, the least factor of a search, and how well its starts agree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

ALIKE = 2e-3  # factors that differ by no more than this share of the least are one
AGREEING = 2e-2  # starts agree that come to factors within this share of the least: checks keep a margin of 5 %
AGREE = 2  # starts that come to the least factor before it counts as known: one start alone may miss it


def agreement(agreeing: int, starts: int) -> str:
    """How many starts agree, and to how much, as a phrase."""
    return f"{agreeing} of {starts} starts agree to {100.0 * AGREEING:g} %"


class Unbounded(RuntimeError):
    """No answer: the programme has none, or the solver found none. The message is the solver's."""


@dataclass(frozen=True, eq=False)
class Optimum:
    """The best that a solver found, in the units of the problem."""

    factor: float
    force: np.ndarray  # (P, m) r
    bars: np.ndarray  # (T,) N
    velocity: np.ndarray  # (unknowns,) v
    iterations: int
    method: str
    stopped: str = ""  # the solver's word where it ended before its tolerance


@dataclass(frozen=True, eq=False)
class LeastFound:
    """The least factor of sliding without dilation that was found."""

    optimum: Optimum  # the least of the ends, or one below it to which descents that began there came
    gap: float  # g over the power of the loads
    starts: int
    ends: tuple[Optimum, ...]  # of each start that came to an end

    @property
    def found(self) -> tuple[float, ...]:
        """The factors of the starts that came to an end."""
        return tuple(end.factor for end in self.ends)

    @property
    def mechanisms(self) -> tuple[Optimum, ...]:
        """All that was found."""
        return self.ends if any(end is self.optimum for end in self.ends) else (self.optimum, *self.ends)

    @property
    def agreeing(self) -> int:
        """The number of starts that came to the least of their ends, to AGREEING."""
        best = min(self.found)
        return sum(factor <= best + AGREEING * abs(best) for factor in self.found)

    @property
    def has_agreement(self) -> bool:
        """True where enough starts agree for the least factor to count as known, which is not proof that it is the least."""
        return self.agreeing >= AGREE

    @property
    def spread(self) -> float:
        """The largest factor found less the least, over the least."""
        return (max(self.found) - self.optimum.factor) / max(abs(self.optimum.factor), 1e-300)


def merged(one: LeastFound | None, other: LeastFound | None, starts: int) -> LeastFound | None:
    """Two searches as one with this total number of starts; None where neither found anything."""
    both = [each for each in (one, other) if each is not None]
    if not both:
        return None
    best = min(both, key=lambda each: each.optimum.factor)
    return LeastFound(best.optimum, best.gap, starts, tuple(end for each in both for end in each.ends))
