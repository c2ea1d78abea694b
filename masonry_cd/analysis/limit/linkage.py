# SPDX-License-Identifier: GPL-3.0-or-later
r"""The mechanism of a macro-element as a linkage that is followed at finite displacements: its capacity curve, [C8.7.1.3] and [C8.7.1.4].

The blocks that move as one are a body: so a mechanism is a few rigid bodies, joined to one another and to what is held by the contacts that
they have wherever they are. What lasts to collapse acts on them (C8.7.1.2.1.6): weights, floors and point loads, which go with their body,
and ties at the force at which they yield. Not so bond and the friction of interlock: the bodies are dry, and held stones that rest on the
part are left out. Joints between two bodies have the least friction that they had between any two blocks.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_cd.analysis.limit.analysis import LimitOptions
from masonry_cd.analysis.limit.capacity import CapacityCurve, CurveOptions, capacity_curve
from masonry_cd.analysis.limit.found import FoundMechanism
from masonry_cd.analysis.limit.mechanism import Mechanism
from masonry_cd.analysis.limit.oscillator import BY_LINKAGE, Oscillator, bodies_of, oscillator
from masonry_cd.analysis.limit.part import FreedPart
from masonry_cd.analysis.limit.problem import Arms, Bars, BlockLoads
from masonry_cd.analysis.limit.solution import Unbounded
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly, Block, ConvexShapes
from masonry_cd.mechanics.model.geometry import Faces
from masonry_cd.mechanics.model.joint_laws import crushing, joint_table

AT_ONCE = 1e-9  # share of the last displacement at which the friction of interlock is gone


def with_displacements(part: FreedPart, one: FoundMechanism, seed: int) -> Oscillator:
    """The oscillator of a mechanism of a part with the displacements at which its factor falls; or with the reason why none is known."""
    made, moves = one.oscillator, one.mechanism
    if made.doubt or moves is None:
        return made
    if part.problem.sections is not None:
        return replace(made, end=crushing.LAW.at_start_only)
    try:
        curve = followed(part, moves, seed)
    except (InputError, Unbounded) as failure:
        return replace(made, end=f"its mechanism is not followed: {failure}")
    known = oscillator(part, moves, made.alpha - _interlock(part, moves), one.dilation, curve)
    if not known.falls:
        return replace(made, end=known.end)
    place = np.concatenate([[0.0, AT_ONCE * known.displacement[-1]], known.displacement[1:]])
    return replace(known, alpha=made.alpha, displacement=place, factor=np.concatenate([[made.alpha], known.factor]), by=BY_LINKAGE)


def _interlock(part: FreedPart, mechanism: Mechanism) -> float:
    """The share of a factor that is due to the friction of interlock."""
    moves, bars = mechanism.velocity, part.beds
    line = bars.points[:, 1] - bars.points[:, 0]
    line /= np.linalg.norm(line, axis=1, keepdims=True)
    ends = moves[bars.blocks, :3] + np.cross(moves[bars.blocks, 3:], bars.points - part.assembly.centre[bars.blocks])
    longer = np.maximum(np.einsum("td,td->t", ends[:, 1] - ends[:, 0], line), 0.0)
    return float(longer @ bars.strength) / float(np.sum(part.loads.live * moves))


def followed(part: FreedPart, moves: Mechanism, seed: int) -> CapacityCurve:
    """The capacity curve of a mechanism; its control point is the centre of the body that goes fastest along the push.

    Raises:
        InputError: bodies that do not stand without what does not last.
        Unbounded: no answer of a solver.
    """
    moving = moves.moving & part.free
    body = np.full(len(moving), -1)
    body[moving] = np.unique(bodies_of(moves, part.whole.joints, moving)[moving], return_inverse=True)[1]
    kept = _neighbours(part, moving)
    assembly = _assembly(part, body, kept)
    loads = _loads(part, body, kept, assembly)
    rate = np.array([_velocity(moves, part.assembly, body, k, assembly.centre[k]) for k in range(int(body.max()) + 1)])
    velocity = np.zeros((assembly.count, 6))
    velocity[: len(rate)] = rate
    fastest = int(np.argmax(rate[:, :3] @ part.push))
    how = CurveOptions(LimitOptions(starts=1, seed=seed), control=fastest, mechanism=velocity)
    curve = capacity_curve(assembly, find_joints(assembly), loads, how)
    return replace(curve, control=replace(curve.control, block=int(np.flatnonzero(body == fastest)[0])))


def _velocity(moves: Mechanism, assembly: Assembly, body: np.ndarray, k: int, place: np.ndarray) -> np.ndarray:
    """Velocity (6,) of a body at a place [m]."""
    one = int(np.flatnonzero(body == k)[0])
    moved = moves.velocity[one]
    return np.concatenate([moved[:3] + np.cross(moved[3:], place - assembly.centre[one]), moved[3:]])


def _neighbours(part: FreedPart, moving: np.ndarray) -> np.ndarray:
    """Blocks that do not move and touch those that do, or are tied to them; no held stones that rest on them."""
    whole = part.whole
    touches = np.zeros(len(moving), dtype=bool)
    for one, other in ((whole.joints.block_a, whole.joints.block_b), (whole.joints.block_b, whole.joints.block_a)):
        touches[other[moving[one]]] = True
    upper, lower = whole.upper, whole.lower
    on = (upper >= 0) & moving[lower]
    touches[upper[on & ~part.free[upper]]] = False
    tied = whole.bars.blocks[moving[whole.bars.blocks].any(axis=1)]
    touches[tied.ravel()] = True
    return np.flatnonzero(touches & ~moving)


def _assembly(part: FreedPart, body: np.ndarray, kept: np.ndarray) -> Assembly:
    """The bodies and then the blocks that are kept, which are held; each is a group of its own."""
    old, count = part.assembly, int(body.max()) + 1
    members = [np.flatnonzero(body == k) for k in range(count)] + [np.array([b]) for b in kept]
    mass = np.array([old.mass[own].sum() for own in members])
    centre = np.array([old.mass[own] @ old.centre[own] / old.mass[own].sum() for own in members])
    blocks = tuple(_body(f"body {k + 1}" if k < count else old.names[own[0]], old, own, k >= count) for k, own in enumerate(members))
    names, fixed = tuple(block.name for block in blocks), np.arange(len(blocks)) >= count
    owner = np.full(old.count, -1)
    for k, own in enumerate(members):
        owner[own] = k
    friction = _friction(part, owner, len(blocks))
    return Assembly(
        blocks=blocks, names=names, groups=names, group_of=np.arange(len(blocks)), fixed=fixed, support_of=np.where(fixed, 0, -1),
        mass=mass, inertia=np.array([mass[k] * np.eye(3) for k in range(len(blocks))]), centre=centre,
        volume=np.array([old.volume[own].sum() for own in members]), friction=friction, rolling=np.zeros_like(friction),
        restitution=np.zeros_like(friction), laws=joint_table({}, names, friction), shapes=ConvexShapes.of(blocks, centre),
    )  # fmt: skip


def _body(name: str, assembly: Assembly, own: np.ndarray, fixed: bool) -> Block:
    """Some blocks as one, of as many convex parts."""
    blocks = [assembly.blocks[b] for b in own]
    faces: list[tuple[int, ...]] = []
    first = 0
    for block in blocks:
        faces += [tuple(first + i for i in face) for face in block.faces]
        first += len(block.vertices)
    made: Faces = tuple(faces)
    parts = tuple(part for block in blocks for part in block.convex_parts)
    return Block(name, np.concatenate([block.vertices for block in blocks]), made, group=name, fixed=fixed, parts=parts)


def _friction(part: FreedPart, owner: np.ndarray, count: int) -> np.ndarray:
    """Between bodies (count, count): the least of any joint between the two; the least of all between those that have none."""
    assembly, joints = part.assembly, part.whole.joints
    out = np.full((count, count), np.inf)
    ends = np.stack([owner[joints.block_a], owner[joints.block_b]], axis=1)
    some = (ends >= 0).all(axis=1) & (ends[:, 0] != ends[:, 1])
    mu = assembly.friction[assembly.rows(joints.block_a[some], joints.block_b[some])]
    for a, b in ((0, 1), (1, 0)):
        np.minimum.at(out, (ends[some][:, a], ends[some][:, b]), mu)
    return np.where(np.isfinite(out), out, float(assembly.friction.min()))


def _loads(part: FreedPart, body: np.ndarray, kept: np.ndarray, made: Assembly) -> BlockLoads:
    """Return the loads that last to collapse, on the bodies."""
    old, count, whole = part.assembly, int(body.max()) + 1, part.whole
    moving = np.flatnonzero(body >= 0)
    dead, live = np.zeros((made.count, 6)), np.zeros((made.count, 6))
    shift = old.centre[moving] - made.centre[body[moving]]
    for out, forces in ((dead, part.loads.dead), (live, part.loads.live)):
        moment = forces[moving, 3:] + np.cross(shift, forces[moving, :3])
        np.add.at(out, body[moving], np.concatenate([forces[moving, :3], moment], axis=1))
    owner = body.copy()
    owner[kept] = count + np.arange(len(kept))
    arms = part.loads.arms
    assert arms is not None
    some = np.flatnonzero(body[arms.block] >= 0)
    block = arms.block[some]
    moved = Arms(body[block], arms.arm[some] + old.centre[block] - made.centre[body[block]], arms.dead[some], arms.live[some])
    ends = owner[whole.bars.blocks]
    tied = (body[whole.bars.blocks] >= 0).any(axis=1) & (ends[:, 0] != ends[:, 1])
    bars = Bars(ends[tied], whole.bars.points[tied], whole.bars.strength[tied])
    return BlockLoads(dead, live, bars, None, moved)
