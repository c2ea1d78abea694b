# SPDX-License-Identifier: GPL-3.0-or-later
"""The outcome of a limit analysis: the verdict on it, with the factor that counts, how sure it is and why, and its mechanism in numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from masonry_cd.analysis.limit.mechanism import STATES, Mechanism
from masonry_cd.analysis.limit.solution import AGREE, LeastFound, agreement
from masonry_cd.analysis.verdict import DOUBTFUL, GOOD, LOOK, RANKS, Verdict
from masonry_cd.foundation.quantities import force

STATES_OF_CHECKS = {"satisfied": GOOD, "not decided": LOOK, "NOT satisfied": DOUBTFUL}  # how the results of a code check are coloured
SURE = {"certain": GOOD, "by search": GOOD, "doubtful": LOOK}  # how sure they are, which is another thing
CLOSED = 1e-4  # gap of the certificate up to which the factor counts as known
APART = 1e-2  # share of the factor by which the least and the associated one may differ and say the same


@dataclass(frozen=True)
class SearchNumbers:
    """The search for the least factor without dilation."""

    associated: float | None  # the factor of sliding that dilates, an upper bound; None where it is not finite
    least: float | None  # None: not searched for, or no start came to an end
    starts: int  # that were made; 0: no search
    ended: int  # that came to an end
    agreeing: int  # that agree on the least factor
    spread: float | None  # the largest factor found less the least, over the least

    @classmethod
    def of(cls, associated: float | None, least: LeastFound | None, starts: int) -> SearchNumbers:
        """The numbers of what a search found; ``starts`` is how many were made where it found nothing."""
        if least is None:
            return cls(associated, None, starts, 0, 0, None)
        return cls(associated, least.optimum.factor, least.starts, len(least.found), least.agreeing, least.spread)

    @property
    def has_agreement(self) -> bool:
        """True where enough starts agree for the least factor to count as known, which is not proof that it is the least."""
        return self.least is not None and self.agreeing >= AGREE


def on_the_check(found: Mapping[str, Any] | None) -> Verdict | None:
    """The verdict of a code check; None where none was requested."""
    if found is None:
        return None
    return Verdict(found["state"], "", found["reason"], SURE[found["confidence"]], found["confidence"], found["because"])


def on_the_whole(facts: Mapping[str, Any]) -> Verdict | None:
    """The verdict on an analysis: of its code check where it has one, else of its load factor; None of parts without a check.

    Args:
        facts: as in limit.json.
    """
    checked = on_the_check(facts["verdict"])
    if checked is not None or "stands" not in facts:
        return checked
    verdict, assumed = on_the_factor(facts), facts["assumed"]
    if assumed["decides"] is not None:
        return _as_assumed(assumed, verdict.sure, "" if facts.get("least") else "at most ")
    return replace(verdict, because="; ".join(filter(None, [verdict.because, *assumed["brief"]])))


def _as_assumed(assumed: Mapping[str, Any], sure: str, bound: str) -> Verdict:
    """The verdict on a factor that rests on what the scene does not state; ``bound`` is "at most " where no least one was searched for."""
    least = assumed["decides"]["factor"]
    words, because = "check its assumptions before you rely on the factor", "; ".join(assumed["brief"])
    keys = " and ".join(one.partition("=")[0] for one in assumed["decides"]["key"].split())
    why = f"the scene does not state {keys}: what lowers the factor is taken"
    grade = f"load factor {bound}{least:.4g}" if least else "does not stand"
    return Verdict(grade, "", because, max(sure, LOOK, key=RANKS.index), words, why)


def on_the_factor(facts: Mapping[str, Any]) -> Verdict:
    """The verdict on an analysis without a check."""
    if not facts["stands"]:
        return Verdict("does not stand", "", "it gives way under its dead loads", DOUBTFUL, "there is no load factor", "")
    if facts["bears_nothing"]:
        return Verdict("has no resistance to this load", "", "any amount of it starts the motion", GOOD, "there is no load factor", "")
    if facts["no_finite_factor"] and facts.get("least"):
        factor, words = facts["least"]["factor"], "check these points before you rely on the factor"
        why = "sliding that opens joints leaves the associated factor without bound: the search alone gives one"
        return Verdict(f"load factor {factor:.4g}", "", "least found without dilation", LOOK, words, why)
    if facts["no_finite_factor"]:
        return Verdict("no finite load factor", "", "the load does no work on any mechanism", LOOK, "check why before you use it", "")
    if facts.get("associated") is None:
        borne = f"they still bear {force(facts['support_force'])} against it"
        return Verdict("supports move", "", borne, LOOK, "there is no load factor", "")
    return _of_the_factor(facts, facts.get("least"))


def _of_the_factor(facts: Mapping[str, Any], least: Mapping[str, Any] | None) -> Verdict:
    """The verdict on a factor: least without dilation where it was searched for, with how well its starts agree."""
    upper, gap = facts["associated"], facts["certificate"]["gap"]
    if gap > CLOSED:
        why = f"the certificate leaves a gap of {gap:.2g}"
        return Verdict(f"load factor {upper:.4g}", "", "", DOUBTFUL, "do not rely on this factor: the cone programme did not close", why)
    if least is None:
        why = "sliding that opens joints gives only an upper bound; the least factor was not searched for"
        return Verdict(f"load factor at most {upper:.4g}", "", "", LOOK, "check these points before you rely on the factor", why)
    factor, agreeing, starts = least["factor"], least["agreeing"], least["starts"]
    because = f"least found without dilation; at most {upper:.4g}, of sliding that opens joints"
    if factor < (1.0 - APART) * upper and (agreeing < AGREE or 2 * agreeing <= starts):
        why = f"{agreement(agreeing, starts)}; more starts may find less (limit.starts)"
        return Verdict(f"load factor {factor:.4g}", "", because, LOOK, "check these points before you rely on the factor", why)
    return Verdict(f"load factor {factor:.4g}", "", because, GOOD, "the searches agree, and the certificate closes", "")


def mechanism_facts(moves: Mechanism, names: Sequence[str], of: str) -> dict[str, Any]:
    """Which blocks move, by their names, and how many joints are at work in the mechanism ``of`` a factor."""
    return (
        {"of": of, "moving_blocks": [names[b] for b in np.flatnonzero(moves.moving).tolist()]}
        | {f"joints_{state.replace(' ', '_')}": moves.count(state) for state in STATES}
        | {"joints_crushing": int(moves.crushing.sum())}
    )
