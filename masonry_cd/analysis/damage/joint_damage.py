# SPDX-License-Identifier: GPL-3.0-or-later
r"""Joint damage: what each joint suffered over the run and what is left of it at the end.

The measures are those of :mod:`masonry_cd.mechanics.model.joints`: opening (the widest corner gap), sliding (of the corners that touch),
relative rotation, contact area. ``max_*`` is the largest value over all time steps, ``residual_*`` that of the last frame. The time of the
first opening is that of a step where the threshold is the run's own (0.1 mm), else that of a frame.

What the words of its states mean, and where damage begins, say :mod:`masonry_cd.analysis.damage.definitions`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_cd.analysis.damage.definitions import STATES, Thresholds, classify, fallen_in, is_open, is_slid, parted
from masonry_cd.analysis.damage.stones import has_stones, stone_of_joints
from masonry_cd.analysis.deformed import Pose, base_at, joint_frame, smallest_gap, solids_of
from masonry_cd.foundation.quantities import counted
from masonry_cd.io.layout import BONDED, CRUSHED, LAW_HISTORIES
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.io.summary_tables import JointCounts, ShockDamage
from masonry_cd.mechanics.model.joints import OPENED as OPENING_IN_RUN

BROKEN = 0.98  # a joint is broken when less than this share of what was bonded is left; a corner holds 4 % or more


@dataclass(frozen=True, eq=False)
class JointDamage:
    """Damage of J joints, one row each, in the order of the result file."""

    joint: np.ndarray  # (J,) number of the joint, from zero
    block_a: np.ndarray  # (J,) names
    block_b: np.ndarray  # (J,) names
    area: np.ndarray  # (J,) [m2] at rest
    max_opening: np.ndarray  # (J,) [m]
    residual_opening: np.ndarray  # (J,) [m]
    max_sliding: np.ndarray  # (J,) [m]
    residual_sliding: np.ndarray  # (J,) [m]
    max_rotation: np.ndarray  # (J,) [rad]
    contact_area_loss: np.ndarray  # (J,) largest over the run, as a share of the area
    first_opening_time: np.ndarray  # (J,) [s], NaN where the joint never opened
    state: np.ndarray  # (J,) one of STATES
    both: np.ndarray  # (J,) opened and slid, and not separated
    of_laws: dict[str, np.ndarray]  # (J,) what the run has recorded of the laws of joints, by name, at the end; and whose stone it cracks


def joint_damage(results: Results, thresholds: Thresholds | None = None, shock: int | None = None) -> JointDamage:
    """The damage of all joints at the end of a run, or after the rest that followed a shock of a sequence.

    A run that was killed before it wrote its peaks is judged by its frames.
    """
    thresholds = thresholds or Thresholds()
    joints = results.joints
    names = np.array([block.name for block in results.blocks], dtype=object)
    frame = -1 if shock is None else results.shocks[shock].frame
    peaks = _peaks(results, thresholds, shock)
    opening, sliding = (joint_frame(results, name, frame) for name in ("opening", "sliding"))
    # a peak is over the steps and a residual over the frames: never let the one fall below the other
    largest_opening, largest_sliding = np.maximum(peaks["opening"], opening), np.maximum(peaks["sliding"], sliding)
    separated = separated_joints(results, frame, thresholds)
    codes = classify(largest_opening, largest_sliding, separated, thresholds)
    return JointDamage(
        joint=np.arange(joints.count),
        block_a=names[joints.block_a],
        block_b=names[joints.block_b],
        area=joints.area,
        max_opening=largest_opening,
        residual_opening=opening,
        max_sliding=largest_sliding,
        residual_sliding=sliding,
        max_rotation=peaks["rotation"],
        contact_area_loss=peaks["contact_area_loss"],
        first_opening_time=peaks["first_opening_time"],
        state=np.array(STATES, dtype=object)[codes],
        both=is_open(largest_opening, thresholds) & is_slid(largest_sliding, thresholds) & ~separated,
        of_laws={name: joint_frame(results, name, frame) for name in LAW_HISTORIES if results.has_joint_history(name)}
        | ({"stone": stone_of_joints(results)} if has_stones(results) else {}),
    )


def has_bonds(results: Results) -> bool:
    """Return True if joints of the run had cohesion."""
    return results.has_joint_history(BONDED)


def bonds(results: Results) -> Summary:
    """Joints that were bonded at the start, and those of them that broke, all over or in part; nothing in a run without bonds."""
    if not has_bonds(results):
        return Summary()
    share = results.joint_history(BONDED)
    return Summary(joints_bonded=int((share[0] > 0.0).sum()), joints_broken=int((share[-1] < BROKEN * share[0]).sum()))


def crushing(results: Results) -> Summary:
    """Joints that were crushed, by how much the most of them at the end and which one, and how many a frame shows crushed that no
    longer know it, as their blocks came far apart or met with other faces; nothing in a run whose joints cannot."""
    if not results.has_joint_history(CRUSHED):
        return Summary()
    history, joints = results.joint_history(CRUSHED), results.joints
    by, lost = history[-1], (history > 0.0).any(axis=0) & ~(history[-1] > 0.0)
    most = float(by.max(initial=0.0))
    found = Summary(joints_crushed=int((by > 0.0).sum()), crushed_max=most, crushing_forgotten=int(lost.sum()))
    ends = (results.blocks[int(block[by.argmax()])].name for block in (joints.block_a, joints.block_b))
    return found | Summary(crushed_where=" - ".join(f'"{name}"' for name in ends)) if most else found


def separated_joints(results: Results, frame: int = -1, thresholds: Thresholds | None = None) -> np.ndarray:
    """(J,) True where a joint is separated at a frame."""
    thresholds = thresholds or Thresholds()
    joints = results.joints
    solids = solids_of(results.blocks)
    gap = smallest_gap(joints, solids, Pose.of(results, solids, frame))
    sliding, contact_area = (joint_frame(results, name, frame) for name in ("sliding", "contact_area"))
    there = results.present(frame)
    return there[joints.block_a] & there[joints.block_b] & parted(joints, gap, sliding, contact_area, thresholds)


def collapsed_blocks(results: Results, thresholds: Thresholds | None = None, frame: int = -1) -> tuple[str, ...]:
    """Names of the blocks that have fallen, see :mod:`masonry_cd.analysis.damage.definitions`."""
    return tuple(results.blocks[i].name for i in np.flatnonzero(fallen(results, thresholds, frame)))


def fallen(results: Results, thresholds: Thresholds | None = None, frame: int = -1) -> np.ndarray:
    """(B,) True where a free block has fallen at a frame."""
    thresholds = thresholds or Thresholds()
    solids = solids_of(results.blocks)
    separated = separated_joints(results, frame, thresholds)
    return fallen_in(results.joints, solids, Pose.of(results, solids, frame), separated, thresholds)


def displacement_max(results: Results) -> float:
    """Largest displacement of a block's centre of mass relative to the base [m], over all steps; over the frames in older files."""
    free = np.array([not block.fixed for block in results.blocks])
    of_steps = results.step_peaks["displacement"][free] if results.has_peaks_of_steps else np.zeros(0)
    return float(max(displacements(results).max(initial=0.0), of_steps.max(initial=0.0)))


def displacements(results: Results) -> np.ndarray:
    """(F,) largest displacement of a block's centre of mass relative to the base in each frame [m]."""
    solids, largest = solids_of(results.blocks), np.zeros(results.frames)
    if solids.fixed.all():
        return largest
    for some in results.in_chunks(3 * len(solids.centre)):
        position = np.asarray(results.position[some], dtype=float)
        relative = base_at(results, solids, some).seen(position) - solids.centre
        largest[some] = np.linalg.norm(relative[:, ~solids.fixed], axis=2).max(axis=1)
    return largest


def joint_counts(table: JointDamage) -> JointCounts:
    """Numbers of joints by state, each joint once by the word in its row, and of those that only opened, only slid, and did both."""
    counts = {f"joints_{state}": int(np.count_nonzero(table.state == state)) for state in STATES[1:]}
    only = {f"joints_only_{state}": int(np.count_nonzero((table.state == state) & ~table.both)) for state in STATES[1:3]}
    return JointCounts(**counts | only, joints_opened_and_slid=int(np.count_nonzero(table.both)))


def in_words(table: JointDamage) -> str:
    """How many joints opened, slid and came apart over the run, in a line."""
    found = joint_counts(table)
    return (
        f"{counted(found.joints_only_opened, 'joint')} opened, {found.joints_only_slid} slid, "
        f"{found.joints_opened_and_slid} opened and slid, {found.joints_separated} separated"
    )


def shock_rows(results: Results, thresholds: Thresholds | None = None) -> tuple[ShockDamage, ...]:
    """Return the damage after each shock of a sequence and its rest, that of earlier shocks included."""
    return tuple(_shock_row(results, thresholds, i) for i in range(len(results.shocks)))


def _shock_row(results: Results, thresholds: Thresholds | None, i: int) -> ShockDamage:
    """Return the damage after one shock."""
    shock, table = results.shocks[i], joint_damage(results, thresholds, i)
    return ShockDamage(
        name=shock.name,
        start=shock.start,
        end=shock.end,
        rest_end=float(results.time[shock.frame]),
        **joint_counts(table).as_dict(),
        collapsed_blocks=len(collapsed_blocks(results, thresholds, shock.frame)),
        opening_max=float(table.max_opening.max(initial=0.0)),
        sliding_max=float(table.max_sliding.max(initial=0.0)),
        residual_opening_max=float(table.residual_opening.max(initial=0.0)),
        residual_sliding_max=float(table.residual_sliding.max(initial=0.0)),
    )


def _peaks(results: Results, thresholds: Thresholds, shock: int | None) -> dict[str, np.ndarray]:
    """Peaks over all steps, or those up to the rest after a shock; over the frames where the run was killed before it wrote them."""
    found = results.peaks if shock is None else results.peaks_after(shock)
    peaks = {name: np.array(values, dtype=float) for name, values in found.items()}
    if not np.isnan(peaks["opening"]).any():
        if thresholds.opened != OPENING_IN_RUN:  # the run noted the times of its own threshold only
            first, last = _first_time(results, thresholds.opened), len(results.time) - 1 if shock is None else results.shocks[shock].frame
            peaks["first_opening_time"] = np.where(first <= results.time[last], first, np.nan)
        return peaks
    for name in ("opening", "sliding", "rotation"):
        peaks[name] = results.joint_history(name).max(axis=0)
    peaks["contact_area_loss"] = 1.0 - results.joint_history("contact_area").min(axis=0) / results.joints.area
    peaks["first_opening_time"] = _first_time(results, thresholds.opened)
    return peaks


def _first_time(results: Results, opened: float) -> np.ndarray:
    """(J,) time of the first frame whose opening reaches a threshold [s], NaN where none does."""
    beyond = results.joint_history("opening") >= opened
    return np.where(beyond.any(axis=0), results.time[beyond.argmax(axis=0)], np.nan)
