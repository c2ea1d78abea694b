# SPDX-License-Identifier: GPL-3.0-or-later
"""analysis/code_check: every formula with its numbers put in comes to the value that the check used; hand checks."""

from __future__ import annotations

import math

import numpy as np
import pytest
from test_code_check import BUILDING, PARAMETERS, checked

from masonry_cd.analysis.code_check.steps import Step, with_numbers
from masonry_cd.analysis.limit.oscillator import Oscillator

HELD = {"height": 6.0, "building_height": 10.0, "building_period": 0.3}
CASES = {
    "ground": {"spectrum": "NTC", **PARAMETERS},
    "soil of rock": {"spectrum": "NTC", **PARAMETERS, "ground": "A", "topography": "T3"},
    "collapse": {"spectrum": "NTC", **PARAMETERS, "limit_state": "SLC"},
    "damage": {"spectrum": "EC8", "ag": 0.5, "limit_state": "SLD"},
    "free to vibrate": {"spectrum": "EC8", "ag": 1.5, "element_period": 0.1},
    "height": {"spectrum": "NTC", **PARAMETERS, **BUILDING, "ground": "D"},
    "height, slow building": {"spectrum": "EC8", "ag": 1.5, **BUILDING, "building_period": 2.1, "building_damping": 0.1},
    "height, free to vibrate": {"spectrum": "EC8", "ag": 1.5, **BUILDING, "element_period": 0.06},
    "participation": {"spectrum": "EC8", "ag": 1.5, **HELD, "participation": 1.1},
    "older": {"code": "NTC2008", "spectrum": "EC8", "ag": 1.5, **BUILDING},
    "older, on the ground": {"code": "NTC2008", "spectrum": "NTC", **PARAMETERS},
    "Eurocode": {"code": "EC8", "spectrum": "EC8", "ag": 1.5, **HELD, "element_period": 0.06},
    "of 2024": {"spectrum": "EC8-2024", "s_alpha": 4.0, "s_beta": 1.5, "ground": "C"},
    "of 2024, rock, free to vibrate": {"spectrum": "EC8-2024", "s_alpha": 4.0, "s_beta": 1.5, "element_period": 0.03},
    "ASCE": {"spectrum": "ASCE7", "s_ds": 6.0, "s_d1": 3.0, "t_l": 6.0, **BUILDING},
    "New Zealand": {"spectrum": "NZS1170", "hazard_factor": 0.2, "ground": "D", "fault_distance": 5e3, "limit_state": "SLC"},
    "New Zealand, free to vibrate": {"spectrum": "NZS1170", "hazard_factor": 0.2, "return_factor": 1.3, "element_period": 0.05},
    "table": {"spectrum": "table", "table": {"period": [0, 0.1, 0.5, 4], "acceleration": [1.5, 3.5, 3.5, 0.3]}},
    "table, height": {"spectrum": "table", "table": {"period": [0.1, 0.5, 4], "acceleration": [3.5, 3.5, 0.3]}, "ag": 1.5, **BUILDING},
    "Eurocode, on the ground": {"code": "EC8", "spectrum": "NTC", **PARAMETERS},
}
KNOWN = {"sqrt": math.sqrt, "max": max, "min": min, "pi": math.pi}


@pytest.mark.parametrize("keys", CASES.values(), ids=list(CASES))
def test_each_line_comes_to_the_value_that_the_check_used(keys):
    made, _ = checked(**keys)
    pairs = [(step, line) for step, line in zip(made.steps, with_numbers(made.steps), strict=True) if line]
    assert len(pairs) >= 6
    for step, line in pairs:
        symbol, formula, numbers, result = line.split(" = ")
        assert (symbol, formula) == (step.symbol, step.formula)
        assert result == f"{float(result.split()[0]):.4g} {step.unit}".strip() or abs(step.value) >= 1e4
        assert eval(numbers.replace(" x ", " * ").replace("^", "**"), {"__builtins__": {}}, KNOWN) == pytest.approx(step.value, rel=5e-3)
    assert [one["line"] for one in made.numbers()["steps"] if one["line"]] == [line for _, line in pairs]
    assert sorted(line for lines in made.worked.values() for line in lines) == sorted(line for _, line in pairs)


def test_demand_and_capacity_are_steps_and_every_symbol_has_one_value_in_a_check():
    made, value = checked(**CASES["height"])
    linear, displaced = made.verdicts
    assert (linear.capacity, linear.demand) == (value["a0*"], value["a asked"])
    assert (displaced.capacity, displaced.demand, displaced.period) == (value["dSLV"], value["d asked"], value["TSLV"])
    assert displaced.unmoved == value["a0* / a"]
    for symbol in ("g", "ag", "F0", "TC*", "SS", "ST", "CC", "S", "TB", "TC", "TD", "eta", "xi", "q", "CF", "z", "H", "gamma1", "psi1(z)"):
        assert len([step for step in made.steps if step.symbol == symbol]) == 1, symbol


def test_symbols_that_begin_alike_stay_apart():
    values = [Step("sum P", 3.0, "N", "", ""), Step("sum P d", 5.0, "N", "", ""), Step("d", 7.0, "", "", "")]
    *_, line = with_numbers([*values, Step("e", 1.0, "", "", "", "sum P d d / sum P")])
    assert line == "e = sum P d d / sum P = 5 x 7 / 3 = 1"


SITE = {"spectrum": "NTC", "ag": 1.8, "f0": 2.42, "tc_star": 0.33, "ground": "C"}


def block(height: float, thickness: float, mass: float, control: float) -> Oscillator:
    """The oscillator of a block that overturns about its foot; the control point is on its axis, at a height."""
    weight, share, slope = 9.81 * mass, 0.5 * height / control, thickness / height
    turn = np.linspace(0.0, math.atan(slope), 400)
    moved = control * np.sin(turn) + 0.5 * thickness * (1.0 - np.cos(turn))
    return Oscillator(slope, 9.81, weight, share * weight, share**2 * weight, moved, np.tan(math.atan(slope) - turn))


def test_a_garden_wall_by_hand():
    """2.4 x 3.0 x 0.45 m of 1900 kg/m3 on a ridge, with g = 9.81 in SS, TD and a0* alike; the top course is 0.5 m high."""
    made, value = checked(block(3.0, 0.45, 1900.0 * 2.4 * 3.0 * 0.45, 2.75), topography="T2", **SITE)
    known = {"M*": 6156.0, "alpha0": 0.150, "e*": 1.0, "a0*": 1.090, "ag S": 3.0965, "TSLV": 1.958, "d asked": 0.1628, "dSLV": 0.08955}
    for symbol, by_hand in known.items():
        assert value[symbol] == pytest.approx(by_hand, rel=5e-4), symbol
    assert "a0* = alpha0 g / (e* CF) = 0.15 x 9.81 / (1 x 1.35) = 1.09 m/s2" in made.worked["mechanism"]


def test_a_gable_and_a_parapet_by_hand():
    """A gable on a wall of 3 m, and a parapet on a roof 6.4 m up: aZ by [C7.2.7], over q = 2."""
    _, gable = checked(height=3.0, building_height=5.4, building_period=0.18, storeys=1, **SITE)
    assert gable["a asked"] == pytest.approx(1.743, rel=5e-4)
    _, parapet = checked(height=6.4, building_height=6.4, building_period=0.2, storeys=2, **SITE)
    assert parapet["aZ"] == pytest.approx(7.531, rel=5e-4)
