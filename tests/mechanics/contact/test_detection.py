# SPDX-License-Identifier: GPL-3.0-or-later
"""Where blocks touch: faces, edges and corners, and where they must not."""

import numpy as np
import pytest
from models import box, ground, tower, turned, wall
from scipy.optimize import linprog

from masonry_cd.mechanics.contact.broad_phase import overlapping_boxes, sweep_axis
from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.contact.pair_memory import CLIPPED, KEPT, SEARCHED, STILL
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.state import State, rotation_matrices


def detect(blocks: list[Block], state: State | None = None, slack: float = 0.0) -> ContactSet:
    assembly = Assembly.from_blocks(blocks, 0.6)
    state = State.at_rest(assembly) if state is None else state
    still = np.zeros((assembly.count, 6))
    return Detector(assembly).detect(state.position, rotation_matrices(state.orientation), still, 1e-3, slack, np.zeros(3))


def rows(points: np.ndarray) -> set[tuple[float, ...]]:
    return {tuple(row) for row in np.round(points + 0.0, 9).tolist()}


def test_a_face_on_a_face_touches_at_the_corners_of_the_overlap():
    contacts = detect([ground(), box("b", (0.0, 0.0, 0.0), (1.0, 0.5, 0.3))])
    assert rows(contacts.point) == {(0, 0, 0), (1, 0, 0), (1, 0.5, 0), (0, 0.5, 0)}
    assert contacts.normal == pytest.approx(np.tile([0, 0, 1.0], (4, 1)))  # from the ground, the antagonist, to the block
    assert np.abs(contacts.gap).max() < 1e-15


def test_a_staggered_block_touches_each_of_the_two_below_over_its_half():
    blocks = [ground(), box("l", (0, 0, 0), (1, 1, 1)), box("r", (1, 0, 0), (2, 1, 1)), box("top", (0.5, 0, 1), (1.5, 1, 2))]
    contacts = detect(blocks)
    above = contacts.bodies[:, 0] == 3
    assert rows(contacts.point[above & (contacts.bodies[:, 1] == 1)]) == {(0.5, 0, 1), (1, 0, 1), (1, 1, 1), (0.5, 1, 1)}
    assert rows(contacts.point[above & (contacts.bodies[:, 1] == 2)]) == {(1, 0, 1), (1.5, 0, 1), (1.5, 1, 1), (1, 1, 1)}
    assert (contacts.pair[1:] >= contacts.pair[:-1]).all()
    assert len(contacts.gap) == 4 * 5


def test_diagonal_neighbours_share_an_edge_but_no_joint():
    blocks = [ground(), box("a", (0, 0, 0), (1, 1, 1)), box("c", (1, 0, 1), (2, 1, 2))]
    assert len(detect(blocks).gap) == 4  # a on the ground
    for shift in (1e-9, -1e-9, 1e-6):  # nor when they have moved a little into or off each other
        assembly = Assembly.from_blocks(blocks, 0.6)
        state = State.at_rest(assembly)
        state.position[2] -= [shift, 0.0, 2 * shift]
        assert len(detect(blocks, state).gap) == 4


def test_a_block_that_falls_past_an_edge_is_seen_before_it_gets_into_the_side():
    """Above the edge of a table and next to it, it faces nothing; a step later its lower corner is next to the side, 1 mm inside."""
    table = box("table", (-1.0, -1.0, -1.0), (0.0, 1.0, 0.0), fixed=True)
    blocks = [table, box("block", (0.002, -0.1, 0.01), (0.202, 0.1, 0.21))]
    assembly, step, velocity = Assembly.from_blocks(blocks, 0.6), 1e-2, np.zeros((2, 6))
    velocity[1, [0, 2]] = -0.3, -4.0
    for moving in (0.0, 1.0):
        state = State.at_rest(assembly)
        where = (state.position, rotation_matrices(state.orientation), moving * velocity, step, 1e-3, np.zeros(3))
        contacts = Detector(assembly).detect(*where)
        assert len(contacts.gap) == (4 if moving else 0)
        if moving:
            assert contacts.normal == pytest.approx(np.tile([1.0, 0.0, 0.0], (4, 1)))
            assert contacts.gap == pytest.approx(np.full(4, 0.002))  # as it is now, not as it will be


def test_neighbours_in_a_wall_touch_face_to_face_only():
    contacts = detect(wall(4, 4))
    assert set(np.abs(contacts.normal).max(axis=1).round(12)) == {1.0}
    head = np.abs(contacts.normal[:, 0]) > 0.5
    assert head.sum() == 4 * (2 * 3 + 2 * 4)  # four corners at each head joint


def test_crossing_edges_touch_at_one_point_with_the_normal_across_both():
    roof = [Block("low", *prism_along_x(), 2000.0, fixed=True), box("high", (-0.5, -0.5, 0.0), (0.5, 0.5, 1.0))]
    assembly = Assembly.from_blocks(roof, 0.6)
    state = turned(assembly, 1, (1.0, 0.0, 0.0), np.pi / 4, (0.0, 0.0, 0.5))  # an edge along x points down ...
    w, z = np.cos(np.pi / 4), np.sin(np.pi / 4)  # ... and now along y
    a, b, c, d = state.orientation[1]
    state.orientation[1] = [w * a - z * d, w * b - z * c, w * c + z * b, w * d + z * a]
    state.position[1] = [0.0, 0.0, np.sqrt(0.5) + 1e-5]
    contacts = detect(roof, state)
    assert len(contacts.gap) == 1
    assert contacts.point[0] == pytest.approx([0, 0, 5e-6], abs=1e-9)
    assert contacts.normal[0] == pytest.approx([0, 0, 1.0])
    assert contacts.gap[0] == pytest.approx(1e-5)


def prism_along_x() -> tuple[np.ndarray, tuple[tuple[int, ...], ...]]:
    """A ridge along x at z = 0."""
    vertices = np.array([[x, y, z] for x in (-1.0, 1.0) for y, z in ((-1.0, -1.0), (1.0, -1.0), (0.0, 0.0))])
    return vertices, ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))


def test_a_corner_on_a_face():
    blocks = [ground(), box("b", (-0.5, -0.5, 0.0), (0.5, 0.5, 1.0))]
    assembly = Assembly.from_blocks(blocks, 0.6)
    tilt = np.arctan(np.sqrt(2.0))  # a space diagonal upright
    axis = (np.sqrt(0.5), -np.sqrt(0.5), 0.0)
    state = turned(assembly, 1, axis, tilt, (0.0, 0.0, 0.5))
    state.position[1] = [0.0, 0.0, np.sqrt(0.75)]
    contacts = detect(blocks, state)
    assert len(contacts.gap) == 1
    assert contacts.point[0] == pytest.approx([0, 0, 0], abs=1e-9)
    assert contacts.normal[0] == pytest.approx([0, 0, 1.0])


@pytest.mark.parametrize("angle", [0.01, 0.2, 0.7])
def test_a_rocking_block_stands_on_its_edge(angle):
    blocks = tower(1, side=0.4, height=1.0)
    assembly = Assembly.from_blocks(blocks, 0.6)
    contacts = detect(blocks, turned(assembly, 1, (0.0, 1.0, 0.0), angle, (0.2, 0.0, 0.0)))
    assert rows(contacts.point) == {(0.2, -0.2, 0), (0.2, 0.2, 0)}
    assert contacts.normal == pytest.approx(np.tile([0, 0, 1.0], (2, 1)))


def test_separation_agrees_with_a_linear_programme_on_random_boxes():
    rng = np.random.default_rng(3)
    blocks = [box("a", (-0.5, -0.3, -0.2), (0.5, 0.3, 0.2)), box("b", (-0.4, -0.4, -0.1), (0.4, 0.4, 0.1))]
    assembly = Assembly.from_blocks(blocks, 0.6)
    seen = {True: 0, False: 0}
    for _ in range(150):
        state = State.at_rest(assembly)
        state.position[1] = rng.uniform(-0.7, 0.7, 3)
        q = rng.normal(size=(2, 4))
        state.orientation[:] = q / np.linalg.norm(q, axis=1)[:, None]
        turn = rotation_matrices(state.orientation)
        hulls = [b.vertices @ turn[i].T + state.position[i] for i, b in enumerate(blocks)]
        meet = hulls_meet(*hulls)
        contacts = Detector(assembly).detect(state.position, turn, np.zeros((2, 6)), 1e-3, 0.0, np.zeros(3))
        overlapping = len(contacts.gap) > 0 and contacts.gap.min() < 0
        assert overlapping == meet
        seen[meet] += 1
    assert min(seen.values()) > 30


def hulls_meet(a: np.ndarray, b: np.ndarray) -> bool:
    """Return True if two convex hulls share a point: a linear programme in the weights of the vertices."""
    equal = np.block([[a.T, -b.T], [np.ones((1, len(a))), np.zeros((1, len(b)))], [np.zeros((1, len(a))), np.ones((1, len(b)))]])
    return linprog(np.zeros(len(a) + len(b)), A_eq=equal, b_eq=[0, 0, 0, 1, 1]).status == 0


def test_shaking_alone_rebuilds_nothing_and_keeps_every_contact():
    assembly = Assembly.from_blocks(wall(4, 4), 0.6)
    detector, state = Detector(assembly), State.at_rest(assembly)
    turn, still = rotation_matrices(state.orientation), np.zeros((assembly.count, 6))
    first = detector.detect(state.position, turn, still, 1e-3, 0.0, np.zeros(3))
    count, pairs = len(first.gap), first.pair.copy()
    for k in range(1, 20):
        shift = np.array([0.3 * np.sin(k), 0.2 * k, 0.0])
        now = detector.detect(state.position + shift, turn, still, 1e-3, 0.0, shift)
        assert now.previous.tolist() == list(range(count))
        assert now.pair.tolist() == pairs.tolist()
    assert detector.rebuilds == 1


def test_a_sliding_block_keeps_its_contacts_and_meets_new_neighbours():
    blocks = [ground(), box("a", (0, 0, 0), (1, 1, 1)), box("b", (1.5, 0, 0), (2.5, 1, 1))]
    assembly = Assembly.from_blocks(blocks, 0.6)
    detector, state = Detector(assembly), State.at_rest(assembly)
    turn = rotation_matrices(state.orientation)
    velocity = np.zeros((3, 6))
    velocity[1, 0] = 10.0
    for k in range(50):
        state.position[1, 0] = 0.5 + 0.01 * k
        now = detector.detect(state.position, turn, velocity, 1e-3, 0.0, np.zeros(3))
        side = now.bodies[:, 1] == 1
        gap = 0.5 - 0.01 * k
        assert side.sum() == (4 if gap < 0.021 else 0)  # two steps at this speed, and a thousandth of the width
        assert np.all(now.gap[side] == pytest.approx(gap))
        assert k == 0 or (now.previous[~side] >= 0).all()


# --- what is not done again -------------------------------------------------------------------------------------------------------


class Scene:
    """A detector and a state that a test moves by hand."""

    def __init__(self, blocks: list[Block]) -> None:
        self.assembly = Assembly.from_blocks(blocks, 0.6)
        self.detector, self.state = Detector(self.assembly), State.at_rest(self.assembly)

    def contacts(self, detector: Detector | None = None, origin: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> ContactSet:
        turn, still = rotation_matrices(self.state.orientation), np.zeros((self.assembly.count, 6))
        found = self.detector if detector is None else detector
        return found.detect(self.state.position, turn, still, 1e-3, 0.0, np.array(origin))

    def done(self) -> np.ndarray:
        """Return the counts of the next detection: pairs apart, kept, clipped, searched."""
        before = self.detector.tally.copy()
        self.contacts()
        return self.detector.tally - before


def test_nothing_is_redone_for_pairs_that_did_not_move():
    scene = Scene(wall(4, 4))
    pairs = len(np.unique(scene.contacts().pair))
    assert scene.done()[KEPT] >= pairs
    scene.state.position[:, 0] += 0.3  # all together: a support's motion
    assert scene.done()[[CLIPPED, SEARCHED]].tolist() == [0, 0]
    scene.state.position[9, 1] += 1e-5  # one block slips a little: its joints are found again, but not the faces that touch
    touching = ((bodies := scene.contacts().bodies) == 9).any(axis=1)
    scene.state.position[9, 1] += 1e-5
    assert scene.done()[[CLIPPED, SEARCHED]].tolist() == [len(np.unique(bodies[touching], axis=0)), 0]
    assert scene.detector.rebuilds == 2  # the start, and the joint motion: nothing was said of an origin that moves


def test_points_kept_are_those_that_would_be_found():
    scene, width = Scene([ground(), box("a", (0, 0, 0), (1, 1, 0.3)), box("b", (0.2, 0.1, 0.3), (1.3, 0.8, 0.6))]), 0.3
    scene.contacts()
    rng = np.random.default_rng(0)
    for _ in range(20):
        scene.state.position[1:] += 0.05 * STILL * width * rng.normal(size=(2, 3))
        kept, fresh = scene.contacts(), scene.contacts(Detector(scene.assembly))
        assert kept.previous.tolist() == list(range(8))
        assert kept.point == pytest.approx(fresh.point, abs=2 * STILL * width)
        assert kept.normal == pytest.approx(fresh.normal, abs=1e-15)
        assert kept.gap == pytest.approx(fresh.gap, abs=1e-15)
    assert scene.detector.tally[KEPT] > scene.detector.tally[CLIPPED]  # or nothing was tested


def test_a_gap_that_leaves_the_margin_and_comes_back_is_a_new_contact():
    scene = Scene([ground(), box("a", (0, 0, 0), (1, 1, 0.3))])
    assert len(scene.contacts().gap) == 4
    scene.state.position[1, 2] += 0.01
    assert len(scene.contacts().gap) == 0
    scene.state.position[1, 2] -= 0.01
    assert scene.contacts().previous.tolist() == [-1] * 4


# --- extreme shapes ---------------------------------------------------------------------------------------------------------------


def test_a_pebble_on_a_slab_a_hundred_times_its_size():
    contacts = detect([ground(), box("slab", (0, 0, 0), (2.0, 2.0, 0.2)), box("pebble", (1.0, 1.0, 0.2), (1.02, 1.02, 0.22))])
    assert rows(contacts.point[contacts.bodies[:, 0] == 2]) == {(x, y, 0.2) for x in (1.0, 1.02) for y in (1.0, 1.02)}
    assert len(contacts.gap) == 8


@pytest.mark.parametrize("thickness", [1e-2, 1e-3])
def test_thin_units_touch_their_neighbours_and_no_one_else(thickness):
    tiles = [box(f"t{k}", (0.0, 0.0, k * thickness), (1.0, 0.5, (k + 1) * thickness)) for k in range(5)]
    contacts = detect([ground(), *tiles])
    assert len(contacts.gap) == 4 * 5
    assert (np.diff(contacts.bodies, axis=1) == -1).all()


def test_neighbours_in_a_plane_that_share_an_edge_or_a_corner_do_not_touch_there():
    at_edge = [ground(), box("a", (0, 0, 0), (1, 1, 1)), box("b", (1, 0, 0), (2, 1, 1)), box("c", (1, 1, 0), (2, 2, 1))]
    contacts = detect(at_edge)
    pairs = {tuple(row) for row in contacts.bodies.tolist()}
    assert pairs == {(1, 0), (2, 0), (3, 0), (2, 1), (3, 2)}  # a and c share an upright edge only
    assert set(np.abs(contacts.normal).max(axis=1)) == {1.0}


@pytest.mark.parametrize("over", [0.3, 0.49, 0.51])
def test_a_block_that_slides_off_an_edge_keeps_the_overlap_that_is_left(over):
    table = box("table", (-1.0, -1.0, -0.5), (0.0, 1.0, 0.0), fixed=True)
    contacts = detect([table, box("b", (over - 1.0, -0.2, 0.0), (over, 0.2, 0.3))])
    assert rows(contacts.point) == {(x, y, 0) for x in (round(over - 1.0, 9), 0.0) for y in (-0.2, 0.2)}


def test_a_block_that_tips_over_an_edge_touches_along_it():
    table = box("table", (-1.0, -1.0, -0.5), (0.0, 1.0, 0.0), fixed=True)
    blocks = [table, box("b", (-0.4, -0.2, 0.0), (0.6, 0.2, 0.3))]
    assembly = Assembly.from_blocks(blocks, 0.6)
    for angle in (0.05, 0.3, 1.0):
        contacts = detect(blocks, turned(assembly, 1, (0.0, 1.0, 0.0), angle, (0.0, 0.0, 0.0)))
        assert rows(contacts.point) == {(0, -0.2, 0), (0, 0.2, 0)}
        assert np.abs(contacts.gap).max() < 1e-12
        assert contacts.normal == pytest.approx(np.tile([np.sin(angle), 0.0, np.cos(angle)], (2, 1)))  # across the face of the block


def test_boxes_are_swept_along_the_axis_that_parts_them():
    """A flat heap of which half the grains fall for ever: they spread most from top to bottom, the others lie side by side."""
    rng = np.random.default_rng(0)
    heap, fallen = rng.uniform((-1, -0.2, 0), (1, 0.2, 0.1), (200, 3)), rng.uniform((-1, -0.2, -40), (1, 0.2, -1), (200, 3))
    centre = np.concatenate([heap, fallen])
    boxes = np.concatenate([centre - 0.05, centre + 0.05], axis=1)
    assert np.std(centre, axis=0).argmax() == 2
    assert sweep_axis(boxes) == 0
    meet = np.triu((np.abs(centre[:, None] - centre[None]) <= 0.1).all(axis=2), k=1)
    np.testing.assert_array_equal(overlapping_boxes(boxes, np.arange(400), np.zeros(400, dtype=bool)), np.argwhere(meet))
