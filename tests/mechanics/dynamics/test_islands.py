# SPDX-License-Identifier: GPL-3.0-or-later
"""Islands: the same answer as of one problem, sleep without a trace, memory that lasts and is resumed."""

from dataclasses import replace

import numpy as np
import pytest
from models import GRAVITY, advance, box, ground, stepper, still

from masonry_cd.mechanics.dynamics.islands import EASY, HARD, REVIEW, Islands, gather_islands
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.friction.problem import Solution
from masonry_cd.mechanics.friction.solver_state import Learnt, SolverState
from masonry_cd.mechanics.solvers import Options

DT = 1e-3
PLACES = {"broad": (0.0, 0.5), "slender": (2.0, 0.12), "middling": (4.0, 0.25)}  # x and width of towers of three blocks


def towers(*names: str, steps: int = 300, lifted: float = 0.0, shaken: float = 0.15, **settings: object) -> Stepper:
    """Towers on one plate that is shaken for 0.2 s; the first one's top block begins that much above its place."""
    blocks = [ground(8.0)]
    for name in names:
        x, width = PLACES[name]
        for k in range(3):
            rise = lifted if name == names[0] and k == 2 else 0.0
            low, high = (x - width / 2, -width / 2, 0.3 * k + rise), (x + width / 2, width / 2, 0.3 * k + 0.3 + rise)
            blocks.append(box(f"{name}{k}", low, high))
    velocity, time = still(steps), np.arange(steps + 1) * DT
    velocity[:, 0, 0] = shaken * np.sin(2 * np.pi * 5.0 * np.minimum(time, 0.2))
    return stepper(blocks, steps, dt=DT, support_velocity=velocity, **({"solver": "auto", "tolerance": 1e-9} | settings))


def path(machine: Stepper, steps: int = 300) -> np.ndarray:
    """Displacements after each step, (N, B, 3)."""
    moved = []
    for _ in range(steps):
        machine.step()
        moved.append(machine.state.position - machine.assembly.centre)
    return np.array(moved)


def test_each_island_moves_as_in_a_scene_of_its_own_and_as_in_one_problem():
    together = path(towers(*PLACES))
    one = path(towers(*PLACES, islands=False))
    assert np.abs(together).max() > 0.01  # the slender one rocks
    assert np.abs(together - one).max() < 1e-6
    for k, name in enumerate(PLACES):
        alone = path(towers(name))
        assert np.abs(together[:, 1 + 3 * k : 4 + 3 * k] - alone[:, 1:]).max() < 1e-6


def test_what_rests_sleeps_next_to_what_rocks_and_no_drift_shows():
    machine, reports = towers("broad", "slender", steps=600), []
    for _ in range(600):
        reports.append(machine.step())
    late = reports[450:]
    assert {report.islands for report in late} == {2}
    assert max(report.iterations for report in late) > 0  # the slender tower still rocks
    assert np.mean([report.sleeping for report in late]) > 0.45  # the broad one, half of the blocks, sleeps
    assert max(report.error for report in reports) <= 1e-9
    moved = machine.state.position - machine.assembly.centre
    assert np.abs(moved[1:4] - moved[0]).max() < 1e-8


def test_a_sleeping_island_wakes_when_it_is_hit():
    """A block falls by 2 cm onto a tower at rest next to another one: it lands after sqrt(2 s / g)."""
    lands = round(np.sqrt(2 * 0.02 / GRAVITY) / DT)
    machines = [towers("broad", "middling", lifted=0.02, shaken=0.0, islands=islands) for islands in (True, False)]
    sleeping, paths = [], []
    for machine in machines:
        moved = []
        for _ in range(120):
            sleeping.append(machine.step().sleeping)
            moved.append(machine.state.position - machine.assembly.centre)
        paths.append(np.array(moved))
    assert max(sleeping[lands - 10 : lands - 3]) == pytest.approx(5 / 6)  # all but the block that falls
    assert min(sleeping[lands - 3 : lands + 4]) == 0.0
    assert sleeping[119] == 1.0
    assert np.abs(paths[0] - paths[1]).max() < 1e-8


def test_a_resumed_stepper_continues_to_the_same_bits():
    first, second = towers(*PLACES), towers(*PLACES)
    advance(first, 150)
    second.restore({name: array.copy() for name, array in first.snapshot().items()})
    for machine in (first, second):
        advance(machine, 60)
    assert first.state.position.tobytes() == second.state.position.tobytes()
    assert first.islands.sleeping == second.islands.sleeping


def test_hard_islands_are_solved_alone_until_they_meet_and_keep_what_was_learnt():
    seen: list[tuple[int, list[str]]] = []

    def solver(problem, options, start):
        """Notes what it is given, and takes long."""
        kept = start.memory
        seen.append((len(problem.v_free), [*(["k"] if kept.learnt.k == 7.0 else []), *kept.own]))
        memory = SolverState(learnt=Learnt(k=7.0), own={"own": np.ones(len(problem.v_free))})
        return Solution(start.impulse, None, EASY + 1, memory=memory)

    machine = towers("broad", "slender", steps=1)  # blocks 0 to 2 and 3 to 5
    made = machine.friction_problem()
    apart, start = made.problem, made.start
    bodies = apart.bodies.copy()
    bodies[np.flatnonzero((bodies == 3).any(axis=1) & (bodies == -1).any(axis=1))[0]] = [3, 2]
    touching = replace(apart, bodies=bodies)
    islands, met = Islands(solver, 6), REVIEW + 3
    for step in range(2 * REVIEW + 1):
        seen.clear()
        problem = touching if step == met else apart
        islands.link(problem, start.impulse, 1e-8)
        islands.solve(problem, Options(), start)
        if step == 0:
            assert seen == [(6, [])]  # not yet known to be hard
        elif step < REVIEW:
            assert seen == [(6, ["k", "own"])]
        elif step == REVIEW:
            assert seen == [(3, ["k"]), (3, [])]
        elif step < met:
            assert seen == [(3, ["k", "own"])] * 2
        elif step == met:
            assert seen == [(6, ["k"])]  # other blocks, so other factors
        elif step < 2 * REVIEW:
            assert seen == [(6, ["k", "own"])]
        else:
            assert seen == [(3, ["k"]), (3, [])]
    assert islands.count == 2


def test_easy_islands_and_those_at_rest_are_gathered_up_to_a_size():
    first, contacts = np.array([0, 2, 4, 6, 8, 10]), np.array([4, 4, 9, 4, 4, 4])
    root = np.repeat(first, 2)
    gather_islands(first, np.array([0, 1, 0, 0, HARD, 1]), contacts, 9, root)
    assert root[::2].tolist() == [0, 2, 4, 0, 8, 2]  # the third is as large as a group may be, the fifth is hard
    assert root[1::2].tolist() == root[::2].tolist()
