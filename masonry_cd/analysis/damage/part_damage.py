# SPDX-License-Identifier: GPL-3.0-or-later
"""The damage of a run by part: at the end, and frame by frame.

What a part is and which joints it owns says :mod:`masonry_cd.analysis.damage.macro_elements`, the mechanisms
:mod:`masonry_cd.analysis.damage.mechanism`, the grades :mod:`masonry_cd.analysis.damage.grades`. Two kinds of numbers stand side by side
and must not be mixed up:

- ``opened``, ``slid``, ``separated`` count each joint once by the word of joints.csv, which is what it suffered at any time;
- ``open``, ``slipped``, ``apart``, ``hinges`` and the crack widths say what is the case at the frame: at the end, what has remained. They
  leave out joints one of whose blocks has fallen; such blocks are counted as lost.

Largest drifts and displacements, and the hinges that a run has had, are over all steps; over the frames in files of older versions, and
where the run was killed before it wrote them, or blocks count as fallen by other thresholds than those of runs.

A crack's width is the opening of a joint that is open at the end and not separated.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.end_state import end_state
from masonry_cd.analysis.damage.grades import Grades, grade_of
from masonry_cd.analysis.damage.joint_damage import JointDamage, joint_damage
from masonry_cd.analysis.damage.macro_elements import (
    DamageSnapshot,
    HeightProfile,
    Levels,
    MacroElements,
    hinge_places,
    macro_elements_of,
    require_names,
    side_names,
)
from masonry_cd.analysis.damage.mechanism import PartMechanism, Rules, mechanisms, pieces_of
from masonry_cd.analysis.damage.step_peaks import falls_as_in_runs
from masonry_cd.analysis.damage.verdict import checks_on
from masonry_cd.analysis.deformed import Solids, solids_of
from masonry_cd.foundation.quantities import classes
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.joints import Joints

Row = dict[str, Any]

LARGEST = 0.05  # where the last class of crack widths begins [m], as on the crack map
ROUNDING = 1e-9  # share by which the same opening may differ between the run and the report
FRAMES = 300  # of the history at most; longer runs are thinned out evenly, their first and last frame kept


@dataclass(frozen=True)
class DamageSettings:
    """Thresholds from which on damage counts, and those of the grades."""

    thresholds: Thresholds = field(default_factory=Thresholds)
    rules: Rules = field(default_factory=Rules)
    grades: Grades = field(default_factory=Grades)


@dataclass(frozen=True, eq=False)
class PartDamage:
    """The tables of a run's damage; lists of rows with equal keys, ready for CSV and JSON."""

    title: str
    time: float  # of the last frame [s]
    provisional: str  # why residual values and grades are not the last, as text; empty where the run ended at rest
    settings: DamageSettings
    width_classes: tuple[float, ...]  # lower bounds [m]
    parts: list[Row]  # one per part, then the structure
    shocks: list[Row]  # the same after each shock of a sequence and its rest; empty for any other run
    history: list[Row]  # one per frame and part
    hinges: list[Row]  # one per joint that was a hinge
    levels: list[Row]  # one per part and level
    of_steps: bool = False  # largest drifts and the hinges are over all steps, not only over the frames


def part_damage(results: Results, settings: DamageSettings | None = None, frames: np.ndarray | None = None) -> PartDamage:
    """The damage of a run by part.

    Args:
        results: of the run.
        settings: what counts as damage.
        frames: of the history, ascending, the last one among them; FRAMES of them evenly when not given.

    Raises:
        InputError: a group of blocks named as the structure as a whole is.
    """
    settings = settings or DamageSettings()
    view = _View.of(results, settings)
    watch = _Watch(view)
    chosen = np.linspace(0, results.frames - 1, min(results.frames, FRAMES)).round().astype(int) if frames is None else frames
    of_steps = results.has_peaks_of_steps and falls_as_in_runs(settings.thresholds) and watch.fits(results.step_peaks)
    after = {shock.frame: i for i, shock in enumerate(results.shocks)}
    history: list[Row] = []
    shocks: list[Row] = []

    ungraded = checks_on(results, settings.thresholds, end_state(results, settings.thresholds)).instead_of_a_grade()

    def parts(table: JointDamage, snapshot: DamageSnapshot, frame: int) -> list[Row]:
        last, end = history[-view.parts.count :], {"provisional": end_state(results, settings.thresholds, frame).provisional} | ungraded
        return [_part_row(view, watch, table, snapshot, p, last[p]) | end for p in range(view.parts.count)]

    for frame in np.unique([*chosen, *after]):
        snapshot = DamageSnapshot.at(results, int(frame), settings.thresholds)
        history += watch.add(snapshot)
        if frame in after:
            i = after[frame]
            if of_steps:
                watch.take_shock(results.step_peaks_after(i))
            named = {"shock": results.shocks[i].name}
            shocks += [named | row for row in parts(joint_damage(results, settings.thresholds, i), snapshot, int(frame))]
    if of_steps:
        watch.take_steps(results.step_peaks)
    table = joint_damage(results, settings.thresholds)
    rows = parts(table, snapshot, -1)
    return PartDamage(
        title=results.title,
        time=float(results.time[-1]),
        provisional=rows[-1]["provisional"],
        settings=settings,
        width_classes=view.widths,
        parts=rows,
        shocks=shocks,
        history=history,
        hinges=_hinge_rows(view, watch, table, snapshot),
        levels=watch.level_rows(),
        of_steps=of_steps,
    )


@dataclass(frozen=True, eq=False)
class _View:
    """Quantities that do not change over the frames."""

    solids: Solids
    joints: Joints
    parts: MacroElements
    levels: Levels
    names: tuple[str, ...]
    pieces: tuple[Any, ...]
    settings: DamageSettings
    widths: tuple[float, ...]

    @classmethod
    def of(cls, results: Results, settings: DamageSettings) -> _View:
        solids, joints = solids_of(results.blocks), results.joints
        require_names(results.blocks)
        parts = macro_elements_of(results.blocks, joints)
        return cls(
            solids=solids,
            joints=joints,
            parts=parts,
            levels=Levels.of(solids, joints, parts),
            names=tuple(block.name for block in results.blocks),
            pieces=pieces_of(solids, joints, parts, settings.rules),
            settings=settings,
            widths=tuple(classes(settings.thresholds.opened, max(LARGEST, settings.thresholds.opened))),
        )


class _Watch:
    """Goes through the frames and keeps what only the history shows: peaks of drift, and hinges that have closed again.

    Those over all steps replace them where the run noted them: no frame goes beyond these, rounding apart, unless a kill came after them.
    """

    def __init__(self, view: _View) -> None:
        self._view = view
        count = view.joints.count
        self.drift_max = np.zeros(view.parts.count)
        self.widest = np.zeros(count)  # opening of each joint while it was a hinge [m]
        self.place = np.full((count, 3), np.nan)
        self.when = np.full(count, np.nan)
        self.profiles: list[HeightProfile] = []
        levels = (view.parts.count, len(view.levels.bounds))  # the foot first
        self._level_displacement, self._level_drift = np.zeros(levels), np.zeros(levels)

    def add(self, snapshot: DamageSnapshot) -> list[Row]:
        """Take in a frame; return its row of each part."""
        view = self._view
        self.profiles = [view.levels.profile(p, view.parts, view.solids, snapshot) for p in range(view.parts.count)]
        self.drift_max = np.maximum(self.drift_max, [profile.overall for profile in self.profiles])
        for p, profile in enumerate(self.profiles):
            own = profile.level + 1
            moved = np.hypot(*profile.shift.T)
            self._level_displacement[p, own] = np.maximum(self._level_displacement[p, own], moved)
            self._level_drift[p, own] = np.maximum(self._level_drift[p, own], np.nan_to_num(profile.drift))
        wider = snapshot.hinged & (snapshot.opening > self.widest)
        self.widest[wider], self.when[wider] = snapshot.opening[wider], snapshot.pose.time
        self.place[wider] = hinge_places(view.joints, snapshot)[wider]
        how = mechanisms(snapshot, view.joints, view.parts, view.pieces, view.settings.rules)
        return [_frame_row(view, snapshot, p, self.profiles[p], how[p]) for p in range(view.parts.count)]

    def fits(self, peaks: Mapping[str, np.ndarray]) -> bool:
        """Return True if peaks over all steps are those of these parts and levels."""
        return peaks["level_drift"].shape == self._level_drift.shape

    def take_shock(self, peaks: Mapping[str, np.ndarray]) -> None:
        """Take in the peaks over the steps up to the end of the rest after a shock; of the hinges, that they were there."""
        self.drift_max = np.maximum(self.drift_max, peaks["drift"])
        new = (peaks["hinge_opening"] >= self._view.settings.thresholds.opened) & np.isnan(self.when)
        self.when[new] = np.inf  # the end of the run says when and where

    def take_steps(self, peaks: Mapping[str, np.ndarray]) -> None:
        """Take in the peaks over all steps."""
        self.drift_max = np.maximum(self.drift_max, peaks["drift"])
        self._level_displacement = np.maximum(self._level_displacement, peaks["level_displacement"])
        self._level_drift = np.maximum(self._level_drift, peaks["level_drift"])
        width = peaks["hinge_opening"]
        known = (width >= self._view.settings.thresholds.opened) & (width >= (1.0 - ROUNDING) * self.widest)
        self.widest[known], self.when[known], self.place[known] = width[known], peaks["hinge_time"][known], peaks["hinge_place"][known]

    def level_rows(self) -> list[Row]:
        """Displacement and drift of each part and level: at the last frame, and the largest."""
        rows = []
        bounds = self._view.levels.bounds
        for p, (name, profile) in enumerate(zip(self._view.parts.names, self.profiles, strict=True)):
            for k, level in enumerate(profile.level):
                rows.append(
                    {
                        "part": name,
                        "level": int(level) + 1,  # 0 is the support
                        "from_z": float(bounds[level]) if level >= 0 else profile.height[k],
                        "to_z": float(bounds[level + 1]) if level >= 0 else profile.height[k],
                        "mean_z": profile.height[k],
                        "residual_x": profile.shift[k, 0],
                        "residual_y": profile.shift[k, 1],
                        "largest_displacement": float(self._level_displacement[p, level + 1]),
                        "residual_drift": profile.drift[k],
                        "largest_drift": float(self._level_drift[p, level + 1]) if np.isfinite(profile.drift[k]) else np.nan,
                    }
                )
        return rows


def _frame_row(view: _View, snapshot: DamageSnapshot, part: int, profile: HeightProfile, how: PartMechanism) -> Row:
    """Return the row of a part at a frame."""
    own, area = view.parts.joints[part], view.joints.area
    live = own & snapshot.live
    apart, standing = live & snapshot.separated, live & ~snapshot.separated
    lost = view.parts.blocks[part] & snapshot.down
    return {
        "time": snapshot.pose.time,
        "part": view.parts.names[part],
        "open": int((own & snapshot.open).sum()),
        "open_area": float(area[own & snapshot.open].sum()),
        "slipped": int((own & snapshot.slid).sum()),
        "slipped_area": float(area[own & snapshot.slid].sum()),
        "apart": int(apart.sum()),
        "apart_area": float(area[apart].sum()),
        "hinges": int((own & snapshot.hinged).sum()),
        "opening": float(snapshot.opening[standing].max(initial=0.0)),
        "sliding": float(snapshot.sliding[standing].max(initial=0.0)),
        "drift": profile.overall,
        "lost_blocks": int(lost.sum()),
        "lost_share": float(view.parts.volume[lost].sum() / view.parts.volume[view.parts.blocks[part]].sum()),
        "mechanism": how.name,
        "other_mechanisms": ", ".join(how.others),
        "turn": how.turn,
        "turn_towards": how.towards,
    }


def _part_row(view: _View, watch: _Watch, table: JointDamage, snapshot: DamageSnapshot, part: int, last: Row) -> Row:
    """A part at the end of the run."""
    own = view.parts.joints[part]
    row: Row = {
        "part": last["part"],
        "blocks": int(view.parts.blocks[part].sum()),
        "joints": int(own.sum()),
        "joint_area": float(view.joints.area[own].sum()),
    }
    for state in ("opened", "slid", "separated"):
        having = own & (table.state == state)
        row |= {state: int(having.sum()), f"{state}_area": float(view.joints.area[having].sum())}
    row |= {f"only_{state}": int((own & (table.state == state) & ~table.both).sum()) for state in ("opened", "slid")}
    row["opened_and_slid"] = int((own & table.both).sum())
    first = table.first_opening_time[own]
    row |= {
        "max_opening": float(table.max_opening[own].max(initial=0.0)),
        "max_sliding": float(table.max_sliding[own].max(initial=0.0)),
        "first_opening_time": float(np.nanmin(first)) if np.isfinite(first).any() else np.nan,
        "hinges_ever": int((own & np.isfinite(watch.when)).sum()),
    }
    renamed = {"opening": "residual_opening", "sliding": "residual_sliding", "drift": "residual_drift"}
    row |= {renamed.get(key, key): value for key, value in last.items() if key not in ("time", "part")}
    row["max_drift"] = float(watch.drift_max[part])
    row["lost_names"] = [view.names[i] for i in np.flatnonzero(view.parts.blocks[part] & snapshot.down)]
    row |= _histogram(view, snapshot, own)
    # a joint between standing blocks that is separated is a crack as well: its width counts for the grade
    live = own & snapshot.live
    width, what, where = _widest(live, table, snapshot)
    grade = grade_of(width, row["residual_drift"], row["lost_share"], view.settings.grades, what, where)
    return row | {"grade": grade.name, "grade_label": grade.label, "grade_reason": grade.reason}


def _widest(live: np.ndarray, table: JointDamage, snapshot: DamageSnapshot) -> tuple[float, str, str]:
    """The widest opening or sliding that is left in some joints (J,) [m], which of the two it is, and the joint."""
    found = (0.0, "opening", "")
    for what, values in (("opening", snapshot.opening), ("sliding", snapshot.sliding)):
        joint = int(np.argmax(np.where(live, values, -1.0))) if live.any() else -1
        if joint >= 0 and values[joint] > found[0]:
            found = (float(values[joint]), what, f'joint {joint} ("{table.block_a[joint]}", "{table.block_b[joint]}")')
    return found


def _histogram(view: _View, snapshot: DamageSnapshot, own: np.ndarray) -> Row:
    """Joints by class of residual width: ``crack_0.1_mm`` holds widths from 0.1 mm to the next class."""
    width = snapshot.opening[own & snapshot.open]
    place = np.searchsorted(view.widths, width, side="right") - 1
    counts = np.bincount(place, minlength=len(view.widths))
    return {f"crack_{1000 * bound:.3g}_mm": int(count) for bound, count in zip(view.widths, counts, strict=True)}


def _hinge_rows(view: _View, watch: _Watch, table: JointDamage, snapshot: DamageSnapshot) -> list[Row]:
    """The joints that were hinges at some time, where they touched when they were widest open."""
    ever = np.flatnonzero(np.isfinite(watch.when))
    sides = side_names(watch.place[ever] - view.joints.centres()[ever])
    rows = []
    for j, side in zip(ever, sides, strict=True):
        owners = [name for name, own in zip(view.parts.names[: view.parts.parts], view.parts.joints, strict=False) if own[j]]
        rows.append(
            {
                "joint": int(j),
                "block_a": table.block_a[j],
                "block_b": table.block_b[j],
                "parts": ", ".join(owners),
                "x": watch.place[j, 0],
                "y": watch.place[j, 1],
                "z": watch.place[j, 2],
                "touches_towards": side,
                "opening": float(watch.widest[j]),
                "time": watch.when[j],
                "residual_opening": snapshot.opening[j],
                "at_end": bool(snapshot.hinged[j]),
            }
        )
    return rows
