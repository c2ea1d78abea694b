# SPDX-License-Identifier: GPL-3.0-or-later
"""[limit.service]: thrust within the middle third, and stresses within a share of the strength, by a programme of their own."""

from __future__ import annotations

from pathlib import Path

import pytest
from test_limit_assumed import DEEP_ARCH, PRESTWOOD, by_own_programme, text_of

from masonry_cd.app.scene import Scene, parse_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.limit.assumed import STRENGTH
from masonry_cd.limit.case import limit_case
from masonry_cd.limit.service import Service

STATED = ', spread = "2:1", passive = 0.5'


def scene(arch: dict[str, float], fill: str = STATED, service: str = "stress = 0.5", more: str = "", material: str = "") -> Scene:
    return parse_scene(
        text_of(arch, fill, more=more, material=material) + f"positions = 8\n[limit.service]\n{service}\n", Path("arch.toml")
    )


def checked(given: Scene) -> Service:
    found = limit_case(given).service
    assert found is not None
    return found


@pytest.mark.parametrize("arch", [PRESTWOOD, DEEP_ARCH], ids=["Prestwood", "deep"])
def test_factors_are_those_of_a_programme_of_its_own_at_the_same_place(arch: dict[str, float]) -> None:
    found = checked(scene(arch))
    opening, stress = found.rows
    assert opening.position is not None and stress.position is not None
    third = by_own_programme(arch | {"at": opening.position}, 0.5, inset=1.0 / 3.0)
    assert opening.factor == pytest.approx(third, rel=0.02)
    assert stress.factor == pytest.approx(by_own_programme(arch | {"at": stress.position}, 0.5, 0.5 * STRENGTH, 60), rel=0.02)
    assert opening.factor < stress.factor < by_own_programme(arch | {"at": opening.position}, 0.5)


def test_what_is_asked_decides_if_it_is_met_and_open_fill_is_looked_at_without_resistance() -> None:
    arch = PRESTWOOD | {"voussoirs": 9}
    found = checked(scene(arch, ', spread = "2:1"', service="factor = 10.0"))
    assert [row.check for row in found.rows] == ["opening", "opening"] and "without passive pressure" in found.rows[1].words
    own, bare = (row.factor for row in found.rows)
    assert own is not None and bare is not None and bare < own and found.rows[0].met
    assert not checked(scene(arch, service=f"factor = {1.2 * own}")).rows[0].met
    without = scene(arch, ', spread = "2:1", passive = 0.0')
    assert checked(without).rows[0].factor == pytest.approx(bare, rel=1e-9)


def test_a_deep_arch_opens_under_its_own_weight() -> None:
    found = checked(scene(DEEP_ARCH | {"thickness": 0.25}, STATED.replace("0.5", "0.0"), service="factor = 1.0"))
    assert found.rows[0].factor is None and not found.rows[0].met and "dead loads alone" in found.rows[0].line


def test_bridges_in_space_and_scenes_without_a_vehicle_are_refused() -> None:
    walls = "[structure.walls]\nthickness = 0.3\ncourse_height = 1.2\nunit_length = 2.0\n"
    arch = PRESTWOOD | {"voussoirs": 7, "span": 3.0, "rise": 1.0, "thickness": 0.4}
    with pytest.raises(InputError, match=r"limit\.service.*in their plane"):
        checked(scene(arch, more=walls))
    text = text_of(arch).partition("[[loads]]")[0] + "[limit]\npush = 'x'\n[limit.service]\n"
    with pytest.raises(InputError, match=r"limit\.service.*under a vehicle"):
        limit_case(parse_scene(text, Path("arch.toml")))
