# SPDX-License-Identifier: GPL-3.0-or-later
"""Write docs/laboratory.md and its figures from what `masonry-cd validate` left in a folder.

for name in $(masonry-cd validate | cut -d: -f1); do masonry-cd validate $name -o out/laboratory/$name --force; done
python docs/write_laboratory.py out/laboratory
"""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

from masonry_cd.studies.laboratory.cases import CASES
from masonry_cd.studies.laboratory.validate import FIGURE, TABLE

DOCS = Path(__file__).parent
PAGE, FIGURES = DOCS / "laboratory.md", DOCS / "laboratory"
HEAD = """# Held against the laboratory

Tests of laboratories, and results of other programs, against what this program gives for them. No parameter is tuned to meet a result: what
was not known is assumed as stated, and what does not agree is shown as it is. `masonry-cd validate` lists the cases and
`masonry-cd validate NAME` repeats one; its scenes are good to start from. The page is written by `docs/write_laboratory.py` from what the
commands leave; each case takes seconds to a few minutes.

*Computed* has rigid joints, by limit analysis or the same run, and elastic ones; the ratio is over what was measured, or found by others.

"""


def page(source: Path) -> str:
    """The text of the page, of those cases whose tables are there."""
    tables = {name: json.loads((source / name / TABLE).read_text()) for name in CASES if (source / name / TABLE).is_file()}
    lines = ["| case | quantity | measured | rigid | elastic | ratio |", "|---|---|---|---|---|---|"]
    for name, rows in tables.items():
        lines += [_row(name, row) for row in rows]
    parts = [HEAD + "\n".join(lines)]
    for name in tables:
        case = CASES[name]
        shown = [f"## {case.title}", f"![{case.title}: computed and measured](laboratory/{name}.svg)", case.verdict]
        facts = [
            f"- Source: {case.source}.",
            f"- Assumed: {case.assumed}.",
            f"- Not known: {case.unknown}.",
            f"- `masonry-cd validate {name}`",
        ]
        parts.append("\n\n".join([*shown, "\n".join(facts)]))
    return "\n\n".join(parts) + "\n"


def _row(name: str, row: dict) -> str:
    computed = [(row[word], f"{row[word]:.4g}") if row[word] is not None else (None, "") for word in ("rigid", "elastic")]
    ratios = ", ".join(f"{value / row['measured']:.2f}" for value, _ in computed if value is not None)
    link = f"[{name}](#{CASES[name].title.lower().replace(' ', '-').replace(chr(39), '')})"
    return f"| {link} | {row['quantity']} | {row['measured']:.4g} {row['unit']} | {computed[0][1]} | {computed[1][1]} | {ratios} |"


if __name__ == "__main__":
    source = Path(sys.argv[1] if len(sys.argv) > 1 else "out/laboratory")
    FIGURES.mkdir(exist_ok=True)
    PAGE.write_text(page(source), encoding="utf-8")
    for name in CASES:
        if (source / name / FIGURE).is_file():
            shutil.copyfile(source / name / FIGURE, FIGURES / f"{name}.svg")
