# SPDX-License-Identifier: GPL-3.0-or-later
r"""Prestwood bridge, loaded to collapse across its quarter point: a ring under fill that weighs, spreads the load, and resists.

Where the ring sways into the fill, on the side away from the load, it meets at most a share of K_p gamma h, h the depth under the road
and K_p = (1 + sin phi) / (1 - sin phi). The computation is that of all field tests (:mod:`masonry_cd.studies.laboratory.field_tests`).
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from masonry_cd.studies.laboratory.case import CaseResults, CaseRow, LaboratoryCase
from masonry_cd.studies.laboratory.field_tests import FRICTION, LINE, PRESTWOOD, collapse

SHARES = (0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0)  # of K_p that the fill resists with at most


def compute(folder: Path, say: Callable[[str], object]) -> CaseResults:
    """The collapse load by limit analysis."""
    found = CaseResults(axes=("share of the passive earth pressure", "collapse load [kN]"))
    loads = []
    for share in SHARES:
        load, hinges = collapse(PRESTWOOD, f"structure.fill.passive={share}", folder=folder / f"passive_{share:.3g}")
        loads.append(load)
        say(f"{share:.3g} of K_p: {load:.1f} kN, {hinges} hinges")
        words = "fill without resistance" if share == 0.0 else f"fill that resists with {share:.3g} of K_p"
        found.rows.append(CaseRow(f"collapse load, {words}", "kN", PRESTWOOD.measured, load, None))
    found.computed.append(("limit analysis", np.array(SHARES), np.array(loads)))
    found.measured.append(("measured", np.array([SHARES[0], SHARES[-1]]), np.full(2, PRESTWOOD.measured)))
    return found


CASE = LaboratoryCase(
    "arch_bridge",
    "A brick arch bridge loaded to collapse",
    f"{'; '.join(PRESTWOOD.sources)}: Prestwood bridge, {PRESTWOOD.measured:g} kN on a line across the quarter point, four hinges",
    f"span {PRESTWOOD.span:g} m, rise {PRESTWOOD.rise:g} m, ring {PRESTWOOD.thickness:g} m, width {PRESTWOOD.width:g} m, "
    f"{PRESTWOOD.cover:g} m of fill over the crown; brickwork of 1,800 and fill of 2,040 kg/m3, {PRESTWOOD.angle:g} degrees in the fill; "
    f"friction {FRICTION:g}; the ring a part of a circle in {PRESTWOOD.voussoirs} voussoirs; the load {LINE:g} m wide at the road, spread "
    "as Boussinesq's within 30 degrees",
    "the distorted shape of the ring; the fill's cohesion; how much of its passive pressure a ring calls up before it gives way",
    "The ring with fill that weighs and spreads the load, but does not resist, carries half. What the fill resists with on the side on "
    "which the ring sways into it makes the difference: two thirds are reached with a third of K_p, the default, and more than four fifths "
    "with all of it. Other assumptions on the fill are compared in [Bridges loaded to collapse](field_tests.md).",
    compute,
)
