# SPDX-License-Identifier: GPL-3.0-or-later
"""The state from which a limit analysis begins: ``[limit] from`` names a run, whose blocks are taken where it left them.

Their joints are found there, as far as they are open by no more than TOUCHES: a hinge is a strip along its edge, and what overlaps bears.
Without the strip's width a structure that rests on hinges, and still moves on by a micrometre, would have no equilibrium. Bond counts no
more, since what a run broke would be whole again; ties are as strong as before.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_cd.analysis.deformed import Pose, solids_of
from masonry_cd.analysis.limit.analysis import Analysis
from masonry_cd.app.limit_structure import LimitStructure
from masonry_cd.app.static_loads import StaticLoads
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import length
from masonry_cd.io.results import Results
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joint_laws import at_start_only
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.model.polygon import clip_loops, loop_area
from masonry_cd.mechanics.model.state import State, rotation_matrices

KEY = "limit.from"
NO_CURVE = "is followed from the structure as built, not from the state that a run left"
TOUCHES = 1e-5  # [m] a hinge that turned by 0.01 is 1 mm wide by it; the contacts of a run at rest overlap, or part by a thousandth of it
OPEN = 0.25  # share of the smallest width: what is farther open at a corner has no joint there
SAME = 1e-6  # share of the smallest width by which corners of the same block may differ


def left_state(structure: LimitStructure, loads: StaticLoads) -> tuple[LimitStructure, StaticLoads, str]:
    """A structure where the run that its table ``[limit]`` names left it, the loads on it there, and which run, when, and how far blocks
    are from their places, as a line.

    Raises:
        InputError: no such run, one of other blocks or of blocks that deform, a time that it does not have, or joints that crush.
    """
    asked, assembly, joints = structure.asked, structure.assembly, structure.joints
    assert asked.begin is not None
    if reason := at_start_only(assembly.laws):
        raise InputError(KEY, f"{reason}, and a run leaves displaced what it has moved")
    if asked.curve is not None:
        raise InputError("limit.curve", NO_CURVE)
    if loads.kind == "tilt" and len(loads.masses.mass):
        raise InputError(KEY, "masses of point loads are not tilted where a run left them; give limit.push")
    if asked.check is not None and asked.check.checks_displacements:
        raise InputError(
            "limit.check.displacements", "no curve is followed from the state that a run left; false leaves the check by accelerations"
        )
    place = structure.scene.folder / asked.begin
    file = place / "result.h5" if place.is_dir() or not place.suffix else place
    if not file.exists():
        raise InputError(KEY, f"{file}: no such result file; it takes the folder of a run, from that of the scene on")
    with Results.open(file) as results:
        _refuse_others(results, assembly)
        frame = _frame(results, asked.time)
        if not results.present(frame).all():
            raise InputError(KEY, f"{results.path}: events have taken blocks away, and limit analysis includes all blocks of the scene")
        if results.gradient(frame) is not None:
            raise InputError(KEY, f"{results.path}: its blocks deform; limit analysis treats them as rigid")
        pose = Pose.of(results, solids_of(results.blocks), frame)
    placed = assembly.placed(pose.position, pose.rotation)
    placed = replace(placed, laws=placed.laws.unbonded())
    found = touching_joints(placed)
    turned = loads.at().moved(assembly.centre, pose.position, pose.rotation)
    moved = replace(loads, constant=turned.dead - loads.gravity, live=turned.live, bars=turned.bars, arms=turned.arms or loads.arms)
    far = float(np.linalg.norm(pose.position - assembly.centre, axis=1).max())
    words = f"from {asked.begin} at {pose.time:.4g} s: blocks are up to {length(far)} from where they were built, "
    words += f"{100.0 * float(found.area.sum()) / float(joints.area.sum()):.3g} % of the area of their joints touches"
    words += "; bond counts no more" if assembly.laws.apex.any() else ""
    return replace(structure, assembly=placed, joints=found), moved, words


def touching_joints(placed: Assembly) -> Joints:
    """The joints of blocks as placed, each as far as it is open by no more than TOUCHES."""
    state, detector = State.at_rest(placed), Detector(placed, corners_only=True)
    still = np.zeros((placed.count, 6))
    contacts = detector.detect(state.position, rotation_matrices(state.orientation), still, 0.0, OPEN * placed.width, np.zeros(3))
    parts = detector.pairs[contacts.pair]
    starts = np.append(np.flatnonzero((np.diff(parts, axis=0, prepend=-1) != 0).any(axis=1)), len(parts))
    corners, ends, rows = clip_loops(contacts.point, starts, TOUCHES - contacts.gap)
    first = starts[:-1][rows]
    return Joints(
        block_a=contacts.bodies[first, 1].copy(), block_b=contacts.bodies[first, 0].copy(),
        area=np.array([loop_area(loop) if len(loop) > 2 else 0.0 for loop in np.split(corners, ends[1:-1])]),
        normal=contacts.normal[first].copy(), polygon_start=ends, polygon=corners,
    )  # fmt: skip


def _refuse_others(results: Results, assembly: Assembly) -> None:
    """Refuse a run of other blocks.

    Raises:
        InputError: names the first that differs.
    """
    theirs = {block.name: block for block in results.blocks}
    for block in assembly.blocks:
        other = theirs.pop(block.name, None)
        alike = other is not None and other.fixed == block.fixed and other.vertices.shape == block.vertices.shape
        if not alike or np.abs(other.vertices - block.vertices).max() > SAME * assembly.width:  # type: ignore[union-attr]
            raise InputError(
                KEY, f'{results.path}: a run of another structure: block "{block.name}" of this scene is not in it as it is here'
            )
    if theirs:
        raise InputError(KEY, f'{results.path}: a run of another structure: this scene has no block "{next(iter(theirs))}"')


def _frame(results: Results, time: float | None) -> int:
    """The frame nearest to a time, the last of none.

    Raises:
        InputError: a time after the end.
    """
    if time is None:
        return results.frames - 1
    last = float(results.time[-1])
    if time > last * (1.0 + SAME):
        raise InputError("limit.time", f"{time:g} s: {results.path} ends at {last:.4g} s")
    return int(np.argmin(np.abs(results.time - time)))


def against_undamaged(now: Analysis, whole: Analysis) -> str:
    """The line on the load factor as a share of that of the structure as built."""
    if not now.stands:
        return (
            f"as built it bore its dead loads; now it bears {100.0 * max(now.standing, 0.0):.3g} % of them"
            if whole.stands
            else "it does not stand under its dead loads, and did not as built"
        )
    if now.problem.moves_support:
        return "supports that move have no load factor to compare"
    if not whole.stands:
        return f"as built it did not stand under its dead loads; {_factor_words(now)} now"
    if (
        now.is_endless
        or whole.is_endless
        or whole.bears_nothing
        or ((now.unlimited or whole.unlimited) and None in (now.least, whole.least))
    ):
        return f"{_factor_words(now)} against {_factor_words(whole)} as built"
    searched = now.least is not None and whole.least is not None
    factor, before = ((each.governing if searched else each.associated).factor for each in (now, whole))
    rule = "" if searched or not (now.starts or whole.starts) else ", both associated: a search did not converge"
    return f"load factor {factor:.4g} against {before:.4g} as built, {100.0 * factor / before:.3g} %{rule}"


def _factor_words(analysis: Analysis) -> str:
    """The load factor of a structure that stands, as a phrase."""
    if analysis.is_endless:
        return "no finite load factor"
    return (
        "no load factor: any amount of the load starts the motion"
        if analysis.bears_nothing
        else f"load factor {analysis.governing.factor:.4g}"
    )
