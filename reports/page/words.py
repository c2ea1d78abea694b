# SPDX-License-Identifier: GPL-3.0-or-later
"""The case as text and numbers: the structure, its loads, its damage, and the reliability of the run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.end_state import EndState
from masonry_cd.analysis.damage.joint_damage import JointDamage, in_words, joint_counts
from masonry_cd.analysis.damage.part_damage import DamageSettings, PartDamage
from masonry_cd.analysis.damage.verdict import Checks, checks_of
from masonry_cd.analysis.deformed import Solids
from masonry_cd.analysis.outputs import PAGE, Number, numbers_in
from masonry_cd.analysis.outputs.measured import Measured
from masonry_cd.analysis.support_motion import STILL, SupportMotion, support_motions
from masonry_cd.analysis.verdict import Verdict
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from reports.drawing.figure import in_metres

JOINTS = {
    "joints_only_opened": "joints opened",
    "joints_only_slid": "joints slid",
    "joints_opened_and_slid": "joints opened and slid",
    "joints_separated": "joints separated",
}
PEAKS = (("pga", "PGA", "m/s²"), ("pgv", "PGV", "m/s"), ("pgd", "PGD", "m"))  # of a base motion: key, name and unit
TABLES = {"structure": "Structure", "material": "Material", "run": "Computation", "report": "Report"}


@dataclass(frozen=True, eq=False)
class PageContext:
    """Context of the texts of a page."""

    results: Results
    thresholds: Thresholds
    end: EndState  # how the run ended
    missed: int  # steps above the tolerance
    steps: int  # steps whose error is known
    tolerance: float
    summary: Summary  # without a key where there is none
    parts: PartDamage | None  # the damage by part, for a table of its own
    carried: Mapping[str, np.ndarray]  # files that the page carries, bytes by their names

    @cached_property
    def measured(self) -> Measured:
        """The run, for its numbers."""
        return Measured(self.results, DamageSettings(self.thresholds), self.summary, self.parts)

    @property
    def solids(self) -> Solids:
        """The blocks as built."""
        return self.measured.solids

    @property
    def table(self) -> JointDamage:
        """The damage joint by joint."""
        return self.measured.table

    @property
    def provisional(self) -> str:
        """Why residual values are not the last, as text."""
        return self.end.provisional

    @cached_property
    def checks(self) -> Checks:
        """Checks of the run."""
        found = Summary(collapsed_blocks=len(self.measured.fallen), displacement_max=self.measured.displacement_max)
        return checks_of(self.summary | found, self.thresholds, self.end)

    @cached_property
    def tables(self) -> dict[str, Any]:
        """The tables of the scene; empty where the result keeps none."""
        return self.results.tables

    @cached_property
    def motions(self) -> tuple[SupportMotion, ...]:
        """How the supports move, each motion by its own."""
        return support_motions(self.results, self.solids)

    @property
    def moving_axes(self) -> list[str]:
        """The axes along which supports move."""
        spans = [np.ptp(motion.displacement, axis=0) for motion in self.motions]
        return [axis for k, axis in enumerate("xyz") if any(span[k] > STILL for span in spans)]

    @cached_property
    def verdict(self) -> Verdict:
        """On the run, with the grade of its structure where the page has the damage by part."""
        return self.checks.verdict(None if self.parts is None else self.parts.parts[-1])

    @property
    def report(self) -> Mapping[str, Any]:
        """The scene's table ``[report]``; empty where there is none."""
        found: Mapping[str, Any] = self.tables.get("report", {})
        return found

    def fallen_of_kinds(self) -> list[tuple[str, int, int]]:
        """Return for blocks and for spheres, where there are free ones, how many fell, and of how many."""
        down, fixed = set(self.measured.fallen), self.solids.fixed
        free = [block for block, held in zip(self.results.blocks, fixed, strict=True) if not held]
        kinds = {"blocks": [b for b in free if not b.radius], "spheres": [b for b in free if b.radius]}
        return [(kind, sum(b.name in down for b in those), len(those)) for kind, those in kinds.items() if those]


def capital(text: str) -> str:
    """A text that begins with a capital."""
    return text[:1].upper() + text[1:]


RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float, unit: str = "", digits: int = 4) -> str:
    """A given number of digits at most, powers of ten as such."""
    if not np.isfinite(value):
        return "unknown"
    text = f"{float(f'{value:.{digits}g}'):.4g}"
    if "e" in text:
        mantissa, power = text.split("e")
        text = (f"{mantissa} × " if mantissa != "1" else "") + f"10{str(int(power)).translate(RAISED)}"
    return f"{text} {unit}".strip()


def sensible(value: float) -> str:
    """A residual value in mm or per cent with at most three digits, and none below a thousandth."""
    return "< 0.001" if np.isfinite(value) and 0.0 < abs(value) < 1e-3 else number(value, digits=3)


def lead(context: PageContext) -> str:
    """Describe the structure and the computation, in a paragraph."""
    blocks, solids = context.results.blocks, context.solids
    groups = list(dict.fromkeys(b.group for b, fixed in zip(blocks, solids.fixed, strict=True) if not fixed))
    named = f" ({', '.join(groups[:6])}{' …' if len(groups) > 6 else ''})" if groups else ""
    free = solids.vertices[~solids.fixed[solids.vertex_block]]
    extent = " × ".join(in_metres(v) for v in np.ptp(free, axis=0)) if len(free) else "nothing free"
    time = context.results.time
    span = f"{number(float(time[0]), 's')} to {number(float(time[-1]), 's')}"
    held = int(solids.fixed.sum())
    supports = "1 block is a support" if held == 1 else f"{held or 'no'} blocks are supports"
    dt, adapted = context.summary.dt, context.summary.time_step
    of = f" of {number(1e3 * dt)} ms" if dt else ""
    if adapted is not None:
        of = f" of {number(1e3 * adapted.shortest)} to {number(1e3 * adapted.longest)} ms"
    steps = f", {context.steps} steps{of}" if context.steps else ""
    return (
        f"{len(blocks)} blocks{named} and {context.results.joints.count} joints, {extent} (x, y, z) without supports; "
        f"{supports}. Computed from {span}{steps}."
    )


def outcome(context: PageContext) -> list[str]:
    """The damage, in two sentences."""
    table = context.table
    opening, sliding = (in_metres(float(np.nanmax(values, initial=0.0))) for values in (table.max_opening, table.max_sliding))
    widest = f"the widest opening was {opening}, the farthest sliding {sliding}"
    kinds = context.fallen_of_kinds()
    if context.measured.fallen:
        down = " and ".join(f"{fell or 'none'} of {free} {kind}" for kind, fell, free in kinds)
    else:
        down = " and ".join(f"no {kind.removesuffix('s')}" for kind, *_ in kinds) or "no block"
    farthest = f"The largest displacement relative to the base is {in_metres(context.measured.displacement_max)}."
    return [f"{in_words(table)}, of {context.results.joints.count} in all; {widest}; {down} fell.", farthest]


def notices(context: PageContext) -> list[str]:
    """Return the notices of the run; empty when all is well."""
    summary, out = context.summary, []
    if summary.stopped:
        out.append(f"The run ended early: {summary.stopped}. The page shows it up to there.")
    elif not summary.steps:
        out.append("The run has no summary: it was stopped or is still running. The page shows the results written so far.")
    if context.provisional:
        why = context.provisional.partition(": ")[2]
        out.append(
            f"Residual values are provisional: {why}. Openings, slidings, drifts, mechanisms and grades would change if the run continued."
        )
    if context.missed:
        largest = f"; the largest error is {number(summary.solver.error_max)}" if summary.solver.has("error_max") else ""
        of = f"{context.missed} of {context.steps} steps missed the tolerance {number(context.tolerance)} of the solver"
        out.append(f"{of}{largest}. They are marked in the plot of the solver's error.")
    return out


def tiles(context: PageContext) -> list[tuple[str, str, str]]:
    """The headline numbers: what each is, the number, and small print behind it."""
    counts, of_joints = joint_counts(context.table), f" of {context.results.joints.count}"
    seconds, steps = context.summary.stepping_seconds, context.summary.steps
    rows = [("grade of the structure", context.verdict.grade, "")] if context.parts is not None else []
    rows += [
        *((name, str(getattr(counts, key)), of_joints) for key, name in JOINTS.items()),
        *((f"{kind} fallen", str(fell), f" of {free}") for kind, fell, free in context.fallen_of_kinds()),
        *((one.name, _shown(one, context), "") for one in numbers_in(PAGE).values()),
        (
            "steps that missed the tolerance",
            str(context.missed) if context.steps else "unknown",
            f" of {context.steps}" * bool(context.steps),
        ),
    ]
    if seconds and steps:
        rows.append(("per step", number(1e3 * seconds / steps, "ms", 3), ""))
    return rows


def _shown(one: Number, context: PageContext) -> str:
    """A number as the page has it; lengths in the unit that suits their size."""
    value = one.compute(context.measured)
    if value is None:
        return "unknown"
    return in_metres(value) if one.unit == "m" else number(one.shown[1] * value, one.shown[0], digits=3)


def settings(context: PageContext) -> list[tuple[str, list[tuple[str, str]]]]:
    """The scene's tables, the loads with their sizes, and the versions, as titled lists of terms."""
    tables = context.tables
    stands = [(f"Structure {table.get('name', k + 1)}", terms(table)) for k, table in enumerate(tables.get("structures", []))]
    boxes = stands + [(title, terms(tables[key])) for key, title in TABLES.items() if isinstance(tables.get(key), Mapping)]
    amounts = context.summary.loads.tables
    for k, load in enumerate(tables.get("loads", [])):
        after = amounts[k].get("after", {}) if k < len(amounts) else {}
        peaks = [(name, number(after[key], unit)) for key, name, unit in PEAKS if isinstance(after.get(key), (int, float))]
        boxes.insert(1 + (len(stands) or 1) + k, (f"Load {k + 1}", terms(load) + peaks))
    boxes.append(("Versions", terms(context.results.versions)))
    return [(title, rows) for title, rows in boxes if rows]


def terms(table: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Keys of a table and their values, as text."""
    return [(key.replace("_", " "), _plain(value)) for key, value in table.items()]


def _plain(value: Any) -> str:
    """A value of TOML as text."""
    if isinstance(value, Mapping):
        return ", ".join(f"{key}: {_plain(item)}" for key, item in value.items())
    if isinstance(value, list):
        text = ", ".join(map(_plain, value))
        return text if len(text) < 120 else text[:117] + "…"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)
