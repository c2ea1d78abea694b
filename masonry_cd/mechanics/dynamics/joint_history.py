# SPDX-License-Identifier: GPL-3.0-or-later
"""Springs and bonds of elastic and mortar joints over a run: into the friction problem of each step, and out of its solution again.

The law is that of ``joint_law.py``. What a joint hands on from step to step is its elastic slip and whether it is still bonded.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_cd.mechanics.dynamics.bonds import BondMemory
from masonry_cd.mechanics.dynamics.contact_arrays import ContactRows, Velocities
from masonry_cd.mechanics.dynamics.crushing import book_crushing
from masonry_cd.mechanics.dynamics.joint_law import JointLawArrays, JointMemory, LawSprings, bonded_area, load_springs, unload_springs
from masonry_cd.mechanics.dynamics.softening import bounded, soften
from masonry_cd.mechanics.dynamics.step_problem import SpringWork, StepProblem
from masonry_cd.mechanics.dynamics.system import MotionState, System
from masonry_cd.mechanics.friction.problem import FrictionProblem
from masonry_cd.mechanics.model.joints import Joints

CREEP = 1e-6  # slip and opening below this share of g h count as none when bonds are judged
AT_START = 1e-6  # gaps up to this share of the smallest width are bonded in the first step, or those of the joints as built


def with_springs(system: System, laws: JointLawArrays, last: MotionState, rigid: StepProblem, pairs: np.ndarray) -> StepProblem:
    """Give contacts of elastic and bonded joints their law in a problem of rigid contacts, found between pairs of parts (P, 2)."""
    loads, rows = rigid.predicted.loads, rigid.rows
    springs = LawSprings.none(rigid.problem, _stiffness(system, rows, pairs))
    bonding = bonding_gap(system, last)
    load_springs(
        laws, rigid.found, rows, system.constants, rigid.predicted.rotation,
        Velocities(last.v, loads.support_before), loads.support_after, last.joints, bonding, springs,
    )  # fmt: skip
    if rigid.bonds is not None:
        springs = bounded(rigid.bonds, springs, rows.active, system.constants.step)
    problem = replace(rigid.problem, compliance=springs.compliance, offset=springs.offset)
    return rigid._replace(springs=springs, problem=problem)


def bonding_gap(system: System, last: MotionState) -> float:
    """Gap up to which new contacts are bonded in a step [m], negative after the first."""
    return max(AT_START * system.width, system.inexact) if last.steps == 0 else -1.0


def _stiffness(system: System, rows: ContactRows, pairs: np.ndarray) -> np.ndarray:
    """k_n and k_t of the contacts, (C, 2) [N/m3]: of the law of their groups, or else of the masonry."""
    laws, group = system.assembly.laws, tuple(rows.groups.T)
    own = np.stack([laws.normal_stiffness[group], laws.tangential_stiffness[group]], axis=1)
    if system.masonry is None:
        return own
    return np.where(own[:, :1] > 0.0, own, system.masonry.of_contacts(pairs[rows.pair], rows.blocks))


def carried_over(
    system: System, last: MotionState, made: StepProblem, v: np.ndarray, impulse: np.ndarray
) -> tuple[JointMemory, BondMemory, SpringWork]:
    """Slips and bonds after a step, those that soften, and what the springs did in it.

    Args:
        system: of the run.
        last: motion before the step.
        made: the problem of the step.
        v: (F, n) velocities at its end.
        impulse: (C, m) of it [N s].
    """
    if system.laws is None or made.springs is None:
        return last.joints, last.bonds, SpringWork()
    memory, loads = JointMemory.empty(len(made.found.gap)), made.predicted.loads
    still = max(CREEP, system.settings.tolerance) * made.predicted.pull * system.constants.step
    springs, bonds = made.springs, last.bonds
    if made.bonds is not None:
        brittle = ~made.bonds.held_rows(made.rows.active)
        springs = springs._replace(elastic=springs.elastic & brittle, bonded=springs.bonded & brittle)
    work = SpringWork(*unload_springs(
        system.laws, made.found, made.rows, system.constants, springs, made.predicted.rotation,
        Velocities(v, loads.support_after), impulse, still, memory,
    ).tolist())  # fmt: skip
    if made.bonds is not None:
        bonds, work = soften(system, made, v, impulse, memory, work)
    return memory, bonds, book_crushing(system, made, v, impulse, work)


def pretensioned(problem: FrictionProblem, bond: np.ndarray) -> FrictionProblem:
    """The problem in the impulses p + h tau A n, whose cones begin at zero; ``bond`` (C,) is h tau A [N s]."""
    pull = np.zeros_like(problem.offset)
    pull[:, 0] = bond
    return replace(problem, v_free=problem.body_velocity(-pull), offset=problem.offset - problem.compliance * pull)


def bonded_shares(made: StepProblem, motion: MotionState, pair_joint: np.ndarray, joints: Joints) -> np.ndarray:
    """Share of the area of each joint that is bonded after a step, (J,), less what softening has taken of its energy.

    ``pair_joint`` names the joint of each pair or -1.
    """
    whole, rows = np.zeros(joints.count), made.rows
    if made.springs is not None:
        area = made.springs.area
        if made.bonds is not None:
            which, row = made.bonds.rows(rows.active)
            area = area.copy()
            area[row] *= (1.0 - motion.bonds.spent[rows.active[row]]) / (1.0 - made.bonds.share[which])
        bonded_area(rows.active, made.found.pair, pair_joint, area, motion.joints.bonded, whole)
    return np.minimum(1.0, whole / joints.area)


def largest_by_joint(of_pairs: np.ndarray, pair_joint: np.ndarray, joints: Joints) -> np.ndarray:
    """The largest number of the pairs of parts (P,) of each joint, (J,); ``pair_joint`` names the joint of each pair or -1."""
    out, known = np.zeros(joints.count), pair_joint >= 0
    np.maximum.at(out, pair_joint[known], of_pairs[known])
    return out
