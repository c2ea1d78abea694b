# SPDX-License-Identifier: GPL-3.0-or-later
"""An assessment as text: the range of the verdict, what decides it, what to pin down first, and what to know of the runs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from masonry_cd.analysis.assessment.assessment import (
    BASE,
    ENSEMBLE,
    FACTOR,
    GRADE,
    LEVEL,
    UNSETTLED,
    AssessedNumber,
    Assessment,
    KnownAssumption,
    Member,
)
from masonry_cd.analysis.assessment.indices import LARGEST_ERROR, Indices
from masonry_cd.analysis.damage.grades import NAMES
from masonry_cd.analysis.damage.verdict import ENOUGH
from masonry_cd.analysis.verdict import DOUBTFUL, GOOD, LOOK, NOT_GRADED, UNKNOWN, Verdict
from masonry_cd.foundation.quantities import counted

MOST = 0.5  # share of the largest weight from which an assumption decides as well
NOTHING = 5e-4  # in the unit of an answer: half of the last digit that anybody reads [mm]
NAMED = 3  # answers that a line names, and pairs


def lines_of(found: Assessment) -> list[str]:
    """The closing lines, the verdict first."""
    if not found.base.row.done:
        return [f"{found.title}: no verdict, the base case has no result: {_why(found.base)}"]
    out = [f"{found.title}: {verdict(found)}"]
    out += [_pin_line(found, one, place) for place, one in enumerate(to_pin_down(found), 1)]
    out += [f"ensemble of {sum(one.row.done for one in found.ensemble)}: {_spreads(found)}"] if len(found.ensemble) > 1 else []
    out += [*_pair_lines(found), *_index_lines(found)]
    return out + [f"not varied: {name}: {why}" for name, why in found.left_out]


def verdict(found: Assessment) -> str:
    """``between D2 and D4; joint stiffness decides; time step and tolerance do not``."""
    return "; ".join([_range(found), *_deciding(found)])


def _deciding(found: Assessment) -> list[str]:
    """Which assumptions decide, which count as well, which do not, and of which nothing is known."""
    deciding = found.deciding
    first = [one for one in deciding if found.weight(one) >= MOST * found.weight(deciding[0])]
    then = [one for one in deciding if one not in first]
    idle = [one for one in found.assumptions if one not in deciding and found.is_tested(one)] if first else []
    unknown = [one for one in found.assumptions if not found.is_tested(one)]
    none = "no assumption shows beyond chance" if len(found.ensemble) > 1 else "no assumption changes it"
    said = (
        (first, f"{_named(first)} {'decides' if len(first) == 1 else 'decide'}"),
        (not first, none),
        (then, f"{_named(then)} {'counts' if len(then) == 1 else 'count'} as well"),
        (idle, f"{_named(idle)} {'does' if len(idle) == 1 else 'do'} not"),
        (unknown, f"nothing is known of {_named(unknown)}"),
    )
    return [words for there, words in said if there]


def on_the_whole(found: Assessment) -> Verdict:
    """Return the verdict on all runs: no grade of one run where an assumption decides, nor where a setting of the computation does."""
    if not found.base.row.done:
        return Verdict("", "", "", UNKNOWN, "no verdict, the base case has no result", _why(found.base))
    others = _deciding(found)
    numerical = [one for one in found.deciding if one.numerical]
    if found.base.row.number("grade") == NOT_GRADED or numerical:
        words = "do not rely on these runs until the cause is removed"
        reason = [f"{_named(numerical)} {'changes' if len(numerical) == 1 else 'change'} the answers"] if numerical else []
        reason += [f"the base case cannot be relied on{_doubt(found.base)}"] if found.base.row.number("grade") == NOT_GRADED else []
        return Verdict(_range(found), "", "", DOUBTFUL, words, "; ".join([*reason, *others]))
    if found.deciding:
        return Verdict(_range(found), "", "", LOOK, "what is assumed decides, no single run is the answer", "; ".join(others))
    if warned := warnings_of(found):
        return Verdict(_range(found), "", "", LOOK, "check these points before you rely on these runs", "; ".join([*warned, *others]))
    return Verdict(_range(found), "", "", GOOD, "; ".join(others) or "nothing that was varied changes it", "")


def to_pin_down(found: Assessment) -> list[KnownAssumption]:
    """Assumptions on the structure that show, the weightiest first."""
    return [one for one in found.deciding if not one.numerical]


def warnings_of(found: Assessment) -> list[str]:
    """On the runs."""
    if not found.base.row.done:
        return []
    out = [f"{place_of(one)}: no result: {_why(one)}" for one in found.members if one.row.status and not one.row.done]
    waiting = sum(not one.row.status for one in found.members)
    out += [f"{waiting} of {len(found.members)} runs have not been made"] if waiting else []
    lost = [one for one in found.sampled if not one.row.done]
    out += [f"{len(lost)} of {len(found.sampled)} runs with all varied together have no result: {_why(lost[0])}"] if lost else []
    out += [f"{place_of(one)}: no load factor: {one.row.limit_reason}" for one in found.members if one.row.done and one.row.limit_reason]
    done = [one for one in found.members if one.row.done]
    ungraded = [one for one in done if "grade" in one.row.numbers and one.row.number("grade_number") is None]
    cut = [one for one in done if one.row.number("provisional")]
    on = "run.until_still = true has them go on" if found.base in cut else ""
    groups = (
        ([one for one in done if one.missed], "missed the tolerance in some steps (marked *)", ""),
        (ungraded, f"cannot be relied on and {'is' if len(ungraded) == 1 else 'are'} not graded", ""),
        (cut, "ended while blocks still moved, so that what remains, and grades, are provisional", on),
        (
            [one for one in done if one.row.numbers.get("loads_acted", 1.0) < ENOUGH],
            f"ended before {100 * ENOUGH:g} % of a load had acted",
            "",
        ),
        (
            [one for one in done if one.row.remark == UNSETTLED],
            "began with the weight coming upon the joints at once, as they did not settle",
            "",
        ),
    )
    out += [f"{counted(len(some), 'run')} {what}: {remedy or _some(some)}" for some, what, remedy in groups if some]
    numerical = [one.name for one in found.deciding if one.numerical]
    if numerical:
        out.append(f"{' and '.join(numerical)} change the answers: make them finer until they do not, before anything else is concluded")
    return out


def place_of(member: Member) -> str:
    """A run by what it changes: ``friction 0.48``."""
    if member.kind == BASE:
        return "base case"
    if member.kind == ENSEMBLE:
        return f"ensemble {member.number or ''}".strip()
    return ", ".join(f"{name} {level}" for name, level in member.values.items())


def shown(answer: AssessedNumber, value: float) -> str:
    """A value with three digits, in its unit."""
    if not np.isfinite(value):
        return ""
    if answer == GRADE:
        return NAMES[int(value)]
    if answer.whole:
        return f"{value:.0f}"
    return f"{answer.factor * value:.3g}" if abs(answer.factor * value) >= NOTHING else "0"


def between(answer: AssessedNumber, low: float, high: float) -> str:
    """``92 to 239 mm``."""
    a, b = shown(answer, low), shown(answer, high)
    unit = f" {answer.unit}" if answer.unit else ""
    return f"{a}{unit}" if a == b else f"{a} to {b}{unit}"


def _range(found: Assessment) -> str:
    """The range of what the verdict is on: the grade, the load factor, else the first answer."""
    parts = []
    if np.isfinite(found.range(GRADE)[0]):
        low, high = (NAMES[int(value)] for value in found.range(GRADE))
        some = " that have a grade" if any(one.row.done and one.row.number("grade") == NOT_GRADED for one in found.members) else ""
        parts.append(f"{low} in all runs{some}" if low == high else f"between {low} and {high}")
    if FACTOR in found.answers:
        low, high = (shown(FACTOR, value) for value in found.range(FACTOR))
        parts.append(f"load factor {low}" if low == high else f"load factor between {low} and {high}")
    if not parts:
        answer = found.answers[0]
        parts.append(f"{answer.name} {between(answer, *found.range(answer))}, not graded")
    return ", ".join(parts)


def _why(member: Member) -> str:
    """Why a run has no result."""
    return member.row.reason if member.row.status else "it was not run"


def _doubt(member: Member) -> str:
    """`` (the error of the contact forces adds up to 12 mm of slip ...)``; nothing of runs that earlier versions made."""
    return f" ({member.row.doubt})" if member.row.doubt else ""


def _pin_line(found: Assessment, one: KnownAssumption, place: int) -> str:
    """``pin down 1: joint stiffness: largest displacement 92 to 239 mm (base case 92, chance 88 to 96)``."""
    bars = [(answer, found.bar(one, answer)) for answer in found.answers]
    said = []
    for answer, bar in sorted((pair for pair in bars if pair[1].shows), key=lambda pair: -found.share(one, pair[0]))[:NAMED]:
        chance = between(answer, *found.chance(answer))  # none of a load factor that no run of the ensemble has
        by_chance = f" (chance alone {chance})" if len(found.ensemble) > 1 and chance.strip() else ""
        said.append(f"{answer.name} {between(answer, bar.low, bar.high)}{by_chance}")
    return f"pin down {place}: {one.name}: {'; '.join(said)}"


def _spreads(found: Assessment) -> str:
    """Describe the spread of each answer by chance."""
    return "; ".join(f"{answer.name} {between(answer, *found.chance(answer))}" for answer in found.answers if answer != FACTOR)


def _pair_lines(found: Assessment) -> list[str]:
    """Pairs that go farther from what their two levels do alone than chance takes them."""
    answer = found.answers[0]
    clear = [(pair, by) for pair, by in found.interactions(answer) if abs(by) > found.by_chance(answer, 4)]
    every = found.interactions(answer)
    if not every:
        return []
    if not clear:
        return [f"pairs: none of {len(every)} differs in its {answer.name} from what its two levels do alone, beyond chance"]
    said = "; ".join(
        f"{place_of(pair)} ({'+' if by > 0 else '-'}{shown(answer, abs(by))} {answer.unit})".replace(" )", ")")
        for pair, by in clear[:NAMED]
    )
    return [f"pairs: {len(clear)} of {len(every)} differ in their {answer.name} from what their two levels do alone: {said}"]


def _index_lines(found: Assessment) -> list[str]:
    """``all at once, 60 runs: largest displacement: friction explains 62 % (41 % by itself), ...``; or why there are no indices."""
    out = []
    for answer, one in found.indices.items():
        if one.refused:
            out.append(f"all at once: {answer.name}: no indices, {one.refused}")
            continue
        most = np.argsort(-one.total)[:NAMED]
        said = ", ".join(f"{found.unknowns[k].name} {100 * one.total[k]:.0f} % ({100 * one.first[k]:.0f} % by itself)" for k in most)
        out.append(f"all at once, {one.runs} runs: {answer.name}: of its variance {said}; {error_in_words(one)}")
    return out


def error_in_words(one: Indices) -> str:
    """Describe the cross-validation of a surrogate."""
    return f"the surrogate misses runs left out by {100 * one.error:.0f} % of their spread (limit {100 * LARGEST_ERROR:.0f} %)"


def _named(known: Sequence[KnownAssumption]) -> str:
    """Names with commas and an "and"."""
    return " and ".join(filter(None, [", ".join(one.name for one in known[:-1]), *(one.name for one in known[-1:])]))


def _some(members: Sequence[Member]) -> str:
    """The first of some runs, with what one of them cannot be relied on for."""
    names = [f"{place_of(one)}{_doubt(one) if k == 0 else ''}" for k, one in enumerate(members[:NAMED])]
    return ", ".join(names) + (" ..." if len(members) > NAMED else "")


def heading(member: Member) -> tuple[str, str]:
    """The first two cells of a run in tables: what it changes, and to what."""
    if member.kind == BASE:
        return "base case", ""
    if member.kind == ENSEMBLE:
        return "ensemble", f"1 + {member.number or '?'}e-9"
    if member.kind == LEVEL:
        return next(iter(member.values.items()))
    return " & ".join(member.values), " & ".join(member.values.values())
