# SPDX-License-Identifier: GPL-3.0-or-later
"""A run in a folder: its result file, opened on first use."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path

import numpy as np

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.interface.sealed import Sealed
from masonry_cd.interface.structure import Structure
from masonry_cd.interface.temporary import TemporaryFolder
from masonry_cd.io.results import Results
from reports.damage import thresholds_of
from reports.outputs import frame_at
from reports.settings import Report, report_of

RESULTS = "result.h5"


class OpenRun(Sealed):
    """The open results that tables, exports and pictures of a run share."""

    folder: Path
    keeper: TemporaryFolder | None
    title: str
    time: np.ndarray

    def __init__(self, folder: Path, keeper: TemporaryFolder | None = None) -> None:
        self.folder = Path(folder)
        """Where its files are."""
        self.keeper = keeper  # of a temporary folder
        self._sums = True  # the first look at the file is at all of it
        with self.results() as found:
            self.title = found.title
            """Title of the scene."""
            self.time = np.asarray(found.time, dtype=float)
            """(F,) of its frames [s]."""
            self._sums = bool(found.words)
            self._words = found.words

    @contextmanager
    def results(self) -> Iterator[Results]:
        """The result file, open, for what the tables do not give: ``with run.results() as results: ...``."""
        with Results.open(self.folder / RESULTS, sums=self._sums) as found:
            yield found

    @contextmanager
    def _at(self, time: float | None) -> Iterator[tuple[Results, int]]:
        """The result file, open, and the frame next to a time [s], the last one where none is given.

        Raises:
            InputError: a time outside the run.
        """
        with self.results() as found:
            yield found, frame_at(found, time) % found.frames

    @cached_property
    def structure(self) -> Structure:
        """The blocks as they were built."""
        with self.results() as found:
            return Structure(found.blocks)

    @cached_property
    def _report(self) -> Report:
        """The settings of the reports."""
        with self.results() as found:
            return report_of(found.tables)

    @property
    def _thresholds(self) -> Thresholds:
        """From which openings and slips a joint counts as open or slid."""
        return thresholds_of(self._report)
