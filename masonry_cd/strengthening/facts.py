# SPDX-License-Identifier: GPL-3.0-or-later
"""strengthen.json: target, ties with forces, bars and prices, and every part before and after; the lines of the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from masonry_cd.analysis.code_check.check import with_borne
from masonry_cd.analysis.code_check.verdicts import LINEAR
from masonry_cd.analysis.verdict import GOOD, LOOK, Verdict
from masonry_cd.foundation.quantities import counted as number_of
from masonry_cd.foundation.quantities import force
from masonry_cd.limit.case import LimitCase
from masonry_cd.limit.checked import Checked, way_words
from masonry_cd.strengthening.asked import StrengtheningTask
from masonry_cd.strengthening.design import StrengtheningDesign, counted

STAGES = ("before", "with_least", "after")
LISTED = 8  # ties and parts that the terminal names


def facts(made: StrengtheningDesign) -> dict[str, Any]:
    """The contents of strengthen.json."""
    from masonry_cd import __version__

    asked = made.asked
    table = _table(made)
    return {
        "title": asked.scene.title,
        "version": __version__,
        "target": {"kind": "factor" if asked.goal.check is None else "zeta_E", "value": asked.goal.value, "words": asked.goal.words},
        "on_the_whole": _verdict(made, table).as_dict(),
        "factor": {stage: min((row[f"factor_{stage}"] for row in table if row[f"factor_{stage}"]), default=None) for stage in STAGES},
        "zeta_E": {stage: min((row[f"zeta_E_{stage}"] for row in table if row[f"zeta_E_{stage}"]), default=None) for stage in STAGES},
        "verdict": {stage: _code_verdict(getattr(made, stage)) for stage in STAGES},
        "cost": {"least": made.least.cost, "bars": made.cost, "one_per_cent_more": made.least.one_more},
        "ties": [_tie(made, k) for k in range(len(made.ties))],
        "candidates": [
            {"name": keys["name"], "length": float(length), "largest_force": float(most), "worth_per_kn": 1e3 * float(worth)}
            for keys, length, most, worth in zip(asked.rows, asked.lengths, asked.candidates.most, made.least.worth, strict=True)
        ],
        "parts": table,
        "cuts": len(made.cuts),
        "cuts_by_search": sum(not cut.dilates for cut in made.cuts),
        "notes": list(dict.fromkeys([*asked.notes, *_stones(made), *(note for case in made.after for note in case.notes)])),
        "seconds": made.seconds,
    }


def least_row(asked: StrengtheningTask, rows: Sequence[Checked]) -> Checked | None:
    """The mechanism that starts earliest against what is asked of it; None of none."""
    return min(rows, key=lambda each: each.one.oscillator.alpha / asked.goal.asked(each.one), default=None)


def zeta_of(case: LimitCase, each: Checked) -> float | None:
    """zeta_E of a mechanism by accelerations; None without a check, or where every motion is borne."""
    asked = case.structure.asked.check
    if asked is None or each.check is None or each.level is None or case.ground is None:
        return None
    return next(
        one.share for one in with_borne(each.check, asked, each.level, each.one.oscillator, case.ground).borne if one.check == LINEAR
    )


def _table(made: StrengtheningDesign) -> list[dict[str, Any]]:
    """A row for each part and push: the mechanism that starts earliest before, with the least forces, and with bars."""
    found: dict[tuple[str, str], dict[str, Any]] = {}
    for stage in STAGES:
        for case in getattr(made, stage):
            parts: dict[tuple[str, str], list[Checked]] = {}
            for each in counted(case):
                parts.setdefault((each.part.element.name, way_words(each.part.direction)), []).append(each)
            for key, rows in parts.items():
                first = least_row(made.asked, rows)
                assert first is not None
                row = found.setdefault(key, {"part": key[0], "push": key[1]} | dict.fromkeys(_columns()))
                row |= {
                    f"factor_{stage}": first.one.oscillator.alpha, f"asked_{stage}": made.asked.goal.asked(first.one),
                    f"mechanism_{stage}": first.one.name, f"zeta_E_{stage}": zeta_of(case, first),
                    f"state_{stage}": None if first.decides is None else first.decides.state,
                }  # fmt: skip
    return sorted(found.values(), key=lambda row: (row["factor_before"] or np.inf) / (row["asked_before"] or 1.0))


def _columns() -> list[str]:
    """The columns of the table that each stage has."""
    return [f"{name}_{stage}" for stage in STAGES for name in ("factor", "asked", "mechanism", "zeta_E", "state")]


def _tie(made: StrengtheningDesign, k: int) -> dict[str, Any]:
    """A tie of the design."""
    tie = made.ties[k]
    keys = made.asked.rows[tie.number]
    return {
        "name": keys["name"], "along": keys["along"], "height": keys["height"], "at": keys["at"][0], "length": tie.length,
        "least_force": tie.force, "diameter": tie.bar.diameter, "yield_force": tie.yields, "worth_per_kn": tie.worth, "cost": tie.cost,
    }  # fmt: skip


def _code_verdict(cases: Sequence[LimitCase]) -> str | None:
    """The worst state of the checks of some limit analyses; None without a check."""
    from masonry_cd.analysis.code_check.verdicts import WORST_FIRST

    states = [case.verdict.state for case in cases if case.verdict is not None]
    return min(states, key=WORST_FIRST.index, default=None)


def _stones(made: StrengtheningDesign) -> list[str]:
    """A line on stones of one course that slide by themselves below the target."""
    some = [each.one for case in made.after for each in case.mechanisms if each.one.stones]
    early = [one.oscillator.alpha for one in some if one.oscillator.alpha < made.asked.goal.asked(one)]
    if not early:
        return []
    return [f"stones of one course slide by themselves from a load factor of {min(early):.4g} on: no tie holds them, and they do not count"]


def _verdict(made: StrengtheningDesign, table: Sequence[dict[str, Any]]) -> Verdict:
    """The verdict on the design."""
    goal = made.asked.goal
    least = min((row["factor_after"] for row in table if row["factor_after"]), default=None)
    reached = "" if least is None else f"every mechanism found starts at {least:.4g} or more"
    doubts = [case for case in made.after if case.whole is not None and case.whole.analysis.least is None]
    sure, words = (LOOK, "the least factor is not known") if doubts else (GOOD, "verified by the search for the least factor")
    grade = f"{number_of(len(made.ties), 'tie')} for {goal.words}" if made.ties else f"{goal.words} is reached without a tie"
    return Verdict(grade, "", reached, sure, words, "the search of one push did not converge: raise limit.starts" if doubts else "")


def lines(found: dict[str, Any]) -> list[str]:
    """The lines of the terminal."""
    cost, state = found["cost"], found["verdict"]
    checked = f"; check {state['before']} before, {state['after']} after" if state["before"] else ""
    out = [
        Verdict(**found["on_the_whole"]).line,
        *_stages("least load factor", found["factor"]),
        *(line + checked for line in _stages("least zeta_E", found["zeta_E"])),
    ]
    for tie in found["ties"][:LISTED]:
        bar = f"a bar of {1e3 * tie['diameter']:g} mm yields at {force(tie['yield_force'])}"
        worth = f"one kN more is worth {tie['worth_per_kn']:.3g} in load factor"
        out.append(f'tie "{tie["name"]}": {force(tie["least_force"])} at least, {bar}; {worth}')
    more = len(found["ties"]) - LISTED
    out += [f"{more} more ties: see ties.csv"] if more > 0 else []
    if found["ties"]:
        percent = f"1 % more of the target costs {cost['one_per_cent_more']:.3g}"
        out.append(f"cost {cost['least']:.4g} of the least forces, {cost['bars']:.4g} of the bars; {percent}")
    by_search = f"{found['cuts_by_search']} of them without dilation"
    return [
        *out,
        f"{number_of(len(found['candidates']), 'candidate')}, {number_of(found['cuts'], 'mechanism')} below the target, {by_search}",
    ]


def _stages(what: str, values: dict[str, float | None]) -> list[str]:
    """A line on a number before and after; none where it is not known."""
    if values["before"] is None or values["after"] is None:
        return []
    return [f"{what} {values['before']:.4g} before, {values['with_least']:.4g} with the least forces, {values['after']:.4g} with bars"]
