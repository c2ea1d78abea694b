# SPDX-License-Identifier: GPL-3.0-or-later
r"""A check with the hazard of its site: ag, F0 and TC* at the return period of a limit state, and what follows for the capacity.

    PGA_D(LS), F0, TC* at T_R(LS),        T_C of PGA_C by the rows,        zeta_E = PGA_C / PGA_D,        the class of risk

F0 and TC* of PGA_C are those of its own return period where the hazard has them; beyond the rows those of the last or the first. Of SLD and
SLC the capacity is looked for in the same way and of the same mechanism, as far as the code checks them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from masonry_cd.analysis.code_check.borne import Borne
from masonry_cd.analysis.code_check.steps import CodeCheck, Step
from masonry_cd.analysis.code_check.verdicts import how_grave
from masonry_cd.analysis.hazard.curve import Hazard, HazardRow
from masonry_cd.analysis.hazard.life import PROBABILITY, USE
from masonry_cd.analysis.hazard.risk import COST, GUIDELINE, Risk, capacity_of, frequencies, risk_of
from masonry_cd.foundation.errors import InputError

if TYPE_CHECKING:
    from masonry_cd.analysis.code_check.table import CheckTable

STATE = "SLV"  # of a check that names none
ITALIAN = ("NTC2008", "NTC2018")  # codes whose return periods end with the national grid
OF_SPECTRA = {"EC8": ("ag",), "NTC": ("ag", "f0", "tc_star")}  # keys of [limit.check] that a hazard may give
HAZARD, BORNE, RISK = "hazard", "acceleration that is just borne", "risk class"  # parts of a check
GLOBAL = "the class is that of the mechanism checked; the guideline asks for the behaviour of the whole building as well (3.1)"


def completed(check: Mapping[str, Any], hazard: Hazard) -> dict[str, Any]:
    """The keys of ``[limit.check]`` with those that a hazard gives.

    Raises:
        InputError: a key that both give, or a return period beyond the rows.
    """
    spectrum, state = check.get("spectrum"), check.get("limit_state", STATE)
    keys = OF_SPECTRA.get(str(spectrum), ())
    if not hazard.is_of_ag or not keys or "record" in check or state not in PROBABILITY:
        return dict(check)
    row = demand(hazard, str(state), str(check.get("code", "NTC2018")))
    given = {"ag": row.intensity, "f0": row.f0, "tc_star": row.tc_star}
    found = {key: given[key] for key in keys if given[key] is not None}
    for key, value in found.items():
        if key in check:
            raise InputError(f"limit.check.{key}", f"[hazard] gives it for {state}, {value:.4g}; leave it out, or the table [hazard]")
    return {**check, **found}


def demand(hazard: Hazard, state: str, code: str) -> HazardRow:
    """The row of a limit state.

    Raises:
        InputError: a return period beyond the rows.
    """
    return hazard.at(hazard.life.return_period(state, code in ITALIAN))


def known_at(hazard: Hazard | None, table: CheckTable) -> Hazard | None:
    """The hazard of a check: that of its scene, or where that is a life alone the one through the ag of the table.

    None of a record, and of spectra that are not made of ag.
    """
    if hazard is None or table.spectrum not in OF_SPECTRA or table.ag is None or (hazard.known and not hazard.is_of_ag):
        return None
    if hazard.known:
        return hazard
    return hazard.through(table.ag, hazard.life.return_period(table.limit_state, table.code in ITALIAN))


Search = Callable[[str, HazardRow], Sequence[Borne]]
"""Gives what the checks of the mechanism just meet at a limit state, under the motion of a row; none where the code has no such check."""


def with_site(made: CodeCheck, table: CheckTable, hazard: Hazard, search: Search) -> CodeCheck:
    """A check with the return period that it asks for and the class of risk, and their steps; what it just bears is known."""
    limited, life, state = table.code in ITALIAN, hazard.life, table.limit_state
    notes = (*made.notes, *hazard.notes, *life.notes(state, limited))
    made = replace(made, steps=(*_asked(hazard, table), *made.steps), notes=notes)
    if not limited:
        return made
    risk = _risk(made, table, hazard, search)
    return replace(made, steps=(*made.steps, *_risk_steps(risk)), risk=risk, notes=(*notes, GLOBAL))


def _asked(hazard: Hazard, table: CheckTable) -> Iterator[Step]:
    """The return period of the limit state, and the ag of the rows there."""
    life, state, limited = hazard.life, table.limit_state, table.code in ITALIAN
    use, taken = USE[life.use], life.return_period(state, limited)
    plain = life.reference == use * life.nominal
    yield Step("VN", life.nominal, "years", "NTC 2018, 2.4.1", "nominal life", part=HAZARD)
    yield Step("CU", use, "", "NTC 2018, table 2.4.II", f"coefficient of class of use {life.use}", part=HAZARD)
    yield Step("VR", life.reference, "years", "NTC 2018, [2.4.1]", "reference life", "CU VN" if plain else "max(CU VN, 35)", HAZARD)
    yield Step("PVR", PROBABILITY[state], "", "NTC 2018, table 3.2.I", f"probability of {state} in VR", part=HAZARD)
    formula = "-VR / ln(1 - PVR)"
    formula = formula if taken == life.asked(state) else f"min(max({formula}, 30), 2475)"
    yield Step("TR", taken, "years", "NTC 2018, [3.2.0]", f"return period of {state}", formula, HAZARD)
    if hazard.is_of_ag and table.ag is not None:
        yield from _between(hazard, table.ag, HAZARD)
        power = "(ln(TR / TR1) / ln(TR2 / TR1))"
        yield Step("ag", table.ag, "m/s2", "NTC, annex A", "on rock, between two rows", f"ag1 (ag2 / ag1)^{power}", HAZARD)


def _between(hazard: Hazard, ag: float, part: str) -> Iterator[Step]:
    """The rows between which an ag lies."""
    for n, k in enumerate(hazard.around(ag), start=1):
        row = f"row {k + 1} of the hazard"
        yield Step(f"TR{n}", 1.0 / float(hazard.frequency[k]), "years", "hazard", f"return period of {row}", part=part)
        yield Step(f"ag{n}", float(hazard.intensity[k]), "m/s2", "hazard", f"ag of {row}", part=part)


def period_steps(hazard: Hazard, one: Borne) -> Iterator[Step]:
    """The return period of what a check just bears, after the step of PGA_C."""
    if one.period is None or one.borne is None:
        return
    if one.period.bound:
        meaning = f"bound of the return period of PGA_C, which is {one.period.words}: the rows of the hazard end there"
        yield Step("TC_C", one.period.years, "years", "hazard", meaning, part=BORNE)
        return
    yield from _between(hazard, one.borne, BORNE)
    formula = "TR1 (PGA_C / ag1)^(ln(TR2 / TR1) / ln(ag2 / ag1))"
    yield Step("TC_C", one.period.years, "years", "NTC, annex A", f"return period of PGA_C, {one.check} check", formula, BORNE)


def _risk(made: CodeCheck, table: CheckTable, hazard: Hazard, search: Search) -> Risk:
    """The class of risk of the mechanism that is checked."""
    least: dict[str, float | None] = {}
    assumed: list[str] = []
    for state in ("SLD", "SLV", "SLC"):
        if state == table.limit_state:
            worst = min(range(len(made.verdicts)), key=lambda k: how_grave(made.verdicts[k]))
            least[state] = made.borne[worst].borne
            continue
        try:
            found = search(state, demand(hazard, state, table.code))
        except InputError as failure:
            assumed.append(f"for {state} the hazard {failure.faults[0].text}")
            continue
        if found:
            every = [math.inf if one.borne is None else one.borne for one in found]
            least[state] = None if math.isinf(min(every)) else min(every)
    if "SLV" not in least:
        return risk_of(None, (), tuple(assumed))
    asked, borne = demand(hazard, "SLV", table.code).intensity, least["SLV"]
    index = None if borne is None else borne / asked
    if "SLC" not in least:
        assumed.append("lambda(SLC) = 0.49 lambda(SLV) (note 3)")
    assumed.append("lambda(SLO) = 1.67 lambda(SLD) (note 3)")
    if hazard.f0 is None and table.spectrum == "NTC":
        assumed.append("F0 and TC* of the check at all limit states")
    return risk_of(index, tuple(capacity_of(state, ag, hazard, asked) for state, ag in least.items()), tuple(assumed))


def _risk_steps(risk: Risk) -> Iterator[Step]:
    """IS-V, lambda of each limit state and PAM."""
    if risk.index is not None:
        yield Step("IS-V", risk.index, "", GUIDELINE, f"index of safety, class {risk.index_class}", part=RISK)
    if risk.loss is None:
        return
    how = {one.state: one.how for one in risk.capacities}
    rule = {"SLID": "by definition", "SLO": "1.67 lambda(SLD)", "SLC": "0.49 lambda(SLV)"}
    often = frequencies({one.state: one.frequency for one in risk.capacities})
    for state in COST:
        yield Step(f"lambda({state})", often[state], "1/year", GUIDELINE, how.get(state, rule.get(state, "")), part=RISK)
    terms, states = [], [*COST]
    for before, after in pairwise(states):
        terms.append(f"(lambda({before}) - lambda({after})) {0.5 * (COST[before] + COST[after]):g}")
    formula = " + ".join([*terms, "lambda(SLC)"])
    yield Step(
        "PAM", risk.loss, "1/year", GUIDELINE, f"mean annual loss over the cost of reconstruction, class {risk.loss_class}", formula, RISK
    )
