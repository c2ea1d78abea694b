# SPDX-License-Identifier: GPL-3.0-or-later
"""Repeats a case: its scenes and runs in a folder, its table, and its curves next to the measured ones."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from masonry_cd.app.result import Result, Say
from masonry_cd.foundation import own_files
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.json_files import write_json
from masonry_cd.studies.laboratory.case import CaseResults, CaseRow, LaboratoryCase
from masonry_cd.studies.laboratory.cases import CASES
from reports.drawing.figure import save
from reports.laboratory import curves_figure

TABLE, SAMPLES, FIGURE = "table.json", "samples.json", "curves.svg"
DRAWN = 300  # points of a curve: figures of the page stay small


def case_named(name: str) -> LaboratoryCase:
    """The case of a name.

    Raises:
        InputError: there is none.
    """
    if name not in CASES:
        raise InputError(f'"{name}"', f"no such case{suggest(name, CASES)}; cases: {', '.join(CASES)}")
    return CASES[name]


def validate(name: str, folder: Path, say: Say) -> Result[CaseResults]:
    """Repeat a case.

    Raises:
        InputError: no such case.
    """
    case = case_named(name)
    own_files.begin(folder, (TABLE, SAMPLES, FIGURE))
    found = case.compute(folder, say)
    table, figure = folder / TABLE, folder / FIGURE
    write_json(table, [row._asdict() for row in found.rows])
    write_json(folder / SAMPLES, [sample.as_dict() for sample in found.samples])
    across, up = found.axes
    drawn = curves_figure(_thinned(found.computed), found.measured, case.title, ((across, 1.0), (up, 1.0)), found.points)
    save(drawn, figure)
    return Result(found, [case.title, f"source: {case.source}", *table_lines(found)], written=[table, folder / SAMPLES, figure])


def table_lines(found: CaseResults) -> list[str]:
    """The rows as text."""
    return [
        f"{row.quantity}: {row.measured:.4g} {row.unit} measured or by others; "
        + ", ".join(f"{word} {value:.4g} ({value / row.measured:.2f})" for word, value in _computed(row))
        for row in found.rows
    ] + [sample.line for sample in found.samples]


def _computed(row: CaseRow) -> list[tuple[str, float]]:
    return [(word, value) for word, value in (("rigid", row.rigid), ("elastic", row.elastic)) if value is not None]


def _thinned(curves: Sequence[tuple[str, np.ndarray, np.ndarray]]) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Curves of DRAWN points at most."""
    out = []
    for name, x, y in curves:
        kept = np.unique(np.linspace(0, len(x) - 1, min(len(x), DRAWN)).round().astype(int))
        out.append((name, x[kept], y[kept]))
    return out
