# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run has come to: summary.json, and the same in words."""

from __future__ import annotations

import json
import math
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd import __version__
from masonry_cd.analysis.damage.verdict import FEW, SOUND_ELASTIC, SOUND_RIGID, beyond_their_law, not_acted
from masonry_cd.analysis.modal.left_out import left_out_lines
from masonry_cd.analysis.pushover import push_lines
from masonry_cd.analysis.verdict import Verdict
from masonry_cd.app.left_out import elasticity_left_out
from masonry_cd.app.load_factor import joints_in_words, outcome_lines
from masonry_cd.app.modelled import masses
from masonry_cd.app.run_report import RunReport
from masonry_cd.app.time_step_summary import steps_in_words, time_step_lines, time_step_summary
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.quantities import counted, in_words, length, per_cent
from masonry_cd.io.summary_file import FORMAT
from masonry_cd.mechanics.dynamics.adaptive import error_tolerance
from masonry_cd.mechanics.model.masonry_kinds import facts
from masonry_cd.mechanics.solvers import threads_that_pay

if TYPE_CHECKING:
    from masonry_cd.app.case import Case
    from masonry_cd.io.results import Results

REPORTED = 1e-3  # share of the largest work from which on the closing lines report what the correction of overlaps put in


def run_summary(case: Case, report: RunReport) -> dict[str, Any]:
    """What the run itself yields for summary.json."""
    settings = case.scene.run
    steps = time_step_summary(settings, report, error_tolerance(settings, case.assembly))
    energy = {("kinetic_end" if name == "kinetic" else name): value for name, value in report.energy.items()}
    return {
        "format": FORMAT,
        "title": case.scene.title,
        "version": __version__,
        "stopped": report.stopped,
        "signal": report.signal,
        "steps": report.steps,
        "steps_asked": report.steps if settings.adaptive and not report.stopped else settings.steps,
        "duration": settings.steps * settings.dt,
        "longest": case.steps * settings.dt,
        "still": case.still,
        "ended_still": report.ended_still,
        "dt": settings.dt,
        "wall_seconds": 0.0,
        "stepping_seconds": report.stepping_seconds,
        "contacts_mean": report.contacts_mean,
        "contacts_max": report.contacts_max,
        "planar": report.planar,
        "solver": {
            "name": settings.solver,
            "threads": threads_that_pay(settings.threads, report.contacts_max, 2 if report.planar else 3),
            "tolerance": settings.tolerance,
            "seed": settings.seed,
            "iterations_mean": report.iterations_mean,
            "iterations_max": report.iterations_max,
            "error_max": report.error_max,
            "error_mean": report.error_mean,
            "violation_max": report.violation_max,
            "false_slip_max": report.false_slip_max,
            "false_slip_where": report.false_slip_where,
            "false_opening_max": report.false_opening_max,
            "steps_missed": report.steps_missed,
            "accept": settings.accepted,
            "steps_accepted": report.steps_accepted,
            "reasons": report.solver_reasons,
        },
        "islands": {"mean": report.islands_mean, "max": report.islands_max, "sleeping_mean": report.sleeping_mean},
        "left_out": {"steps_without_iterations": report.steps_as_before} | report.left_out,
        "built_gap": case.built_gap,
        "penetration_max": report.penetration_max,
        "penetration_where": report.penetration_where,
        "shortening_max": report.shortening_max,
        "shortening_where": report.shortening_where,
        "closing": {"steps": report.steps_closing, "speed_max": report.closing_max, "jam": report.jam},
        "energy": energy
        | {
            "balance_error": report.balance_error,
            "balance_max": report.balance_max,
            "at_rest": report.at_rest,
            "lift_share": report.lift_share,
        },
        "modelled": [masses(case.assembly), *case.notes, *case.loading.lines],
        "loads": case.loading.summary,
        **({} if case.scene.material.masonry is None else {"masonry": facts(case.scene.material.masonry)}),
        **elasticity_left_out(case),
        **steps,
    }


def loads_acted(case: Case, results: Results) -> list[dict[str, Any]]:
    """The share of each load that has acted in the steps of a run; a rest at its end adds none, since the loads were cut off before."""
    reached = results.per_step("load_step")
    steps = min(int(reached[-1]), case.scene.run.steps) if len(reached) else 0
    return [one.row(steps * case.scene.run.dt) for one in case.loading.acted]


def tolerances(case: Case, results: Results) -> dict[str, Any]:
    """The error that all but FEW of the steps stay within, and the tolerance up to which no bias was found (docs/accuracy.md)."""
    error = results.per_step("solver/error")
    elastic = bool(case.assembly.laws.elastic.any())
    return {
        "error_reached": float(np.quantile(error, 1.0 - FEW, method="higher")) if len(error) else 0.0,
        "tolerance_sound": SOUND_ELASTIC if elastic else SOUND_RIGID,
    }


def as_json(summary: dict[str, Any]) -> str:
    """A summary as JSON; what is not finite becomes null, since JSON knows no NaN."""

    def plain(value: Any) -> Any:
        if isinstance(value, dict):
            return {str(key): plain(item) for key, item in value.items()}
        if isinstance(value, (list, tuple, np.ndarray)):
            return [plain(item) for item in value]
        if isinstance(value, np.generic):
            value = value.item()
        return None if isinstance(value, float) and not math.isfinite(value) else value

    return json.dumps(plain(summary), indent=2) + "\n"


def write_json(summary: dict[str, Any], path: Path) -> None:
    """Write a summary."""
    with replacing(path) as part:
        part.write_text(as_json(summary), encoding="utf-8")


def crushed_lines(s: dict[str, Any]) -> list[str]:
    """How many joints crushed, and by how much at most; nothing where none did."""
    where = f", {s['crushed_where']}" if s.get("crushed_where") else ""
    most = f"by {length(s.get('crushed_max', 0.0))} at the most{where}"
    return [f"crushing: {counted(s['joints_crushed'], 'joint')}, {most}"] if s.get("joints_crushed") else []


def closing_lines(summary: dict[str, Any]) -> list[str]:
    """What happened, in words."""
    s, solver, energy = summary, summary["solver"], summary["energy"]
    per_step = s["stepping_seconds"] / max(1, s["steps"])
    lifted = energy.get("lift_share", 0.0)
    reported = lifted >= REPORTED and not energy["at_rest"]
    lift = f"; taking overlaps away lifted blocks by {100 * lifted:.2g} % of it besides" if reported else ""
    deep = f", of {s['penetration_where']}" if s.get("penetration_where") else ""
    bonds = [f"bonds: {s['joints_broken']} of {s['joints_bonded']} bonded joints broke"] if s.get("joints_bonded") else []
    crushed = crushed_lines(s)
    on = f" on {solver['threads']} threads" if solver["threads"] > 1 else ""
    return [
        f"{s['title']}: {steps_in_words(s)} in {in_words(s['stepping_seconds'])}, "
        f"{length(per_step, 's')} per step; {in_words(s['wall_seconds'])} in all",
        *verdict_lines(s),
        *time_step_lines(s),
        *outcome_lines(s),
        *push_lines(s.get("pushes", [])),
        damage_line(s),
        *_end_lines(s),
        *acted_lines(s),
        *_part_lines(s),
        *bonds,
        *crushed,
        *_stress_lines(s),
        f"contacts: {s['contacts_mean']:.0f} on average, {s['contacts_max']} at most{', solved in their plane' if s['planar'] else ''}; "
        f"largest penetration {length(s['penetration_max'])}{deep}",
        *_bed_lines(s),
        *beyond_their_law(s),
        f"solver {solver['name']}{on}: {solver['iterations_mean']:.0f} iterations on average, {solver['iterations_max']} at most; "
        f"error {solver['error_mean']:.1e} on average, {solver['error_max']:.1e} at most",
        *_violation_lines(solver),
        f"energy: balance closed to {_balance(energy)}{lift}",
        *left_out_lines(s),
    ]


def _violation_lines(solver: dict[str, Any]) -> list[str]:
    """What the error of the solver comes to in m/s and in mm; nothing of older runs."""
    if solver.get("violation_max") is None:
        return []
    left = f"{length(solver['false_slip_max'])} of slip and {length(solver['false_opening_max'])} of opening"
    return [f"contact laws: violated by {length(solver['violation_max'])}/s at most, which adds up to {left} at the worst contacts"]


def verdict_lines(s: dict[str, Any]) -> list[str]:
    """The verdict on the run, before anything that it found; nothing of a summary of an older version."""
    found = s.get("verdict", {})
    keys = [item.name for item in fields(Verdict)]
    return [Verdict(**{key: found[key] for key in keys}).line] if all(key in found for key in keys) else []


def _bed_lines(s: dict[str, Any]) -> list[str]:
    """That joints have too few points for how they opened; nothing where all are resolved."""
    from masonry_cd.analysis.damage.verdict import bed_words

    return [f"elastic joints: {bed_words(s['beds'])}"] if (s.get("beds") or {}).get("unresolved") else []


def _balance(energy: dict[str, Any]) -> str:
    """How the balance closed: as a share of the largest work, in joules where there was none to speak of."""
    if energy["at_rest"]:
        return f"{energy['balance_max']:.1e} J; no work was done beyond what the tolerance of the steps leaves"
    return f"{energy['balance_error']:.1e} of the largest work done"


def damage_line(s: dict[str, Any]) -> str:
    """The damage in one line."""
    fallen = f"{s['collapsed_blocks'] or 'none'} of {s['blocks']} blocks fell"
    moved = f"largest displacement relative to the base {length(s['displacement_max'])}"
    return f"joints: {s['joints']}, of which {joints_in_words(s)}; {fallen}; {moved}"


def _end_lines(s: dict[str, Any]) -> list[str]:
    """How long the run went on beyond its duration, and whether what is left is final."""
    more = s["end"]["time"] - s["duration"] if "end" in s and "duration" in s else 0.0
    lines = []
    if more > 0.5 * s["dt"] and not s.get("shocks"):
        until = f"still moving when run.longest, {s['longest']:g} s, was over" if s.get("provisional") else "until all blocks were still"
        loose = f"; {s['end']['rattles']} rattles in its place" if s["end"].get("rattles") else ""
        lines.append(f"rest: {more:.4g} s more than run.duration, {until}{loose}")
    return [*lines, *([f"what is left at the end is {s['provisional']}"] if s.get("provisional") else [])]


def acted_lines(s: dict[str, Any]) -> list[str]:
    """How much of each load has acted; nothing of a run whose loads all act from the start."""
    acted = [f"{one['load']} {per_cent(one['share'])} of its {one['measure']}" for one in s.get("loads", {}).get("acted", [])]
    return [f"loads that acted: {', '.join(acted)}"] if acted else []


def _part_lines(s: dict[str, Any]) -> list[str]:
    """The damage part by part, where the scene asks for it."""
    if "parts" not in s:
        return []
    from masonry_cd.app.part_lines import part_lines

    return part_lines(s["parts"])


def _stress_lines(s: dict[str, Any]) -> list[str]:
    """The stress of blocks and joints, where the scene asks for it."""
    if not s.get("stress"):
        return []
    from masonry_cd.analysis.stress.words import stress_lines

    return stress_lines(s["stress"])


def run_warnings(summary: dict[str, Any]) -> list[str]:
    """Steps that missed their tolerance, and a run that ended early."""
    solver, lines = summary["solver"], []
    if solver["steps_missed"]:
        beyond = solver["steps_missed"] - solver["steps_accepted"]
        lines.append(
            f"{solver['steps_missed']} of {summary['steps']} steps missed the tolerance {solver['tolerance']:g}, "
            f"{beyond or 'none'} of them by more than is accepted ({solver['accept']:g}); "
            f"the largest error is {solver['error_max']:.1e} (each step's: solver/error in result.h5)"
        )
    lines += [f"{short} when the run ends: a longer run.duration or an earlier start has it act" for short in not_acted(summary)]
    lines += _false_motion(summary)
    closing = summary["closing"]
    if closing["steps"]:
        left = f"{closing['steps']} of them left contacts closing, at up to {length(closing['speed_max'])}/s, so that overlaps grow"
        why = f": {closing['jam']}; no solution is without penetration, and forces and work of such steps mean nothing"
        lines.append(left + (why if closing["jam"] else ""))
    if summary["stopped"]:
        lines.append(f"the run ended early, {summary['stopped']}; the results hold all frames up to there")
    return lines


def _false_motion(summary: dict[str, Any]) -> list[str]:
    """That violations of the contact laws are no longer small beside the motion, where they are not."""
    from masonry_cd.analysis.damage.verdict import FALSE_SHARE

    solver, moved = summary["solver"], summary.get("displacement_max", 0.0)
    slip, opening = solver["false_slip_max"], solver["false_opening_max"]
    if not (solver["false_slip_where"] and max(slip, opening) > FALSE_SHARE[0] * moved):
        return []
    share = f"{100.0 * max(slip, opening) / moved:.2g} % of the largest displacement" if moved else "the blocks do not move"
    return [
        f"violations of the contact laws have added up to {length(slip)} of slip that friction should have held "
        f"({solver['false_slip_where']}) and {length(opening)} of opening: {share}; a smaller run.tolerance makes them less"
    ]
