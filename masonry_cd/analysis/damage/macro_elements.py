# SPDX-License-Identifier: GPL-3.0-or-later
r"""Macro-elements, the parts of a structure: the groups of its blocks (piers, arches, facade ...).

A part is a group with at least one free block; a group of supports alone is none. A joint between two parts belongs to both, and a
joint between a part and a support to the part: sums over the parts therefore exceed the number of the structure, which has a
row of its own and counts each joint once. Where a scene has several structures, each has such a row, which follows those of the parts.

**Levels and drift.** The height of the free blocks at rest is cut into equal levels. The displacement u_k of a part at a level is the
horizontal mean over its standing blocks whose centre lies there at rest, weighted by volume, relative to the base [m], and z_k the mean
height of these blocks [m]; a part that stands on supports has their displacement at its foot, level 0. Spheres, which are fill, are left
out of it. Then

    drift of a level    | u_k - u_j | / (z_k - z_j),     j the next level below
    drift of the part   max_k | u_k - u_0 | / height,    of parts with two levels at least, height from the foot to the top of the part

The first shows where a structure is sheared, and grows without bound as levels become thinner than the slip of a joint is long; the second
does not, and grades the part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_cd.analysis.damage.definitions import Thresholds, fallen_in, is_open, is_slid, parted
from masonry_cd.analysis.deformed import Pose, Solids, corner_gaps, frame_index, joint_frame, solids_of
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import mass_properties
from masonry_cd.mechanics.model.joints import TOUCHING_SHARE, Joints

WHOLE = "structure"  # name of the row of the structure as a whole
LEVELS = 10
HINGED = 0.25  # a hinge touches where its smallest gap is below this share of its largest
MERGED = 0.5  # levels whose blocks lie closer than this share of a level's height are not compared


@dataclass(frozen=True, eq=False)
class MacroElements:
    """P rows: parts, then structures where there are several; and, as row P, all that stands."""

    names: tuple[str, ...]  # P + 1, the last is WHOLE
    blocks: np.ndarray  # (P + 1, B) bool: free blocks of each
    joints: np.ndarray  # (P + 1, J) bool: joints of each
    volume: np.ndarray  # (B,) [m3]
    parts: int  # rows that are parts

    @property
    def count(self) -> int:
        """Number of rows, P + 1."""
        return len(self.names)

    def parts_of(self, row: int) -> list[int]:
        """The parts that a row holds: itself, or those of a structure."""
        return [row] if row < self.parts else [p for p in range(self.parts) if (self.blocks[p] <= self.blocks[row]).all()]


def part_names(blocks: Sequence[Block]) -> tuple[str, ...]:
    """Names of the parts, of the structures where there are several, and WHOLE, (P + 1)."""
    return (*_groups(blocks), *_structures(blocks), WHOLE)


def _groups(blocks: Sequence[Block]) -> list[str]:
    """The groups that have a free block."""
    return list(dict.fromkeys(block.group for block in blocks if not block.fixed))


def _structures(blocks: Sequence[Block]) -> list[str]:
    """The structures of a scene that has several."""
    return [name for name in dict.fromkeys(block.structure for block in blocks if not block.fixed) if name]


def can_be_graded(blocks: Sequence[Block]) -> bool:
    """Return True if no group is called as the whole is."""
    return WHOLE not in _groups(blocks)


def require_names(blocks: Sequence[Block]) -> None:
    """Refuse a group that is called as the whole is.

    Raises:
        InputError: names it.
    """
    if not can_be_graded(blocks):
        raise InputError(f'group "{WHOLE}"', "this name stands for the whole in the damage tables; give the group another")


def macro_elements_of(blocks: Sequence[Block], joints: Joints) -> MacroElements:
    """The parts of a structure."""
    groups, several = _groups(blocks), _structures(blocks)
    of_block = np.array([groups.index(block.group) if block.group in groups else -1 for block in blocks], dtype=np.int64)
    free = np.array([not block.fixed for block in blocks])
    member = (of_block == np.arange(len(groups))[:, None]) & free
    standing = [np.array([block.structure == name for block in blocks]) & free for name in several]
    rows = np.concatenate([member, np.array(standing, dtype=bool).reshape(-1, len(blocks))])
    owns = rows[:, joints.block_a] | rows[:, joints.block_b]
    return MacroElements(
        names=part_names(blocks),
        blocks=np.concatenate([rows, free[None]]),
        joints=np.concatenate([owns, np.ones((1, joints.count), dtype=bool)]),
        volume=np.array([mass_properties(block.vertices, block.faces).volume for block in blocks]),
        parts=len(groups),
    )


@dataclass(frozen=True, eq=False)
class DamageSnapshot:
    """Damage at one frame: J joints, B blocks."""

    pose: Pose
    opening: np.ndarray  # (J,) largest corner gap [m]
    gap: np.ndarray  # (J,) smallest corner gap [m]
    sliding: np.ndarray  # (J,) [m]
    rotation: np.ndarray  # (J,) [rad]
    separated: np.ndarray  # (J,)
    down: np.ndarray  # (B,) fallen blocks
    live: np.ndarray  # (J,) neither of its blocks has fallen
    open: np.ndarray  # (J,) live, not separated, opening beyond the threshold
    slid: np.ndarray  # (J,) likewise by sliding
    hinged: np.ndarray  # (J,) open at one side and in contact at the other
    touching: np.ndarray  # (N,) corners where a hinged joint touches

    @classmethod
    def at(cls, results: Results, frame: int, thresholds: Thresholds) -> DamageSnapshot:
        """The damage at a frame."""
        joints, solids = results.joints, solids_of(results.blocks)
        pose = Pose.of(results, solids, frame_index(results, frame))
        opening, sliding, rotation, area = (joint_frame(results, n, frame) for n in ("opening", "sliding", "rotation", "contact_area"))
        gaps = corner_gaps(joints, solids, pose)
        least = np.minimum.reduceat(gaps, joints.polygon_start[:-1]) if joints.count else np.zeros(0)
        separated = parted(joints, least, sliding, area, thresholds)
        down = fallen_in(joints, solids, pose, separated, thresholds)
        live = ~(down[joints.block_a] | down[joints.block_b])
        opened = live & ~separated & is_open(opening, thresholds)
        hinged = opened & (least <= HINGED * opening)
        side = np.repeat(np.arange(joints.count), np.diff(joints.polygon_start))
        touching = hinged[side] & (gaps <= (least + TOUCHING_SHARE * (opening - least))[side])
        slid = live & ~separated & is_slid(sliding, thresholds)
        return cls(pose, opening, least, sliding, rotation, separated, down, live, opened, slid, hinged, touching)


def hinge_places(joints: Joints, snapshot: DamageSnapshot) -> np.ndarray:
    """(J, 3) where each hinged joint touches: the mean of its touching corners at rest [m]; NaN where it is not a hinge."""
    side = np.repeat(np.arange(joints.count), np.diff(joints.polygon_start))
    out = np.zeros((joints.count, 3))
    np.add.at(out, side[snapshot.touching], joints.polygon[snapshot.touching])
    count = np.bincount(side[snapshot.touching], minlength=joints.count)
    return np.where(snapshot.hinged[:, None], out / np.maximum(count, 1)[:, None], np.nan)


def side_names(towards: np.ndarray) -> list[str]:
    """Names of directions (n, 3) by their largest component: ``+x``, ``-z`` ...; empty where there is none."""
    names = []
    for vector in towards:
        k = int(np.argmax(np.abs(np.nan_to_num(vector))))
        names.append(f"{'-' if vector[k] < 0 else '+'}{'xyz'[k]}" if np.abs(vector[k]) > 0 else "")
    return names


@dataclass(frozen=True, eq=False)
class Levels:
    """L levels over the height of the free blocks."""

    bounds: np.ndarray  # (L + 1,) [m]
    of_block: np.ndarray  # (B,) level of each block's centre at rest
    foot: np.ndarray  # (P + 1,) height where a part stands on supports [m], NaN where it stands on none
    footing: np.ndarray  # (P + 1, B) the supports that it stands on
    ends: np.ndarray  # (P + 1, 2) lowest and highest corner of a part [m]

    @property
    def least(self) -> float:
        """Height by which levels that are compared are apart [m]."""
        return MERGED * float(np.diff(self.bounds)[0])

    @classmethod
    def of(cls, solids: Solids, joints: Joints, parts: MacroElements, count: int = LEVELS) -> Levels:
        """Cut the height of a structure into levels."""
        free = ~solids.fixed
        z = solids.vertices[free[solids.vertex_block], 2]
        bounds = np.linspace(z.min(), z.max(), count + 1)
        of_block = np.clip(np.searchsorted(bounds, solids.centre[:, 2], side="right") - 1, 0, count - 1)
        foot, footing = np.full(parts.count, np.nan), np.zeros((parts.count, len(free)), dtype=bool)
        held = solids.fixed[joints.block_a] | solids.fixed[joints.block_b]
        height = joints.centres()[:, 2]
        ends_z = np.empty((parts.count, 2))
        for p in range(parts.count):
            corners = solids.vertices[parts.blocks[p][solids.vertex_block], 2]
            ends_z[p] = corners.min(), corners.max()
            mine = np.flatnonzero(parts.joints[p] & held)
            ends = np.concatenate([joints.block_a[mine], joints.block_b[mine]])
            footing[p, ends[solids.fixed[ends]]] = True
            foot[p] = height[mine].min() if len(mine) else np.nan
        return cls(bounds, of_block, foot, footing, ends_z)

    def profile(self, part: int, parts: MacroElements, solids: Solids, snapshot: DamageSnapshot) -> HeightProfile:
        """Heights and displacements of a part, level by level, from its standing blocks; spheres settle and roll without harm."""
        count = len(self.bounds) - 1
        standing = parts.blocks[part] & ~snapshot.down & (True if solids.round is None else ~solids.round)
        level, weight = self.of_block[standing], parts.volume[standing]
        moved = snapshot.pose.displacement(solids)
        filled = np.bincount(level, weight, minlength=count)
        kept = np.flatnonzero(filled)
        sums = [np.bincount(level, weight * v, minlength=count)[kept] for v in (solids.centre[standing, 2], *moved[standing, :2].T)]
        height, *plan = (values / filled[kept] for values in sums)
        shift = np.stack(plan, axis=1)
        if np.isfinite(self.foot[part]):
            height = np.concatenate([[self.foot[part]], height])
            shift = np.concatenate([moved[self.footing[part], :2].mean(axis=0)[None], shift])
            kept = np.concatenate([[-1], kept])
        least = self.least
        low, high = self.ends[part]
        overall = float(np.linalg.norm(shift - shift[:1], axis=1).max(initial=0.0)) / (high - low) if (kept >= 0).sum() > 1 else 0.0
        return HeightProfile(kept, height, shift, _drifts(height, shift, least), overall)


@dataclass(frozen=True, eq=False)
class HeightProfile:
    """A part over its height: n levels that hold blocks, the support first where it stands on one."""

    level: np.ndarray  # (n,) -1 for the support
    height: np.ndarray  # (n,) of the centres [m]
    shift: np.ndarray  # (n, 2) horizontal displacement relative to the base [m]
    drift: np.ndarray  # (n,) towards the level below; NaN for the lowest
    overall: float  # drift of the part


def _drifts(height: np.ndarray, shift: np.ndarray, least: float) -> np.ndarray:
    """Drift of each level towards the next one below that is at least so far away [m]; a thin lowest course counts from its foot."""
    out = np.full(len(height), np.nan)
    for k in range(1, len(height)):
        below = np.flatnonzero(height[:k] <= height[k] - least)
        if len(below):
            j = below[-1]
            out[k] = np.linalg.norm(shift[k] - shift[j]) / (height[k] - height[j])
    return out
