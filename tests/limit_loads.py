"""Loads of limit analyses for the tests: gravity and a push, on blocks placed by hand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from models import GRAVITY

from masonry_cd.contact.find_joints import find_joints
from masonry_cd.limit.analysis import Analysis, Options, analyse
from masonry_cd.limit.problem import Bars, Loads
from masonry_cd.model.blocks import Assembly, Block
from masonry_cd.model.joints import Joints
from masonry_cd.model.materials import JointLaw


def joined(blocks: Sequence[Block], friction: float, laws: Mapping[str, JointLaw] | None = None) -> tuple[Assembly, Joints]:
    """An assembly and its joints."""
    assembly = Assembly.from_blocks(blocks, friction, laws)
    return assembly, find_joints(assembly)


def push_loads(assembly: Assembly, direction: Sequence[float] = (1.0, 0.0, 0.0), bars: Bars | None = None) -> Loads:
    """Gravity, and lambda times the weight along a direction, on the free blocks."""
    dead, live = np.zeros((assembly.count, 6)), np.zeros((assembly.count, 6))
    weight = np.where(assembly.fixed, 0.0, GRAVITY * assembly.mass)
    dead[:, 2] = -weight
    live[:, :3] = weight[:, None] * np.asarray(direction) / np.linalg.norm(direction)
    return Loads(dead, live, bars or Bars.none())


def pushed(
    blocks: Sequence[Block],
    friction: float,
    direction: Sequence[float] = (1.0, 0.0, 0.0),
    laws: Mapping[str, JointLaw] | None = None,
    options: Options | None = None,
) -> Analysis:
    """The limit analysis of blocks under a push."""
    assembly, joints = joined(blocks, friction, laws)
    return analyse(assembly, joints, push_loads(assembly, direction), options or Options(starts=0))
