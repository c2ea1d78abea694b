# SPDX-License-Identifier: GPL-3.0-or-later
"""The lines that a run prints: its announcement, its closing lines, its warnings."""

from __future__ import annotations

from collections.abc import Sequence

from masonry_cd.analysis.damage.grades import NAMES
from masonry_cd.analysis.damage.verdict import FALSE_SHARE, bed_words, beyond_their_law, not_acted
from masonry_cd.analysis.modal.left_out import left_out_lines
from masonry_cd.analysis.pushover import push_line
from masonry_cd.analysis.stress.summary import stress_lines
from masonry_cd.analysis.verdict import NOT_GRADED, Verdict
from masonry_cd.foundation.quantities import counted, force, in_words, length, per_cent
from masonry_cd.io.summary import Summary
from masonry_cd.io.summary_tables import Energy, JointCounts, LimitBracket, LoadFactor, PartInShort, ShockDamage, Solver, TieTension
from masonry_cd.mechanics.dynamics.settings import Run

REPORTED = 1e-3  # share of the largest work from which on the closing lines report what the correction of overlaps put in
NOT_THE_LEAST = (
    "rigid joints that slide allow several load factors: this run found one, not the least, and another run.solver or run.seed may find "
    "another; masonry-cd limit SCENE gives the bracket"
)


def announced(settings: Run) -> str:
    """The steps that a run is about to make."""
    if settings.is_adaptive:
        return f"{settings.steps * settings.dt:g} s in steps of {length(settings.dt, 's')} to {length(settings.longest_step, 's')}"
    return f"{settings.steps} steps of {settings.dt:g} s"


def closing_lines(s: Summary) -> list[str]:
    """The closing lines of a run."""
    solver = s.solver
    deep = f", of {s.penetration_where}" if s.penetration_where else ""
    on = f" on {solver.threads} threads" if solver.threads > 1 else ""
    return [
        f"{s.title}: {_steps(s)} in {in_words(s.stepping_seconds)}, "
        f"{length(s.stepping_seconds / max(1, s.steps), 's')} per step; {in_words(s.wall_seconds)} in all",
        *verdict_lines(s),
        *_time_step_lines(s),
        *map(_shock_line, s.shocks),
        *(f"{one.name} came at {one.time:g} s: {one.change}" for one in s.events if one.time is not None),
        *([] if s.load_factor is None else factor_lines(s.load_factor)),
        *map(_tie_line, s.ties),
        *map(push_line, s.pushes),
        damage_line(s),
        *_end_lines(s),
        *_acted_lines(s),
        *(part_lines(s.parts) if s.parts else []),
        *([f"bonds: {s.joints_broken} of {s.joints_bonded} bonded joints broke"] if s.joints_bonded else []),
        *([f"stones: {s.cracked_stones} of {s.stones} cracked"] if s.stones else []),
        *crushed_lines(s),
        *([] if s.stress is None else stress_lines(s.stress)),
        f"contacts: {s.contacts_mean:.0f} on average, {s.contacts_max} at most{', solved in their plane' if s.planar else ''}; "
        f"largest penetration {length(s.penetration_max)}{deep}",
        *([f"elastic joints: {bed_words(s.beds)}"] if s.beds is not None and s.beds.unresolved else []),
        *beyond_their_law(s),
        f"solver {solver.name}{on}: {solver.iterations_mean:.0f} iterations on average, {solver.iterations_max} at most; "
        f"error {solver.error_mean:.1e} on average, {solver.error_max:.1e} at most",
        *_violation_lines(solver),
        f"energy: balance closed to {_balance(s.energy)}",
        *left_out_lines(s),
    ]


def _steps(s: Summary) -> str:
    """The steps of a run and their length."""
    found = s.time_step
    if found is None:
        return f"{s.steps} steps of {length(s.dt or 0.0, 's')}"
    return f"{s.steps} steps of {length(found.shortest, 's')} to {length(found.longest, 's')} (median {length(found.median, 's')})"


def verdict_lines(s: Summary) -> list[str]:
    """The verdict on the run, before anything that it found; nothing of a summary of an older version."""
    found = s.verdict
    if found is None or not found.has("words"):
        return []
    return [Verdict(found.grade, found.means, found.because, found.sure, found.words, found.why).line]


def _time_step_lines(s: Summary) -> list[str]:
    """How the lengths of the steps were found, where they adapt."""
    found = s.time_step
    if found is None:
        return []
    return [
        f"time steps: local error {length(found.local_error_max)} at most, {length(found.tolerance)} aimed at; "
        f"{found.repeated_for_error or 'none'} repeated for it, {found.repeated_for_solver or 'none'} for the solver; "
        f"{found.steps_wanted_shorter or 'none'} at the shortest, {length(found.dt_min, 's')}, that should have been shorter; "
        f"supports off their motion by {length(found.base_drift_max)} at most"
    ]


def _shock_line(shock: ShockDamage) -> str:
    when = f"{shock.start:.4g} to {shock.end:.4g} s, rest to {shock.rest_end:.4g} s"
    return f'after "{shock.name}" ({when}): joints: {_joints(shock)}; {shock.collapsed_blocks or "no"} blocks fell'


def _joints(damage: JointCounts) -> str:
    """How many joints opened, slid and came apart, and how far; older versions counted those that did both with the others."""
    apart = damage.has("joints_only_opened")
    opened, slid = (damage.joints_only_opened, damage.joints_only_slid) if apart else (damage.joints_opened, damage.joints_slid)
    return (
        f"{opened} opened (at most {length(damage.opening_max)}), {slid} slid (at most {length(damage.sliding_max)}), "
        f"{damage.joints_opened_and_slid} opened and slid, {damage.joints_separated} separated"
    )


def factor_lines(found: LoadFactor) -> list[str]:
    """The load factor of a run, and what limit analysis says of it."""
    bracket = found.limit_analysis
    several = [NOT_THE_LEAST] if found.rigid and not (bracket is not None and bracket.one) else []
    return [_factor_line(found), *several, *([] if bracket is None else [_bracket_line(bracket)])]


def _factor_line(found: LoadFactor) -> str:
    if found.given_way is None:
        return f"load factor: {found.end:.4g} at the end, and the structure had not given way"
    if found.given_way_displacement is None:
        moved = f"a block had moved by more than {1e3 * found.limit:.3g} mm"
        return f"load factor: {found.given_way:.4g} when {moved}, at {found.given_way_time:.4g} s; {found.end:.4g} at the end"
    place = f"at {found.given_way_time:.4g} s, a block {length(found.given_way_displacement)} from its place"
    return f"load factor: {found.given_way:.4g} is the largest that was carried, {place}; {found.end:.4g} at the end"


def _bracket_line(bracket: LimitBracket) -> str:
    least, upper = bracket.least_found, bracket.associated
    if least is None:
        return f"limit analysis: {upper:.4g} at most (associated); no start of the search for the least factor converged"
    if upper is None:
        wedged = "the blocks are wedged, and what friction on their faces bears beyond that is the solver's choice"
        return f"limit analysis: {least:.4g}, the least found without dilation, and none with it that is finite: {wedged}"
    if bracket.one:
        return f"limit analysis: {upper:.4g}; dilation of sliding joints makes no difference here"
    return f"limit analysis: {least:.4g}, the least found without dilation, to {upper:.4g} (associated)"


def _tie_line(tie: TieTension) -> str:
    most = f"{force(tie.tension_max)} ({tie.stress_max / 1e6:.3g} MPa) at {tie.tension_max_time:.3g} s"
    first, second = tie.blocks
    named = f'tie "{first}" to "{second}"' if tie.name == f"{first} to {second}" else f'tie "{tie.name}" ("{first}" to "{second}")'
    yields = f", yielded from {tie.yield_time:.3g} s on" if tie.yielded else ""
    return f"{named}: at most {most}{yields}, {force(tie.tension_end)} at the end"


def damage_line(s: Summary) -> str:
    """The damage in one line."""
    fallen = f"{s.collapsed_blocks or 'none'} of {s.blocks} blocks fell"
    return f"joints: {s.joints}, of which {_joints(s)}; {fallen}; largest displacement relative to the base {length(s.displacement_max)}"


def _end_lines(s: Summary) -> list[str]:
    """How long the run went on beyond its duration, and whether what is left is final."""
    lines = []
    if s.end is not None and s.duration is not None and s.end.time - s.duration > 0.5 * (s.dt or 0.0) and not s.shocks:
        until = f"still moving when run.longest, {s.longest:g} s, was over" if s.provisional else "until all blocks were still"
        loose = f"; {s.end.rattles} rattles in its place" if s.end.rattles else ""
        lines.append(f"rest: {s.end.time - s.duration:.4g} s more than run.duration, {until}{loose}")
    return [*lines, *([f"what is left at the end is {s.provisional}"] if s.provisional else [])]


def _acted_lines(s: Summary) -> list[str]:
    """How much of each load has acted; nothing of a run whose loads all act from the start."""
    acted = [f"{one.load} {per_cent(one.share)} of its {one.measure}" for one in s.loads.acted or ()]
    return [f"loads that acted: {', '.join(acted)}"] if acted else []


def part_lines(parts: Sequence[PartInShort]) -> list[str]:
    """The grade and mechanism of each part in a line, for the terminal; the structure first, then the gravest, the undamaged counted."""
    whole, rows = parts[-1], sorted(parts[:-1], key=lambda row: row.grade, reverse=True)
    damaged, sound = [row for row in rows if not _is_sound(row)], [row for row in rows if _is_sound(row)]
    graded = whole.grade != NOT_GRADED
    wide = len("grade") if graded else len(NOT_GRADED)
    lines = [] if graded else [f"{NOT_GRADED}: {whole.grade_reason}"]
    head = f"{'part':<20} {'grade':<{wide}} {'mechanism':<24} {'opened':>6} {'slid':>6} {'both':>6} {'lost':>6}"
    lines.append(head + ("  graded by what is left" if graded else ""))
    for row in [whole, *damaged]:
        reason = (row.grade_reason or row.grade_label) if graded else ""
        lines.append(
            f"{row.part:<20} {row.grade:<{wide}} {row.mechanism:<24} {row.only_opened:>6} {row.only_slid:>6} "
            f"{row.opened_and_slid:>6} {row.lost_blocks:>6}  {reason}".rstrip()
        )
    if sound:
        label = f"{NAMES[0]}, {sound[0].grade_label}" if graded else "no joint opened or slid"
        lines.append(f"{len(sound)} of {len(rows)} parts: {label}")
    return [*lines, *([f"grades, mechanisms and residual values are {whole.provisional}"] if whole.provisional else [])]


def _is_sound(row: PartInShort) -> bool:
    """True for a part that is undamaged: by its grade, or where it has none by what is left."""
    if row.grade != NOT_GRADED:
        return row.grade == NAMES[0]
    return not (row.only_opened or row.only_slid or row.opened_and_slid or row.separated or row.lost_blocks)


def crushed_lines(s: Summary) -> list[str]:
    """How many joints crushed, and by how much at most; nothing where none did."""
    where = f", {s.crushed_where}" if s.crushed_where else ""
    most = f"by {length(s.crushed_max)} at the most{where}"
    return [f"crushing: {counted(s.joints_crushed, 'joint')}, {most}"] if s.joints_crushed else []


def _violation_lines(solver: Solver) -> list[str]:
    """A line on the error of the solver in m/s and in mm; none of older runs."""
    speed, slip, opening = solver.violation_max, solver.false_slip_max, solver.false_opening_max
    if speed is None or slip is None or opening is None:
        return []
    left = f"{length(slip)} of slip and {length(opening)} of opening"
    return [f"contact laws: violated by {length(speed)}/s at most, which adds up to {left} at the worst contacts"]


def _balance(energy: Energy) -> str:
    """How the balance closed: as a share of the largest work, in joules where there was none to speak of; and what lifted blocks."""
    if energy.at_rest:
        return f"{energy.balance_max:.1e} J; no work was done beyond what the tolerance of the steps leaves"
    lift = f"; taking overlaps away lifted blocks by {100 * energy.lift_share:.2g} % of it as well" if energy.lift_share >= REPORTED else ""
    return f"{energy.balance_error:.1e} of the largest work done{lift}"


def run_warnings(s: Summary) -> list[str]:
    """Steps that missed their tolerance, and a run that ended early."""
    solver, closing, lines = s.solver, s.closing, []
    if solver.steps_missed:
        beyond = solver.steps_missed - solver.steps_accepted
        lines.append(
            f"{solver.steps_missed} of {s.steps} steps missed the tolerance {solver.tolerance:g}, "
            f"{beyond or 'none'} of them by more than is accepted ({solver.accept:g}); "
            f"the largest error is {solver.error_max:.1e} (each step's: solver/error in result.h5)"
        )
    lines += [f"{short} when the run ends: a longer run.duration or an earlier start has it act" for short in not_acted(s)]
    lines += [f"{one.name} has not come ({one.cause}): {one.change}" for one in s.events if one.time is None]
    lines += _false_motion(solver, s.displacement_max)
    if closing.steps:
        left = f"{closing.steps} of them left contacts closing, at up to {length(closing.speed_max)}/s, so that overlaps grow"
        why = f": {closing.jam}; no solution is without penetration, and forces and work of such steps mean nothing"
        lines.append(left + (why if closing.jam else ""))
    if s.stopped:
        lines.append(f"the run ended early, {s.stopped}; the results hold all frames up to there")
    return lines


def _false_motion(solver: Solver, moved: float) -> list[str]:
    """That violations of the contact laws are no longer small compared with the motion, where they are not."""
    slip, opening = solver.false_slip_max or 0.0, solver.false_opening_max or 0.0
    if not (solver.false_slip_where and max(slip, opening) > FALSE_SHARE[0] * moved):
        return []
    share = f"{100.0 * max(slip, opening) / moved:.2g} % of the largest displacement" if moved else "the blocks do not move"
    return [
        f"violations of the contact laws have added up to {length(slip)} of slip that friction should have held "
        f"({solver.false_slip_where}) and {length(opening)} of opening: {share}; a smaller run.tolerance makes them less"
    ]
