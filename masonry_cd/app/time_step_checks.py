# SPDX-License-Identifier: GPL-3.0-or-later
r"""Checks that time step and tolerance resolve the shaking, the blocks and their rest; else the run warns, with the number and the block.

**Shaking.** f95 is the frequency below which 95 % of the base acceleration's mean square lies, from its values at the steps. Fewer than
PER_PERIOD steps per period of f95 are too few.

**Rocking.** A block that rocks about an edge grows with the rate p = sqrt(3 g / (4 R)), R the distance of its farthest corner from its
centre (Housner, Bull. Seism. Soc. Am. 53, 1963). Against Housner's solution peaks are met to 0.1 % at p h = 0.008, to 2 % at 0.02
(``python -m benchmarks.rocking``); p h beyond ROCKING, some 3 %, is too much.

**Passing through.** A block that moves by more than PASSING times the smallest width of any block within one step can get into another
before the two are found to touch (see ``docs/stability.md``).

**Stillness.** The error of a step is shared by all C contacts; all of it in one of them is a speed of tolerance g h sqrt(C) there. A rest
that waits for a smaller one may wait in vain.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from masonry_cd.io.results import Results
from masonry_cd.mechanics.dynamics.local_error import PASSING
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.shocks import Pause

ENERGY = 0.95
PER_PERIOD = 10.0
ROCKING = 0.03


def before_run(assembly: Assembly, support_velocity: np.ndarray, gravity: float, step: float) -> list[str]:
    """Return lines on shaking and blocks for which a time step is too coarse.

    Args:
        assembly: the blocks.
        support_velocity: (N + 1, S, 3 or 6) at the steps [m/s, rad/s].
        gravity: magnitude [m/s2].
        step: h [s].
    """
    frequency = dominant_frequency(assembly.in_metres(support_velocity), step)
    reach = np.where(assembly.fixed, np.inf, assembly.reach)
    smallest = int(np.argmin(reach))
    p = float(np.sqrt(0.75 * gravity / reach[smallest]))
    too_few, too_fast = frequency * step * PER_PERIOD > 1.0, p * step > ROCKING
    needs = ([1.0 / (PER_PERIOD * frequency)] if too_few else []) + ([ROCKING / p] if too_fast else [])
    longest = _round_down(min(needs)) if needs else step  # one step that meets every remark
    lines = []
    if too_few:
        lines.append(
            f"run.dt {step:g} s is coarse for the shaking: {100 * ENERGY:g} % of the base acceleration (mean square) lie below "
            f"{frequency:.3g} Hz, of which a period has {1.0 / (frequency * step):.2g} steps; {PER_PERIOD:g} need dt {longest:g}"
        )
    if too_fast:
        lines.append(
            f'run.dt {step:g} s is coarse for block "{assembly.names[smallest]}", should it rock by itself: it grows by p = {p:.3g} 1/s '
            f"(R {1000 * reach[smallest]:.3g} mm), p dt is {p * step:.2g}; {ROCKING:g} needs dt {longest:g}"
        )
    return lines


def after_run(assembly: Assembly, results: Results, step: float) -> list[str]:
    """Warn of blocks that moved so far within a step that they could pass through another; by the velocities of the frames."""
    found = fastest(assembly, results)
    if found is None:
        return []
    speed, block, time = found
    free_part = ~assembly.fixed[assembly.shapes.part_block]
    part = int(np.argmin(np.where(free_part, assembly.shapes.size, np.inf)))
    width, thin = float(assembly.shapes.size[part]), assembly.names[assembly.shapes.part_block[part]]
    if not speed * step > PASSING * width:
        return []
    return [
        f'block "{assembly.names[block]}" moves at {speed:.3g} m/s at {time:.4g} s, by {speed * step / width:.2g} of the width of '
        f'"{thin}" ({1000 * width:.3g} mm) in one step: it can pass into others; dt {_round_down(PASSING * width / speed):g} is safe'
    ]


def restless(results: Results, pauses: Sequence[Pause], gravity: float, step: float, tolerance: float) -> list[str]:
    """The rests that took their whole length and waited for a speed that the tolerance does not resolve.

    Args:
        results: of the run.
        pauses: of its loads.
        gravity: magnitude [m/s2].
        step: h [s].
        tolerance: of each step.
    """
    load_steps, contacts = results.per_step("load_step"), results.per_step("solver/contacts")
    if not len(load_steps):
        return []
    resolved = resolved_speed(tolerance, gravity, step, float(contacts.mean()))
    return [
        f'the rest after "{pause.after}" took its whole length: still = {pause.speed:g} m/s asks for less than the {resolved:.2g} m/s that '
        f"a tolerance of {tolerance:g} reliably resolves"
        for pause in pauses
        if pause.speed < resolved and np.any(load_steps == pause.last)  # a rest that ends early jumps over its last step
    ]


def resolved_speed(tolerance: float, gravity: float, step: float, contacts: float) -> float:
    """The speed that a step's tolerance reliably resolves, see the head of this file [m/s]."""
    return tolerance * gravity * step * math.sqrt(contacts)


def dominant_frequency(support_velocity: np.ndarray, step: float) -> float:
    """f95 of the base acceleration, all motions and directions together [Hz]; 0 for a base that stands still."""
    acceleration = np.diff(support_velocity, axis=0).reshape(len(support_velocity) - 1, -1) / step
    power = (np.abs(np.fft.rfft(acceleration, axis=0)) ** 2).sum(axis=1)
    if not power.sum() > 0.0:
        return 0.0
    share = np.cumsum(power) / power.sum()
    return float(np.fft.rfftfreq(len(acceleration), step)[int(np.argmax(share >= ENERGY))])


def fastest(assembly: Assembly, results: Results) -> tuple[float, int, float] | None:
    """Largest speed of a free block over the frames [m/s], the block, and when [s]; None without one.

    Relative to the support that moves least: one that settles, or is shaken late, is not a measure of the others. What has dropped below
    all supports, off the edge of a floor, falls for ever and meets nothing any more: it counts as still.
    """
    free = np.flatnonzero(~assembly.fixed)
    if not len(free) or not results.frames:
        return None
    support = results.support
    velocity, position, best = results.velocity, results.position, (-1.0, 0, 0.0)
    for some in results.in_chunks(6 * assembly.count):
        linear = velocity[some, :, :3]
        relative = linear[:, free] - (linear[:, [support]] if support >= 0 else 0.0)
        speed = np.sqrt((relative**2).sum(axis=2))
        speed[below_supports(assembly, position[some, :, 2])[:, free]] = 0.0
        frame, block = np.unravel_index(int(np.argmax(speed)), speed.shape)
        if speed[frame, block] > best[0]:
            best = (float(speed[frame, block]), int(free[block]), float(results.time[some.start + frame]))
    return best


def below_supports(assembly: Assembly, height: np.ndarray) -> np.ndarray:
    """(F, B) True where a block is wholly below all supports, by the heights (F, B) of the centres of mass [m]; z is up."""
    if not assembly.fixed.any():
        return np.zeros(height.shape, dtype=np.bool_)
    ground = (height - assembly.reach)[:, assembly.fixed].min(axis=1)
    return np.asarray(height + assembly.reach < ground[:, None])


def _round_down(value: float) -> float:
    """The next value of one digit below: 0.00137 -> 0.001."""
    power = 10.0 ** math.floor(math.log10(value))
    return float(np.floor(value / power * (1 + 1e-9)) * power)
