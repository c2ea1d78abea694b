# SPDX-License-Identifier: GPL-3.0-or-later
"""The verdict on a result, with which every output begins: what came out, how sure that is, and why.

A run, an assessment and a code check each come to one of these; page, PDF, terminal and JSON show it and judge nothing by themselves.
What cannot be relied on has no grade: that it cannot, and why, stands in its place.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

GOOD, LOOK, DOUBTFUL = "good", "look", "doubtful"
UNKNOWN = "unknown"  # of a result that has left no numbers of its own
RANKS = (GOOD, LOOK, DOUBTFUL)
NOT_GRADED = "not graded"  # stands for the grade of a run that is doubtful


@dataclass(frozen=True)
class Verdict:
    """The outcome of a run, an assessment or a check, how sure it is, and why."""

    grade: str  # D1, "D2 to D4", satisfied, "not graded"; empty where none was requested
    means: str  # the grade as text; empty where it says all
    because: str  # what gives the grade, with its numbers
    sure: str  # good, look, doubtful or unknown
    words: str  # that as text, with what decides it
    why: str  # what decides it, with its numbers; empty where all is good

    @property
    def result(self) -> str:
        """``D1, negligible to slight damage (opening 295 um ...)``; empty without a grade."""
        named = ", ".join(filter(None, [self.grade, self.means]))
        return f"{named} ({self.because})" if named and self.because else named

    @property
    def trust(self) -> str:
        """``do not rely on this run until the cause is removed: contact forces (9 of 200 steps missed ...)``."""
        return f"{self.words} ({self.why})" if self.why else self.words

    @property
    def line(self) -> str:
        """All of it in a line, for a terminal."""
        return f"verdict: {'; '.join(filter(None, [self.result, self.trust]))}"

    def as_dict(self) -> dict[str, str]:
        """For JSON."""
        return asdict(self)
