# SPDX-License-Identifier: GPL-3.0-or-later
"""The extent of the search for the least factor without dilation, and the conclusions from a search."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from masonry_cd.analysis.limit.analysis import Analysis, LimitOptions
from masonry_cd.analysis.limit.interfaces import interfaces
from masonry_cd.analysis.limit.outcome import SearchNumbers
from masonry_cd.analysis.limit.problem import plane_of
from masonry_cd.analysis.limit.solution import AGREE, AGREEING, agreement
from masonry_cd.foundation.quantities import in_words

if TYPE_CHECKING:
    from masonry_cd.analysis.limit.macro import Effort, ElementAnalysis
    from masonry_cd.app.limit_structure import LimitStructure
    from masonry_cd.app.static_loads import StaticLoads

STARTS = 4  # of the search in a plane; for a check in space at most, until starts agree: two from each end of what normal forces may be
FIRST = 2  # of these that are made in any case, one from each end
SEARCHED = (
    15_000  # points in space up to which a check searches by default: two starts take 47 s of processor time at 10,600, 140 s at 14,500
)
ASK = "limit.starts = 2 does"


@dataclass(frozen=True)
class SearchSettings:
    """The settings of a search."""

    analysis: LimitOptions
    curve: LimitOptions  # of the points of a capacity curve
    most: int  # starts to which the search of the analysis goes on until some agree
    begins_at_parts: bool  # whether it begins at mechanisms of parts that practice looks at as well


def ways(structure: LimitStructure, loads: StaticLoads) -> SearchSettings:
    """How to solve as the table ``[limit]`` of a structure asks for it.

    In space each start is expensive: by default a search is made for a check only, of a structure that is not large, and ends where starts
    agree; no curve is followed by it.
    """
    asked, seed = structure.asked, structure.scene.run.seed
    planar = plane_of(structure.assembly, loads.at()) is not None
    usual = asked.starts if asked.starts is not None else STARTS if planar else 0
    options = LimitOptions(usual, seed)
    if asked.starts is not None or planar or asked.check is None:
        return SearchSettings(options, options, usual, not planar and usual > 1)
    small = interfaces(structure.assembly, structure.joints, None).count <= SEARCHED
    return SearchSettings(replace(options, starts=FIRST if small else 0), options, STARTS if small else 0, small)


def search_words(analysis: Analysis) -> str:
    """The outcome of a search as a line: the least factor, starts, agreement and spread; or why there is no such factor."""
    least = analysis.least
    if least is None:
        off = f"not searched for; {ASK}, at some ten times the cost of the associated factor each"
        sought = f"of {analysis.starts} starts, none converged" if analysis.starts else off
        return f"sliding without dilation may give way at less: {sought}"
    open_end = least.starts - len(least.found)
    ended = f", {open_end} to no end" if open_end else ""
    wide = f", the largest found is {100.0 * least.spread:.2g} % above it" if len(least.found) > 1 else ""
    sure = f"{agreement(least.agreeing, least.starts)}, none came to less{ended}{wide}; no proof that it is the least"
    return f"sliding without dilation: {least.optimum.factor:.5g} is the least found; {sure}"


def certificate_lines(analysis: Analysis) -> list[str]:
    """A line on the accuracy of the associated factor; none where it is not finite."""
    answer, made = analysis.associated, analysis.associated.certificate
    if analysis.unlimited:
        return []
    return [
        f"certificate: static {made.static:.8g}, kinematic {made.kinematic:.8g}, gap {made.gap:.1e}; residuals: "
        f"equilibrium {made.equilibrium:.1e}, friction {made.friction:.1e}, flow {made.flow:.1e}; "
        f"{answer.optimum.method}, {in_words(answer.seconds)}"
    ]


def search_numbers(analysis: Analysis) -> SearchNumbers:
    """The outcome of a search in numbers."""
    upper = None if analysis.unlimited else analysis.associated.factor
    return SearchNumbers.of(upper, analysis.least, analysis.starts)


def doubt(analysis: Analysis) -> str:
    """The reason why no demand counts as met after a search; empty where one may.

    The static value of the associated programme does not count: it is no lower bound where joints slide without dilation.
    """
    if not analysis.starts:
        large = analysis.problem.axis is None and analysis.problem.points.count > SEARCHED
        size = f" in a structure of more than {SEARCHED:,} contact points" if large else ""
        return f"the least factor without dilation is not computed by default{size}: {ASK}"
    return _unsure(search_numbers(analysis), f"of {analysis.starts} starts of the search for the least factor, none converged")


def doubt_of(part: ElementAnalysis, effort: Effort) -> str:
    """The reason why no demand counts as met by a part after its search; empty where one may."""
    if part.remarks:
        return part.remarks[0]
    if part.numbers.least is None and part.points > effort.most_points:
        return f"the free least mechanism is not computed for a part of more than {effort.most_points:,} contact points: {ASK}"
    return _unsure(part.numbers, "no start of the search for the free least mechanism converged")


def _unsure(found: SearchNumbers, no_end: str) -> str:
    """Why the outcome of a search that was made is not sure; empty where enough of its starts agree."""
    if found.least is None:
        return f"{no_end}: raise limit.starts"
    if found.has_agreement:
        return ""
    came = f"{found.agreeing} of {found.starts} starts came to the least factor found"
    return f"{came}, {AGREE} have to agree to {100.0 * AGREEING:g} %: raise limit.starts"
