# SPDX-License-Identifier: GPL-3.0-or-later
"""A run for ParaView: what ``masonry-cd export`` writes."""

from __future__ import annotations

from pathlib import Path

from masonry_cd.app.result import Result
from masonry_cd.io.results import Results
from reports import outputs, paraview
from reports.settings import report_of


def export(folder: Path, form: str = "vtkhdf", output: Path | None = None) -> Result[None]:
    """Write a run for ParaView.

    Args:
        folder: of the run.
        form: vtkhdf or pvd.
        output: folder for the files; ``paraview`` in that of the run when not given.

    Raises:
        InputError: no run, or no such format.
    """
    with Results.open(folder / "result.h5") as results:
        thresholds = outputs.thresholds_of(report_of(results.tables))
        written = paraview.export(results, output or folder / "paraview", form, thresholds)
        return Result(None, warnings=results.words, written=written)
