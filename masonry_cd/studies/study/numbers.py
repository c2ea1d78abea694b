# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers of a run for its row, and the arrays of its joints for maps of probability."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.outputs import STUDY, numbers_in, values_in
from masonry_cd.analysis.outputs.measured import Measured
from masonry_cd.analysis.outputs.values import finite, grade_number
from masonry_cd.app.scene import Scene
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.mechanics.model.joints import Joints
from reports.damage import damage_settings

QUANTITIES = tuple(numbers_in(STUDY))


def of_run(results_file: Path, summary: Summary, scene: Scene) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
    """The numbers of a run that is done, those of its parts, and its joints' arrays.

    Args:
        results_file: result.h5 of the run.
        summary: that of the run.
        scene: whose ``[report]`` says what counts as damage.

    Returns:
        numbers by the columns of ``QUANTITIES``, with the residual drift; by part {"grade_number", "drift"}; and
        opening, sliding (J,) float32 [m], the largest over the run, lost (J,) bool, and ``shape``, a digest of the joints at rest.
    """
    with Results.open(results_file) as results:
        run = Measured(results, damage_settings(scene.report), summary)
        found, table = values_in(STUDY, run) | {"residual_drift": finite(run.whole["residual_drift"])}, run.table
        arrays = {
            "opening": table.max_opening.astype(np.float32),
            "sliding": table.max_sliding.astype(np.float32),
            "lost": table.state == "separated",
            "shape": _digest(results.joints),
        }
        rows = run.damage.parts[:-1]
    parts = {row["part"]: {"grade_number": grade_number(row["grade"]), "drift": finite(row["max_drift"])} for row in rows}
    return found, parts, arrays


def _digest(joints: Joints) -> int:
    """A number that joints of the same blocks and corners share."""
    digest = hashlib.sha256()
    for array in (joints.block_a, joints.block_b, joints.polygon_start, joints.polygon):
        digest.update(np.ascontiguousarray(array).tobytes())
    return int.from_bytes(digest.digest()[:7], "little")
