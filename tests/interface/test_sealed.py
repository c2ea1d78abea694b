# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects of the interface refuse attributes that would change nothing."""

from __future__ import annotations

from typing import Any

import pytest

import masonry_cd as mc

KINDS = ("Assessment", "Comparison", "LimitAnalysis", "Run", "Scene", "Simulation", "Structure", "Study")


@pytest.mark.parametrize("kind", KINDS)
def test_no_class_of_the_interface_takes_an_attribute_that_it_does_not_know(kind: str) -> None:
    made = object.__new__(getattr(mc, kind))
    with pytest.raises(AttributeError, match="friction"):
        made.friction = 0.2


def test_what_can_be_set_is_set_and_what_is_read_is_not(tables: dict[str, Any]) -> None:
    sim = mc.Simulation(mc.scene(tables))
    sim.step()
    for name in ("friction", "report", "scene", "structure", "time"):
        with pytest.raises(AttributeError, match=name):
            setattr(sim, name, 0.2)
    sim.state = sim.state.changed("b1", velocity=(0.0, 0.0, 0.0))
    other = sim.copy()
    assert other.step() is other.report and sim.report is not other.report
    for made in (sim.state, sim.contacts, sim.joints, sim.report, sim.structure[0], sim.structure, sim.scene):
        with pytest.raises(AttributeError):
            made.friction = 0.2  # type: ignore[union-attr]
