# SPDX-License-Identifier: GPL-3.0-or-later
"""Has the kernels of a run compiled before it begins, by a run of three cubes, so that compiling does not count as time of the run.

The scene of the cubes has a bit of all that a step can meet: a cube at rest, one that starts inside another by a micrometre, one that falls
on it. No step can reach its tolerance, so that ``auto`` turns to every solver that it has. Which files of ``kernel_store.py`` that took is
kept as a list: as long as they are all there nothing needs to be done, and a run loads what it calls.

``python -m masonry_cd.app.warmup`` does so for a plane and for space with ``auto``, so that no first run has to (``make setup``).

numba compiles one thing at a time. Where there are two cores, a second process therefore compiles the methods that linearise the law, and
before them some that the first one needs late, while this one runs the cubes with ADMM; each finds in the store what the other one has
made. If the second process fails, all is compiled here.
"""

from __future__ import annotations

import gc
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from functools import cache, cached_property
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from masonry_cd import mechanics
from masonry_cd.app import compile_progress
from masonry_cd.app.run_loop import RunPlan, run
from masonry_cd.foundation import jit, kernel_store
from masonry_cd.io.result_writer import ResultWriter
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.dynamics import islands
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.friction.contact_geometry import Geometry
from masonry_cd.mechanics.friction.law_terms import errors_by_group
from masonry_cd.mechanics.friction.problem import FrictionProblem, Problem, Solution, natural_map_error
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.joints import Joints, touching_places
from masonry_cd.mechanics.model.materials import Material
from masonry_cd.mechanics.model.state import State
from masonry_cd.mechanics.solvers import SOLVERS, Options, cores

STEPS, STEP = 6, 1e-3  # [s]
FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
BALLS = "balls"  # group of the sphere, which is rigid where blocks deform
COARSE = 10.0  # of elements [m]: as few of them as a cube can have
PATIENCE = 60.0  # to wait for the second process, beyond twice what this one took for its share [s]
COLLECT = (100_000, 20, 20)  # objects made between two looks for garbage among the new ones, and such looks before one among older ones
UNREACHED = Options(tolerance=1e-300)
JOBS = {  # of ``auto``, in a plane and in space: those of this process, and of the second one, which take about as long
    True: (("joints", "errors", "admm"), ("pivoting", "step")),
    False: (("joints", "admm", "step"), ("errors", "newton", "interior")),
}
SELDOM = ("newton", "interior")  # what a run in a plane seldom comes to

# What there is to compile, by solver and whether in a plane: kernels, and seconds of a processor.
KERNELS = {("auto", True): (34, 75.0), ("auto", False): (37, 85.0), ("nlgs", True): (25, 40.0), ("nlgs", False): (25, 45.0)}
MORE = ((2, 4.0), (5, 8.0), (8, 20.0), (10, 25.0))  # in addition to these for joint laws by area, stress, blocks that deform, and spheres
SHARED = 0.55  # of the time that one process takes, where two share the work
PLAIN_TAKES = 2.0  # times as long takes numba's own njit


@dataclass(frozen=True)
class SceneKind:
    """Properties of a scene that decide which kernels a run needs."""

    solver: str
    planar: bool
    by_area: bool = False  # joint laws per area
    stress: bool = False  # of blocks and joints as well
    strained: int = 0  # unknowns of a block beyond those of a rigid one
    spheres: bool = False

    @cached_property
    def file(self) -> str:
        """Name of the list of kernels in the store."""
        return kernel_store.name_of("warm-up", _sources(), f"{self} {jit.target()}")

    def is_compiled(self) -> bool:
        """Return True if all kernels are in the store."""
        data = None if jit.PLAIN else kernel_store.read(self.file)
        return data is not None and all(map(kernel_store.is_there, json.loads(data)))

    def note(self) -> None:
        """Note that what this process has loaded or compiled are the kernels."""
        if jit.keeps() and all(map(kernel_store.is_there, kernel_store.used)):
            kernel_store.write(self.file, json.dumps(sorted(kernel_store.used)).encode())


@cache
def _sources() -> str:
    """Hash of the text of the mechanics and of this file: they decide which kernels a run calls."""
    files = [*Path(mechanics.__path__[0]).rglob("*.py"), Path(__file__)]
    return sha256(b"".join(file.read_bytes() for file in sorted(files))).hexdigest()


_done: set[SceneKind] = set()  # whose kernels this process has


@contextmanager
def compiling(kind: SceneKind) -> Iterator[None]:
    """Have the kernels of a kind of scene compiled, where they are not in the store; the body may call kernels meanwhile."""
    if kind in _done or kind.is_compiled():
        compile_progress.late_methods.heard = True
        yield
        return
    compile_progress.late_methods.heard = False
    helped = kind.solver == "auto" and jit.keeps() and cores() > 1
    with _rarely_collecting(), compile_progress.shown(*_expected(kind, helped), jit.why_nothing_is_kept()):
        with second_process(kind) if helped else nullcontext():
            yield
            if helped:
                compile_jobs(kind, 0)
        compile_missing(kind)
    _done.add(kind)
    kind.note()
    compile_progress.late_methods.heard = True


@contextmanager
def _rarely_collecting() -> Iterator[None]:
    """Look for garbage less often: numba makes millions of objects that stay, and looking through them takes a sixth of the time."""
    usual = gc.get_threshold()
    gc.set_threshold(*COLLECT)
    try:
        yield
    finally:
        gc.set_threshold(*usual)


def _expected(kind: SceneKind, helped: bool) -> tuple[int, float]:
    """How many kernels a kind of scene needs, and about how long it takes to compile them all [s]."""
    count, seconds = KERNELS.get((kind.solver, kind.planar), KERNELS["auto", kind.planar])
    for asked, (more, longer) in zip((kind.by_area, kind.stress, kind.strained, kind.spheres), MORE, strict=True):
        count, seconds = (count + more, seconds + longer) if asked else (count, seconds)
    return count, seconds * (PLAIN_TAKES if jit.PLAIN else SHARED if helped else 1.0)


def compile_missing(kind: SceneKind) -> None:
    """Have all that a kind of scene needs compiled, or loaded where it is there."""
    if kind.solver in SOLVERS and kind.solver != "auto":
        shake_cubes(kind)
    elif kind.solver != "auto":  # from elsewhere
        shake_cubes(kind, unsolved=True)
        _measure_errors(kind)
    else:
        compile_jobs(kind, 0)
        compile_jobs(kind, 1)
        if jit.PLAIN:  # each run compiles, so that one line says it for all
            compile_seldom(kind)
        shake_cubes(replace(kind, solver="admm"))
        if kind.spheres:  # which it begins with only where there are many
            shake_cubes(replace(kind, solver="accelerated"))
    islands.compile_kernels()


def compile_jobs(kind: SceneKind, process: int) -> None:
    """Do the jobs of a process, 0 or 1, for a scene that ``auto`` solves."""
    for job in JOBS[kind.planar][process]:
        if job == "joints":
            _cubes(kind)
        elif job == "step":
            shake_cubes(kind, unsolved=True)
        elif job == "errors":
            _measure_errors(kind)
            islands.compile_kernels()
        else:
            SOLVERS[job](_falling_block(kind), UNREACHED, None)


def _measure_errors(kind: SceneKind) -> None:
    """Measure errors."""
    problem, impulse = _falling_block(kind), np.zeros((1, 2 if kind.planar else 3))
    natural_map_error(problem, impulse)
    errors_by_group(problem.arrays(), impulse, np.zeros(1, dtype=np.int64), 1)


def compile_seldom(kind: SceneKind) -> None:
    """Have those methods of ``auto`` compiled that a run in a plane seldom comes to."""
    for name in SELDOM:
        SOLVERS[name](_falling_block(kind), UNREACHED, None)


def _falling_block(kind: SceneKind) -> FrictionProblem:
    """The problem of a block that falls onto a support."""
    m, n = _rows_and_unknowns(kind.planar, kind.strained)
    body, contact = np.zeros((1, n)), np.zeros((1, m))
    at = (
        Geometry.by_rows(np.eye(m, n)[None, None].repeat(2, axis=1))
        if kind.strained
        else Geometry.by_arms(np.eye(m)[None], np.zeros((1, 2, m)))
    )
    return FrictionProblem(np.eye(n)[None], body - 1.0, np.array([[0, -1]]), at, contact, np.full(1, 0.5), contact)


def _unsolved(problem: Problem, _: Options, start: Solution | None) -> Solution:
    """A solver that leaves the impulses as they were."""
    impulse = np.zeros((problem.contacts, problem.dimension)) if start is None else start.impulse.copy()
    return Solution(impulse, None, 0, error=1.0)


def _cubes(kind: SceneKind) -> tuple[Assembly, Joints]:
    """The scene of the cubes."""
    planar, strained, spheres = kind.planar, kind.strained, kind.spheres
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    places = {"base": (0.0, 0.0), "sunk": (0.1, 1.0 - 1e-6), "falling": (0.2, 2.0 + 1e-3)}
    blocks = [Block(name, corners + [x, 0.0, z], FACES, 2000.0, fixed=name == "base") for name, (x, z) in places.items()]
    laws = {"default": JointLaw(normal_stiffness=1e9, cohesion=1.0)} if kind.by_area else {}
    if spheres:
        blocks.append(Block.sphere("ball", np.array([0.7, 0.5, 3.3]), 0.3, 2000.0, BALLS))
    assembly = Assembly.from_blocks(blocks, Material(friction=0.5, joints=laws, **_elasticity(planar, strained, spheres)))
    if assembly.deformation is not None:
        assembly = replace(assembly, deformation=replace(assembly.deformation, room=_rows_and_unknowns(planar, strained)[1]))
    joints = find_joints(assembly)
    touching_places(joints, assembly, State.at_rest(assembly), np.arange(joints.count))  # which a run asks for at its first hinge
    return assembly, joints


def shake_cubes(kind: SceneKind, unsolved: bool = False) -> None:
    """A short run of cubes, which compiles what its solver needs; ``unsolved`` by no solver, as one island."""
    assembly, joints = _cubes(kind)
    shaking = np.zeros((STEPS + 1, 1, 3))
    shaking[:, 0, 0] = 0.01 * np.arange(STEPS + 1)
    gravity = np.tile([0.0, 0.0, -9.81], (STEPS + 1, 1))
    solver = "admm" if unsolved else kind.solver
    settings = Run(dt=STEP, duration=STEPS * STEP, solver=solver, tolerance=1e-300, planar=kind.planar, islands=not unsolved)
    with TemporaryDirectory() as folder, ResultWriter(Path(folder) / "result.h5", assembly, joints) as writer:
        machine = Stepper(assembly, shaking, gravity, settings)
        if unsolved:
            machine.islands.solver = _unsolved
        machine.kick(np.where(np.array(assembly.names) == "falling", 1.0, 0.0)[:, None] * [0.0, 0.0, -0.5, 0.0, 0.0, 0.0])  # it lands
        run(machine, joints, writer, RunPlan(STEPS, stress=kind.stress))


def _elasticity(planar: bool, strained: int, spheres: bool) -> dict[str, Any]:
    """Keys of the material of blocks with some unknowns more than rigid ones have; spheres are rigid, and roll with friction."""
    rolling = {"rolling_friction": 0.01} if spheres else {}
    if strained == 0:
        return rolling
    kind = "uniform" if strained == (3 if planar else 6) else "tetrahedra"
    keys = {"deformable": {BALLS: "rigid", "default": kind} if spheres else kind, "young": 1e9}
    return keys | rolling | ({"mesh_size": COARSE} if kind == "tetrahedra" else {})


# --- the second process ------------------------------------------------------------------------------------------------------------


def _rows_and_unknowns(planar: bool, strained: int) -> tuple[int, int]:
    """Return the rows of a contact, and the unknowns of a block with that many more than a rigid one has."""
    return (2, 3 + strained) if planar else (3, 6 + strained)


@contextmanager
def second_process(kind: SceneKind) -> Iterator[subprocess.Popen[bytes] | None]:
    """Have a process of its own do its jobs meanwhile; wait for it at the end; it ends with this one at the latest."""
    begin = time.monotonic()
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    call = f"from masonry_cd.app.warmup import SceneKind, be_second_process; be_second_process({kind!r})"
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
            other.wait(PATIENCE + 2 * (time.monotonic() - begin))
        except subprocess.TimeoutExpired:
            pass
        finally:
            other.kill()


def be_second_process(kind: SceneKind) -> None:
    """Compile its share; leave when the input ends, which happens when the first process does, in whatever way."""
    threading.Thread(target=_leave_at_end_of_input, daemon=True).start()
    gc.set_threshold(*COLLECT)
    compile_jobs(kind, 1)


def _leave_at_end_of_input() -> None:
    sys.stdin.buffer.read()
    os._exit(1)


if __name__ == "__main__":
    for in_plane in (True, False):
        usual = SceneKind("auto", in_plane)
        with compiling(usual):
            pass
        compile_progress.late_methods.heard = False  # "which no step needed before" is news of a run
        compile_seldom(usual)
