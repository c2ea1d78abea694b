"""A run of three cubes before the real one, so that what numba compiles on first use does not count as time of the run.

The scene has a bit of all that a step can meet: a cube at rest, one that starts inside another by a micrometre, one that falls on it.
No step can reach its tolerance, so that ``auto`` turns to every solver that it has.

``python -m masonry_cd.app.warmup`` does so for a plane and for space with ``auto``, so that no first run has to (``make setup``).

numba compiles one thing at a time. Where there are two cores, a second process therefore compiles the largest kernel, while this one runs
the cubes with ADMM; then this one finds it in numba's cache. If the second process fails, it is compiled here.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numba import types

from masonry_cd.app.run_loop import run
from masonry_cd.foundation.jit import has_cache, kept
from masonry_cd.io.result_writer import ResultWriter
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.dynamics import islands
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.friction.problem import FrictionProblem
from masonry_cd.mechanics.linalg.small_blocks import room_for, size_of_blocks
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.elastic_blocks import ElasticBlocks
from masonry_cd.mechanics.model.joints import touching_places
from masonry_cd.mechanics.model.materials import JointLaw
from masonry_cd.mechanics.model.state import State
from masonry_cd.mechanics.solvers import Options, cores, interior
from masonry_cd.mechanics.solvers.condensed import is_condensed
from masonry_cd.mechanics.solvers.linearised_bodies import linearised_by_team

STEPS, STEP = 6, 1e-3  # [s]
FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
BALLS = "balls"  # group of the sphere, which is rigid where blocks deform
COARSE = 10.0  # of elements [m]: as few of them as a cube can have
PATIENCE = 60.0  # to wait for the second process, beyond what this one took for its share [s]


@cache
def compile_kernels(solver: str, planar: bool, by_area: bool, stress: bool = False, strained: int = 0, spheres: bool = False) -> None:
    """Have the kernels of a solver compiled, or loaded from their cache: in a plane or in space, with laws that go by area or without;
    ``stress``: those of the stress of blocks and joints as well; ``strained``: for blocks with so many unknowns more than rigid ones have;
    ``spheres``: for scenes with some."""
    if solver in ("auto", "newton", "interior", "pivoting") and keeps() and not is_kept(planar, strained) and cores() > 1:
        with second_process(planar, strained):
            _shake_cubes("admm", planar, by_area, strained=strained, spheres=spheres)
    _shake_cubes(solver, planar, by_area, stress, strained, spheres)
    if solver == "auto" and spheres:  # which begins with them only where there are many
        _shake_cubes("accelerated", planar, by_area, strained=strained, spheres=spheres)
    islands.compile_kernels()


def keeps() -> bool:
    """Whether later runs find what this one compiles."""
    return has_cache(linearised_by_team)


def _shake_cubes(solver: str, planar: bool, by_area: bool, stress: bool = False, strained: int = 0, spheres: bool = False) -> None:
    """The run."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    places = {"base": (0.0, 0.0), "sunk": (0.1, 1.0 - 1e-6), "falling": (0.2, 2.0 + 1e-3)}
    blocks = [Block(name, corners + [x, 0.0, z], FACES, 2000.0, fixed=name == "base") for name, (x, z) in places.items()]
    laws = {"default": JointLaw(normal_stiffness=1e9, cohesion=1.0)} if by_area else None
    if spheres:
        blocks.append(Block.sphere("ball", np.array([0.7, 0.5, 3.3]), 0.3, 2000.0, BALLS))
    assembly = Assembly.from_blocks(blocks, 0.5, laws, _material(planar, strained, spheres), 0.01 if spheres else 0.0)
    if assembly.deformation is not None:
        assembly = replace(assembly, deformation=replace(assembly.deformation, room=_rows_and_unknowns(planar, strained)[1]))
    joints = find_joints(assembly)
    touching_places(joints, assembly, State.at_rest(assembly), np.arange(joints.count))  # which a run asks for at its first hinge
    shaking = np.zeros((STEPS + 1, 1, 3))
    shaking[:, 0, 0] = 0.01 * np.arange(STEPS + 1)
    gravity = np.tile([0.0, 0.0, -9.81], (STEPS + 1, 1))
    settings = Run(dt=STEP, duration=STEPS * STEP, solver=solver, tolerance=1e-300, planar=planar)
    with TemporaryDirectory() as folder, ResultWriter(Path(folder) / "result.h5", assembly, joints) as writer:
        machine = Stepper(assembly, shaking, gravity, settings)
        machine.kick(np.where(np.array(assembly.names) == "falling", 1.0, 0.0)[:, None] * [0.0, 0.0, -0.5, 0.0, 0.0, 0.0])  # it lands
        run(machine, joints, writer, STEPS, stress=stress)


def _material(planar: bool, strained: int, spheres: bool) -> ElasticBlocks | None:
    """Of blocks with so many unknowns more than rigid ones have; spheres are rigid."""
    if strained == 0:
        return None
    kind = "uniform" if strained == (3 if planar else 6) else "tetrahedra"
    keys = {"deformable": {BALLS: "rigid", "default": kind} if spheres else kind, "young": 1e9}
    return ElasticBlocks.model_validate(keys | ({"mesh_size": COARSE} if kind == "tetrahedra" else {}))


# --- the second process ------------------------------------------------------------------------------------------------------------


def is_kept(planar: bool, strained: int = 0) -> bool:
    """Whether the largest kernel is in the cache."""
    problems = [kinds[2] for kinds in kept(linearised_by_team)]  # numba's types of ProblemArrays
    rows, unknowns = _rows_and_solved_unknowns(planar, strained)
    wanted = type(size_of_blocks(unknowns)) is np.ndarray  # one kernel for all that many
    return any(
        len(problem.m) == rows and (isinstance(problem.n, types.Array) if wanted else getattr(problem.n, "count", 0) == unknowns)
        for problem in problems
    )


def _rows_and_unknowns(planar: bool, strained: int) -> tuple[int, int]:
    """Of a contact, and of a block with so many unknowns more than a rigid one has."""
    return (2, 3 + strained) if planar else (3, 6 + strained)


def _rows_and_solved_unknowns(planar: bool, strained: int) -> tuple[int, int]:
    """Of a contact, and of a block as solvers see it: meshed ones have others, see condensation.py."""
    rows, unknowns = _rows_and_unknowns(planar, strained)
    return rows, room_for(0) if is_condensed(unknowns) else unknowns


@contextmanager
def second_process(planar: bool, strained: int = 0) -> Iterator[subprocess.Popen[bytes] | None]:
    """Compile the largest kernel in a process of its own meanwhile, and in the end wait for it. It ends with this one at the latest."""
    begin = time.monotonic()
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    call = f"from masonry_cd.app import warmup; warmup.be_second_process({planar}, {strained})"
    try:
        other = subprocess.Popen(
            [sys.executable, "-P", "-c", call], env=environment, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
    except OSError:  # no process to be had
        yield None
        return
    with other:
        try:
            yield other
            other.wait(PATIENCE + time.monotonic() - begin)
        except subprocess.TimeoutExpired:
            pass
        finally:
            other.kill()


def be_second_process(planar: bool, strained: int) -> None:
    """Compile the largest kernel; leave when the input ends, which happens when the first process does, in whatever way."""
    threading.Thread(target=_leave_at_end_of_input, daemon=True).start()
    compile_largest(planar, strained)


def _leave_at_end_of_input() -> None:
    sys.stdin.buffer.read()
    os._exit(1)


def compile_largest(planar: bool, strained: int = 0) -> None:
    """Have the largest kernel compiled, by an iteration on a block that falls onto a support."""
    m, n = _rows_and_solved_unknowns(planar, strained)
    jacobian = np.zeros((1, 2, m, n))
    jacobian[0, 0, :, :m] = np.eye(m)
    body, contact = np.zeros((1, n)), np.zeros((1, m))
    problem = FrictionProblem(np.eye(n)[None], body - 1.0, np.array([[0, -1]]), jacobian, contact, np.full(1, 0.5), contact)
    interior.solve(problem, Options(tolerance=1e-300, max_iterations=1))


if __name__ == "__main__":
    for in_plane in (True, False):
        compile_kernels("auto", in_plane, False)
