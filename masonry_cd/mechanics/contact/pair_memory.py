# SPDX-License-Identifier: GPL-3.0-or-later
"""Memory of each pair of parts from one step to the next, so that no work is done twice.

    distance    of a pair when it was last searched: apart, it is not looked at before the two can have met
    feature     the face or the edges that separate them, until the pair has moved by REUSE of its width
    manifold    the points, until it has moved by STILL of its width. They are carried along with a, so they are off by that much at
                most; gaps follow the motion to first order, so they are off by that times the angle between the faces

Blocks that stick move by 1e-13 to 1e-10 of their width per step, others by 1e-6 and more: hardly anything lies between. All of this is
kept in the body frame of the first part, so it depends on the relative pose alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.arrays import LARGEST, Stored
from masonry_cd.foundation.jit import borrower
from masonry_cd.mechanics.contact.motion import distance_moved
from masonry_cd.mechanics.contact.separation import EDGES, FACE_OF_A, FACE_OF_B, FAR_APART, ROUND, UNKNOWN
from masonry_cd.mechanics.model.blocks import ConvexShapes
from masonry_cd.mechanics.model.geometry import Polyhedra, inverse_row

STILL = 1e-9  # a manifold is kept until the pair has moved by this share of the smaller part's width
RINGING = 1e-6  # and of blocks that deform, which are never quite still
REUSE = 1e-3  # a remembered feature is trusted until the pair has moved by this share of the smaller part's width
APART, KEPT, CLIPPED, SEARCHED = 0, 1, 2, 3  # what was done with a pair: nothing, points carried along, points found, feature found
MATCH = 0.05  # a contact is the same as one of the last step if it moved by less than this share of the smaller part's width


class PairMemory(NamedTuple):
    """P pairs of parts a and b, and room for S points; the points of pair k are in rows slot[k], ..., slot[k] + point_count[k] - 1."""

    parts: np.ndarray  # (P, 2) a and b, sorted
    feature: np.ndarray  # (P, 3) kind of the separating feature and its face or edges
    budget: np.ndarray  # (P,) separation of the parts when the feature was found [m]
    pose: np.ndarray  # (P, 12) pose of b in the frame of a when the feature was found
    built: np.ndarray  # (P, 12) that in which the points were found
    normal: np.ndarray  # (P, 3) from a to b, in the frame of a
    unfelt: np.ndarray  # (P,) overlap that the springs between a and b do not feel [m]
    rings: np.ndarray  # (P,) of points that the joint has where it opens, see joint_points.py
    light: np.ndarray  # (P,) overlap times area of a joint that carries too little for them to matter [m3]
    spread: np.ndarray  # (P,) bool: it has them
    exchanged: np.ndarray  # (P,) bool: it has got or lost them just now; not kept over a checkpoint
    point_count: np.ndarray  # (P,)
    slot: np.ndarray  # (P + 1,)
    local: np.ndarray  # (S, 3) point in the frame of a [m]
    height: np.ndarray  # (S,) gap when it was found [m]
    area: np.ndarray  # (S,) share of the joint's area [m2]
    crushed: np.ndarray  # (S,) by how much the joint is shorter there for good [m]
    place: np.ndarray  # (S,) its contact in the last set, -1 if it was none
    gap: np.ndarray  # (S,) gap now, inf where it is beyond the margin [m]; not kept over a checkpoint

    @classmethod
    def of(cls, parts: np.ndarray, capacity: np.ndarray) -> PairMemory:
        """Nothing is remembered of a list of pairs (P, 2); ``capacity`` (P,) is the largest number of points of each."""
        pairs, slot = len(parts), np.zeros(len(parts) + 1, dtype=np.int64)
        np.cumsum(capacity, out=slot[1:])
        points = int(slot[-1])
        return cls(
            parts=parts,
            feature=np.full((pairs, 3), UNKNOWN),
            budget=np.zeros(pairs),
            pose=np.full((pairs, 12), np.inf),
            built=np.full((pairs, 12), np.inf),
            normal=np.zeros((pairs, 3)),
            unfelt=np.zeros(pairs),
            rings=np.ones(pairs, dtype=np.int64),
            light=np.zeros(pairs),
            spread=np.zeros(pairs, dtype=np.bool_),
            exchanged=np.zeros(pairs, dtype=np.bool_),
            point_count=np.zeros(pairs, dtype=np.int64),
            slot=slot,
            local=np.zeros((points, 3)),
            height=np.zeros(points),
            area=np.zeros(points),
            crushed=np.zeros(points),
            place=np.zeros(points, dtype=np.int64),
            gap=np.empty(points),
        )

    @classmethod
    def none(cls) -> PairMemory:
        """No pairs."""
        return cls.of(np.zeros((0, 2), dtype=np.int64), np.zeros(0, dtype=np.int64))

    def carried_over(self, parts: np.ndarray, capacity: np.ndarray) -> PairMemory:
        """The memory for a new list of pairs (sorted), with what was known of those in the old one."""
        new = PairMemory.of(parts, capacity)
        if len(self.parts) and len(parts):
            span = max(self.parts.max(), parts.max()) + 1
            old_key, new_key = self.parts @ [span, 1], parts @ [span, 1]
            at = np.minimum(np.searchsorted(old_key, new_key), len(old_key) - 1)
            on = np.flatnonzero(old_key[at] == new_key)
            for name in OF_PAIRS:
                getattr(new, name)[on] = getattr(self, name)[at[on]]
            for name in OF_POINTS:
                getattr(new, name)[new.rows(on)] = getattr(self, name)[self.rows(at[on])]
        return new

    def rows(self, pairs: np.ndarray | slice = slice(None)) -> np.ndarray:
        """Rows of the points of some pairs, pair by pair."""
        count = self.point_count[pairs]
        end = np.cumsum(count)
        return np.repeat(self.slot[:-1][pairs] - (end - count), count) + np.arange(end[-1] if len(end) else 0)

    def pair_of_contacts(self) -> np.ndarray:
        """The pair of each contact of the last set, (C,)."""
        place, pair = self.place[self.rows()], np.repeat(np.arange(len(self.parts)), self.point_count)
        return pair[place >= 0][np.argsort(place[place >= 0])]

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return the arrays for a checkpoint: all but unused rows of points."""
        used = self.rows()
        return {name: getattr(self, name) for name in ("parts", *OF_PAIRS)} | {name: getattr(self, name)[used] for name in OF_POINTS}

    @classmethod
    def restored(cls, arrays: Mapping[str, np.ndarray], capacity: np.ndarray) -> PairMemory:
        """The memory from what :meth:`snapshot` gave."""
        new = cls.of(arrays["parts"], capacity)._replace(**{name: arrays[name] for name in OF_PAIRS})
        used = new.rows()
        for name in OF_POINTS:
            getattr(new, name)[used] = arrays[name]
        return new


def check_pairs(stored: Stored, parts: np.ndarray, capacity: np.ndarray, shapes: ConvexShapes, contacts: int) -> None:
    """Check what a checkpoint holds of pairs (P, 2), with room for ``capacity`` (P,) points each and some contacts in the last set,
    each of which one point is.

    Raises:
        InputError: an array that no detector leaves.
    """
    pairs = len(parts)
    feature = stored.whole("feature", pairs, 3, low=-1)
    if not _features_exist(feature, parts, shapes.solids):
        stored.refuse("feature", "out of range")
    stored.real("budget", pairs)
    for name in ("pose", "built"):
        pose = stored.real(name, pairs, 12, finite=False)
        known = np.isfinite(pose).all(axis=1)
        if not (np.abs(pose[known]) <= LARGEST).all() or not np.isposinf(pose[~known]).all():
            stored.refuse(name, "not finite, or far too large")
        if known[feature[:, 0] == UNKNOWN].any():
            stored.refuse(name, "known of a pair whose feature is not")
    stored.real("normal", pairs, 3)
    stored.real("unfelt", pairs)
    stored.flags("spread", pairs)
    count = stored.whole("point_count", pairs, high=capacity + 1)
    points = int(count.sum())
    stored.real("local", points, 3)
    for name in ("height", "area", "crushed"):
        stored.real(name, points)
    place = stored.whole("place", points, low=-1)
    if not np.array_equal(np.sort(place[place >= 0]), np.arange(contacts)):
        stored.refuse("place", "not those of the contacts")


def _features_exist(feature: np.ndarray, parts: np.ndarray, solids: Polyhedra) -> bool:
    """Return True if the faces and edges (P, 3) that separate pairs are those of their parts."""
    kind, known = feature[:, 0], True
    for which, column, side, starts in (
        (FACE_OF_A, 1, 0, solids.face_start),
        (FACE_OF_B, 1, 1, solids.face_start),
        (EDGES, 1, 0, solids.edge_start),
        (EDGES, 2, 1, solids.edge_start),
    ):
        found, of = feature[kind == which, column], parts[kind == which, side]
        known &= bool(((starts[of] <= found) & (found < starts[of + 1])).all())
    return known and bool(((kind >= UNKNOWN) & (kind <= ROUND)).all())


OF_PAIRS = ("feature", "budget", "pose", "built", "normal", "unfelt", "spread", "point_count")
OF_POINTS = ("local", "height", "area", "crushed", "place")


@borrower()
def is_stuck(memory, k, now, affine, radius, width):
    """Return True if the points of pair k can be kept; its pose ``now`` (12,), ``radius`` of b and ``width`` of the smaller part [m].

    ``affine``: two zeros where poses hold strains, else one.
    """
    still = RINGING if len(affine) == 2 else STILL
    return memory.feature[k, 0] > FAR_APART and distance_moved(now, memory.built[k], radius) < still * width


@borrower()
def update_gaps(memory, k, now, affine):
    """Gaps of pair k after a small motion to the pose ``now`` (12,): what they were, and the motion along n of b's point at the contact.

    ``affine``: two zeros where poses hold strains, else one.
    """
    then, n, local = memory.built[k], memory.normal[k], memory.local
    first = memory.slot[k]
    for s in range(first, first + memory.point_count[k]):
        dx, dy, dz = local[s, 0] - then[0], local[s, 1] - then[1], local[s, 2] - then[2]
        moved = 0.0
        for i in range(3):
            moved += n[i] * (now[i] - then[i])
        for j in range(3):
            rx, ry, rz = inverse_row(then[3:].reshape((1, 3, 3)), 0, j) if len(affine) == 2 else (then[3 + j], then[6 + j], then[9 + j])
            y = rx * dx + ry * dy + rz * dz  # in the frame of b
            for i in range(3):
                moved += n[i] * (now[3 + 3 * i + j] - then[3 + 3 * i + j]) * y
        memory.gap[s] = memory.height[s] + moved + memory.crushed[s]


@borrower()
def let_go(memory, k):
    """Reduce the points of pair k as it separates: to none, or to those that may be crushed, far from one another."""
    if memory.light[k] >= 0.0:
        memory.point_count[k], memory.spread[k] = 0, False
    for s in range(memory.slot[k], memory.slot[k] + memory.point_count[k]):
        memory.gap[s] = np.inf


@borrower()
def store_points(memory, k, found, manifold, with_area, width, work):
    """Put the ``found`` points of a manifold in the memory of pair k, each with the contact of the last set that it continues.

    ``width`` [m] is that of the smaller part. With areas several points may continue one contact; points that have
    been exchanged for others continue the nearest, however far off.
    """
    place = work.place
    _match(memory, k, manifold.point, found, np.inf if memory.exchanged[k] else MATCH * width, with_area, place)
    _crushed_before(memory, k, manifold.point, found, MATCH * width, work.crushed)
    memory.point_count[k] = found
    for i in range(found):
        s = memory.slot[k] + i
        for d in range(3):
            memory.local[s, d] = manifold.point[i, d]
        memory.height[s] = manifold.height[i]
        memory.area[s], memory.crushed[s] = manifold.area[i] if with_area else 0.0, work.crushed[i]
        memory.place[s] = place[i]


@borrower()
def _match(memory, k, point, found, reach, shared, new_place):
    """Fill ``new_place`` with the nearest contact of pair k in the last set for each point that no other point has taken, or -1.

    ``point`` (N, 3), of which ``found`` count; none farther off than ``reach`` [m]. With ``shared`` one that was taken counts too: a corner
    that parts in two hands on its slip and its bond to both.
    """
    local, place, first, last = memory.local, memory.place, memory.slot[k], memory.slot[k] + memory.point_count[k]
    for i in range(found):
        nearest, new_place[i] = reach * reach, -1
        for s in range(first, last):
            taken = place[s] < 0
            for j in range(i):
                taken = taken or (new_place[j] == place[s] and not shared)
            dx, dy, dz = point[i, 0] - local[s, 0], point[i, 1] - local[s, 1], point[i, 2] - local[s, 2]
            distance = dx * dx + dy * dy + dz * dz
            if not taken and distance < nearest:
                nearest, new_place[i] = distance, place[s]


@borrower()
def _crushed_before(memory, k, point, found, reach, crushed):
    """Fill ``crushed`` (N,) with by how much the joint of pair k is shorter for good at the ``found`` ones of points (N, 3): as at the
    nearest one so far, none farther off than ``reach`` [m]."""
    local, first, last = memory.local, memory.slot[k], memory.slot[k] + memory.point_count[k]
    for i in range(found):
        nearest, crushed[i] = reach * reach, 0.0
        for s in range(first, last if memory.light[k] < 0.0 else first):
            dx, dy, dz = point[i, 0] - local[s, 0], point[i, 1] - local[s, 1], point[i, 2] - local[s, 2]
            distance = dx * dx + dy * dy + dz * dz
            if distance < nearest:
                nearest, crushed[i] = distance, memory.crushed[s]
