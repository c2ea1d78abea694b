# SPDX-License-Identifier: GPL-3.0-or-later
"""Vehicles: shares that sum to the axles, spreading in closed form, crossings, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from bridge_scenes import SPAN, bridge, grid

from loads.kinds.vehicle import VEHICLES, VehicleTable, strip_loads, vehicle
from masonry_cd.foundation.errors import parse_table


def table(**keys: object) -> VehicleTable:
    return parse_table(VehicleTable, {"kind": "vehicle", **keys}, "loads[0]")


@pytest.mark.parametrize("spread", ["2:1", "boussinesq"])
@pytest.mark.parametrize("keys", [{}, {"skew": 25.0}, {"strips": 3}])
@pytest.mark.parametrize("name", sorted(VEHICLES))
def test_what_the_bridge_bears_sums_to_the_axles(spread: str, keys: dict, name: str) -> None:
    made, _ = bridge(SPAN, SPAN, width=3.5, fill={"spread": spread}, **keys)
    asked = table(name=name, offset=0.2)
    _, load = strip_loads(asked, made.fills[0], np.array([3.7, 7.1]))
    assert load.sum(axis=1) == pytest.approx(sum(asked.known.loads), rel=2e-3)  # the rest is spread beyond the ends


def test_the_load_lies_under_the_axle_and_within_its_cone() -> None:
    made, _ = bridge(width=3.0, cover=1.0, fill={"spread": "boussinesq"})
    strips, load = strip_loads(table(axles=[1.0], contact=[0.2, 0.2]), made.fills[0], np.array([3.0]))
    middle = strips.ends.mean(axis=1)
    assert float(np.sum(load[0] * middle)) == pytest.approx(3.0, abs=1e-12)
    reach = 0.1 + strips.depth * math.tan(math.radians(30.0)) + np.ptp(strips.ends, axis=1)
    assert not load[0][np.abs(middle - 3.0) > reach].any()


def test_two_to_one_is_even_over_the_contact_and_the_depth() -> None:
    made, _ = bridge({"span": 20.0, "rise": 0.4, "thickness": 0.3, "voussoirs": 201}, width=3.0, cover=1.0, fill={"spread": "2:1"})
    strips, load = strip_loads(table(axles=[1.0], contact=[0.2, 0.2]), made.fills[0], np.array([10.0]))
    density = load[0] / np.ptp(strips.ends, axis=1)
    under = np.abs(strips.ends.mean(axis=1) - 10.0) < 0.5
    assert density[under] == pytest.approx(1.0 / 1.2, rel=3e-3)


def test_an_axle_in_the_middle_loads_a_strip_in_its_plane() -> None:
    made, assembly = bridge(width=3.0)
    part = vehicle(table(name="triple", position=3.0), grid(made, assembly), "loads[0]")
    assert max(abs(float(load.arm[1] + assembly.centre[load.block, 1])) for load in part.forces) < 1e-12


def test_a_crossing_comes_and_goes() -> None:
    made, assembly = bridge(width=3.0)
    own = grid(made, assembly, steps=1200, dt=0.01)
    part = vehicle(table(name="double", speed=1.0), own, "loads[0]")
    total = sum(-float(load.force[2]) * load.factor for load in part.forces)
    on = (own.times > 4.5) & (own.times < 5.0)  # both axles over the arch
    assert total[on] == pytest.approx(2 * 10.0 * 9810.0, rel=1e-3)
    assert total[-1] == 0.0
    assert float(np.abs(np.diff(total)).max()) < 0.1 * 2 * 98100.0  # no axle jumps onto the arch


def test_a_crossing_that_the_run_cuts_short_is_said() -> None:
    made, assembly = bridge(width=3.0)
    acted = vehicle(table(name="single", speed=1.0), grid(made, assembly, 100, 0.01), "loads[0]").acted
    assert acted is not None and acted.end == pytest.approx(9.0)
    assert len(acted.lines(1.0)) == 1 and not acted.lines(9.0)
