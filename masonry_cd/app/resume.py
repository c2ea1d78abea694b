# SPDX-License-Identifier: GPL-3.0-or-later
"""Which checkpoint a run goes on from, and whether it may: nothing is changed before all of it is checked."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.app.checkpoint_checks import check_content
from masonry_cd.app.inputs import digests, require_same
from masonry_cd.foundation.errors import InputError
from masonry_cd.io import checkpoint
from masonry_cd.io.result_writer import require_rows
from masonry_cd.io.results import Results
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper

if TYPE_CHECKING:
    from masonry_cd.app.case import Case


def choose(case: Case, stepper: Stepper, results: Path, saved: Path) -> str:
    """Put the last checkpoint that can be gone on from in its place; return a line where it is not the last that was taken, or "".

    Args:
        case: as it is now.
        stepper: at its start.
        results: of the run.
        saved: the last checkpoint.

    Raises:
        InputError: other inputs than those of the results, or no checkpoint that can be gone on from. Nothing is changed.
    """
    with Results.open(results) as found:
        if found.scene != case.scene.text:
            raise InputError(results, "made by another scene; resume with the same scene file and the same --set")
        require_same(digests(case), found.inputs, results)

        def fits(arrays: Mapping[str, np.ndarray], numbers: Mapping[str, Any]) -> None:
            check_content(arrays, numbers, stepper, case.joints.count, case.scene.stress)
            require_rows(found, numbers["rows"], numbers["mark"])

        return checkpoint.mend(saved, fits)
