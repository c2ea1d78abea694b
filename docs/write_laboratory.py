# SPDX-License-Identifier: GPL-3.0-or-later
"""Write docs/laboratory.md and its figures from what `masonry-cd validate` left in a folder.

for name in $(masonry-cd validate | cut -d: -f1); do masonry-cd validate $name -o out/laboratory/$name --force; done
python docs/write_laboratory.py out/laboratory
"""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

from masonry_cd.studies.laboratory.case import shown_quartiles
from masonry_cd.studies.laboratory.cases import CASES
from masonry_cd.studies.laboratory.validate import FIGURE, SAMPLES, TABLE

DOCS = Path(__file__).parent
PAGE, FIGURES = DOCS / "laboratory.md", DOCS / "laboratory"
HEAD = """# Held against the laboratory

Tests of laboratories, and results of other programs, against what this program gives for them. No parameter is tuned to meet a result: what
was not known is assumed as stated, and what does not agree is shown as it is. `masonry-cd validate` lists the cases and
`masonry-cd validate NAME` repeats one; its scenes are good to start from. The page is written by `docs/write_laboratory.py` from what the
commands leave; each case takes seconds to a few minutes.

*Computed* has rigid joints, by limit analysis or the same run, and elastic ones; the ratio is over what was measured, or found by others.

"""
DISTRIBUTIONS = """## Distributions

One history of rocking is one sample: the next with a load that differs by 1e-9 may be another. Repeated tests, and many motions, are
compared as distributions: median and quartiles of both, what share fell, the largest distance of the two distribution functions
(Kolmogorov), and the probability of one as large by chance.

"""


def page(source: Path) -> str:
    """The text of the page, of those cases whose tables are there."""
    tables = {name: json.loads((source / name / TABLE).read_text()) for name in CASES if (source / name / TABLE).is_file()}
    lines = ["| case | quantity | measured | rigid | elastic | ratio |", "|---|---|---|---|---|---|"]
    for name, rows in tables.items():
        lines += [_row(name, row) for row in rows]
    parts = [HEAD + "\n".join(lines), DISTRIBUTIONS + "\n".join(_samples(source, list(tables)))]
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


def _samples(source: Path, names: list[str]) -> Iterator[str]:
    """The lines of the table of distributions."""
    yield "| case | quantity | n | measured | fell | computed | fell | distance | probability |"
    yield "|---|---|---|---|---|---|---|---|---|"
    for name in names:
        for one in json.loads((source / name / SAMPLES).read_text()) if (source / name / SAMPLES).is_file() else ():
            sides = [one["measured"], one["computed"]]
            cells = [f"{shown_quartiles(side)} {one['unit']} | {100 * side['fallen']:.3g} %" for side in sides]
            counts, chance = ", ".join(str(side["count"]) for side in sides), f"{one['distance']:.3f} | {one['probability']:.2g}"
            yield f"| {_link(name)} | {one['quantity']} | {counts} | {' | '.join(cells)} | {chance} |"


def _link(name: str) -> str:
    return f"[{name}](#{CASES[name].title.lower().replace(' ', '-').replace(chr(39), '')})"


def _row(name: str, row: dict) -> str:
    computed = [(row[word], f"{row[word]:.4g}") if row[word] is not None else (None, "") for word in ("rigid", "elastic")]
    ratios = ", ".join(f"{value / row['measured']:.2f}" for value, _ in computed if value is not None)
    return f"| {_link(name)} | {row['quantity']} | {row['measured']:.4g} {row['unit']} | {computed[0][1]} | {computed[1][1]} | {ratios} |"


if __name__ == "__main__":
    source = Path(sys.argv[1] if len(sys.argv) > 1 else "out/laboratory")
    FIGURES.mkdir(exist_ok=True)
    PAGE.write_text(page(source), encoding="utf-8")
    for name in CASES:
        if (source / name / FIGURE).is_file():
            shutil.copyfile(source / name / FIGURE, FIGURES / f"{name}.svg")
