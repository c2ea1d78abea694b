# SPDX-License-Identifier: GPL-3.0-or-later
"""Existing masonry by kind: the key ``material.masonry`` of a scene, and the values that tables of the Italian code give for it.

Tables C8.5.I, ranges of each kind, and C8.5.II, factors for what makes it better, of Circolare 21 January 2019 n. 7, paragraph C8.5.3.1
(Gazzetta Ufficiale 35, 11 February 2019, supplement 5). Where little is known, LC1, strengths are the least of their range; else, and
moduli always, the mean. Tensile strength and friction are not in these tables.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import BeforeValidator, Field, field_validator, model_validator

from masonry_cd.foundation.errors import suggest
from masonry_cd.foundation.fields import Flag, Number, Table
from masonry_cd.foundation.quantities import pressure
from masonry_cd.foundation.table_schema import Schema, table_schema
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.usual import BOND, COMPRESSION, DENSITY, YOUNG

MPA = 1e6  # [Pa]
KN_PER_M3 = 1e3 / 9.80665  # density of what weighs a kilonewton per cubic metre [kg/m3]
CONFIDENCE = {"LC1": 1.35, "LC2": 1.20, "LC3": 1.00}  # factor FC by which the code divides strengths, by level of knowledge
RIGID = "rigid"
NO_FACTOR = "the tables have none for it: give the value itself"


class Range(NamedTuple):
    """The least and the largest value of a kind."""

    least: float
    largest: float

    @property
    def mean(self) -> float:
        """Between them."""
        return 0.5 * (self.least + self.largest)

    def times(self, factor: float) -> Range:
        """Both, by a factor."""
        return Range(factor * self.least, factor * self.largest)


@dataclass(frozen=True)
class MasonryKind:
    """A row of table C8.5.I, and that of C8.5.II."""

    italian: str
    compressive: Range  # f [MPa]
    shear: Range  # tau_0, of a panel that cracks along its diagonal [MPa]
    sliding: Range | None  # f_v0, of regular bond along its beds, without compression [MPa]
    young: Range  # E [MPa]
    rigidity: Range  # G [MPa]
    weight: Range  # w [kN/m3]
    factors: tuple[float | None, ...]  # largest ones, in the order of BETTER; None: not for this kind
    at_most: float  # all of them together


BETTER = {
    "good mortar": "malta di buone caratteristiche",
    "brick courses": "ricorsi o listature",
    "transverse connections": "connessioni trasversali sistematiche",
    "grout injection": "iniezioni di miscele leganti",
    "reinforced plaster": "intonaco armato",
    "reinforced repointing": "ristilatura armata con connessione dei paramenti",
}
"""Features that make masonry better than its kind, and their names in the code."""
AS_FOUND = ("good mortar", "brick courses", "transverse connections")  # of them the two with the largest factors count
STIFFENING = {"good mortar": 1.0, "grout injection": 1.0, "reinforced plaster": 1.0, "reinforced repointing": 0.5}  # share on moduli
NOT_WITH_PLASTER = ("transverse connections", "reinforced repointing")  # which do not count with reinforced plaster
NO_BEDS = "brick courses"  # do nothing for f_v0

KINDS = {
    "irregular stone": MasonryKind(
        "muratura in pietrame disordinata (ciottoli, pietre erratiche e irregolari)",
        Range(1.0, 2.0), Range(0.018, 0.032), None, Range(690, 1050), Range(230, 350), Range(19, 19), (1.5, 1.3, 1.5, 2.0, 2.5, 1.6), 3.5,
    ),
    "roughly dressed stone": MasonryKind(
        "muratura a conci sbozzati, con paramenti di spessore disomogeneo",
        Range(2.0, 2.0), Range(0.035, 0.051), None, Range(1020, 1440), Range(340, 480), Range(20, 20), (1.4, 1.2, 1.5, 1.7, 2.0, 1.5), 3.0,
    ),
    "split stone": MasonryKind(
        "muratura in pietre a spacco con buona tessitura",
        Range(2.6, 3.8), Range(0.056, 0.074), None, Range(1500, 1980), Range(500, 660), Range(21, 21), (1.3, 1.1, 1.3, 1.5, 1.5, 1.4), 2.4,
    ),
    "irregular soft stone": MasonryKind(
        "muratura irregolare di pietra tenera (tufo, calcarenite, ecc.)",
        Range(1.4, 2.2), Range(0.028, 0.042), None, Range(900, 1260), Range(300, 420), Range(13, 16), (1.5, 1.2, 1.3, 1.4, 1.7, 1.1), 2.0,
    ),
    "regular soft stone": MasonryKind(
        "muratura a conci regolari di pietra tenera (tufo, calcarenite, ecc.)", Range(2.0, 3.2), Range(0.04, 0.08), Range(0.10, 0.19),
        Range(1200, 1620), Range(400, 500), Range(13, 16), (1.6, None, 1.2, 1.2, 1.5, 1.2), 1.8,
    ),
    "squared stone": MasonryKind(
        "muratura a blocchi lapidei squadrati", Range(5.8, 8.2), Range(0.09, 0.12), Range(0.18, 0.28),
        Range(2400, 3300), Range(800, 1100), Range(22, 22), (1.2, None, 1.2, 1.2, 1.2, None), 1.4,
    ),
    "solid brick": MasonryKind(  # good mortar: the strength of the mortar to the power of 0.35, so no number here
        "muratura in mattoni pieni e malta di calce", Range(2.6, 4.3), Range(0.05, 0.13), Range(0.13, 0.27),
        Range(1200, 1800), Range(400, 600), Range(18, 18), (None, None, 1.3, 1.2, 1.5, 1.2), 1.8,
    ),
    "hollow brick": MasonryKind(
        "muratura in mattoni semipieni con malta cementizia (foratura fino al 40 %)", Range(5.0, 8.0), Range(0.08, 0.17),
        Range(0.20, 0.36), Range(3500, 5600), Range(875, 1400), Range(15, 15), (1.2, None, None, None, 1.3, None), 1.3,
    ),
}  # fmt: skip
"""Kinds by plain English names."""

Modulus = Annotated[Number, Unit("Pa"), YOUNG, Field(ge=1e5, le=1e13)]
Stress = Annotated[Number, Unit("Pa"), Field(ge=1.0, le=1e10)]


class Masonry(Table):
    """The table ``[material.masonry]``, or its kind alone as ``masonry = "squared stone"``."""

    kind: Annotated[str, Field(json_schema_extra={"enum": list(KINDS)})]
    """Kind of masonry of table C8.5.I of Circolare 7/2019."""
    stiffness: Literal["mean", "least", "largest", "rigid"] = "mean"
    """Value of the range of E and G for the joints, or "rigid" for rigid joints."""
    knowledge: Literal["LC1", "LC2", "LC3"] = "LC2"
    """Level of knowledge of the code: at LC1 strengths are the least of their range, else the mean. Strengths are not divided by its
    confidence factor."""
    better: tuple[str, ...] = Field((), strict=False, json_schema_extra={"items": {"type": "string", "enum": list(BETTER)}})
    """Features that make the masonry better than its kind, by the largest factors of table C8.5.II: "good mortar", "brick courses",
    "transverse connections", "grout injection", "reinforced plaster", "reinforced repointing"."""
    shear_bond: Flag = False
    """Give joints the shear strength f_v0 of the table as their cohesion, where they have none of their own. [material.joints] then says
    what tension they have, which the table does not."""
    crushing: Flag = False
    """Give joints the compressive strength f of the table, where they have none of their own; in limit analyses of bridges true when not
    given."""
    E: Modulus | None = None
    """Young's modulus of the masonry instead of the table's; G follows in proportion where it is not given."""
    G: Modulus | None = None
    """Shear modulus instead of the table's."""
    density: Annotated[Number, Unit("kg/m3"), DENSITY, Field(ge=100.0, le=1e4)] | None = None
    """Instead of the table's."""
    compressive_strength: Annotated[Stress, COMPRESSION] | None = None
    """Instead of the table's f."""
    bed_strength: Annotated[Stress, BOND] | None = None
    """Instead of the table's f_v0, shear strength of beds without compression."""

    @field_validator("kind")
    @classmethod
    def _is_known(cls, value: str) -> str:
        if value not in KINDS:
            raise ValueError(f"no such kind of masonry{suggest(value, KINDS)}; kinds: {', '.join(KINDS)}")
        return value

    @model_validator(mode="after")
    def _fits_its_kind(self) -> Masonry:
        for name in self.better:
            if name not in BETTER:
                raise ValueError(f'better: "{name}" is none of {", ".join(BETTER)}')
            if KINDS[self.kind].factors[list(BETTER).index(name)] is None:
                raise ValueError(f'better: "{name}" of {self.kind}: {NO_FACTOR}')
            if name in NOT_WITH_PLASTER and "reinforced plaster" in self.better:
                raise ValueError(f'better: "{name}" does not count with "reinforced plaster"')
        if self.shear_bond and self.bed_strength is None and KINDS[self.kind].sliding is None:
            raise ValueError(f"shear_bond: {self.kind} has no regular beds, so the table gives no f_v0; bed_strength does")
        return self

    @property
    def moduli(self) -> tuple[float, float] | None:
        """E and G of the joints' stiffness [Pa]; None: they are rigid."""
        if self.stiffness == RIGID:
            return None
        row, at = KINDS[self.kind], {"least": 0, "largest": 1}.get(self.stiffness)
        factor = MPA * self._factor(STIFFENING)
        young, rigidity = (factor * (values.mean if at is None else values[at]) for values in (row.young, row.rigidity))
        chosen = self.E or young
        return chosen, self.G or rigidity * chosen / young

    @property
    def mean_density(self) -> float:
        """[kg/m3]."""
        return self.density or KN_PER_M3 * KINDS[self.kind].weight.mean

    @property
    def strength(self) -> float:
        """Compressive strength f [Pa]."""
        return self.compressive_strength or self._known(self.ranges()["compressive_strength"])

    @property
    def cohesion(self) -> float:
        """Cohesion of joints [Pa]; 0 where it is not wanted."""
        beds = self.ranges().get("bed_strength")
        return 0.0 if not self.shear_bond else self.bed_strength or (self._known(beds) if beds else 0.0)

    def ranges(self) -> dict[str, Range]:
        """Least and largest value of each property by the tables, without corrections, in SI units."""
        row = KINDS[self.kind]
        stronger, stiffer = (MPA * self._factor(shares) for shares in (dict.fromkeys(BETTER, 1.0), STIFFENING))
        out = {
            "E": row.young.times(stiffer),
            "G": row.rigidity.times(stiffer),
            "density": row.weight.times(KN_PER_M3),
            "compressive_strength": row.compressive.times(stronger),
            "shear_strength": row.shear.times(stronger),
        }
        beds = {name: 1.0 for name in BETTER if name != NO_BEDS}
        return out if row.sliding is None else out | {"bed_strength": row.sliding.times(MPA * self._factor(beds))}

    def _known(self, values: Range) -> float:
        return values.least if self.knowledge == "LC1" else values.mean

    def _factor(self, shares: Mapping[str, float]) -> float:
        """Return the factor of table C8.5.II: the product of those that apply, of those as found the two largest, up to the limit."""
        row = KINDS[self.kind]
        own = dict(zip(BETTER, row.factors, strict=True))
        each = {name: 1.0 + shares[name] * ((own[name] or 1.0) - 1.0) for name in self.better if name in shares}
        found = sorted((each.pop(name) for name in AS_FOUND if name in each), reverse=True)[:2]
        product = 1.0
        for factor in (*found, *each.values()):
            product *= factor
        return min(product, row.at_most)


def _as_table(value: Any) -> Any:
    """The name of a kind stands for a table with it."""
    if isinstance(value, str):
        return {"kind": value}
    if value is None or isinstance(value, (Mapping, Masonry)):
        return value
    raise ValueError(f"should be the name of a kind of masonry, or a table with its kind; kinds: {', '.join(KINDS)}")


def _name_or_table(schema: Schema) -> None:
    """The key in the schema of scenes."""
    schema["anyOf"] = [{"type": "string", "enum": list(KINDS)}, table_schema(Masonry)]


MasonryKey = Annotated[Masonry | None, BeforeValidator(_as_table), Field(json_schema_extra=_name_or_table)]


def facts(masonry: Masonry) -> dict[str, Any]:
    """Return the values that a run takes of a kind of masonry, and the ranges of the tables, in SI units, for summary.json."""
    taken: dict[str, float] = {"density": masonry.mean_density, "compressive_strength": masonry.strength}
    taken |= dict(zip(("E", "G"), masonry.moduli or (), strict=False)) | ({"cohesion": masonry.cohesion} if masonry.shear_bond else {})
    ranges = {name: [*values, values.mean] for name, values in masonry.ranges().items()}
    confidence = CONFIDENCE[masonry.knowledge]
    return {"kind": masonry.kind, "taken": taken, "least_largest_mean": ranges, "confidence_factor_not_applied": confidence}


def in_words(masonry: Masonry) -> str:
    """Return a line on the values that a run takes of a kind of masonry, and of which range."""
    said, ranges = [f"density {masonry.mean_density:.0f} kg/m3"], masonry.ranges()
    for name, value in zip(("E", "G"), masonry.moduli or (), strict=False):
        said.append(f"{name} {pressure(value)} ({pressure(ranges[name].least)} to {pressure(ranges[name].largest)} by the table)")
    return f"masonry: {masonry.kind}, {', '.join(said)}{'' if masonry.moduli else ', joints rigid'}"
