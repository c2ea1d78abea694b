# SPDX-License-Identifier: GPL-3.0-or-later
"""The key material.masonry: values of the tables, corrections, and what is refused."""

import pytest

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.mechanics.model.masonry_kinds import KINDS, Masonry
from masonry_cd.mechanics.model.materials import Material, given_strength


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


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"masonry": "sqared stone"}, 'material.masonry.kind: no such kind of masonry (did you mean "squared stone"?); kinds: irregular'),
        ({"masonry": 3}, "material.masonry: should be the name of a kind of masonry, or a table with its kind; kinds: irregular stone,"),
        ({"masonry": {"E": 1e9}}, "material.masonry.kind: missing"),
        ({"masonry": {"kind": "solid brick", "F": 1e9}}, "material.masonry.F: unknown key"),
        ({"masonry": {"kind": "solid brick", "E": 1800.0}}, "material.masonry.E: input should be greater than or equal to 100000"),
        ({"masonry": {"kind": "solid brick", "better": ["paint"]}}, 'material.masonry: better: "paint" is none of good mortar,'),
        ({"masonry": {"kind": "solid brick", "better": ["good mortar"]}}, 'material.masonry: better: "good mortar" of solid brick: the'),
        (
            {"masonry": {"kind": "split stone", "better": ["reinforced plaster", "transverse connections"]}},
            'material.masonry: better: "transverse connections" does not count beside "reinforced plaster"',
        ),
        ({"masonry": {"kind": "split stone", "shear_bond": True}}, "material.masonry: shear_bond: split stone has no regular beds"),
        ({"masonry": {"kind": "solid brick", "shear_bond": True}}, "material: masonry.shear_bond needs joints.tension beside it"),
        ({"joints": {"tension": 1e5}}, "material.joints.default: tension needs normal_stiffness"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_in_one_line(keys, message):
    with pytest.raises(InputError) as caught:
        material(**keys)
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


def test_results_find_the_strength_in_the_table():
    assert given_strength({"masonry": "hollow brick"}) == pytest.approx(6.5e6)
    assert given_strength({"masonry": "hollow brick", "compressive_strength": {"pier": 1e6}}) == {"pier": 1e6}
    assert given_strength({}) is None
