# SPDX-License-Identifier: GPL-3.0-or-later
"""A code and its declaration; a module of ``codes`` lists its own in ``CODES``, by the name that ``limit.check.code`` has for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from masonry_cd.analysis.code_check.ground import Ground
from masonry_cd.analysis.code_check.steps import CodeCheck
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.limit.oscillator import Oscillator


@dataclass(frozen=True)
class Code:
    """A code."""

    check: Callable[[CheckTable, Oscillator, Ground], CodeCheck]
    height: str  # the clause by which the height of a mechanism counts
    limit_states: tuple[str, ...] = ()  # of the key limit_state; empty: the code knows none
    by_displacements: tuple[str, ...] = ()  # those of them that it checks by displacements, too
    storeys: bool = False  # the mode of a building takes part by its storeys, and is damped
    parts_vibrate: str = ""  # where element_period applies: "anywhere", "above the ground", nowhere where empty
    raised: Callable[[CheckTable, Ground, np.ndarray, float], tuple[np.ndarray, np.ndarray]] | None = None
    """Acceleration [m/s2] and displacement [m] required at the height of a table, (n,) each, of periods (n,) and a damping."""
    left_open: Callable[[CheckTable], tuple[str, ...]] = lambda _: ()  # what its clauses leave to the engineer, and what was taken
