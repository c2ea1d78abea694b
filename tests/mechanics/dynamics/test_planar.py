# SPDX-License-Identifier: GPL-3.0-or-later
"""Which scenes are planar, and that solving them as such gives the same motion."""

import numpy as np
import pytest
from models import advance, box, gravity, ground, stepper, still, tower, turned, wall

from masonry_cd.mechanics.dynamics.planar import find_plane
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.state import State


def plane_of(blocks, velocity=None, start=None):
    assembly = Assembly.from_blocks(blocks, 0.6)
    state = State.at_rest(assembly) if start is None else start(assembly)
    return find_plane(assembly, state, still(3) if velocity is None else velocity, gravity(3))


def test_a_wall_shaken_along_is_planar_and_shaken_across_is_not():
    along, across, both = still(3), still(3), still(3)
    along[1, 0, 0], across[1, 0, 1] = 1.0, 1.0
    both[1, 0, :2] = 1.0
    assert plane_of(wall(3, 3), along).axis == 1
    assert plane_of(wall(3, 3), across) is None
    assert plane_of(wall(3, 3), both) is None


def test_what_breaks_the_symmetry_is_seen():
    aside = [*tower(2), box("aside", (-0.2, -0.1, 0.5), (0.2, 0.2, 0.7))]
    assert plane_of(aside).axis == 0  # still symmetric about x = 0, no longer about y = 0
    assert plane_of([ground(), box("a", (0.0, 0.0, 0.0), (1.0, 1.0, 1.0))]) is None
    tilted = plane_of(tower(2), start=lambda a: turned(a, 2, (0.0, 1.0, 0.0), 0.01, (0.25, 0.0, 0.25)))
    assert tilted.axis == 1
    assert plane_of(tower(2), start=lambda a: turned(a, 2, (0.0, 0.0, 1.0), 0.01, (0.0, 0.0, 0.0))) is None  # about an axis in the plane


@pytest.mark.parametrize("axis", range(3))
def test_friction_acts_in_any_plane(axis):
    """A cube on a face, pressed on it and pushed along it: s = (push - mu pull) t^2 / 2, whatever the normal of the plane it moves in."""
    along, down = [d for d in range(3) if d != axis]
    push, pull, mu, steps = 3.0, 10.0, 0.2, 200
    acceleration = np.zeros(3)
    acceleration[along], acceleration[down] = push, -pull
    low, high = np.full(3, -0.5), np.full(3, 0.5)
    plate_low, plate_high = np.full(3, -5.0), np.full(3, 5.0)
    plate_low[axis], plate_high[axis] = -0.5, 0.5
    plate_low[down], plate_high[down] = -1.0, -0.5
    blocks = [box("plate", tuple(plate_low), tuple(plate_high), fixed=True), box("cube", tuple(low), tuple(high))]
    run = stepper(blocks, steps, friction=mu, acceleration=gravity(steps, tuple(acceleration)))
    advance(run, steps)
    assert run.plane is not None
    assert run.plane.axis == axis
    assert run.state.position[1, along] == pytest.approx(0.5 * (push - mu * pull) * 0.2**2, rel=1e-6)


@pytest.mark.parametrize("axis", [0, 1])
def test_planar_and_spatial_runs_agree(axis):
    steps, turn = 150, slice(None) if axis == 1 else [1, 0, 2]
    velocity = still(steps)
    velocity[:, 0, 1 - axis] = 0.5 * np.sin(2 * np.pi * 4.0 * np.arange(steps + 1) * 1e-3)
    blocks = [box(b.name, tuple(b.vertices.min(axis=0)[turn]), tuple(b.vertices.max(axis=0)[turn]), b.fixed) for b in wall(2, 3)]
    ends = []
    for planar in (True, False):
        run = stepper(blocks, steps, support_velocity=velocity, planar=planar, solver="admm", tolerance=1e-9)
        reports = [run.step() for _ in range(steps)]
        assert max(report.error for report in reports) <= 1e-9
        assert (run.plane.axis if run.plane else None) == (axis if planar else None)
        ends.append((run.state.position.copy(), run.state.orientation.copy(), reports[-1].contacts))
    assert ends[0][2] * 2 == ends[1][2]
    assert ends[0][0] == pytest.approx(ends[1][0], abs=1e-8)
    assert ends[0][1] == pytest.approx(ends[1][1], abs=1e-8)
