# SPDX-License-Identifier: GPL-3.0-or-later
"""A column of drums under a pulse of its base, against LMGC90 and UDEC."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.studies.laboratory.case import CaseResults, CaseRow, LaboratoryCase, run_in, threshold
from structures.geometry.prism import box, prism_xz

DURATIONS = (0.15, 0.2, 0.3, 0.34, 0.4, 0.5, 0.8)  # t_p [s]
LMGC90 = (2.2, 1.48, 0.88, 0.44, 0.30, 0.25, 0.22)  # smallest a that throws it down [g]
UDEC = (2.05, 1.46, 0.87, 0.46, 0.31, 0.27, 0.22)
DRUMS, HEIGHT, CAPITAL, FOOT, TOP, DENSITY = 7, 5.95, 0.21, 1.11, 0.90, 2620.0
FAR = 1.2  # of the capital from its place: it has fallen [m]
HALVINGS, RANGE = 5, (0.85, 1.15)  # of the search, between these shares of LMGC90's


def column() -> list[Block]:
    """Seven drums and a capital on a base, 1 m deep."""
    blocks = [Block("base", *box((-5.0, -0.5, -0.5), (5.0, 1.5, 0.0)), DENSITY, "base", fixed=True)]
    levels = np.linspace(0.0, HEIGHT - CAPITAL, DRUMS + 1)
    half = 0.5 * np.interp(levels, [0.0, levels[-1]], [FOOT, TOP])
    for k in range(DRUMS):
        (a, b), (low, high) = half[k : k + 2], levels[k : k + 2]
        profile = np.array([(-a, low), (a, low), (b, high), (-b, high)])
        blocks.append(Block(f"drum{k + 1}", *prism_xz(profile, 0.0, 1.0), DENSITY, "drums"))
    return [*blocks, Block("capital", *box((-half[-1], 0.0, float(levels[-1])), (half[-1], 1.0, HEIGHT)), DENSITY, "drums")]


def falls(folder: Path, length: float, size: float) -> bool:
    """Return True if a base accelerated by a [g] for t_p, then by -a/2 for 2 t_p, throws the capital down."""
    pulse = {"kind": "pulse", "shape": "rectangle"}
    tables = {
        "title": "Column of drums",
        "material": {"density": DENSITY, "friction": 0.7},
        "loads": [
            pulse | {"direction": "-x", "acceleration": 9.81 * size, "duration": length},
            pulse | {"direction": "x", "acceleration": 4.905 * size, "duration": 2 * length, "start": length},
        ],
        "run": {"dt": 4e-3, "duration": 3.0 * length + 4.0, "tolerance": 1e-5, "frames_per_second": 10.0},
    }
    with run_in(folder, column(), tables) as results:
        place = np.array([results.position[frame][-1] for frame in range(results.frames)])
    return bool(np.linalg.norm(place - place[0], axis=1).max() > FAR)


def compute(folder: Path, say: Callable[[str], object]) -> CaseResults:
    """Halve the range until the threshold is known to half a hundredth of it."""
    found = CaseResults(axes=("duration of the pulse [s]", "smallest acceleration that overturns it [g]"))
    limits = []
    for length, other in zip(DURATIONS, LMGC90, strict=True):
        low, high = (share * other for share in RANGE)
        limits.append(threshold(partial(falls, folder / f"pulse_{length:g}", length), low, high, HALVINGS))
        say(f"t_p {length:g} s: {limits[-1]:.4f} g, LMGC90 {other:g}")
        found.rows.append(CaseRow(f"a at t_p = {length:g} s (UDEC {UDEC[len(limits) - 1]:g})", "g", other, limits[-1], None))
    found.measured += [(name, np.array(DURATIONS), np.array(values)) for name, values in (("LMGC90", LMGC90), ("UDEC", UDEC))]
    found.computed.append(("masonry_cd, rigid", np.array(DURATIONS), np.array(limits)))
    return found


CASE = LaboratoryCase(
    "columns",
    "A column of drums under a pulse",
    "Dimitri, De Lorenzis & Zavarise, Eng. Struct. 33, 2011, as in HybriDFEM 3.1: LMGC90 and UDEC",
    "seven equal drums that taper from 1.11 to 0.90 m and a capital of 0.21 m, rigid dry joints of friction 0.7; time step 4 ms",
    "contact stiffness and damping of UDEC",
    "The three programs agree within a few hundredths over a tenfold range of accelerations.",
    compute,
)
