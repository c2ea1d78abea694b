# SPDX-License-Identifier: GPL-3.0-or-later
r"""How long the next step is: a ladder of lengths, and the rules by which a run goes up and down on it.

**The ladder.** Lengths are n = 1, 2, 4 ... ticks, the longest of them dt_max; a tick is the shortest step. A step of n ticks begins at a
multiple of n, as in block time steps of N-body codes (Makino, Publ. Astron. Soc. Japan 43, 1991): what is at a multiple of dt_max is met by
itself, and any other instant by halving towards it. All times are whole ticks, so that landing is exact.

**The rules**, for the local error e of a step over its tolerance (``local_error.py``; Hairer, Norsett & Wanner, Solving Ordinary
Differential Equations I, 1993, sec. II.4):

    e > REPEAT      the step is repeated, shorter by sqrt(e): between the order of an impact (e ~ h) and of a smooth motion (e ~ h^3)
    e > 1           it stands, and the next one is half as long
    e < CALM        counts as quiet, unless an impact was solved; QUIET of these in a row, and the next one is twice as long
    solver missed   repeated with half the length, unless the step before missed too: then length is not what is wrong

At an impact a time-stepping scheme is of first order whatever its length, and so is worth a short step only around it (Studer, Leine &
Glocker, Int. J. Numer. Methods Eng. 76, 2008): the repetition finds the impact, the wait for quiet steps passes it.

Everything is a function of the steps before, of whole numbers and comparisons: equal settings give equal steps.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

REPEAT = 4.0  # error over tolerance above which a step is repeated
CALM = 0.125  # below which a step twice as long would still be within: 2^3 for a smooth motion
QUIET = 3  # such steps in a row before a longer one


@dataclass
class StepControl:
    """Chooses the lengths of steps.

    Attributes:
        longest: length of the longest step in ticks, a power of two.
        span: length wanted for the next step, likewise.
        quiet: quiet steps in a row.
        missed: whether the solver missed the last step.
    """

    longest: int
    span: int = 1
    quiet: int = 0
    missed: bool = False

    def next_span(self, ticks: int, room: int, allows: Callable[[int], bool]) -> int:
        """Length of the step that begins after a given number of ticks, with ``room`` ticks to the next instant that has to be met.

        Args:
            ticks: since the start of the run.
            room: one at least.
            allows: whether loads and motion let a step have a length; called for lengths above one.
        """
        longer = 2 * self.span
        if self.quiet >= QUIET and longer <= min(self.longest, room) and ticks % longer == 0 and allows(longer):
            self.span, self.quiet = longer, 0
            return longer
        while self.span > 1 and not allows(self.span):
            self.span, self.quiet = self.span // 2, 0
        span = self.span
        while ticks % span or span > room:
            span //= 2
        return span

    def judge(self, span: int, error: float, missed: bool, event: bool) -> int:
        """Judge a step, and return the length with which it has to be repeated, 0 if it is accepted.

        Args:
            span: its length.
            error: local error over its tolerance.
            missed: by the solver.
            event: an impact was solved in it.
        """
        if span > 1 and not error <= REPEAT:
            halvings = math.ceil(0.5 * math.log2(error)) if math.isfinite(error) else span.bit_length()
            return self._shortened(span >> halvings)
        if span > 1 and missed and not self.missed:
            self.missed = True
            return self._shortened(span // 2)
        self.missed = missed
        if error > 1.0:
            self._shortened(min(span, self.span) // 2)
        else:
            self.quiet = 0 if event or missed or error > CALM else self.quiet + 1
        return 0

    def _shortened(self, span: int) -> int:
        """Want steps of a length, or of one tick."""
        self.span, self.quiet = max(1, span), 0
        return self.span
