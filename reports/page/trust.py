# SPDX-License-Identifier: GPL-3.0-or-later
"""How far the numbers can be trusted: the checks of the run with what each found, what it means, and what to do where it is not met."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from masonry_cd.analysis.damage.verdict import END, ENERGY, FALSE_MOTION, FORCES, OVERLAP, TIME_STEP
from masonry_cd.analysis.verdict import GOOD
from reports.page.section import Section
from reports.page.templates import Badge
from reports.page.words import PageContext, capital

SAID = {  # what a check means, and what to do
    END: (
        "What is left of cracks, slips and drifts, and the grades, hold once all standing blocks are still.",
        "They are provisional here: let the run go on (run.until_still, run.longest, or --resume).",
    ),
    FORCES: (
        "In each time step all contact forces are found at once, so that no joint pulls, none is pushed together further, and friction "
        "obeys Coulomb's law. The error is by how much they miss this, as a share of what the step has to balance: 10⁻³ is a thousandth.",
        "Look at the plot of the solver's error: single steps in an impact hardly matter, stretches of missed steps do. Raise "
        "run.max_iterations, or halve run.dt. Where steps left contacts closing, their forces mean nothing: look at what pushes blocks "
        "together there.",
    ),
    FALSE_MOTION: (
        "The error of the contact forces lets joints slip that friction should hold, and part that are pressed. A slip stays and adds up, "
        "here at the single worst contact. It should be small beside the largest displacement.",
        "Tighten run.tolerance until it is.",
    ),
    ENERGY: (
        "The work of the base, of gravity and of forces is either still there as motion or was lost to friction and impacts. What does not "
        "add up is an error of the computation.",
        "Halve run.dt and compare; if it stays, tighten run.tolerance.",
    ),
    OVERLAP: (
        "Blocks should not enter one another. Openings and slidings below this mean nothing.",
        "Halve run.dt, and tighten run.tolerance; a jam between moving supports shows here as well.",
    ),
    TIME_STEP: ("It has to resolve the shaking, the rocking of the smallest block, and the fastest motion.", "Take a smaller run.dt."),
}


def trust(context: PageContext) -> Mapping[str, Any]:
    """The checks with what they come to; what to do is said where one is not good."""
    checks, columns = context.checks.findings, ["check", "found", "verdict", "what it means"]
    rows = [[one.name, capital(one.why), Badge(f"verdict {one.verdict}", one.verdict), SAID[one.name][0]] for one in checks]
    if context.checks.worst != GOOD:
        columns.append("what to do")
        for row, one in zip(rows, checks, strict=True):
            row.append(Badge("wanted", SAID[one.name][1]) if one.verdict != GOOD else "")
    return {"columns": columns, "rows": rows, "words": context.verdict.words}


SECTIONS = {"trust": Section("How far the numbers can be trusted", trust, 20)}
