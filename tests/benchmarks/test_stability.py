# SPDX-License-Identifier: GPL-3.0-or-later
"""The stability sheet: what stands passes, what falls or is penetrated does not, and the table says which."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.counted_cost import OUTSIDE_SOLVER, counted
from benchmarks.ours import stepper
from benchmarks.scenes import arch, tower
from benchmarks.stability import DRIFT, StabilityCase, cases, main, row, run
from benchmarks.strong_shaking import rest_cases, strong_cases
from masonry_cd.mechanics.contact.find_joints import built_gap
from masonry_cd.mechanics.solvers import admm, interior, newton, nlgs


@pytest.fixture(scope="module")
def standing():
    return run(StabilityCase("time step", "tower of 3", replace(tower(3, amplitude=0.0), dt=5e-2), 20))


def test_a_tower_at_rest_passes(standing):
    assert standing.failures == []
    assert (standing.blocks, standing.steps, standing.stopped) == (3, 20, "")
    assert set(standing.limits) == {"drift", "penetration", "balance", "dissipation"}
    assert row(standing).endswith("| pass |")


def test_a_tower_that_overhangs_fails_by_its_drift():
    """Each block stands out by 0.4 of its side: the lowest joint is overturned by the two blocks above it."""
    made = tower(3, amplitude=0.0)
    leaning = tuple(replace(block, vertices=block.vertices + [0.2 * k, 0.0, 0.0]) for k, block in enumerate(made.blocks))
    fallen = run(StabilityCase("time step", "leaning", replace(made, blocks=leaning), 100))
    assert "drift" in fallen.failures
    assert fallen.drift > 100.0 * DRIFT
    assert "**FAIL**: drift" in row(fallen)


@pytest.mark.parametrize(
    ("change", "failure"),
    [
        ({"drift": 1e-5}, "drift"),
        ({"penetration": 1e-4}, "penetration"),
        ({"balance": 1e-3}, "balance"),
        ({"gained": 1e-2}, "dissipation"),
        ({"balance": np.nan}, "balance"),
        ({"stopped": "step 3: not finite"}, "finite"),
    ],
)
def test_every_measure_can_fail(standing, change, failure):
    assert replace(standing, **change).failures == [failure]


def test_what_is_shaken_may_drift(standing):
    shaken = replace(standing, at_rest=False, drift=0.3)
    assert shaken.failures == []
    assert "(3.0e-01)" in row(shaken)


def test_the_cases_span_what_the_head_says():
    found = list(cases())
    assert {case.scene.dt for case in found} >= {1e-4, 5e-2}
    accelerations = [2 * np.pi * case.scene.frequency * case.scene.amplitude / 9.81 for case in found]
    assert max(accelerations) == pytest.approx(5.0)
    assert max(case.scene.frequency for case in found) == 50.0
    assert max(case.scene.stiffness for case in found) == 1e13
    assert {case.scene.friction for case in found} >= {0.0, 10.0}
    assert len({case.name for case in found}) == len(found)


def test_ten_cases_in_space_are_shaken_hard():
    """Each in a plane by no means, at 0.5 to 2 g; two with gaps as built, one on elastic joints, one shaken upwards more than a little."""
    found = {name: scene for name, scene, _ in strong_cases()}
    machines = {name: stepper(scene, 2) for name, scene in found.items()}
    assert len(found) == 10
    assert all(machine.plane is None for machine in machines.values())
    peaks = [2 * np.pi * scene.frequency * scene.amplitude / 9.81 for scene in found.values()]
    assert pytest.approx(min(peaks)) == 0.5 and max(peaks) == pytest.approx(2.0)
    assert all(np.linalg.norm(scene.direction) == pytest.approx(1.0) for scene in found.values())
    assert sum(built_gap(machine.assembly) > 1e-7 for machine in machines.values()) == 2
    assert sum(scene.stiffness > 0.0 for scene in found.values()) == 1
    assert max(scene.direction[2] for scene in found.values()) > 0.5
    assert max(machine.assembly.count for machine in machines.values()) < 250  # the sheet stays a matter of minutes


def test_the_base_moves_along_the_direction_of_the_scene_and_no_peer_takes_it(tmp_path):
    machine = stepper(replace(tower(1), direction=(0.0, 0.6, 0.8)), 4)
    base = machine.system.loads.support_velocity[:, 0]
    assert base[3] == pytest.approx(tower(1).base_velocity(4)[3] * np.array([0.0, 0.6, 0.8]))
    assert base[3, 1] > 0.0
    with pytest.raises(ValueError, match="along x only"):
        replace(tower(1), direction=(0.0, 0.6, 0.8)).write(tmp_path / "scene.json", 4)


def test_gaps_as_built_pass_at_rest():
    name, scene, _ = next(iter(rest_cases()))
    found = run(StabilityCase("gaps", name, scene, 5))
    assert (found.failures, found.missed) == ([], 0)
    assert found.penetration < 1e-9 < built_gap(scene.assembly()) / 0.5  # the overlaps that it was built with are none of its own


def test_costs_of_steps_are_counted():
    """Equal in every run; a step without iterations costs what is next to them; nothing stays watched."""
    methods, costs = (admm, newton, interior, nlgs), []
    before = [method.solve for method in methods]
    for _ in range(2):
        machine = stepper(replace(arch(9), amplitude=0.5), 60)
        with counted() as cost:
            for _ in range(60):
                report = machine.step()
                cost.end_step(report.contacts)
                assert (cost.steps[-1] == OUTSIDE_SOLVER * report.contacts) == (report.iterations == 0)
        costs.append(cost)
    assert [method.solve for method in methods] == before
    assert costs[0].steps == costs[1].steps
    assert costs[0].worst == max(costs[0].steps[1:]) / np.median(costs[0].steps[1:]) > 1.0


def test_an_unknown_case_is_refused(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--only", "no such case"])
    assert ended.value.code == 2
    assert 'no case "no such case"' in capsys.readouterr().err
