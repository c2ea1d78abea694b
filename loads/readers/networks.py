# SPDX-License-Identifier: GPL-3.0-or-later
"""Networks whose files are a heading of ``key: value`` and a table of components: AFAD/NSMN (Turkey), UNAM (Mexico), CWB (Taiwan).

    AFAD    STRONG GROUND MOTION RECORDS OF TURKIYE;  SAMPLING INTERVAL (sec), NUMBER OF DATA, PGA VALUES (gal);  N-S E-W U-D
    UNAM    ARCHIVO ESTANDAR DE ACELERACION;  INTERVALO DE MUESTREO, UNIDADES DE LOS DATOS, ORIENTACION;  CANAL-1 CANAL-2 CANAL-3
    CWB     #SampleRate(Hz), #AmplitudeUnit, #DataSequence: Time U(+); N(+); E(+)

Newer files of AFAD (TADAS) have the heading of ESM and are read as such.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from loads.readers.channels import component, evenly, only_physical, pick, positive, whole
from loads.readers.quantity import Stated
from loads.readers.source import RawRecord, Reader, Request, Source, check_count

HEADING = 150  # lines in which keys are looked for
AFAD, UNAM, CWB = "STRONG GROUND MOTION RECORDS OF TURKIYE", "ARCHIVO ESTANDAR DE ACELERACION", "#DATASEQUENCE"
PGA_UNIT = re.compile(r"PGA VALUES\s*\(([^)]+)\)", re.IGNORECASE)
RULE = re.compile(r"^[-+]{20,}\s*$")  # above and below the names of UNAM's columns


def _keys(source: Source) -> dict[str, tuple[int, str]]:
    """Key in capitals -> (index of its line, value), of the first lines."""
    found: dict[str, tuple[int, str]] = {}
    for index, line in enumerate(source.lines[:HEADING]):
        key, colon, value = line.partition(":")
        if colon:
            found.setdefault(" ".join(key.upper().split()), (index, value.strip()))
    return found


def _find(source: Source, beginning: str, kind: str) -> tuple[int, str]:
    """The line and the value of the first key that begins so.

    Raises:
        InputError: there is none.
    """
    found = next((entry for key, entry in _keys(source).items() if key.startswith(beginning)), None)
    if found is None:
        raise source.error(f"no line {beginning} in the heading of a {kind} file")
    return found


def _table(source: Source, first: int, columns: Sequence[int], width: int) -> list[list[float]]:
    """Some columns of the lines of numbers from one line on, each of a width.

    Raises:
        InputError: a line of another width, text among the numbers.
    """
    rows = []
    for index in range(first, len(source.lines)):
        words = source.lines[index].split()
        if words and len(words) != width:
            raise source.error(f"{len(words)} columns, where the table has {width}", index)
        if words:
            rows.append([source.number(words[c], index) for c in columns])
    if len(rows) < 2:
        raise source.error(f"{len(rows)} rows of numbers are no record")
    return rows


def _made(kind: str) -> Stated:
    return Stated("acceleration", f"the format of {kind} files", firm=True)


def recognises_afad(source: Source) -> bool:
    """True when the first line is that of the Turkish network."""
    return bool(source.lines) and AFAD in source.lines[0].upper()


def read_afad(source: Source, request: Request) -> RawRecord:
    """Read one component.

    Raises:
        InputError: a missing line of the heading, no such component, a wrong count.
    """
    only_physical(source, request, "AFAD")
    line, text = _find(source, "SAMPLING INTERVAL", "AFAD")
    step = positive(source, text, line, "the sampling interval")
    titles = next((i for i, line in enumerate(source.lines[:HEADING]) if re.match(r"\s*N-?S\s+E-?W\s+U-?D\s*$", line, re.IGNORECASE)), None)
    if titles is None:
        raise source.error("no line N-S E-W U-D above the numbers of an AFAD file")
    names = source.lines[titles].split()
    column = pick(source, names, request, "AFAD")
    values = [row[0] for row in _table(source, titles + 1, [column], len(names))]
    unit = next((found[1] for line in source.lines[:titles] if (found := PGA_UNIT.search(line))), None)
    line, text = _find(source, "NUMBER OF DATA", "AFAD")
    record = RawRecord(np.array(values), step, 0.0, unit, names[column], column, _made("AFAD"))
    check_count(source, record.values, whole(source, text, line, "NUMBER OF DATA"), line)
    return record


def recognises_unam(source: Source) -> bool:
    """True when one of the first lines is that of the standard file of UNAM."""
    return any(UNAM in line.upper() for line in source.lines[:15])


def read_unam(source: Source, request: Request) -> RawRecord:
    """Read one component.

    Raises:
        InputError: a missing line of the heading, no such component, a wrong count.
    """
    only_physical(source, request, "UNAM")
    rules = [index for index, line in enumerate(source.lines[:HEADING]) if RULE.match(line.strip())]
    if len(rules) < 2 or rules[-1] - rules[-2] < 2:
        raise source.error("no ruled names of columns above the numbers of a UNAM file")
    line, text = _find(source, "ORIENTACION C1", "UNAM")
    names = [component(word.replace(";", " ")) for word in text.strip("/ ").split("/")]
    column = pick(source, names, request, "UNAM")
    line, text = _find(source, "INTERVALO DE MUESTREO, C1", "UNAM")
    step = positive(source, _of_channel(source, line, text, column), line, "INTERVALO DE MUESTREO")
    unit = _find(source, "UNIDADES DE LOS DATOS", "UNAM")[1].partition("(")[0].strip()
    values = np.array([row[0] for row in _table(source, rules[-1] + 1, [column], len(names))])
    line, text = _find(source, "NUM. TOTAL DE MUESTRAS, C1", "UNAM")
    check_count(source, values, whole(source, _of_channel(source, line, text, column), line, "NUM. TOTAL DE MUESTRAS"), line)
    return RawRecord(values, step, 0.0, unit or None, names[column], column, _made("UNAM"))


def _of_channel(source: Source, line: int, text: str, column: int) -> str:
    """The entry of a channel in ``/0.005/0.005/0.005``."""
    words = text.strip("/ ").split("/")
    if column >= len(words):
        raise source.error(f"{len(words)} entries, and channel {column + 1} is asked for", line)
    return words[column]


def recognises_cwb(source: Source) -> bool:
    """True when the heading of Taiwan's weather bureau gives rate and sequence of the columns."""
    keys = _keys(source)
    return CWB in keys and any(key.startswith("#SAMPLERATE") for key in keys)


def read_cwb(source: Source, request: Request) -> RawRecord:
    """Read one component.

    Raises:
        InputError: a missing line of the heading, no such component, times that contradict the rate.
    """
    only_physical(source, request, "CWB")
    titles = [re.sub(r"\([^)]*\)", "", word).strip() for word in re.split(r"[;\s]+", _find(source, CWB, "CWB")[1]) if word.strip()]
    names = titles[1:]
    column = pick(source, names, request, "CWB")
    line, text = _find(source, "#SAMPLERATE", "CWB")
    rate = positive(source, text, line, "the sample rate")
    unit = _find(source, "#AMPLITUDEUNIT", "CWB")[1].split()
    first = 1 + max(index for index, line in enumerate(source.lines[:HEADING]) if line.startswith("#"))
    table = np.array(_table(source, first, [0, column + 1], len(titles)))
    values, step, notes = evenly(source, table[:, 0], table[:, 1], first)
    if abs(step * rate - 1.0) > 1e-3:
        raise source.error(f"{rate:g} samples a second, but the times are {step:g} s apart: correct the file", line)
    return RawRecord(
        values, step, float(table[0, 0]), unit[0].rstrip(".") if unit else None, names[column], column, _made("CWB"), notes=notes
    )


FORMATS = {
    "afad": Reader(recognises_afad, read_afad, about="text of three components", by="AFAD/NSMN, Turkey (older files; newer ones are esm)"),
    "unam": Reader(recognises_unam, read_unam, about="Archivo estandar de aceleracion (ASA 2.0)", by="UNAM, Mexico"),
    "cwb": Reader(recognises_cwb, read_cwb, about="text of three components", by="Central Weather Bureau, Taiwan"),
}
