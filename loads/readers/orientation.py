# SPDX-License-Identifier: GPL-3.0-or-later
"""Which way a channel points, by the name that its file gives it: vertical, or horizontal with an azimuth where it says one.

    HNZ, UD, U-D, Up, DWN, vert, az                     vertical
    HNE, N-S, EW, N08W, S82E, 340, "90 DEG", north      horizontal, clockwise from north
    HN1, H2, ax, long, trans, radial                    horizontal

What a name does not say, or says twice, is left open.
"""

from __future__ import annotations

import re
from pathlib import PurePath
from typing import NamedTuple

WORDS: dict[str, float | str] = {
    **dict.fromkeys(("U", "UP", "DN", "DWN", "DOWN", "Z", "UD", "DU", "VER", "VERT", "VRT", "VERTICAL", "VERTICALE"), "vertical"),
    **dict.fromkeys(("N", "S", "NS", "SN", "NORTH", "SOUTH", "NORD", "SUD", "NORTE", "SUR"), 0.0),
    **dict.fromkeys(("E", "W", "EW", "WE", "EAST", "WEST", "EST", "OVEST", "ESTE", "OESTE"), 90.0),
    **dict.fromkeys(("X", "Y", "H1", "H2", "LONG", "LONGITUDINAL", "TRAN", "TRANS", "TRANSVERSE", "RAD", "RADIAL", "H"), "horizontal"),
}
CLEAR = ("UD", "UP", "DWN", "DOWN", "VERT", "VERTICAL", "NS", "SN", "EW", "WE")  # at the end of the name of a file, too
CODE = re.compile(r"(?!CH\d)[A-Z][GHLNP]([ENZ123])")  # of SEED, band, instrument, orientation
BY_CODE: dict[str, float | str] = {"E": 90.0, "N": 0.0, "Z": "vertical", "1": "horizontal", "2": "horizontal", "3": "vertical"}
BEARING = re.compile(r"([NS])(\d{1,3})([EW])")
AZIMUTH = re.compile(r"0\d{1,2}|\d{2,3}")
LONGEST = 80  # characters of a name
PAIRED = re.compile(r"\b([NSEWUD])[-/]([NSEWUD])\b")  # N-S
PREFIXED = re.compile(r"(?:ACC|ACCEL)_?([NEUXYZ]|NS|EW|UD)|A([XYZ])|(NS|EW|UD)[12]")


class Orientation(NamedTuple):
    """The way of a channel, and what says so."""

    vertical: bool
    azimuth: float | None  # 0 to 180 degrees from north; None of a vertical channel, and where it is not known
    by: str


def of_record(name: str, path: str) -> Orientation | None:
    """Return the orientation by the name of a channel, or else by the end of the name of its file; None where neither gives it."""
    own = of_name(name)
    if own is not None:
        return Orientation(*own, f'the channel "{name}"')
    file = PurePath(path)
    ends = [word.upper() for word in (file.suffix.lstrip("."), re.split(r"[\W_]+", file.stem)[-1])]
    word = next(
        (end for end in ends if end in CLEAR or BEARING.fullmatch(end) or re.fullmatch(r"[BEH][HLN][ENZ]|(?:NS|EW|UD)[12]", end)), ""
    )
    found = of_name(word)
    return Orientation(*found, f'the file "{file.name}"') if found else None


def of_name(name: str) -> tuple[bool, float | None] | None:
    """Return True if a name is that of a vertical channel, and its azimuth; None where it gives neither or several."""
    if len(name) > LONGEST:
        return None
    text = PAIRED.sub(r"\1\2", name.strip().upper())
    if name.strip() == "V":  # v may be a velocity
        return True, None
    bare = re.sub(r"[\s_]*DEG(?:REES)?\.?$", "", text)
    if AZIMUTH.fullmatch(bare):
        return (False, float(bare) % 180.0) if float(bare) <= 360.0 else None
    found = {said for word in re.split(r"[^A-Z0-9]+", text) if (said := _of_word(word)) is not None}
    known = {said for said in found if said != "horizontal"}
    if len(known) > 1 or not found or (known == {"vertical"} and len(found) > 1):
        return None
    said = known.pop() if known else "horizontal"
    return said == "vertical", said if isinstance(said, float) else None


def _of_word(word: str) -> float | str | None:
    """Vertical, horizontal, or an azimuth; None of a word that says nothing."""
    if code := CODE.fullmatch(word):
        return BY_CODE[code[1]]
    if bearing := BEARING.fullmatch(word):
        turn = float(bearing[2]) * (1.0 if bearing[3] == "E" else -1.0)
        return (turn if bearing[1] == "N" else -turn) % 180.0
    prefixed = PREFIXED.fullmatch(word)
    return WORDS.get(next(filter(None, prefixed.groups())) if prefixed else word)
