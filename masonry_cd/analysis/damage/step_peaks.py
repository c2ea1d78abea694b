# SPDX-License-Identifier: GPL-3.0-or-later
"""The largest drifts, displacements and hinges of a run, from all of its steps: what frames alone would miss between them.

A run takes in each of its steps, by the definitions of :mod:`masonry_cd.analysis.damage.definitions`, with their default thresholds of
fall, and of :mod:`masonry_cd.analysis.damage.macro_elements`. A hinge is kept whatever its opening, so that reports may count those from
another opening on.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.macro_elements import HINGED, LEVELS, Levels, MacroElements, macro_elements_of, part_names
from masonry_cd.analysis.deformed import Base, Solids, solids_of
from masonry_cd.io.layout import STEP_PEAKS
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.damage_peaks import FallTables, PartTables, Peaks, StepMeasures, take_step
from masonry_cd.mechanics.model.joints import JointMeasures, Joints, touching_places
from masonry_cd.mechanics.model.state import State

UNKNOWN = ("hinge_time", "hinge_place")  # NaN where there was no hinge


def shapes(blocks: Sequence[Block], joints: int) -> dict[str, tuple[int, ...]]:
    """The shapes of the peaks of some blocks and a given number of joints, by the names of STEP_PEAKS."""
    parts = len(part_names(blocks))
    sizes = ((len(blocks),), (parts,), (parts, LEVELS + 1), (parts, LEVELS + 1), (joints,), (joints,), (joints, 3))
    return dict(zip(STEP_PEAKS, sizes, strict=True))


def falls_as_in_runs(thresholds: Thresholds) -> bool:
    """Return True if blocks fall by the thresholds that runs take their peaks with."""
    default = Thresholds()
    return all(getattr(thresholds, name) == getattr(default, name) for name in ("apart", "lost", "drop", "tilt"))


class StepPeaks:
    """The peaks of a run so far: B blocks, J joints, P parts (those of the damage tables, the whole last), LEVELS levels.

    Attributes:
        arrays: by the names of STEP_PEAKS; they grow in place.
            displacement: (B,) largest displacement of each centre of mass relative to the support [m].
            drift: (P,) of each part.
            level_displacement: (P, LEVELS + 1) of each level in plan, the foot first [m].
            level_drift: (P, LEVELS + 1).
            hinge_opening: (J,) largest opening while the joint was a hinge [m].
            hinge_time: (J,) when that was [s]; NaN without a hinge.
            hinge_place: (J, 3) where it touched then, at rest [m]; NaN likewise.
    """

    def __init__(self, assembly: Assembly, joints: Joints, support: int) -> None:
        self._assembly, self._joints = assembly, joints
        solids, parts = solids_of(assembly.blocks), macro_elements_of(assembly.blocks, joints)
        self._parts = _part_tables(solids, parts, Levels.of(solids, joints, parts), support)
        self._falls = _fall_tables(solids, joints, Thresholds())
        self._wider = np.zeros(joints.count, dtype=bool)
        sizes = shapes(assembly.blocks, joints.count).items()
        self.arrays = {name: np.full(shape, np.nan if name in UNKNOWN else 0.0) for name, shape in sizes}

    def update(self, now: JointMeasures, state: State) -> None:
        """Take in a step."""
        position, orientation = state.position, state.orientation
        if self._parts.support >= 0 and orientation[self._parts.support, 1:].any():
            base = Base.of(self._parts.support, self._assembly.centre, position, orientation)
            position, orientation = base.seen(position), base.orientations(orientation)
        seen = StepMeasures(position, orientation, now.opening, now.gap, now.sliding, now.contact_area)
        grown = Peaks(*(self.arrays[name] for name in Peaks._fields))
        if take_step(self._parts, self._falls, seen, grown, self._wider):
            new = np.flatnonzero(self._wider)
            self.arrays["hinge_time"][new] = state.time
            self.arrays["hinge_place"][new] = touching_places(self._joints, self._assembly, state, new)

    def restore(self, arrays: dict[str, np.ndarray]) -> None:
        """Go on from peaks that were kept."""
        for name in STEP_PEAKS:
            self.arrays[name][...] = arrays[name]


def _part_tables(solids: Solids, parts: MacroElements, levels: Levels, support: int) -> PartTables:
    """Return constant data on the parts, for the kernel."""
    owned = [np.flatnonzero(own) for own in parts.blocks.T]
    feet = [np.flatnonzero(own) for own in levels.footing]
    return PartTables(
        start=_starts(owned),
        part=np.concatenate(owned),
        level=levels.of_block.astype(np.int64),
        volume=parts.volume,
        centre=solids.centre,
        foot=levels.foot,
        footing_start=_starts(feet),
        footing=np.concatenate(feet),
        height=np.diff(levels.ends, axis=1)[:, 0],
        least=levels.least,
        support=support,
    )


def _fall_tables(solids: Solids, joints: Joints, thresholds: Thresholds) -> FallTables:
    """When blocks have fallen, for the kernel."""
    return FallTables(
        block_a=joints.block_a.astype(np.int64),
        block_b=joints.block_b.astype(np.int64),
        least_area=thresholds.lost * joints.area,
        apart=thresholds.apart * np.sqrt(joints.area),
        fixed=solids.fixed,
        drop=thresholds.drop * solids.sizes[:, 2],
        cosine=math.cos(math.radians(thresholds.tilt)),
        hinged=HINGED,
    )


def _starts(lists: list[np.ndarray]) -> np.ndarray:
    """Where each of some lists begins when they follow each other, and where the last ends."""
    return np.cumsum([0, *(len(each) for each in lists)])
