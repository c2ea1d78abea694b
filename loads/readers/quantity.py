# SPDX-License-Identifier: GPL-3.0-or-later
"""Quantity of a series, acceleration, velocity or displacement, where a file gives it: by words of its heading or by a SEED channel code.

Band, instrument, orientation are the letters of a channel code (FDSN, "SEED Reference Manual", 2012, appendix A): HNE is the east component
of an accelerometer, HHE that of a broadband seismometer, whose counts follow the velocity. A code names the instrument; where its response
has been taken out the samples may be another quantity, so the user may say otherwise. A word of a heading holds.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

from loads.readers.units import measured_by, units_in

WORDS = {
    "acceleration": r"acc|accel|accelerations?|accelerograms?|accelerazion[ei]"
    r"|aceleraci[oó]n(?:es)?|acelerograma|acc[eé]l[eé]rations?|beschleunigung(?:en)?",
    "velocity": r"vel|veloc|velocity|velocities|velocit[aà]|velocidad(?:es)?|vitesses?|geschwindigkeit(?:en)?",
    "displacement": r"disp|displ|displacements?|spostament[oi]|desplazamientos?|d[eé]placements?|verschiebung(?:en)?",
}
ELSE = re.compile(
    r"\bvs|\b(?:wave|shear|peak|pg[avd]|soil|site|model|fault|rupture)\b", re.IGNORECASE
)  # a comment on the ground, or on a peak
CODE = re.compile(r"[A-Z][A-Z0-9][A-Z0-9]")
SPOKEN_CODE = re.compile(r"\b[BEH][GHLNP][ENZ123]\b")  # in a text: bands and orientations of ground motion, "HHE" but not "CH1" or "THE"
INSTRUMENTS = {
    "N": ("acceleration", "an accelerometer"),
    "G": ("acceleration", "a gravimeter or accelerometer"),
    "H": ("velocity", "a high-gain seismometer, which follows the velocity"),
    "P": ("velocity", "a geophone, which follows the velocity"),
    "L": ("", "a low-gain sensor, which follows the velocity by the SEED manual and the acceleration in older networks"),
    "M": ("", "the mass position of a seismometer"),
    "J": ("", "a rotational sensor"),
    "A": ("", "a tiltmeter"),
    "D": ("", "a pressure sensor"),
    "F": ("", "a magnetometer"),
    "S": ("", "a strain meter"),
    "V": ("", "a strain meter"),
    "K": ("", "a thermometer"),
    "W": ("", "a wind sensor"),
}


class Stated(NamedTuple):
    """Quantity of a series as its file states it."""

    quantity: str  # "" where the sensor may follow several, or no motion of the ground
    by: str  # what says so
    firm: bool  # the user cannot say otherwise


def of_format(kind: str) -> Stated:
    """Return the quantity of a format that has nothing but accelerations."""
    return Stated("acceleration", f"the format of {kind} files", firm=True)


def of_channel(code: str) -> Stated | None:
    """Return the quantity by a channel code such as "HNE"; None where it is none, or names no instrument that is known."""
    known = INSTRUMENTS.get(code[1:2].upper()) if CODE.fullmatch(code.strip().upper()) else None
    return Stated(known[0], f"channel {code}, that of {known[1]}", firm=False) if known else None


def named(text: str) -> str:
    """The one quantity that words of a text name; "" where there are none or several."""
    words = re.findall(r"[^\W\d_]+", text.lower())
    found = [quantity for quantity, pattern in WORDS.items() if any(re.fullmatch(pattern, word) for word in words)]
    return found[0] if len(found) == 1 else ""


def of_comments(lines: Iterable[str]) -> Stated | None:
    """Return the quantity by the comments or other text above a table, which may speak of something else: so the user may say otherwise.

    Words hold before units, and units before channel codes.
    """
    spoken = [line for line in lines if not ELSE.search(line)]
    for says in (named, _by_units):
        found = {quantity: line for line in spoken if (quantity := says(line))}
        if found:
            quantity, line = next(iter(found.items()))
            return Stated(quantity, f'the line "{line.strip()[:60]}"', firm=False) if len(found) == 1 else None
    return next((stated for line in spoken if (stated := of_spoken_channel(line))), None)


def of_spoken_channel(text: str) -> Stated | None:
    """Return the quantity by a channel code within a text, as in "IV.AQK..HHE"; None where there is none."""
    code = SPOKEN_CODE.search(text)
    return of_channel(code[0]) if code else None


def _by_units(text: str) -> str:
    """The one quantity that the units in a text are of; "" where there are none, or of several."""
    found = {measured[0] for unit in units_in(text) if (measured := measured_by(unit))}
    return found.pop() if len(found) == 1 else ""
