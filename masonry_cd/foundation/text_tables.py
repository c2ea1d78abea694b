# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables as text whose columns are aligned: as Markdown, and plain for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

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
