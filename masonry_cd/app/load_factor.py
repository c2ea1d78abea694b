# SPDX-License-Identifier: GPL-3.0-or-later
"""The fate of a structure under growing loads: the load factor at which it gave way, the tensions of its ties.

A push or a tilt grows until the structure gives way: a block has moved, relative to the base, by more than MOVED of the smallest width of a
block, and the structure carries less than the load applied (:mod:`masonry_cd.app.carried`). Its factor is the largest that it carried.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.analysis.ties import histories
from masonry_cd.app.carried import largest_carried
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.io.summary_tables import LimitBracket, LoadFactor
from masonry_cd.io.tie_bars import TieBar

if TYPE_CHECKING:
    from masonry_cd.app.case import Case

MOVED = 0.01
FEW = 100  # blocks up to which a run in a plane is judged by limit analysis as well
FEW_POINTS = 800  # contact points up to which one in space is: three seconds for a corner of 73 blocks
STARTS = 3  # of its search for the least factor


def outcome(case: Case, results: Results) -> Summary:
    """For the summary; a scene without such loads gets none of it."""
    found, ties = _load_factor(case, results), tuple(tie.row() for tie in histories(results))
    return (Summary() if found is None else Summary(load_factor=found)) | (Summary(ties=ties) if ties else Summary())


def _load_factor(case: Case, results: Results) -> LoadFactor | None:
    """lambda at the end, and when the structure gave way; None without a load that grows."""
    gravity, free = np.array(case.scene.run.gravity), ~case.assembly.fixed
    load_step = results.per_step("load_step").astype(np.int64)
    if not gravity.any() or not len(load_step) or not set(_patterns(case)) & {"push", "tilt"}:  # no pulse, no push by displacement
        return None
    factor = case.loading.load_factor(case.scene.run.gravity)[load_step]  # after each step
    if not factor.any():
        return None
    limit = MOVED * float(case.assembly.shapes.size[free[case.assembly.shapes.part_block]].min())
    rigid = not case.assembly.laws.by_area.any()
    given_way = {"given_way": None, "given_way_time": None} | _given_way(case, results, factor, limit)
    bracket = limit_bracket(case) if rigid else None
    found: dict[str, Any] = given_way if bracket is None else given_way | {"limit_analysis": bracket}
    return LoadFactor(end=float(factor[-1]), limit=limit, rigid=rigid, **found)


def _patterns(case: Case) -> list[str]:
    """Name the loads that limit analysis would multiply; a push and a tilt grow until the structure gives way."""
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


def limit_bracket(case: Case) -> LimitBracket | None:
    """The least factor found, None where no start comes to an end, and the associated one, None where it is not finite, by limit analysis,
    where that takes seconds: of few blocks, under one push or tilt that limit analysis takes as it is; None elsewhere."""
    from masonry_cd.analysis.limit.analysis import LimitOptions, analyse
    from masonry_cd.analysis.limit.interfaces import interfaces
    from masonry_cd.analysis.limit.problem import plane_of
    from masonry_cd.app.limit_table import limit_table
    from masonry_cd.app.static_loads import static_loads

    scene, assembly, forces = case.scene, case.assembly, case.loading.forces
    filled = any(block.carried is not None for block in assembly.blocks)  # what fill presses and resists with is not among these loads
    if assembly.count > FEW or filled or assembly.links or assembly.footings is not None or not assembly.fixed.any():
        return None
    if _patterns(case) not in (["push"], ["tilt"]):
        return None
    loads = static_loads(scene.loads, limit_table({}), scene.run.gravity, scene.folder, assembly)
    if forces is not None and len(forces.ties) != len(loads.bars.strength):  # those of the structure are not among them
        return None
    if plane_of(assembly, loads.at()) is None and interfaces(assembly, case.joints, None).count > FEW_POINTS:
        return None
    if loads.kind == "tilt" and not (loads.has_only_gravity and not assembly.laws.apex.any()):
        return None
    try:
        found = analyse(assembly, case.joints, loads.at(), LimitOptions(starts=STARTS, seed=scene.run.seed))
    except InputError:  # the run stands for itself: it needs no factor of limit analysis
        return None
    if not found.stands or found.is_endless:
        return None
    least, upper = found.least, None if found.unlimited else found.associated.factor
    return LimitBracket(least_found=None if least is None else least.optimum.factor, associated=upper)


def tie_bars(case: Case) -> list[TieBar]:
    """The bars of a case's ties, for its results."""
    forces, centre = case.loading.forces, case.assembly.centre
    ties = () if forces is None else forces.ties
    return [TieBar(tie.name, tie.blocks, centre[list(tie.blocks)] + tie.arms, tie.section, tie.limit) for tie in ties]
