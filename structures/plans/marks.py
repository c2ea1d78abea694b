# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts of a plan that mean something: heights, sills, shapes, thicknesses, names, as surveys write them in English and Italian.

    h=2.10  h. 2,10  H 210        height           alt. altezza height
    s=0.90  dav. 90               sill             davanzale, parapetto, sill
    210/90                        height over sill; where one of the two is the width as drawn, the other is the height: 90/210
    +8.50  q. +8.50               level of the top
    h=7.5/9.8/7.5                 of a wall: heights at equal stations from its start, a gable
    sp. 60  t=0.60                thickness        spessore, thickness
    imp. 4.50  springing 4.50     of a vault       imposta
    f=1.20  freccia  rise=1.20    rise of an arch or a vault
    ring=0.3  ghiera 0.3          depth of its ring
    l=1.60  w=1.60  diam. 160     width, where the drawing has another one, as of a rose over a door
    arco ribassato, round arch    shapes: see SHAPES and VAULTS

Numbers from 20 on without a point are centimetres, from 1000 on millimetres; with ``m``, ``cm`` or ``mm`` behind them what that says.
"""

from __future__ import annotations

import re
import unicodedata
from typing import NamedTuple

NUMBER = r"[-+]?\d{1,6}(?:[.,]\d{1,6})?(?:\s*(?:mm|cm|m)\b)?"
WORDS = {
    "height": r"altezza|height|alt|hn|h",
    "sill": r"davanzale|dav|parapetto|par|sill|s",
    "thickness": r"spessore|thickness|thk|sp|t",
    "springing": r"imposta|imp|springing",
    "rise": r"freccia|rise|f",
    "ring": r"ghiera|ring",
    "depth": r"profondita|prof|depth|p",
    "base": r"base|b",
    "width": r"larghezza|luce|width|diametro|diam|l|w",
}
KEYED = {name: re.compile(rf"(?<![a-z0-9])(?:{words})\s*[.:=]*\s*({NUMBER}(?:\s*/\s*{NUMBER})*)") for name, words in WORDS.items()}
LEVEL = re.compile(rf"(?:(?<![a-z0-9])(?:quota|q|lev|level|el)\s*[.:=]*\s*)?(?<![\w.])(\+\s*{NUMBER})")
PAIR = re.compile(rf"(?<![\w.+/])({NUMBER})\s*/\s*({NUMBER})(?!\s*/)")
TOKEN = re.compile(r"^[a-z_]\w*$")
SHAPES = {
    "niche": r"nicchia|niche",
    "rose": r"rosone|rosa|rose|oculo|oculus",
    "pointed": r"acuto|ogiva\w*|pointed|gothic",
    "segmental": r"ribassat\w+|segmental",
    "round": r"tutto sesto|tonda?|round|semicirc\w+",
    "rectangular": r"architravat\w+|rectangular|rettangolare|lintel\w*",
}
VAULTS = {
    "cross": r"crociera|cross|groin",
    "domical": r"padiglione|domical|cloister",
    "dome": r"cupola|calotta|dome",
    "barrel": r"botte|barrel",
}
WINDOW = re.compile(r"(?<![a-z])(finestra|finestre|window|windows|fin|win)(?![a-z])")
DOOR = re.compile(r"(?<![a-z])(porta|porte|portone|door|doors)(?![a-z])")
CENTIMETRES, MILLIMETRES = 20.0, 1000.0  # from where on a whole number without a unit is one of these


class Marks(NamedTuple):
    """Measures in a text [m]."""

    numbers: dict[str, float]  # height, sill, thickness, springing, rise, ring, depth, base, width, level
    profile: tuple[float, ...]  # heights at equal stations
    pair: tuple[float, float] | None  # height / sill, or width / height
    shape: str  # of an opening
    vault: str
    kind: str  # "door", "window" or ""
    name: str

    @property
    def means_nothing(self) -> bool:
        """Return True if there is none of all that, a name apart."""
        return not (self.numbers or self.profile or self.pair or self.shape or self.vault or self.kind)

    @property
    def is_of_opening(self) -> bool:
        """Return True if this can be of an opening only."""
        return bool(self.pair or self.shape or self.kind or {"sill", "ring", "depth"} & set(self.numbers))


def read(text: str) -> Marks:
    """The marks of a text; what is left in front of them, if it is one to three words, is a name."""
    plain = "".join(c for c in unicodedata.normalize("NFKD", text) if not unicodedata.combining(c)).replace("±", "+")
    low, first = plain.lower(), len(plain)
    numbers: dict[str, float] = {}
    profile: tuple[float, ...] = ()
    rest = low
    for name, pattern in KEYED.items():
        if found := pattern.search(rest):
            values = tuple(metres(part) for part in found.group(1).split("/"))
            if name == "height" and len(values) > 2:
                profile = values
            elif name == "height" and len(values) == 2:
                numbers["height"], numbers["sill"] = values
            else:
                numbers[name] = values[0]
            first = min(first, found.start())
            rest = rest[: found.start()] + " " * len(found.group()) + rest[found.end() :]
    if found := LEVEL.search(rest):
        numbers["level"] = metres(found.group(1))
        first = min(first, found.start())
        rest = rest[: found.start()] + " " * len(found.group()) + rest[found.end() :]
    pair = None
    if found := PAIR.search(rest):
        pair = (metres(found.group(1)), metres(found.group(2)))
        first = min(first, found.start())
    shape, place = _word(SHAPES, low)
    first = min(first, place)
    vault, _ = _word(VAULTS, low)
    kind = "window" if WINDOW.search(low) else "door" if DOOR.search(low) else ""
    return Marks(numbers, profile, pair, shape, vault, kind, name_in(plain[:first]))


def _word(table: dict[str, str], low: str) -> tuple[str, int]:
    """Which of some meanings a text has, and where it says so; none at its end."""
    found = [(word, match.start()) for word, pattern in table.items() if (match := re.search(rf"\b(?:{pattern})\b", low))]
    return found[0] if found else ("", len(low))


def metres(text: str) -> float:
    """A number of a mark in metres."""
    text = text.replace(" ", "")
    digits = text.rstrip("cm").replace(",", ".")
    value, unit = float(digits), text[len(digits) :]
    if not unit:
        unit = "m" if "." in digits or abs(value) < CENTIMETRES else "mm" if abs(value) >= MILLIMETRES else "cm"
    return round(value * {"m": 1.0, "cm": 0.01, "mm": 0.001}[unit], 6)


def name_in(text: str) -> str:
    """A name that stands in front of marks: lower case, words joined by an underscore; empty where it is none."""
    words = re.findall(r"\w+", re.sub(r"(?i)^\s*(muro|wall|name|nome)\s*[:=]", " ", text.lower()))
    joined = "_".join(words)
    return joined if len(words) <= 3 and TOKEN.match(joined) and len(joined) <= 40 else ""
