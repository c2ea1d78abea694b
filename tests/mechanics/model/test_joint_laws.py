# SPDX-License-Identifier: GPL-3.0-or-later
"""The laws of joints: what each says of itself, and what all that show it make of that."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.joint_laws import LAWS, JointLaw, at_start_only, held, histories, joint_table, law_in_words, refuse_in_a_run
from masonry_cd.mechanics.model.joint_laws.tables import JointLaws
from masonry_cd.mechanics.model.materials import Material


def material(**keys):
    return Material.model_validate({"density": 2000.0, "friction": 0.6} | keys)


def checked(made: Material) -> None:
    refuse_in_a_run(made.joint_laws, made.joint_moduli)


@pytest.mark.parametrize(
    ("keys", "place"),
    [
        ({"joints": {"a-b": {"compressive_strength": 2e6}, "default": {}}}, "material.joints.a-b.normal_stiffness"),
        ({"masonry": {"kind": "solid brick", "stiffness": "rigid", "crushing": True}}, "material.joints.default.normal_stiffness"),
    ],
)
def test_a_run_refuses_rigid_joints_that_crush(keys, place):
    with pytest.raises(InputError) as refused:
        checked(material(**keys))
    assert refused.value.place == place


def test_elastic_joints_may_crush_and_blocks_have_a_strength_for_reports():
    checked(material(joints={"compressive_strength": 2e6, "normal_stiffness": 1e10}))
    checked(material(compressive_strength=5e6, joints={"normal_stiffness": 1e10}))


def test_a_law_fills_its_tables_alone_and_is_found_by_them():
    """Every key of [material.joints] is of one law, and every table."""
    tables = [name for law in LAWS for name in law.tables(JointLaw(), 0.5, "a-a")]
    assert sorted([*tables, "moduli"]) == sorted(JointLaws.__dataclass_fields__)
    assert not held(joint_table({}, ("a",), np.full((1, 1), 0.5)))
    for keys, found in (
        ({"normal_stiffness": 1e9}, []),
        ({"cohesion": 1e5}, ["bonded"]),
        ({"normal_stiffness": 1e9, "compressive_strength": 1e6}, ["crushed"]),
    ):
        laws = joint_table({"default": JointLaw(**keys)}, ("a",), np.full((1, 1), 0.5))
        assert [history.name for history in histories(laws)] == found
        assert bool(at_start_only(laws)) == ("crushed" in found)


def test_all_of_a_law_is_said():
    said = law_in_words(JointLaw(normal_stiffness=2e9, cohesion=1e5, compressive_strength=5e6), "rigid")
    assert all(part in said for part in ("2 GN/m³", "100 kPa", "crushed at 5 MPa"))
    assert law_in_words(JointLaw(), "rigid").startswith("rigid, dry")
