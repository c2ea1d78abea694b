# SPDX-License-Identifier: GPL-3.0-or-later
"""What a measurement of error against run time comes to: rows, a diagram, and both in words; and its files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.csv_files import write_rows
from masonry_cd.foundation.text_tables import markdown
from masonry_cd.studies.accuracy.picture import Diagram, draw

Row = Mapping[str, Any]
CSV, MARKDOWN, PICTURE = OUTPUTS = ("accuracy.csv", "accuracy.md", "accuracy.png")


@dataclass(frozen=True)
class Measurement:
    """What was measured; rows of one table have equal keys."""

    heading: str  # of accuracy.md
    rows: Sequence[Row]  # of accuracy.csv
    read: Sequence[Row]  # of accuracy.md
    lines: Sequence[str]
    warnings: Sequence[str]
    diagram: Diagram

    def write(self, folder: Path) -> list[Path]:
        """Write accuracy.csv, accuracy.md and accuracy.png; their paths."""
        write_rows(folder / CSV, nine_digits(self.rows))
        lines = [*(f"- {line}" for line in self.lines), *(f"- **{line}**" for line in self.warnings)]
        with replacing(folder / MARKDOWN) as part:
            part.write_text("\n".join([f"# {self.heading}", "", table(self.read), *lines]) + "\n", encoding="utf-8")
        draw(self.diagram, folder / PICTURE)
        return [folder / name for name in OUTPUTS]


def nine_digits(rows: Sequence[Row]) -> list[Row]:
    """Rows for CSV."""
    return [{key: f"{v:.9g}" if isinstance(v, float) else v for key, v in row.items()} for row in rows]


def table(rows: Sequence[Row]) -> str:
    """Rows in Markdown, three digits; what was missed stands out."""
    return markdown([[key.replace("_", " ") for key in rows[0]], *([_cell(key, value) for key, value in row.items()] for row in rows)])


def _cell(key: str, value: Any) -> str:
    """A value for reading."""
    if isinstance(value, bool):
        return "yes" if value else "**missed**" if key == "reached" else ""
    return f"{value:.3g}" if isinstance(value, float) else str(value)
