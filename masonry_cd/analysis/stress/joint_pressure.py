# SPDX-License-Identifier: GPL-3.0-or-later
"""The largest mean pressure on a joint of a run that kept no stress."""

from __future__ import annotations

import numpy as np

from masonry_cd.io.results import Results


def largest_pressure(results: Results) -> tuple[float, int, float] | None:
    """Largest normal force of a joint over its area in the frames [Pa], the joint, and when [s]; None in a file without forces."""
    joints = results.joints
    if not joints.count or not results.has_joint_history("normal_force"):
        return None
    best, force = (-1.0, 0, 0.0), results.file["joints/normal_force"]
    for some in results.in_chunks(joints.count):
        pressure = np.nan_to_num(np.asarray(force[some], dtype=float)) / joints.area
        frame, joint = np.unravel_index(int(np.argmax(pressure)), pressure.shape)
        if pressure[frame, joint] > best[0]:
            best = (float(pressure[frame, joint]), int(joint), float(results.time[some.start + int(frame)]))
    return best
