# SPDX-License-Identifier: GPL-3.0-or-later
"""The types of what a plug-in or a function of Python adds; docs/plugins.md has their contracts, and an example of each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, Protocol

import numpy as np

from loads.motion import LoadAction, LoadKind, RunGrid
from loads.readers.source import Reader as RecordReader
from masonry_cd.analysis.limit.part import Whole
from masonry_cd.interface.joint_law import JointLaw
from masonry_cd.interface.own_forces import Now
from masonry_cd.mechanics.dynamics.own_friction import FrictionLaw, SlidingContacts
from masonry_cd.mechanics.friction.problem import FrictionProblem, LocalProblem, Problem, Solution
from masonry_cd.mechanics.solvers import Options, Solver
from reports.files import Output as Report
from structures.kind import StructureKind  # of which ``build`` alone may stand for it
from structures.macro_elements.element import MacroElement

__all__ = [
    "FrictionLaw",
    "FrictionProblem",
    "JointLaw",
    "LimitMechanism",
    "LoadKind",
    "LoadPart",
    "LocalProblem",
    "Now",
    "Options",
    "Problem",
    "RecordReader",
    "Report",
    "SlidingContacts",
    "Solution",
    "Solver",
    "StructureKind",
]

LoadPart = Callable[[Any, RunGrid, str], LoadAction]
"""The function of a :class:`LoadKind`: what a table adds to a run on a grid of times; messages begin with the place of the table."""


class LimitMechanism(Protocol):
    """``masonry_cd.mechanisms``: how a macro-element may give way as rigid bodies; the load factor is found by limit analysis."""

    def __call__(self, whole: Whole, element: MacroElement, direction: np.ndarray, /) -> Iterable[Sequence[np.ndarray]]:
        """Bodies, as numbers of blocks of the part each, once for every height or angle that is tried; the least factor counts.

        Args:
            whole: the structure: ``whole.assembly.centre`` (B, 3) [m] are the centres of mass.
            element: the part: ``element.blocks`` (N,) are the numbers of its blocks.
            direction: (3,) of the push.
        """
