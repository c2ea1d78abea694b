# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs refuse rigid joints with a compressive strength, and name the key that is missing."""

from __future__ import annotations

import pytest

from masonry_cd.app.crushing_checks import refuse_crushing_in_a_run
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.materials import Material


def material(**keys):
    return Material.model_validate({"density": 2000.0, "friction": 0.6} | keys)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        (
            {"joints": {"a-b": {"compressive_strength": 2e6}, "default": {}}},
            r"^material\.joints\.a-b\.normal_stiffness: missing beside compressive_strength",
        ),
        (
            {"masonry": {"kind": "solid brick", "stiffness": "rigid", "crushing": True}},
            r"^material\.joints\.default\.normal_stiffness: missing",
        ),
    ],
)
def test_a_run_refuses_rigid_joints_that_crush(keys, message):
    with pytest.raises(InputError, match=message):
        refuse_crushing_in_a_run(material(**keys))


def test_elastic_joints_may_crush_and_blocks_have_a_strength_for_reports():
    refuse_crushing_in_a_run(material(joints={"compressive_strength": 2e6, "normal_stiffness": 1e10}))
    refuse_crushing_in_a_run(material(compressive_strength=5e6, joints={"normal_stiffness": 1e10}))
