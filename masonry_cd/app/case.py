"""A run as a function of its scene: scene -> assembly and loading -> results -> damage, summary and pictures.

This is the command line's work without the command line. It alone, with :mod:`masonry_cd.cli`, calls the other rooms, and imports
them inside its functions: a run whose scene asks for no picture never loads VTK.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd import __version__
from masonry_cd.app import time_step_checks
from masonry_cd.app.dump import FILES, Dump
from masonry_cd.app.explain import left_out
from masonry_cd.app.load_factor import joints_in_words, outcome, outcome_lines
from masonry_cd.app.progress import Interrupt, Progress, said_if_slow
from masonry_cd.app.run_loop import RunReport
from masonry_cd.app.run_loop import run as run_steps
from masonry_cd.app.scene import Scene
from masonry_cd.app.warmup import compile_kernels, keeps
from masonry_cd.atomic import part_of, replacing
from masonry_cd.contact.joints import Joints, find_joints
from masonry_cd.dynamics.equilibrium import settle
from masonry_cd.dynamics.moreau_jean import Stepper
from masonry_cd.dynamics.pauses import Rests
from masonry_cd.dynamics.planar import find_plane
from masonry_cd.dynamics.settings import Run
from masonry_cd.errors import InputError
from masonry_cd.io import checkpoint
from masonry_cd.io.lock import locked
from masonry_cd.io.results import Results, ResultWriter
from masonry_cd.jit import why_nothing_is_kept
from masonry_cd.model.blocks import Assembly, Block
from masonry_cd.model.state import State
from masonry_cd.quantities import in_words, length
from masonry_cd.solvers import cores
from reports.settings import Report

if TYPE_CHECKING:
    from loads import Loading

RESULTS, SUMMARY = "result.h5", "summary.json"
OUTPUTS = (
    "result.h5", "joints.csv", "summary.json", "damage.csv", "damage_history.csv", "hinges.csv", "drift.csv", "damage.json",
    "damage_shocks.csv", "crack_map.png", "crack_map.gif", "energy.png", "report.html", "report.pdf",
)  # fmt: skip

TOLD = 1e-3  # share of the largest work from which on the closing lines tell what the correction of overlaps put in


@dataclass(frozen=True, eq=False)
class Case:
    """A scene whose every part is checked and built; nothing is written yet."""

    scene: Scene
    assembly: Assembly
    joints: Joints
    loading: Loading
    notes: tuple[str, ...]  # what was changed in making the blocks, in words
    warnings: tuple[str, ...]  # what the time step is too coarse for, and the machine too small
    seconds: float  # to build it


def build_blocks(scene: Scene) -> list[Block]:
    """The blocks of a scene's structure, see :func:`build_structure`."""
    return build_structure(scene)[0]


def build_structure(scene: Scene) -> tuple[list[Block], list[str]]:
    """The blocks of a scene's structure, and lines on what was changed in making them.

    Raises:
        InputError: with file and line of the scene where a key is at fault.
    """
    import structures

    try:
        with np.errstate(all="ignore"):  # blocks that are not finite are refused by name
            return structures.build_with_notes(scene.structure, scene.material.density, scene.folder)
    except InputError as error:
        raise scene.at_fault(error) from None


def prepare(scene: Scene) -> Case:
    """Build and check all that a run needs.

    Raises:
        InputError: anything wrong with the structure, the material or the loads.
    """
    import loads

    begin = time.perf_counter()
    blocks, notes = build_structure(scene)
    try:
        if scene.report.asks or scene.report.grades:
            from reports import outputs

            outputs.check(scene.report)
        assembly = Assembly.from_blocks(blocks, scene.material.friction, scene.material.joints)
        loading = loads.build(scene.loads, scene.run.dt, scene.run.steps, scene.run.gravity, scene.folder, assembly)
    except InputError as error:
        raise scene.at_fault(error) from None
    if loading.support_velocity.any() and not assembly.fixed.any():
        raise InputError(f"{scene.path}: loads: the base is shaken, but no block of the structure is fixed")
    if loading.support_of is not None:
        assembly = replace(assembly, support_of=loading.support_of)
    for_good = "about half a minute on two cores and is kept for later runs"
    no_folder = "no folder takes numba's cache; NUMBA_CACHE_DIR names one that does"
    again = f"a minute or two in each run, as {why_nothing_is_kept() or no_folder}"
    with said_if_slow(f"compiling the kernels{', once' if keeps() else ''}: this takes {for_good if keeps() else again}"):
        joints = find_joints(assembly)
        compile_kernels(scene.run.solver, _is_planar(assembly, loading, scene.run), bool(assembly.laws.by_area.any()))
    gravity = float(np.linalg.norm(scene.run.gravity))
    coarse = time_step_checks.before_run(assembly, loading.support_velocity, gravity, scene.run.dt)
    warnings = (*coarse, *_beyond_machine(scene.run.threads))
    return Case(scene, assembly, joints, loading, tuple(notes), warnings, time.perf_counter() - begin)


def _beyond_machine(threads: int) -> list[str]:
    """A line where a scene asks for more threads than there are cores; threads change no result, so it runs all the same."""
    there = cores()
    return [f"run.threads: {threads} asked for, {there} used, as many as there are cores for this run"] if threads > there else []


def _is_planar(assembly: Assembly, loading: Loading, settings: Run) -> bool:
    """Whether the run will be solved in a plane."""
    motion = (State.at_rest(assembly), loading.support_velocity, loading.acceleration, loading.forces)
    return settings.planar and find_plane(assembly, *motion) is not None


def run_case(case: Case, folder: Path, quiet: bool = True, resume: bool = False, dump: Sequence[int] = ()) -> dict[str, Any]:
    """Run a case and write everything into a folder, which is made if need be.

    Args:
        case: from :func:`prepare`.
        folder: for the results.
        quiet: no progress.
        resume: go on from the folder's checkpoint, with the scene that it was made by.
        dump: steps whose friction problems are written, see :mod:`masonry_cd.app.dump`.

    Ctrl-C, SIGTERM, SIGHUP and SIGQUIT end the run after its step; once the steps are done they raise Interrupted, and ``resume``
    finishes what was left to write.

    Raises:
        InputError: with ``resume``, a folder without a checkpoint or with one of another scene; a step to dump that the run does not make;
            a folder that another run writes into.

    Returns:
        the summary, as in summary.json; its ``stopped`` says why the run ended early, empty when it did not, and ``signal`` the number of
        the signal that ended it.
    """
    begin = time.perf_counter()
    scene, settings = case.scene, case.scene.run
    saved, dumped = folder / checkpoint.NAME, Dump(folder, dump)
    loading = case.loading
    stepper = Stepper(case.assembly, loading.support_velocity, loading.acceleration, settings, forces=loading.forces)
    if not resume:
        dumped.check(1, settings.steps)
        _settle(stepper, scene)
    with locked(folder), Interrupt() as interrupt:
        mended = ""
        if resume:
            mended = checkpoint.mend(saved)
            dumped.check(checkpoint.load(saved)[1]["report"]["steps"] + 1, settings.steps)
        else:
            _clear(folder)
        stepper.watch = dumped if dump else None
        report = _steps(case, stepper, folder, interrupt, quiet, resume)
        interrupt.at_once = not report.signal  # from here on nothing is torn
        summary = _summary(case, report) | {
            "dumped": [path.name for path in dumped.written],
            "explanation": left_out(scene, stepper, report),
            "warnings": [*([mended] if mended else []), *case.warnings, *dumped.warnings()],
        }
        summary = _write_rest(case, folder, report, summary, case.seconds - begin)
        if not report.stopped:
            checkpoint.remove(saved)
        interrupt.at_once = False
    return summary


def _steps(case: Case, stepper: Stepper, folder: Path, interrupt: Interrupt, quiet: bool, resume: bool) -> RunReport:
    """Make the steps of a run and write result.h5."""
    settings, loading, saved = case.scene.run, case.loading, folder / checkpoint.NAME
    rests = Rests(case.assembly, loading.pauses, loading.shocks, settings.steps) if loading.shocks else None
    show = Progress(settings.steps, quiet)

    def progress(done: int) -> None:
        show(done)
        interrupt.check()

    with _writer(case, folder / RESULTS, saved, resume) as writer, show:
        return run_steps(stepper, case.joints, writer, settings.steps, settings.frame_every, progress, saved, resume, rests)


def _write_rest(case: Case, folder: Path, report: RunReport, summary: dict[str, Any], since: float) -> dict[str, Any]:
    """Write what a run yields beside result.h5; return its summary, whose seconds count from a reading of the clock."""
    scene, settings = case.scene, case.scene.run
    with Results.open(folder / RESULTS) as results:
        summary |= write_damage(results, folder, scene.report) | outcome(case, results)
        fast = time_step_checks.after_run(case.assembly, results, settings.dt)
        gravity = float(np.linalg.norm(settings.gravity))
        restless = time_step_checks.restless(results, case.loading.pauses, gravity, settings.dt, settings.tolerance)
        summary["warnings"] = [*_warnings(summary), *summary["warnings"], *fast, *restless]
        summary["wall_seconds"] = since + time.perf_counter()
        write_json(summary, folder / SUMMARY)  # before the pictures, which may fail for want of a library
        if scene.report.asks and not report.stopped:
            from reports import outputs

            summary |= outputs.write_asked(results, folder, scene.report, summary)
            summary["wall_seconds"] = since + time.perf_counter()
            write_json(summary, folder / SUMMARY)
    return summary


def _settle(stepper: Stepper, scene: Scene) -> None:
    """Let elastic joints take up the weight, unless the scene wants it to come at once."""
    try:
        if scene.run.settle:
            settle(stepper)
    except InputError as error:
        raise scene.at_fault(error) from None


def _clear(folder: Path) -> None:
    """Take away what a former run left in a folder."""
    former = (name for pattern in ("crack_map_*s.png", FILES) for name in folder.glob(pattern))
    for old in (*(folder / name for name in OUTPUTS), *former):
        old.unlink(missing_ok=True)
        part_of(old).unlink(missing_ok=True)
    checkpoint.remove(folder / checkpoint.NAME)


def _writer(case: Case, file: Path, saved: Path, resume: bool) -> ResultWriter:
    """The writer of a new result file, or of one that is gone on with."""
    if not resume:
        return ResultWriter(file, case.assembly, case.joints, case.scene.text, case.scene.title)
    numbers = checkpoint.load(saved)[1]
    with Results.open(file) as results:
        if results.scene != case.scene.text:
            raise InputError(f"{file}: made by another scene; resume with the same scene file and the same --set")
    return ResultWriter.resumed(file, numbers["rows"], numbers["mark"])


def write_damage(results: Results, folder: Path, settings: Report) -> dict[str, Any]:
    """Write joints.csv and return the numbers of damage for the summary, those after each shock of a sequence among them."""
    from reports.damage import joint_damage

    thresholds = joint_damage.Thresholds(opened=settings.opened, slid=settings.slid)
    table = joint_damage.joint_damage(results, thresholds)
    joint_damage.write_joints_csv(table, folder / "joints.csv")
    fallen = joint_damage.collapsed_blocks(results, thresholds)
    return (
        joint_damage.summary(table)
        | {
            "blocks": len(results.blocks),
            "joints": results.joints.count,
            "collapsed_blocks": len(fallen),
            "collapsed_block_names": list(fallen),
            "displacement_max": joint_damage.displacement_max(results),
            "opening_max": float(table.max_opening.max(initial=0.0)),
            "sliding_max": float(table.max_sliding.max(initial=0.0)),
        }
        | ({"shocks": joint_damage.shock_rows(results, thresholds)} if results.shocks else {})
        | joint_damage.bonds(results)
    )


def _summary(case: Case, report: RunReport) -> dict[str, Any]:
    """What the run itself yields for summary.json."""
    settings = case.scene.run
    energy = {("kinetic_end" if name == "kinetic" else name): value for name, value in report.energy.items()}
    return {
        "title": case.scene.title,
        "version": __version__,
        "stopped": report.stopped,
        "signal": report.signal,
        "steps": report.steps,
        "steps_asked": settings.steps,
        "dt": settings.dt,
        "wall_seconds": 0.0,
        "stepping_seconds": report.stepping_seconds,
        "contacts_mean": report.contacts_mean,
        "contacts_max": report.contacts_max,
        "planar": report.planar,
        "solver": {
            "name": settings.solver,
            "threads": min(settings.threads, cores()),
            "tolerance": settings.tolerance,
            "seed": settings.seed,
            "iterations_mean": report.iterations_mean,
            "iterations_max": report.iterations_max,
            "error_max": report.error_max,
            "error_mean": report.error_mean,
            "steps_missed": report.steps_missed,
            "reasons": report.solver_reasons,
        },
        "islands": {"mean": report.islands_mean, "max": report.islands_max, "sleeping_mean": report.sleeping_mean},
        "left_out": {"steps_without_iterations": report.steps_as_before} | report.left_out,
        "penetration_max": report.penetration_max,
        "penetration_where": report.penetration_where,
        "closing": {"steps": report.steps_closing, "speed_max": report.closing_max, "jam": report.jam},
        "energy": energy | {"balance_error": report.balance_error, "lift_share": report.lift_share},
        "loads": case.loading.summary,
    }


def write_json(summary: dict[str, Any], path: Path) -> None:
    """Write a summary; what is not finite becomes null, since JSON knows no NaN."""

    def plain(value: Any) -> Any:
        if isinstance(value, dict):
            return {str(key): plain(item) for key, item in value.items()}
        if isinstance(value, (list, tuple, np.ndarray)):
            return [plain(item) for item in value]
        if isinstance(value, np.generic):
            value = value.item()
        return None if isinstance(value, float) and not math.isfinite(value) else value

    with replacing(path) as part:
        part.write_text(json.dumps(plain(summary), indent=2) + "\n", encoding="utf-8")


def closing_lines(summary: dict[str, Any]) -> list[str]:
    """What happened, in words."""
    s, solver, energy = summary, summary["solver"], summary["energy"]
    per_step = s["stepping_seconds"] / max(1, s["steps"])
    lifted = energy.get("lift_share", 0.0)
    lift = f"; taking overlaps away lifted blocks by {100 * lifted:.2g} % of it besides" if lifted >= TOLD else ""
    deep = f", of {s['penetration_where']}" if s.get("penetration_where") else ""
    bonds = [f"bonds: {s['joints_broken']} of {s['joints_bonded']} bonded joints broke"] if s.get("joints_bonded") else []
    return [
        f"{s['title']}: {s['steps']} steps of {length(s['dt'], 's')} in {in_words(s['stepping_seconds'])}, "
        f"{length(per_step, 's')} per step; {in_words(s['wall_seconds'])} in all",
        *outcome_lines(s),
        damage_line(s),
        *_part_lines(s),
        *bonds,
        f"contacts: {s['contacts_mean']:.0f} on average, {s['contacts_max']} at most{', solved in their plane' if s['planar'] else ''}; "
        f"largest penetration {length(s['penetration_max'])}{deep}",
        f"solver {solver['name']}: {solver['iterations_mean']:.0f} iterations on average, {solver['iterations_max']} at most; "
        f"error {solver['error_mean']:.1e} on average, {solver['error_max']:.1e} at most",
        f"energy: balance closed to {energy['balance_error']:.1e} of the largest work done{lift}",
    ]


def damage_line(s: dict[str, Any]) -> str:
    """The damage in one line."""
    fallen = f"{s['collapsed_blocks'] or 'none'} of {s['blocks']} blocks fell"
    moved = f"largest displacement relative to the base {length(s['displacement_max'])}"
    return f"joints: {s['joints']}, of which {joints_in_words(s)}; {fallen}; {moved}"


def _part_lines(s: dict[str, Any]) -> list[str]:
    """The damage part by part, where the scene asks for it."""
    if "parts" not in s:
        return []
    from reports.damage.part_files import part_lines

    return part_lines(s["parts"])


def _warnings(summary: dict[str, Any]) -> list[str]:
    """Steps that missed their tolerance, and a run that ended early."""
    solver, lines = summary["solver"], []
    if solver["steps_missed"]:
        lines.append(
            f"{solver['steps_missed']} of {summary['steps']} steps missed the tolerance {solver['tolerance']:g}; "
            f"the largest error is {solver['error_max']:.1e} (each step's: solver/error in result.h5)"
        )
    closing = summary["closing"]
    if closing["steps"]:
        left = f"{closing['steps']} of them left contacts closing, at up to {length(closing['speed_max'])}/s, so that overlaps grow"
        why = f": {closing['jam']}; no solution is without penetration, and forces and work of such steps mean nothing"
        lines.append(left + (why if closing["jam"] else ""))
    if summary["stopped"]:
        lines.append(f"the run ended early, {summary['stopped']}; the results hold all frames up to there")
    return lines
