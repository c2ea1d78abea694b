# SPDX-License-Identifier: GPL-3.0-or-later
"""The share of summary.json that a run itself yields (:mod:`masonry_cd.io.summary`), with the elasticity that its joints leave out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd import __version__
from masonry_cd.analysis.damage.verdict import FEW, SOUND_ELASTIC, SOUND_RIGID
from masonry_cd.app.run_report import RunReport
from masonry_cd.io.summary import FORMAT, Summary
from masonry_cd.io.summary_tables import (
    ActedLoad,
    ClosingSteps,
    Energy,
    IslandCounts,
    LoadSummary,
    SkippedWork,
    Solver,
    SummaryTable,
    TimeStep,
)
from masonry_cd.mechanics.dynamics.adaptive import error_tolerance
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.masonry_kinds import facts
from masonry_cd.mechanics.solvers import threads_that_pay

if TYPE_CHECKING:
    from masonry_cd.app.case import Case
    from masonry_cd.io.results import Results


def run_summary(case: Case, report: RunReport) -> Summary:
    """Return the summary of the run itself; numbers that a report counts step by step have its names."""
    settings, named = case.scene.run, case.scene.material.masonry
    energy = {("kinetic_end" if name == "kinetic" else name): value for name, value in report.energy.items()}
    found = Summary(
        format=FORMAT,
        title=case.scene.title,
        version=__version__,
        **_of(report, Summary),
        steps_asked=report.steps if settings.is_adaptive and not report.stopped else settings.steps,
        duration=settings.steps * settings.dt,
        longest=case.steps * settings.dt,
        still=case.still,
        dt=settings.dt,
        wall_seconds=0.0,
        solver=Solver(
            name=settings.solver,
            threads=threads_that_pay(settings.threads, report.contacts_max, 2 if report.planar else 3),
            tolerance=settings.tolerance,
            seed=settings.seed,
            **_of(report, Solver),
            accept=settings.accepted,
            reasons=report.solver_reasons,
        ),
        islands=IslandCounts(mean=report.islands_mean, max=report.islands_max, sleeping_mean=report.sleeping_mean),
        left_out=SkippedWork(steps_without_iterations=report.steps_as_before, **report.left_out),
        built_gap=case.built_gap,
        closing=ClosingSteps(steps=report.steps_closing, speed_max=report.closing_max, jam=report.jam),
        energy=Energy(**energy | _of(report, Energy)),
        modelled=(masses(case.assembly), *case.notes, *case.loading.lines),
        loads=LoadSummary(**case.loading.summary),
    )
    found |= elasticity_left_out(case)
    if named is not None:
        found |= Summary(masonry=facts(named))
    if settings.is_adaptive:
        found |= Summary(time_step=_time_step(settings, report, error_tolerance(settings, case.assembly)))
    return found


def _of(report: RunReport, table: type[SummaryTable]) -> dict[str, Any]:
    """The numbers of a report that a table has by the same names; its energy is a table of its own."""
    return {name: getattr(report, name) for name in table.model_fields if hasattr(report, name) and name not in ("energy", "left_out")}


def _time_step(settings: Run, report: RunReport, tolerance: float) -> TimeStep:
    """Return the account of a time step that adapts, with a ``tolerance`` of the local error [m]."""
    lengths = sorted((int(span), count) for span, count in report.spans.items())
    taken = [span for span, _ in lengths] or [1]
    return TimeStep(
        shortest=taken[0] * settings.dt,
        median=_median(lengths) * settings.dt,
        longest=taken[-1] * settings.dt,
        dt_min=settings.dt,
        dt_max=settings.longest_step,
        tolerance=tolerance,
        local_error_max=report.local_error_max,
        repeated_for_error=report.repeated_error,
        repeated_for_solver=report.repeated_solver,
        steps_wanted_shorter=report.steps_too_long,
        base_drift_max=report.base_drift_max,
        steps_by_length=tuple({"dt": span * settings.dt, "steps": count} for span, count in lengths),
    )


def _median(lengths: list[tuple[int, int]]) -> int:
    """The middle length of steps given as (length, how many), sorted."""
    half, passed = 0.5 * sum(count for _, count in lengths), 0
    for span, count in lengths:
        passed += count
        if passed >= half:
            return span
    return 1


def loads_acted(case: Case, results: Results) -> tuple[ActedLoad, ...]:
    """The share of each load that has acted in the steps of a run; a rest at its end adds none, since the loads were cut off before."""
    reached = results.per_step("load_step")
    steps = min(int(reached[-1]), case.scene.run.steps) if len(reached) else 0
    return tuple(ActedLoad(**one.row(steps * case.scene.run.dt)) for one in case.loading.acted)


def tolerances(case: Case, results: Results) -> dict[str, float]:
    """The error that all but FEW of the steps stay within, and the tolerance up to which no bias was found (docs/accuracy.md)."""
    error = results.per_step("solver/error")
    elastic = bool(case.assembly.laws.elastic.any())
    return {
        "error_reached": float(np.quantile(error, 1.0 - FEW, method="higher")) if len(error) else 0.0,
        "tolerance_sound": SOUND_ELASTIC if elastic else SOUND_RIGID,
    }


NAMED = 12  # groups whose masses are listed, the heaviest


def masses(assembly: Assembly) -> str:
    """The masses of the free blocks, what rides on them included, in a line."""
    free, riding = ~assembly.fixed, sum(block.carried.mass for block in assembly.blocks if block.carried is not None)
    by_group = np.bincount(assembly.group_of[free], assembly.mass[free], minlength=len(assembly.groups))
    heaviest = [k for k in np.argsort(-by_group, kind="stable").tolist() if by_group[k] > 0.0]
    named = [f"{assembly.groups[k]} {1e-3 * by_group[k]:.4g} t" for k in heaviest[:NAMED]]
    named += ["and others"] if len(heaviest) > NAMED else []
    fill = f"; {1e-3 * riding:.4g} t of it is fill that rides on blocks" if riding else ""
    return f"masses: {1e-3 * assembly.mass[free].sum():.4g} t free to move, {', '.join(named)}{fill}"


FEW_FREE = 5  # free blocks that are a study of mechanics rather than a building


def elasticity_left_out(case: Case) -> Summary:
    """The elastic period that rigid joints leave out, for the summary; nothing where something is elastic, or nothing shakes."""
    from loads import shakes

    assembly, material = case.assembly, case.scene.material
    shaken = case.loading.support_velocity.any() and shakes(case.scene.loads)  # a settlement moves the base once
    rigid = assembly.deformation is None and not assembly.laws.elastic.any() and not assembly.shapes.rounding.any()
    if not rigid or (~assembly.fixed).sum() <= FEW_FREE or not case.joints.count or not shaken:
        return Summary()
    from masonry_cd.analysis.modal.elastic_period import elastic_period

    named = material.masonry
    moduli = None if named is None else named.model_copy(update={"stiffness": "mean"}).moduli
    velocity = case.loading.support_velocity[..., :3]
    moved = velocity[: case.scene.run.steps + 1].mean(axis=1)
    return elastic_period(assembly, case.joints, moved, case.scene.run.dt, moduli)
