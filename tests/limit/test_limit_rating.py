# SPDX-License-Identifier: GPL-3.0-or-later
"""[limit.rating]: the axle load of a vehicle with the factor asked, by the limit analysis of a scene that states the same."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from loads.kinds.vehicle import TONNE, VEHICLES
from masonry_cd.app.scene import Scene, parse_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.limit.case import limit_case
from masonry_cd.limit.rating import RESTRICTIONS, Rated, Rating

TEXT = """
[structure]
kind = "bridge"
width = 3.0
cover = 0.4
spans = [{span = 4.0, rise = 1.2, thickness = 0.4, voussoirs = 7}]
[structure.fill]
friction_angle = 35.0
[material]
density = 2100.0
friction = 2.0
[[loads]]
kind = "vehicle"
axles = [50e3, 80e3]
spacing = [2.0]
offset = 0.2
[limit]
live = [0]
starts = 0
positions = 6
[limit.rating]
factor = 2.0
vehicles = ["single"]
"""


def scene(*changes: str, text: str = TEXT) -> Scene:
    return parse_scene(text, Path("bridge.toml"), list(changes))


def test_an_axle_may_weigh_what_makes_its_load_factor_the_one_asked() -> None:
    """Of a bridge that states all: the vehicle with the axles of its rating has the factor asked."""
    stated = ("structure.fill.passive=0.2", 'structure.fill.spread="2:1"', "material.masonry={kind='solid brick', crushing=false}")
    found = limit_case(scene(*stated, "limit.rating.vehicles=['single']")).rating
    assert found is not None and [row.vehicle for row in found.rows] == ["loads[0]", "single"]
    own = found.rows[0]
    assert own.axles == (50e3, 80e3) and own.axle_load is not None and own.ratio is not None
    for row in found.rows:
        assert row.decides == "as the scene states it" and row.factor == row.computed and row.gives_way == ("arch1",)
    heavier = [f"loads[0].axles={[own.ratio * load for load in own.axles]}", "limit.rating.factor=1.0"]
    assert limit_case(scene(*stated, *heavier)).whole.analysis.governing.factor == pytest.approx(2.0, rel=1e-3)
    single = parse_scene(TEXT.replace("axles = [50e3, 80e3]\nspacing = [2.0]", 'name = "single"'), Path("b.toml"), [*stated])
    borne = limit_case(single).whole.analysis.governing.factor
    assert found.rows[1].factor == pytest.approx(borne, rel=1e-9)
    assert found.rows[1].axle_load == pytest.approx(borne / 2.0 * 11.5 * TONNE, rel=1e-9)


def test_what_the_scene_leaves_open_is_assumed_against_the_bridge_as_in_its_verdict() -> None:
    case = limit_case(scene())
    found, decides = case.rating, case.assumed.decides
    assert found is not None and decides is not None and decides.factor is not None
    own = found.rows[0]
    assert own.computed == pytest.approx(case.whole.analysis.governing.factor, rel=1e-9)
    assert own.factor == pytest.approx(decides.factor, rel=2e-3) and own.factor < 0.9 * own.computed
    assert "passive pressure" in own.decides and "structure.fill.passive=0" in own.key
    again = limit_case(scene(*own.key.split(), "limit.rating.factor=1")).whole
    assert again is not None and again.analysis.governing.factor == pytest.approx(own.factor, rel=5e-3)  # places 1/400 apart


def test_the_level_is_the_heaviest_of_which_every_axle_is_borne() -> None:
    def level(**tonnes: float) -> str | None:
        factors = dict.fromkeys(VEHICLES, 1.0) | {name.replace("_", " "): t for name, t in tonnes.items()}
        rows = [Rated(name, VEHICLES[name].loads, 1.0, factor=factor) for name, factor in factors.items()]
        return Rating(1.0, tuple(rows)).level

    assert level() == "normal traffic"
    assert level(triple=0.99) == "33 t"  # which has no triple axles
    assert level(single=9.0 / 11.5) == "13 t" and level(single=8.9 / 11.5) == "10 t" and level(single=0.1) is None
    only = Rating(1.0, (Rated("single", VEHICLES["single"].loads, 1.0, factor=1.0),))
    assert only.level == "18 t"  # its single axle alone was looked at
    for name, tonnes in RESTRICTIONS["normal traffic"].items():
        assert VEHICLES[name].loads[0] == pytest.approx(tonnes * TONNE)


def test_a_rating_needs_a_live_vehicle_and_one_that_does_not_fit_the_road_says_so() -> None:
    pushed = replace(scene(), limit={"push": "x", "rating": {"factor": 2.0}})
    with pytest.raises(InputError, match=r"limit\.rating.*rates vehicles"):
        limit_case(pushed)
    found = limit_case(scene("structure.width=2.4", "loads[0].offset=0.1", "limit.rating.vehicles=['LM2','single']")).rating
    assert found is not None
    wide = found.rows[1]
    assert wide.vehicle == "LM2" and wide.factor is None and "next to the road" in wide.line
    assert found.rows[2].factor is not None
    with pytest.raises(InputError, match="factor"):
        limit_case(scene("limit.rating.factor=0"))
