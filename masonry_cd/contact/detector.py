r"""Contact detection between convex parts: which surfaces may touch within the coming step, where, and how far apart they are.

    broad_phase    pairs of parts whose boxes overlap
    pair_memory    what is known of a pair from the last step; pairs that stick are done with here
    separation     the faces or edges that separate the others, the last ones first
    manifold       the points of contact of these
    facets         and those between the facets of faces of meshed blocks

Points are contacts where the gap may close within the step.

**Fast pairs.** Blocks that pass each other edge by edge face nothing of one another now, and yet may meet before the next look. Where a
pair has no points and may move by FAR of its width, they are those of its pose a step later, if both go on as they move.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from masonry_cd.arrays import Stored
from masonry_cd.contact.broad_phase import SKIN, Listing, list_holds, list_pairs
from masonry_cd.contact.facets import Facets, Overlay, has_facets, split
from masonry_cd.contact.manifold import Manifold, contact_points, incident_face
from masonry_cd.contact.motion import Motion, distance_moved, pair_margin, pose_ahead
from masonry_cd.contact.pair_memory import REUSE, PairMemory, check_pairs, is_stuck, store_points, update_gaps
from masonry_cd.contact.separation import EDGES, FACE_OF_A, FAR_APART, WHOLE, Placed, place_part, separate
from masonry_cd.errors import InputError
from masonry_cd.jit import borrower, entry
from masonry_cd.model.blocks import Assembly, Shapes
from masonry_cd.model.geometry import relative_pose, turned_normal

EDGE_BIAS = 1e-3  # an edge pair must be this much farther apart than the best face, as a share of the smaller width
FAR = 0.05  # a pair that may move by more than this share of the smaller part's width in a step is looked at as it will be then, too

ROOM_OF_FACETS = (32, 8)  # points of a pair whose faces have facets, and for each: meshes of nearly one size have three or so

APART, KEPT, CLIPPED, SEARCHED = 0, 1, 2, 3  # what was done with a pair: nothing, points carried along, points found, feature found


class ContactSet(NamedTuple):
    """C contacts. The normal points from the antagonist (second body) to the candidate (first body)."""

    bodies: np.ndarray  # (C, 2) candidate and antagonist block
    point: np.ndarray  # (C, 3) world frame [m]
    normal: np.ndarray  # (C, 3) unit
    gap: np.ndarray  # (C,) [m], negative when the blocks overlap
    area: np.ndarray  # (C,) share of the joint's area where its law goes by area, else 0 [m2]
    pair: np.ndarray  # (C,) row of the detector's pair list
    previous: np.ndarray  # (C,) the same contact in the last set, -1 for a new one

    @classmethod
    def allocate(cls, count: int) -> ContactSet:
        """Room for a number of contacts, to be filled."""
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
        facets: of meshed blocks; None: there are none.
    """

    def __init__(self, assembly: Assembly, corners_only: bool = False, facets: Facets | None = None) -> None:
        shapes = assembly.shapes
        self._shapes = shapes
        self._part_group = assembly.group_of[shapes.part_block]
        self._by_area = assembly.laws.by_area & (not corners_only)
        self._fixed_part = assembly.fixed[shapes.part_block]
        self._affine = assembly.affine
        self._skin = SKIN * float(np.median(shapes.size[~self._fixed_part]))
        self._corners = np.maximum.reduceat(np.diff(shapes.solids.loop_start), shapes.solids.face_start[:-1])  # (P,) most of a face
        facets = Facets.none() if facets is None else facets
        self._facets = facets.most(shapes.solids.owner_of_face(), len(shapes.part_block))  # (P,) most of a face
        self._work = Workspace.allocate(shapes, int(self._corners.max()), facets, more_points(2 * self._facets.max()))
        self._listing = Listing.none(assembly.count, len(shapes.part_block))
        self._remember(PairMemory.none())
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
            rotation: (B, 3, 3) body to world, with the strain of blocks that deform.
            velocity: (B, 6), bounds how far blocks can come closer within the step.
            step: time step [s].
            slack: distance that forces not yet known may add within the step [m].
            origin: (3,) displacement of the supports since the start [m].
        """
        motion = Motion(position, rotation, velocity, float(step), float(slack), self._affine)
        count = self._update(motion, origin, False)
        if count < 0:
            self._rebuild(motion, origin)
            count = self._update(motion, origin, True)
        if self._work.overlay.full[0]:
            raise InputError("material.mesh_size: two faces with meshes of very different sizes touch in too many points; take sizes alike")
        found = ContactSet.allocate(count)
        write_contacts(self._memory, self._shapes.part_block, motion, found)
        return found

    def copied(self) -> Detector:
        """A detector that remembers the same and goes its own way."""
        other = copy.copy(self)
        other._memory = PairMemory(*[array.copy() for array in self._memory])
        other._listing = Listing(*[array.copy() for array in self._listing])
        other.tally = self.tally.copy()
        return other

    def snapshot(self) -> dict[str, np.ndarray]:
        """What the detector remembers, as arrays for a checkpoint."""
        listed = {f"listed_{name}": getattr(self._listing, name) for name in ("position", "rotation")}
        own = listed | {"allowance": self._listing.allowance, "tally": self.tally, "rebuilds": np.array(self.rebuilds)}
        return self._memory.snapshot() | own

    def check(self, stored: Stored, contacts: int) -> None:
        """Check what :meth:`restore` takes, with so many contacts in the last set.

        Raises:
            InputError: an array that no detector of these blocks leaves.
        """
        shapes, blocks = self._shapes, len(self._listing.position)
        parts = stored.whole("parts", None, 2, high=len(shapes.part_block))
        keys = parts @ [len(shapes.part_block), 1]
        if (np.diff(keys) <= 0).any() or (shapes.part_block[parts[:, 0]] == shapes.part_block[parts[:, 1]]).any():
            stored.refuse("parts", "not in order")
        check_pairs(stored, parts, self._capacity(parts), shapes, contacts)
        stored.real("listed_position", blocks, 3)
        stored.real("listed_rotation", blocks, 3, 3)
        stored.real("allowance", len(shapes.part_block), finite=False)
        stored.whole("tally", 4)
        stored.whole("rebuilds")
        stored.nothing_else()

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Take back what :meth:`snapshot` gave."""
        self._remember(PairMemory.restored(arrays, self._capacity(arrays["parts"])))
        self._listing = Listing(arrays["listed_position"], arrays["listed_rotation"], arrays["allowance"])
        self.tally, self.rebuilds = arrays["tally"], int(arrays["rebuilds"])

    def _update(self, motion: Motion, origin: np.ndarray, just_listed: bool) -> int:
        """Bring the pairs up to date; the number of contacts, or -1 if the pairs have to be listed anew."""
        known = (self._listing, self._memory, self._shapes)
        return int(update_pairs(*known, motion, origin, just_listed, self._pair_by_area, self._work, self.tally))

    def _rebuild(self, motion: Motion, origin: np.ndarray) -> None:
        """Sweep the boxes again, and carry over what is remembered of the pairs that stay."""
        self._listing = Listing(motion.position - origin, motion.rotation.copy(), self._listing.allowance)
        pairs = list_pairs(self._listing, self._shapes, motion, self._fixed_part, self._skin)
        self._remember(self._memory.carried_over(pairs, self._capacity(pairs)))
        self.rebuilds += 1

    def _remember(self, memory: PairMemory) -> None:
        """Have a memory of new pairs, and the law of each: whether it goes by area."""
        self._memory = memory
        groups = self._part_group[memory.parts]
        self._pair_by_area = self._by_area[groups[:, 0], groups[:, 1]]

    def _capacity(self, pairs: np.ndarray) -> np.ndarray:
        """Most points (P,) of each pair: a polygon of i corners cut by one of k has i + k at most; the centroid; those of facets."""
        facets = self._facets[pairs].sum(axis=1)
        return np.asarray(self._corners[pairs].sum(axis=1) + 1 + more_points(facets))


def more_points(facets: Any) -> Any:
    """How many more points a pair may have whose faces have so many facets together."""
    return np.where(facets > 0, ROOM_OF_FACETS[0] + ROOM_OF_FACETS[1] * facets, 0)


class Workspace(NamedTuple):
    """Scratch arrays for one pair after another, and the facets."""

    now: np.ndarray  # (12,) pose of b in the frame of a
    vertices: np.ndarray  # (V, 3) of b in the frame of a [m]
    normals: np.ndarray  # (F, 3)
    manifold: Manifold
    place: np.ndarray  # (N,) contacts of the last set that its points continue
    ahead_position: np.ndarray  # (2, 3) of both bodies a step later [m]
    ahead_rotation: np.ndarray  # (2, 3, 3)
    faces: np.ndarray  # (2,) by which a and b touch
    facets: Facets
    overlay: Overlay

    @classmethod
    def allocate(cls, shapes: Shapes, corners: int, facets: Facets, more: int) -> Workspace:
        """Room for parts, by the largest number of corners of a face, and for more points between facets."""
        manifold = Manifold.allocate(corners, int(more))
        vertices, faces = (int(np.diff(start).max()) for start in (shapes.solids.vertex_start, shapes.solids.face_start))
        place = np.empty(len(manifold.point), dtype=np.int64)
        return cls(
            np.empty(12), np.empty((vertices, 3)), np.empty((faces, 3)), manifold, place, np.empty((2, 3)), np.empty((2, 3, 3)),
            np.zeros(2, dtype=np.int64), facets, Overlay.allocate(corners),
        )  # fmt: skip


@entry()
def update_pairs(
    listing: Listing,
    memory: PairMemory,
    shapes: Shapes,
    motion: Motion,
    origin: np.ndarray,
    just_listed: bool,
    by_area: np.ndarray,
    work: Workspace,
    tally: np.ndarray,
) -> int:
    """Bring the points of all P pairs up to date, and the gap of each, inf where it is beyond the margin.

    ``origin`` (3,) is the displacement of the supports since the start [m]; ``just_listed``: the list holds, where motions are not finite
    too; ``by_area`` (P,) whether the law of the joint goes by area; ``tally`` (4,) counts what was done.

    Returns:
        how many points are within the margin; -1, and nothing is done, where the list of pairs no longer holds.
    """
    if not just_listed and not list_holds(listing, shapes, motion, origin):
        return -1
    part_block, radius, size = shapes.part_block, shapes.radius, shapes.size
    parts, slot, count, gap, now = memory.parts, memory.slot, memory.point_count, memory.gap, work.now
    within = 0
    for k in range(parts.shape[0]):
        a, b = parts[k, 0], parts[k, 1]
        block_a, block_b = part_block[a], part_block[b]
        width = min(size[a], size[b])
        margin = pair_margin(motion, block_a, block_b, radius[a], radius[b], width)
        relative_pose(motion.position, motion.rotation, motion.affine, block_a, block_b, now)
        if is_stuck(memory, k, now, radius[b], width):
            update_gaps(memory, k, now, motion.affine)
            tally[KEPT] += 1
        else:
            _look_again(memory, k, shapes, motion, margin, width, by_area[k], work, tally)
        for s in range(slot[k], slot[k] + count[k]):
            if gap[s] > margin:
                gap[s] = np.inf
            else:
                within += 1
    return within


@borrower()
def _look_again(memory, k, shapes, motion, margin, width, by_area, work, tally):
    """Find the points of pair k and their gaps anew, as far as the pair has moved; ``margin`` and ``width`` [m]."""
    solids, now, feature = shapes.solids, work.now, memory.feature[k]
    a, b = memory.parts[k, 0], memory.parts[k, 1]
    moved = distance_moved(now, memory.pose[k], shapes.radius[b])
    if feature[0] == FAR_APART and memory.budget[k] - moved > margin:
        tally[APART] += 1
        return
    own, other = (
        Placed(solids.vertices, solids.normals, WHOLE, WHOLE),
        place_part(now, b, solids, motion.affine, work.vertices, work.normals),
    )
    if feature[0] == FAR_APART or not moved < REUSE * width:
        tally[SEARCHED] += 1
        apart = separate(a, b, solids, own, other, EDGE_BIAS * width, feature)
        _copy(now, memory.pose[k])
        if apart > margin:
            feature[0], memory.budget[k], memory.point_count[k] = FAR_APART, apart, 0
            return
    tally[CLIPPED] += 1
    with_area = by_area and feature[0] != EDGES
    found = _points(memory, k, solids, own, other, now, width, with_area, work)
    _copy(now, memory.built[k])
    if found == 0 and margin > FAR * width and not with_area:
        found = _look_ahead(memory, k, shapes, motion, margin, width, work)
    store_points(memory, k, found, work.manifold, with_area, width, work.place)
    update_gaps(memory, k, now, motion.affine)


@borrower()
def _copy(pose, to):
    """Copy a relative pose (12,)."""
    for i in range(12):
        to[i] = pose[i]


@borrower()
def _look_ahead(memory, k, shapes, motion, margin, width, work):
    """Fill the manifold with the points of pair k in its pose a step later, which becomes the pose remembered; returns how many."""
    solids, feature, pose = shapes.solids, memory.feature[k], memory.built[k]
    a, b = memory.parts[k, 0], memory.parts[k, 1]
    pose_ahead(motion, shapes.part_block[a], shapes.part_block[b], work.ahead_position, work.ahead_rotation, pose)
    own, other = (
        Placed(solids.vertices, solids.normals, WHOLE, WHOLE),
        place_part(pose, b, solids, motion.affine, work.vertices, work.normals),
    )
    _copy(pose, memory.pose[k])
    if separate(a, b, solids, own, other, EDGE_BIAS * width, feature) > margin:
        return 0
    return _points(memory, k, solids, own, other, pose, width, False, work)


@borrower()
def _points(memory, k, solids, own, other, pose, width, with_area, work):
    """Fill the manifold with the points of pair k, of which b has a pose (12,) in the frame of a; returns how many."""
    parts, feature, faces = (memory.parts[k, 0], memory.parts[k, 1]), memory.feature[k], work.faces
    cut = False
    if len(work.facets.start) > 1 and feature[0] != EDGES:
        if feature[0] == FACE_OF_A:
            faces[0], faces[1] = feature[1], incident_face(parts[1], solids, other, own.normals[feature[1] - own.first_face])
        else:
            faces[0], faces[1] = incident_face(parts[0], solids, own, other.normals[feature[1] - other.first_face]), feature[1]
        cut = has_facets(work.facets, faces)
    found = contact_points(parts, feature, solids, own, other, width, with_area and not cut, memory.normal[k], work.manifold)
    if not cut or found == 0:
        return found
    room = memory.slot[k + 1] - memory.slot[k]
    return split(work.facets, faces, pose, memory.normal[k], found, width, with_area, room, work.manifold, work.overlay)


@entry()
def write_contacts(memory: PairMemory, part_block: np.ndarray, motion: Motion, rows: ContactSet) -> None:
    """Fill the rows of a set with the points within the margin, in the world frame, and note the row of each."""
    total = 0
    for k in range(memory.parts.shape[0]):
        if memory.point_count[k] == 0:
            continue
        a, b = part_block[memory.parts[k, 0]], part_block[memory.parts[k, 1]]
        r, x, scale = motion.rotation[a], motion.position[a], 1.0
        if len(motion.affine) == 2:
            nx, ny, nz, scale = turned_normal(motion.rotation, a, memory.normal[k])
        else:
            nx, ny, nz = _turned(r, memory.normal[k])
        for s in range(memory.slot[k], memory.slot[k] + memory.point_count[k]):
            if memory.gap[s] == np.inf:
                memory.place[s] = -1
                continue
            px, py, pz = _turned(r, memory.local[s])
            rows.point[total, 0], rows.point[total, 1], rows.point[total, 2] = x[0] + px, x[1] + py, x[2] + pz
            rows.normal[total, 0], rows.normal[total, 1], rows.normal[total, 2] = nx, ny, nz
            rows.bodies[total, 0], rows.bodies[total, 1] = b, a
            rows.gap[total], rows.area[total] = scale * memory.gap[s], memory.area[s]
            rows.pair[total], rows.previous[total] = k, memory.place[s]
            memory.place[s] = total
            total += 1


@borrower()
def _turned(r, v):
    """The vector r v, r (3, 3), as three numbers: no array is made."""
    return (
        r[0, 0] * v[0] + r[0, 1] * v[1] + r[0, 2] * v[2],
        r[1, 0] * v[0] + r[1, 1] * v[1] + r[1, 2] * v[2],
        r[2, 0] * v[0] + r[2, 1] * v[1] + r[2, 2] * v[2],
    )
