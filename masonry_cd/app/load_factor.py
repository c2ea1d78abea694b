# SPDX-License-Identifier: GPL-3.0-or-later
"""What became of a structure under its loads: the load factor at which it gave way, the tensions of its ties, the damage shock by shock.

A push or a tilt grows until the structure gives way: a block has moved, relative to the base, by more than MOVED of the smallest width of a
block, and the structure carries less than the load applied (:mod:`masonry_cd.app.carried`). Its factor is the largest that it carried.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.analysis.limit.outcome import one_factor
from masonry_cd.app.carried import largest_carried
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import force, length
from masonry_cd.io.results import Results
from masonry_cd.io.tie_bars import TieBar

if TYPE_CHECKING:
    from masonry_cd.app.case import Case

MOVED = 0.01
FEW = 100  # blocks up to which a run in a plane is judged by limit analysis as well
FEW_POINTS = 800  # contact points up to which one in space is: three seconds for a corner of 73 blocks
STARTS = 3  # of its search for the least factor
NOT_THE_LEAST = (
    "rigid joints that slide allow several load factors: this run found one, not the least, and another run.solver or run.seed may find "
    "another; masonry-cd limit SCENE gives the bracket"
)


def outcome(case: Case, results: Results) -> dict[str, Any]:
    """For the summary; a scene without such loads gets none of it."""
    return _load_factor(case, results) | _ties(results)


def _load_factor(case: Case, results: Results) -> dict[str, Any]:
    """lambda at the end, and when the structure gave way."""
    gravity, free = np.array(case.scene.run.gravity), ~case.assembly.fixed
    load_step = results.per_step("load_step").astype(np.int64)
    if not gravity.any() or not len(load_step) or not set(_patterns(case)) & {"push", "tilt"}:  # no pulse, no push by displacement
        return {}
    factor = case.loading.load_factor(case.scene.run.gravity)[load_step]  # after each step
    if not factor.any():
        return {}
    limit = MOVED * float(case.assembly.shapes.size[free[case.assembly.shapes.part_block]].min())
    rigid = not case.assembly.laws.by_area.any()
    found: dict[str, Any] = {"end": float(factor[-1]), "limit": limit, "given_way": None, "given_way_time": None, "rigid": rigid}
    found |= _given_way(case, results, factor, limit)
    bracket = limit_bracket(case) if rigid else None
    return {"load_factor": found | ({} if bracket is None else {"limit_analysis": bracket})}


def _patterns(case: Case) -> list[str]:
    """What limit analysis would multiply of the loads; a push and a tilt grow until the structure gives way."""
    from loads.static import patterns

    return [pattern for pattern in patterns(case.scene.loads, case.scene.folder) if pattern not in ("", "live")]


def _given_way(case: Case, results: Results, factor: np.ndarray, limit: float) -> dict[str, float]:
    """Factor, time and displacement at which the structure gave way, of factors (N,) after each step."""
    moved, moment = _gone(results, np.where(case.assembly.fixed, 0.0, case.assembly.mass))
    if results.per_step("energy/base_work").any():  # on a base that shakes, the load a block carries cannot be separated from the shaking
        beyond = np.flatnonzero(moved > limit)
        if not len(beyond):
            return {}
        time = float(results.time[beyond[0]])
        return {"given_way": float(factor[np.searchsorted(results.per_step("step_time"), time)]), "given_way_time": time}
    ends = np.minimum(np.searchsorted(results.per_step("step_time"), results.time), len(factor) - 1)  # steps that end with the frames
    pull = case.loading.acceleration[results.per_step("load_step").astype(np.int64)][ends]
    kinetic = np.where(results.time > 0.0, results.per_step("energy/kinetic")[ends], 0.0)
    carried = largest_carried(moved, _work_of_one(case, pull, moment), factor[ends], kinetic, limit)
    if carried is None:
        return {}
    at = carried.frame
    return {"given_way": carried.factor, "given_way_time": float(results.time[at]), "given_way_displacement": float(moved[at])}


def _gone(results: Results, mass: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Since the first frame, in which the joints have settled, and relative to the base: how far a block has gone at most (F,) [m], and the
    sum of masses (B,) times displacements (F, 3) [kg m]."""
    base, first = results.support, np.asarray(results.position[0], dtype=float)
    farthest, moment = np.zeros(results.frames), np.zeros((results.frames, 3))
    for frame in range(results.frames):
        gone = results.position[frame] - first
        gone = gone - gone[base] if base >= 0 else gone
        farthest[frame], moment[frame] = np.linalg.norm(gone, axis=1).max(), mass @ gone
    return farthest, moment


def _work_of_one(case: Case, pull: np.ndarray, moment: np.ndarray) -> np.ndarray:
    """(F,) work of the load for a factor of one [J], of accelerations (F, 3) and masses times displacements (F, 3)."""
    gravity = np.array(case.scene.run.gravity)
    down = gravity / np.linalg.norm(gravity)
    across = pull - np.outer(pull @ down, down)
    across /= np.maximum(np.linalg.norm(across, axis=1), 1e-300)[:, None]
    push = across * (pull @ down)[:, None]  # on a kilogram
    return np.concatenate([[0.0], np.cumsum(np.sum(0.5 * (push[1:] + push[:-1]) * np.diff(moment, axis=0), axis=1))])


def limit_bracket(case: Case) -> dict[str, float | None] | None:
    """The least factor found, None where no start comes to an end, and the associated one, None where it is not finite, by limit analysis,
    where that takes seconds: of few blocks, under one push or tilt that limit analysis takes as it is; None elsewhere."""
    from masonry_cd.analysis.limit.analysis import Options, analyse
    from masonry_cd.analysis.limit.interfaces import interfaces
    from masonry_cd.analysis.limit.problem import plane_of
    from masonry_cd.app.limit_table import limit_table
    from masonry_cd.app.static_loads import static_loads

    scene, assembly, forces = case.scene, case.assembly, case.loading.forces
    filled = any(block.carried is not None for block in assembly.blocks)  # what fill presses and resists with is not among these loads
    if assembly.count > FEW or filled or not assembly.fixed.any():
        return None
    if _patterns(case) not in (["push"], ["tilt"]):
        return None
    loads = static_loads(scene.loads, limit_table({}), scene.run.gravity, scene.folder, assembly)
    if forces is not None and len(forces.ties) != len(loads.bars.strength):  # those of the structure are not among them
        return None
    if plane_of(assembly, loads.at()) is None and interfaces(assembly, case.joints, None).count > FEW_POINTS:
        return None
    if loads.kind == "tilt" and not (loads.only_gravity and not assembly.laws.apex.any()):
        return None
    try:
        found = analyse(assembly, case.joints, loads.at(), Options(starts=STARTS, seed=scene.run.seed))
    except InputError:  # the run stands for itself: it needs no factor of limit analysis
        return None
    if not found.stands or found.endless:
        return None
    least, upper = found.least, None if found.unlimited else found.associated.factor
    return {"least_found": None if least is None else least.optimum.factor, "associated": upper}


def tie_bars(case: Case) -> list[TieBar]:
    """The bars of a case's ties, for its results."""
    forces, centre = case.loading.forces, case.assembly.centre
    ties = () if forces is None else forces.ties
    return [TieBar(tie.name, tie.blocks, centre[list(tie.blocks)] + tie.arms, tie.section, tie.limit) for tie in ties]


def _ties(results: Results) -> dict[str, Any]:
    """What each tie had to bear."""
    from masonry_cd.analysis.ties import histories

    found = [tie.row() for tie in histories(results)]
    return {"ties": found} if found else {}


def outcome_lines(summary: dict[str, Any]) -> list[str]:
    """Load factor, shocks and ties of a summary in words, one line each."""
    lines = [_shock_line(shock) for shock in summary.get("shocks", ())]
    if "load_factor" in summary:
        factor, only = summary["load_factor"], one_factor(summary["load_factor"].get("limit_analysis"))
        lines += [_factor_line(factor), *([NOT_THE_LEAST] if factor.get("rigid") and not only else []), *_bracket_line(factor)]
    return lines + [_tie_line(tie) for tie in summary.get("ties", ())]


def _shock_line(shock: dict[str, Any]) -> str:
    when = f"{shock['start']:.4g} to {shock['end']:.4g} s, rest to {shock['rest_end']:.4g} s"
    return f'after "{shock["name"]}" ({when}): joints: {joints_in_words(shock)}; {shock["collapsed_blocks"] or "no"} blocks fell'


def joints_in_words(damage: dict[str, Any]) -> str:
    """How many joints opened, slid and came apart, and how far."""
    opened, slid = (damage.get(f"joints_only_{word}", damage[f"joints_{word}"]) for word in ("opened", "slid"))
    return (
        f"{opened} opened (at most {length(damage['opening_max'])}), {slid} slid (at most {length(damage['sliding_max'])}), "
        f"{damage.get('joints_opened_and_slid', 0)} opened and slid, {damage['joints_separated']} separated"
    )


def _factor_line(factor: dict[str, Any]) -> str:
    if factor["given_way"] is None:
        return f"load factor: {factor['end']:.4g} at the end, and the structure had not given way"
    if "given_way_displacement" not in factor:
        moved = f"a block had moved by more than {1e3 * factor['limit']:.3g} mm"
        return f"load factor: {factor['given_way']:.4g} when {moved}, at {factor['given_way_time']:.4g} s; {factor['end']:.4g} at the end"
    place = f"at {factor['given_way_time']:.4g} s, a block {length(factor['given_way_displacement'])} from its place"
    return f"load factor: {factor['given_way']:.4g} is the largest that was carried, {place}; {factor['end']:.4g} at the end"


def _bracket_line(factor: dict[str, Any]) -> list[str]:
    """What limit analysis says beside a run, where it was asked."""
    bracket = factor.get("limit_analysis")
    if not bracket:
        return []
    least, upper = bracket["least_found"], bracket["associated"]
    if least is None:
        return [f"limit analysis: {upper:.4g} at most (associated); no start of the search for the least factor came to an end"]
    if upper is None:
        wedged = "the blocks are wedged, and what friction on their faces bears beyond that is the solver's choice"
        return [f"limit analysis: {least:.4g}, the least found without dilation, and none with it that is finite: {wedged}"]
    if one_factor(bracket):
        return [f"limit analysis: {upper:.4g}; how joints slide makes no difference here"]
    return [f"limit analysis: {least:.4g}, the least found without dilation, to {upper:.4g} (associated)"]


def _tie_line(tie: dict[str, Any]) -> str:
    most = f"{force(tie['tension_max'])} ({tie['stress_max'] / 1e6:.3g} MPa) at {tie['tension_max_time']:.3g} s"
    first, second = tie["blocks"]
    named = f'tie "{first}" to "{second}"' if tie["name"] == f"{first} to {second}" else f'tie "{tie["name"]}" ("{first}" to "{second}")'
    yields = f", yielded from {tie['yield_time']:.3g} s on" if tie["yielded"] else ""
    return f"{named}: at most {most}{yields}, {force(tie['tension_end'])} at the end"
