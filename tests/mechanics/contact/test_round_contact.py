# SPDX-License-Identifier: GPL-3.0-or-later
"""Where spheres touch: spheres, faces, edges and corners; the points of rolling friction; and the identity of a contact that rolls."""

import numpy as np
import pytest
from models import box, material_of
from scipy.optimize import nnls

from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.contact.round_contact import round_depths
from masonry_cd.mechanics.model.blocks import Assembly, Block, Shapes
from masonry_cd.mechanics.model.state import State, rotation_matrices

RADIUS = 0.25
TABLE = box("table", (-1.0, -1.0, -1.0), (0.0, 0.0, 0.0), fixed=True)


def ball(centre: tuple[float, float, float], name: str = "ball", radius: float = RADIUS) -> Block:
    return Block.sphere(name, np.array(centre), radius, 2000.0)


def detect(blocks: list[Block], slack: float = 0.1, rolling: float = 0.0) -> ContactSet:
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
    contacts = detect(blocks)
    assert contacts.gap == pytest.approx([0.02])
    sign = 1.0 if contacts.bodies[0, 0] == blocks.index(TABLE) else -1.0  # the normal points to the candidate
    assert -sign * contacts.normal[0] == pytest.approx(np.array(normal), abs=1e-15)
    assert contacts.point[0] == pytest.approx(np.array(centre) - (RADIUS + 0.01) * np.array(normal))


def test_a_sphere_whose_centre_is_in_a_block_is_freed_by_its_least_deep_face():
    contacts = detect([TABLE, ball((-0.3, -0.4, -0.05))])
    assert contacts.gap == pytest.approx([-0.05 - RADIUS])
    assert contacts.normal[0] == pytest.approx([0.0, 0.0, 1.0])


def test_two_spheres_touch_between_their_centres():
    contacts = detect([TABLE, ball((3.0, 0.0, 0.0), "a"), ball((3.0, 0.3, 0.4), "b", 0.2)])
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
    shapes = Shapes.of(blocks, np.zeros((len(blocks), 3)))
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
    contacts = detect([TABLE, ball((-0.5, -0.5, RADIUS))], rolling=0.1)
    offset = contacts.point - [-0.5, -0.5, 0.0]
    assert np.linalg.norm(offset, axis=1) == pytest.approx(np.full(4, 0.1 * RADIUS))
    assert offset.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-15)
    two = detect([TABLE, ball((3.0, 0.0, 0.0), "a"), ball((3.0, 0.0, 0.45), "b", 0.2)], rolling=0.1)
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
