# SPDX-License-Identifier: GPL-3.0-or-later
"""Fields of a line of a table: what stands between them, and decimal commas."""

from __future__ import annotations

import re

from loads.readers.source import Source

DELIMITERS = (";", "\t", ",")
PROBE = 20  # lines looked at to recognise a table
DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")


def delimiter_of(source: Source) -> str | None:
    """The delimiter of a CSV: the one next to which numbers stand in the first lines."""
    lines = [line for _, (_, line) in zip(range(PROBE), source.content(), strict=False)]
    for delimiter in DELIMITERS:
        if delimiter == "," and any(len(line.split()) > 1 and all(map(DECIMAL_COMMA.fullmatch, line.split())) for line in lines):
            continue  # columns apart by blanks, of numbers with a decimal comma
        rows = [split(line, delimiter) for line in lines]
        if any(len(row) > 1 and any(is_number(decimal(field, delimiter)) for field in row) for row in rows):
            return delimiter
    return None


def split(line: str, delimiter: str | None) -> list[str]:
    """The fields of a line; with blanks as delimiter a unit in brackets stays with its name."""
    if delimiter is not None:
        return [field.strip().strip('"') for field in line.split(delimiter)]
    fields: list[str] = []
    for word in line.split():
        if fields and word[0] in "[(":
            fields[-1] += " " + word
        else:
            fields.append(word)
    return fields


def decimal(word: str, delimiter: str | None) -> str:
    """A decimal comma is read where the comma does not separate values."""
    return word if delimiter == "," else word.replace(",", ".")


def is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
