# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts whose joints crush: the closed form of a pier as a part, in a plane and in space, and what joins it to the whole's search."""

from __future__ import annotations

import numpy as np
import pytest
from limit_loads import joined, push_loads
from models import GRAVITY, box

from masonry_cd.analysis.limit.admitted import admitted
from masonry_cd.analysis.limit.analysis import LimitOptions, analyse
from masonry_cd.analysis.limit.candidates import with_mechanisms
from masonry_cd.analysis.limit.found import FREE
from masonry_cd.analysis.limit.macro import Effort, ElementAnalysis, analyse_element
from masonry_cd.analysis.limit.part import Whole, part_of, resting
from masonry_cd.analysis.limit.problem import Bars
from masonry_cd.analysis.limit.rigid_groups import rigid_groups
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.joint_laws import JointLaw
from structures.macro_elements.element import OVERTURNING, MacroElement

B, T, HIGH, COURSES = 1.0, 0.3, 0.5, 4  # of a pier [m], and of a course
PRESSURE = 2000.0 * GRAVITY * HIGH * COURSES  # at its foot [Pa]
ROUGH = 5.0  # friction that lets nothing slide
X = (1.0, 0.0, 0.0)


def piers(off: float) -> list[Block]:
    """Two piers side by side on a base, which reaches ``off`` farther to one side, out of the plane."""
    out = [box("base", (-2.0, -1.0, -0.5), (8.0, 1.0 + T + off, 0.0), True)]
    for name, x in (("near", 0.0), ("far", 5.0)):
        out += [box(f"{name}.{k}", (x, 0.0, HIGH * k), (x + B, T, HIGH * (k + 1))) for k in range(COURSES)]
    return out


def whole_of(strength: float, off: float = 0.0) -> Whole:
    assembly, joints = joined(piers(off), ROUGH, {"default": JointLaw(compressive_strength=strength)})
    return Whole(assembly, joints, push_loads(assembly).dead, Bars.none(), GRAVITY, lambda group: False)


def near(whole: Whole) -> np.ndarray:
    return np.array([b for b, name in enumerate(whole.assembly.names) if name.startswith("near")])


def analysed(whole: Whole, displacements: bool = False) -> ElementAnalysis:
    element = MacroElement("pier", "wall", near(whole), (X,), (OVERTURNING,))
    return analyse_element(whole, element, X, Effort(2, 10_000, displacements=displacements))


def by_hand(share: float) -> float:
    """N b/2 (1 - N/(f b t)) over N h/2, at the foot, where N/(f b t) is the largest."""
    return (B / 2.0) * (1.0 - share) / (HIGH * COURSES / 2.0)


@pytest.mark.parametrize("off", [0.0, 0.1], ids=["plane", "space"])
@pytest.mark.parametrize("share", [0.02, 0.2, 0.6])
def test_a_pier_overturns_about_its_stress_block(share: float, off: float) -> None:
    """As one body and block by block, with dilation and without."""
    found = analysed(whole_of(PRESSURE / share, off))
    factors = [one.oscillator.alpha for one in found.mechanisms]
    assert {one.name.startswith(FREE) for one in found.mechanisms} == {True, False}
    assert factors == pytest.approx([by_hand(share)] * len(factors), rel=3e-4)
    assert found.numbers.has_agreement
    first = found.mechanisms[0].mechanism
    assert first is not None and first.crushing.sum() == 1


def test_joints_that_crush_are_not_followed_and_the_part_says_so() -> None:
    first = analysed(whole_of(5.0 * PRESSURE), displacements=True).mechanisms[0]
    assert not first.oscillator.falls and first.oscillator.end == "joints that crush are not followed at finite displacements"


def test_a_strength_below_the_stress_that_acts_names_the_joint_of_the_part() -> None:
    with pytest.raises(InputError, match=r'the joint "base" - "near\.0" .* crushes at .* under the dead loads alone'):
        analysed(whole_of(0.8 * PRESSURE))


def test_bodies_keep_the_joints_between_them_and_their_cells() -> None:
    whole = whole_of(5.0 * PRESSURE)
    part = part_of(whole, resting(whole, near(whole)), np.array(X))
    two = rigid_groups(part.problem, part.assembly, [near(whole)[:2], near(whole)[2:]]).problem
    assert part.problem.sections is not None and two.sections is not None
    assert len(part.problem.sections.joint) == COURSES and len(two.sections.joint) == 2  # the foot, and between the two
    assert len(two.strength) == len(two.sections.cells.owner) == two.bars.shape[0]
    one = rigid_groups(part.problem, part.assembly, [near(whole)]).problem
    assert one.unknowns == 3 + 2  # a body in a plane, the closing rate of its foot


def test_the_search_of_the_whole_begins_at_a_part_that_crushes() -> None:
    """The foot may close where the part's mechanism crushes it, by as much as the blocks overlap there."""
    share = 0.2
    whole = whole_of(PRESSURE / share)
    moves = analysed(whole).mechanisms[0].mechanism
    assert moves is not None
    analysis = analyse(whole.assembly, whole.joints, push_loads(whole.assembly), LimitOptions(starts=0))
    problem, velocity = analysis.problem, moves.velocity
    assert admitted(problem, whole.assembly, velocity) is None
    begun = admitted(problem, whole.assembly, velocity, moves.crushing)
    assert begun is not None and (problem.jacobian @ begun)[:: problem.directions].min() > -1e-9 * np.abs(begun).max()
    least = with_mechanisms(analysis, whole.assembly, whole.joints, [moves]).least
    assert least is not None and least.starts == 1
    assert least.optimum.factor == pytest.approx(by_hand(share), rel=1e-3)
