# SPDX-License-Identifier: GPL-3.0-or-later
"""A comparison of runs in files: a table as CSV and Markdown, and its picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.csv_files import write_csv
from reports.compare.comparison import Comparison
from reports.compare.comparison_picture import comparison_picture

MISSING = "–"


def write_comparison(comparison: Comparison, folder: Path) -> list[Path]:
    """Write comparison.csv, comparison.md and comparison.png into a folder, which is made if need be."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"comparison.{ending}" for ending in ("csv", "md", "png")]
    write_csv(paths[0], comparison.header, ([name, unit, *map(_exact, values)] for name, unit, values in comparison.rows), digits=9)
    with replacing(paths[1]) as part:
        part.write_text(markdown(comparison), encoding="utf-8")
    comparison_picture(comparison, paths[2])
    return paths


def markdown(comparison: Comparison) -> str:
    """The table in Markdown, its columns aligned so that it reads well as plain text; lengths in millimetres."""
    cells = [comparison.header]
    for name, unit, values in comparison.rows:
        cells.append([name, "mm", *map(_millimetres, values)] if unit == "m" else [name, unit, *map(_short, values)])
    cells = [[cell.replace("|", "\\|") for cell in row] for row in cells]
    width = [max(len(row[k]) for row in cells) for k in range(len(cells[0]))]
    lines = ["| " + " | ".join(cell.ljust(w) for cell, w in zip(row, width, strict=True)) + " |" for row in cells]
    rule = "|" + "|".join("-" * (w + 2) for w in width) + "|"
    return "\n".join([lines[0], rule, *lines[1:]]) + "\n"


def _short(value: Any) -> str:
    """A cell for reading: three digits."""
    if value is None or (isinstance(value, float) and np.isnan(value)):
        return MISSING
    if isinstance(value, (float, np.floating)):
        return f"{value:.3g}"
    return str(value)


def _millimetres(value: float | None) -> str:
    """A cell of a length [m] for reading; what is below a micrometre is as good as nothing, as on the page."""
    if value is None or np.isnan(value):
        return MISSING
    if 0.0 < abs(value) < 1e-6:
        return "<0.001"
    return f"{1e3 * value:.0f}" if abs(value) >= 1.0 else f"{1e3 * value:.3g}"


def _exact(value: Any) -> Any:
    """A cell for computing: words of a scene as they are."""
    return value if value is None or isinstance(value, float) else str(value)
