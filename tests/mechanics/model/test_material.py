# SPDX-License-Identifier: GPL-3.0-or-later
"""Friction and joint laws by pair of groups."""

import numpy as np
import pytest

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.mechanics.dynamics.pair_stiffness import most_stretched
from masonry_cd.mechanics.model.joint_laws import JointLaw, joint_table
from masonry_cd.mechanics.model.joint_laws.friction import friction_table
from masonry_cd.mechanics.model.masonry_kinds import KINDS, Masonry
from masonry_cd.mechanics.model.materials import Material, given_strength

GROUPS = ("base", "arch", "pier")
MU = np.full((3, 3), 0.5)


def test_friction_by_pair_of_groups():
    table = friction_table({"default": 0.6, "arch-base": 0.9}, GROUPS)
    assert table[0, 1] == table[1, 0] == 0.9
    assert table[1, 1] == table[0, 2] == 0.6


def test_bad_friction_names_the_pair():
    with pytest.raises(InputError, match=r"friction\.arhc-base.*did you mean \"arch\""):
        friction_table({"default": 0.6, "arhc-base": 0.9}, GROUPS[:2])
    with pytest.raises(InputError, match="no value for base-base"):
        friction_table({"arch-base": 0.9}, GROUPS[:2])


def test_laws_by_pair_and_a_default_that_a_pair_may_take_back():
    laws = joint_table({"arch-base": JointLaw(), "default": JointLaw(normal_stiffness=2.4e9, cohesion=1e5)}, GROUPS, MU)
    assert laws.normal_stiffness[1, 2] == 2.4e9
    assert laws.tangential_stiffness[2, 1] == pytest.approx(1e9)
    assert laws.apex[1, 1] == laws.tension[1, 1] == 2e5
    assert not laws.by_area[0, 1] and not laws.by_area[1, 0]
    assert most_stretched(laws, None) == pytest.approx(2e5 / 2.4e9)
    assert not joint_table({}, GROUPS, MU).by_area.any()


def test_a_dashpot_is_given_by_its_share_of_critical_at_a_frequency():
    laws = joint_table({"arch-base": JointLaw(normal_stiffness=1e9, damping=0.05, damping_frequency=10.0)}, GROUPS, MU)
    assert laws.retardation[0, 1] == laws.retardation[1, 0] == pytest.approx(2.0 * 0.05 / (2.0 * np.pi * 10.0), rel=1e-15)
    assert not laws.retardation[1, 1]


def test_damping_of_zero_is_none_whatever_the_frequency():
    """As in a study over damping, whose first level is none."""
    laws = joint_table({"default": JointLaw(normal_stiffness=1e9, damping=0.0, damping_frequency=10.0)}, GROUPS, MU)
    assert not laws.retardation.any()
    assert not joint_table({"default": JointLaw(damping=0.0, damping_frequency=10.0)}, GROUPS, MU).by_area.any(), "a rigid joint stays one"


@pytest.mark.parametrize(
    ("law", "mu", "message"),
    [
        (
            {"normal_stiffness": 1e9, "cohesion": 1e5, "tension": 3e5},
            0.5,
            "the tension 300 kPa of the joint base-base is above its cohesion",
        ),
        ({"cohesion": 1e5}, 0.0, "the joint base-base has cohesion but no friction"),
    ],
)
def test_laws_that_friction_does_not_allow(law, mu, message):
    with pytest.raises(InputError, match=message):
        joint_table({"default": JointLaw(**law)}, GROUPS, np.full((3, 3), mu))


def test_a_tension_without_friction_or_cohesion_is_its_own_limit():
    assert joint_table({"default": JointLaw(normal_stiffness=1e9, tension=1e5)}, GROUPS, 0 * MU).apex[0, 0] == 1e5


def test_joints_crush_where_a_strength_says_so():
    laws = joint_table({"arch-base": JointLaw(compressive_strength=2e6), "default": JointLaw()}, GROUPS, MU)
    assert laws.crushing[0, 1] == laws.crushing[1, 0] == 2e6
    assert not laws.crushing[1, 1] and not joint_table({}, GROUPS, MU).crushing.any()


def material(**keys):
    return parse_table(Material, {"friction": 0.6} | keys, "material")


def masonry(kind, **keys):
    return Masonry(kind=kind, **keys)


def test_a_name_gives_the_means_of_its_row():
    made = material(masonry="squared stone")
    assert made.joint_moduli == pytest.approx((2850e6, 950e6))
    assert made.block_density == pytest.approx(22e3 / 9.80665)
    assert made.strength == pytest.approx(7e6)
    assert made.joint_laws == {}


@pytest.mark.parametrize("kind", KINDS)
def test_every_row_is_in_order(kind):
    """Ranges ascend, G is a quarter to a third of E, and shear strengths are far below the compressive one."""
    values = masonry(kind).ranges()
    assert all(0.0 < each.least <= each.largest for each in values.values())
    for end in (0, 1):
        assert 0.24 < values["G"][end] / values["E"][end] < 0.35
        assert values["shear_strength"][end] < 0.05 * values["compressive_strength"][end]
    assert 1200.0 < values["density"].least < 2300.0


def test_corrections_and_other_keys_win():
    assert material(masonry={"kind": "split stone", "E": 1.8e9}).joint_moduli == pytest.approx((1.8e9, 1.8e9 * 580 / 1740))
    assert material(masonry={"kind": "split stone", "E": 1.8e9, "G": 5e8}).joint_moduli == (1.8e9, 5e8)
    assert material(masonry={"kind": "split stone", "stiffness": "least"}).joint_moduli == pytest.approx((1.5e9, 5e8))
    assert material(masonry={"kind": "split stone", "stiffness": "rigid"}).joint_moduli is None
    assert material(masonry="split stone", density=2000.0, compressive_strength=1e6).block_density == 2000.0
    assert material(masonry="split stone", compressive_strength=1e6).strength == 1e6
    assert masonry("split stone", knowledge="LC1").strength == pytest.approx(2.6e6)


@pytest.mark.parametrize(
    ("kind", "better", "stronger", "stiffer"),
    [
        ("irregular stone", ["good mortar"], 1.5, 1.5),
        ("irregular stone", ["brick courses"], 1.3, 1.0),
        ("irregular stone", ["good mortar", "brick courses", "transverse connections"], 1.5 * 1.5, 1.5),  # the two largest as found
        ("split stone", ["reinforced repointing"], 1.4, 1.2),  # half of it on moduli
        ("squared stone", ["good mortar", "grout injection", "reinforced plaster"], 1.4, 1.4),  # at most
    ],
)
def test_what_makes_it_better(kind, better, stronger, stiffer):
    plain, made = masonry(kind), masonry(kind, better=better)
    assert made.strength == pytest.approx(stronger * plain.strength)
    assert made.moduli == pytest.approx([stiffer * modulus for modulus in plain.moduli])
    assert made.mean_density == plain.mean_density


def test_bond_by_the_table_and_a_tension_that_is_stated():
    made = material(masonry={"kind": "solid brick", "shear_bond": True}, joints={"tension": 5e4})
    assert made.joint_laws["default"].cohesion == pytest.approx(0.2e6)
    assert made.joint_laws["default"].tension == 5e4
    own = material(masonry={"kind": "solid brick", "shear_bond": True}, joints={"tension": 5e4, "cohesion": 1e5})
    assert own.joint_laws["default"].cohesion == 1e5


def test_joints_crush_at_the_strength_of_the_kind_where_that_is_asked_for():
    assert material(masonry="solid brick", joints={"theta": 0.5}).joint_laws["default"].compressive_strength is None
    made = material(masonry={"kind": "solid brick", "crushing": True}, joints={"a-b": {"compressive_strength": 1e6}, "b-b": {"theta": 0.5}})
    assert {pair: law.compressive_strength for pair, law in made.joint_laws.items()} == {"default": 3.45e6, "a-b": 1e6, "b-b": 3.45e6}


def test_laws_of_joints_of_masonry_need_no_stiffness_of_their_own():
    law = material(masonry="solid brick", joints={"damping": 0.05, "damping_frequency": 5.0}).joint_laws["default"]
    assert law.normal_stiffness is None and law.retardation > 0.0


def test_results_find_the_strength_in_the_table():
    assert given_strength({"masonry": "hollow brick"}) == pytest.approx(6.5e6)
    assert given_strength({"masonry": "hollow brick", "compressive_strength": {"pier": 1e6}}) == {"pier": 1e6}
    assert given_strength({}) is None
