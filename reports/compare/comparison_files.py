"""A comparison of runs in files: a table as CSV and Markdown, and its picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.atomic import replacing
from masonry_cd.csv_files import write_csv
from reports.compare.comparison import Comparison
from reports.compare.comparison_picture import comparison_picture

MISSING = "–"


def write_comparison(comparison: Comparison, folder: Path) -> list[Path]:
    """Write comparison.csv, comparison.md and comparison.png into a folder, which is made if need be."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"comparison.{ending}" for ending in ("csv", "md", "png")]
    write_csv(paths[0], comparison.header, ([name, unit, *map(_exact, values)] for name, unit, values in comparison.rows))
    with replacing(paths[1]) as part:
        part.write_text(markdown(comparison), encoding="utf-8")
    comparison_picture(comparison, paths[2])
    return paths


def markdown(comparison: Comparison) -> str:
    """The table in Markdown, its columns aligned so that it reads well as plain text."""
    cells = [comparison.header, *([name, unit, *map(_short, values)] for name, unit, values in comparison.rows)]
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


def _exact(value: Any) -> str:
    """A cell for computing: nine digits, empty where unknown."""
    if value is None or (isinstance(value, float) and np.isnan(value)):
        return ""
    return f"{value:.9g}" if isinstance(value, (float, np.floating)) else str(value)
