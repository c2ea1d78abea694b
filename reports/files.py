"""The files that a run may leave in its folder, each declared once: its name, and what it holds.

The command that runs a scene clears and lists them, the page names those it carries, and docs/outputs.md has them all. A further report
declares its own (:mod:`reports.extra`).
"""

from __future__ import annotations

from reports.extra import EXTRA

FILES = {
    "result.h5": "all that the run recorded, frame by frame and step by step, with its blocks and its scene",
    "joints.csv": "every joint: largest and last opening and sliding, rotation, contact lost, state",
    "summary.json": "the run in numbers, the verdict on it among the first",
    "damage.csv": "every part: counts, largest and last values, drift, mechanism, grade with its reason",
    "damage_history.csv": "every part over time",
    "hinges.csv": "joints that were hinges, and where they touched",
    "drift.csv": "displacement and drift of every part, level by level",
    "damage.json": "the tables of damage in one document, with all thresholds",
    "damage_shocks.csv": "every part after each shock",
    "ties.csv": "every tie: largest tension and when, tension at the end, from when it yielded",
    "force_displacement.csv": "every push by displacement, step by step: displacement, reaction, inertia left in it",
    "push_cycles.csv": "every cycle of a push: dissipated energy, equivalent damping",
    "force_displacement.png": "the curves of pushes by displacement",
    "points.csv": "the motion of the points that the scene watches",
    "joint_gauges.csv": "the joints that the scene watches: opening, slip, forces, compressed depth",
    "cracks.csv": "the gauges between two points that the scene names",
    "supports.csv": "the reaction of every support over time",
    "gauges.png": "the histories of watched points, joints and gauges",
    "crack_map.png": "the structure at the end, its joints coloured by opening and sliding",
    "crack_map.svg": "that map as polygons",
    "crack_map.pdf": "that map as polygons",
    "crack_map.gif": "that map through the run",
    "report.html": "the page that shows the run to any browser",
    "report.pdf": "the page on A4",
    "stress.csv": "every block: largest mean compression and tension and when, its stress at the end, the share of its strength",
    "joint_stress.csv": "every joint: largest compression at its edge, largest normal force",
    "element_stress.csv": "every element of meshed blocks: largest compression and tension and when, stress at the end",
    "stress_map.png": "the structure, its blocks coloured by their largest compression",
    "stress_map.svg": "that map as polygons",
    "stress_map.pdf": "that map as polygons",
}


def known_files() -> dict[str, str]:
    """All of them with what they hold, those of further reports last."""
    return FILES | {name: report.meaning for report in EXTRA.values() for name in report.files}
