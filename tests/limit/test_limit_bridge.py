# SPDX-License-Identifier: GPL-3.0-or-later
"""Effect of skew and rings on the load that a bridge bears, where statics gives it without a program."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from masonry_cd.analysis.limit.analysis import analyse
from masonry_cd.app.scene import parse_scene
from masonry_cd.app.scene_text import dump_toml
from masonry_cd.limit.case import limit_case

SPAN = {"span": 5.0, "rise": 1.5, "thickness": 0.45, "voussoirs": 9}


def factor(load: dict[str, Any], friction: Any, span: dict[str, Any] = SPAN, **keys: Any) -> float:
    structure = {"kind": "bridge", "spans": [span], "width": 2.0, "fill": {"passive": 0.0}, **keys}
    scene = {
        "structure": structure,
        "material": {"density": 2000.0, "friction": friction},
        "loads": [load],
        "limit": {"live": [0], "starts": 0},
    }
    analysis = limit_case(parse_scene(dump_toml(scene), Path("bridge.toml"))).whole.analysis
    assert analysis.stands
    return analysis.associated.factor


@pytest.mark.parametrize("skew", [20.0, 45.0])
def test_skew_changes_nothing_where_joints_do_not_slide(skew: float) -> None:
    """Slanting by x' = x + y tan(skew) maps equilibrium under upright loads onto equilibrium, and hinge lines onto hinge lines."""
    load = {"kind": "point", "block": "arch1.v3", "force": [0.0, 0.0, -1e4]}
    assert factor(load, 3.0, skew=skew) == pytest.approx(factor(load, 3.0), rel=1e-5)


def test_skew_lets_joints_slide_below_the_tangent_of_its_angle() -> None:
    load = {"kind": "point", "block": "arch1.v3", "force": [0.0, 0.0, -1e4]}
    assert factor(load, 0.5, skew=30.0) < 0.9 * factor(load, 0.5)


def test_rings_bear_less_than_one_and_more_the_less_they_slide() -> None:
    load = {"kind": "vehicle", "axles": [1e4], "position": 1.25, "across": "line"}
    rings = {**SPAN, "rings": 2}
    smooth, rough = (factor(load, {"default": 0.7, "arch1_ring1-arch1_ring2": mu}, rings) for mu in (0.05, 0.7))
    one = factor(load, 0.7)
    thin = factor(load, 0.7, {**SPAN, "thickness": 0.225}, cover=0.525)  # a ring alone under the road of both
    assert thin < smooth < rough < one


def test_at_collapse_walls_and_backs_are_pressed_by_the_active_pressure() -> None:
    """A wall about to move away has K_a, whatever pressed it at rest."""
    load, solid = {"kind": "vehicle", "axles": [1e4], "position": 1.25, "across": "line"}, [{"rigid": False, "height": 1.5}]
    rest, active, none = (factor(load, 0.7, abutments=solid, fill={"passive": 0.0, "pressure": p}) for p in ("at_rest", "active", "none"))
    assert rest == active
    assert abs(none - active) > 1e-3 * active


def test_under_a_push_the_fill_is_shaken_by_the_factor_itself() -> None:
    """With K_AE and K_PE at the factor found, the factor is that; and less than with a fill that is not shaken."""
    text = """
[structure]
kind = "bridge"
width = 3.0
cover = 0.4
spans = [{span = 4.0, rise = 1.5, thickness = 0.5, voussoirs = 7}]
abutments = [{rigid = false, height = 2.0, width = 1.5}]
[material]
density = 2200.0
friction = 0.6
[limit]
push = "x"
starts = 0
"""
    whole = limit_case(parse_scene(text, Path("shaken.toml"))).whole
    assert whole is not None
    factor = whole.analysis.associated.factor
    structure = whole.structure
    at_it, still = (analyse(structure.assembly, structure.joints, structure.loads(shaken_by=by).at()) for by in (factor, 0.0))
    assert at_it.associated.factor == pytest.approx(factor, rel=2e-4)
    assert factor < 0.98 * still.associated.factor
    assert any("Mononobe" in note for note in whole.loads.notes)


def test_a_wide_bridge_bears_on_a_strip_what_one_as_wide_as_the_strip_bears() -> None:
    """Of bridges as wide as the strip at the crown, and at the springings, which it lies between."""
    wheels = {"kind": "vehicle", "axles": [1e4], "position": 1.25, "offset": 1.0}
    found = factor(wheels | {"across": "strip"}, 0.7, width=8.0, cover=0.3)
    crown, springing = 2.0 * (0.3 + 0.3), 1.8 + 0.3 + 0.3 + 1.5 + 0.45  # where each wheel has its own, and where they meet
    least, most = (factor(wheels | {"across": "line", "offset": 0.0}, 0.7, width=wide, cover=0.3) for wide in (crown, springing))
    assert least < found < most
    edge = factor(wheels | {"across": "strip", "offset": 2.9}, 0.7, width=8.0, cover=0.3)
    assert edge < found
    whole = factor(wheels | {"across": "line"}, 0.7, width=8.0, cover=0.3)
    assert whole > 2.0 * found


def test_wheels_that_press_backs_leave_a_bridge_in_its_plane() -> None:
    """Those of a vehicle in the middle of the road, on an abutment of blocks behind which it stands."""
    scene = {
        "structure": {
            "kind": "bridge",
            "spans": [SPAN],
            "width": 3.0,
            "abutments": [{"rigid": False, "height": 1.5}],
            "backing": {"height": 0.6},
        },
        "material": {"density": 2000.0, "friction": 0.6},
        "loads": [{"kind": "vehicle", "name": "double", "position": 0.1}],
        "limit": {"live": [0], "starts": 0},
    }
    whole = limit_case(parse_scene(dump_toml(scene), Path("bridge.toml"))).whole
    assert whole is not None and whole.analysis.problem.axis is not None
    pressed = {whole.assembly.groups[whole.assembly.group_of[b]] for b in np.flatnonzero(np.abs(whole.loads.live[:, 0]) > 1.0)}
    assert pressed & {"abutment1", "backing"}
