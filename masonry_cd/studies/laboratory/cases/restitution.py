# SPDX-License-Identifier: GPL-3.0-or-later
r"""Blocks that rock freely: what an impact leaves of their angular velocity.

    Housner: r = 1 - 3/2 sin^2 alpha,        tan alpha = width / height

for a rigid block that turns about one corner, then about the other, and does not bounce.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.studies.laboratory.case import CaseResults, CaseRow, Curve, LaboratoryCase, elastic, run_in
from structures.geometry.prism import box

MEASURED = ((3.0, "concrete", 0.97), (5.0, "concrete", 0.95), (5.0, "rubber", 0.67))  # height over width, base, share of Housner's r
WIDTH, DENSITY = 0.2, 2400.0  # [m], [kg/m3]; r depends on neither
SHAPES = (2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0)  # height over width of the blocks that are run: a curve against the measured one
RELEASED = 0.8  # share of alpha from which it is let go
LAW = {"normal_stiffness": 1e10, "tangential_stiffness": 4e9}  # of the elastic joint [N/m3]


def housner(slenderness: float) -> float:
    """r of a block whose height is a given number of times its width."""
    return 1.0 - 1.5 / (1.0 + slenderness**2)


def tilted(slenderness: float) -> list[Block]:
    """A block on a lower corner, leaning, and its base."""
    lean = RELEASED * float(np.arctan(1.0 / slenderness))
    corners, faces = box((0.0, 0.0, 0.0), (WIDTH, 0.3, slenderness * WIDTH))
    turn = np.array([[np.cos(lean), 0.0, -np.sin(lean)], [0.0, 1.0, 0.0], [np.sin(lean), 0.0, np.cos(lean)]])
    return [
        Block("ground", *box((-1.0, -0.3, -0.3), (1.0, 0.6, 0.0)), DENSITY, "base", fixed=True),
        Block("block", corners @ turn.T, faces, DENSITY, "block"),
    ]


def lasting(slenderness: float) -> float:
    """Two half-swings to the angle of release, which none after an impact exceeds, and a tenth more [s]: cosh(p t) = 1 / (1 - share)."""
    frequency = np.sqrt(3.0 * 9.81 / (2.0 * WIDTH * np.hypot(1.0, slenderness)))
    return float(1.1 * 2.0 * np.arccosh(1.0 / (1.0 - RELEASED)) / frequency)


def swings(folder: Path, slenderness: float, law: dict[str, float] | None) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and tilts [rad] of the block, let go."""
    tables = {
        "title": f"A block of height / width {slenderness:g} rocks freely",
        "material": {"density": DENSITY, "friction": 1.0, **elastic(law)},
        "run": {"dt": 2.5e-4, "duration": lasting(slenderness), "tolerance": 1e-8, "frames_per_second": 1000.0, "settle": False},
    }
    with run_in(folder, tilted(slenderness), tables) as results:
        turned = np.array([results.orientation[frame][-1] for frame in range(results.frames)])
        time = np.array(results.time[: results.frames])
    start = RELEASED * float(np.arctan(1.0 / slenderness))
    return time, start - 2.0 * np.arctan2(turned[:, 2], turned[:, 0])


def kept(tilt: np.ndarray, slenderness: float) -> float:
    """r of the first impact, from the energies above rest at the two ends of the first half-swing."""
    alpha = float(np.arctan(1.0 / slenderness))
    crossing = int(np.argmax(tilt * tilt[0] < 0.0))
    after = np.abs(tilt[crossing:])
    back = np.flatnonzero(tilt[crossing:] * tilt[0] > 0.0)
    peak = float(after[: back[0] if len(back) else None].max())
    above = [np.cos(alpha - angle) - np.cos(alpha) for angle in (abs(float(tilt[0])), peak)]
    return float(np.sqrt(above[1] / above[0]))


def measured(base: str) -> Curve:
    """Heights over widths of the blocks that were tested on a base, and r as it was measured."""
    across, up = np.array([(slenderness, share * housner(slenderness)) for slenderness, of, share in MEASURED if of == base]).T
    return f"measured on {base}", across, up


def compute(folder: Path, say: Callable[[str], object]) -> CaseResults:
    """r over slenderness on rigid and on elastic joints, with Housner's curve and the points that were measured."""
    found = CaseResults(axes=("height / width", "r of the first impact"))
    values: dict[tuple[float, str], float] = {}
    for label, law in (("rigid", None), ("elastic", LAW)):
        for slenderness in SHAPES:
            values[slenderness, label] = kept(swings(folder / f"{label}_{slenderness:g}", slenderness, law)[1], slenderness)
            say(f"height / width {slenderness:g}, {label}: r {values[slenderness, label]:.4f}, Housner {housner(slenderness):.4f}")
        found.computed.append((f"{label} joint", np.array(SHAPES), np.array([values[slenderness, label] for slenderness in SHAPES])))
    along = np.linspace(SHAPES[0], SHAPES[-1], 61)
    found.measured.append(("Housner", along, np.array([housner(slenderness) for slenderness in along])))
    found.measured.append(measured("rubber"))
    found.points.append(measured("concrete"))
    for slenderness, base, share in MEASURED:
        row = (values[slenderness, "rigid"], values[slenderness, "elastic"])
        found.rows.append(CaseRow(f"r, height / width {slenderness:g}, on {base}", "of 1", share * housner(slenderness), *row))
    return found


CASE = LaboratoryCase(
    "restitution",
    "Blocks that rock freely",
    "ElGawady, Ma, Butterworth & Ingham, Effects of interface material on the dynamic behaviour of rigid blocks: measured 0.97 and 0.95 of "
    "Housner's value on concrete, 0.67 of it on rubber",
    "blocks 0.2 m wide, let go at 0.8 of their slenderness; r from the heights of the first two swings; elastic joint of 1e10 N/m3 "
    "without damping",
    "sizes of the blocks, which Housner's value does not depend on; the bases' stiffness; the swings over time, which the public summary "
    "does not have",
    "The rigid joint loses at an impact what Housner's formula says, within 1e-4, and the tests on concrete a few per cent more. An "
    "elastic joint without damping loses less, as it throws the block back. Rubber takes more than either. With material.restitution = e "
    "the rigid block keeps r - e (1 - r) of its speed: 0.17 and 0.82 give the two values on concrete, and no e up to 1 that on rubber.",
    compute,
)
