"""The numbers of a run for its row, and the arrays of its joints for maps of probability."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.grades import NAMES
from masonry_cd.analysis.damage.joint_damage import displacements, fallen, joint_damage
from masonry_cd.analysis.damage.verdict import NOT_GRADED
from masonry_cd.app.scene import Scene
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.joints import Joints
from reports.damage.joint_files import thresholds_of
from reports.outputs import damage_of

FARTHEST, EVENLY = 20, 20  # frames at which drifts are looked at: all of them would take a fifth of the time of a run of 30 blocks
QUANTITIES = (
    "max_opening", "max_sliding", "displacement_max", "residual_opening", "drift", "collapsed_blocks", "collapse_time", "grade",
    "grade_number", "load_factor", "steps", "steps_missed", "error_max", "provisional",
)  # fmt: skip


def of_run(results_file: Path, summary: Mapping[str, Any], scene: Scene) -> tuple[dict[str, Any], dict[str, Any]]:
    """The numbers of a run that is done, and its joints' arrays.

    Args:
        results_file: result.h5 of the run.
        summary: that of the run.
        scene: whose ``[report]`` says what counts as damage.

    Returns:
        numbers by the columns of ``QUANTITIES``, with ``parts``, {name: {"grade_number", "drift"}}; and
        opening, sliding (J,) float32 [m], the largest over the run, lost (J,) bool, and ``shape``, a digest of the joints at rest.
    """
    with Results.open(results_file) as results:
        thresholds = thresholds_of(scene.report)
        damage = damage_of(results, scene.report, _telling_frames(results))
        table = joint_damage(results, thresholds)
        shape = _digest(results.joints)
        collapse_time = _first_fall(results, thresholds) if summary["collapsed_blocks"] else None
    *parts, whole = damage.parts
    found = {
        "max_opening": float(table.max_opening.max(initial=0.0)),
        "residual_opening": float(table.residual_opening[table.state != "separated"].max(initial=0.0)),
        "max_sliding": float(table.max_sliding.max(initial=0.0)),
        "displacement_max": float(summary["displacement_max"]),
        "drift": _finite(whole["max_drift"]),
        "collapsed_blocks": int(summary["collapsed_blocks"]),
        "collapse_time": collapse_time,
        "grade": whole["grade"],
        "grade_number": _number(whole["grade"]),
        "load_factor": summary.get("load_factor", {}).get("given_way"),
        "steps": int(summary["steps"]),
        "steps_missed": int(summary["solver"]["steps_missed"]),
        "error_max": float(summary["solver"]["error_max"]),
        "provisional": summary["provisional"],
    }
    found["parts"] = {row["part"]: {"grade_number": _number(row["grade"]), "drift": _finite(row["max_drift"])} for row in parts}
    arrays = {
        "opening": table.max_opening.astype(np.float32),
        "sliding": table.max_sliding.astype(np.float32),
        "lost": table.state == "separated",
        "shape": shape,
    }
    return found, arrays


def _telling_frames(results: Results) -> np.ndarray:
    """Frames at which damage is looked at: the last where drifts are known over all steps.

    Else those in which a block is farthest from its place and some evenly between as well.
    """
    if results.peaks_of_steps:
        return np.array([results.frames - 1])
    moved = displacements(results)
    evenly = np.linspace(0, len(moved) - 1, min(len(moved), EVENLY)).round().astype(int)
    return np.unique([*np.argsort(-moved, kind="stable")[:FARTHEST], *evenly, len(moved) - 1])


def _first_fall(results: Results, thresholds: Thresholds) -> float:
    """Time of the first frame in which a block has fallen, where one has at the end [s]; a fallen block stays one."""
    low, high = 0, results.frames - 1
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if fallen(results, thresholds, middle).any() else (middle + 1, high)
    return float(results.time[high])


def _number(grade: str) -> int | None:
    """The number of a grade; None where the run cannot be relied on, so that it was not graded."""
    return None if grade == NOT_GRADED else NAMES.index(grade)


def _finite(value: float) -> float | None:
    """A number, or nothing where there is none."""
    return float(value) if np.isfinite(value) else None


def _digest(joints: Joints) -> int:
    """A number that joints of the same blocks and corners share."""
    digest = hashlib.sha256()
    for array in (joints.block_a, joints.block_b, joints.polygon_start, joints.polygon):
        digest.update(np.ascontiguousarray(array).tobytes())
    return int.from_bytes(digest.digest()[:7], "little")
