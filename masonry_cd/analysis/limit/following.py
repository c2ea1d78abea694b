# SPDX-License-Identifier: GPL-3.0-or-later
r"""A mechanism followed over a finite step: its blocks move along their screws, and what touches goes on touching.

Blocks that the mechanism moves alike are one body. A step takes each body along the screw of its velocity, then corrects what the motion of
the others has changed meanwhile, by Newton steps of least norm: points that neither open nor slide stay together, points that slide stay on
the surface on which they slide (the dilation of an associated mechanism is not followed), and ties that neither yield nor go slack keep
their length. With one degree of freedom this is exact, however long the step. Where it would lock the mechanism, or cannot be met, or lets
blocks overlap, contacts give way (:mod:`masonry_cd.analysis.limit.least_work`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import lstsq
from scipy.sparse import coo_matrix, csr_matrix, identity, vstack
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from masonry_cd.analysis.limit.least_work import FAR, Resistance, least_work
from masonry_cd.analysis.limit.mechanism import STILL
from masonry_cd.analysis.limit.moved import Placement
from masonry_cd.analysis.limit.problem import Bars, LimitProblem
from masonry_cd.analysis.limit.solution import Optimum
from masonry_cd.mechanics.model.blocks import Assembly

MANY = 100  # unknowns from which sparse least squares are faster
SMALL = 1e-9  # of the largest diagonal entry of A^T A: what is added to it
REFINED = 12  # rounds of least squares at most
ROUNDS = 12  # of Newton's method at most
EXACT = 1e-12  # share of the mean size of a block to which constraints are met
MISSED = 1e-9  # and where they are missed by more, those of points that bear nothing are dropped
PARALLEL = 1e-9  # normals that differ by less are one
SHORT = 1e-3  # step, as a share of the mean size of a block, on which it is seen what can be kept
CLOSE = 1e-3  # share of a step below which a correction is the last
NEARER = 0.1  # share by which the largest correction shrinks from round to round, in space
NEAR = 0.05  # and in space, whose programmes end at a tolerance that leaves d uncertain by as much; overlaps then count above MISSED
LOCKED = 0.1  # share of a step that blocks go at least, where their mechanism does not lock
BEARS = 1e-6  # share of the mean weight of a block above which a point bears


@dataclass(frozen=True, eq=False)
class KeptConstraints:
    """Constraints of a step: N points at which ``rows`` times the shift between the two blocks stays zero, and the lengths of T ties."""

    bodies: np.ndarray  # (N, 2)
    local: np.ndarray  # (N, 2, 3) the point in the frame of either block, from its centre of mass
    rows: np.ndarray  # (N, 3, 3) in the frame of the carrier; zero where nothing is asked
    carrier: np.ndarray  # (N,) 0 or 1: which block carries the rows
    ties: np.ndarray  # (T, 2) blocks
    tie_arms: np.ndarray  # (T, 2, 3) ends, from the centres of mass
    lengths: np.ndarray  # (T,) [m]


@dataclass(frozen=True, eq=False)
class FollowedMotion:
    """How blocks move from where they are placed, by bodies: those of one move as one."""

    start: Placement
    velocity: np.ndarray  # (B, 6), the largest of any corner is one
    body: np.ndarray  # (B,) body of each block, -1 of the blocks that do not move
    kept: KeptConstraints
    bearing: KeptConstraints  # of the points that bear only
    yielding: KeptConstraints  # and those that open, on the faces on which they slide once they give way
    resistance: Resistance  # of these
    size: float  # [m]
    columns: np.ndarray  # of (v, w) in which blocks may move

    def follow(self, amount: float) -> tuple[Placement, float]:
        """Where the blocks are when the fastest corner has gone about ``amount`` [m], and by how much anything kept is missed [m]."""
        moved = self.start.along(self.velocity, amount)
        if self.held is not None:
            end, missed = self._corrected(moved, self.held)
            if self._kept_up(end, amount, missed):
                return end, missed
        return self._yielded(moved, amount)

    @cached_property
    def held(self) -> KeptConstraints | None:
        """Return the constraints that a short step can keep: all, or those that bear; None where contacts have to give way."""
        amount = SHORT * self.size
        for kept in (self.kept, self.bearing):
            end, missed = self._corrected(self.start.along(self.velocity, amount), kept)
            if self._kept_up(end, amount, missed):
                return kept
        return None

    def _kept_up(self, end: Placement, amount: float, missed: float) -> bool:
        """Return True if a step has met what it keeps, has gone on, and lets no blocks overlap."""
        return max(missed, self._overlap(end)) <= MISSED * self.size and self.progress(end) >= LOCKED * amount

    def _overlap(self, placement: Placement) -> float:
        """Largest overlap at points that touched [m]."""
        residual = self._equations(placement, self.yielding)[0]
        return -float(residual[self.resistance.opens].min(initial=0.0))

    def progress(self, end: Placement) -> float:
        """How far any point has gone, about [m]."""
        gone = np.linalg.norm(end.position - self.start.position, axis=1)
        gone += self.size * np.linalg.norm(end.rotation - self.start.rotation, axis=(1, 2))
        return float(gone.max(initial=0.0))

    def _corrected(self, placement: Placement, kept: KeptConstraints) -> tuple[Placement, float]:
        """A placement with all that is kept, as far as that goes, and what is missed."""
        missed = np.inf
        for _ in range(ROUNDS):
            residual, matrix, centres = self._equations(placement, kept)
            now = float(np.abs(residual).max(initial=0.0))
            if now <= EXACT * self.size or now >= missed:
                return placement, now
            missed = now
            step = _least_norm(matrix, -residual)
            placement = self._shifted(placement, step, centres)
        return placement, float(np.abs(self._equations(placement, kept)[0]).max(initial=0.0))

    def _yielded(self, placement: Placement, amount: float) -> tuple[Placement, float]:
        """A placement whose contacts have given way where that costs least work, and by how much they still overlap."""
        exact, close = (EXACT, CLOSE) if len(self.columns) == 3 else (MISSED, NEAR)
        overlap = np.inf
        for k in range(ROUNDS):
            residual, matrix, centres = self._equations(placement, self.yielding)
            overlap = -float(residual[self.resistance.opens].min(initial=0.0))
            step = least_work(matrix, residual, self.resistance, self._along(placement, centres), amount, FAR * NEARER**k)
            if step is None:
                return placement, overlap if k and overlap <= MISSED * self.size else np.inf
            placement = self._shifted(placement, step, centres)
            if overlap <= exact * self.size and float(np.abs(step).max(initial=0.0)) <= close * amount:
                break
        return placement, overlap

    def _along(self, placement: Placement, centres: np.ndarray) -> np.ndarray:
        """The twists of the bodies in the mechanism (D,), at their centres now."""
        count = len(centres)
        first = np.full(count, -1)
        moving = np.flatnonzero(self.body >= 0)
        first[self.body[moving[::-1]]] = moving[::-1]
        twist = self.velocity[first].copy()
        twist[:, :3] += np.cross(twist[:, 3:], centres - placement.position[first])
        twist[:, 3:] *= self.size
        return np.asarray(twist[:, self.columns].ravel())

    def _shifted(self, placement: Placement, step: np.ndarray, centres: np.ndarray) -> Placement:
        """A placement after a small step (D,) of the bodies about their centres."""
        step = step.reshape(-1, len(self.columns))
        twist = np.zeros((len(step), 6))
        twist[:, self.columns] = step
        twist[:, 3:] /= self.size
        moving = self.body >= 0
        velocity = np.zeros((len(self.body), 6))
        velocity[moving] = twist[self.body[moving]]
        velocity[moving, :3] += np.cross(velocity[moving, 3:], placement.position[moving] - centres[self.body[moving]])
        return placement.along(velocity, 1.0)

    def _equations(self, placement: Placement, kept: KeptConstraints) -> tuple[np.ndarray, csr_matrix, np.ndarray]:
        """Residuals (R,), their rows over the twists of the bodies, rotations over the size, and the centres of the bodies (M, 3)."""
        count = int(self.body.max(initial=-1)) + 1
        moving = self.body >= 0
        owner = self.body[moving]
        members = np.maximum(np.bincount(owner, minlength=count), 1)[:, None]
        centres = np.stack([np.bincount(owner, part, minlength=count) for part in placement.position[moving].T], axis=1) / members
        place = placement.position[kept.bodies] + np.einsum("neij,nej->nei", placement.rotation[kept.bodies], kept.local)
        apart = place[:, 1] - place[:, 0]
        carrier = kept.bodies[np.arange(len(kept.carrier)), kept.carrier]
        rows = np.einsum("nrj,nij->nri", kept.rows, placement.rotation[carrier])
        asked = np.flatnonzero(kept.rows.any(axis=2).ravel())
        residual = np.einsum("nri,ni->nr", rows, apart).ravel()[asked]
        ends = np.repeat(kept.bodies, 3, axis=0)[asked]
        matrix = self._rows(rows.reshape(-1, 3)[asked], np.repeat(place, 3, axis=0)[asked], ends, centres)
        if not len(kept.lengths):
            return residual, matrix, centres
        tips = placement.position[kept.ties] + np.einsum("teij,tej->tei", placement.rotation[kept.ties], kept.tie_arms)
        line = tips[:, 1] - tips[:, 0]
        now = np.linalg.norm(line, axis=1)
        more = self._rows(line / now[:, None], tips, kept.ties, centres)
        return np.concatenate([residual, now - kept.lengths]), vstack([matrix, more], format="csr"), centres

    def _rows(self, direction: np.ndarray, place: np.ndarray, ends: np.ndarray, centres: np.ndarray) -> csr_matrix:
        """Rates of relative displacements along directions (R, 3) at places (R, 2, 3) of blocks (R, 2)."""
        body = self.body[ends]
        row, side = np.nonzero(body >= 0)
        owner = body[row, side]
        arm = place[row, side] - centres[owner]
        rates = np.concatenate([direction[row], np.cross(arm, direction[row]) / self.size], axis=1)[:, self.columns]
        rates *= np.array([-1.0, 1.0])[side][:, None]
        count = len(self.columns)
        column = owner[:, None] * count + np.arange(count)
        shape = (len(direction), len(centres) * count)
        return csr_matrix((rates.ravel(), (np.repeat(row, count), column.ravel())), shape)


def _least_norm(matrix: csr_matrix, wanted: np.ndarray) -> np.ndarray:
    """The solution (columns,) of least squares and least norm."""
    if matrix.shape[1] > MANY:
        return _least_norm_sparse(matrix, wanted)
    return np.asarray(lstsq(matrix.toarray(), wanted, cond=1e-10, lapack_driver="gelsy")[0])


def _least_norm_sparse(matrix: csr_matrix, wanted: np.ndarray) -> np.ndarray:
    """The solution (columns,) of large systems, whose rows have few entries: x <- x + (A^T A + d 1)^-1 A^T (b - A x) from x = 0.

    Each round leaves d / (s^2 + d) of what belongs to a singular value s, and nothing moves that belongs to none.
    """
    square = (matrix.T @ matrix).tocsc()
    small = SMALL * float(square.diagonal().max(initial=0.0))
    if small == 0.0:
        return np.zeros(matrix.shape[1])
    factor = splu(square + small * identity(matrix.shape[1], format="csc"), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    out = np.zeros(matrix.shape[1])
    for _ in range(REFINED):
        step = factor.solve(matrix.T @ (wanted - matrix @ out))
        out += step
        if float(np.abs(step).max()) <= EXACT * float(np.abs(out).max()):
            break
    return out


def motion(problem: LimitProblem, placed: Assembly, best: Optimum, velocity: np.ndarray, bars: Bars) -> FollowedMotion:
    """The motion of a mechanism.

    Args:
        problem: of the blocks where they are.
        placed: the blocks there.
        best: the forces.
        velocity: (B, 6) of the blocks, over the largest of any corner.
        bars: the ties of the problem, where they are now.
    """
    points = problem.points
    apart = _at(placed, velocity, points.bodies, points.point)
    opens = np.einsum("pi,pi->p", points.frame[:, 0], apart)
    along = np.einsum("pdi,pi->pd", points.frame[:, 1:], apart)
    slip = np.linalg.norm(along, axis=1)
    sliding = slip > STILL
    bears = np.abs(best.force[:, 0]) > BEARS
    lifted = (opens > STILL) & ~bears  # what bears and opens dilates
    body = _bodies(placed, points.bodies, points.joint, np.maximum(slip, np.abs(opens)), velocity)
    frames = np.zeros((points.count, 3, 3))
    frames[:, : problem.directions] = points.frame
    frames[sliding | lifted, 1:] = 0.0
    giving = frames.copy()
    goes_on = sliding & bears
    giving[goes_on, 1] = np.einsum("pd,pdi->pi", along, points.frame[:, 1:])[goes_on] / slip[goes_on, None]
    faces = _carriers(placed, points.bodies, points.frame[:, 0])
    line = bars.points[:, 1] - bars.points[:, 0]
    longer = np.sum(line * _at(placed, velocity, bars.blocks, bars.points), axis=1) / np.linalg.norm(line, axis=1)
    taut = (best.bars > BEARS) & (np.abs(longer) <= STILL)

    def kept(rows: np.ndarray, keep: np.ndarray, carrier: np.ndarray) -> KeptConstraints:
        ends = points.bodies[keep]
        local = points.point[keep][:, None] - placed.centre[ends]
        arms = bars.points - placed.centre[bars.blocks]
        return KeptConstraints(ends, local, rows[keep], carrier[keep], bars.blocks[taut], arms[taut], np.linalg.norm(line[taut], axis=1))

    touching = body[points.bodies[:, 0]] != body[points.bodies[:, 1]]
    between = touching & ~lifted
    rigid = _as_bodies(velocity, placed, body)
    carrier = np.where(sliding, faces, 0)
    resistance = Resistance.of_points(giving[touching], best.force[touching], problem.mu[touching], goes_on[touching])
    return FollowedMotion(
        start=Placement.as_built(placed), velocity=rigid, body=body, kept=kept(frames, between, carrier),
        bearing=kept(frames, between & bears, carrier), yielding=kept(giving, touching, faces), resistance=resistance, size=problem.length,
        columns=problem.columns,
    )  # fmt: skip


def _at(placed: Assembly, velocity: np.ndarray, ends: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Velocity of b less that of a, blocks (N, 2), at places (N, 3) or of each block (N, 2, 3): (N, 3)."""
    arm = (place if place.ndim == 3 else place[:, None]) - placed.centre[ends]
    both = velocity[ends, :3] + np.cross(velocity[ends, 3:], arm)
    return np.asarray(both[:, 1] - both[:, 0])


def _bodies(placed: Assembly, ends: np.ndarray, joint: np.ndarray, rate: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """The body of each block (B,): those that touch and move alike are one, -1 those that do not move."""
    turning = np.linalg.norm(velocity[ends[:, 1], 3:] - velocity[ends[:, 0], 3:], axis=1) * placed.reach[ends].max(axis=1)
    worst = np.zeros(int(joint.max(initial=-1)) + 1)
    np.maximum.at(worst, joint, np.maximum(rate, turning))
    alike = worst[joint] <= STILL
    pairs = ends[alike]
    count = placed.count
    fixed = np.flatnonzero(placed.fixed)
    first = np.concatenate([pairs[:, 0], fixed[:-1]])
    second = np.concatenate([pairs[:, 1], fixed[1:]])
    _, label = connected_components(coo_matrix((np.ones(len(first)), (first, second)), (count, count)), directed=False)
    still = np.unique(label[fixed])
    _, body = np.unique(np.where(np.isin(label, still), -1, label), return_inverse=True)
    return np.asarray(body - 1)


def _as_bodies(velocity: np.ndarray, placed: Assembly, body: np.ndarray) -> np.ndarray:
    """Velocities (B, 6) as bodies move: each as the mean of its blocks."""
    out, moving = np.zeros_like(velocity), body >= 0
    owner, count = body[moving], int(body.max(initial=-1)) + 1
    members = np.maximum(np.bincount(owner, minlength=count), 1)[:, None]
    mean = np.stack([np.bincount(owner, part, minlength=count) for part in velocity[moving].T], axis=1) / members
    centre = np.stack([np.bincount(owner, part, minlength=count) for part in placed.centre[moving].T], axis=1) / members
    out[moving] = mean[owner]
    out[moving, :3] += np.cross(mean[owner, 3:], placed.centre[moving] - centre[owner])
    return out


def _carriers(placed: Assembly, ends: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Which of both blocks (N, 2) has a face with the normal of a point, (N,): 0 or 1."""
    solids, part_block = placed.shapes.solids, placed.shapes.part_block
    owner = part_block[solids.owner_of_face()]
    out = np.zeros(len(ends), dtype=np.int64)
    for k, (pair, n) in enumerate(zip(ends, normal, strict=True)):
        own = solids.normals[owner == pair[0]]
        out[k] = int((own @ n).max() < 1.0 - PARALLEL)
    return out
