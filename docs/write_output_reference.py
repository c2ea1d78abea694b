"""Writes docs/outputs.md: every number that a run comes to, as its declaration says."""

from __future__ import annotations

from pathlib import Path

from masonry_cd.analysis.outputs import FORMATS, NUMBERS

PAGE = Path(__file__).parent / "outputs.md"
HEAD = """# Numbers of a run

Written by `docs/write_output_reference.py` from the declarations in `masonry_cd/analysis/outputs`, which all that shows a number
reads: a file there with an entry in `NUMBERS` adds one everywhere. The files are described in [Results](results.md).

| number | key | unit | what it is | in |
|---|---|---|---|---|
"""


def reference() -> str:
    """The page."""
    rows = []
    for key, number in sorted(NUMBERS.items(), key=lambda item: (min(item[1].places.values()), item[0])):
        others = sorted({other for other in number.keys.values() if other != key})
        keys = " ".join(f"`{name}`" for name in (key, *others))
        shown = ", ".join(place for place in FORMATS if place in number.places)
        rows.append(f"| {number.name} | {keys} | {number.unit} | {number.meaning} | {shown} |")
    return HEAD + "\n".join(rows) + "\n"


if __name__ == "__main__":
    PAGE.write_text(reference(), encoding="utf-8")
