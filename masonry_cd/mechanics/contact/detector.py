# SPDX-License-Identifier: GPL-3.0-or-later
r"""Contact detection between convex parts: which surfaces may touch within the coming step, where, and how far apart they are.

    broad_phase    pairs of parts whose boxes overlap, but those that have no contact (apart)
    pair_memory    what is known of a pair from the last step; pairs that stick are done with here
    separation     the faces or edges that separate the others, the last ones first
    flat_contact   finds both again, for polyhedra
    manifold       the points of contact of these
    facets         and those between the facets of faces of meshed blocks
    round_contact  spheres: where they come nearest to others, and to polyhedra
    contact_set    the points within the margin, in the world frame

Points are contacts where the gap may close within the step.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from masonry_cd.foundation.arrays import Stored
from masonry_cd.foundation.jit import borrower, entry
from masonry_cd.mechanics.contact.apart import Apart
from masonry_cd.mechanics.contact.broad_phase import SKIN, Listing, list_holds, list_pairs
from masonry_cd.mechanics.contact.contact_set import ContactSet, write_contacts
from masonry_cd.mechanics.contact.facets import Facets, Overlay
from masonry_cd.mechanics.contact.faults import TooManyPoints, UnexplainedOverlap
from masonry_cd.mechanics.contact.flat_contact import look_again
from masonry_cd.mechanics.contact.joint_points import CRUSHES, GRAVITY, LIGHT
from masonry_cd.mechanics.contact.motion import BodyMotion, pair_margin
from masonry_cd.mechanics.contact.pair_memory import APART, KEPT, SEARCHED, PairMemory, check_pairs, is_stuck, update_gaps
from masonry_cd.mechanics.contact.round_contact import POINTS, find_round_contact
from masonry_cd.mechanics.contact.workspace import Workspace
from masonry_cd.mechanics.linalg.threads import in_shares
from masonry_cd.mechanics.model.blocks import Assembly, ConvexShapes
from masonry_cd.mechanics.model.geometry import relative_pose

ROOM_OF_FACETS = (32, 8)  # points of a pair whose faces have facets, and for each: meshes of nearly one size have three or so

# Kinds of pairs: points at corners; at centroids too, with areas; between facets; those with areas; of a sphere. The last three loop apart.
CORNERS, BY_AREA, FACET_PAIR, FACETS_BY_AREA, ROUND_PAIR = 0, 1, 2, 3, 4

StiffnessOf = Callable[[np.ndarray, np.ndarray], np.ndarray]


class Detector:
    """Finds contacts step after step and remembers what the next step can use.

    Args:
        assembly: the blocks.
        corners_only: no centroids and no areas, whatever the laws of the joints.
        facets: of meshed blocks; None: there are none.
        stiffness: k_n and k_t of joints without a law of their own, (P, 2) [N/m3], by their parts and blocks (P, 2); None: there are none.
    """

    def __init__(
        self, assembly: Assembly, corners_only: bool = False, facets: Facets | None = None, stiffness: StiffnessOf | None = None
    ) -> None:
        shapes = assembly.shapes
        self._shapes = shapes
        self._rows = assembly.rows  # of the tables of laws, for pairs of blocks
        self._law_by_area = assembly.laws.by_area & (not corners_only)
        rings = assembly.laws.points.astype(np.int64) // 2
        self._rings_of_law = np.where(assembly.laws.elastic & (not corners_only), rings, 1)  # (G, G)
        self._normal_stiffness, self._stiffness_of = assembly.laws.normal_stiffness, stiffness
        self._crushes = assembly.laws.elastic & ((assembly.laws.crushing > 0.0) | (assembly.laws.fracture > 0.0)) & (not corners_only)
        self._weight = np.where(assembly.fixed, np.inf, GRAVITY * assembly.mass)
        self._fixed_part = assembly.fixed[shapes.part_block]
        self._apart = Apart.of(assembly)
        self._affine = assembly.affine
        self._skin = SKIN * float(np.median(shapes.size[~self._fixed_part]))
        self._corners = _most_corners(shapes)
        self._rolling = assembly.rolling if not corners_only else np.zeros_like(assembly.rolling)
        facets = Facets.none() if facets is None else facets
        self._facets = facets.most(shapes.solids.owner_of_face(), len(shapes.part_block))  # (P,) most of a face
        self._work = [self._workspace()]  # of each thread
        self._overlay = Overlay.allocate(facets, int(self._corners.max()))
        self._listing = Listing.none(assembly.count, len(shapes.part_block))
        self._remember(PairMemory.none())
        self.rebuilds = 0
        self.contacts = 0  # of the last set
        self.tally = np.zeros(4, dtype=np.int64)  # pairs so far that were APART, KEPT, CLIPPED, SEARCHED

    @property
    def pairs(self) -> np.ndarray:
        """(P, 2) parts that may meet before the list is rebuilt."""
        return self._memory.parts

    @property
    def left_out(self) -> dict[str, int]:
        """How often so far each part of the work was done or left out; pairs are counted in every detection."""
        names = ("pairs_not_looked_at", "pairs_with_points_kept", "pairs_with_points_found", "pairs_with_faces_searched")
        return {"broad_phases": self.rebuilds} | dict(zip(names, self.tally.tolist(), strict=True))

    def detect(
        self,
        position: np.ndarray,
        rotation: np.ndarray,
        velocity: np.ndarray,
        step: float,
        slack: float,
        origin: np.ndarray,
        threads: int = 1,
    ) -> ContactSet:
        """List the contacts of a configuration.

        Args:
            position: (B, 3) centres of mass [m].
            rotation: (B, 3, 3) body to world, with the strain of blocks that deform.
            velocity: (B, 6), bounds how far blocks can come closer within the step.
            step: time step [s].
            slack: distance that forces not yet known may add within the step [m].
            origin: (3,) displacement of the supports since the start [m].
            threads: that share the pairs of polyhedra; they change no bit.

        Raises:
            TooManyPoints: the meshes of two faces cross too often.
            UnexplainedOverlap: two parts are deeper in each other than they can have moved.
        """
        motion = BodyMotion(position, rotation, velocity, float(step), float(slack), self._affine)
        count = self._update(motion, origin, False, threads)
        if count < 0:
            self._rebuild(motion, origin)
            count = self._update(motion, origin, True, threads)
        if self._overlay.crowded[0] >= 0:
            raise self._crowding()
        if any(work.unexplained[0] >= 0.0 for work in self._work):
            raise self._unexplained()
        self.contacts, found = count, ContactSet.allocate(count)
        write_contacts(self._memory, self._shapes.part_block, motion, found)
        return found

    def crush(self, by: np.ndarray) -> None:
        """Shorten joints for good at the contacts of the last set, by so much each, (C,) [m]."""
        rows = self._memory.rows()
        place = self._memory.place[rows]
        self._memory.crushed[rows[place >= 0]] += by[place[place >= 0]]

    def most_crushed(self) -> np.ndarray:
        """Return the largest permanent shortening of the joint of each pair, (P,) [m]."""
        out, memory = np.zeros(len(self.pairs)), self._memory
        np.maximum.at(out, np.repeat(np.arange(len(out)), memory.point_count), memory.crushed[memory.rows()])
        return out

    def copied(self) -> Detector:
        """A detector that remembers the same and goes its own way."""
        other = copy.copy(self)
        other._memory = PairMemory(*[array.copy() for array in self._memory])
        other._listing = Listing(*[array.copy() for array in self._listing])
        other.tally = self.tally.copy()
        return other

    def go_on_from(self, other: Detector) -> None:
        """Remember what one of the same blocks does, of which others are supports or absent, and list pairs again."""
        self.restore(other.snapshot() | {"allowance": np.full(len(self._fixed_part), np.nan)})

    def blocks_of_contacts(self) -> np.ndarray:
        """The blocks of the contacts of the last set, (C, 2)."""
        return np.asarray(self._shapes.part_block[self._memory.parts][self._memory.pair_of_contacts()])

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return the memory of the detector, as arrays for a checkpoint."""
        listed = {f"listed_{name}": getattr(self._listing, name) for name in ("position", "rotation")}
        own = listed | {"allowance": self._listing.allowance, "tally": self.tally, "rebuilds": np.array(self.rebuilds)}
        return self._memory.snapshot() | own

    def check(self, stored: Stored, contacts: int) -> None:
        """Check what :meth:`restore` takes, with a given number of contacts in the last set.

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
        stored.check_all_read()

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Take back what :meth:`snapshot` gave."""
        self._remember(PairMemory.restored(arrays, self._capacity(arrays["parts"])))
        self._listing = Listing(arrays["listed_position"], arrays["listed_rotation"], arrays["allowance"])
        self.tally, self.rebuilds = arrays["tally"], int(arrays["rebuilds"])

    def _update(self, motion: BodyMotion, origin: np.ndarray, just_listed: bool, threads: int) -> int:
        """Bring the pairs up to date; the number of contacts, or -1 if the pairs have to be listed again."""
        known, work, tally = (self._memory, self._shapes, motion, self._kind), self._work, [self.tally]
        while len(work) < threads:
            work.append(self._workspace())
        while len(tally) < threads:
            tally.append(np.zeros(4, dtype=np.int64))

        def update(rank: int, first: int, end: int) -> int:
            return update_pairs(self._listing, origin, just_listed, *known, work[rank], tally[rank], (first, end))

        counts = in_shares(update, threads, len(self.pairs))
        for of_thread in tally[1:]:
            self.tally += of_thread
        if counts[0] < 0:  # so says each
            return -1
        count = sum(counts)
        if self._meshed:
            count += update_facet_pairs(*known, work[0], self._overlay, self.tally)
        if self._round:
            count += update_round_pairs(*known, self._arm, work[0], self.tally)
        return count

    def _workspace(self) -> Workspace:
        """Scratch arrays for a thread."""
        return Workspace.allocate(self._shapes, int(self._corners.max()), int(more_points(2 * self._facets.max())))

    def _crowding(self) -> TooManyPoints:
        """Return the fault of faces that have no space for their points; other detections may continue."""
        faces = self._overlay.crowded.copy()
        self._overlay.crowded[:] = -1
        blocks = self._shapes.part_block[self._shapes.solids.owner_of_face()[faces]]
        return TooManyPoints((int(blocks[0]), int(blocks[1])))

    def _unexplained(self) -> UnexplainedOverlap:
        """Return the fault of the first pair whose overlap no motion explains; other detections may continue."""
        pair, gap, least = min(tuple(work.unexplained) for work in self._work if work.unexplained[0] >= 0.0)
        for work in self._work:
            work.unexplained[0] = -1.0
        a, b = self._shapes.part_block[self.pairs[int(pair)]]
        return UnexplainedOverlap((int(a), int(b)), float(-gap), float(-least))

    def _rebuild(self, motion: BodyMotion, origin: np.ndarray) -> None:
        """Sweep the boxes again, and carry over what is remembered of the pairs that stay."""
        self._listing = Listing(motion.position - origin, motion.rotation.copy(), self._listing.allowance)
        listed = list_pairs(self._listing, self._shapes, motion, self._fixed_part, self._skin)
        pairs = self._apart.without(listed, len(self._listing.position))
        self._remember(self._memory.carried_over(pairs, self._capacity(pairs)))
        self.rebuilds += 1

    def _remember(self, memory: PairMemory) -> None:
        """Have a memory of new pairs, the kind of each, and the arm of its rolling friction [m]."""
        self._memory = memory
        rows = self._rows(*self._shapes.part_block[memory.parts].T)
        round_pair, meshed = (self._shapes.rounding[memory.parts] > 0.0).any(axis=1), self._facets[memory.parts].any(axis=1)
        self._kind = np.where(self._law_by_area[rows], BY_AREA, CORNERS) + np.where(meshed, FACET_PAIR, 0)
        self._kind[round_pair] = ROUND_PAIR
        memory.rings[:], memory.light[:] = self._rings(memory.parts), self._light(memory.parts)
        self._arm = self._rolling[rows] * effective_radius(*self._shapes.rounding[memory.parts].T)
        self._meshed, self._round = bool((meshed & ~round_pair).any()), bool(round_pair.any())

    def _capacity(self, pairs: np.ndarray) -> np.ndarray:
        """Most points (P,) of each pair: a polygon of i corners cut by one of k has i + k at most, or rings of them; centroid; facets."""
        return np.asarray(self._corners[pairs].sum(axis=1) * self._rings(pairs) + 1 + more_points(self._facets[pairs].sum(axis=1)))

    def _rings(self, pairs: np.ndarray) -> np.ndarray:
        """Rings of points that joints of pairs of parts (P, 2) have where they open, (P,)."""
        return np.where(self._facets[pairs].any(axis=1), 1, self._rings_of_law[self._rows(*self._shapes.part_block[pairs].T)])

    def _light(self, pairs: np.ndarray) -> np.ndarray:
        """Overlap times area [m3] of joints between pairs of parts (P, 2) that carry LIGHT of the weight of the lighter block, (P,)."""
        blocks = self._shapes.part_block[pairs]
        rows = self._rows(*blocks.T)
        stiffness = self._normal_stiffness[rows]
        if self._stiffness_of is not None:
            stiffness = np.where(stiffness > 0.0, stiffness, self._stiffness_of(pairs, blocks)[:, 0])
        light = np.divide(LIGHT * self._weight[blocks].min(axis=1), stiffness, out=np.zeros(len(pairs)), where=stiffness > 0.0)
        return np.where(self._crushes[rows], CRUSHES, light)


def more_points(facets: Any) -> Any:
    """How many more points a pair may have whose faces have a given number of facets together."""
    return np.where(facets > 0, ROOM_OF_FACETS[0] + ROOM_OF_FACETS[1] * facets, 0)


def effective_radius(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """1 / (1 / R_a + 1 / R_b) of pairs of spheres of those radii [m]; 0 stands for a polyhedron, which is flat, or of two for no sphere."""
    return np.where(np.minimum(first, second) > 0.0, first * second / np.maximum(first + second, 1e-300), np.maximum(first, second))


def _most_corners(shapes: ConvexShapes) -> np.ndarray:
    """Most corners of a face of each part, (P,); of a sphere what its contact with another may have points."""
    starts, out = shapes.solids.face_start, np.full(len(shapes.part_block), POINTS)
    flat = shapes.rounding == 0.0
    if flat.any():
        out[flat] = np.maximum.reduceat(np.diff(shapes.solids.loop_start), starts[:-1][flat])
    return out


@entry()
def update_pairs(
    listing: Listing,
    origin: np.ndarray,
    just_listed: bool,
    memory: PairMemory,
    shapes: ConvexShapes,
    motion: BodyMotion,
    kind: np.ndarray,
    work: Workspace,
    tally: np.ndarray,
    share: tuple[int, int],
) -> int:
    """Bring the points of the pairs without spheres and facets up to date, and the gap of each, inf where it is beyond the margin.

    ``origin`` (3,) is the displacement of the supports since the start [m]; ``just_listed``: the list holds, where motions are not finite
    too; ``kind`` (P,) of each pair; ``tally`` (4,) counts what was done; ``share``: the first pair that is looked at, and the end.

    Returns:
        how many points are within the margin; -1, and nothing is done, where the list of pairs no longer holds.
    """
    if not just_listed and not list_holds(listing, shapes, motion, origin):
        return -1
    part_block, radius, size = shapes.part_block, shapes.radius, shapes.size
    parts, slot, count, gap, now = memory.parts, memory.slot, memory.point_count, memory.gap, work.now
    within = 0
    for k in range(share[0], share[1]):
        if kind[k] > BY_AREA:
            continue
        a, b = parts[k, 0], parts[k, 1]
        block_a, block_b = part_block[a], part_block[b]
        width, memory.exchanged[k] = min(size[a], size[b]), False
        margin = pair_margin(motion, block_a, block_b, radius[a], radius[b], width)
        relative_pose(motion.position, motion.rotation, motion.affine, block_a, block_b, now)
        if is_stuck(memory, k, now, motion.affine, radius[b], width):
            update_gaps(memory, k, now, motion.affine)
            tally[KEPT] += 1
        else:
            look_again(memory, k, shapes, motion, margin, width, kind[k] == BY_AREA, work, None, tally)
        for s in range(slot[k], slot[k] + count[k]):
            if gap[s] > margin:
                gap[s] = np.inf
            else:
                within += 1
    return within


@entry()
def update_facet_pairs(
    memory: PairMemory, shapes: ConvexShapes, motion: BodyMotion, kind: np.ndarray, work: Workspace, overlay: Overlay, tally: np.ndarray
) -> int:
    """As :func:`update_pairs`, for the pairs of which one part at least is meshed; apart, as those with spheres."""
    within = 0
    for k in range(memory.parts.shape[0]):
        if kind[k] <= BY_AREA or kind[k] == ROUND_PAIR:
            continue
        margin, width, kept = _keep_points(memory, k, shapes, motion, work, tally)
        if not kept:
            look_again(memory, k, shapes, motion, margin, width, kind[k] == FACETS_BY_AREA, work, overlay, tally)
        within += _within_margin(memory, k, margin)
    return within


@entry()
def update_round_pairs(
    memory: PairMemory, shapes: ConvexShapes, motion: BodyMotion, kind: np.ndarray, arm: np.ndarray, work: Workspace, tally: np.ndarray
) -> int:
    """As :func:`update_pairs`, for the pairs of which one part at least is a sphere; ``arm`` (P,) of the rolling friction [m].

    Apart, since the compiler makes slower code of the loop over polyhedra where it holds this too.
    """
    within = 0
    for k in range(memory.parts.shape[0]):
        if kind[k] != ROUND_PAIR:
            continue
        margin, _, kept = _keep_points(memory, k, shapes, motion, work, tally)
        if not kept:
            looked = find_round_contact(memory, k, shapes, motion, margin, arm[k], work)
            tally[SEARCHED if looked else APART] += 1
        within += _within_margin(memory, k, margin)
    return within


@borrower()
def _keep_points(memory, k, shapes, motion, work, tally):
    """Place pair k, and carry its points along if it sticks; its margin and width [m], and whether it does."""
    a, b = memory.parts[k, 0], memory.parts[k, 1]
    block_a, block_b, width = shapes.part_block[a], shapes.part_block[b], min(shapes.size[a], shapes.size[b])
    margin = pair_margin(motion, block_a, block_b, shapes.radius[a], shapes.radius[b], width)
    relative_pose(motion.position, motion.rotation, motion.affine, block_a, block_b, work.now)
    kept = is_stuck(memory, k, work.now, motion.affine, shapes.radius[b], width)
    if kept:
        update_gaps(memory, k, work.now, motion.affine)
        tally[KEPT] += 1
    return margin, width, kept


@borrower()
def _within_margin(memory, k, margin):
    """How many points of pair k are within the margin [m]; the gaps of the others become inf."""
    within = 0
    for s in range(memory.slot[k], memory.slot[k] + memory.point_count[k]):
        if memory.gap[s] > margin:
            memory.gap[s] = np.inf
        else:
            within += 1
    return within
