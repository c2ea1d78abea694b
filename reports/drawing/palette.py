# SPDX-License-Identifier: GPL-3.0-or-later
"""The colours of pictures, pages and the model on the page: one of each meaning, for VTK, matplotlib, SVG, style sheet and WebGL."""

from __future__ import annotations

INK, FAINT = "#23272b", "#5f666d"
# Okabe & Ito (2008): distinguishable by colour-blind readers
CURVES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
ENERGIES = (
    "#7f6a4a",
    "#c9b79c",
    CURVES[0],
    "#5f666d",
    *CURVES[1:6],
)  # where it went: radiation, ground, crushing, bond, damping ... kinetic
AXES = {"x": "#b2382c", "y": "#2f7d3b", "z": "#2b5fa8"}
GRADES = {"D0": "#eef0f2", "D1": "#fff3c4", "D2": "#fed98e", "D3": "#fe9929", "D4": "#cc4c02", "D5": "#7a2500"}
DARK = ("D4", "D5")  # of them those on which letters are white
PULLING, SLACK = "#6a1b7a", "#8d8d8d"  # ties: unlike openings, slidings and forces
STONE, FALLEN, PARTED, SHADOW = "#efe8da", "#c4a491", "#2b2b2b", "#e6e9ec"
SUPPORT, EDGE = "#a9adb0", "#4a4640"
FILL = "#8f7a5c"  # of a bridge, darker than stones
OPENED, SLID = "#225ea8", "#d7301f"  # the states of a joint, next to PARTED
CRACKED = "#1a7f37"  # of a crack within a stone
CRUSHED = "#c51b7d"  # of a joint that is shorter for good, unlike these, ties and forces
# of groups: light enough for black edges, apart in hue and in grey; supports are always the grey one
GROUPS = ("#e6d9bd", "#9fc3dd", "#e9a77c", "#b9d3a4", "#cbb3d9", "#f3dc84", "#8fb8b0", "#dba3ad", "#b7a58a", "#c6d9ea")
STRONG = "#1b2a6b"  # joints that a map points out
THRUST = "#5a146e"  # the line of thrust
STANDS, MOVES, REST = "#ddd8cc", "#f0d9a8", "#9aa0a6"  # blocks in a mechanism, and their outlines as built
AT_WORK = {"hinge": "#d55e00", "slide": "#0072b2", "hinge and slide": "#cc79a7", "open": "#009e73"}  # joints in a mechanism
FAULTY, SOUND = "#c2410c", "#c9ced1"  # blocks that are refused, and the others
OPENING, SLIDING = ("YlGnBu", 0.4, 1.0), ("OrRd", 0.4, 1.0)  # colour maps of joints, and the part of each in use
PRESSED = ("YlOrRd", 0.0, 0.9)  # of a compression: pale to dark, distinguishable in grey print
SHARES = ("YlOrRd", 0.18, 1.0)  # of a probability
DISPLACED = "viridis"  # of a displacement: orderly also in grey and for colour-blind eyes
