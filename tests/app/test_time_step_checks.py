# SPDX-License-Identifier: GPL-3.0-or-later
"""Warnings about the time step: the number and the block that it is too coarse for, and silence where it is not."""

from __future__ import annotations

import json

import numpy as np
import pytest
from command_line import masonry_cd
from made_run import at_rest, box, shifted, write_run
from models import box as cuboid
from models import ground, stepper, still

from masonry_cd.app.time_step_checks import after_run, before_run, dominant_frequency, fastest
from masonry_cd.io.results import Results
from masonry_cd.mechanics.dynamics.moreau_jean import RunStopped
from masonry_cd.mechanics.model.blocks import Assembly, Block

PLATE = box("plate", (-2, -2, -1), (2, 2, 0), fixed=True)


def assembly(*sizes: float) -> Assembly:
    """Cubes on a plate, of some edge lengths."""
    cubes = [box(f"cube{k}", (k, 0, 0), (k + size, size, size)) for k, size in enumerate(sizes)]
    return Assembly.from_blocks([PLATE, *cubes], 0.5)


def shaking(frequency: float, step: float, steps: int = 4000) -> np.ndarray:
    velocity = still(steps)
    velocity[:, 0, 0] = 0.1 * np.sin(2 * np.pi * frequency * step * np.arange(steps + 1))
    return velocity


@pytest.mark.parametrize(("frequency", "step"), [(2.0, 1e-3), (12.0, 4e-3), (50.0, 2e-3)])
def test_the_frequency_of_a_sine_is_found(frequency, step):
    assert dominant_frequency(shaking(frequency, step), step) == pytest.approx(frequency, rel=0.02)


def test_the_band_of_a_noise_is_found():
    """White acceleration up to 30 Hz has 95 % of its mean square below 28.5 Hz."""
    rng, step, steps = np.random.default_rng(1), 1e-3, 20_000
    spectrum = np.fft.rfft(rng.normal(size=steps))
    spectrum[np.fft.rfftfreq(steps, step) > 30.0] = 0.0
    velocity = still(steps)
    velocity[1:, 0, 1] = step * np.cumsum(np.fft.irfft(spectrum))
    assert dominant_frequency(velocity, step) == pytest.approx(28.5, rel=0.04)


def test_a_base_that_stands_still_has_no_frequency():
    assert dominant_frequency(still(10), 1e-3) == 0.0
    assert before_run(assembly(1.0), still(10), 9.81, 1e-3) == []


def test_shaking_that_the_step_does_not_follow_is_reported():
    (line,) = before_run(assembly(5.0), shaking(20.0, 1e-2), 9.81, 1e-2)
    assert "below 20 Hz, of which a period has 5 steps; 10 need dt 0.005" in line
    assert before_run(assembly(5.0), shaking(9.0, 1e-2), 9.81, 1e-2) == []


def test_the_block_that_rocks_too_fast_is_named():
    """The smaller cube, R = 0.1 sqrt(3) / 2 m, p = 9.2 1/s."""
    (line,) = before_run(assembly(1.0, 0.1), still(10), 9.81, 5e-3)
    assert 'block "cube1"' in line
    assert "p = 9.22 1/s (R 86.6 mm), p dt is 0.046; 0.03 needs dt 0.003" in line
    assert before_run(assembly(1.0, 0.1), still(10), 9.81, 3e-3) == []


def test_a_block_that_could_pass_through_another_is_named(tmp_path):
    cubes = [box("thin", (0, 0, 0), (0.5, 0.5, 0.02)), box("cube", (1, 0, 0), (1.5, 0.5, 0.5))]
    state = at_rest([PLATE, *cubes])
    state.velocity[2, :3] = (0.0, 3.0, -4.0)
    write_run(tmp_path / "r.h5", [PLATE, *cubes], [at_rest([PLATE, *cubes]), shifted(state, 2, (0, 0, 1))])
    made = Assembly.from_blocks([PLATE, *cubes], 0.6)
    with Results.open(tmp_path / "r.h5") as results:
        (line,) = after_run(made, results, 2e-3)
        assert after_run(made, results, 1e-3) == []
    assert 'block "cube" moves at 5 m/s at 0.1 s, by 0.5 of the width of "thin" (20 mm) in one step' in line
    assert "dt 0.001 is safe" in line


def test_warnings_are_printed_and_kept(block_on_plate, tmp_path):
    scene = block_on_plate(dt="dt = 0.02", amplitude="amplitude = 0.1").read_text().replace("frequency = 2.0", "frequency = 6.0")
    (tmp_path / "scene.toml").write_text(scene)
    result = masonry_cd("run", tmp_path / "scene.toml", "-o", tmp_path / "out", "-q")
    assert result.exit_code == 0
    kept = json.loads((tmp_path / "out" / "summary.json").read_text())["warnings"]
    assert [f"masonry-cd: warning: {line}" for line in kept] == [
        line for line in result.stderr.splitlines() if line.startswith("masonry-cd")
    ]
    assert any("coarse for the shaking" in line for line in kept)


def test_a_run_that_breaks_down_names_step_block_and_contact():
    machine = stepper([ground(), cuboid("low", (0, 0, 0), (1, 1, 1)), cuboid("high", (0, 0, 1), (1, 1, 2))], 10)
    machine.step()
    solve = machine.islands.solver

    def broken(problem, options, start):
        found = solve(problem, options, start)
        found.impulse[-1] = np.nan  # a contact of the upper joint
        return found

    machine.islands.solver = broken
    with pytest.raises(
        RunStopped, match=r'^step 2: the velocity of block "\w+" is not finite; the impulse of a contact between "'
    ) as stopped:
        machine.step()
    assert stopped.match('"high"')


@pytest.mark.parametrize("drop", [box("drop", (3, 0, 0), (3.2, 0.2, 0.2)), Block.sphere("drop", np.array([3.1, 0.1, 0.1]), 0.1)])
def test_what_falls_past_the_supports_is_not_looked_at(drop, tmp_path):
    """A stone and a ball beside the plate fall at 30 m/s: above its lower side they may meet something, far below it nothing."""
    blocks, found = [PLATE, box("stone", (0, 0, 0), (1, 1, 1)), drop], []
    for depth in (0.5, 45.0):
        state = shifted(at_rest(blocks), 2, (0, 0, -depth))
        state.velocity[2, 2] = -30.0
        with Results.open(write_run(tmp_path / "r.h5", blocks, [state])) as results:
            found.append(fastest(Assembly.from_blocks(blocks, 0.5), results)[0])
            assert bool(after_run(Assembly.from_blocks(blocks, 0.5), results, 1e-2)) == (depth < 1.0)
    assert found == [30.0, 0.0]


def test_speeds_are_relative_to_a_support_that_stays(tmp_path):
    """Of two supports the first sinks at 2 m/s; the stone on the other stands still, whatever the first does."""
    sinks, stays = box("sinks", (-3, 0, -1), (-2, 1, 0), fixed=True), box("stays", (0, 0, -1), (1, 1, 0), fixed=True)
    blocks = [sinks, stays, box("stone", (0, 0, 0), (1, 1, 1))]
    states = [at_rest(blocks), shifted(at_rest(blocks), 0, (0, 0, -0.2))]
    for state in states:
        state.velocity[0, 2] = -2.0
    path = write_run(tmp_path / "r.h5", blocks, states)
    with Results.open(path) as results:
        assert fastest(Assembly.from_blocks(blocks, 0.5), results) == (0.0, 2, 0.0)
