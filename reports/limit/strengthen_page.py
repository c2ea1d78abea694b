# SPDX-License-Identifier: GPL-3.0-or-later
"""strengthen.html, a strengthening on one page: verdict, ties with bars and prices, parts before and after, pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from masonry_cd.analysis.verdict import Verdict
from masonry_cd.foundation.quantities import force
from reports.page.document import Head, pictures, rows_of, write_document
from reports.page.words import number

TIES = ("tie", "along", "z [m]", "length [m]", "least force", "bar", "yields at", "worth of 1 kN", "cost")
STAGES = {"before": "before", "with_least": "least forces", "after": "bars"}
SHOWN = 30  # parts at most


def write_strengthen_page(found: Mapping[str, Any], lines: Sequence[str], drawn: Mapping[Path, str], scene: str, path: Path) -> None:
    """Write the page of strengthen.json; ``lines`` are those of the terminal, ``drawn`` PNGs with what each shows."""
    checked = found["zeta_E"]["before"] is not None
    write_document(
        path,
        "strengthen.html",
        title=f"{found['title']}: strengthening",
        page=Head(
            f"{found['title']}: strengthening", lines[1:], found["notes"], _numbers(found),
            rows_of({}, f"masonry_cd {found['version']}", scene), Verdict(**found["on_the_whole"]),
        ),
        target=found["target"]["words"],
        ties=[_tie(tie) for tie in found["ties"]],
        columns=TIES,
        parts=[_part(row, checked) for row in found["parts"][:SHOWN]],
        heads=["part", "push", "mechanism before", *(f"{name}, {of}" for name in _shown(checked) for of in STAGES.values())],
        more=max(len(found["parts"]) - SHOWN, 0),
        unused=[one["name"] for one in found["candidates"] if one["name"] not in {tie["name"] for tie in found["ties"]}],
        drawn=pictures(drawn),
        command="masonry-cd strengthen scene.toml -o out",
        scene=scene,
    )  # fmt: skip


def _shown(checked: bool) -> dict[str, str]:
    """The numbers of each stage that the table shows, with their keys."""
    return {"factor": "factor"} | ({"zeta_E": "zeta_E"} if checked else {})


def _numbers(found: Mapping[str, Any]) -> list[tuple[str, object, str]]:
    """The headline numbers."""
    kind = found["target"]["kind"]
    name = "least load factor" if kind == "factor" else "least zeta_E"
    values = [(f"{name} {stage}", number(found[kind][stage]), "") for stage in ("before", "after") if found[kind][stage] is not None]
    cost = found["cost"]
    return [*values, ("ties", len(found["ties"]), f" of {len(found['candidates'])}"), ("cost with bars", number(cost["bars"]), "")]


def _tie(tie: Mapping[str, Any]) -> list[str]:
    """The cells of a tie."""
    return [
        f"{tie['name']}", f"{tie['along']}, {'y' if tie['along'] == 'x' else 'x'} = {number(tie['at'])}", number(tie["height"]),
        number(tie["length"]), force(tie["least_force"]), f"{1e3 * tie['diameter']:g} mm", force(tie["yield_force"]),
        number(tie["worth_per_kn"], digits=3), number(tie["cost"]),
    ]  # fmt: skip


def _part(row: Mapping[str, Any], checked: bool) -> list[str]:
    """The cells of a part under a push."""
    values = [row[f"{key}_{stage}"] for key in _shown(checked).values() for stage in STAGES]
    return [row["part"], row["push"], row["mechanism_before"] or "none", *("–" if value is None else number(value) for value in values)]
