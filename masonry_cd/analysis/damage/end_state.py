# SPDX-License-Identifier: GPL-3.0-or-later
r"""End states: frames in which blocks and base are still, of a run that was not cut off.

Residual values, mechanisms and grades say what remains, so they hold only where nothing moves any more. The speed of a block is that of
its fastest point at most, |v| + |w| r, r the farthest corner from its centre, relative to the support that moves least. A block that has
fallen may roll for as long as it likes. What is faster than STILL, 1 mm/s, moves; or faster than the tolerance of the run resolves, where
that is more.

Where a run ended because its steps were still, a loose stone may yet rattle between its neighbours, to and fro in one step each
(``mechanics/dynamics/pauses.py``). In its last frame the speed of a block is therefore the mean since the frame before, where that is less.
In other frames it is not: of a structure that sways, two frames may look alike.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.joint_damage import fallen
from masonry_cd.analysis.deformed import Solids, frame_index, solids_of
from masonry_cd.foundation.quantities import length
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.io.summary_tables import End
from masonry_cd.mechanics.dynamics.pauses import STILL

CUT_OFF = "the run was cut off"


@dataclass(frozen=True)
class EndState:
    """How a structure moves at a frame."""

    end: End  # its speeds, for summary.json
    still: float  # what is faster moves [m/s]
    stopped: str  # why the run ended before its time; empty where it did not

    @property
    def provisional(self) -> str:
        """Why residual values and grades are provisional, as text; empty where they are final."""
        reasons, end = [self.stopped] if self.stopped else [], self.end
        if end.base_speed > self.still:
            reasons.append(f"the base still moving at {length(end.base_speed)}/s")
        if end.speed > self.still:
            reasons.append(f'still moving at {length(end.speed)}/s ("{end.block}")')
        return f"provisional: {', '.join(reasons)} at {end.time:.4g} s" if reasons else ""


def end_state(results: Results, thresholds: Thresholds | None = None, frame: int = -1) -> EndState:
    """How the structure moves at a frame, the last one by default."""
    solids, index = solids_of(results.blocks), frame_index(results, frame)
    velocity = np.asarray(results.velocity[index], dtype=float)
    standing = ~solids.fixed & ~fallen(results, thresholds, index)
    closing = results.closing or Summary()
    still = STILL if closing.still is None else closing.still
    speed = now = np.where(standing, speeds(velocity, solids, results.support), -1.0)
    if index > 0 and index == results.frames - 1 and closing.ended_still:
        speed = np.minimum(now, speeds(_since(results, index), solids, results.support))
    fastest = int(np.argmax(speed)) if standing.any() else -1
    base = speeds(velocity, solids, -1)[solids.fixed]
    end = End(
        time=float(results.time[index]),
        speed=float(speed[fastest]) if fastest >= 0 else 0.0,
        block=results.blocks[fastest].name if fastest >= 0 else "",
        base_speed=float(base.max(initial=0.0)),
        rattles=_fastest_in_words(results, np.where(speed <= still, now, 0.0), still),
    )
    return EndState(end, still, _stopped(results) if index == results.frames - 1 else "")


def _fastest_in_words(results: Results, speed: np.ndarray, still: float) -> str:
    """The block of the largest of some speeds (B,) and that speed [m/s]; empty where none moves."""
    fastest = int(np.argmax(speed))
    return f'"{results.blocks[fastest].name}" at {length(speed[fastest])}/s' if speed[fastest] > still else ""


def _since(results: Results, index: int) -> np.ndarray:
    """Mean velocities (B, 6) of the blocks between the frame before and one [m/s, rad/s]; angular ones by their size, as small turns."""
    shift, span = results.position[index] - results.position[index - 1], float(results.time[index] - results.time[index - 1])
    cosine = np.abs((results.orientation[index] * results.orientation[index - 1]).sum(axis=1))
    turn = 2.0 * np.sqrt(np.maximum(0.0, 2.0 - 2.0 * np.minimum(cosine, 1.0)))
    return np.column_stack([shift, turn, np.zeros((len(turn), 2))]) / span


def speeds(velocity: np.ndarray, solids: Solids, support: int) -> np.ndarray:
    """(B,) largest speed of a point of each block relative to a support [m/s], -1 for none; velocities (B, 6) [m/s, rad/s]."""
    base = velocity[support, :3] if support >= 0 else np.zeros(3)
    reach = np.zeros(len(solids.centre))
    np.maximum.at(reach, solids.vertex_block, np.linalg.norm(solids.vertices - solids.centre[solids.vertex_block], axis=1))
    return np.asarray(np.linalg.norm(velocity[:, :3] - base, axis=1) + np.linalg.norm(velocity[:, 3:], axis=1) * reach)


def _stopped(results: Results) -> str:
    """Why a run ended before its time: what its closing words say, or that it has none, as after a kill."""
    if not results.scene or not results.format:
        return ""  # no run of a scene, or from before there were closing words
    return CUT_OFF if results.closing is None else results.closing.stopped
