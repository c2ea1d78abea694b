# SPDX-License-Identifier: GPL-3.0-or-later
"""The damage of parts in the closing lines."""

from __future__ import annotations

from collections.abc import Sequence

from masonry_cd.analysis.damage.grades import NAMES
from masonry_cd.analysis.damage.part_damage import Row
from masonry_cd.analysis.verdict import NOT_GRADED


def _sound(row: Row) -> bool:
    """Whether a part is undamaged: by its grade, or where it has none by what is left."""
    if row["grade"] != NOT_GRADED:
        return bool(row["grade"] == NAMES[0])
    return not any(row[key] for key in ("only_opened", "only_slid", "opened_and_slid", "separated", "lost_blocks"))


def part_lines(parts: Sequence[Row]) -> list[str]:
    """The grade and mechanism of each part in a line, for the terminal; the gravest first, the undamaged ones counted only.

    Args:
        parts: rows as in damage.csv, the structure last.
    """
    rows = sorted(parts[:-1], key=lambda row: row["grade"], reverse=True)
    damaged, sound = [row for row in rows if not _sound(row)], [row for row in rows if _sound(row)]
    graded = parts[-1]["grade"] != NOT_GRADED
    wide = max(len("grade"), 0 if graded else len(NOT_GRADED))
    lines = [] if graded else [f"{NOT_GRADED}: {parts[-1]['grade_reason']}"]
    head = f"{'part':<20} {'grade':<{wide}} {'mechanism':<24} {'opened':>6} {'slid':>6} {'both':>6} {'lost':>6}"
    lines.append(head + ("  graded by what is left" if graded else ""))
    for row in [parts[-1], *damaged]:
        reason = (row["grade_reason"] or row["grade_label"]) if graded else ""
        lines.append(
            f"{row['part']:<20} {row['grade']:<{wide}} {row['mechanism']:<24} {row['only_opened']:>6} {row['only_slid']:>6} "
            f"{row['opened_and_slid']:>6} {row['lost_blocks']:>6}  {reason}".rstrip()
        )
    if sound:
        label = f"{NAMES[0]}, {sound[0]['grade_label']}" if graded else "no joint opened or slid"
        lines.append(f"{len(sound)} of {len(rows)} parts: {label}")
    if provisional := parts[-1].get("provisional"):
        lines.append(f"grades, mechanisms and what is left are {provisional}")
    return lines
