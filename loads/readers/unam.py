# SPDX-License-Identifier: GPL-3.0-or-later
"""UNAM (Mexico), Archivo estandar de aceleracion (ASA 2.0): a heading of ``key: value`` lines, and columns CANAL-1 CANAL-2 CANAL-3 between
rules; what differs from channel to channel is written ``/0.005/0.005/0.005``."""

from __future__ import annotations

import re

from loads.readers.channels import component, pick
from loads.readers.heading import RecordHeading, columns, first_of_numbers
from loads.readers.quantity import of_format
from loads.readers.source import RawRecord, Reader, Request, Source, begins

HEADING = 150  # lines in which keys are looked for
RULE = re.compile(r"^[-+]{20,}\s*$")  # above and below the names of the columns


def read(source: Source, request: Request) -> RawRecord:
    """Read one component."""
    heading = RecordHeading.split(source, "UNAM", HEADING)
    rules = [index for index, line in enumerate(source.lines[:HEADING]) if RULE.match(line.strip())]
    if len(rules) < 2 or rules[-1] - rules[-2] < 2:
        raise source.error("no ruled names of columns above the numbers of a UNAM file")
    names = [component(word.replace(";", " ")) for word in heading.find("ORIENTACION C1")[1].strip("/ ").split("/")]
    column = pick(names, request.column, source.error)
    step = heading.positive("INTERVALO DE MUESTREO, C1", column)
    unit = heading.find("UNIDADES DE LOS DATOS")[1].partition("(")[0].strip()
    values = columns(source, first_of_numbers(source, rules[-1] + 1), [column], len(names))[:, 0]
    count = int(heading.positive("NUM. TOTAL DE MUESTRAS, C1", column))
    heading.check_count("NUM. TOTAL DE MUESTRAS, C1", values[:count], place=column)
    more = len(values) - count
    notes = (f"{more} row{'s' if more > 1 else ''} behind the {count} samples announced left out",) if more else ()
    return RawRecord(values[:count], step, 0.0, unit or None, names[column], column, of_format("UNAM"), notes=notes)


MARK = begins("ARCHIVO ESTANDAR DE ACELERACION", 15)
FORMATS = {"unam": Reader(MARK, read, about="Archivo estandar de aceleracion (ASA 2.0)", by="UNAM, Mexico", takes=("column",))}
