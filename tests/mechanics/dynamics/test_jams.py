# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps without a solution: the linear program proves it, and the run names the supports that close and the blocks between them."""

from dataclasses import replace

import numpy as np
import pytest
import scenes
from models import box, gravity, ground, still

from masonry_cd.app.run_loop import RunPlan, run
from masonry_cd.app.run_report import RunReport
from masonry_cd.io.result_writer import ResultWriter
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.dynamics.jams import Closing, find_jam
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly

STEPS = 20


def pressed(speed_left: float, speed_right: float, stones: int = 1) -> Stepper:
    """Stones in a row on the ground between two jaws of a vice, which move towards each other, each at a speed [m/s]."""
    row = [box(f"stone{k}", (k, -0.5, 0.0), (k + 1.0, 0.5, 1.0)) for k in range(stones)]
    left = box("left", (-0.2, -0.5, 0.1), (0.0, 0.5, 0.9), fixed=True)
    right = box("right", (stones, -0.5, 0.1), (stones + 0.2, 0.5, 0.9), fixed=True)
    assembly = Assembly.from_blocks([ground(), left, right, *row], 0.5)
    moves = np.zeros(assembly.count, dtype=np.int64)
    moves[1], moves[2] = 1, 2
    velocity = np.repeat(still(STEPS), 3, axis=1)
    velocity[1:, 1, 0], velocity[1:, 2, 0] = speed_left, -speed_right
    settings = Run(dt=1e-3, duration=1e3, solver="auto", tolerance=1e-8, max_iterations=200)
    return Stepper(replace(assembly, support_of=moves), velocity, gravity(STEPS), settings)


@pytest.mark.parametrize(("left", "right", "jam"), [(0.1, 0.1, 0.1), (0.3, 0.0, 0.15), (0.1, -0.1, 0.0), (-0.1, 0.0, 0.0)])
def test_the_least_closing_speed_is_half_of_what_the_jaws_close_by(left, right, jam):
    """Whatever the stone does, one of the jaws keeps closing at half the sum of their speeds; a stone that can give way is not a jam."""
    machine = pressed(left, right)
    made = machine.friction_problem()
    problem, blocks = made.problem, made.rows.blocks
    found = find_jam(Closing(problem, blocks, int(np.argmin(problem.offset[:, 0])), max(abs(left), abs(right))))
    assert (found is not None) == (jam > 0.0)
    if found is not None:
        assert found.speed == pytest.approx(jam, rel=1e-6)
        assert found.blocks == (1, 2, 3)  # the jaws and the stone, not the ground


def test_blocks_between_jaws_are_named():
    machine = pressed(0.1, 0.1, stones=4)
    closing = machine.step().closing
    assert closing is not None
    assert closing.speed >= 0.2 / 5 * (1.0 - 1e-6)  # shared by five joints at best
    jam = find_jam(closing)
    assert jam is not None
    said = '"left" and "right" close on "stone0", "stone1", "stone2" and 1 more with 40 mm/s or more in a contact'
    assert jam.in_words(machine.assembly) == said


def test_a_run_reports_its_jam_and_what_gives_way_is_none(tmp_path):
    reports = []
    for right in (0.1, -0.1):
        machine = pressed(0.1, right)
        joints = find_joints(machine.assembly)
        with ResultWriter(tmp_path / f"{right}.h5", machine.assembly, joints) as writer:
            reports.append(run(machine, joints, writer, RunPlan(STEPS)))
    closed, pushed = reports
    assert closed.steps_closing == closed.steps_missed == STEPS
    assert '"left" and "right" close on "stone0"' in closed.jam
    assert (pushed.steps_closing, pushed.jam) == (0, "")


def test_a_deep_overlap_names_its_blocks():
    report, machine = RunReport(), pressed(2.0, 2.0)
    for _ in range(STEPS):
        step = machine.step()
        report.look(step, machine)
        report.add(step, 1e-8, machine.energy)
    assert report.penetration_max > 0.02
    assert set(report.penetration_where.split('"')) & {"left", "right"}
    assert "stone0" in report.penetration_where


def test_a_supported_wall_is_no_jam():
    """From rest on a still support there is a solution, whatever contact one asks about."""
    problem = scenes.wall(4, 5)
    assert find_jam(Closing(problem, problem.bodies, 7, 1e-3)) is None
