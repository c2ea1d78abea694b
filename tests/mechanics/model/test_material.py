# SPDX-License-Identifier: GPL-3.0-or-later
"""Friction and joint laws by pair of groups."""

import numpy as np
import pytest

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.dynamics.pair_stiffness import most_stretched
from masonry_cd.mechanics.model.joint_laws import JointLaw, joint_table
from masonry_cd.mechanics.model.joint_laws.friction import friction_table

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
            "the tension 300000 Pa of the joint base-base is above its cohesion",
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
