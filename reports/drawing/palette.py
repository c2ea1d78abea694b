"""The colours of pictures, pages and the model on the page: one of each meaning, for VTK, matplotlib, SVG, style sheet and WebGL.

Those of openings and slidings are scales (:mod:`reports.maps.crack_key`).
"""

from __future__ import annotations

INK, FAINT = "#23272b", "#5f666d"
# Okabe & Ito (2008): distinguishable by colour-blind readers
CURVES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
AXES = {"x": "#b2382c", "y": "#2f7d3b", "z": "#2b5fa8"}
GRADES = {"D0": "#eef0f2", "D1": "#fff3c4", "D2": "#fed98e", "D3": "#fe9929", "D4": "#cc4c02", "D5": "#7a2500"}
DARK = ("D4", "D5")  # of them those on which letters are white
PULLING, SLACK = "#6a1b7a", "#8d8d8d"  # ties: unlike openings, slidings and forces
STONE, FALLEN, PARTED, SHADOW = "#efe8da", "#c4a491", "#2b2b2b", "#e6e9ec"
SUPPORT, EDGE = "#a9adb0", "#4a4640"
OPENED, SLID = "#225ea8", "#d7301f"  # the states of a joint, beside PARTED
CRUSHED = "#c51b7d"  # of a joint that is shorter for good, unlike these, ties and forces
