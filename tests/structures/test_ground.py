# SPDX-License-Identifier: GPL-3.0-or-later
"""structures.layout.ground: what has no ground of its own gets one, on which what falls comes to lie."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from models import advance, stepper

import structures
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block

THIN = {"kind": "arch", "radius": 1.0, "thickness": 0.08, "voussoirs": 9}  # too thin to stand
VAULT = {"kind": "vault", "form": "cross", "voussoirs": 7}


def build(table: dict[str, Any], **keys: Any) -> list[Block]:
    return structures.build({**table, **keys}, 2000.0, Path())


@pytest.mark.parametrize("table", [THIN, VAULT, {"kind": "vault", "form": "barrel"}])
def test_a_slab_lies_under_abutments_and_piers(table):
    before, after = build(table, ground=False), build(table)
    assert [block.name for block in after] == [*(block.name for block in before), "ground"]
    slab, points = after[-1], np.concatenate([block.vertices for block in before])
    assert slab.fixed
    assert slab.group == "base"
    assert slab.vertices[:, 2].max() == points[:, 2].min()
    assert (slab.vertices[:, :2].min(axis=0) < points[:, :2].min(axis=0)).all()
    assert (slab.vertices[:, :2].max(axis=0) > points[:, :2].max(axis=0)).all()
    assert build(table, ground=-5.0)[-1].vertices[:, 2].max() == pytest.approx(-5.0)
    again = build(table, ground=True)
    assert [block.vertices.tolist() for block in again] == [block.vertices.tolist() for block in after]


@pytest.mark.parametrize(
    "table",
    [
        THIN | {"abutment": False},
        THIN | {"buttress_width": 0.5},
        {"kind": "aqueduct"},
        {"kind": "wall"},
        {"kind": "dome"},
        {"kind": "column"},
        {"kind": "tower"},
    ],
)
def test_structures_with_a_ground_of_their_own_or_without_supports_get_no_other(table):
    assert [block.name for block in build(table)] == [block.name for block in build(table, ground=False)]


@pytest.mark.parametrize(
    "table",
    [THIN, THIN | {"buttress_width": 0.7, "buttress_height": 2.4}, VAULT, *({"kind": kind} for kind in ("wall", "dome", "column"))],
)
def test_the_ground_reaches_one_and_a_half_heights_around(table):
    blocks = build(table)
    free, fixed = (np.concatenate([block.vertices for block in blocks if block.fixed == kind]) for kind in (False, True))
    far = 1.5 * np.ptp(free[:, 2]) * (1.0 - 1e-9)
    assert (free[:, :2].min(axis=0) - fixed[:, :2].min(axis=0) >= far).all()
    assert (fixed[:, :2].max(axis=0) - free[:, :2].max(axis=0) >= far).all()


def test_ties_and_foundations_are_those_without_a_ground():
    """The slab is neither an end of a tie nor cut."""
    tied = THIN | {"ties": [{"along": "x", "height": 0.3, "diameter": 0.02}]}
    with_slab, without = (structures.make(tied | keys, 2000.0, Path()) for keys in ({}, {"ground": False}))
    assert [bar.blocks for bar in with_slab.ties] == [bar.blocks for bar in without.ties]
    cut = [block.name for block in build(THIN, foundations={"x": [0.9, 1.04]})]
    assert [name for name in cut if name.startswith("ground")] == ["ground"]


def test_an_arch_that_falls_lands_on_it():
    """On its own ground, 8 cm below the springings; without one its voussoirs are more than 5 m down after 1.6 s, and fall on."""
    steps = 800
    fallen = {}
    for name, keys in (("air", {"ground": False}), ("ground", {"ground": -1.0}), ("own", {})):
        machine = stepper(build(THIN, **keys), steps, dt=2e-3, solver="auto", tolerance=1e-4)
        advance(machine, steps)
        free = ~machine.assembly.fixed
        fallen[name] = machine.state.position[free, 2].min()
    assert fallen["air"] < -5.0 < -1.0 < fallen["ground"] < -0.9  # on the ground, in no place below it
    assert -0.08 < fallen["own"] < 0.0


@pytest.mark.parametrize(
    ("table", "ground", "message"),
    [
        (THIN, "yes", "structure.ground: should be true, false or the height of its top [m], got 'yes'"),
        (THIN, 0.5, "structure.ground: its top must be at most the lowest corner, "),
        ({"kind": "wall"}, True, 'structure.ground: the structure has a block "ground" already'),
    ],
)
def test_what_is_wrong_is_named(table, ground, message):
    with pytest.raises(InputError) as failure:
        build(table, ground=ground)
    assert str(failure.value).startswith(message)


@pytest.mark.parametrize("kind", ["wall", "column", "tower", "dome", "arch", "vault"])
def test_what_topples_lies_on_the_ground(kind):
    """It reaches farther on all sides than the structure is high."""
    blocks = build({"kind": kind} | (THIN if kind == "arch" else {}))
    (slab,) = (block for block in blocks if block.name == "ground")
    rest = np.concatenate([block.vertices for block in blocks if block is not slab])
    high = np.ptp(rest[:, 2])
    assert (slab.vertices[:, :2].min(axis=0) <= rest[:, :2].min(axis=0) - 1.2 * high).all()
    assert (slab.vertices[:, :2].max(axis=0) >= rest[:, :2].max(axis=0) + 1.2 * high).all()
