"""structures.layout.ground: what has no ground of its own gets one, on which what falls comes to lie."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from models import stepper

import structures
from masonry_cd.errors import InputError
from masonry_cd.model.blocks import Block

THIN = {"kind": "arch", "radius": 1.0, "thickness": 0.08, "voussoirs": 9}  # too thin to stand
VAULT = {"kind": "vault", "form": "cross", "voussoirs": 7}


def build(table: dict[str, Any], **keys: Any) -> list[Block]:
    return structures.build({**table, **keys}, 2000.0, Path())


@pytest.mark.parametrize("table", [THIN, VAULT, {"kind": "vault", "form": "barrel"}])
def test_a_slab_lies_under_abutments_and_piers(table):
    before, after = build(table), build(table, ground=True)
    assert [block.name for block in after] == [*(block.name for block in before), "ground"]
    slab, points = after[-1], np.concatenate([block.vertices for block in before])
    assert slab.fixed
    assert slab.group == "base"
    assert slab.vertices[:, 2].max() == points[:, 2].min()
    assert (slab.vertices[:, :2].min(axis=0) < points[:, :2].min(axis=0)).all()
    assert (slab.vertices[:, :2].max(axis=0) > points[:, :2].max(axis=0)).all()
    assert build(table, ground=-5.0)[-1].vertices[:, 2].max() == pytest.approx(-5.0)
    assert len(build(table, ground=False)) == len(before)


def test_an_arch_that_falls_lands_on_it():
    """Without a ground its voussoirs are more than 5 m down after 1.6 s, and fall on."""
    steps = 800
    fallen = {}
    for name, keys in (("air", {}), ("ground", {"ground": -1.0})):
        machine = stepper(build(THIN, **keys), steps, dt=2e-3, solver="auto", tolerance=1e-4)
        for _ in range(steps):
            machine.step()
        free = ~machine.assembly.fixed
        fallen[name] = machine.state.position[free, 2].min()
    assert fallen["air"] < -5.0 < -1.0 < fallen["ground"] < -0.9  # on the ground, in no place below it


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
