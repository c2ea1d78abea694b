# SPDX-License-Identifier: GPL-3.0-or-later
"""Joints and facets of a structure, and contacts of round bodies."""

from __future__ import annotations

import numpy as np
import pytest
from models import box, ground, material_of, tower, turned, wall
from scipy.optimize import nnls

from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.contact.faults import TooManyPoints
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.contact.round_contact import round_depths
from masonry_cd.mechanics.dynamics.warps import Warps
from masonry_cd.mechanics.model.blocks import Assembly, Block, ConvexShapes
from masonry_cd.mechanics.model.elastic_blocks import ElasticBlocks
from masonry_cd.mechanics.model.joints import JointPeaks, measure_joints
from masonry_cd.mechanics.model.state import State, rotation_matrices
from structures.geometry.prism import prism_xz


def test_the_joints_of_a_wall_are_its_bed_and_head_joints():
    assembly = Assembly.from_blocks(wall(4, 4, length=0.4, height=0.2, width=0.3), 0.6)
    joints = find_joints(assembly)
    bed = np.abs(joints.normal[:, 2]) > 0.5
    assert joints.count == (4 + 3 * 8) + (2 * 3 + 2 * 4)
    assert joints.area[bed].sum() == pytest.approx(4 * 4 * 0.4 * 0.3)  # four bed joints over the whole length
    assert joints.area[~bed] == pytest.approx(0.2 * 0.3)
    toward = assembly.centre[joints.block_b] - assembly.centre[joints.block_a]
    assert (np.einsum("ji,ji->j", toward, joints.normal) > 0).all()


def test_nothing_is_open_at_rest():
    assembly = Assembly.from_blocks(wall(3, 3), 0.6)
    joints = find_joints(assembly)
    measures = measure_joints(joints, assembly, State.at_rest(assembly))
    assert max(measures.opening.max(), measures.sliding.max(), measures.rotation.max()) < 1e-14
    assert measures.contact_area == pytest.approx(joints.area)


def test_a_known_slip_comes_back():
    assembly = Assembly.from_blocks(tower(2, side=0.5), 0.6)
    joints, state = find_joints(assembly), State.at_rest(assembly)
    state.position[2] += [0.03, -0.04, 0.0]
    measures = measure_joints(joints, assembly, state)
    assert measures.sliding == pytest.approx([0.0, 0.05], abs=1e-14)
    assert measures.opening == pytest.approx([0.0, 0.0], abs=1e-14)
    assert measures.contact_area == pytest.approx([0.25, 0.47 * 0.46])


@pytest.mark.parametrize("angle", [1e-5, 1e-3, 0.3])
def test_a_known_hinge_comes_back(angle):
    assembly = Assembly.from_blocks(tower(2, side=0.5, height=0.25), 0.6)
    joints = find_joints(assembly)
    measures = measure_joints(joints, assembly, turned(assembly, 2, (0.0, 1.0, 0.0), angle, (0.25, 0.0, 0.25)))
    assert measures.rotation == pytest.approx([0.0, angle], rel=1e-9)
    assert measures.opening == pytest.approx([0.0, 0.5 * np.sin(angle)], rel=1e-9)
    assert measures.sliding[1] < 1e-3 * angle * 0.5
    open_from = min(0.5, 1e-4 / np.sin(angle))  # distance from the hinge to where the joint is 0.1 mm open
    assert measures.contact_area[1] == pytest.approx(open_from * 0.5, rel=1e-9)


def test_the_measures_do_not_change_when_everything_moves_together():
    assembly = Assembly.from_blocks(tower(2), 0.6)
    joints = find_joints(assembly)
    state = turned(assembly, 2, (0.0, 1.0, 0.0), 0.1, (0.25, 0.0, 0.25))
    before = measure_joints(joints, assembly, state)
    w, z = np.cos(0.4), np.sin(0.4)  # about z through the origin
    c, s = np.cos(0.8), np.sin(0.8)
    state.position = state.position @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + [3.0, -1.0, 2.0]
    a, b, p, q = state.orientation.T
    state.orientation = np.stack([w * a - z * q, w * b - z * p, w * p + z * b, w * q + z * a], axis=1)
    after = measure_joints(joints, assembly, state)
    for name in ("opening", "sliding", "rotation", "contact_area"):
        assert getattr(after, name) == pytest.approx(getattr(before, name), abs=1e-12)


def test_peaks_remember_the_worst_and_the_first_opening():
    assembly = Assembly.from_blocks([ground(), box("b", (0, 0, 0), (1, 1, 1))], 0.6)
    joints = find_joints(assembly)
    peaks = JointPeaks(joints)
    for time, lift in ((1.0, 0.0), (2.0, 5e-4), (3.0, 2e-3), (4.0, 0.0)):
        state = State.at_rest(assembly)
        state.position[1, 2] += lift
        peaks.update(measure_joints(joints, assembly, state), time)
    assert peaks.opening == pytest.approx([2e-3])
    assert peaks.first_opening_time.tolist() == [2.0]
    assert peaks.contact_area_loss == pytest.approx([1.0])


def long_plate(name: str, y: float, sides: int, upright: bool) -> Block:
    """A plate of 4 m x 1 m, whose ends are arcs of a given number of sides: its mesh is of slivers along it, from one end to the other."""
    s = np.linspace(-0.5, 0.5, sides + 1)
    end = np.stack([2.0 + 0.01 * (1.0 - 4.0 * s * s), s], axis=1)
    outline = np.concatenate([end, -end])
    return Block(name, *prism_xz(outline[:, ::-1] if upright else outline, y, y + 0.3), 2000.0, name)


def crossed(sides: int) -> tuple[Detector, Assembly]:
    """Two such plates against each other, at right angles."""
    material = ElasticBlocks.model_validate({"deformable": "tetrahedra", "young": 1e9, "mesh_size": 10.0})
    blocks = [long_plate("level", 0.0, sides, False), long_plate("upright", 0.3, sides, True)]
    assembly = Assembly.from_blocks(blocks, material_of(0.6, None, material))
    warps = Warps.of(assembly, None, 12)
    assert warps is not None
    return Detector(assembly, facets=warps.facets), assembly


def detect(detector: Detector, assembly: Assembly, apart: float = 0.0) -> ContactSet:
    """The contacts of the plates as built, or apart [m]."""
    state = State.at_rest(assembly)
    state.position[1, 1] += apart
    return detector.detect(state.position, rotation_matrices(state.orientation), np.zeros((2, 6)), 1e-3, 1e-4, np.zeros(3))


def test_slivers_that_cross_touch_wherever_their_sides_do() -> None:
    found = detect(*crossed(2))
    assert len(found.gap) > 8  # the corners of the overlap, and what is within
    assert np.abs(found.gap).max() < 1e-9


def test_meshes_that_cross_in_too_many_points_name_their_blocks() -> None:
    detector, assembly = crossed(14)
    with pytest.raises(TooManyPoints) as crowd:
        detect(detector, assembly)
    assert crowd.value.blocks == (0, 1)
    assert len(detect(detector, assembly, 0.1).gap) == 0  # nothing of it is left once they are apart


RADIUS = 0.25
TABLE = box("table", (-1.0, -1.0, -1.0), (0.0, 0.0, 0.0), fixed=True)


def ball(centre: tuple[float, float, float], name: str = "ball", radius: float = RADIUS) -> Block:
    return Block.sphere(name, np.array(centre), radius, 2000.0)


def detect_contact(blocks: list[Block], slack: float = 0.1, rolling: float = 0.0) -> ContactSet:
    assembly = Assembly.from_blocks(blocks, material_of(0.6, rolling=rolling))
    state = State.at_rest(assembly)
    still = np.zeros((assembly.count, 6))
    return Detector(assembly).detect(state.position, rotation_matrices(state.orientation), still, 1e-3, slack, np.zeros(3))


D = RADIUS + 0.02
SLOPED = np.sqrt(0.5) * D


@pytest.mark.parametrize(
    ("centre", "normal"),
    [
        ((-0.3, -0.4, D), (0.0, 0.0, 1.0)),
        ((-0.3, SLOPED, SLOPED), (0.0, np.sqrt(0.5), np.sqrt(0.5))),
        (tuple(np.full(3, np.sqrt(1 / 3) * D)), tuple(np.full(3, np.sqrt(1 / 3)))),
    ],
    ids=["face", "edge", "corner"],
)
@pytest.mark.parametrize("first", [False, True], ids=["table first", "ball first"])
def test_a_sphere_touches_where_it_is_nearest(centre, normal, first):
    blocks = [ball(centre), TABLE] if first else [TABLE, ball(centre)]
    contacts = detect_contact(blocks)
    assert contacts.gap == pytest.approx([0.02])
    sign = 1.0 if contacts.bodies[0, 0] == blocks.index(TABLE) else -1.0  # the normal points to the candidate
    assert -sign * contacts.normal[0] == pytest.approx(np.array(normal), abs=1e-15)
    assert contacts.point[0] == pytest.approx(np.array(centre) - (RADIUS + 0.01) * np.array(normal))


def test_a_sphere_whose_centre_is_in_a_block_is_freed_by_its_least_deep_face():
    contacts = detect_contact([TABLE, ball((-0.3, -0.4, -0.05))])
    assert contacts.gap == pytest.approx([-0.05 - RADIUS])
    assert contacts.normal[0] == pytest.approx([0.0, 0.0, 1.0])


def test_two_spheres_touch_between_their_centres():
    contacts = detect_contact([TABLE, ball((3.0, 0.0, 0.0), "a"), ball((3.0, 0.3, 0.4), "b", 0.2)])
    assert contacts.gap == pytest.approx([0.5 - RADIUS - 0.2])
    assert contacts.normal[0] == pytest.approx([0.0, 0.6, 0.8])
    assert contacts.point[0] == pytest.approx(np.array([3.0, 0.0, 0.0]) + (RADIUS + 0.025) * np.array([0.0, 0.6, 0.8]))


def test_the_distance_from_a_polyhedron_is_that_from_its_convex_hull():
    """Against the least-squares problem over the weights of the corners."""
    random = np.random.default_rng(4)
    wedge = Block(
        "w", np.array([[0, 0, 0], [1, 0, 0], [0.3, 1.2, 0], [0.4, 0.3, 0.7]], dtype=float), ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
    )
    places = random.uniform(-1.0, 2.0, (300, 3))
    blocks = [wedge, *(ball(tuple(place), f"b{k}", 0.01) for k, place in enumerate(places))]
    shapes = ConvexShapes.of(blocks, np.zeros((len(blocks), 3)))
    pairs = np.array([[0, k] for k in range(1, len(blocks))])
    depth = round_depths(shapes.solids, shapes.rounding, pairs)
    system = np.vstack([wedge.vertices.T, np.full(4, 1e3)])
    hull = np.array([nnls(system, np.append(place, 1e3))[1] for place in places])
    outside = hull > 1e-3
    assert outside.sum() > 200
    assert 0.01 - depth[outside] == pytest.approx(hull[outside], abs=1e-5)
    assert (depth[~outside] > 0.01 - 1e-3).all()


def test_a_contact_that_rolls_stays_the_same():
    assembly = Assembly.from_blocks([TABLE, ball((-0.9, -0.5, RADIUS))], material_of(0.6, rolling=0.1))
    state, detector = State.at_rest(assembly), Detector(assembly)
    velocity = np.zeros((2, 6))
    for turn in (0.0, 0.5, 1.0):
        state.position[1, 0] = -0.9 + turn * RADIUS
        state.orientation[1] = [np.cos(turn / 2), 0.0, np.sin(turn / 2), 0.0]
        found = detector.detect(state.position, rotation_matrices(state.orientation), velocity, 1e-3, 1e-3, np.zeros(3))
        assert found.previous.tolist() == ([-1] * 4 if turn == 0.0 else [0, 1, 2, 3])


def test_rolling_friction_spreads_a_contact_along_the_rolling():
    contacts = detect_contact([TABLE, ball((-0.5, -0.5, RADIUS))], rolling=0.1)
    offset = contacts.point - [-0.5, -0.5, 0.0]
    assert np.linalg.norm(offset, axis=1) == pytest.approx(np.full(4, 0.1 * RADIUS))
    assert offset.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-15)
    two = detect_contact([TABLE, ball((3.0, 0.0, 0.0), "a"), ball((3.0, 0.0, 0.45), "b", 0.2)], rolling=0.1)
    effective = RADIUS * 0.2 / (RADIUS + 0.2)
    assert np.linalg.norm(two.point - two.point.mean(axis=0), axis=1) == pytest.approx(np.full(4, 0.1 * effective))
    assembly = Assembly.from_blocks([TABLE, ball((-0.5, -0.5, RADIUS))], material_of(0.6, rolling=0.1))
    velocity = np.zeros((2, 6))
    velocity[1, 3:] = [0.6, 0.8, 5.0]  # rolls along (0.8, -0.6)
    state = State.at_rest(assembly)
    found = Detector(assembly).detect(state.position, rotation_matrices(state.orientation), velocity, 1e-3, 0.0, np.zeros(3))
    offset = found.point - [-0.5, -0.5, 0.0]
    assert np.abs(offset[:2] @ [0.8, -0.6, 0.0]) == pytest.approx(np.full(2, 0.1 * RADIUS))
    assert np.abs(offset[2:] @ [0.8, -0.6, 0.0]) == pytest.approx(np.zeros(2), abs=1e-15)


def test_spheres_make_no_joints():
    assembly = Assembly.from_blocks([TABLE, ball((-0.5, -0.5, RADIUS))], material_of(0.6, rolling=0.1))
    assert find_joints(assembly).count == 0


def test_a_sphere_has_its_exact_mass():
    assembly = Assembly.from_blocks([TABLE, ball((1.0, 2.0, 3.0))], 0.6)
    mass = 2000.0 * 4.0 / 3.0 * np.pi * RADIUS**3
    assert assembly.mass[1] == pytest.approx(mass, rel=1e-15)
    assert assembly.inertia[1] == pytest.approx(0.4 * mass * RADIUS**2 * np.eye(3), rel=1e-15)
    assert assembly.centre[1].tolist() == [1.0, 2.0, 3.0]
    assert assembly.shapes.size[1] == 2 * RADIUS
    assert assembly.reach[1] == RADIUS
