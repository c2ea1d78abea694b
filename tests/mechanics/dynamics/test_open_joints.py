"""Elastic joints that open: moments against the closed form of a bed without tension, shares of area, slip that goes on, equal bits."""

import numpy as np
import pytest
from models import GRAVITY, box, gravity, ground, stepper, turned
from scipy.optimize import brentq

from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.dynamics.equilibrium import settle
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.materials import JointLaw
from masonry_cd.mechanics.model.state import State, rotation_matrices

DEPTH, WIDTH, STIFFNESS, WEIGHT = 0.5, 0.3, 2e10, 2e4  # [m], [N/m3], [N]
LAW = {"default": JointLaw(normal_stiffness=STIFFNESS)}
RECTANGLE = 0.5 * np.array([[-DEPTH, -WIDTH], [DEPTH, -WIDTH], [DEPTH, WIDTH], [-DEPTH, WIDTH]])
TRIANGLE = np.array([[-0.25, -0.15], [0.25, -0.15], [-0.05, 0.3]])
ODD = np.array([[-0.3, -0.2], [0.3, -0.15], [0.35, 0.05], [0.0, 0.25], [-0.25, 0.15]])


def prism(corners: np.ndarray) -> Block:
    """An upright prism, 1 m high, over a convex polygon (n, 2), counter-clockwise."""
    n = len(corners)
    vertices = np.array([[*corner, z] for z in (0.0, 1.0) for corner in corners])
    sides = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    return Block("b", vertices, (tuple(range(n))[::-1], tuple(range(n, 2 * n)), *sides), 2000.0)


class Bed:
    """A block on an elastic joint, turned about an axis of its bed."""

    def __init__(self, corners: np.ndarray, axis: tuple[float, float], law: dict[str, JointLaw] | None = None) -> None:
        self.assembly = Assembly.from_blocks([ground(), prism(corners)], 0.6, law or LAW)
        self.axis = np.array([*axis, 0.0]) / np.hypot(*axis)

    def contacts(self, angle: float, sunk: float) -> ContactSet:
        """Those of the block turned by an angle [rad] and sunk [m], whose joint was closed before."""
        detector, moved = Detector(self.assembly), turned(self.assembly, 1, tuple(self.axis), angle, (0.0, 0.0, 0.0))
        moved.position[1, 2] -= sunk
        for state in (State.at_rest(self.assembly), moved):
            found = detector.detect(state.position, rotation_matrices(state.orientation), np.zeros((2, 6)), 1e-3, 1.0, np.zeros(3))
        return found

    def under_weight(self, angle: float) -> ContactSet:
        """Those in which the joint carries WEIGHT."""
        sunk = brentq(lambda z: pressure(self.contacts(angle, z)).sum() - WEIGHT, -0.6 * angle, 0.6 * angle + 1e-4, xtol=1e-16)
        return self.contacts(angle, sunk)


def pressure(found: ContactSet) -> np.ndarray:
    """Normal forces of the springs (C,) [N]."""
    return STIFFNESS * found.area * np.maximum(0.0, -found.gap)


def closed_form(size: float, across: float, angle: float) -> float:
    """Moment of a bed without tension, ``size`` deep and ``across`` wide [m], turned by an angle [N m]."""
    touching = np.sqrt(2.0 * WEIGHT / (STIFFNESS * across * angle))
    if touching > size:
        return float(STIFFNESS * across * size**3 / 12.0 * angle)
    return float(WEIGHT * (0.5 * size - touching / 3.0))


def in_strips(corners: np.ndarray, axis: np.ndarray, angle: float) -> np.ndarray:
    """Moments (2,) [N m] about x and y of the pressure over a polygon, point by point."""
    side = np.linspace(-0.4, 0.4, 801)
    x, y = (values.ravel() for values in np.meshgrid(side, side))
    a, b = corners, np.roll(corners, -1, axis=0)
    inside = np.all([(q - p)[0] * (y - p[1]) - (q - p)[1] * (x - p[0]) >= 0.0 for p, q in zip(a, b, strict=True)], axis=0)
    x, y = x[inside], y[inside]
    lift, share = angle * (axis[0] * y - axis[1] * x), STIFFNESS * 1e-6

    def forces(sunk: float) -> np.ndarray:
        return np.asarray(share * np.maximum(0.0, sunk - lift))

    p = forces(brentq(lambda sunk: forces(sunk).sum() - WEIGHT, -0.01, 0.01, xtol=1e-16))
    return np.array([p @ y, -p @ x])


@pytest.mark.parametrize(("axis", "size", "across"), [((0.0, 1.0), DEPTH, WIDTH), ((1.0, 0.0), WIDTH, DEPTH)])
def test_a_bed_without_tension_has_the_moment_of_its_closed_form(axis, size, across):
    """From the joint that is closed to one that touches over a twentieth of its depth; corners and centroid alone are 37 % off."""
    bed = Bed(RECTANGLE, axis)
    for touching in (1.5, 0.95, 0.7, 0.5, 0.3, 0.1, 0.05):
        angle = 2.0 * WEIGHT / (STIFFNESS * across * (touching * size) ** 2)
        found = bed.under_weight(angle)
        moment = pressure(found) @ (bed.axis[1] * found.point[:, 0] - bed.axis[0] * found.point[:, 1])
        assert moment == pytest.approx(closed_form(size, across, angle), rel=1e-3)


@pytest.mark.parametrize("corners", [RECTANGLE, TRIANGLE, ODD])
@pytest.mark.parametrize("direction", [0.0, 0.6, 1.2, 2.2, 3.5, 5.0])
def test_a_bed_of_any_shape_bends_right_about_any_axis(corners, direction):
    bed = Bed(corners, (np.cos(direction), np.sin(direction)))
    for angle in (5e-5, 2e-4, 1e-3):
        found = bed.under_weight(angle)
        p = pressure(found)
        exact = in_strips(corners, bed.axis, angle)
        assert np.array([p @ found.point[:, 1], -p @ found.point[:, 0]]) == pytest.approx(exact, abs=0.03 * np.hypot(*exact))


@pytest.mark.parametrize("corners", [RECTANGLE, TRIANGLE, ODD])
@pytest.mark.parametrize("cohesion", [0.0, 1e5])
def test_what_touches_and_what_is_open_share_the_area(corners, cohesion):
    """Each with its own centroid; corners stay."""
    law = {"default": JointLaw(normal_stiffness=STIFFNESS, cohesion=cohesion)}
    bed = Bed(corners, (0.3, 1.0), law)
    closed, open_ = bed.contacts(0.0, 1e-6), bed.contacts(4e-5, 0.0)
    assert len(closed.gap) == len(corners) + 1
    assert closed.area.sum() == pytest.approx(open_.area.sum(), rel=1e-8)
    assert open_.area.min() > 0.0
    touching = open_.gap <= 1e-12
    whole, at = closed.area @ closed.point[:, :2], open_.area @ open_.point[:, :2]
    if cohesion:  # exact where the open part is pulled, too
        assert at == pytest.approx(whole, abs=0.02 * closed.area.sum())
    assert 0.2 < open_.area[touching].sum() / open_.area.sum() < 0.8
    for corner in corners:
        assert np.hypot(*(open_.point[:, :2] - corner).T).min() < 1e-4


def test_rigid_joints_and_joints_that_only_lean_keep_their_corners():
    rigid = Bed(RECTANGLE, (0.0, 1.0), {"block-block": JointLaw(normal_stiffness=1e9)})
    assert len(rigid.contacts(1e-4, 0.0).gap) == 4
    assert len(Bed(RECTANGLE, (0.0, 1.0)).contacts(1e-5, 1e-4).gap) == 5


# --- in a run ---------------------------------------------------------------------------------------------------------------------


def pushed(planar: bool, share: float, steps: int) -> Stepper:
    """A block on its bed under a push on its centre that grows to a share of what turns it over, stays, and goes back to none."""
    blocks, pull = [ground(), box("b", (-0.25, -0.5, 0.0), (0.25, 0.5, 2.0))], gravity(steps)
    time = np.arange(steps + 1) / steps
    pull[:, 0] = GRAVITY * share * 0.25 * np.interp(time, [0.0, 0.25, 0.6, 0.85], [0.0, 1.0, 1.0, 0.0])
    law = {"default": JointLaw(normal_stiffness=2e9, damping=0.3, damping_frequency=10.0)}
    out = stepper(blocks, steps, dt=5e-3, friction=0.7, joints=law, acceleration=pull, planar=planar, solver="auto", tolerance=1e-8)
    settle(out)
    return out


@pytest.mark.parametrize("planar", [True, False])
def test_a_push_turns_a_block_as_far_as_the_closed_form_says_and_back(planar):
    """At 70 % of the push that turns a rigid block over; N = W, M = F H/2 + W H/2 theta, and c from theta."""
    steps, share = 800, 0.7
    machine = pushed(planar, share, steps)
    weight, begin = machine.assembly.mass[1] * GRAVITY, machine.state.position[1].copy()
    for _ in range(480):
        machine.step()
    theta = 2.0 * np.arctan2(machine.state.orientation[1, 2], machine.state.orientation[1, 0])

    def out_of_balance(angle: float) -> float:
        touching = np.sqrt(2.0 * weight / (2e9 * angle))
        bed = weight * (0.25 - touching / 3.0) if touching < 0.5 else 2e9 * 0.5**3 / 12.0 * angle
        return float(bed - weight * angle - weight * share * 0.25)

    expected = brentq(out_of_balance, 1e-6, 2e-3)
    assert theta == pytest.approx(expected, rel=0.02)
    for _ in range(320):
        machine.step()
    slip = share * 0.25 * weight / (2e9 / 2.4 * np.sqrt(2.0 * weight / (2e9 * expected)))  # of what touched at the most, elastic
    assert np.abs(machine.state.position[1] - begin)[:2].max() < 1.2 * slip
    assert abs(machine.state.orientation[1, 2]) < 0.01 * expected
    energy = machine.energy
    assert abs(energy["balance"]) < 1e-9 * abs(energy["gravity_work"]) + 1e-9 * energy["elastic"]


def test_a_stepper_resumes_amid_an_opening_joint_to_the_same_bits():
    first = pushed(False, 0.7, 300)
    for _ in range(130):
        first.step()
    assert len(first.last.found.gap) > 5
    second = pushed(False, 0.7, 300)
    second.restore({name: array.copy() for name, array in first.snapshot().items()})
    for machine in (first, second):
        for _ in range(40):
            machine.step()
    assert first.state.position.tobytes() == second.state.position.tobytes()
    assert first.energy == second.energy
