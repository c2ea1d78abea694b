# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes docs/outputs.md: every number that a run comes to and every file that a command may leave, as declared."""

from __future__ import annotations

from pathlib import Path

from masonry_cd.analysis.outputs import FORMATS, NUMBERS
from masonry_cd.analysis.outputs.folders import FOLDERS
from reports.files import known_files

PAGE = Path(__file__).parent / "outputs.md"
HEAD = """# Outputs of a run

## Numbers

Written by `docs/write_output_reference.py` from the declarations in `masonry_cd/analysis/outputs`, which all that shows a number
reads: a file there with an entry in `NUMBERS` adds one everywhere. The files are described in [Results](results.md).

| number | key | unit | what it is | in |
|---|---|---|---|---|
"""

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
    files = [f"| `{name}` | {meaning} |" for name, meaning in known_files().items()]
    for command, held in FOLDERS.items():
        files.append(f"\n## Files of `{command}`\n\n| file | what it holds |\n|---|---|")
        files += [f"| `{name}` | {meaning} |" for name, meaning in held.items()]
    return HEAD + "\n".join([*rows, FILES, *files]) + "\n"


if __name__ == "__main__":
    PAGE.write_text(reference(), encoding="utf-8")
