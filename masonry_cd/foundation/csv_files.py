# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables as CSV that a spreadsheet opens without running anything, and as aligned text in Markdown or for a terminal.

A spreadsheet takes a cell that begins with =, +, -, @ or a control character for a formula, and names come from files of strangers. So a
text that begins like one gets an apostrophe before it, and what could end a cell in any country is quoted (OWASP, CSV injection); numbers
stay as they are. Whoever reads such a table by a program takes one apostrophe away where more of them, or none, and one of these follow:
every name is then what it was. What this program reads, it reads by number and place.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from masonry_cd.foundation.atomic import replacing

# with any apostrophes before it, so that removing a guard leaves those of the name; the last four are =, +, - and @ of full width
FORMULA = re.compile("'*[=+\\-@\t\r\n\0\uff1d\uff0b\uff0d\uff20]")
DIRECTIONS = {f"{sign}{axis}" for sign in "+-" for axis in "xyz"}  # columns of reports hold them; a formula of one letter does nothing
SEPARATORS = ',;"\t\r\n|'


def write_csv(path: Path, header: Iterable[str], rows: Iterable[Iterable[object]], digits: int = 0) -> None:
    """Write a table; the file is there whole or not at all.

    Args:
        path: of the file.
        header: names of the columns.
        rows: cells, of which each is written as ``str`` shows it, None as nothing, or by :func:`cell` where digits are given.
        digits: of numbers.
    """
    table = ((cell(value, digits) for value in row) for row in rows) if digits else rows
    lines = (",".join(map(_field, row)) for row in (header, *table))
    with replacing(path) as part:
        part.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="")


def write_rows(path: Path, rows: Sequence[Mapping[str, object]]) -> None:
    """Write a table whose columns are the keys of its first row; a cell is empty where another row has none."""
    write_csv(path, rows[0], ([row.get(key, "") for key in rows[0]] for row in rows))


def cell(value: object, digits: int) -> str:
    """A value with a given number of digits; nothing where it is unknown, lists with blanks between."""
    if isinstance(value, (list, tuple)):
        return " ".join(cell(one, digits) for one in value)
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.{digits}g}"
    return "" if value is None else str(value).lower() if isinstance(value, bool) else str(value)


def unguarded(cell: str) -> str:
    """A text as it was before :func:`write_csv` guarded it."""
    return cell[1:] if cell.startswith("'") and FORMULA.match(cell) else cell


def _field(value: object) -> str:
    """A cell, guarded and quoted where it has to be."""
    text = "" if value is None else str(value)
    if FORMULA.match(text) and not _is_number(text) and text not in DIRECTIONS:
        text = f"'{text}"
    return '"' + text.replace('"', '""') + '"' if any(c in text for c in SEPARATORS) else text


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


Rows = Sequence[Sequence[str]]


def markdown(rows: Rows) -> str:
    """A table in Markdown, which reads well as plain text too; the first row is its head."""
    padded = _padded([[cell.replace("|", "\\|") for cell in row] for row in rows])
    head, *lines = ["| " + " | ".join(row) + " |" for row in padded]
    return "\n".join([head, "|" + "|".join("-" * (len(cell) + 2) for cell in padded[0]) + "|", *lines]) + "\n"


def plain(rows: Rows, numbers: range) -> str:
    """A table for a terminal with a line below its head; the columns of ``numbers`` end at the right."""
    lines = ["  ".join(row).rstrip() for row in _padded(rows, numbers)]
    return "\n".join([lines[0], "-" * max(map(len, lines)), *lines[1:]])


def _padded(rows: Rows, numbers: range = range(0)) -> list[list[str]]:
    """The cells, each as wide as the widest of its column."""
    wide = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [[cell.rjust(w) if k in numbers else cell.ljust(w) for k, (cell, w) in enumerate(zip(row, wide, strict=True))] for row in rows]
