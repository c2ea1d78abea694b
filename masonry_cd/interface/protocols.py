# SPDX-License-Identifier: GPL-3.0-or-later
"""What a plug-in has to be, by the group of its entry points; docs/plugins.md shows an example of each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np

from loads.motion import LoadTable, Part, RunGrid
from loads.readers.source import RawRecord, Request, Source
from masonry_cd.analysis.limit.part import Whole
from reports.files import Job
from structures.kind import StructureKind as StructureKind  # a value, of which ``build`` alone may stand for it
from structures.macro_elements.element import MacroElement


@runtime_checkable
class LoadKind(Protocol):
    """``masonry_cd.loads``: the model of the keys of a [[loads]] table, and what it adds to a run."""

    @property
    def table(self) -> type[LoadTable]:
        """The model."""

    @property
    def part(self) -> LoadPart:
        """What it adds."""


class LoadPart(Protocol):
    """The function of a :class:`LoadKind`."""

    def __call__(self, table: Any, grid: RunGrid, where: str, /) -> Part:
        """What a table adds to a run on a grid of times; messages begin with ``where``."""


@runtime_checkable
class RecordReader(Protocol):
    """``masonry_cd.readers``: a format of record files."""

    @property
    def loose(self) -> bool:
        """Whether it recognises much; of a package it does not matter."""

    def recognises(self, source: Source, /) -> bool:
        """Whether a file is in this format, by its content alone."""

    def read(self, source: Source, request: Request, /) -> RawRecord:
        """What stands in the file, in its own unit."""


@runtime_checkable
class Report(Protocol):
    """``masonry_cd.reports``: an output by name; ``reports.files.Output`` is one."""

    @property
    def files(self) -> Mapping[str, str]:
        """Names of what it writes into the folder of a run, and what each holds."""

    @property
    def write(self) -> Callable[[Job], Iterable[Path]]:
        """Writes it into ``job.folder``, from ``job.results`` alone, and returns the files."""


class LimitMechanism(Protocol):
    """``masonry_cd.mechanisms``: how a macro-element may give way as rigid bodies; the load factor is found by limit analysis."""

    def __call__(self, whole: Whole, element: MacroElement, direction: np.ndarray, /) -> Iterable[Sequence[np.ndarray]]:
        """Bodies, as numbers of blocks of the part each, once for every height or angle that is tried; the least factor counts.

        Args:
            whole: the structure: ``whole.assembly.centre`` (B, 3) [m] are the centres of mass.
            element: the part: ``element.blocks`` (N,) are the numbers of its blocks.
            direction: (3,) of the push.
        """


@runtime_checkable
class JointLaw(Protocol):
    """``masonry_cd.joint_laws``: a law beside contact and friction, for ``mc.Simulation(scene, law="name")``; ``mc.JointLaw`` is one."""

    @property
    def function(self) -> Callable[[np.ndarray, np.ndarray, np.ndarray, float, np.ndarray], Any]:
        """``f(opening, slip, history, step, stress)`` over K points at once, which fills the stresses (K, 3) [Pa]."""

    @property
    def stiffness(self) -> float:
        """The largest that it has anywhere [Pa/m]."""

    @property
    def history(self) -> int:
        """How many numbers a point remembers."""

    @property
    def joints(self) -> Sequence[int] | None:
        """The joints that have it; all of them where None."""
