# SPDX-License-Identifier: GPL-3.0-or-later
r"""Stones that crack along planes laid beforehand: the keys ``[material.stones]``, and the joint law of the planes within a stone.

A stone is several blocks, its pieces, which know it by name (``Block.stone``); ``structures/layout/pieces.py`` cuts them. A pair of pieces
of one stone has the law of the planes of its group, any other pair the law of its groups. The tables of friction and of joint laws have a
row for each group, and then one for the planes of each group whose stones crack: :meth:`CrackPlanes.rows` is where a pair finds its own.

**The law** is that of a bond (``joint_laws``). What is not given follows from the tensile strength f_t:

    cohesion 2 f_t     the shear strength without pressure of Griffith's criterion, tau^2 = 4 f_t (f_t + sigma), 1924
    friction 0.85      of fresh surfaces of rock under pressures below 200 MPa (Byerlee, Pure Appl. Geophys. 116, 1978)
    k_n = E / l        l the mean distance of the centres of pieces that are next to each other
    G_II               as brittle as in tension: G_II / (c^2 / 2 k_t) = G_I / (f_t^2 / 2 k_n)
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.fields import Count, Number, Table
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.by_group import of_group
from masonry_cd.mechanics.model.joint_laws import LAWS, JointLaw
from masonry_cd.mechanics.model.joint_laws.elastic import SOFTER_ALONG
from masonry_cd.mechanics.model.joint_laws.tables import JointLaws
from masonry_cd.mechanics.model.stone_kinds import STONES, stone_in_words
from masonry_cd.mechanics.model.usual import FRACTURE, FRICTION, SPLITTING, YOUNG

KEY = "material.stones"
GRIFFITH = 2.0  # cohesion over tensile strength
BYERLEE = 0.85  # friction of fresh surfaces of rock
PIECES = 4  # of a stone cut by the cells of points
MOST_PIECES = 100  # of a stone
AXES = "xyz"


class Stones(Table):
    """The table ``[material.stones]``, or one of its groups, ``[material.stones.arch]``."""

    kind: Annotated[str, Field(json_schema_extra={"enum": list(STONES)})] | None = None
    """Kind of stone, which gives tensile_strength and young as the means of a table; keys of the scene win."""
    tensile_strength: Annotated[Number, Unit("Pa"), SPLITTING, Field(gt=0)] | None = None
    """Tensile strength of the stone across the planes; needed where no kind gives it."""
    fracture_energy: Annotated[Number, Unit("N/m"), FRACTURE, Field(gt=0)] | None = None
    """G_I, what a crack takes per area when it opens; without it a plane breaks at once."""
    cohesion: Annotated[Number, Unit("Pa"), SPLITTING, Field(gt=0)] | None = None
    """Shear strength without pressure; twice the tensile strength when not given, as by Griffith's criterion."""
    shear_fracture_energy: Annotated[Number, Unit("N/m"), FRACTURE, Field(gt=0)] | None = None
    """G_II, what a crack takes per area when it shears; as brittle as in tension when not given."""
    friction: Annotated[Number, FRICTION, Field(gt=0, le=2)] = BYERLEE
    """Coefficient of friction in a crack; that of Byerlee for fresh rock when not given."""
    young: Annotated[Number, Unit("Pa"), YOUNG, Field(gt=0)] | None = None
    """Young's modulus of the stone, which gives the planes their stiffness; that of the kind, or else of the masonry, when not given."""
    planes: Literal["mid", "cross", "voronoi"] = "mid"
    """Planes of a stone: "mid", one through its centre; "cross", two; "voronoi", those between the cells of points in it."""
    across: Annotated[tuple[Literal["x", "y", "z"], ...], Field(strict=False, min_length=1, max_length=3)] | None = None
    """Axes of the scene across which stones are cut: one for "mid", two for "cross", any for the cells of "voronoi". When not given, the
    longest extent of each stone, the two longest, and all three."""
    pieces: Annotated[Count, Field(ge=2, le=MOST_PIECES)] | None = None
    """Number of pieces of "voronoi"; 4 when not given."""
    seed: Annotated[Count, Field(ge=0)] = 0
    """Seed of the points of "voronoi"."""

    @field_validator("kind")
    @classmethod
    def _is_known(cls, value: str | None) -> str | None:
        if value is not None and value not in STONES:
            raise ValueError(f"no such kind of stone{suggest(value, STONES)}; kinds: {', '.join(STONES)}")
        return value

    @field_validator("across", mode="before")
    @classmethod
    def _one_or_more(cls, value: Any) -> Any:
        return (value,) if isinstance(value, str) else value

    @model_validator(mode="after")
    def _goes_together(self) -> Stones:
        if self.tensile_strength is None and self.kind is None:
            raise ValueError("needs tensile_strength, or the kind of a stone, which gives it")
        if self.planes != "voronoi":
            idle = [key for key in ("pieces", "seed") if key in self.model_fields_set]
            if idle:
                raise ValueError(f'{idle[0]} counts with planes = "voronoi" alone')
        needed = {"mid": 1, "cross": 2}.get(self.planes)
        if self.across is not None and (len(set(self.across)) < len(self.across) or len(self.across) != (needed or len(self.across))):
            asked = {1: "one axis", 2: "two axes"}.get(needed or 0, "different axes")
            raise ValueError(f'across should be {asked} with planes = "{self.planes}", got {", ".join(self.across)}')
        if self.shear_fracture_energy is not None and self.fracture_energy is None:
            raise ValueError("shear_fracture_energy needs fracture_energy next to it: what a crack takes when it opens")
        return self

    @property
    def strength(self) -> float:
        """Tensile strength [Pa]."""
        return self.tensile_strength or self._of_kind("tensile_strength") or 0.0

    @property
    def modulus(self) -> float | None:
        """Young's modulus [Pa]; None: that of the masonry."""
        return self.young or self._of_kind("young")

    def notes(self) -> list[str]:
        """A line on what its kind gives, where one is named."""
        given = {key for key in ("tensile_strength", "young") if getattr(self, key) is not None}
        return [] if self.kind is None else [f"{KEY}: {stone_in_words(self.kind, given)}"]

    def _of_kind(self, key: str) -> float | None:
        return None if self.kind is None else STONES[self.kind].ranges()[key].mean

    def law(self, spacing: float, young: float) -> JointLaw:
        """The law of planes between pieces whose centres are so far apart [m], of a stone with such a modulus [Pa]."""
        cohesion, shear = self.cohesion or GRIFFITH * self.strength, self.shear_fracture_energy
        if shear is None and self.fracture_energy is not None:
            shear = SOFTER_ALONG * (cohesion / self.strength) ** 2 * self.fracture_energy
        return JointLaw(
            normal_stiffness=young / spacing,
            cohesion=cohesion,
            tension=self.strength,
            fracture_energy=self.fracture_energy,
            shear_fracture_energy=shear,
        )


def stones_of(stones: Mapping[str, Stones], group: str, groups: Sequence[str]) -> Stones | None:
    """What the stones of one of some groups crack by; None: they do not.

    Raises:
        InputError: a name that is not a group.
    """
    found: Stones | None = of_group(stones, group, groups, "stones") if stones else None
    return found


def stones_in_words(stones: Mapping[str, Stones]) -> list[str]:
    """A line for each group whose stones crack, with the numbers of their law."""
    return [
        f"Stones{'' if group == 'default' else f' of {group}'} crack along planes laid beforehand ({own.planes}), at a tensile strength of "
        f"{own.strength / 1e6:.3g} MPa, " + ("at once." if own.fracture_energy is None else f"softening by {own.fracture_energy:.3g} N/m.")
        for group, own in stones.items()
    ]


@dataclass(frozen=True, eq=False)
class CrackPlanes:
    """Which blocks are pieces of which stones, and the rows of the tables that hold the law of the planes within these."""

    names: tuple[str, ...]  # of the stones
    stone: np.ndarray  # (B,) number of the stone of each piece; -1: a block that does not crack
    row: np.ndarray  # (B,) of the planes of its group
    groups: tuple[int, ...]  # those whose stones crack, in the order of the rows
    spacing: tuple[float, ...]  # mean distance of the centres of neighbouring pieces in each of them [m]

    @classmethod
    def of(cls, stones: Sequence[str], group_of: np.ndarray, count: int, centre: np.ndarray) -> CrackPlanes | None:
        """Those of B blocks of ``count`` groups, by the names of their stones, with their centres of mass (B, 3) [m]; None: none cracks."""
        names = tuple(name for name, pieces in Counter(stones).items() if name and pieces > 1)
        if not names:
            return None
        number = {name: i for i, name in enumerate(names)}
        stone = np.array([number.get(name, -1) for name in stones])
        groups = tuple(np.unique(group_of[stone >= 0]).tolist())
        order = np.argsort(stone, kind="stable")
        apart = np.zeros(len(stone))
        for own in np.split(order, np.flatnonzero(np.diff(stone[order])) + 1):
            if stone[own[0]] >= 0:
                between = np.sqrt(((centre[own, None] - centre[None, own]) ** 2).sum(axis=2))
                apart[own] = np.where(np.eye(len(own), dtype=bool), np.inf, between).min(axis=1)
        spacing = tuple(float(apart[(group_of == group) & (stone >= 0)].mean()) for group in groups)
        row = np.full(count, -1)
        row[list(groups)] = count + np.arange(len(groups))
        return cls(names, stone, np.where(stone >= 0, row[group_of], -1), groups, spacing)

    def rows(self, a: np.ndarray | int, b: np.ndarray | int, group_of: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns of the tables for pairs of blocks."""
        within = (self.stone[a] >= 0) & (self.stone[a] == self.stone[b])
        return np.where(within, self.row[a], group_of[a]), np.where(within, self.row[b], group_of[b])

    def grown(self, table: np.ndarray) -> np.ndarray:
        """A table (G, G) with rows and columns of zeros for the planes."""
        return np.pad(table, (0, len(self.groups)))

    def with_laws(
        self, stones: Mapping[str, Stones], groups: Sequence[str], friction: np.ndarray, laws: JointLaws
    ) -> tuple[np.ndarray, JointLaws]:
        """Friction and joint laws between groups, with the rows of the planes.

        Args:
            stones: by group.
            groups: G names.
            friction: (G, G).
            laws: likewise, with the moduli of the masonry where it has some.

        Raises:
            InputError: stones of a group without a law, no modulus, or a law that friction or the stiffness does not allow.
        """
        mu, young = self.grown(friction), None if laws.moduli is None else laws.moduli[0]
        tables: dict[str, Any] = {name: self.grown(table) for name, table in vars(laws).items() if isinstance(table, np.ndarray)}
        for k, (group, spacing) in enumerate(zip(self.groups, self.spacing, strict=True), len(groups)):
            own = stones_of(stones, groups[group], groups)
            if own is None:
                raise InputError(KEY, f'gives no strength to the stones of group "{groups[group]}", which have pieces')
            mu[k, k] = own.friction
            for name, value in _values(own, own.law(spacing, _modulus(own, young, groups[group])), groups[group]).items():
                tables[name][k, k] = value
        return mu, replace(laws, **tables)


def _modulus(stones: Stones, young: float | None, group: str) -> float:
    """E of the stones of a group [Pa].

    Raises:
        InputError: neither stone nor masonry has one.
    """
    if stones.modulus is None and young is None:
        raise InputError(f"{KEY}.{group}", "needs young, the modulus of the stone, where no elastic masonry is named")
    return stones.modulus or young or 0.0


def _values(stones: Stones, law: JointLaw, group: str) -> dict[str, float]:
    """The law of planes as entries of the tables; faults name the key of the stones."""
    out: dict[str, float] = {}
    try:
        for one in LAWS:
            out |= one.tables(law, stones.friction, f"within stones of {group}")
    except InputError as error:
        raise error.each(lambda fault: fault._replace(place=f"{KEY}.{group}")) from None
    return out
