# SPDX-License-Identifier: GPL-3.0-or-later
"""Damage of each joint in the runs of a study, read from the files that they left; only runs on the joints of the first count."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.fragility.folder import StudyResults
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.files import size_of_regular

MOST_CELLS = 100_000_000  # runs times joints that are held for the median, 0.4 GB
KEYS = ("opening", "sliding", "lost", "shape")


@dataclass(frozen=True, eq=False)
class JointRuns:
    """Damage of the same J joints in n runs."""

    rows: np.ndarray  # (n,) of the table
    opening: np.ndarray  # (n, J) float32, largest [m]; inf where the joint was lost
    slid: np.ndarray  # (n, J) bool
    lost: np.ndarray  # (n, J) bool
    left_out: int  # runs on other joints

    def opened(self, thresholds: Thresholds) -> np.ndarray:
        """(n, J) bool."""
        return self.opening >= thresholds.opened


def read_joint_runs(study: StudyResults, count: int, thresholds: Thresholds) -> JointRuns | None:
    """Read joints/*.npz of the runs that are done; the first in the table that has one says which joints are meant.

    Args:
        study: the study.
        count: number of joints of the reference.
        thresholds: of sliding.

    Raises:
        InputError: a file is broken, or has another number of joints.
    """
    rows, opening, slid, lost, shape, left_out = [], [], [], [], None, 0
    for row in np.flatnonzero(study.done):
        path = study.folder / "joints" / f"{study.text('run')[row]}.npz"
        if not path.exists():
            continue
        found = _read(path)
        shape = int(found["shape"]) if shape is None else shape
        if int(found["shape"]) != shape:
            left_out += 1
            continue
        if found["opening"].shape != (count,):
            raise InputError(path, f"{len(found['opening'])} joints, and reference/result.h5 has {count}")
        rows.append(row)
        gone = found["lost"].astype(bool)
        opening.append(np.where(gone, np.float32(np.inf), found["opening"].astype(np.float32)))
        slid.append((found["sliding"] >= thresholds.slid) & ~gone)
        lost.append(gone)
        if len(rows) * count > MOST_CELLS:
            break
    if not rows:
        return None
    return JointRuns(np.array(rows), np.array(opening), np.array(slid), np.array(lost), left_out)


def _read(path: Path) -> dict[str, np.ndarray]:
    """One of them."""
    try:
        if not size_of_regular(path):
            raise EOFError("the file is empty")
        with np.load(path) as file:
            found = {key: file[key] for key in KEYS}
    except Exception as failure:  # damaged bytes make the readers of zip files and arrays raise whatever they like
        raise InputError(path, f"cannot be read: {failure}") from None
    if not found["opening"].shape == found["sliding"].shape == found["lost"].shape or found["opening"].ndim != 1:
        raise InputError(path, "opening, sliding and lost differ in their number of joints")
    return found


def median(opening: np.ndarray) -> np.ndarray:
    """(J,) lower median of openings (n, J), infinite ones included."""
    return np.asarray(np.sort(opening, axis=0)[(len(opening) - 1) // 2], dtype=float)
