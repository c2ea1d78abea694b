# SPDX-License-Identifier: GPL-3.0-or-later
"""Why the least factor may lie far below what a held push of the dynamics bears: friction in joints whose normal force nothing decides.

A slab stands on a narrow foot and, halfway up, on ledges next to it. It overturns inwards together with its foot, and slides on the ledges
without opening there. Where the foot bears all of its weight, as equilibrium allows, the ledges hold nothing and the two overturn as one
body; where the ledges bear their share, as built, friction on them holds it. Both are answers of Coulomb's law.
"""

from __future__ import annotations

from dataclasses import replace

import pytest
from limit_loads import push_loads
from models import box, ground

from benchmarks.held_push import hold
from masonry_cd.analysis.limit.analysis import LimitOptions, analyse
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly

INWARDS = (0.0, 1.0, 0.0)
ALONE = 0.25 / ((0.75 * 0.75 + 2.25 * 2.25) / 3.0)  # half of the thickness over the height of the centre of foot and slab


def on_ledges(friction_there: float) -> Assembly:
    """Foot of 1 m and slab of 3 m by 0.5 m, 1.5 m high each; fixed ledges 5 cm next to the foot."""
    ledges = [box("west", (-1.5, 0.0, 0.0), (-0.55, 0.5, 1.5), fixed=True), box("east", (0.55, 0.0, 0.0), (1.5, 0.5, 1.5), fixed=True)]
    stones = [box("foot", (-0.5, 0.0, 0.0), (0.5, 0.5, 1.5)), box("slab", (-1.5, 0.0, 1.5), (1.5, 0.5, 3.0))]
    blocks = [ground(4.0), *(replace(ledge, group="ledge") for ledge in ledges), *stones]
    return Assembly.from_blocks(blocks, {"default": 0.6, "ledge-block": friction_there})


def test_the_search_finds_the_slab_relieved_of_its_ledges() -> None:
    assembly = on_ledges(0.6)
    joints, loads = find_joints(assembly), push_loads(assembly, INWARDS)
    found = analyse(assembly, joints, loads, LimitOptions(starts=2))
    assert found.least is not None and found.least.optimum.factor == pytest.approx(ALONE, rel=1e-3)
    assert found.associated.factor > 1.8 * ALONE


@pytest.mark.parametrize(("friction_there", "factor", "verdict"), [(0.6, 1.5, "stands"), (0.0, 0.95, "stands"), (0.0, 1.1, "moves")])
def test_what_holds_it_in_the_dynamics_is_the_friction_of_the_ledges(friction_there: float, factor: float, verdict: str) -> None:
    assembly = on_ledges(friction_there)
    assert hold(assembly, INWARDS, factor * ALONE, lambda trial: False).verdict == verdict
