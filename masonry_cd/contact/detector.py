r"""Contact detection between convex parts: which surfaces may touch within the coming step, where, and how far apart they are.

**Broad phase.** Bounding boxes grown by a skin, swept along the axis on which they spread most. The list of pairs stays valid
until a part has moved through its skin, what it may do within the step included; the common motion of the supports is taken off first,
so that shaking alone rebuilds nothing.

**Narrow phase.** Two convex polyhedra are apart by the largest separation over the face normals of either and the cross products
of their edges; edge pairs count only where their arcs cross on the Gauss map of the Minkowski difference (Gregorius, "The separating
axis test between convex polyhedra", GDC 2013). Of each pair is kept what it takes to do no work twice, and how far it may move until
that is due:

    apart       the distance: not looked at before the two can have met
    feature     the face or the edges that separate them, until the pair has moved by REUSE of its width
    manifold    the points, until it has moved by STILL of its width. They are carried along with a, so they are off by that much at
                most; gaps follow the motion to first order, so they are off by that times the angle between the faces

Blocks that stick move by 1e-13 to 1e-10 of their width per step, others by 1e-6 and more: hardly anything lies between. All of this is
done in the body frame of the first part, so it depends on the relative pose alone.

**Manifold.** Face on face: the incident polygon clipped by the reference face, all its corners kept, no inset (their placement is
physics: an inset of 1.25 % raises the minimum thickness of an arch by 2.6 %). Overlaps narrower than SLIVER of the smaller part are no
interface: blocks that only share an edge or a corner, as diagonal neighbours in a bond do, must not wedge each other apart.
Crossing edges: one point, midway between them.

**Fast pairs.** Blocks that pass each other edge by edge face nothing of one another now, and yet may meet before the next look. Where a
pair has no points and may move by FAR of its width, they are those of its pose a step later, if both go on as they move.

**Areas.** A joint whose law goes by area, elastic or bonded, has one more point, at the centroid of its polygon, and shares its area out so
that springs at the points act as springs all over it. With A_i the triangles (centroid, c_i, c_i+1), c seen from the centroid,

    w_i = lambda (A_i-1 + A_i) / 6 at corner i, the rest at the centroid,   lambda = 1 + sum A_i c_i . c_i+1 / sum A_i (c_i^2 + c_i+1^2).

First moments sum w_i c_i are zero for any polygon; lambda, between 1/2 and 3/2, gives the second moments their exact trace (the torsion of
the joint), and all of them are exact for triangles, parallelograms and regular polygons (A/12 at a corner of a rectangle). No weight is
negative. Corners that have moved less than SNAP off a side plane stay on it, or every small turn would double them. Crossing edges
have no area: they are rigid and dry in any joint.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from masonry_cd.jit import entry, kernel
from masonry_cd.model.blocks import Assembly

SLIVER = 1e-4  # narrowest interface, as a share of the smaller part's width
STILL = 1e-9  # a manifold is kept until the pair has moved by this share of the smaller part's width
REUSE = 1e-3  # a remembered feature is trusted until the pair has moved by this share of the smaller part's width
SKIN = 0.2  # growth of the bounding boxes, as a share of the median width of the parts
EDGE_BIAS = 1e-3  # an edge pair must be this much farther apart than the best face, as a share of the smaller width
SNAP = 1e-4  # a corner this close to a side plane is on it, as a share of the smaller part's width
MATCH = 0.05  # a contact is the same as one of the last step if it moved by less than this share of the smaller part's width

FAR = 0.05  # a pair that may move by more than this share of the smaller part's width in a step is looked at as it will be then, too
NEAR = 1e-3  # surfaces closer than this share of the smaller part's width are always in the contact set

OWN = np.int64(0)  # where a block's vertices and normals begin in arrays of its own; for a plain 0 numba would compile the code twice
UNKNOWN, NOTHING, FACE_OF_A, FACE_OF_B, EDGES = 0, 1, 2, 3, 4  # kinds of separating feature
APART, KEPT, CLIPPED, SEARCHED = 0, 1, 2, 3  # what was done with a pair: nothing, points carried along, points found, feature found


@dataclass(frozen=True, eq=False)
class ContactSet:
    """C contacts. The normal points from the antagonist (second body) to the candidate (first body)."""

    bodies: np.ndarray  # (C, 2) candidate and antagonist block
    point: np.ndarray  # (C, 3) world frame [m]
    normal: np.ndarray  # (C, 3) unit
    gap: np.ndarray  # (C,) [m], negative when the blocks overlap
    area: np.ndarray  # (C,) share of the joint's area where its law goes by area, else 0 [m2]
    pair: np.ndarray  # (C,) row of the detector's pair list
    previous: np.ndarray  # (C,) the same contact in the last set, -1 for a new one

    @property
    def count(self) -> int:
        """Number of contacts C."""
        return len(self.gap)

    @classmethod
    def none(cls) -> ContactSet:
        """No contacts."""
        return cls.room(0)

    @classmethod
    def room(cls, count: int) -> ContactSet:
        """Arrays for so many contacts, to be filled."""
        one, three, index = (count,), (count, 3), np.int64
        return cls(
            np.empty((count, 2), index), np.empty(three), np.empty(three), np.empty(one), np.empty(one), np.empty(one, index),
            np.empty(one, index),
        )  # fmt: skip


class Detector:
    """Finds contacts step after step and remembers what the next step can use.

    Args:
        assembly: the blocks.
        corners_only: no centroids and no areas, whatever the laws of the joints.
    """

    def __init__(self, assembly: Assembly, corners_only: bool = False) -> None:
        shapes = assembly.shapes
        self._shapes = shapes
        self._group_of = assembly.group_of
        self._by_area = assembly.laws.by_area & (not corners_only)
        self._fixed_part = assembly.fixed[shapes.part_block]
        self._skin = SKIN * float(np.median(shapes.size[~self._fixed_part]))
        corners = np.diff(shapes.loop_start)
        self._corners = np.maximum.reduceat(corners, shapes.face_start[:-1])  # (P,) most corners of a face
        self._scratch = 2 * int(self._corners.max()) + 8, int(np.diff(shapes.vertex_start).max()), int(np.diff(shapes.face_start).max())
        self._listed_position = np.empty_like(assembly.centre)
        self._listed_rotation = np.empty((assembly.count, 3, 3))
        self._allowance = np.full(len(shapes.part_block), np.nan)  # nothing is less than NaN: the first call builds the list
        self._memory = PairMemory.empty(0, 0)
        self._gap = np.empty(0)  # of each point kept, inf beyond the margin
        self.rebuilds = 0
        self.tally = np.zeros(4, dtype=np.int64)  # pairs so far that were APART, KEPT, CLIPPED, SEARCHED

    @property
    def pairs(self) -> np.ndarray:
        """(P, 2) parts that may meet before the list is made anew."""
        return self._memory.parts

    @property
    def left_out(self) -> dict[str, int]:
        """How often so far each part of the work was done or left out; pairs are counted in every detection."""
        names = ("pairs_not_looked_at", "pairs_with_points_kept", "pairs_with_points_found", "pairs_with_faces_searched")
        return {"broad_phases": self.rebuilds} | dict(zip(names, self.tally.tolist(), strict=True))

    def detect(
        self, position: np.ndarray, rotation: np.ndarray, velocity: np.ndarray, step: float, slack: float, origin: np.ndarray
    ) -> ContactSet:
        """List the contacts of a configuration.

        Args:
            position: (B, 3) centres of mass [m].
            rotation: (B, 3, 3) body to world.
            velocity: (B, 6), bounds how far blocks can come closer within the step.
            step: time step [s].
            slack: distance that forces not yet known may add within the step [m].
            origin: (3,) displacement of the supports since the start [m].
        """
        s = self._shapes
        if not _list_holds(
            position, rotation, velocity, step, slack, origin, s.part_block, s.radius, s.size, self._listed_position, self._listed_rotation,
            self._allowance,
        ):  # fmt: skip
            self._rebuild(position, rotation, velocity, step, slack, origin)
        m = self._memory
        count = _look(
            m.parts, m.feature, m.budget, m.pose, m.built, m.normal, m.slot, m.count, m.local, m.height, m.area, m.place, self._gap,
            s.part_block, s.vertex_start, s.vertices, s.face_start, s.face_normals, s.loop_start, s.loops, s.edge_start, s.edges, s.radius,
            s.size, self._group_of, self._by_area, self._scratch, position, rotation, velocity, step, slack, self.tally,
        )  # fmt: skip
        out = ContactSet.room(count)
        _write_down(
            m.parts, m.normal, m.slot, m.count, m.local, m.area, m.place, self._gap, s.part_block, position, rotation,
            out.bodies, out.point, out.normal, out.gap, out.area, out.pair, out.previous,
        )  # fmt: skip
        return out

    def snapshot(self) -> dict[str, np.ndarray]:
        """What the detector remembers, as arrays for a checkpoint."""
        own = {"listed_position": self._listed_position, "listed_rotation": self._listed_rotation, "allowance": self._allowance}
        return self._memory.snapshot() | own | {"tally": self.tally, "rebuilds": np.array(self.rebuilds)}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Take back what :meth:`snapshot` gave."""
        self._memory = PairMemory.restored(arrays, self._room(arrays["parts"]))
        self._gap = np.empty(len(self._memory.height))
        self._listed_position, self._listed_rotation = arrays["listed_position"], arrays["listed_rotation"]
        self._allowance, self.tally, self.rebuilds = arrays["allowance"], arrays["tally"], int(arrays["rebuilds"])

    def _rebuild(
        self, position: np.ndarray, rotation: np.ndarray, velocity: np.ndarray, step: float, slack: float, origin: np.ndarray
    ) -> None:
        """Sweep the boxes again, and carry over what is remembered of the pairs that stay."""
        s, boxes = self._shapes, np.empty((len(self._allowance), 6))
        np.subtract(position, origin, out=self._listed_position)
        self._listed_rotation[:] = rotation
        _boxes(
            self._listed_position, rotation, velocity, step, slack, self._skin, s.part_block, s.vertex_start, s.vertices, s.radius, s.size,
            self._allowance, boxes,
        )  # fmt: skip
        axis = int(np.argmax(np.std(boxes[:, :3] + boxes[:, 3:], axis=0)))  # on which their centres spread most
        order = np.argsort(boxes[:, axis], kind="stable")
        pairs = _sweep(boxes, axis, order, self._fixed_part, s.part_block)
        pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
        self._memory = self._memory.carried_over(pairs, self._room(pairs))
        self._gap = np.empty(len(self._memory.height))
        self.rebuilds += 1

    def _room(self, pairs: np.ndarray) -> np.ndarray:
        """Room (P,) for the points of each pair: a polygon of i corners cut by one of k has i + k at most; and the centroid."""
        return self._corners[pairs].sum(axis=1) + 1


@dataclass(eq=False)
class PairMemory:
    """What is remembered of each of P candidate pairs from one step to the next; arrays, so that a checkpoint can hold them.

    The points of pair k stand at slot[k], ..., slot[k] + count[k] - 1 of the arrays of points, (S, ...).
    """

    parts: np.ndarray  # (P, 2) a and b
    feature: np.ndarray  # (P, 3) kind of the separating feature and its face or edges; NOTHING: apart
    budget: np.ndarray  # (P,) distance between the parts when they were last found apart [m]
    pose: np.ndarray  # (P, 12) pose of b in the frame of a when the feature was found
    built: np.ndarray  # (P, 12) the same when the points were found
    normal: np.ndarray  # (P, 3) from a to b, in the frame of a
    count: np.ndarray  # (P,) points
    slot: np.ndarray  # (P + 1,)
    local: np.ndarray  # (S, 3) point in the frame of a
    height: np.ndarray  # (S,) gap when it was found [m]
    area: np.ndarray  # (S,) share of the joint's area [m2]
    place: np.ndarray  # (S,) its contact in the last set, -1 if it was none

    @classmethod
    def empty(cls, pairs: int, room: np.ndarray | int) -> PairMemory:
        """Nothing remembered: every pair is looked at afresh. ``room`` (P,) points for each pair."""
        slot = np.zeros(pairs + 1, dtype=np.int64)
        np.cumsum(np.broadcast_to(room, pairs), out=slot[1:])
        points = int(slot[-1])
        return cls(
            np.zeros((pairs, 2), dtype=np.int64), np.full((pairs, 3), UNKNOWN), np.zeros(pairs), np.full((pairs, 12), np.inf),
            np.full((pairs, 12), np.inf), np.zeros((pairs, 3)), np.zeros(pairs, dtype=np.int64), slot,
            np.zeros((points, 3)), np.zeros(points), np.zeros(points), np.zeros(points, dtype=np.int64),
        )  # fmt: skip

    def carried_over(self, parts: np.ndarray, room: np.ndarray) -> PairMemory:
        """The memory for a new list of pairs (sorted), with what was known of those in the old one."""
        new = PairMemory.empty(len(parts), room)
        new.parts = parts
        if len(self.parts) and len(parts):
            span = max(self.parts.max(), parts.max()) + 1
            old_key, new_key = self.parts @ [span, 1], parts @ [span, 1]
            at = np.minimum(np.searchsorted(old_key, new_key), len(old_key) - 1)
            on = np.flatnonzero(old_key[at] == new_key)
            for name in OF_PAIRS:
                getattr(new, name)[on] = getattr(self, name)[at[on]]
            for name in OF_POINTS:
                getattr(new, name)[new.points(on)] = getattr(self, name)[self.points(at[on])]
        return new

    def points(self, pairs: np.ndarray | slice = slice(None)) -> np.ndarray:
        """Where the points of some pairs stand, pair by pair."""
        count = self.count[pairs]
        end = np.cumsum(count)
        return np.repeat(self.slot[:-1][pairs] - (end - count), count) + np.arange(end[-1] if len(end) else 0)

    def snapshot(self) -> dict[str, np.ndarray]:
        """All of it but the room that is not used."""
        used = self.points()
        return {name: getattr(self, name) for name in ("parts", *OF_PAIRS)} | {name: getattr(self, name)[used] for name in OF_POINTS}

    @classmethod
    def restored(cls, arrays: Mapping[str, np.ndarray], room: np.ndarray) -> PairMemory:
        """Take back what :meth:`snapshot` gave."""
        new = cls.empty(len(room), room)
        for name in ("parts", *OF_PAIRS):
            setattr(new, name, arrays[name])
        used = new.points()
        for name in OF_POINTS:
            getattr(new, name)[used] = arrays[name]
        return new


OF_PAIRS = ("feature", "budget", "pose", "built", "normal", "count")
OF_POINTS = ("local", "height", "area", "place")


# --- broad phase ----------------------------------------------------------------------------------------------------------------


@kernel()
def _reach(v, radius, size, step, slack):
    """How far a part may go within the step, and its share of what counts as near: half the margin of a pair, or more [m]."""
    speed = np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) + radius * np.sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5])
    return 2.0 * step * speed + 0.5 * slack + 0.5 * NEAR * size


@entry()
def _list_holds(position, rotation, velocity, step, slack, origin, part_block, radius, size, listed_position, listed_rotation, allowance):
    """Whether no part has moved, nor may move within the step, by more than its box had been grown."""
    for p in range(part_block.shape[0]):
        b = part_block[p]
        shift, turn = 0.0, 0.0
        for i in range(3):
            shift += (position[b, i] - origin[i] - listed_position[b, i]) ** 2
            for j in range(3):
                turn += (rotation[b, i, j] - listed_rotation[b, i, j]) ** 2
        moved = np.sqrt(shift) + radius[p] * np.sqrt(turn)
        if not moved + _reach(velocity[b], radius[p], size[p], step, slack) <= allowance[p]:
            return False
    return True


@entry()
def _boxes(position, rotation, velocity, step, slack, skin, part_block, vertex_start, vertices, radius, size, allowance, box):
    """Bounding boxes of all parts, grown by the skin and by what a part may do within a step; the growth is the ``allowance``."""
    for p in range(part_block.shape[0]):
        b = part_block[p]
        allowance[p] = skin + _reach(velocity[b], radius[p], size[p], step, slack)
        for d in range(3):
            low, high = np.inf, -np.inf
            for i in range(vertex_start[p], vertex_start[p + 1]):
                value = position[b, d]
                for e in range(3):
                    value += rotation[b, d, e] * vertices[i, e]
                low, high = min(low, value), max(high, value)
            box[p, d], box[p, 3 + d] = low - allowance[p], high + allowance[p]


@entry()
def _sweep(box, axis, order, fixed, block):
    """Pairs of overlapping boxes, swept along an axis in the order in which they begin there; two supports never pair up."""
    parts = box.shape[0]
    u, w = (axis + 1) % 3, (axis + 2) % 3
    capacity, count = 8 * parts + 16, 0
    pairs = np.empty((capacity, 2), dtype=np.int64)
    for i in range(parts):
        p = order[i]
        for j in range(i + 1, parts):
            q = order[j]
            if box[q, axis] > box[p, 3 + axis]:
                break
            if box[q, u] > box[p, 3 + u] or box[q, 3 + u] < box[p, u] or box[q, w] > box[p, 3 + w] or box[q, 3 + w] < box[p, w]:
                continue
            if (fixed[p] and fixed[q]) or block[p] == block[q]:
                continue
            if count == capacity:
                capacity *= 2
                grown = np.empty((capacity, 2), dtype=np.int64)
                for k in range(count):
                    grown[k, 0], grown[k, 1] = pairs[k, 0], pairs[k, 1]
                pairs = grown
            pairs[count, 0], pairs[count, 1] = min(p, q), max(p, q)
            count += 1
    return pairs[:count].copy()


# --- narrow phase ---------------------------------------------------------------------------------------------------------------
#
# Kernels see the two parts of a pair in the frame of a: those of a as they are stored, those of b placed into scratch arrays, whose
# entries are counted from ``b_vertex``, ``b_face``. Where a kernel treats both alike, it takes an array and where its counting begins.


@entry()
def _look(
    parts, feature, budget, pose, built, normal, slot, count, local, height, area, place, gap,
    part_block, vertex_start, vertices, face_start, normals, loop_start, loops, edge_start, edges, radius, size, group_of, by_area, scratch,
    position, rotation, velocity, step, slack, tally,
):  # fmt: skip
    """Bring the points of all pairs up to date, and the gap of each, inf where it is beyond the margin; return how many are within."""
    most, most_vertices, most_faces = scratch
    polygon, other = np.empty((most, 3)), np.empty((most, 3))
    new_height, weight, new_place = np.empty(most), np.empty(most), np.empty(most, dtype=np.int64)
    vertices_b, normals_b = np.empty((most_vertices, 3)), np.empty((most_faces, 3))
    now, ahead, turned = np.empty(12), np.empty((2, 3)), np.empty((2, 3, 3))
    shown = 0
    for k in range(parts.shape[0]):
        a, b = parts[k, 0], parts[k, 1]
        body_a, body_b = part_block[a], part_block[b]
        width = min(size[a], size[b])
        margin = slack + NEAR * width + 2.0 * step * _closing_speed(velocity[body_a], velocity[body_b], radius[a], radius[b])
        _relative_pose(position, rotation, body_a, body_b, now)
        first = slot[k]
        if feature[k, 0] > NOTHING and _moved(now, built[k], radius[b]) < STILL * width:
            _follow(now, built[k], normal[k], local, height, first, first + count[k], gap)
            tally[KEPT] += 1
        else:
            moved = _moved(now, pose[k], radius[b])
            if feature[k, 0] == NOTHING and budget[k] - moved > margin:
                tally[APART] += 1
                continue
            _place(now, b, vertex_start, vertices, face_start, normals, vertices_b, normals_b)
            if feature[k, 0] == NOTHING or not moved < REUSE * width:
                tally[SEARCHED] += 1
                apart = _separate(
                    a, b, vertex_start, vertices, face_start, normals, loop_start, loops, edge_start, edges, vertices_b, normals_b,
                    EDGE_BIAS * width, feature[k],
                )  # fmt: skip
                for i in range(12):
                    pose[k, i] = now[i]
                if apart > margin:
                    feature[k, 0], budget[k], count[k] = NOTHING, apart, 0
                    continue
            tally[CLIPPED] += 1
            with_area = by_area[group_of[body_a], group_of[body_b]] and feature[k, 0] != EDGES
            found = _points(
                a, b, feature[k], vertex_start, vertices, face_start, normals, loop_start, loops, edges, vertices_b, normals_b, width,
                with_area, normal[k], polygon, other, new_height, weight,
            )  # fmt: skip
            for i in range(12):
                built[k, i] = now[i]
            if found == 0 and margin > FAR * width and not with_area:
                _pose_ahead(position, rotation, velocity, step, body_a, body_b, ahead, turned, built[k])
                _place(built[k], b, vertex_start, vertices, face_start, normals, vertices_b, normals_b)
                for i in range(12):
                    pose[k, i] = built[k, i]
                if _separate(
                    a, b, vertex_start, vertices, face_start, normals, loop_start, loops, edge_start, edges, vertices_b, normals_b,
                    EDGE_BIAS * width, feature[k],
                ) <= margin:  # fmt: skip
                    found = _points(
                        a, b, feature[k], vertex_start, vertices, face_start, normals, loop_start, loops, edges, vertices_b, normals_b,
                        width, False, normal[k], polygon, other, new_height, weight,
                    )  # fmt: skip
            _match(polygon, found, local, place, first, count[k], MATCH * width, with_area, new_place)
            count[k] = found
            for i in range(found):
                s = first + i
                local[s, 0], local[s, 1], local[s, 2] = polygon[i, 0], polygon[i, 1], polygon[i, 2]
                height[s] = new_height[i]
                area[s] = weight[i] if with_area else 0.0
                place[s] = new_place[i]
            _follow(now, built[k], normal[k], local, height, first, first + found, gap)
        for s in range(first, first + count[k]):
            if gap[s] > margin:
                gap[s] = np.inf
            else:
                shown += 1
    return shown


@entry()
def _write_down(
    parts, local_normal, slot, count, local, local_area, place, kept_gap, part_block, position, rotation,
    bodies, point, normal, gap, area, pair, previous,
):  # fmt: skip
    """Fill the contact set (the last line) with the points within the margin, in the world frame, and note the place of each."""
    total = 0
    for k in range(parts.shape[0]):
        if count[k] == 0:
            continue
        a, b = part_block[parts[k, 0]], part_block[parts[k, 1]]
        r, x = rotation[a], position[a]
        nx, ny, nz = _turned(r, local_normal[k])
        for s in range(slot[k], slot[k] + count[k]):
            if kept_gap[s] == np.inf:
                place[s] = -1
                continue
            px, py, pz = _turned(r, local[s])
            point[total, 0], point[total, 1], point[total, 2] = x[0] + px, x[1] + py, x[2] + pz
            normal[total, 0], normal[total, 1], normal[total, 2] = nx, ny, nz
            bodies[total, 0], bodies[total, 1] = b, a
            gap[total], area[total], pair[total], previous[total] = kept_gap[s], local_area[s], k, place[s]
            place[s] = total
            total += 1


@kernel()
def _closing_speed(va, vb, radius_a, radius_b):
    """Bound on the speed at which a point of one body nears a point of the other [m/s]."""
    dx, dy, dz = vb[0] - va[0], vb[1] - va[1], vb[2] - va[2]
    spin_a = np.sqrt(va[3] * va[3] + va[4] * va[4] + va[5] * va[5])
    spin_b = np.sqrt(vb[3] * vb[3] + vb[4] * vb[4] + vb[5] * vb[5])
    return np.sqrt(dx * dx + dy * dy + dz * dz) + spin_a * radius_a + spin_b * radius_b


@kernel()
def _relative_pose(position, rotation, a, b, pose):
    """Pose of block b in the frame of block a: place of its centre, then the rotation matrix row by row."""
    ra, rb = rotation[a], rotation[b]
    dx, dy, dz = position[b, 0] - position[a, 0], position[b, 1] - position[a, 1], position[b, 2] - position[a, 2]
    for i in range(3):
        pose[i] = ra[0, i] * dx + ra[1, i] * dy + ra[2, i] * dz
        for j in range(3):
            pose[3 + 3 * i + j] = ra[0, i] * rb[0, j] + ra[1, i] * rb[1, j] + ra[2, i] * rb[2, j]


@kernel()
def _pose_ahead(position, rotation, velocity, step, a, b, place, turned, pose):
    """Pose of block b in the frame of block a a step later, if both go on as they move; ``place`` (2, 3), ``turned`` (2, 3, 3) are room."""
    for side in range(2):
        body = a if side == 0 else b
        v, r = velocity[body], rotation[body]
        speed = np.sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5])
        c, s = np.cos(step * speed), np.sin(step * speed)
        scale = 1.0 / speed if speed > 0.0 else 0.0
        x, y, z = scale * v[3], scale * v[4], scale * v[5]
        for d in range(3):
            place[side, d] = position[body, d] + step * v[d]
            px, py, pz = r[0, d], r[1, d], r[2, d]
            along = (1.0 - c) * (x * px + y * py + z * pz)
            turned[side, 0, d] = c * px + s * (y * pz - z * py) + along * x
            turned[side, 1, d] = c * py + s * (z * px - x * pz) + along * y
            turned[side, 2, d] = c * pz + s * (x * py - y * px) + along * z
    _relative_pose(place, turned, 0, 1, pose)


@kernel()
def _moved(now, then, radius):
    """Bound on how far any point of b has moved in the frame of a between two poses [m]."""
    shift, turn = 0.0, 0.0
    for i in range(3):
        shift += (now[i] - then[i]) ** 2
    for i in range(3, 12):
        turn += (now[i] - then[i]) ** 2
    return np.sqrt(shift) + radius * np.sqrt(turn)


@kernel()
def _follow(now, then, n, local, height, first, last, gap):
    """Gaps after a small motion: what they were, and the motion along n of the point of b that was at the contact."""
    for s in range(first, last):
        dx, dy, dz = local[s, 0] - then[0], local[s, 1] - then[1], local[s, 2] - then[2]
        moved = 0.0
        for i in range(3):
            moved += n[i] * (now[i] - then[i])
        for j in range(3):
            y = then[3 + j] * dx + then[6 + j] * dy + then[9 + j] * dz  # in the frame of b
            for i in range(3):
                moved += n[i] * (now[3 + 3 * i + j] - then[3 + 3 * i + j]) * y
        gap[s] = height[s] + moved


@kernel()
def _place(pose, b, vertex_start, vertices, face_start, normals, placed, turned):
    """Vertices and face normals of part b in the frame of a."""
    for k in range(vertex_start[b + 1] - vertex_start[b]):
        v = vertices[vertex_start[b] + k]
        for i in range(3):
            placed[k, i] = pose[i] + pose[3 + 3 * i] * v[0] + pose[4 + 3 * i] * v[1] + pose[5 + 3 * i] * v[2]
    for k in range(face_start[b + 1] - face_start[b]):
        v = normals[face_start[b] + k]
        for i in range(3):
            turned[k, i] = pose[3 + 3 * i] * v[0] + pose[4 + 3 * i] * v[1] + pose[5 + 3 * i] * v[2]


@kernel()
def _separate(
    a, b, vertex_start, vertices, face_start, normals, loop_start, loops, edge_start, edges, vertices_b, normals_b, bias, feature
):
    """Find the axis of largest separation, write it into ``feature`` and return the separation [m].

    Faces win over edges, and the face of the last step over others, unless beaten by the bias: the normal must not flicker.
    """
    b_vertex, b_face = vertex_start[b], face_start[b]
    best, face = _face_axis(face_start[a], face_start[a + 1], normals, OWN, loop_start, loops, vertices, OWN, vertices_b,
                            vertex_start[b + 1] - b_vertex)  # fmt: skip
    best_b, face_b = _face_axis(b_face, face_start[b + 1], normals_b, b_face, loop_start, loops, vertices_b, b_vertex,
                                vertices[vertex_start[a] : vertex_start[a + 1]], vertex_start[a + 1] - vertex_start[a])  # fmt: skip
    kind = FACE_OF_A
    prefer_b = feature[0] == FACE_OF_B
    if best_b > best + (-0.1 * bias if prefer_b else 0.1 * bias):
        best, face, kind = best_b, face_b, FACE_OF_B
    edge_best, edge_a, edge_b = _edge_axis(edge_start[a], edge_start[a + 1], edge_start[b], edge_start[b + 1], edges, normals, vertices,
                                           normals_b, b_face, vertices_b, b_vertex)  # fmt: skip
    if edge_best > best + bias:
        feature[0], feature[1], feature[2] = EDGES, edge_a, edge_b
        return edge_best
    feature[0], feature[1], feature[2] = kind, face, -1
    return best


@kernel()
def _face_axis(first, last, normals, normal_from, loop_start, loops, vertices, vertex_from, points, count):
    """Largest separation of some points from a part over the faces of the part, and the face."""
    best, at = -np.inf, -1
    for f in range(first, last):
        n, corner = normals[f - normal_from], vertices[loops[loop_start[f]] - vertex_from]
        offset = n[0] * corner[0] + n[1] * corner[1] + n[2] * corner[2]
        least = np.inf
        for i in range(count):
            value = n[0] * points[i, 0] + n[1] * points[i, 1] + n[2] * points[i, 2]
            if value < least:
                least = value
                if least - offset < best:
                    break
        if least - offset > best:
            best, at = least - offset, f
    return best, at


@kernel()
def _edge_axis(first_a, last_a, first_b, last_b, edges, normals, vertices, normals_b, b_face, vertices_b, b_vertex):
    """Largest separation over the edge pairs whose Gauss arcs cross, and the edges."""
    best, at_a, at_b = -np.inf, -1, -1
    for i in range(first_a, last_a):
        left, right = edges[i, 2], edges[i, 3]
        ax, ay, az = normals[left, 0], normals[left, 1], normals[left, 2]
        bx, by, bz = normals[right, 0], normals[right, 1], normals[right, 2]
        px, py, pz = by * az - bz * ay, bz * ax - bx * az, bx * ay - by * ax  # b x a, along the edge
        p = vertices[edges[i, 0]]
        for j in range(first_b, last_b):
            left, right = edges[j, 2] - b_face, edges[j, 3] - b_face
            cx, cy, cz = normals_b[left, 0], normals_b[left, 1], normals_b[left, 2]
            dx, dy, dz = normals_b[right, 0], normals_b[right, 1], normals_b[right, 2]
            cba = -(cx * px + cy * py + cz * pz)
            dba = -(dx * px + dy * py + dz * pz)
            if cba * dba >= 0.0:
                continue
            qx, qy, qz = dy * cz - dz * cy, dz * cx - dx * cz, dx * cy - dy * cx
            adc = ax * qx + ay * qy + az * qz
            bdc = bx * qx + by * qy + bz * qz
            if adc * bdc >= 0.0 or cba * bdc <= 0.0:
                continue
            ux, uy, uz = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
            length = np.sqrt(ux * ux + uy * uy + uz * uz)
            if length < 1e-6 * np.sqrt((px * px + py * py + pz * pz) * (qx * qx + qy * qy + qz * qz)):
                continue  # parallel edges: a face axis is at least as good
            sign = 1.0 if ux * (ax + bx) + uy * (ay + by) + uz * (az + bz) > 0.0 else -1.0
            q = vertices_b[edges[j, 0] - b_vertex]
            value = sign * (ux * (q[0] - p[0]) + uy * (q[1] - p[1]) + uz * (q[2] - p[2])) / length
            if value > best:
                best, at_a, at_b = value, i, j
    return best, at_a, at_b


# --- manifolds ------------------------------------------------------------------------------------------------------------------


@kernel()
def _points(
    a, b, feature, vertex_start, vertices, face_start, normals, loop_start, loops, edges, vertices_b, normals_b, width, with_area,
    n, polygon, other, height, weight,
):  # fmt: skip
    """Contact points of a pair by its separating feature: fills polygon, height, n and weight, see ``_face_contacts``; returns how many."""
    b_vertex, b_face = vertex_start[b], face_start[b]
    if feature[0] == EDGES:
        return _edge_contact(edges[feature[1]], edges[feature[2]], vertices, vertices_b, b_vertex, normals, n, polygon, height)
    if feature[0] == FACE_OF_A:
        return _face_contacts(
            1.0, feature[1], loop_start, loops, vertices, OWN, normals, OWN,
            vertices_b, b_vertex, normals_b, b_face, b_face, face_start[b + 1],
            width, with_area, n, polygon, other, height, weight,
        )  # fmt: skip
    return _face_contacts(
        -1.0, feature[1], loop_start, loops, vertices_b, b_vertex, normals_b, b_face,
        vertices, OWN, normals, OWN, face_start[a], face_start[a + 1],
        width, with_area, n, polygon, other, height, weight,
    )  # fmt: skip


@kernel()
def _face_contacts(
    sign, reference, loop_start, loops, vertices, vertex_from, normals, normal_from,
    other_vertices, other_vertex_from, other_normals, other_normal_from, other_first, other_last,
    width, with_area, n, polygon, other, height, weight,
):  # fmt: skip
    """Clip the incident face of the other part by the reference face.

    Fills polygon (contact points), height (gaps), n (from a to b: the outward normal times ``sign``) and weight (areas).
    """
    outward = normals[reference - normal_from]
    nx, ny, nz = outward[0], outward[1], outward[2]
    n[0], n[1], n[2] = sign * nx, sign * ny, sign * nz
    incident = _incident_face(other_normals, other_normal_from, other_first, other_last, nx, ny, nz)
    start, count = loop_start[incident], loop_start[incident + 1] - loop_start[incident]
    for i in range(count):
        v = other_vertices[loops[start + i] - other_vertex_from]
        polygon[i, 0], polygon[i, 1], polygon[i, 2] = v[0], v[1], v[2]
    snap = SNAP * width
    first, last = loop_start[reference], loop_start[reference + 1]
    for i in range(first, last):  # side planes of the reference face point inwards: normal x edge
        p, q = vertices[loops[i] - vertex_from], vertices[loops[i + 1 if i + 1 < last else first] - vertex_from]
        ex, ey, ez = q[0] - p[0], q[1] - p[1], q[2] - p[2]
        sx, sy, sz = ny * ez - nz * ey, nz * ex - nx * ez, nx * ey - ny * ex
        scale = 1.0 / np.sqrt(sx * sx + sy * sy + sz * sz)
        count = _cut(polygon, count, scale * sx, scale * sy, scale * sz, p[0], p[1], p[2], snap, height, other)
    count = _without_twins(polygon, count, snap)
    if count < 3 or _narrowness(polygon, count, nx, ny, nz) < SLIVER * width:
        return 0
    if with_area:
        count = _share_out(polygon, count, nx, ny, nz, weight)
    p = vertices[loops[first] - vertex_from]
    for k in range(count):  # the point lies midway between the two surfaces
        height[k] = nx * (polygon[k, 0] - p[0]) + ny * (polygon[k, 1] - p[1]) + nz * (polygon[k, 2] - p[2])
        polygon[k, 0] -= 0.5 * height[k] * nx
        polygon[k, 1] -= 0.5 * height[k] * ny
        polygon[k, 2] -= 0.5 * height[k] * nz
    return count


@kernel()
def _incident_face(normals, normal_from, first, last, nx, ny, nz):
    """The face that faces the direction -n most squarely."""
    least, at = np.inf, -1
    for f in range(first, last):
        n = normals[f - normal_from]
        value = n[0] * nx + n[1] * ny + n[2] * nz
        if value < least:
            least, at = value, f
    return at


@kernel()
def _cut(polygon, count, sx, sy, sz, px, py, pz, snap, side, kept):
    """Cut a polygon down to the positive side of the plane through p; corners within ``snap`` of it count as on it. Returns its corners."""
    all_inside = True
    for k in range(count):
        side[k] = sx * (polygon[k, 0] - px) + sy * (polygon[k, 1] - py) + sz * (polygon[k, 2] - pz)
        all_inside = all_inside and side[k] >= -snap
    if all_inside:
        return count
    out = 0
    for k in range(count):
        j = k + 1 if k + 1 < count else 0
        fx, fy = side[k], side[j]
        if fx >= -snap:
            for d in range(3):
                kept[out, d] = polygon[k, d]
            out += 1
        if (fx > snap and fy < -snap) or (fx < -snap and fy > snap):
            t = fx / (fx - fy)
            for d in range(3):
                kept[out, d] = polygon[k, d] + t * (polygon[j, d] - polygon[k, d])
            out += 1
    for k in range(out):
        for d in range(3):
            polygon[k, d] = kept[k, d]
    return out


@kernel()
def _without_twins(polygon, count, tolerance):
    """Drop corners that coincide with the one before; return how many stay."""
    out = 0
    for k in range(count):
        last = polygon[out - 1 if out > 0 else count - 1]
        dx, dy, dz = polygon[k, 0] - last[0], polygon[k, 1] - last[1], polygon[k, 2] - last[2]
        if dx * dx + dy * dy + dz * dz > tolerance * tolerance or count == 1:
            for d in range(3):
                polygon[out, d] = polygon[k, d]
            out += 1
    return out


@kernel()
def _narrowness(polygon, count, nx, ny, nz):
    """Area over diameter of a polygon seen along n: about its width [m]."""
    area, diameter = 0.0, 0.0
    for k in range(1, count):
        ax, ay, az = polygon[k, 0] - polygon[0, 0], polygon[k, 1] - polygon[0, 1], polygon[k, 2] - polygon[0, 2]
        diameter = max(diameter, ax * ax + ay * ay + az * az)
        if k + 1 < count:
            bx, by, bz = polygon[k + 1, 0] - polygon[0, 0], polygon[k + 1, 1] - polygon[0, 1], polygon[k + 1, 2] - polygon[0, 2]
            area += nx * (ay * bz - az * by) + ny * (az * bx - ax * bz) + nz * (ax * by - ay * bx)
    return 0.5 * abs(area) / np.sqrt(diameter) if diameter > 0.0 else 0.0


@kernel()
def _share_out(polygon, count, nx, ny, nz, weight):
    """Append the centroid to a polygon, and share its area seen along n out between corners and centroid; see the head of this file."""
    total, first = 0.0, polygon[0]
    centre = polygon[count]
    centre[:] = 0.0
    for i in range(1, count - 1):
        part = _triangle(first, polygon[i], polygon[i + 1], nx, ny, nz)
        total += part
        for d in range(3):
            centre[d] += part * (first[d] + polygon[i, d] + polygon[i + 1, d]) / 3.0
    for d in range(3):
        centre[d] /= total
    mixed, squares = 0.0, 0.0
    weight[: count + 1] = 0.0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        part = abs(_triangle(centre, polygon[i], polygon[j], nx, ny, nz))
        weight[i] += part / 6.0
        weight[j] += part / 6.0
        for d in range(3):
            x, y = polygon[i, d] - centre[d], polygon[j, d] - centre[d]
            mixed += part * x * y
            squares += part * (x * x + y * y)
    weight[count] = abs(total)
    for i in range(count):
        weight[i] *= 1.0 + mixed / squares
        weight[count] -= weight[i]
    return count + 1


@kernel()
def _triangle(p, q, r, nx, ny, nz):
    """Signed area of a triangle seen along n."""
    ax, ay, az = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    bx, by, bz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
    return 0.5 * (nx * (ay * bz - az * by) + ny * (az * bx - ax * bz) + nz * (ax * by - ay * bx))


@kernel()
def _edge_contact(edge_a, edge_b, vertices, vertices_b, b_vertex, normals, n, polygon, height):
    """The point midway between two crossing edges, its gap, and the normal from a to b."""
    p, p_end = vertices[edge_a[0]], vertices[edge_a[1]]
    q, q_end = vertices_b[edge_b[0] - b_vertex], vertices_b[edge_b[1] - b_vertex]
    left, right = normals[edge_a[2]], normals[edge_a[3]]
    uu, uv, vv, uw, vw = 0.0, 0.0, 0.0, 0.0, 0.0  # u, v along the edges, w from one to the other
    length, side = 0.0, 0.0
    for d in range(3):
        e, f = (d + 1) % 3, (d + 2) % 3
        u, v, w = p_end[d] - p[d], q_end[d] - q[d], q[d] - p[d]
        uu, uv, vv, uw, vw = uu + u * u, uv + u * v, vv + v * v, uw + u * w, vw + v * w
        n[d] = (p_end[e] - p[e]) * (q_end[f] - q[f]) - (p_end[f] - p[f]) * (q_end[e] - q[e])
        length += n[d] * n[d]
        side += n[d] * (left[d] + right[d])
    scale = (1.0 if side >= 0.0 else -1.0) / np.sqrt(length)
    det = uu * vv - uv * uv
    s = min(1.0, max(0.0, (uw * vv - uv * vw) / det))
    t = min(1.0, max(0.0, (uw * uv - uu * vw) / det))
    height[0] = 0.0
    for d in range(3):
        n[d] *= scale
        height[0] += n[d] * (q[d] - p[d])
        polygon[0, d] = 0.5 * (p[d] + s * (p_end[d] - p[d]) + q[d] + t * (q_end[d] - q[d]))
    return 1


@kernel()
def _match(polygon, found, local, place, first, count, reach, shared, new_place):
    """For each point, the nearest contact of the same pair in the last set that no other one has taken, or -1.

    With ``shared`` one that was taken counts too: a corner that parts in two hands on its slip and its bond to both.
    """
    for i in range(found):
        nearest, new_place[i] = reach * reach, -1
        for s in range(first, first + count):
            taken = place[s] < 0
            for k in range(i):
                taken = taken or (new_place[k] == place[s] and not shared)
            dx, dy, dz = polygon[i, 0] - local[s, 0], polygon[i, 1] - local[s, 1], polygon[i, 2] - local[s, 2]
            distance = dx * dx + dy * dy + dz * dz
            if not taken and distance < nearest:
                nearest, new_place[i] = distance, place[s]


@kernel()
def _turned(r, n):
    """The vector r n, as three numbers: no array is made."""
    return (
        r[0, 0] * n[0] + r[0, 1] * n[1] + r[0, 2] * n[2],
        r[1, 0] * n[0] + r[1, 1] * n[1] + r[1, 2] * n[2],
        r[2, 0] * n[0] + r[2, 1] * n[1] + r[2, 2] * n[2],
    )
