# SPDX-License-Identifier: GPL-3.0-or-later
"""Joints that crush: closed forms of sections without tension, about one axis and about both, and of a flat arch."""

from __future__ import annotations

import numpy as np
import pytest
from models import material_of

from masonry_cd.analysis.limit.analysis import LimitOptions, analyse
from masonry_cd.analysis.limit.capacity import capacity_curve
from masonry_cd.analysis.limit.problem import Bars, BlockLoads
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joint_laws import JointLaw
from structures.geometry.prism import box

B, T, H = 1.0, 0.3, 2.0  # of a pier [m]
N = 2e5  # on its base [N]
ROUGH = 5.0  # friction that lets nothing slide
EXACT = 1e-6  # the closed form of a plane is met but for rounding; 1 % is requested
CONES = 1e-4  # and in space but for the last cuts and the tolerance of cone programmes


def pier(law: JointLaw, across: tuple[float, float] = (1.0, 0.0), off: float = 0.0) -> tuple[Assembly, BlockLoads]:
    """A pier under N that is pushed with 1 N at its top; ``off``: the base reaches so much farther to one side, out of the plane."""
    base = Block("base", *box((-B, -B, -0.5), (2.0 * B, B + T + off, 0.0)), 2000.0, "base", fixed=True)
    assembly = Assembly.from_blocks(
        [base, Block("pier", *box((0.0, 0.0, 0.0), (B, T, H)), 2000.0, "pier")], material_of(ROUGH, {"default": law})
    )
    dead, live = np.zeros((2, 6)), np.zeros((2, 6))
    dead[1, 2] = -N
    live[1, :2] = across
    live[1, 3:] = np.cross([0.0, 0.0, 0.5 * H], live[1, :3])
    return assembly, BlockLoads(dead, live, Bars.none())


def moment(assembly: Assembly, loads: BlockLoads, starts: int = 0) -> tuple[float, float | None]:
    """At the base under the largest push, and under the least without dilation, None where none is searched for [N m]."""
    found = analyse(assembly, find_joints(assembly), loads, LimitOptions(starts=starts))
    return H * found.associated.factor, None if found.least is None else H * found.least.optimum.factor


@pytest.mark.parametrize("share", [1e-6, 0.02, 0.05, 0.2, 0.5, 0.8, 0.99])
def test_a_pier_under_axial_load_has_the_moment_of_its_stress_block(share):
    """M = N b/2 (1 - N/(f b t)); joints that only rock have one factor, with dilation and without."""
    exact = N * B / 2.0 * (1.0 - share)
    law = JointLaw(compressive_strength=N / (share * B * T))
    found, least = moment(*pier(law), starts=2)
    assert found == pytest.approx(exact, rel=EXACT) and least == pytest.approx(exact, rel=EXACT)
    assert moment(*pier(law, off=0.1))[0] == pytest.approx(exact, rel=CONES)


@pytest.mark.parametrize(("p", "q"), [(0.5, 0.2), (0.9, 0.05), (0.3, 0.28)])
def test_about_both_axes_the_stress_block_is_a_triangle_at_the_corner(p, q):
    """A bed of legs p and q has its resultant p/3 and q/3 from the edges; the push goes the way of that eccentricity."""
    arm = np.array([B / 2.0 - p / 3.0, T / 2.0 - q / 3.0])
    found, least = moment(*pier(JointLaw(compressive_strength=N / (p * q / 2.0)), tuple(arm / np.linalg.norm(arm))), starts=1)
    exact = N * np.linalg.norm(arm)
    assert exact * (1.0 - 10.0 * CONES) < found < exact * (1.0 + 1e-6)
    assert least == pytest.approx(exact, rel=10.0 * CONES)


def test_a_bond_adds_its_tension_below_the_stress_block():
    """-f_t <= sigma <= f is 0 <= sigma + f_t <= f + f_t."""
    strength, tension = 2e6, 3e5
    law = JointLaw(compressive_strength=strength, cohesion=ROUGH * tension)
    lifted, most = N + tension * B * T, (strength + tension) * B * T
    assert moment(*pier(law))[0] == pytest.approx(lifted * B / 2.0 * (1.0 - lifted / most), rel=EXACT)


def flat_arch(strength: float) -> tuple[Assembly, BlockLoads]:
    """Two stones of 1 x 0.3 x 0.4 m between abutments, each with 1 N at the crown."""
    law = {"default": JointLaw(compressive_strength=strength)}
    ends = [box((-1.5, 0.0, -0.2), (-1.0, T, 0.6)), box((1.0, 0.0, -0.2), (1.5, T, 0.6))]
    stones = [box((-1.0, 0.0, 0.0), (0.0, T, 0.4)), box((0.0, 0.0, 0.0), (1.0, T, 0.4))]
    blocks = [Block(f"abutment{k}", *shape, 2000.0, "base", fixed=True) for k, shape in enumerate(ends)]
    blocks += [Block(f"stone{k}", *shape, 2000.0, "arch") for k, shape in enumerate(stones)]
    assembly = Assembly.from_blocks(blocks, material_of(ROUGH, law))
    dead, live = np.zeros((4, 6)), np.zeros((4, 6))
    dead[2:, 2] = -9.81 * assembly.mass[2:]
    live[2:, 2] = -1.0
    live[2:, 3:] = np.cross([[0.5, 0.0, 0.0], [-0.5, 0.0, 0.0]], live[2:, :3])
    return assembly, BlockLoads(dead, live, Bars.none())


@pytest.mark.parametrize("strength", [1e6, 4e6])
def test_a_flat_arch_bears_what_its_thrust_can_at_half_the_depth(strength):
    """V l + W l / 2 = T (d - T / (f t)), which is largest where the stress blocks take half of the depth: f t d^2 / 4."""
    assembly, loads = flat_arch(strength)
    found = analyse(assembly, find_joints(assembly), loads, LimitOptions(starts=1))  # a second lets go of the thrust
    exact = strength * T * 0.4**2 / 4.0 - 9.81 * float(assembly.mass[2]) / 2.0
    assert found.associated.factor == pytest.approx(exact, rel=EXACT)
    assert found.least is not None and found.least.optimum.factor == pytest.approx(exact, rel=EXACT)
    collapse = found.collapse(3)
    assert collapse.block_share == pytest.approx(0.5, rel=1e-3) and collapse.mechanism.crushing.all()


@pytest.mark.parametrize("bond", [{}, {"cohesion": 6e4}])
def test_a_strength_below_the_stress_that_acts_is_said_with_the_joint(bond):
    """All of the joint is at its strength, which is its mean stress to 0.2 % whatever tension it bears."""
    assembly, loads = pier(JointLaw(compressive_strength=0.9 * N / (B * T), **bond))
    said = r'^material\.joints: the joint "base" - "pier" \(base-pier\) crushes at 600 kPa .*: 90.* % .* mean stress of 60[01] kPa'
    with pytest.raises(InputError, match=said):
        analyse(assembly, find_joints(assembly), loads)


def test_a_structure_that_falls_anyway_is_no_fault_of_its_strength():
    assembly, loads = pier(JointLaw(compressive_strength=1e8))
    loads.dead[1, 3:] = 0.6 * N * np.array([0.0, B, 0.0])
    assert not analyse(assembly, find_joints(assembly), loads).stands


def test_a_tie_that_a_mechanism_stretches_yields_in_the_search_in_space_too():
    """The forces of a mechanism without dilation are at the strength of the ties that it stretches; a rocking pier has one factor."""
    assembly, loads = pier(JointLaw(), off=0.1)
    tied = BlockLoads(
        loads.dead, loads.live, Bars(np.array([[0, 1]]), np.array([[[0.0, T / 2.0, -0.2], [0.0, T / 2.0, H]]]), np.array([1e4]))
    )
    found, least = moment(assembly, tied, starts=1)
    assert found == pytest.approx(N * B / 2.0 + 1e4 * B, rel=CONES) and least == pytest.approx(found, rel=10.0 * CONES)


def test_a_curve_is_not_followed():
    assembly, loads = pier(JointLaw(compressive_strength=1e7))
    with pytest.raises(InputError, match=r"^limit\.curve: joints that crush are not followed"):
        capacity_curve(assembly, find_joints(assembly), loads)
