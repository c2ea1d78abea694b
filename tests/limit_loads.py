# SPDX-License-Identifier: GPL-3.0-or-later
"""Loads of limit analyses for the tests: gravity and a push, on blocks placed by hand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from models import GRAVITY

from benchmarks.limit import push as push_loads
from masonry_cd.analysis.limit.analysis import Analysis, LimitOptions, analyse
from masonry_cd.analysis.limit.part import FreedPart, Whole
from masonry_cd.analysis.limit.problem import Bars, BlockLoads
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.model.materials import Material


def joined(blocks: Sequence[Block], friction: float, laws: Mapping[str, JointLaw] | None = None) -> tuple[Assembly, Joints]:
    """An assembly and its joints."""
    assembly = Assembly.from_blocks(blocks, Material(friction=friction, joints=dict(laws or {})))
    return assembly, find_joints(assembly)


def everything(assembly: Assembly, joints: Joints, analysis: Analysis, loads: BlockLoads) -> FreedPart:
    """A structure under a push along x as the part that holds everything."""
    whole = Whole(assembly, joints, loads.dead, loads.bars, GRAVITY, lambda group: False)
    return FreedPart(whole, assembly, ~assembly.fixed, analysis.problem, np.array([GRAVITY, 0.0, 0.0]), loads, Bars.none())


def pushed(
    blocks: Sequence[Block],
    friction: float,
    direction: Sequence[float] = (1.0, 0.0, 0.0),
    laws: Mapping[str, JointLaw] | None = None,
    options: LimitOptions | None = None,
) -> Analysis:
    """The limit analysis of blocks under a push."""
    assembly, joints = joined(blocks, friction, laws)
    return analyse(assembly, joints, push_loads(assembly, direction), options or LimitOptions(starts=0))
