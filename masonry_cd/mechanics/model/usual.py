# SPDX-License-Identifier: GPL-3.0-or-later
"""Usual values of masonry and its ties, where keys of several tables are such a quantity; each stands in the annotation of its key."""

from __future__ import annotations

from masonry_cd.foundation.units import Usual

LENGTHS = ("mm", "cm")  # units that are easily meant where metres are required; below, in place of Pa, N and m/s2
MODULI, STRENGTHS = ("MPa", "GPa"), ("MPa", "kPa")
FORCES = ("kN", "MN")
ACCELERATIONS = ("g", "cm/s2")

DENSITY = Usual(400.0, 3500.0, "masonry has 400 (foamed) to 3500 kg/m3 (basalt)", ("t/m3", "kN/m3"))
FRICTION = Usual(0.0, 1.2, "dry joints have 0.3 to 1.2; an angle is given by its tangent")
YOUNG = Usual(1e7, 2.5e11, "from adobe, 0.01 GPa, to steel, 210 GPa", MODULI)
COMPRESSION = Usual(1e5, 5e8, "from rubble, 0.1 MPa, to the hardest stone, 500", STRENGTHS)
BOND = Usual(1e3, 2e7, "mortar and bricks have 0.001 to 20 MPa", STRENGTHS)
SPLITTING = Usual(1e5, 5e7, "stone splits at 0.5 to 25 MPa, and shears at some twice that", STRENGTHS)
FRACTURE = Usual(0.1, 1e3, "mortar joints take 1 to 200 N/m, stone up to some 200", ("N/mm",))
DAMPING = Usual(0.0, 0.5, "a share of critical is given, 0.05 for 5 %, and masonry has 0.01 to 0.1")

TIE_MODULUS = Usual(1e9, 5e11, "timber has 10 GPa, steel 210 GPa, carbon fibre at most 500", MODULI)
DIAMETER = Usual(3e-4, 0.4, "from wires of 0.3 mm to beams of 0.4 m", LENGTHS)
SECTION = Usual(1e-7, 0.25, "from wires of 0.1 mm2 to beams of 0.25 m2", ("cm2", "mm2"))
YIELDING = Usual(2e-5, 2e-2, "ties and anchorages yield at stretches of 2e-5 to 2e-2", FORCES, over="E A of the tie")
TENSION = Usual(1e-6, 2e-2, "a tenth of a degree of warmth stretches a tie by 1e-6", FORCES, over="E A of the tie")
