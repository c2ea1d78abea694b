# SPDX-License-Identifier: GPL-3.0-or-later
r"""The stress of a run: principal stresses of the blocks, largest compressions of blocks and joints, against a strength.

A **block** has the mean stress over its volume (:mod:`masonry_cd.mechanics.dynamics.mean_stress`). It hides bending, local pressure under a
contact, and splitting next to it: a block may fail whose mean is low. A **joint** has the largest compression of a linear distribution
without tension of its normal force (:mod:`masonry_cd.mechanics.model.edge_stress`); where rigid blocks turn about an edge that is infinite,
and what a strength f then says is how much of the joint the force N takes at the least, spread evenly, as in a plastic hinge:

    crushed share = N / (f A),        A the area of the joint; the hinge moves in by half of that share of the joint's depth.

Where joints are rigid, the place of the force in a joint that is closed is not unique in a hyperstatic structure: a run finds one, often at
an edge. In a hinge that gapes it is. So joints above their strength, or with a force at an edge, are sorted by whether they were open.

All values are means over the time between two frames, so the largest are over all steps of the run, but of these means: what rises and
falls within a frame is averaged. Nothing crushes in the run itself. The strength of a joint is the lower one of its two blocks.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from masonry_cd.foundation.errors import InputError, table_in_si
from masonry_cd.io.layout import EDGE_STRESS, MEAN_NORMAL_FORCE
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.materials import Material, given_strength
from masonry_cd.mechanics.model.strength import strength_by_group

NOTHING = 1e-6  # share of the largest compression below which a tension is rounding
AT_ONCE = 256  # frames that are read together
KEPT_NONE = "the run kept no stress; report.stress = true in its scene asks for it"


@dataclass(frozen=True, eq=False)
class StressPeaks:
    """The largest stresses of B blocks and J joints; NaN of supports, and of a run without a step.

    Attributes:
        interval: mean time between two frames [s].
        compression: (B,) largest compression of each block, a principal stress, positive [Pa].
        compression_time: (B,) frame of it [s].
        tension: (B,) largest tension [Pa], negative where all principal stresses are compressions at all times.
        tension_time: (B,) [s].
        edge: (J,) largest compression of each joint, infinite where its force came to an edge [Pa].
        edge_time: (J,) [s]; the first of equals.
        finite_edge: (J,) largest compression of each joint while that was finite [Pa].
        open_above: (J,) joints that came above their strength, or, where none is given, to an edge, while they were open.
        closed_above: (J,) joints that did so only while they were closed.
        open_at_edge: (J,) joints whose force came to an edge while they were open.
        force: (J,) largest normal force [N].
        force_time: (J,) [s].
        block_strength: (B,) NaN where there is none [Pa].
        joint_strength: (J,) likewise.
        area: (J,) of the joints [m2].
    """

    interval: float
    compression: np.ndarray
    compression_time: np.ndarray
    tension: np.ndarray
    tension_time: np.ndarray
    edge: np.ndarray
    edge_time: np.ndarray
    finite_edge: np.ndarray
    open_above: np.ndarray
    closed_above: np.ndarray
    open_at_edge: np.ndarray
    force: np.ndarray
    force_time: np.ndarray
    block_strength: np.ndarray
    joint_strength: np.ndarray
    area: np.ndarray

    @cached_property
    def block_ratio(self) -> np.ndarray:
        """(B,) largest compression over the strength."""
        return self.compression / self.block_strength

    @cached_property
    def joint_ratio(self) -> np.ndarray:
        """(J,) largest compression over the strength; infinite at an edge."""
        return self.edge / self.joint_strength

    @cached_property
    def crushed_share(self) -> np.ndarray:
        """(J,) share of the joint that its largest force takes at the least, at the strength."""
        return self.force / (self.joint_strength * self.area)

    @cached_property
    def pulled(self) -> np.ndarray:
        """(B,) blocks in which there was tension at all."""
        return np.asarray(np.nan_to_num(self.tension) > NOTHING * np.nan_to_num(self.compression).max(initial=0.0))

    @property
    def compared(self) -> bool:
        """Return True if any block has a strength."""
        return bool(np.isfinite(self.block_strength).any())


def require_stress(results: Results) -> None:
    """Refuse results without stress.

    Raises:
        InputError: the run kept none.
    """
    if not results.has_stress:
        raise InputError(results.path, f"{KEPT_NONE}")


def tensors(six: np.ndarray) -> np.ndarray:
    """Stresses (..., 6) xx yy zz xy yz xz as symmetric tensors (..., 3, 3)."""
    return np.asarray(six)[..., [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(*np.shape(six)[:-1], 3, 3)


def principal(six: np.ndarray) -> np.ndarray:
    """Principal stresses (..., 3), the largest tension first, of stresses (..., 6); NaN where these are."""
    known = np.isfinite(six).all(axis=-1)
    values = np.linalg.eigvalsh(tensors(np.where(known[..., None], six, 0.0)))[..., ::-1]
    return np.where(known[..., None], values, np.nan)


def strengths(results: Results) -> tuple[np.ndarray, np.ndarray]:
    """The strength of each block (B,) and joint (J,) by the scene of a run [Pa]; NaN where there is none."""
    given = given_strength(table_in_si((Material,), results.tables.get("material", {}), "material"))
    named = [block.group for block in results.blocks]
    groups = list(dict.fromkeys(named))
    of_group = strength_by_group(given, groups)
    of_block = of_group[[groups.index(name) for name in named]]
    joints = results.joints
    return of_block, np.fmin(of_block[joints.block_a], of_block[joints.block_b])


def stress_peaks(results: Results, opened: float) -> StressPeaks:
    """The largest stresses of a run; a joint counts as open beyond a width ``opened`` [m].

    Raises:
        InputError: the run kept none.
    """
    require_stress(results)
    blocks, joints, time = len(results.blocks), results.joints.count, np.asarray(results.time, dtype=float)
    largest = {name: Largest(n) for name, n in (("compression", blocks), ("tension", blocks), ("edge", joints), ("force", joints))}
    finite, above = Largest(joints), np.zeros((3, joints), dtype=bool)  # at all, while open; at an edge while open
    of_block, of_joint = strengths(results)
    for first in range(1, results.frames, AT_ONCE):  # the first frame is before any step
        last = min(first + AT_ONCE, results.frames)
        values = principal(np.asarray(results.stress[first:last], dtype=float))
        edge = np.asarray(results.file[f"joints/{EDGE_STRESS}"][first:last], dtype=float)
        largest["compression"].take(-values[..., 2], time[first:last])
        largest["tension"].take(values[..., 0], time[first:last])
        largest["edge"].take(edge, time[first:last])
        largest["force"].take(np.asarray(results.file[f"joints/{MEAN_NORMAL_FORCE}"][first:last], dtype=float), time[first:last])
        finite.take(np.where(np.isinf(edge), np.nan, edge), time[first:last])
        gaping, over = np.asarray(results.file["joints/opening"][first:last]) >= opened, above_limit(edge, of_joint)
        above |= np.stack([over, over & gaping, np.isinf(edge) & gaping]).any(axis=1)
    found = {name: item.value for name, item in largest.items()} | {f"{name}_time": item.time for name, item in largest.items()}
    interval = float(np.diff(time).mean()) if len(time) > 1 else float("nan")
    found |= {"finite_edge": finite.value, "open_above": above[1], "closed_above": above[0] & ~above[1], "open_at_edge": above[2]}
    found |= {"block_strength": of_block, "joint_strength": of_joint, "area": results.joints.area}
    return StressPeaks(interval, **found)


def above_limit(edge: np.ndarray, strength: np.ndarray) -> np.ndarray:
    """Where edges (..., J) come above their strength (J,); where no joint has one, whether the force is at an edge."""
    return edge > strength if np.isfinite(strength).any() else np.isinf(edge)


class Largest:
    """The largest of n values so far, and when; NaN before any."""

    def __init__(self, count: int) -> None:
        self.value, self.time = np.full(count, np.nan), np.full(count, np.nan)

    def take(self, values: np.ndarray, times: np.ndarray) -> None:
        """Take in values (F, n) of some times (F,)."""
        if not values.size:
            return
        filled = np.where(np.isnan(values), -np.inf, values)
        row = filled.argmax(axis=0)
        best = filled[row, np.arange(filled.shape[1])]
        new = (best > np.where(np.isnan(self.value), -np.inf, self.value)) & (best > -np.inf)
        self.value[new], self.time[new] = best[new], times[row[new]]


def largest_pressure(results: Results) -> tuple[float, int, float] | None:
    """Largest normal force of a joint over its area in the frames [Pa], the joint, and when [s]; None in a file without forces."""
    joints = results.joints
    if not joints.count or not results.has_joint_history("normal_force"):
        return None
    best, force = (-1.0, 0, 0.0), results.file["joints/normal_force"]
    for some in results.in_chunks(joints.count):
        pressure = np.nan_to_num(np.asarray(force[some], dtype=float)) / joints.area
        frame, joint = np.unravel_index(int(np.argmax(pressure)), pressure.shape)
        if pressure[frame, joint] > best[0]:
            best = (float(pressure[frame, joint]), int(joint), float(results.time[some.start + int(frame)]))
    return best
