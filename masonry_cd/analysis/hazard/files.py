# SPDX-License-Identifier: GPL-3.0-or-later
"""Hazard in CSV files: a table with units in its heading, or the hazard curves of OpenQuake.

    return_period_years,ag_g,f0,tc_star_s          # or intensity_g, frequency_per_year
    30,0.079,2.40,0.27
    50,0.104,2.33,0.28

OpenQuake (Engine 3, manual, "hazard curves") has a remark with investigation_time and imt first, then a heading and a row for each site:

    #,,,,"generated_by='OpenQuake engine 3.16.3', kind='mean', investigation_time=50.0, imt='PGA'"
    lon,lat,depth,poe-0.0050000,poe-0.0070000
    13.40000,42.35000,0.00000,9.912345E-01,9.812345E-01

poe is the probability that the level is exceeded in that time; levels of PGA and SA(T) are in g. Levels at the ends that are exceeded
for certain, or never, say nothing of a frequency.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from masonry_cd.analysis.hazard.curve import G
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.fields import finite_number
from masonry_cd.foundation.files import read_text

COLUMNS = {  # of our own tables: key and factor
    "return_period_years": ("return_period", 1.0),
    "ag_g": ("ag", G),
    "ag_m_s2": ("ag", 1.0),
    "f0": ("f0", 1.0),
    "tc_star_s": ("tc_star", 1.0),
    "intensity_g": ("intensity", G),
    "intensity_m_s2": ("intensity", 1.0),
    "frequency_per_year": ("frequency", 1.0),
    "probability": ("probability", 1.0),
}
LEVEL = "poe-"
NEAR = 1e-3  # degrees by which a site of a file may differ from the requested one
TIME, IMT = re.compile(r"investigation_time\s*=\s*([\d.eE+-]+)"), re.compile(r"""imt\s*=\s*['"]+([^'"]+)['"]""")
SPECTRAL = re.compile(r"SA\(([\d.]+)\)")


class Read(NamedTuple):
    """The rows of a file by the keys of [hazard], and what it says of them."""

    rows: dict[str, list[float]]
    measure: str = ""  # empty where the file does not say
    years: float | None = None
    notes: tuple[str, ...] = ()


def read_hazard(path: Path, site: tuple[float, float] | None) -> Read:
    """Read a file; ``site``: longitude and latitude in a file of OpenQuake with several [degrees].

    Raises:
        InputError: no such file, no such table, no such site; names file and line.
    """
    try:
        lines = read_text(path, encoding="utf-8-sig").splitlines()
    except OSError as failure:
        raise InputError(path, f"cannot be read, {failure.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(path, "is not text in UTF-8") from None
    table = [(number, line) for number, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")]
    if not table:
        raise InputError(path, f"holds no table; its heading names columns: {', '.join(COLUMNS)}")
    rows = [(f"{path}:{number}", [cell.strip() for cell in next(csv.reader([line]))]) for number, line in table]
    heading, *body = rows
    for place, cells in body:
        if len(cells) != len(heading[1]):
            raise InputError(place, f"{len(cells)} values under {len(heading[1])} columns")
    if any(name.startswith(LEVEL) for name in heading[1]):
        remarks = "\n".join(line.replace('""', '"') for line in lines if line.lstrip().startswith("#"))
        return _of_openquake(path, remarks, (heading[1], body), site)
    if site is not None:
        raise InputError("hazard.lon", f"{path} is the table of one site")
    return _own(heading, body)


Cells = Sequence[tuple[str, list[str]]]


def _own(heading: tuple[str, list[str]], body: Cells) -> Read:
    """Read a table of our own."""
    place, names = heading
    for name in names:
        if name not in COLUMNS:
            raise InputError(place, f'unknown column "{name}"{suggest(name, COLUMNS)}; known: {", ".join(COLUMNS)}')
    keys = [COLUMNS[name][0] for name in names]
    if twice := [name for name, key in zip(names, keys, strict=True) if keys.count(key) > 1]:
        raise InputError(place, f"columns {' and '.join(twice)} say one thing twice")
    columns = {COLUMNS[name]: list(_numbers(body, k, name)) for k, name in enumerate(names)}
    return Read({key: [factor * value for value in values] for (key, factor), values in columns.items()})


def _numbers(body: Cells, column: int, name: str) -> Iterator[float]:
    """The numbers of a column, all above zero."""
    for place, cells in body:
        value = finite_number(cells[column])
        if value is None or value <= 0.0:
            raise InputError(place, f'{name}: should be a number above 0, got "{cells[column]}"')
        yield value


def _of_openquake(path: Path, remarks: str, table: tuple[list[str], Cells], site: tuple[float, float] | None) -> Read:
    """Read the hazard curve of a site, less the levels at its ends that are exceeded for certain or never."""
    time, imt = TIME.search(remarks), IMT.search(remarks)
    if time is None or imt is None:
        raise InputError(path, "the remark in its first line should give investigation_time and imt, as OpenQuake writes them")
    spectral = SPECTRAL.fullmatch(imt[1])
    if imt[1] != "PGA" and spectral is None:
        raise InputError(path, f"imt {imt[1]} is read for PGA and SA(T) alone; give the curve by intensity and frequency")
    names, body = table
    place, cells = _site(path, names, body, site)
    at = [k for k, name in enumerate(names) if name.startswith(LEVEL)]
    levels = [finite_number(names[k].removeprefix(LEVEL)) for k in at]
    poes = [finite_number(cells[k]) for k in at]
    for name, level, poe in zip((names[k] for k in at), levels, poes, strict=True):
        if level is None or level <= 0.0 or poe is None or not 0.0 <= poe <= 1.0:
            raise InputError(place, f"{name}: a level above 0 and a probability from 0 to 1 are needed")
    rows = [(G * level, poe) for level, poe in zip(levels, poes, strict=True) if level and poe and poe < 1.0]
    lost = len(levels) - len(rows)
    notes = (f"{path.name}: {lost} of {len(levels)} levels are exceeded for certain or never, and left out",) if lost else ()
    of = {"intensity": [level for level, _ in rows], "probability": [poe for _, poe in rows]}
    return Read(of, f"Sa({spectral[1]})" if spectral else "PGA", finite_number(time[1]), notes)


def _site(path: Path, names: list[str], body: Cells, site: tuple[float, float] | None) -> tuple[str, list[str]]:
    """The row of a site."""
    if not {"lon", "lat"} <= set(names):
        raise InputError(path, "its heading should have lon and lat, as OpenQuake writes them")
    places = [tuple(finite_number(cells[names.index(name)]) or 0.0 for name in ("lon", "lat")) for _, cells in body]
    if not body:
        raise InputError(path, "holds no site")
    if site is None:
        if len(body) > 1:
            raise InputError(
                "hazard.lon", f"{path} has {len(body)} sites; give lon and lat of one, as {places[0][0]:g} and {places[0][1]:g}"
            )
        return body[0]
    apart = [max(abs(x - site[0]), abs(y - site[1])) for x, y in places]
    k = apart.index(min(apart))
    if apart[k] > NEAR:
        raise InputError("hazard.lon", f"{path} has no site at {site[0]:g}, {site[1]:g}; the nearest is {places[k][0]:g}, {places[k][1]:g}")
    return body[k]
