# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts deep in each other, as blocks on elastic joints are under a great load: one normal, and springs that begin without force."""

import numpy as np
import pytest
from models import box, ground, material_of, turned

from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.contact.faults import UnexplainedOverlap
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.state import State, rotation_matrices

ELASTIC = {"default": JointLaw(normal_stiffness=1e9)}


class Watched:
    """Two blocks, one of which is put here and there under the eyes of one detector."""

    def __init__(self, blocks: list[Block]) -> None:
        self.assembly = Assembly.from_blocks(blocks, material_of(0.6, ELASTIC))
        self.detector = Detector(self.assembly)

    def at(self, state: State, slack: float = 1e-3) -> ContactSet:
        where = state.position, rotation_matrices(state.orientation)
        return self.detector.detect(*where, np.zeros((self.assembly.count, 6)), 1e-3, slack, np.zeros(3))

    def moved(self, *shift: float) -> ContactSet:
        state = State.at_rest(self.assembly)
        state.position[1] += shift
        return self.at(state)


def test_the_face_that_parts_a_tilted_pair_does_not_change_with_every_small_motion():
    """The faces of two like blocks, 10 mm in each other at an angle of 0.04, are equally deep: which is deeper hangs on a tenth of a mm."""
    blocks = [box("low", (0.0, 0.0, 0.0), (0.3, 0.3, 0.15), fixed=True), box("high", (0.0, 0.0, 0.15), (0.3, 0.3, 0.3))]
    pair, normals = Watched(blocks), []
    for k in range(6):
        state = turned(pair.assembly, 1, (0.0, 1.0, 0.0), 0.04, (0.15, 0.15, 0.15))
        state.position[1] += [(-1.0) ** k * 2e-3, 0.0, -4e-3]
        normals.append(pair.at(state).normal)
    assert all(normal == pytest.approx(np.tile(normals[0][0], (len(normal), 1)), abs=1e-12) for normal in normals)


def test_a_face_that_frees_a_part_over_half_the_way_takes_over():
    """A block pushed deep into a table beside its edge leaves it upwards, until the way to the side is half as long."""
    pair = Watched([box("table", (-1.0, -1.0, -1.0), (0.0, 1.0, 0.0), fixed=True), box("block", (-0.2, -0.2, 0.0), (0.2, 0.2, 0.4))])
    assert pair.moved(0.15, 0.0, -0.04).normal[0] == pytest.approx([0.0, 0.0, 1.0])
    assert pair.moved(0.17, 0.0, -0.04).normal[0] == pytest.approx([0.0, 0.0, 1.0])  # 30 mm to the side, 40 upwards
    assert pair.moved(0.19, 0.0, -0.04).normal[0] == pytest.approx([1.0, 0.0, 0.0])


def test_springs_of_a_new_joint_do_not_feel_the_overlap_that_they_find():
    """They feel what comes on top of it; and as the blocks come out of each other they feel again what they then go in."""
    pair = Watched([ground(), box("block", (-0.2, -0.2, 0.0), (0.2, 0.2, 0.4))])
    assert len(pair.moved(0.0, 0.0, 0.5).gap) == 0
    for depth, felt in ((0.030, 0.0), (0.035, 0.005), (0.020, 0.0), (0.032, 0.012), (-0.0005, -0.0005), (0.003, 0.003)):
        assert -pair.moved(0.0, 0.0, -depth).gap == pytest.approx(felt, abs=1e-12)


def test_a_joint_that_closes_is_felt_from_the_first():
    pair = Watched([ground(), box("block", (-0.2, -0.2, 0.0), (0.2, 0.2, 0.4))])
    for depth in (-0.0005, 0.001, 0.004, 0.010):
        assert -pair.moved(0.0, 0.0, -depth).gap == pytest.approx(depth, abs=1e-12)


def test_edges_that_are_nearly_parallel_do_not_turn_their_normal_about():
    """Upright edges of two blocks 0.42 m apart, seen from afar: where they lean by 1e-5 would decide to which side a normal across them
    points, so they have none, and with a greater lean no gap is less than what separates the blocks."""
    pair = Watched([box("a", (0.0, 0.0, 0.0), (0.3, 0.3, 0.3), fixed=True), box("b", (0.6, 0.6, 0.0), (0.9, 0.9, 0.3))])
    for angle in (2e-5, 1e-3, 1e-2):
        for axis in ((1.0, 1.0, 0.0), (1.0, -1.5, 0.0)):
            state = turned(pair.assembly, 1, np.array(axis) / np.linalg.norm(axis), angle, (0.75, 0.75, 0.15))
            gaps = pair.at(state, slack=0.6).gap
            assert angle > 1e-4 or len(gaps) == 0
            assert (gaps > 0.3 - angle).all()  # not the 0.08 that lie along another normal


def test_an_overlap_that_no_motion_explains_is_reported_with_its_blocks():
    """A detector that takes blocks to have been apart just now, which are deep in each other: as a false contact would look."""
    blocks = [ground(), box("low", (0.0, 0.0, 0.1), (0.4, 0.4, 0.5)), box("high", (0.0, 0.0, 0.48), (0.4, 0.4, 0.9))]
    assembly = Assembly.from_blocks(blocks, 0.6)
    state, turn, still = State.at_rest(assembly), rotation_matrices(State.at_rest(assembly).orientation), np.zeros((3, 6))
    detector = Detector(assembly)
    where = (turn, still, 1e-3, 1e-4, np.zeros(3))
    assert detector.detect(state.position, *where).gap.min() == pytest.approx(-0.02)
    state.position[2, 2] -= 0.01  # which explains 10 mm more
    assert detector.detect(state.position, *where).gap.min() == pytest.approx(-0.03)
    known = detector.snapshot()
    detector.restore(known | {"budget": np.full(len(known["budget"]), 0.005)})
    state.position[2, 2] -= 0.01
    with pytest.raises(UnexplainedOverlap, match="by 40 mm, of which their motion explains 5 mm") as fault:
        detector.detect(state.position, *where)
    assert fault.value.blocks == (1, 2)
    assert detector.detect(state.position, *where).gap.min() == pytest.approx(-0.04)  # others, of a shorter step perhaps, go on
