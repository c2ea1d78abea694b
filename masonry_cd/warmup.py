"""A run of three cubes before the real one, so that what numba compiles on first use does not count as time of the run.

The scene has a bit of all that a step can meet: a cube at rest, one that starts inside another by a micrometre, one that falls on it.
No step can reach its tolerance, so that ``auto`` turns to every solver that it has.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from masonry_cd import islands
from masonry_cd.blocks import Assembly, Block
from masonry_cd.joints import find_joints
from masonry_cd.results import ResultWriter
from masonry_cd.runner import run
from masonry_cd.scene import JointLaw, Run, SolverName
from masonry_cd.stepping import Stepper

STEPS, STEP = 6, 1e-3  # [s]
FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


@cache
def compile_kernels(solver: SolverName, planar: bool, by_area: bool) -> None:
    """Have the kernels of a solver compiled, or loaded from their cache: in a plane or in space, with laws that go by area or without."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    places = {"base": (0.0, 0.0), "sunk": (0.1, 1.0 - 1e-6), "falling": (0.2, 2.0 + 1e-5)}
    blocks = [Block(name, corners + [x, 0.0, z], FACES, 2000.0, fixed=name == "base") for name, (x, z) in places.items()]
    laws = {"default": JointLaw(normal_stiffness=1e9, cohesion=1.0)} if by_area else None
    assembly = Assembly.from_blocks(blocks, 0.5, laws)
    joints = find_joints(assembly)
    shaking = np.zeros((STEPS + 1, 1, 3))
    shaking[:, 0, 0] = 0.01 * np.arange(STEPS + 1)
    gravity = np.tile([0.0, 0.0, -9.81], (STEPS + 1, 1))
    settings = Run(dt=STEP, duration=STEPS * STEP, solver=solver, tolerance=1e-300, planar=planar)
    with TemporaryDirectory() as folder, ResultWriter(Path(folder) / "result.h5", assembly, joints) as writer:
        run(Stepper(assembly, shaking, gravity, settings), joints, writer, STEPS)
    islands.compile_kernels()
