# SPDX-License-Identifier: GPL-3.0-or-later
"""What a limit analysis finds, and how sure it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


class Unbounded(RuntimeError):
    """No answer: the programme has none, or the solver found none. The message is the solver's."""


@dataclass(frozen=True, eq=False)
class Optimum:
    """The best that a solver found, in the units of the problem."""

    factor: float
    force: np.ndarray  # (P, m) r
    bars: np.ndarray  # (T,) N
    velocity: np.ndarray  # (unknowns,) v
    iterations: int
    method: str
    stopped: str = ""  # the solver's word where it ended before its tolerance
