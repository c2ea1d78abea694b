# SPDX-License-Identifier: GPL-3.0-or-later
"""The assumptions on which the answer of a scene rests, by ``masonry-cd assess``: a verdict, a table of runs, a tornado chart, a page."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_cd.analysis.assessment.assessment import read_assessment
from masonry_cd.analysis.assessment.verdict import heading, lines_of, to_pin_down, verdict, warnings_of
from masonry_cd.analysis.outputs import ASSESS, units_in
from masonry_cd.app.result import said
from masonry_cd.foundation.errors import InputError
from masonry_cd.interface.plots import Page, drawn
from masonry_cd.interface.returned import closing_as_html, returned
from masonry_cd.interface.scenes import Scene, scene
from masonry_cd.interface.sealed import Sealed
from masonry_cd.interface.studies import warn, without_main
from masonry_cd.interface.tables import frame_of_rows
from masonry_cd.interface.temporary import TemporaryFolder, place_of
from reports.assess.outputs import COLUMNS, cells_of, index_rows

if TYPE_CHECKING:
    from pandas import DataFrame
    from PIL.Image import Image

UNITS = {**units_in(ASSESS), "seconds": "s"}


class Assessment(Sealed):
    """Findings of an assessment. Made by :func:`masonry_cd.assess`; ``print`` shows the closing lines of the command line."""

    folder: Path
    keeper: TemporaryFolder | None

    def __init__(self, folder: Path, keeper: TemporaryFolder | None = None) -> None:
        self.folder = Path(folder)
        """Where its files are."""
        self.keeper = keeper  # of a temporary folder
        self._found = read_assessment(self.folder)

    @property
    def title(self) -> str:
        """Title of the scene."""
        return self._found.title

    @property
    def verdict(self) -> str:
        """``between D2 and D4; joint stiffness decides; time step and tolerance do not``; empty where the base case has no result."""
        return verdict(self._found) if self._found.base.row.done else ""

    @property
    def pin_down(self) -> list[str]:
        """Assumptions on the structure that change the answer beyond chance, the weightiest first."""
        return [one.name for one in to_pin_down(self._found)] if self._found.base.row.done else []

    @cached_property
    def table(self) -> DataFrame:
        """A row per run: what it changes, how it ended, its answers in SI units; ``attrs["units"]`` says which."""
        rows = []
        for member in self._found.members:
            name, level = heading(member)
            rows.append({"assumption": name, "level": level} | dict(zip(COLUMNS, cells_of(member), strict=True)))
        table = frame_of_rows(rows, "assumption")
        table.attrs["units"] = dict(UNITS)
        return table

    @cached_property
    def bars(self) -> DataFrame:
        """A row per assumption and answer: low and high of its bar, reference, what chance alone spans, and whether it shows."""
        rows = [{"assumption": name, "answer": answer} | bar for name, bars in self._found.bars().items() for answer, bar in bars.items()]
        return frame_of_rows(rows, "assumption")

    @cached_property
    def indices(self) -> DataFrame:
        """A row per answer and property of runs in which all vary at once: Sobol indices, their bands, and the surrogate's error."""
        return frame_of_rows(index_rows(self._found), "answer")

    @property
    def lines(self) -> list[str]:
        """The verdict, what to pin down first, what chance does, what was not varied: the closing lines of the command line."""
        return lines_of(self._found)

    @property
    def warnings(self) -> list[str]:
        """Runs that have no result, that missed the tolerance, that are not graded."""
        return warnings_of(self._found)

    def plot(self) -> Image:
        """The tornado chart.

        Raises:
            InputError: the base case has no result.
        """
        from reports.assess.picture import draw_tornado

        if not self._found.base.row.done:
            raise InputError("", self.lines[0])
        return drawn(lambda path: draw_tornado(self._found, path))

    def page(self) -> Page:
        """assess.html with all of it, which needs no network; table and chart in the folder are written again with it."""
        from reports.assess.outputs import PAGE, write_assessment

        write_assessment(self.folder)
        return Page(self.folder / PAGE)

    def __str__(self) -> str:
        return "\n".join(self.lines)

    def __repr__(self) -> str:
        return f'<Assessment "{self.title}": {self.verdict or "no verdict"}>'

    def _repr_html_(self) -> str:
        return closing_as_html(self.lines, self.warnings)


def assess(
    source: str | os.PathLike[str] | Mapping[str, Any] | Scene,
    folder: str | os.PathLike[str] | None = None,
    *,
    all_pairs: bool = False,
    at_once: bool = False,
    workers: int | None = None,
    progress: bool = True,
    retry: bool = False,
    force: bool = False,
) -> Assessment:
    """Vary the assumptions of a scene one at a time, and compare with an ensemble that shows the scatter by chance.

    Args:
        source: anything that :func:`masonry_cd.scene` takes; its table ``[assess]`` may give ranges of its own.
        folder: for the results, created if missing; runs that have ended there are not repeated. By default a temporary one that lasts as
            long as the assessment that is returned.
        all_pairs: two levels of every two assumptions as well.
        at_once: runs in which all properties of the structure vary at once as well, for Sobol indices.
        workers: processes of this machine; all cores when not given.
        progress: say on standard error how far it is.
        retry: make runs again that failed or timed out.
        force: begin again, whatever the folder holds.

    Runs are made in processes of their own; a script needs no guard for them. Ctrl-C ends it: what is returned holds the runs that have
    ended, and the same call continues it. Warnings are shown as :class:`RunWarning`.

    Raises:
        InputError: anything wrong with the scene, or the folder of another one.

    >>> import masonry_cd as mc
    >>> wall = {"structure": {"kind": "wall", "length": 2.0, "height": 1.0, "course_height": 0.5, "thickness": 0.4}}
    >>> wall |= {"material": {"density": 2000.0, "friction": 0.5}, "limit": {"push": "y"}, "run": {"dt": 1e-3, "duration": 1e-3}}
    >>> found = mc.assess(wall, workers=1, progress=False)
    >>> found.table.loc["friction", ["level", "status"]].values.tolist()
    [['0.4', 'done'], ['0.6', 'done']]
    """
    from masonry_cd.studies.assess.command import assess as command
    from masonry_cd.studies.assess.plan import AssessPlan
    from masonry_cd.studies.study.study_case import StudyOptions

    place, keeper = place_of(folder)
    plan = AssessPlan(scene(source).checked, all_pairs, at_once)
    with without_main():
        result = command(plan, place, StudyOptions(plan.where(workers), retry, force, quiet=not progress, warn=warn), said(progress))
    returned(result)
    return Assessment(place, keeper)
