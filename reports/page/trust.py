# SPDX-License-Identifier: GPL-3.0-or-later
"""How far the numbers can be trusted: what the run checked of itself, in words for an engineer, and what to do where a check is not met.

Every check has a number, a verdict and a sentence on what it means; the verdicts are those of :mod:`masonry_cd.analysis.damage.verdict`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from masonry_cd.analysis.damage.verdict import END as END_OF_RUN
from masonry_cd.analysis.damage.verdict import ENERGY, FALSE_MOTION, FORCES, LIFT, OVERLAP, TIME_STEP
from masonry_cd.analysis.verdict import GOOD
from masonry_cd.foundation.quantities import length
from reports.drawing.figure import in_metres
from reports.page.section import Section
from reports.page.words import PageContext, number


@dataclass(frozen=True)
class Check:
    """What a run says of itself in one respect; what to do is said where it is not good."""

    name: str
    measured: str
    verdict: str
    meaning: str
    remedy: str  # what to do where it is not good


def trust(context: PageContext) -> Mapping[str, Any]:
    """The checks, with what they come to."""
    return {"checks": checks(context), "words": context.verdict.words}


def checks(context: PageContext) -> list[Check]:
    """What the run says of itself; nothing for one without a summary."""
    summary = context.summary
    known = [_end(context)] if summary.get("steps") else []
    if "error_max" in summary.get("solver", {}):
        known.append(_solver(context))
    if summary.get("solver", {}).get("false_slip_max") is not None:
        known.append(_false_motion(context))
    if "balance_error" in summary.get("energy", {}):
        known.append(_energy(context, summary["energy"]))
    if "penetration_max" in summary:
        known.append(_overlap(context))
    if "time_step_remarks" in summary:
        known.append(_time_step(context, summary))
    return known


def _end(context: PageContext) -> Check:
    """Whether the run came to its end, and the blocks to rest."""
    stopped = context.summary.get("stopped")
    time = number(float(context.results.time[-1]), "s")
    found = f"ended early at {time}" if stopped else f"moving at {time}" if context.provisional else f"at rest at {time}"
    return Check(
        END_OF_RUN,
        found,
        context.checks.of(END_OF_RUN),
        "What is left of cracks, slips and drifts, and the grades, hold once all standing blocks are still.",
        "They are provisional here: let the run go on (run.until_still, run.longest, or --resume).",
    )


def _solver(context: PageContext) -> Check:
    """Whether the contact forces of each step were found."""
    solver, missed, steps = context.summary["solver"], context.missed, context.steps or context.summary["steps"]
    closing = context.summary.get("closing", {})
    measured = f"{missed or 'no'} of {steps} steps missed {number(context.tolerance)}; error {_two(solver['error_max'])} at most"
    meaning = (
        "In each time step all contact forces are found at once, so that no joint pulls, none is pushed together further, and friction "
        "obeys Coulomb's law. The error is by how much they miss this, as a share of what the step has to balance: 10⁻³ is a "
        f"thousandth. It was {_two(solver['error_mean'])} on average."
    )
    remedy = (
        "Look at the plot of the solver's error: single steps in an impact hardly matter, stretches of missed steps do. Raise "
        "run.max_iterations, or halve run.dt."
    )
    if closing.get("steps"):
        jam = f": {closing['jam']}" if closing.get("jam") else ""
        remedy = (
            f"{closing['steps']} steps left contacts closing{jam}. Their forces mean nothing: look at what pushes blocks together there."
        )
    return Check(FORCES, measured, context.checks.of(FORCES), meaning, remedy)


def _false_motion(context: PageContext) -> Check:
    """What the error of the contact forces comes to in m/s and in mm."""
    solver = context.summary["solver"]
    slip, opening = solver["false_slip_max"], solver["false_opening_max"]
    where = f", {solver['false_slip_where']}" if solver.get("false_slip_where") else ""
    return Check(
        FALSE_MOTION,
        f"{length(solver['violation_max'])}/s at most; {in_metres(slip)} of slip{where} and {in_metres(opening)} of opening in all",
        context.checks.of(FALSE_MOTION),
        "The error of the contact forces lets joints slip that friction should hold, and part that are pressed. A slip stays and adds up, "
        "here at the single worst contact. It should be small beside the largest displacement.",
        "Tighten run.tolerance until it is.",
    )


def _energy(context: PageContext, energy: Mapping[str, Any]) -> Check:
    """Whether the energy adds up."""
    name, meaning = (
        ENERGY,
        "The work of the base, of gravity and of forces is either still there as motion or was lost to friction and impacts. What does not "
        "add up is an error of the computation.",
    )
    if energy.get("at_rest"):
        return Check(name, f"off by {_two(energy['balance_max'])} J", GOOD, f"{meaning} No work was done to speak of.", "")
    open_share, lift = energy["balance_error"] or 0.0, energy.get("lift_share") or 0.0
    lifted = f"; taking overlaps away put in {_two(lift)}" if lift > LIFT[0] else ""
    measured = f"open by {_two(open_share)} of the largest work{lifted}"
    return Check(name, measured, context.checks.of(ENERGY), meaning, "Halve run.dt and compare; if it stays, tighten run.tolerance.")


def _overlap(context: PageContext) -> Check:
    """How far blocks got into one another."""
    deepest, threshold = context.summary["penetration_max"] or 0.0, context.thresholds.opened
    where = f", {context.summary['penetration_where']}" if context.summary.get("penetration_where") else ""
    return Check(
        OVERLAP,
        f"{in_metres(deepest)} at most{where}",
        context.checks.of(OVERLAP),
        f"Blocks should not enter one another. Openings and slidings below this mean nothing; they count from {in_metres(threshold)}.",
        "Halve run.dt, and tighten run.tolerance; a jam between moving supports shows here as well.",
    )


def _time_step(context: PageContext, summary: Mapping[str, Any]) -> Check:
    """Whether the time step resolves the shaking and the blocks."""
    remarks, adapted = summary["time_step_remarks"], summary.get("time_step")
    measured = f"{length(summary['dt'], 's')}"
    if adapted:
        measured = f"{length(adapted['shortest'], 's')} to {length(adapted['longest'], 's')}, by the local error"
    return Check(
        TIME_STEP,
        measured,
        context.checks.of(TIME_STEP),
        "It has to resolve the shaking, the rocking of the smallest block, and the fastest motion.",
        " ".join(f"{remark}." for remark in remarks),
    )


def _two(value: float | None) -> str:
    """Two digits."""
    return number(value, digits=2) if value is not None else "unknown"


SECTIONS = {"trust": Section("How far the numbers can be trusted", trust, 20)}
