# SPDX-License-Identifier: GPL-3.0-or-later
"""Result files made by hand: blocks put where a test wants them, measured and written as a run does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from masonry_cd.analysis.damage.step_peaks import StepPeaks
from masonry_cd.io.layout import JOINT_PEAKS
from masonry_cd.io.result_writer import ResultWriter
from masonry_cd.io.summary import Summary
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.fill import Fill
from masonry_cd.mechanics.model.joints import JointPeaks, measure_joints
from masonry_cd.mechanics.model.state import State

BOX_FACES = ((3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))


def box(name: str, low: Sequence[float], high: Sequence[float], group: str = "block", fixed: bool = False) -> Block:
    """A box between two opposite corners [m]."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    plan = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    return Block(name, np.array([(x, y, z) for z in (z0, z1) for x, y in plan], dtype=float), BOX_FACES, 2000.0, group, fixed)


def turned(state: State, index: int, pivot: Sequence[float], degrees: float, axis: Sequence[float] = (0.0, 1.0, 0.0)) -> State:
    """The state with one block turned about an axis through a point; about y, a positive angle tips +z over to +x."""
    half, unit = np.radians(degrees) / 2.0, np.asarray(axis) / np.linalg.norm(axis)
    out = state.copy()
    out.orientation[index] = [np.cos(half), *(np.sin(half) * unit)]
    arm = state.position[index] - np.asarray(pivot)
    across = np.cross(unit, arm)
    out.position[index] = np.asarray(pivot) + arm + np.sin(2 * half) * across + (1 - np.cos(2 * half)) * np.cross(unit, across)
    return out


def shifted(state: State, indices: int | Sequence[int] | slice, by: Sequence[float]) -> State:
    """The state with some blocks moved."""
    out = state.copy()
    out.position[indices] += np.asarray(by)
    return out


def write_run(
    path: Path,
    blocks: Sequence[Block],
    states: Sequence[State],
    title: str = "a case",
    peaks: bool = True,
    scene: str = "",
    histories: Mapping[str, np.ndarray] | None = None,
    ended: bool = False,
    every: int = 0,
    stress: np.ndarray | None = None,
    fills: Sequence[Fill] = (),
) -> Path:
    """Write a result with one frame per state, 0.1 s apart; without peaks it is the file of a run that was killed,
    and with a scene it is one that was cut off unless it has ``ended``.

    With ``every``, each state is that of a step, the first of all left out, and only every so many become frames; without it, largest
    drifts and hinges are not noted, as by older versions.

    ``histories`` (F, J) or (F, J, 3) of the joints by name come in addition to those that are measured, ``stress`` (F, B, 6) of the blocks.
    """
    assembly = Assembly.from_blocks(blocks, 0.6)
    joints = find_joints(assembly)
    largest = JointPeaks(joints)
    support = int(np.argmax(assembly.fixed)) if assembly.fixed.any() else -1
    of_steps = StepPeaks(assembly, joints, support)
    with ResultWriter(path, assembly, joints, scene=scene, title=title, fills=fills) as writer:
        if every:
            writer.begin_step_peaks(of_steps.arrays, support)
        for k, state in enumerate(states):
            now = measure_joints(joints, assembly, state)
            largest.update(now, 0.1 * k)
            if k and every:
                of_steps.update(now, replace(state, time=0.1 * k))
            if every and k % every:
                continue
            writer.append({"time": 0.1 * k, "position": state.position, "orientation": state.orientation, "velocity": state.velocity})
            writer.append({f"joints/{name}": getattr(now, name) for name in ("opening", "sliding", "rotation", "contact_area")})
            writer.append({f"joints/{name}": rows[k] for name, rows in (histories or {}).items()})
            if stress is not None:
                writer.append({"stress": stress[k]})
        if ended:
            writer.write_closing(Summary(stopped=""))
        writer.flush()
        if peaks:
            writer.write_peaks({name: getattr(largest, name) for name in JOINT_PEAKS}, of_steps.arrays if every else None)
    return path


def at_rest(blocks: Sequence[Block]) -> State:
    """The blocks where they were built."""
    return State.at_rest(Assembly.from_blocks(blocks, 0.6))
