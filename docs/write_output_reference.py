# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes docs/outputs.md: every number that a run comes to and every file that a command may leave, as declared."""

from __future__ import annotations

from pathlib import Path

from pydantic import BaseModel

from masonry_cd.analysis.outputs import FORMATS, NUMBERS
from masonry_cd.analysis.outputs.folders import FOLDERS
from masonry_cd.app.per_step import QUANTITIES
from masonry_cd.foundation.units import models_in, unit_of
from masonry_cd.io import layout
from masonry_cd.io.summary import Summary
from reports.files import known_files

PAGE = Path(__file__).parent / "outputs.md"
HEAD = """# Outputs of a run

## Numbers

Written by `docs/write_output_reference.py` from the declarations in `masonry_cd/analysis/outputs`, which all that shows a number
reads: a file there with an entry in `NUMBERS` adds one everywhere. The files are described in [Results](results.md).

| number | key | unit | what it is | in |
|---|---|---|---|---|
"""

SUMMARY = """
## Keys of summary.json

Written from `masonry_cd/io/summary.py` and `summary_tables.py`. A key is written where the run has it; null stands for what is not finite.
The numbers above that name summary.json, also those of plug-ins, are keys as well.

| key | unit | what it is |
|---|---|---|"""

DATASETS = """
## Datasets of result.h5

Written from the table `DATASETS` of `masonry_cd/io/layout.py`, by which the file is written and checked. SI units, world frame. What has a
first dimension F, N, K or bytes grows as the run goes; `segments/` holds checksums (`masonry_cd/io/segments.py`).

| dataset | shape | unit | what it is | where |
|---|---|---|---|---|"""

FILES = """
## Files of `run` and `report`

| file | what it holds |
|---|---|"""


def reference() -> str:
    """The page."""
    rows = []
    for key, number in sorted(NUMBERS.items(), key=lambda item: (min(item[1].places.values()), item[0])):
        others = sorted({other for other in number.keys.values() if other != key})
        keys = " ".join(f"`{name}`" for name in (key, *others))
        shown = ", ".join(place for place in FORMATS if place in number.places)
        rows.append(f"| {number.name} | {keys} | {number.unit} | {number.meaning} | {shown} |")
    rows += [SUMMARY, *key_rows(Summary), DATASETS]
    for one in layout.DATASETS:
        shape = ", ".join(map(str, one.shape))
        rows.append(f"| `{one.name}` | {shape} | {one.unit} | {one.meaning} | {one.when or 'everywhere'} |")
    for name, number in QUANTITIES.items():
        rows.append(f"| `{name}` | N | {number.unit} | {number.meaning} | everywhere |")
    dimensions = "; ".join(f"{name} {meaning}" for name, meaning in layout.DIMENSIONS.items())
    attributes = layout.ATTRIBUTES | layout.OPTIONAL_ATTRIBUTES | layout.OTHER_ATTRIBUTES
    rows += ["", f"Dimensions: {dimensions}.", "", "| attribute | what it is |", "|---|---|"]
    rows += [f"| `{name}` | {meaning} |" for name, meaning in attributes.items()]
    files = [f"| `{name}` | {meaning} |" for name, meaning in known_files().items()]
    for command, held in FOLDERS.items():
        files.append(f"\n## Files of `{command}`\n\n| file | what it holds |\n|---|---|")
        files += [f"| `{name}` | {meaning} |" for name, meaning in held.items()]
    return HEAD + "\n".join([*rows, FILES, *files]) + "\n"


def key_rows(table: type[BaseModel], above: str = "") -> list[str]:
    """The rows of a table of summary.json, those of tables in it behind the key that holds them; ``[]`` marks a list."""
    rows = []
    for name, field in table.model_fields.items():
        if not field.exclude:
            inner = next(models_in(field.annotation), None)
            said = next((word for word in field.metadata if isinstance(word, str)), "" if inner is None else _first_line(inner))
            rows.append(f"| `{above}{name}` | {unit_of(field)} | {said or name.replace('_', ' ')} |")
            if inner is not None:
                rows += key_rows(inner, f"{above}{name}{'[]' if 'tuple' in str(field.annotation) else ''}.")
    return rows


def _first_line(table: type[BaseModel]) -> str:
    """Return the first line of a table's docstring."""
    line = (table.__doc__ or "").splitlines()[0].rstrip(".")
    return line[:1].lower() + line[1:]


if __name__ == "__main__":
    PAGE.write_text(reference(), encoding="utf-8")
