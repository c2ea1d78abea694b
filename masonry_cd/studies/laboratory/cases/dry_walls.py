# SPDX-License-Identifier: GPL-3.0-or-later
"""The dry-stone walls of Lourenço et al. (2005), pushed along their plane under a constant vertical force."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from masonry_cd.studies.laboratory.case import CaseResults, CaseRow, Curve, LaboratoryCase, at
from masonry_cd.studies.laboratory.shear_walls import ShearWall, crack_rows

WALL = ShearWall(courses=10, course=0.1, unit=0.2, depth=0.2, friction=0.62)  # friction of sawn stone, not stated with the tests
REACH = 0.02  # pushed so far [m]
STRESSES: dict[float, tuple[float, tuple[float, ...], tuple[float, ...]]] = {  # MPa: E [Pa], peaks [kN], and where [mm]
    0.15: (566e6, (21.9, 22.9), (26.0, 8.8)),
    0.5: (756e6, (41.5, 48.2), (10.1, 7.0)),
    1.0: (1135e6, (71.6, 68.6), (9.6, 18.9)),
    1.25: (1324e6, (102.7,), (8.6,)),
}

ENVELOPES = """\
SW.30.1, 0.15 MPa | 2.49 4.98 7.46 9.95 12.44 14.92 17.41 19.9 22.39 24.88 27.36 29.85
                  | 14.2 15.8 17.1 15.7 14 14.8 15.7 17 19.5 21.1 21.5 19.1
SW.30.2, 0.15 MPa | 2.49 4.98 7.46 9.95 12.44 14.92 17.41 19.9 22.39 24.88 27.36 29.85
                  | 15.9 17.3 20.6 14.8 18.7 19.1 11 15.7 19.4 14.9 19.9 19.1
SW.100.1, 0.5 MPa | 1.8 3.6 5.4 7.2 9 10.8 12.59 14.39 16.19 17.99 19.79 21.59
                  | 25.7 27.7 31.8 36.6 36.4 35.3 33.3 26.7 35.3 28.1 26.9 28.3
SW.100.2, 0.5 MPa | 2.13 4.26 6.38 8.51 10.64 12.76 14.89 17.02 19.15 21.28 23.4 25.53
                  | 25 36.2 46.3 44.7 44.1 40 43.7 46.9 40.1 44 45.4 28.7
SW.200.1, 1 MPa | 2.23 4.46 6.68 8.91 11.14 13.37 15.6 17.83 20.05 22.28 24.51 26.74
                | 45.7 54.2 62.2 72.1 66 63.4 59 54.4 52.1 40.6 35.6 48.6
SW.200.2, 1 MPa | 1.89 3.78 5.66 7.55 9.44 11.32 13.21 15.1 16.99 18.88 20.76 22.65
                | 31.2 49.8 62.3 65.2 66.1 58 51.7 58.2 61.1 67.7 63.4 67.4
SW.250.1, 1.25 MPa | 2.47 4.94 7.4 9.87 12.34 14.81 17.28 19.75 22.22 24.68 27.15 29.62
                   | 68.2 87.1 100.8 78.5 70.5 76.5 74.7 75.8 74.2 71.4 72.2 66.6
"""  # of the tests, read off the database's curves at twelve displacements: name and [mm], then [kN]

CRACKS = """\
0.15 | 0,1 1,1 1,2 2,2 2,3 3,3 3,4 4,4 4,5 5,5 5,6 6,6 6,7 7,7 7,8 8,8 8,9 10,9 | 2,6 2,7 3,7 3,8 4,8 4,9
0.15 | 1,1 1,2 2,2 2,3 3,3 3,4 4,4 4,5 5,5 5,6 6,6 6,7 7,7 7,8 8,8 8,9 10,9 | 1,3 1,4 2,4 2,5 3,5 3,6 4,6 4,7 5,7 5,8 6,8 6,9 7,9 7,10
0.5 | 4,2 4,3 5,3 5,4 6,4 6,5 7,5 7,6 8,6 8,7 9,7 9,8 | 6,6 6,7 7,7 7,8 8,8 8,9 9,9 9,10 | 2,4 2,5 3,5 3,6 4,6 4,7 5,7 5,8 6,8 6,9
    | 0,4 1.3,4 1.3,3.3 0.8,2.1 0.3,1.2 0.3,0
0.5 | 1,1 1,2 2,2 2,3 3,3 3,4 4,4 4,5 | 7,5 7,6 8,6 8,7 9,7 9,8 | 6,6 6,7 7,7 7,8 8,8 8,9 9,9 9,10 | 1,5 1,6
    | 2,4 2,5 3,5 3,6 4,6 4,7 5,7 5,8 6,8 6,9 | 0,4 1.7,4 1.7,3.4 1,3.2 0.9,2.2 0.5,1.4 0.5,0
1 | 6,6 6,7 7,7 7,8 8,8 8,9 9,9 9,10 | 2,4 2,5 3,5 3,6 4,6 4,7 5,7 5,8 6,8 6,9 7,9 7,10
    | 0,4 1.5,4 1.4,3.4 0.8,3.2 0.7,2.4 0.4,2 0.3,1.5 0.3,0
1 | 9,9 9,10 | 6,8 6,9 | 5,7 5,8 | 2,6 2,7 | 4,6 4,7 | 4,8 4,9 | 8.5,9.1 8.5,10 | 3,7 3,8 | 2.7,7.8 2.3,7.1 | 2.5,6.1 2.5,6.9 | 1,5 1,6
    | 1.4,6.3 1.3,5.8 | 0.2,5 0.3,4.2 0.2,3.2 0.3,2.9 0.2,0 | 0.7,4.9 0.5,3.6
1.25 | 1,2.1 1.1,3 | 0.4,1 0.4,2 1,2 | 1,3 1,4 | 2,4 2,5 | 1,5 1,6 | 2,6 2,7 | 4,6 4,7 | 8,8 8,9 | 4,8 4,9 | 2.75,7 2.7,7.8
    | 2.7,7.8 2.3,7.1 | 2.5,6.1 2.5,6.9 | 0.2,5 0.3,4 | 0.1,3.1 0.2,3.9 | 0,1.7 0.2,1.1 0.2,0
"""  # drawn on the walls of SW.30.1 to SW.250.1: MPa, then lines by half stones from the toe and by courses, read off the database's maps


def crack_maps() -> list[tuple[float, list[list[tuple[float, float]]]]]:
    """The crack maps of the tests: stress [MPa] and lines [m] in the elevation of a wall that is pushed along +x."""
    maps: list[tuple[float, list[list[tuple[float, float]]]]] = []
    for row in CRACKS.splitlines():
        stress, *lines = row.split(" | ") if not row.startswith(" ") else ["", *row.split("| ")[1:]]
        points = [[tuple(map(float, point.split(","))) for point in line.split()] for line in lines]
        drawn = [[(WALL.length - 0.5 * WALL.unit * x, WALL.course * z) for x, z in line] for line in points]
        if stress:
            maps.append((float(stress), drawn))
        else:
            maps[-1][1].extend(drawn)
    return maps


def envelopes() -> list[Curve]:
    """The table of the tests."""
    rows = [line.split(" | ") for line in ENVELOPES.splitlines()]
    return [
        (name, np.array(u.split(), dtype=float), np.array(f.split(), dtype=float))
        for (name, u), (_, f) in zip(rows[::2], rows[1::2], strict=True)
    ]


def compute(folder: Path, say: Callable[[str], object]) -> CaseResults:
    """All four stresses: the limit load, and the push on elastic joints."""
    found = CaseResults()
    for stress, (young, peaks, places) in STRESSES.items():
        name = f"{stress:g} MPa"
        rigid, curve = WALL.tested(folder, f"*_{stress:g}", f"Dry wall at {name}", (stress, young, REACH), say)
        u, f = curve.envelope()
        mean, place = float(np.mean(peaks)), float(np.mean(places))
        most = 1e-3 * float(f.max())
        found.rows.append(CaseRow(f"{name}: peak, mean of {len(peaks)}", "kN", mean, 1e-3 * rigid, most))
        if place < 1e3 * REACH:
            found.rows.append(
                CaseRow(f"{name}: at {place:.3g} mm, where it was measured", "kN", mean, None, 1e-3 * at(curve, 1e-3 * place))
            )
        found.computed.append((f"{name}, elastic joints", 1e3 * u, 1e-3 * f))
        found.rows += crack_rows(folder / f"push_{stress:g}", name, [drawn for own, drawn in crack_maps() if own == stress], WALL)
    found.measured = envelopes()
    return found


CASE = LaboratoryCase(
    "dry_walls",
    "Dry walls of sawn sandstone under shear",
    "Lourenço, Oliveira, Roca & Orduña, J. Struct. Eng. 131(11), 2005; peaks as in the Stone Masonry Database of the EESD laboratory of "
    "EPFL (MIT)",
    "ten courses of 0.1 m, as the crack maps show (the database's height, 0.9 m, has nine), friction 0.62 (sawn stone in other papers), "
    "stiffness of bed and head joints E / 0.1 m with E of the tested walls, k_t = 0.4 k_n, beam of 100 kg held by nothing but the pusher, "
    "10 % of damping in the joints; cracks are joints open or slid by 1 mm at the end of the push",
    "friction; how the beam was held: at 0.15 MPa equilibrium about the toe allows 16.4 kN in this set-up, below both tests",
    "At 0.5 and 1.25 MPa within the scatter. At 0.15 MPa most of both curves, but no model without tension can reach their peaks. At "
    "1 MPa it is above both tests. Up to 0.5 MPa two thirds of the drawn cracks are found within a course, as two flights of steps; "
    "from 1 MPa on the tests crack and crush stones at the toe, which rigid stones cannot, and the pattern is another one. Joints that "
    "crush at the 56.8 MPa of prisms would take 2 % of the peak at 1.25 MPa: N / (t f_c) is 22 mm of 1 m.",
    compute,
)
