"""What a series is, acceleration, velocity or displacement, where a file says so: by words of its heading or by a SEED channel code.

Band, instrument, orientation are the letters of a channel code (FDSN, "SEED Reference Manual", 2012, appendix A): HNE is the east component
of an accelerometer, HHE that of a broadband seismometer, whose counts follow the velocity. A code names the instrument; where its response
has been taken out the samples may be another quantity, so the user may say otherwise. A word of a heading holds.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

WORDS = {
    "acceleration": r"acc|accel|accelerations?|accelerograms?|accelerazion[ei]|aceleraci[oó]n(?:es)?|acelerograma",
    "velocity": r"vel|veloc|velocity|velocities|velocit[aà]|velocidad(?:es)?",
    "displacement": r"disp|displ|displacements?|spostament[oi]|desplazamientos?",
}
ELSE = re.compile(
    r"vs ?\d+|\b(?:wave|shear|peak|pg[avd]|soil|site|model|fault|rupture)\b", re.IGNORECASE
)  # a comment on the ground, or on a peak
CODE = re.compile(r"[A-Z][A-Z0-9][A-Z0-9]")
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
    """What a file says its series is."""

    quantity: str  # "" where the sensor may follow several, or no motion of the ground
    by: str  # what says so
    firm: bool  # the user cannot say otherwise


def of_channel(code: str) -> Stated | None:
    """By a channel code such as "HNE"; None where it is none, or names no instrument that is known."""
    known = INSTRUMENTS.get(code[1:2].upper()) if CODE.fullmatch(code.strip().upper()) else None
    return Stated(known[0], f"channel {code}, that of {known[1]}", firm=False) if known else None


def named(text: str) -> str:
    """The one quantity that words of a text name; "" where there are none or several."""
    words = re.findall(r"[^\W\d_]+", text.lower())
    found = [quantity for quantity, pattern in WORDS.items() if any(re.fullmatch(pattern, word) for word in words)]
    return found[0] if len(found) == 1 else ""


def of_comments(lines: Iterable[str]) -> Stated | None:
    """By the comments or other text above a table, which may speak of something else: so the user may say otherwise."""
    found = {quantity: line for line in lines if (quantity := named(line)) and not ELSE.search(line)}
    if len(found) != 1:
        return None
    quantity, line = next(iter(found.items()))
    return Stated(quantity, f'the line "{line.strip()[:60]}"', firm=False)
