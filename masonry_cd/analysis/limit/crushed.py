# SPDX-License-Identifier: GPL-3.0-or-later
r"""Which joints are at their compressive strength: at the factor found, and where the dead loads leave little of it.

A joint that closes in a mechanism is on the surface of its domain, |M| = N b/2 (1 - N/(f b t)): N and M are those of the stress block on
its one side. A joint at rest has one of many sets of forces, and says nothing. So what the dead loads leave is asked of the largest
multiple of them that is borne: if a joint crushes where that ends, before 1 + LEFT, it is named.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_cd.analysis.limit.analysis import Collapse, collapse_of
from masonry_cd.analysis.limit.crushing import solved_finely
from masonry_cd.analysis.limit.mechanism import mechanism
from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.analysis.limit.programme import largest
from masonry_cd.analysis.limit.solution import Unbounded
from masonry_cd.foundation.quantities import counted, pressure
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints

LEFT = 0.25  # more of the dead loads that a structure is asked to bear: the fifth of the strength that is then used is little
NAMED = 3  # joints that a line names


@dataclass(frozen=True)
class CrushedJoint:
    """A joint at its compressive strength."""

    joint: int
    block_a: str
    block_b: str
    groups: str
    strength_pa: float
    share: float  # of its area under stress at its strength: N/(f b t)

    @property
    def words(self) -> str:
        """The joint as text."""
        named = f'"{self.block_a}" - "{self.block_b}" ({self.groups}, {pressure(self.strength_pa)})'
        return f"{named} over {100.0 * self.share:.3g} % of its area"


@dataclass(frozen=True)
class LittleLeft:
    """A multiple of the dead loads below 1 + LEFT at which joints crush."""

    factor: float
    joints: tuple[CrushedJoint, ...]


def crushed_joints(problem: LimitProblem, collapse: Collapse, assembly: Assembly, joints: Joints) -> tuple[CrushedJoint, ...]:
    """The joints that crush in a mechanism, those first that are at their strength over most of their area."""
    share = collapse.block_share
    if problem.sections is None or share is None:
        return ()
    strength = np.full(joints.count, np.nan)
    strength[problem.sections.joint] = problem.sections.strength - problem.sections.tension
    found = np.flatnonzero(collapse.mechanism.crushing & np.isfinite(strength))
    first = found[np.argsort(-share[found], kind="stable")]
    return tuple(_named(int(j), float(strength[j]), float(share[j]), assembly, joints) for j in first)


def _named(j: int, strength: float, share: float, assembly: Assembly, joints: Joints) -> CrushedJoint:
    a, b = int(joints.block_a[j]), int(joints.block_b[j])
    groups = "-".join(assembly.groups[assembly.group_of[block]] for block in (a, b))
    return CrushedJoint(j, assembly.names[a], assembly.names[b], groups, strength, share)


def little_left(problem: LimitProblem, assembly: Assembly, joints: Joints) -> LittleLeft | None:
    """The least multiple of the dead loads of a structure that stands at which joints crush; None where the strength bears 1 + LEFT."""
    if problem.sections is None or problem.moves_support:
        return None
    most, bond = 1.0 + LEFT, np.zeros_like(problem.dead)
    bond[problem.unknowns - problem.rates :] = problem.dead[problem.unknowns - problem.rates :]  # which does not grow with the loads
    try:
        finer, best = solved_finely(problem, lambda one: largest(one, bond, one.dead - bond, most))
    except Unbounded:
        return None
    moves = mechanism(finer, assembly, joints, best.velocity)
    crushed = crushed_joints(finer, collapse_of(finer, best, moves, joints.count), assembly, joints)
    return LittleLeft(best.factor, crushed) if crushed and best.factor < most * (1.0 - 1e-6) else None


def crushed_lines(crushed: tuple[CrushedJoint, ...], left: LittleLeft | None) -> list[str]:
    """Both as text."""
    out = [f"crushing: {counted(len(crushed), 'joint')} at the strength at this factor: {_listed(crushed)}"] if crushed else []
    if left is not None:
        out.append(f"the dead loads leave little of the strength: at {left.factor:.4g} times of them joints crush: {_listed(left.joints)}")
    return out


def _listed(joints: tuple[CrushedJoint, ...]) -> str:
    more = f" and {len(joints) - NAMED} more" if len(joints) > NAMED else ""
    return ", ".join(one.words for one in joints[:NAMED]) + more
