# SPDX-License-Identifier: GPL-3.0-or-later
"""Points of elastic joints, in closed form, and overlaps that are deep."""

import numpy as np
import pytest
from models import GRAVITY, advance, box, gravity, ground, material_of, stepper, turned
from scipy.optimize import brentq

from benchmarks.joint_points import IN_CONTACT, errors, on_the_depth, on_the_diagonal, square, table
from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.contact.faults import UnexplainedOverlap
from masonry_cd.mechanics.contact.joint_points import LIGHT, MOST, resolved_share, rule
from masonry_cd.mechanics.dynamics.equilibrium import settle
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.state import State, rotation_matrices

DEPTH, WIDTH, STIFFNESS, WEIGHT = 0.5, 0.3, 2e10, 2e4  # [m], [N/m3], [N]
RECTANGLE = 0.5 * np.array([[-DEPTH, -WIDTH], [DEPTH, -WIDTH], [DEPTH, WIDTH], [-DEPTH, WIDTH]])
TRIANGLE = np.array([[-0.25, -0.15], [0.25, -0.15], [-0.05, 0.3]])
ROUND = 0.3 * np.stack([np.cos(np.arange(12) * np.pi / 6), np.sin(np.arange(12) * np.pi / 6)], axis=1)


def prism(corners: np.ndarray) -> Block:
    """An upright prism, 1 m high, over a convex polygon (n, 2), counter-clockwise."""
    n = len(corners)
    vertices = np.array([[*corner, z] for z in (0.0, 1.0) for corner in corners])
    sides = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    return Block("b", vertices, (tuple(range(n))[::-1], tuple(range(n, 2 * n)), *sides), 2000.0)


class Bed:
    """A block on an elastic joint, turned about an axis of its bed."""

    def __init__(self, corners: np.ndarray, axis: tuple[float, float], points: int = 7) -> None:
        law = {"default": JointLaw(normal_stiffness=STIFFNESS, joint_points=points)}
        self.assembly = Assembly.from_blocks([ground(), prism(corners)], material_of(0.6, law))
        self.axis = np.array([*axis, 0.0]) / np.hypot(*axis)
        self.rising = float((corners @ [-self.axis[1], self.axis[0]]).max())  # of the corner that opens first [m]

    @property
    def light(self) -> float:
        """Return the shortening of a joint whose points just matter, by the weight of the block [m]."""
        return float(LIGHT * GRAVITY * self.assembly.mass[1] / (STIFFNESS * DEPTH * WIDTH))

    def contacts(self, angle: float, *sunk: float) -> ContactSet:
        """Those of the block turned by an angle [rad] and sunk [m], one depth after the other, whose joint just touched before."""
        detector, still = Detector(self.assembly), np.zeros((2, 6))
        found = detector.detect(*self.placed(0.0, 0.0), still, 1e-3, 1.0, np.zeros(3))
        for depth in sunk:
            found = detector.detect(*self.placed(angle, depth), still, 1e-3, 1.0, np.zeros(3))
        return found

    def nearly_open(self, angle: float) -> float:
        """How far the block is sunk whose joint is closed all over, and about to open [m]."""
        return 1.25 * self.rising * angle

    def placed(self, angle: float, sunk: float) -> tuple[np.ndarray, np.ndarray]:
        """Positions (2, 3) and rotations (2, 3, 3) of the ground and the block."""
        state = turned(self.assembly, 1, tuple(self.axis), angle, (0.0, 0.0, 0.0))
        state.position[1, 2] -= sunk
        return state.position, rotation_matrices(state.orientation)

    def under_weight(self, angle: float) -> ContactSet:
        """Those in which the joint carries WEIGHT, and opened as the block rose."""
        closed = self.nearly_open(angle)
        sunk = brentq(lambda z: pressure(self.contacts(angle, closed, z)).sum() - WEIGHT, -0.6 * angle, 0.6 * angle + 1e-4, xtol=1e-16)
        return self.contacts(angle, closed, sunk)


def pressure(found: ContactSet) -> np.ndarray:
    """Normal forces of the springs (C,) [N]."""
    return STIFFNESS * found.area * np.maximum(0.0, -found.gap)


def energy(found: ContactSet) -> float:
    """Return the energy of the springs [J]."""
    return float(0.5 * STIFFNESS * found.area @ np.minimum(found.gap, 0.0) ** 2)


def moments_of(found: ContactSet) -> np.ndarray:
    """Area, first and second moments (7,) of the points of a joint."""
    x, area = found.point[:, :2], found.area
    return np.array([area.sum(), *(area @ x), *np.ravel(x.T @ (area[:, None] * x))])


@pytest.mark.parametrize(("axis", "size", "across"), [((0.0, 1.0), DEPTH, WIDTH), ((1.0, 0.0), WIDTH, DEPTH)])
@pytest.mark.parametrize(("points", "allowed"), [(7, 0.035), (9, 0.02), (15, 0.01)])
def test_a_bed_without_tension_has_the_moment_of_its_closed_form(axis, size, across, points, allowed):
    bed = Bed(RECTANGLE, axis, points)
    for touching in (0.95, 0.7, 0.5, 0.3, 0.1, 0.05):
        angle = 2.0 * WEIGHT / (STIFFNESS * across * (touching * size) ** 2)
        found = bed.under_weight(angle)
        moment = pressure(found) @ (bed.axis[1] * found.point[:, 0] - bed.axis[0] * found.point[:, 1])
        assert moment == pytest.approx(WEIGHT * (0.5 * size - touching * size / 3.0), rel=allowed)


def test_the_rules_are_as_exact_as_the_table_says():
    largest = [np.abs(errors(on_the_depth(rule(points)))).max() for points in range(3, MOST + 1, 2)]
    assert largest == sorted(largest, reverse=True)  # more points, less error
    assert largest[0] > 0.3 and largest[2] < 0.034 and largest[3] < 0.019
    closed = errors(on_the_diagonal(rule(7)), square, np.array([1.0]))
    assert abs(closed[0]) < 2e-3  # second moments are exact about any axis
    assert [len(rule(points)[0]) for points in (3, 5, 9, 15)] == [1, 2, 4, 7]
    assert "| 9 | -1.9 % | +1.9 % |" in table()


@pytest.mark.parametrize("points", [3, 5, 7, 9, 11, 15])
def test_below_the_share_that_points_resolve_the_force_is_at_the_very_edge(points):
    at_the_edge = 1.0 / (1.0 - 2.0 * IN_CONTACT / 3.0) - 1.0  # error of N b / 2 against N (b / 2 - c / 3)
    found, alone = errors(on_the_depth(rule(points))), resolved_share(points) > IN_CONTACT
    assert found[alone] == pytest.approx(at_the_edge[alone])
    assert (found[~alone] < at_the_edge[~alone] - 1e-6).all()


@pytest.mark.parametrize("corners", [RECTANGLE, TRIANGLE, ROUND])
@pytest.mark.parametrize("points", [5, 7, 15])
def test_rings_have_area_centre_and_second_moments_of_corners_and_centroid(corners, points):
    bed, angle = Bed(corners, (0.3, 1.0), points), 1e-4
    closed, open_ = bed.contacts(0.0, 1e-4), bed.contacts(angle, bed.nearly_open(angle), 0.0)
    assert len(closed.gap) == len(corners) + 1
    assert len(open_.gap) == len(corners) * (points // 2) + 1
    assert open_.area.min() > 0.0
    assert moments_of(open_) == pytest.approx(moments_of(closed), abs=1e-4 * closed.area.sum())


def test_joints_that_are_closed_rigid_or_have_three_points_keep_their_corners():
    assert len(Bed(RECTANGLE, (0.0, 1.0)).contacts(1e-5, 1e-4).gap) == 5
    assert len(Bed(RECTANGLE, (0.0, 1.0), 3).contacts(1e-4, 0.0).gap) == 5
    rigid = Bed(RECTANGLE, (0.0, 1.0))
    rigid.assembly = Assembly.from_blocks([ground(), prism(RECTANGLE)], 0.6)
    assert len(rigid.contacts(1e-4, 0.0).gap) == 4


def test_a_joint_gets_its_points_where_it_carries_what_counts_next_to_its_block():
    bed, angle = Bed(RECTANGLE, (0.0, 1.0)), 1e-4
    hardly, well = 0.2 * bed.light, 5.0 * bed.light  # sunk by what makes a joint that is closed all over carry too little, and enough
    tilted = hardly / DEPTH
    assert len(bed.contacts(tilted, hardly, 0.0).gap) == 5
    assert len(bed.contacts(tilted, hardly, 0.0, well).gap) == 5  # closed, and far from opening again
    assert len(bed.contacts(angle, bed.nearly_open(angle), 0.0).gap) == 13
    assert len(bed.contacts(angle, bed.nearly_open(angle), -0.6 * DEPTH * angle).gap) == 5  # it came off


def test_a_joint_that_is_pressed_while_it_is_open_gets_its_points_where_its_springs_gain_nothing():
    bed, angle = Bed(RECTANGLE, (0.0, 1.0)), 1e-3
    above = -0.6 * DEPTH * angle
    for touching in (0.95, 0.85, 0.7, 0.6, 0.45, 0.3, 0.1):
        sunk = (touching - 0.5) * DEPTH * angle
        pressed, corners = bed.contacts(angle, above, sunk), Bed(RECTANGLE, (0.0, 1.0), 3).contacts(angle, above, sunk)
        gain = energy(pressed) - energy(corners)
        assert (len(pressed.gap) == 5 and gain == 0.0) or (len(pressed.gap) == 13 and gain <= 0.0)
        assert touching > 0.5 or len(pressed.gap) == 13


# --- in a run ---------------------------------------------------------------------------------------------------------------------


def pushed(planar: bool, steps: int) -> Stepper:
    """A block on its bed under a push on its centre that grows to 70 % of what turns it over, stays, and goes back to none."""
    blocks, pull = [ground(), box("b", (-0.25, -0.5, 0.0), (0.25, 0.5, 2.0))], gravity(steps)
    pull[:, 0] = GRAVITY * 0.7 * 0.25 * np.interp(np.arange(steps + 1) / steps, [0.0, 0.25, 0.6, 0.85], [0.0, 1.0, 1.0, 0.0])
    law = {"default": JointLaw(normal_stiffness=2e9, damping=0.3, damping_frequency=10.0, joint_points=7)}
    out = stepper(blocks, steps, dt=5e-3, friction=0.7, joints=law, acceleration=pull, planar=planar, solver="auto", tolerance=1e-8)
    settle(out)
    return out


@pytest.mark.parametrize("planar", [True, False])
def test_a_push_turns_a_block_as_far_as_the_closed_form_says_and_back(planar):
    """N = W, M = F H/2 + W H/2 theta, and c from theta. Elastic slip goes on through both exchanges of points, and energy is booked."""
    machine = pushed(planar, 800)
    weight, begin, lost = machine.assembly.mass[1] * GRAVITY, machine.state.position[1].copy(), [0.0]
    exchanged, most = [], 0.0
    for k in range(800):
        spread = machine.detector.snapshot()["spread"].any()
        machine.step()
        lost.append(machine.energy["damping"] + machine.energy["friction"])
        most = max(most, machine.energy["elastic"])
        if machine.detector.snapshot()["spread"].any() != spread:
            exchanged.append(lost[-1] - lost[-2])
        if k == 479:
            theta = 2.0 * np.arctan2(machine.state.orientation[1, 2], machine.state.orientation[1, 0])
            assert machine.detector.snapshot()["spread"].any()

    def out_of_balance(angle: float) -> float:
        bed = weight * (0.25 - np.sqrt(2.0 * weight / (2e9 * angle)) / 3.0)
        return float(bed - weight * angle - weight * 0.7 * 0.25)

    expected = brentq(out_of_balance, 4.0 * 2.0 * weight / 2e9, 2e-3)
    assert theta == pytest.approx(expected, rel=0.1)  # 2 % of the moment is far more of the turn
    assert not machine.detector.snapshot()["spread"].any()
    touched = np.sqrt(2.0 * weight / (2e9 * expected))
    slip = 0.7 * 0.25 * weight / (2e9 / 2.4 * touched)  # elastic, at the most: points that open lose it
    moved = np.abs(machine.state.position[1] - begin)
    assert moved[0] < slip and moved[1:].max() < 1e-6
    assert abs(machine.state.orientation[1, 2]) < 0.01 * expected
    assert len(exchanged) == 2 and min(exchanged) > 0.0  # energy that an exchange took
    assert np.diff(lost).min() > -1e-3 * most  # with three points as well: springs open and close within a step
    assert abs(machine.energy["balance"]) < 1e-9 * machine.energy["elastic"]


def test_a_stepper_resumes_amid_an_opening_joint_to_the_same_bits():
    first = pushed(False, 300)
    advance(first, 130)
    assert len(first.last.found.gap) > 5
    second = pushed(False, 300)
    second.restore({name: array.copy() for name, array in first.snapshot().items()})
    for machine in (first, second):
        for _ in range(170):  # it closes in these: the points are exchanged again
            machine.step()
    assert first.state.position.tobytes() == second.state.position.tobytes()
    assert first.energy == second.energy


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
    """A block pushed deep into a table next to its edge leaves it upwards, until the way to the side is half as long."""
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
