# SPDX-License-Identifier: GPL-3.0-or-later
"""Assessments of bridges: assumptions on their fill are varied one by one, and each level is a scene that limit analysis takes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from masonry_cd.app.scene import Scene, parse_scene
from masonry_cd.app.scene_text import dump_toml
from masonry_cd.limit.case import limit_case
from masonry_cd.studies.assess.command import check_statics
from masonry_cd.studies.assess.plan import AssessPlan
from masonry_cd.studies.study.checks import scene_of_run

BRIDGE: dict[str, Any] = {
    "structure": {
        "kind": "bridge",
        "abutments": [{"rigid": False, "width": 2.0}],
        "spans": [{"span": 4.0, "rise": 1.2, "thickness": 0.4, "voussoirs": 7, "rings": 2}],
    },
    "material": {"density": 2000.0, "friction": 0.6},
    "loads": [{"kind": "vehicle", "axles": [1e5], "position": 1.0}],
    "limit": {"live": [0], "starts": 1},
    "run": {"dt": 2e-3, "duration": 0.5},
}


def scene(**changes: Any) -> Scene:
    return parse_scene(dump_toml(BRIDGE | changes), Path("bridge.toml"), called="bridge")


def test_fill_block_size_and_rings_of_a_bridge_are_varied_and_the_load_factor_follows_them() -> None:
    plan = AssessPlan(scene())
    assert {one.name: [level.name for level in one.levels] for one in plan.known} == {
        "friction": ["0.48", "0.72"],
        "block size": ["x 0.7", "x 1.4"],
        "bond": ["rings as one"],
        "fill resistance": ["none", "twice"],
        "fill spread": ["2:1"],
        "fill pressure": ["active", "none"],
        "fill angle": ["25 degrees", "35 degrees"],
    }
    by_level = {tuple(part.values().items()): run for part, run in zip(plan.parts, plan.runs, strict=True) if part.kind == "level"}
    factors = [
        limit_case(scene_of_run(plan.maker.tables(by_level[(level,)].asked))).whole.analysis.governing.factor
        for level in (("fill resistance", "none"), ("fill angle", "25 degrees"), ("fill angle", "35 degrees"), ("fill resistance", "twice"))
    ]
    assert factors == sorted(factors)
    assert factors[0] < 0.9 * factors[-1]


def test_what_has_no_effect_is_left_out_with_the_reason() -> None:
    structure = {**BRIDGE["structure"], "abutments": [{"rigid": True}]}
    plan = AssessPlan(scene(structure=structure, loads=[], limit={"push": "x"}, assess={"leave_out": ["fill angle"]}))
    left = {one.name: one.why for one in plan.left_out}
    assert left["fill spread"] == "no vehicle stands on it"
    assert left["fill pressure"] == "it presses nothing that may move"
    assert left["fill angle"] == "left out by the scene, assess.leave_out"
    assert "fill resistance" in [one.name for one in plan.known]


@pytest.mark.parametrize("vehicle", [{"position": 1.0}, {}])
def test_statics_are_checked_with_the_fill_and_with_a_vehicle_that_has_no_place_yet(vehicle: dict[str, float]) -> None:
    check_statics(AssessPlan(scene(loads=[{"kind": "vehicle", "axles": [1e5], **vehicle}])))
