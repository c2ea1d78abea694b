# SPDX-License-Identifier: GPL-3.0-or-later
r"""The mechanisms whose start is compared with a demand: each with the factor alpha_0 at which it starts.

The least factor does not decide a check by accelerations: a_0 = alpha_0 g / e* differs from mechanism to mechanism by e* as well. So all
that were found are looked at: those of the search without dilation, the associated one, and those of the same structure without its ties.

**The factor of a given mechanism** v is that of virtual work,

    lambda = ( -w_0 . v  -  r . u  +  N_y . max(G v, 0) ) / w_1 . v,      u = H v,

with the forces r of the joints that were found together with v. -r . u is what the joints take up: a bond where they open, mu r'_n |u_t|
where they slide. Without dilation v alone does not say r'_n, as friction hangs on normal forces that do no work; they are those of the
equilibrium in which v was found. In associated sliding dilation gives back what friction takes, and dry joints take up nothing.

**With ties** that mechanism takes up N_y max(G v, 0) more: those that it stretches yield, the others are slack, and one that does not yield
holds it. r stays what it was. So a tie never lowers the factor of a mechanism, nor does it touch its e*. What the pull of a tie does to
friction is not counted here: it is in the mechanisms that are found with the ties.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from masonry_cd.analysis.limit.admitted import admitted
from masonry_cd.analysis.limit.analysis import HELD, Analysis, LimitOptions, largest_factor, searched_finely
from masonry_cd.analysis.limit.found import ASSOCIATED, SEARCH, FoundMechanism, are_alike, dilation, found_in
from masonry_cd.analysis.limit.mechanism import STILL, Mechanism, mechanism
from masonry_cd.analysis.limit.overturning import overturning_below
from masonry_cd.analysis.limit.part import FreedPart, Whole
from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.analysis.limit.search import Searched, begun_at, least_factor, sought
from masonry_cd.analysis.limit.solution import ALIKE, LeastFound, Optimum, Unbounded
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints

UNTIED = ", found without the ties"

Source = tuple[str, Optimum]  # how a mechanism was found, and its velocities


def with_untied(analysis: Analysis, assembly: Assembly, joints: Joints, options: LimitOptions) -> tuple[Analysis, list[Source], str]:
    """An analysis whose search with ties has begun at the mechanisms found without them as well, these mechanisms, or why there are none.

    Args:
        analysis: of a structure that stands, with its ties.
        assembly: its blocks.
        joints: of them.
        options: of the analysis; the search without ties is made as they say.
    """
    problem = analysis.problem
    if not problem.ties:
        return analysis, [], ""
    bare = problem.without_ties()
    try:
        best, _ = largest_factor(bare)
        # what starts far above the least factor with ties starts higher with them
        least = least_factor(bare, best, options.starts, options.seed, known=analysis.least)
    except (InputError, Unbounded) as failure:
        return analysis, [], f"without its ties no load factor is found, and no mechanism: {failure}"
    if least is not None:
        analysis = _begun_at(analysis, assembly, joints, [end.velocity for end in least.ends])
    return analysis, _named(UNTIED, best, least), ""


def with_mechanisms(analysis: Analysis, assembly: Assembly, joints: Joints, known: Sequence[Mechanism]) -> Analysis:
    """An analysis whose search has begun at known mechanisms as well, as those of macro-elements; blocks on them go with them."""
    every = (admitted(analysis.problem, assembly, moves.velocity, moves.crushing) for moves in known)
    begun = [each for each in every if each is not None]
    return _begun_at(analysis, assembly, joints, begun) if begun else analysis


def with_overturning(analysis: Analysis, whole: Whole, direction: np.ndarray) -> Analysis:
    """An analysis whose search has begun as well at bodies that would overturn below the least factor that it knows, were they free."""
    known = analysis.governing.factor if np.isfinite(analysis.governing.factor) else HELD
    begun = [analysis.problem.unknowns_of(moves) for moves in overturning_below(whole, direction, (1.0 - ALIKE) * known)]
    return _begun_at(analysis, whole.assembly, whole.joints, begun) if begun else analysis


def _begun_at(analysis: Analysis, assembly: Assembly, joints: Joints, mechanisms: Sequence[np.ndarray]) -> Analysis:
    """An analysis whose search has begun at velocities (unknowns,) as well."""
    before, cap = Searched(analysis.least, analysis.starts), sought(analysis.associated.optimum)
    found = before

    def search(problem: LimitProblem) -> LeastFound | None:
        nonlocal found
        found = begun_at(problem, before, mechanisms, cap)
        return found.least

    problem, least = searched_finely(analysis.problem, search)
    moves = None if least is None else mechanism(problem, assembly, joints, least.optimum.velocity)
    return replace(analysis, problem=problem, least=least, least_mechanism=moves, starts=found.starts)


def candidates(analysis: Analysis, untied: Sequence[Source], part: FreedPart) -> list[FoundMechanism]:
    """The mechanisms that an analysis of a standing structure found, and those found without its ties that can start with them; each once.

    Args:
        analysis: of the structure with its ties.
        untied: mechanisms found without its ties.
        part: the structure as the part that holds everything.
    """
    out: list[FoundMechanism] = []
    associated = None if analysis.unlimited else analysis.associated.optimum
    for source, optimum in (*_named("", associated, analysis.least), *untied):
        factor = tied_factor(analysis.problem, optimum) if UNTIED in source else optimum.factor
        if not np.isfinite(factor):
            continue
        made = found_in(part, source, replace(optimum, factor=factor), dilation(analysis.problem, optimum))
        if not any(are_alike(made, other) for other in out):
            out.append(made)
    return out


def tied_factor(problem: LimitProblem, untied: Optimum) -> float:
    """The factor at which a mechanism found without ties starts once those of a problem are there; infinite where one holds it."""
    velocity = untied.velocity / float(problem.live @ untied.velocity)
    longer = problem.bars[: problem.ties] @ velocity
    grows = longer > STILL * float(np.abs(velocity).max(initial=0.0))
    return untied.factor + float(np.sum(longer[grows] * problem.strength[: problem.ties][grows]))


def _named(suffix: str, associated: Optimum | None, least: LeastFound | None) -> list[Source]:
    """The mechanisms that a search found, the least first, and the associated one where there is one."""
    ends = () if least is None else sorted(least.mechanisms, key=lambda end: end.factor)
    found = [*((SEARCH, end) for end in ends), *([] if associated is None else [(ASSOCIATED, associated)])]
    return [(source + suffix, optimum) for source, optimum in found]
