# SPDX-License-Identifier: GPL-3.0-or-later
"""Units of motion as record files write them, and their size in SI. A record in an unknown unit is refused, never guessed."""

from __future__ import annotations

import re
from collections.abc import Iterable

from loads.motion import STANDARD_GRAVITY

ACCELERATION = {
    "m/s2": 1.0,
    "cm/s2": 0.01,
    "mm/s2": 0.001,
    "gal": 0.01,
    "g": STANDARD_GRAVITY,
    "mg": 1e-3 * STANDARD_GRAVITY,
    "g/10": 0.1 * STANDARD_GRAVITY,
    "%g": 0.01 * STANDARD_GRAVITY,
    "nm/s2": 1e-9,
    "in/s2": 0.0254,
    "ft/s2": 0.3048,
}
VELOCITY = {"m/s": 1.0, "cm/s": 0.01, "mm/s": 0.001, "nm/s": 1e-9, "in/s": 0.0254, "kine": 0.01}
DISPLACEMENT = {"m": 1.0, "cm": 0.01, "mm": 0.001, "nm": 1e-9}
UNITS = {"acceleration": ACCELERATION, "velocity": VELOCITY, "displacement": DISPLACEMENT}
SUFFIX = "m_s2|cm_s2|mm_s2|m/s2|cm/s2|mm/s2|m_s|cm_s|mm_s|m/s|cm/s|mm/s|gal|kine|mg|g|cm|mm|m|s|sec|ms"  # of a heading, after "_"
TIME = {"s": 1.0, "sec": 1.0, "secs": 1.0, "seconds": 1.0, "seg": 1.0, "segundos": 1.0, "secondi": 1.0, "sek": 1.0, "ms": 1e-3}
LONGEST = 200  # characters of a heading with a unit
DECLARED = re.compile(r"\bUNITS?\b\s*(?:(?:OF|ARE|IN|IS)\s+|[:=]\s*)?(\S+)", re.IGNORECASE)
SPELT = {
    "gals": "gal",
    "galileo": "gal",
    "galileos": "gal",
    "g's": "g",
    "gn": "g",
    "milli-g": "mg",
    "millig": "mg",
    "kines": "kine",
    "g%": "%g",
    "% g": "%g",
    "percent g": "%g",
    "percent of g": "%g",
    "g /10": "g/10",
    "g / 10": "g/10",
    "tenths of g": "g/10",
    "decig": "g/10",
}  # as networks write them


def plain(unit: str) -> str:
    """Write a unit the one way it is keyed here: ``cm/s^2``, ``cm/sec2``, ``cm/s/s``, ``cm_s2``, ``cm s-2`` all become ``cm/s2``."""
    word = re.sub(r"\s+", " ", unit.strip().lower()).replace("²", "2").replace("⁻", "-")
    word = re.sub(r"\b(?:sec|seg)\b|(?<=/)(?:sec|seg)(?=\d|\^|\*|/|$)", "s", word)
    word = word.replace("**", "^").replace("^", "")
    match = re.fullmatch(r"(nm|m|cm|mm|in|ft)(?:/s/s|/s2|_s2|[ .*]?s-2|/\(s2\))", word)
    if match:
        return f"{match[1]}/s2"
    match = re.fullmatch(r"(nm|m|cm|mm|in)(?:/s|_s|[ .*]?s-1|/\(s\))", word)
    if match:
        return f"{match[1]}/s"
    return SPELT.get(word, word)


def acceleration_unit(unit: str) -> float | None:
    """Size of a unit of acceleration in m/s2, None where it is not known."""
    return ACCELERATION.get(plain(unit))


def measured_by(unit: str) -> tuple[str, float] | None:
    """Which quantity a unit is one of, and its size in SI; None where it is not known."""
    word = plain(unit)
    return next(((quantity, sizes[word]) for quantity, sizes in UNITS.items() if word in sizes), None)


def units_in(text: str) -> list[str]:
    """The units of motion that a line of text names, those of one quantity over time: ``cm/s`` or ``gal``, not ``m`` or ``g``."""
    words = (word.strip(".,;:()[]#%=\"'") for word in re.split(r"[\s=]+", text))
    return [word for word in words if len(plain(word)) > 2 and measured_by(word)]


def declared_unit(text: str) -> str | None:
    """The unit that a line of text declares, of one letter, too: ``UNITS G``, ``IN UNITS OF CM/S2``, ``UNIT=gal(cm/s/s)``."""
    found = DECLARED.search(text)
    word = found[1].partition("(")[0].strip(".,;:()[]#\"'") if found else ""
    return word if word and measured_by(word) else None


def one_unit(lines: Iterable[str]) -> str | None:
    """The one unit that lines of text name, or declare where they name none; None of several."""
    every = list(lines)
    units = {unit for line in every for unit in units_in(line)} or {unit for line in every if (unit := declared_unit(line))}
    return units.pop() if len(units) == 1 else None


def split_heading(heading: str) -> tuple[str, str | None]:
    """Split a column's heading into its name and its unit: ``ns_m_s2``, ``acc [g]``, ``NS (cm/s2)``, ``time_s``."""
    heading = heading.strip().strip("\"'")
    if len(heading) > LONGEST:
        return heading, None
    bracket = re.fullmatch(r"(.*?)\s*[\[(]\s*([^\])]+)\s*[\])]", heading)
    if bracket:
        return bracket[1].strip(), bracket[2].strip()
    suffix = re.fullmatch(rf"(.+?)_({SUFFIX})", heading, re.IGNORECASE)
    if suffix:
        return suffix[1], suffix[2]
    if len(heading) > 1 and measured_by(heading):  # not of one letter, which may be a name
        return heading, heading
    name, _, last = heading.rpartition(" ")
    if name and len(last) > 1 and measured_by(last):  # not of one letter: "sensor g", "acc m"
        return name.rstrip(" ,"), last
    return heading, None
