# SPDX-License-Identifier: GPL-3.0-or-later
r"""How a part gave way: words for its mechanism, from the geometry of a frame alone.

By the first rule that holds; ``others`` lists those that hold as well:

1. *falling blocks*: at least one block of the part has fallen (:mod:`masonry_cd.analysis.damage.joint_damage`).
2. *out-of-plane overturning*: a piece of the part that is a wall (``thin`` or thinner in plan, and higher than it is thick) has turned
   about the direction of its length. A *piece* is a set of blocks joined inside the part: the two walls of a nave are two pieces.
   It has turned when the blocks of its upper half, of volumes V and rotation vectors w, turn enough about the axis a, and mostly in
   one sense:

       | sum V w . a | >= turned * sum V      and      | sum V w . a | >= coherent * sum V |w . a|

3. *overturning*: likewise, about any horizontal axis, of a piece that is compact in plan and higher than wide: a tower, a pier.
4. *hinging*, *sliding* or *parting*, by the largest of these sums over the part's joints between standing blocks [m3]:

       hinging  area * opening of joints that are open at one side and touch at the other
       sliding  area * sliding of slid joints
       parting  area * smallest gap of joints that are open over their whole face

5. *none*.

Joints below the thresholds of damage count nothing. The rules see a frame, at the end of a run what has remained: an arch that has
rocked on four hinges and closed again shows none.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from masonry_cd.analysis.damage.macro_elements import DamageSnapshot, MacroElements
from masonry_cd.analysis.deformed import Solids
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.components import connected_components
from masonry_cd.mechanics.model.joints import Joints

NONE, HINGING, SLIDING, PARTING = "none", "hinging", "sliding", "parting"
FALLING, OUT_OF_PLANE, OVERTURNING = "falling blocks", "out-of-plane overturning", "overturning"
MECHANISMS = (NONE, PARTING, SLIDING, HINGING, OVERTURNING, OUT_OF_PLANE, FALLING)


@dataclass(frozen=True)
class Rules:
    """Numbers of the rules above.

    Attributes:
        turned: rotation of a piece that overturns [rad]; 0.01 rad is a lean of 1 %.
        coherent: share of the turning that must be in one sense.
        thin: thickness of a wall over its length.
        slender: height of a compact piece over its longer side in plan.
    """

    turned: float = 0.01
    coherent: float = 0.5
    thin: float = 0.5
    slender: float = 1.25

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not (np.isfinite(value) and value > 0):
                raise InputError(f"rules.{item.name}", f"must be positive, got {value!r}")


@dataclass(frozen=True, eq=False)
class RockingPiece:
    """Blocks joined inside a part that could overturn together."""

    part: int
    upper: np.ndarray  # indices of the blocks of its upper half
    axis: np.ndarray | None  # (3,) direction of its length when it is a wall, None when it is compact


@dataclass(frozen=True)
class PartMechanism:
    """The mechanism found in a part.

    Attributes:
        name: one of MECHANISMS.
        others: which others hold as well.
        turn: largest mean rotation of a piece [rad], of those that may overturn.
        towards: where the top of that piece went, e.g. ``+y``; empty where it did not turn.
    """

    name: str
    others: tuple[str, ...]
    turn: float
    towards: str


def pieces_of(solids: Solids, joints: Joints, parts: MacroElements, rules: Rules) -> tuple[RockingPiece, ...]:
    """The pieces of all parts that are walls, or compact and slender, by their shape at rest."""
    found = []
    count = len(solids.centre)
    for p in range(parts.parts):
        inside = parts.blocks[p][joints.block_a] & parts.blocks[p][joints.block_b]
        label = connected_components(joints.block_a[inside], joints.block_b[inside], count)
        mine = np.flatnonzero(parts.blocks[p])
        order = mine[np.argsort(label[mine], kind="stable")]
        for members in np.split(order, np.flatnonzero(np.diff(label[order])) + 1):
            piece = _piece(p, members, solids, parts, rules)
            if piece is not None:
                found.append(piece)
    return tuple(found)


def mechanisms(
    snapshot: DamageSnapshot, joints: Joints, parts: MacroElements, pieces: tuple[RockingPiece, ...], rules: Rules
) -> tuple[PartMechanism, ...]:
    """The mechanism of each part and, after these, of each structure and of all: the gravest of their parts'."""
    weights = _joint_weights(snapshot, joints)
    turn, towards = np.zeros(parts.count), [""] * parts.count
    held: list[set[str]] = [set() for _ in range(parts.count)]
    spin = _rotation_vectors(snapshot.pose.rotation) if pieces else np.empty((0, 3))
    for piece in pieces:
        angle, direction = _turn(piece, snapshot, parts, spin, rules)
        if angle > turn[piece.part]:
            turn[piece.part], towards[piece.part] = angle, direction
        if angle >= rules.turned:
            held[piece.part].add(OVERTURNING if piece.axis is None else OUT_OF_PLANE)
    out = []
    for p in range(parts.count):
        if p >= parts.parts:
            own = parts.parts_of(p)
            gravest = own[int(np.argmax(turn[own]))]
            turn[p], towards[p] = turn[gravest], towards[gravest]
            held[p] = set().union(*(held[part] for part in own))
        score = {name: float(weights[name][parts.joints[p]].sum()) for name in weights}
        held[p] |= {name for name, value in score.items() if value > 0}
        if (snapshot.down & parts.blocks[p]).any():
            held[p].add(FALLING)
        ranked = sorted(held[p], key=lambda name: (name in score, -score.get(name, 0.0), -MECHANISMS.index(name)))
        out.append(PartMechanism(ranked[0] if ranked else NONE, tuple(ranked[1:]), float(turn[p]), towards[p]))
    return tuple(out)


def _joint_weights(snapshot: DamageSnapshot, joints: Joints) -> dict[str, np.ndarray]:
    """(J,) contribution of each joint to the three sums of rule 4 [m3]."""
    return {
        HINGING: np.where(snapshot.hinged, joints.area * snapshot.opening, 0.0),
        SLIDING: np.where(snapshot.slid, joints.area * snapshot.sliding, 0.0),
        PARTING: np.where(snapshot.open & ~snapshot.hinged, joints.area * np.maximum(snapshot.gap, 0.0), 0.0),
    }


def _piece(part: int, members: np.ndarray, solids: Solids, parts: MacroElements, rules: Rules) -> RockingPiece | None:
    """The piece that some blocks form, if its shape at rest lets it overturn."""
    corners = solids.vertices[np.isin(solids.vertex_block, members)]
    plan = corners[:, :2] - corners[:, :2].mean(axis=0)
    axes = np.linalg.svd(plan, full_matrices=False)[2]  # the first along the length
    length, thickness = np.ptp(plan @ axes.T, axis=0)
    height = float(np.ptp(corners[:, 2]))
    wall = thickness <= rules.thin * length
    if height <= (thickness if wall else rules.slender * length):
        return None
    z, volume = solids.centre[members, 2], parts.volume[members]
    order = np.argsort(-z, kind="stable")
    half = np.searchsorted(np.cumsum(volume[order]), 0.5 * volume.sum()) + 1
    return RockingPiece(part, members[order[:half]], np.array([*axes[0], 0.0]) if wall else None)


def _turn(piece: RockingPiece, snapshot: DamageSnapshot, parts: MacroElements, spin: np.ndarray, rules: Rules) -> tuple[float, str]:
    """Mean rotation of a piece's upper half [rad], 0 where it turns in many senses, and where its top goes."""
    upper = piece.upper[~snapshot.down[piece.upper]]
    if not len(upper):
        return 0.0, ""
    weight = parts.volume[upper] / parts.volume[upper].sum()
    mean = weight @ spin[upper]
    axis = piece.axis if piece.axis is not None else np.array([mean[0], mean[1], 0.0]) / max(float(np.hypot(*mean[:2])), 1e-300)
    about = spin[upper] @ axis
    total = float(weight @ about)
    if abs(total) < rules.coherent * float(weight @ np.abs(about)) or abs(total) < 1e-9:
        return 0.0, ""
    top = np.cross(total * axis, [0.0, 0.0, 1.0])
    k = int(np.argmax(np.abs(top)))
    return abs(total), f"{'-' if top[k] < 0 else '+'}{'xy'[k]}"


def _rotation_vectors(rotation: np.ndarray) -> np.ndarray:
    """Axis times angle (B, 3) [rad] of rotations (B, 3, 3)."""
    from scipy.spatial.transform import Rotation  # takes as long to load as a small run

    return np.asarray(Rotation.from_matrix(rotation).as_rotvec())
