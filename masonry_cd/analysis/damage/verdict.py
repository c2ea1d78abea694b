# SPDX-License-Identifier: GPL-3.0-or-later
"""The reliability of a run, judged by the checks of the run itself, and the verdict on it.

Each check is ``good``: it does not limit the results; ``look``: read its reason; or ``doubtful``: do not rely on the run until the cause is
removed. The verdict on the run is that of its worst check. A doubtful run has no grade of damage: the verdict replaces it everywhere.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.end_state import EndState
from masonry_cd.analysis.damage.joint_damage import collapsed_blocks, displacement_max
from masonry_cd.analysis.verdict import DOUBTFUL, GOOD, LOOK, NOT_GRADED, RANKS, UNKNOWN, Verdict
from masonry_cd.foundation.quantities import counted, length, per_cent
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.io.summary_tables import Beds, Check, RunVerdict, Solver

END, FORCES, FALSE_MOTION = "End of the run", "Contact forces", "Motion against the contact laws"
ENERGY, OVERLAP, TIME_STEP, BEDS = "Energy balance", "Overlap of blocks", "Time step", "Points of open joints"
LOADS, LAWS, MODEL = "Loads", "Joint laws", "Model"
WORDS = {
    GOOD: "all checks of the computation are good",
    LOOK: "check these points before you rely on the run",
    DOUBTFUL: "do not rely on this run until the cause is removed",
    UNKNOWN: "the run left no summary, so its checks are not known",
}

ENOUGH = 0.95  # share of a load that has to act: 95 % of the Arias intensity end the significant duration of a record
FEW = 0.01  # share of the steps that may miss the tolerance before a run is doubtful
NOTHING = 1e-6  # share of the largest work below which nobody reads by how much the balance is open
SOUND_RIGID, SOUND_ELASTIC = 1e-3, 5e-3  # tolerances up to which ensembles of buildings show no bias, by their joints: docs/accuracy.md
BALANCE = (1e-3, 2e-2)  # share of the largest work by which the balance may be open: good up to the first, doubtful beyond the second
LIFT = (1e-3, 5e-2)  # likewise of what taking overlaps away put in: docs/accuracy.md has it of a church by tolerance, and where that biases
FALSE_SHARE = (0.01, 0.1)  # likewise of what violations of the contact laws add up to, as a share of the largest displacement
DEPTH = (1.0, 10.0)  # likewise of the largest overlap, in thresholds of an open joint
OF_DEBRIS = 10.0  # times the second where blocks fell: what lands gets as deep as it falls in a step, and changes no grade of what stands
OF_MOTION = 0.05  # share of the largest displacement that is as good as the second: what strikes gets as deep as it moves in a step


@dataclass(frozen=True)
class Finding:
    """The verdict of one check, and the numbers that led to it, in plain words."""

    name: str
    verdict: str
    why: str


@dataclass(frozen=True)
class Checks:
    """Checks of a run itself; all unknown for a run that left no summary."""

    findings: tuple[Finding, ...] = ()

    @property
    def worst(self) -> str:
        """``good``, ``look``, ``doubtful``, or ``unknown``."""
        return max((found.verdict for found in self.findings), key=RANKS.index, default=UNKNOWN)

    @property
    def is_reliable(self) -> bool:
        """False for a run that is doubtful: its damage is not graded."""
        return self.worst != DOUBTFUL

    def of(self, name: str) -> str:
        """The verdict of a check; unknown where it was not made."""
        return next((found.verdict for found in self.findings if found.name == name), UNKNOWN)

    def verdict(self, whole: Mapping[str, Any] | None = None) -> Verdict:
        """The verdict on the run, with the grade that a row of the damage by part gives its structure; None without one."""
        decisive = [found for found in self.findings if found.verdict == self.worst != GOOD]
        names = ", ".join(found.name.lower() for found in decisive)
        words = WORDS[self.worst] + (f": {names}" if names else "")
        grade, means, because = (whole["grade"], whole["grade_label"], whole["grade_reason"]) if whole else ("", "", "")
        if not self.is_reliable:
            grade, means, because = NOT_GRADED, "", ""
        return Verdict(grade, means, because, self.worst, words, "; ".join(found.why for found in decisive))

    def as_summary(self, whole: Mapping[str, Any] | None = None) -> Summary:
        """For summary.json."""
        checks = tuple(Check(check=found.name, verdict=found.verdict, why=found.why) for found in self.findings)
        return Summary(verdict=RunVerdict(verdict=self.worst, **self.verdict(whole).as_dict(), checks=checks))

    def instead_of_a_grade(self) -> dict[str, str]:
        """Return the entries that replace the grade in the row of a part; none where the run can be relied on."""
        found = self.verdict()
        return {} if self.is_reliable else {"grade": found.grade, "grade_label": found.words, "grade_reason": found.trust}


def checks_of(summary: Summary, thresholds: Thresholds, end: EndState | None = None) -> Checks:
    """Return the checks of a run, from its numbers.

    Args:
        summary: of the run, or what its results hold of it; without keys where there is none.
        thresholds: of damage; overlaps are measured by them.
        end: how the run ended, which says more than the summary of one that was cut off.
    """
    found = [_end(summary, end)] if summary.steps or (end is not None and end.stopped) else []
    if summary.solver.has("error_max"):
        found.append(_forces(summary))
    if summary.solver.false_slip_max is not None:
        found.append(_false_motion(summary, summary.solver.false_slip_max, thresholds))
    if summary.energy.has("balance_error"):
        found.append(_energy(summary, thresholds))
    if summary.has("penetration_max"):
        found.append(_overlap(summary, thresholds))
    if summary.time_step_remarks is not None:
        found.append(_time_step(summary, summary.time_step_remarks))
    if summary.beds is not None:
        found.append(_beds(summary.beds))
    if summary.loads.acted is not None:
        short = not_acted(summary)
        found.append(Finding(LOADS, LOOK, "; ".join(short)) if short else Finding(LOADS, GOOD, "all of them have acted"))
    found += [_noted(LAWS, lines, "") for lines in [beyond_their_law(summary)] if lines]
    if summary.doubts is not None:
        found.append(_noted(MODEL, summary.doubts, "no value is unusual, and every block is carried"))
    return Checks(tuple(found))


def checks_on(results: Results, thresholds: Thresholds, end: EndState) -> Checks:
    """Return the checks of the run of a result file."""
    of_results = Summary(collapsed_blocks=len(collapsed_blocks(results, thresholds)), displacement_max=displacement_max(results))
    return checks_of((results.closing or Summary()) | of_results, thresholds, end)


def graded(value: float, bounds: tuple[float, float]) -> str:
    """The verdict on a value by where it is good up to and doubtful from; one that is not finite is doubtful."""
    return GOOD if value <= bounds[0] else LOOK if value <= bounds[1] else DOUBTFUL


def _end(summary: Summary, end: EndState | None) -> Finding:
    """Judge if the run came to its end, and the blocks to rest."""
    stopped = summary.stopped or (end.stopped if end is not None else "")
    provisional = end.provisional if end is not None else summary.provisional
    if stopped:
        return Finding(END, DOUBTFUL, f"it ended early: {stopped}")
    return Finding(END, LOOK, provisional) if provisional else Finding(END, GOOD, "at rest")


def _forces(summary: Summary) -> Finding:
    """Judge if the contact forces of each step were found."""
    solver, steps, closing = summary.solver, summary.steps, summary.closing
    missed, error = solver.steps_missed, solver.error_max
    if closing.steps:
        jam = f": {closing.jam}" if closing.jam else ""
        return Finding(FORCES, DOUBTFUL, f"{closing.steps} steps left contacts closing{jam}")
    will_do = tolerance_that_does(solver) if missed > FEW * steps else None
    sound = missed <= FEW * steps or will_do is not None
    verdict = GOOD if not missed else LOOK if sound and error < 1.0 else DOUBTFUL
    remedy = "" if will_do is None else f"; set run.tolerance = {will_do:g}, which 99 % of the steps meet"
    return Finding(FORCES, verdict, f"{missed} of {steps} steps missed the tolerance, with an error of {error:.2g} at most{remedy}")


def tolerance_that_does(solver: Solver) -> float | None:
    """The tolerance that all but FEW of the steps of a run reached, to one digit upwards; None where that would bias what joints do."""
    reached, sound = solver.error_reached, solver.tolerance_sound
    if not reached or not sound or not reached <= sound:
        return None
    power = 10.0 ** math.floor(math.log10(reached))
    return min(sound, power * math.ceil(reached / power))


def _false_motion(summary: Summary, slip: float, thresholds: Thresholds) -> Finding:
    """How far joints moved against the contact laws; lengths that count for nothing compared with the structure's size have no place named.

    What is less than the width from which on a joint counts as open or slid changes no grade: a structure nearly at rest has moved by
    little more.
    """
    solver, moved, opening = summary.solver, summary.displacement_max, summary.solver.false_opening_max or 0.0
    why = f"the error of the contact forces adds up to {length(slip)} of slip and {length(opening)} of opening"
    least = min(thresholds.opened, thresholds.slid)
    verdict = graded(max(slip, opening), (FALSE_SHARE[0] * moved, max(FALSE_SHARE[1] * moved, least)))
    if not solver.false_slip_where or verdict == GOOD:
        return Finding(FALSE_MOTION, GOOD, why)
    return Finding(FALSE_MOTION, verdict, why + tighter(solver, max(slip, opening), max(FALSE_SHARE[0] * moved, FALSE_SHARE[1] * least)))


def tighter(solver: Solver, false: float, wanted: float) -> str:
    """``; set run.tolerance = 1e-05``: the power of ten that makes false motion or work, which goes with the tolerance, as small as
    ``wanted``."""
    if not solver.tolerance or not 0.0 < wanted < false:
        return ""
    return f"; set run.tolerance = {10.0 ** math.floor(math.log10(solver.tolerance * wanted / false)):g}"


def _energy(summary: Summary, thresholds: Thresholds) -> Finding:
    """Judge if the energy adds up; what lifts a structure that moves by less than an open joint is wide changes no grade."""
    energy = summary.energy
    still = summary.has("displacement_max") and summary.displacement_max <= min(thresholds.opened, thresholds.slid)
    if energy.at_rest:
        return Finding(ENERGY, GOOD, "the loads did no appreciable work")
    share, lift = energy.balance_error, energy.lift_share
    closed = share <= NOTHING
    verdict = max(graded(share, BALANCE), GOOD if still else graded(lift, LIFT), key=RANKS.index)
    closes = "the energy balance closes" if closed else f"the energy balance is open by {100 * share:.2g} % of the largest work"
    lifted = f", and taking overlaps away put in {100 * lift:.2g} %{' of the largest work' if closed else ''}"
    remedy = tighter(summary.solver, lift, LIFT[1]) if verdict == DOUBTFUL and share <= BALANCE[1] else ""
    return Finding(ENERGY, verdict, closes + (lifted + remedy if lift > LIFT[0] else ""))


def _overlap(summary: Summary, thresholds: Thresholds) -> Finding:
    """How far blocks got into one another."""
    deepest, threshold = summary.penetration_max, thresholds.opened
    where = f", of {summary.penetration_where}" if summary.penetration_where else ""
    usual, debris = DEPTH[1] * threshold, OF_DEBRIS * DEPTH[1] * threshold
    most = debris if summary.collapsed_blocks else min(max(usual, OF_MOTION * summary.displacement_max), debris)
    verdict = graded(deepest, (DEPTH[0] * threshold, most))
    return Finding(OVERLAP, verdict, f"blocks overlap by up to {length(deepest)}{where}")


def not_acted(summary: Summary) -> list[str]:
    """A line for each load of which less than ENOUGH has acted in a run."""
    acted = summary.loads.acted or ()
    return [f"{per_cent(one.share)} of the {one.measure} of {one.load} has acted" for one in acted if one.share < ENOUGH]


def beyond_their_law(summary: Summary) -> list[str]:
    """Lines on joints that went where their law no longer describes them."""
    lines = []
    if summary.shortening_where:
        shortened = f"joints shortened by up to {length(summary.shortening_max)}, {summary.shortening_where}"
        lines.append(f"{shortened}; stones would crush, elastic joints do not")
    if lost := summary.crushing_forgotten:
        lines.append(f"crushing: of {counted(lost, 'joint')} it is forgotten: the blocks came far apart, or met again with other faces")
    return lines


def _noted(name: str, lines: Sequence[str], otherwise: str) -> Finding:
    """A check by lines that the run says anyway: a verdict is never better than these."""
    return Finding(name, LOOK, "; ".join(lines)) if lines else Finding(name, GOOD, otherwise)


def _time_step(summary: Summary, remarks: Sequence[str]) -> Finding:
    """Judge if the time step resolves the shaking and the blocks."""
    adapted = summary.time_step
    if remarks:
        return Finding(TIME_STEP, LOOK, "; ".join(remarks))
    if adapted and adapted.steps_wanted_shorter > FEW * summary.steps:
        short = f"{adapted.steps_wanted_shorter} of {summary.steps} steps should have been shorter than run.dt_min"
        return Finding(TIME_STEP, LOOK, f"{short}, {length(adapted.dt_min, 's')}")
    if adapted:
        return Finding(TIME_STEP, GOOD, f"{length(adapted.shortest, 's')} to {length(adapted.longest, 's')}, by the local error")
    return Finding(TIME_STEP, GOOD, "" if summary.dt is None else length(summary.dt, "s"))


def _beds(found: Beds) -> Finding:
    """Judge if the points of elastic joints resolve the part of their depth that carries while they are open."""
    if found.unresolved:
        return Finding(BEDS, LOOK, bed_words(found))
    least = found.share_least
    return Finding(BEDS, GOOD, "no joint opened" if least is None else f"joints carry on {100 * least:.2g} % of their depth at the least")


def bed_words(found: Beds) -> str:
    """How many elastic joints carry on less of their depth than their points resolve, the worst of them, and what to do."""
    return (
        f"{counted(found.unresolved, 'open joint')} carried on less of the depth than the points resolve, {found.where} on "
        f"{100 * found.share:.2g} % of it where {found.points} points resolve {100 * found.resolved:.2g} %: too strong by some "
        f"{200 / 3 * found.share:.2g} %; more material.joints.joint_points resolve it"
    )
