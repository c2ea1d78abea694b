# SPDX-License-Identifier: GPL-3.0-or-later
"""Load factors of joints that crush: a flat arch, and the dry walls of Lourenco et al. (2005), by ``python -m benchmarks.crushing``.

Each is analysed for some compressive strengths of its joints, and without; the tables are those of docs/limit_analysis.md.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from masonry_cd.analysis.limit.analysis import LimitOptions, analyse
from masonry_cd.analysis.limit.problem import Bars, BlockLoads
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.materials import Material
from structures.geometry.prism import box

GRAVITY = 9.81  # [m/s2]
STRENGTHS = (None, 57e6, 20e6, 10e6, 5e6, 3e6)  # [Pa]; None: joints do not crush, 57 MPa: the least of the units' own
WALL_LOADS = (0.15e6, 0.5e6, 1.0e6, 1.25e6)  # on the top of the walls [Pa]
MEASURED = ("21.9, 22.9", "41.5, 48.2", "71.6, 68.6", "102.7")  # [kN]
GRANITE, GRANITE_FRICTION = 2650.0, 0.62  # density assumed [kg/m3]; friction assumed, as other papers on these walls have it
UNIT, COURSES, THICK = (0.2, 0.1), 9, 0.2  # length, height, number of courses, thickness [m]
LENGTH, PUSHED_AT = 1.0, 1.0  # of the wall, and the height of the push [m]
ARCH = (2.0, 0.4, 0.3, 10)  # span, depth, thickness [m], stones of the flat arch


def _material(friction: float, strength: float | None) -> Material:
    return Material(friction=friction, joints={} if strength is None else {"default": JointLaw(compressive_strength=strength)})


def _loads(assembly: Assembly) -> tuple[np.ndarray, np.ndarray]:
    """Weight, and no live load."""
    dead, live = np.zeros((assembly.count, 6)), np.zeros((assembly.count, 6))
    dead[~assembly.fixed, 2] = -GRAVITY * assembly.mass[~assembly.fixed]
    return dead, live


def dry_wall(stress: float, strength: float | None) -> tuple[float, float | None]:
    """The push [N] that a dry wall bears under a stress on its top [Pa], associated and the least found without dilation."""
    blocks = [Block("base", *box((-0.5, 0.0, -0.5), (LENGTH + 0.5, THICK, 0.0)), GRANITE, "base", fixed=True)]
    for course in range(COURSES):
        edges = np.arange(0.0, LENGTH + 1e-9, UNIT[0]) if course % 2 == 0 else np.array([0.0, *np.arange(0.1, LENGTH, UNIT[0]), LENGTH])
        low = course * UNIT[1]
        for k, (left, right) in enumerate(pairwise(edges)):
            blocks.append(Block(f"{course}.{k}", *box((left, 0.0, low), (right, THICK, low + UNIT[1])), GRANITE, "wall"))
    top = COURSES * UNIT[1]
    blocks.append(Block("beam", *box((0.0, 0.0, top), (LENGTH, THICK, top + 0.2)), GRANITE, "wall"))
    assembly = Assembly.from_blocks(blocks, _material(GRANITE_FRICTION, strength))
    dead, live = _loads(assembly)
    dead[-1, 2] = -stress * LENGTH * THICK
    live[-1, 0], live[-1, 4] = 1.0, PUSHED_AT - (top + 0.1)
    found = analyse(assembly, find_joints(assembly), BlockLoads(dead, live, Bars.none()), LimitOptions(starts=4))
    return found.associated.factor, None if found.least is None else found.least.optimum.factor


def flat_arch(strength: float | None) -> float:
    """The load at mid-span [N] that a flat arch between rigid abutments bears; infinite where its joints do not crush."""
    span, depth, thick, stones = ARCH
    blocks = [Block("left", *box((-0.5, 0.0, -0.2), (0.0, thick, depth + 0.2)), GRANITE, "base", fixed=True)]
    wide = span / stones
    for k in range(stones):
        blocks.append(Block(f"v{k}", *box((k * wide, 0.0, 0.0), ((k + 1) * wide, thick, depth)), GRANITE, "arch"))
    blocks.append(Block("right", *box((span, 0.0, -0.2), (span + 0.5, thick, depth + 0.2)), GRANITE, "base", fixed=True))
    assembly = Assembly.from_blocks(blocks, _material(2.0, strength))
    dead, live = _loads(assembly)
    for k, side in ((stones // 2, 1.0), (stones // 2 + 1, -1.0)):
        live[k, 2], live[k, 4] = -0.5, 0.25 * wide * side
    found = analyse(assembly, find_joints(assembly), BlockLoads(dead, live, Bars.none()), LimitOptions(starts=0))
    return found.associated.factor


def main() -> None:
    """Print the tables."""
    print("| strength [MPa] | flat arch [kN] | " + " | ".join(f"wall at {stress / 1e6:g} MPa [kN]" for stress in WALL_LOADS) + " |")
    for strength in STRENGTHS:
        walls = [dry_wall(stress, strength) for stress in WALL_LOADS]
        cells = [f"{least / 1e3 if least else np.nan:.1f} to {most / 1e3:.1f}" for most, least in walls]
        print(f"| {'none' if strength is None else f'{strength / 1e6:g}'} | {flat_arch(strength) / 1e3:.4g} | {' | '.join(cells)} |")
    print(f"| measured | | {' | '.join(MEASURED)} |")


if __name__ == "__main__":
    main()
