# SPDX-License-Identifier: GPL-3.0-or-later
r"""How stiff bars may be for the time step: a run with w h (1 + xi) > 1, w = sqrt(k / m_e), is refused, with the dt that would do.

Ties that share a block stiffen one another. With g_i the row that maps the velocities of the blocks to L_i', w^2 is the largest
eigenvalue of sqrt(k_i k_j) g_i M^-1 g_j^T over all ties, and the same limit holds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from loads.bars import Tie
from loads.motion import RunGrid
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Assembly

LARGEST_PHASE = 1.0  # w h (1 + xi) of a bar, and of all together


def check_together(ties: Sequence[Tie], grid: RunGrid) -> None:
    """Refuse ties that are too stiff together for the time step.

    Raises:
        InputError: names the step that would do.
    """
    if len(ties) > 1:
        check_phase(*highest_frequency(ties, grid.blocks("loads")), grid, "ties on the same blocks")


def bar_of(assembly: Assembly, ends: tuple[int, int], points: np.ndarray, stiffness: float, limit: float, damping: float, name: str) -> Tie:
    """A bar without first tension, of a stiffness [N/m], that yields at a limit [N]; ``damping`` is a share of the critical one."""
    length, heard = math.hypot(*(points[1] - points[0])), felt_mass(assembly, ends, points)
    dashpot = 2.0 * damping * math.sqrt(stiffness * heard)
    return Tie(ends, points - assembly.centre[list(ends)], length, 1.0, stiffness, 0.0, dashpot, limit, name)


def felt_mass(assembly: Assembly, ends: tuple[int, int], points: np.ndarray) -> float:
    """m_e of the head of this file [kg]; blocks that lean on others feel heavier, so this is the smallest it can be."""
    rows = _rows(assembly, ends, points)
    return 1.0 / sum(float(np.sum(row * _accelerated(assembly, block, row))) for block, row in rows.items())


def _rows(assembly: Assembly, ends: tuple[int, int], points: np.ndarray) -> dict[int, np.ndarray]:
    """g of the head of this file, (6,) for each free block at the ends of a tie: what its velocity adds to L'."""
    along = (points[1] - points[0]) / math.hypot(*(points[1] - points[0]))
    sides = zip(ends, points, (-1.0, 1.0), strict=True)
    return {
        block: sign * np.concatenate([along, np.cross(place - assembly.centre[block], along)])
        for block, place, sign in sides
        if not assembly.fixed[block]
    }


def _accelerated(assembly: Assembly, block: int, row: np.ndarray) -> np.ndarray:
    """M^-1 g^T of a block, (6,)."""
    a, b, c = assembly.inertia[block]  # Cramer's rule
    across = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)])
    return np.concatenate([row[:3] / assembly.mass[block], np.sum(across * row[3:], axis=1) / np.sum(a * across[0])])


def highest_frequency(ties: Sequence[Tie], assembly: Assembly) -> tuple[float, float]:
    """The largest w of all ties together [rad/s], and the largest damping ratio of one."""
    rows = [_rows(assembly, tie.blocks, assembly.centre[list(tie.blocks)] + tie.arms) for tie in ties]
    fastest, ratios = 0.0, list[float]()
    for members in _sharing(rows):
        coupled = np.zeros((len(members), len(members)))
        for i, first in enumerate(members):
            for block, row in rows[first].items():
                gain = _accelerated(assembly, block, row)
                for j, second in enumerate(members):
                    if block in rows[second]:
                        both = np.sqrt(ties[first].stiffness * ties[second].stiffness)
                        coupled[i, j] += both * float(np.sum(rows[second][block] * gain))
        fastest = max(fastest, float(np.linalg.eigvalsh(coupled)[-1]))
        ratios += [0.5 * ties[t].damping * float(np.sqrt(coupled[i, i])) / ties[t].stiffness for i, t in enumerate(members)]
    return math.sqrt(fastest), max(ratios)


def _sharing(rows: Sequence[Mapping[int, np.ndarray]]) -> list[list[int]]:
    """The ties of each set that hangs together by free blocks."""
    on, seen, found = dict[int, list[int]](), set[int](), list[list[int]]()
    for i, row_of in enumerate(rows):
        for block in row_of:
            on.setdefault(block, []).append(i)
    for i in range(len(rows)):
        members = [] if i in seen else [i]
        seen.add(i)
        for member in members:  # which grows meanwhile
            more = dict.fromkeys(j for block in rows[member] for j in on[block] if j not in seen)
            seen.update(more)
            members += more
        found += [sorted(members)] if members else []
    return found


def check_phase(omega: float, damping: float, grid: RunGrid, what: str) -> None:
    """Refuse a time step that is too long for bars of angular frequency omega [1/s]; ``what`` names them."""
    key, step = ("run.dt", grid.dt) if grid.longest is None else ("run.dt_max", grid.longest)
    phase = omega * step * (1.0 + damping)
    if phase > LARGEST_PHASE:
        allowed = f"at most {step * LARGEST_PHASE / phase:.2g} s"
        raise InputError(key, f"{step:g} s is too long for the {omega / (2.0 * np.pi):.3g} Hz of {what}; {allowed}")
