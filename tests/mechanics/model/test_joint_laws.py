# SPDX-License-Identifier: GPL-3.0-or-later
"""Joint laws as text and tables, and the stiffness of bonded courses, which shear as their continuum."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from models import box, wall

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joint_laws import LAWS, JointLaw, at_start_only, held, histories, joint_table, law_in_words, refuse_in_a_run
from masonry_cd.mechanics.model.joint_laws.tables import JointLaws
from masonry_cd.mechanics.model.joint_stiffness import joint_stiffness
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


E, G = 2.4e9, 0.8e9


def stiffness(blocks):
    """The joints of blocks, their middles (J, 3), and both stiffnesses (J,)."""
    assembly = Assembly.from_blocks(blocks, 0.6)
    joints = find_joints(assembly)
    young, shear = np.full(assembly.count, E), np.full(assembly.count, G)
    return joints, *joint_stiffness(assembly, joints, young, shear)


def test_in_a_column_the_moduli_over_the_length_and_supports_count_nothing():
    blocks = [box("base", (-1, -1, -1), (1, 1, 0), fixed=True)]
    blocks += [box(f"b{k}", (-0.3, -0.2, 0.5 * k), (0.3, 0.2, 0.5 * (k + 1))) for k in range(4)]
    joints, normal, tangential = stiffness(blocks)
    length = np.where(joints.centres()[:, 2] == 0.0, 0.25, 0.5)
    assert normal == pytest.approx(E / length)
    assert tangential == pytest.approx(G / length)


@pytest.mark.parametrize(("length", "height"), [(1.0, 0.5), (0.5, 0.5), (0.75, 0.25)])
@pytest.mark.parametrize("running", [False, True])
def test_a_bond_shears_as_the_continuum(length, height, running):
    """1 / P + 1 / Q = 1 / G, with what holds blocks against turning next to the head joints in running bond."""
    joints, normal, tangential = stiffness(wall(6, 6, length, height, 0.4, running))
    middle = joints.centres()
    inside = (np.abs(middle[:, 0] - 3.0 * length) < 1.6 * length) & (middle[:, 2] > 1.6 * height) & (middle[:, 2] < 4.4 * height)
    bed = inside & (np.abs(joints.normal[:, 2]) > 0.9)
    assert bed.sum() >= 6
    assert normal[bed] == pytest.approx(E / height)
    factor = tangential[bed] * height / G
    extra = E * length**2 / (4.0 * height**2) / G if running else 0.0
    assert 1.0 / factor + 1.0 / (factor + extra) == pytest.approx(1.0)


def test_the_stiffness_turns_with_the_wall():
    turn = np.array([[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
    blocks = wall(4, 4)
    turned = [replace(block, vertices=block.vertices @ turn.T) for block in blocks]
    here, there = stiffness(blocks), stiffness(turned)
    order = [np.lexsort(np.round(middle, 6).T) for middle in (here[0].centres() @ turn.T, there[0].centres())]
    for a, b in zip(here[1:], there[1:], strict=True):
        assert a[order[0]] == pytest.approx(b[order[1]])
