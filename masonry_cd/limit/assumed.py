# SPDX-License-Identifier: GPL-3.0-or-later
"""The load factor with one assumption on a structure changed at a time: bond, crushing, and the effects of fill.

Each row is a limit analysis of its own, of a vehicle without a place at the place that is then the worst. Of a bridge the verdict takes
what its scene states; where the scene states nothing, it takes what lowers the factor, all of it together. No default decides silently.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.analysis.limit.analysis import LimitOptions
from masonry_cd.app.limit_structure import LimitStructure, limit_structure
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import pressure
from masonry_cd.limit.vehicle import anywhere, at_worst
from masonry_cd.limit.whole import WholeAnalysis, analyse_whole
from masonry_cd.mechanics.model.masonry_kinds import Masonry

if TYPE_CHECKING:
    from masonry_cd.app.scene import Scene
    from masonry_cd.limit.vehicle import Crossing
    from masonry_cd.mechanics.model.fill import Fill

BRICK = Masonry.model_validate({"kind": "solid brick"})  # the assumption on masonry whose kind is not named
STRENGTH = BRICK.strength  # [Pa]
LOWER = 1e-4  # share of the factor by which a row is lower, and no rounding
SCENE, TOGETHER, ENDLESS = "scene", "together", "no finite load factor"
BY = {"boussinesq": "by Boussinesq's line load", "2:1": "2:1"}


@dataclass(frozen=True)
class AssumedRow:
    """The load factor under an assumption."""

    assumed: str  # scene, bond, crushing, fill, walls, rings, spread or together
    words: str
    factor: float | None  # None where there is no finite one, 0 where the structure does not stand
    why: str = ""  # there is none
    key: str = ""  # of the scene, and its value, that assume this; empty where no one key does
    counts: bool = False  # the scene does not state it otherwise, and it is no help: the verdict takes it where it is the least
    position: float | None = None  # of the first axle at its worst [m]; None where it is given, or nothing crosses

    @property
    def line(self) -> str:
        """The line that is shown."""
        found = self.why if self.factor is None else f"load factor {self.factor:.4g}" if self.factor else "it does not stand"
        there = "" if self.position is None or not self.factor else f" at x = {self.position:.4g} m"
        return f"{self.words}: {found}{there}{f' (--set {self.key})' if '=' in self.key else ''}"

    def numbers(self) -> dict[str, Any]:
        """For limit.json."""
        return asdict(self) | {"line": self.line}


@dataclass(frozen=True)
class Assumed:
    """The assumptions behind a load factor: a row for each, of a bridge the scene's own first."""

    rows: tuple[AssumedRow, ...] = ()

    @property
    def decides(self) -> AssumedRow | None:
        """The row that the verdict takes in place of the scene's own; None: that one holds."""
        lower = [row for row in self.rows if row.counts and _is_lower(row, self.rows[0].factor)]
        return min(lower, key=lambda row: row.factor or 0.0, default=None)

    @property
    def range(self) -> tuple[float, float] | None:
        """The least and the largest factor of a bridge; None of anything else."""
        found = [row.factor for row in self.rows if row.factor is not None]
        return (min(found), max(found)) if any(row.assumed == SCENE for row in self.rows) and found else None

    @property
    def lines(self) -> list[str]:
        """The lines that are shown."""
        lines = [row.line for row in self.rows]
        return lines if self.range is None else [*lines, "by these assumptions: load factor {:.4g} to {:.4g}".format(*self.range)]

    @property
    def brief(self) -> list[str]:
        """These lines as a verdict has them: of a bridge what decides, and the range."""
        if self.range is None:
            return [row.line for row in self.rows]
        decides, own = self.decides, self.rows[0]
        computed = own.why if own.factor is None else f"{own.factor:.4g}"
        said = [] if decides is None else [decides.words, f"{computed} as computed"]
        return [*said, "{:.4g} to {:.4g} by what is assumed".format(*self.range)]

    def numbers(self) -> dict[str, Any]:
        """For limit.json."""
        decides = None if self.decides is None else self.decides.numbers()
        return {"rows": [row.numbers() for row in self.rows], "decides": decides, "range": self.range, "brief": self.brief}


def assumed(structure: LimitStructure, whole: WholeAnalysis, crossing: Crossing | None) -> Assumed:
    """The load factors of a structure as built with its assumptions changed; none if it does not stand, or assumes nothing.

    Only of a bridge there are some where its own is not finite.
    """
    analysis, bridge = whole.analysis, bool(structure.made.fills)
    if not analysis.stands or analysis.bears_nothing or analysis.problem.moves_support or (analysis.is_endless and not bridge):
        return Assumed()
    if not bridge:
        return Assumed(tuple(_row(whole, None, *one) for one in _of_joints(structure)))
    in_plane = analysis.problem.axis is not None  # in space the places of each row take too long: it has the one that the scene has
    place = None if crossing is None else float(crossing.position[crossing.worst])
    factor, why = (None, ENDLESS) if analysis.is_endless else (analysis.governing.factor, "")
    own = AssumedRow(SCENE, f"as computed, {_in_words(structure)}", factor, why, position=place)
    changed = [*_of_joints(structure), *_of_fill(structure, whole.loads.kind != "live")]
    rows = [_row(whole, crossing if in_plane else None, *one) for one in changed]
    rows = [replace(row, words=f"{row.words}{_of_walls(row, own.factor)}") if row.assumed == "walls" else row for row in rows]
    lower = [one for one, row in zip(changed, rows, strict=True) if row.counts and _is_lower(row, own.factor)]
    if len(lower) > 1:
        rows.append(_row(whole, crossing if in_plane else None, *_together(structure, lower)))
    return Assumed((own, *(replace(row, position=place) if row.position is None else row for row in rows)))


def against(structure: LimitStructure, lowers: Callable[[LimitStructure], bool]) -> tuple[AssumedRow, LimitStructure] | None:
    """A bridge under live load with all unstated values assumed unfavourably, and the row of that without its factor.

    Args:
        structure: as its scene states it.
        lowers: True of one whose wheels are spread the other way and which bears less; all else that is left open never helps.

    Returns:
        None where the scene leaves nothing open.
    """
    every = [one for one in (*_of_joints(structure), *_of_fill(structure, False)) if one[0].counts]
    lower = [(row, other) for row, other in every if row.assumed != "spread" or lowers(other)]
    return _together(structure, lower) if lower else None


def _together(structure: LimitStructure, changes: Sequence[tuple[AssumedRow, LimitStructure]]) -> tuple[AssumedRow, LimitStructure]:
    """A structure with several changes, each of something else, and their row."""
    both = structure
    for _, other in changes:
        both = _merged(both, structure, other)
    words, key = " and ".join(row.words for row, _ in changes), " ".join(row.key for row, _ in changes)
    return AssumedRow(TOGETHER, words, None, key=key, counts=True), both


def _is_lower(row: AssumedRow, own: float | None) -> bool:
    return row.factor is not None and (own is None or row.factor < (1.0 - LOWER) * own)


def _of_walls(bare: AssumedRow, own: float | None) -> str:
    """What walls do to the factor: they stiffen the arches until they slide or lean out, after which the arches bear alone."""
    if _is_lower(bare, own):
        return ", which stiffen the arches"
    return "" if own is None or bare.factor is None or bare.factor < (1.0 + LOWER) * own else ", which give way before the arches"


def _merged(one: LimitStructure, built: LimitStructure, other: LimitStructure) -> LimitStructure:
    """A structure with the change of another one as well; each changed something else of the structure as built."""

    def changed(old: Fill, new: Fill) -> dict[str, Any]:
        keys = ("passive", "passive_shaken", "spread")
        return {key: getattr(new, key) for key in keys if getattr(new, key) != getattr(old, key)}

    every = zip(one.made.fills, built.made.fills, other.made.fills, strict=True)
    fills = [replace(fill, **changed(old, new)) for fill, old, new in every]
    assembly = one.assembly if other.assembly is built.assembly else other.assembly
    return replace(one, made=one.made._replace(fills=fills), assembly=assembly)


def _of_joints(structure: LimitStructure) -> Iterator[tuple[AssumedRow, LimitStructure]]:
    """Rows of the assumptions on joints, without their factors, and their structures."""
    assembly, laws, material = structure.assembly, structure.assembly.laws, structure.scene.material
    if laws.apex.any():
        yield (
            AssumedRow("bond", "without the bond of its joints", None),
            replace(structure, assembly=replace(assembly, laws=laws.unbonded())),
        )
    if laws.crushing.any():
        row = AssumedRow("crushing", "without crushing, of joints of any strength", None)
        yield row, replace(structure, assembly=replace(assembly, laws=replace(laws, crushing=0.0 * laws.crushing)))
    elif structure.made.fills:
        named, (strength, source) = material.masonry, strength_of(structure)
        words = f"with joints that crush at {pressure(strength)} ({source})"
        crushing = replace(laws, crushing=np.full_like(laws.crushing, strength))
        open_ = named is None or "crushing" not in named.model_fields_set
        row = AssumedRow("crushing", words, None, key=f"material.joints.compressive_strength={strength:g}", counts=open_)
        yield row, replace(structure, assembly=replace(assembly, laws=crushing))


def strength_of(structure: LimitStructure) -> tuple[float, str]:
    """The compressive strength of the joints of a bridge [Pa], the least where they differ, and where it is from."""
    own, named = structure.assembly.laws.crushing, structure.scene.material.masonry
    if own.any():
        return float(own[own > 0.0].min()), "of the scene" if named is None else named.kind
    return (STRENGTH, f"{BRICK.kind}, assumed") if named is None else (named.strength, named.kind)


def against_fill(structure: LimitStructure) -> tuple[AssumedRow, LimitStructure] | None:
    """A bridge under live load whose fill does not resist, where its scene leaves that open, and the row of it."""
    return next((one for one in _of_fill(structure, False) if one[0].assumed == "fill" and one[0].counts), None)


def _of_fill(structure: LimitStructure, shaken: bool) -> Iterator[tuple[AssumedRow, LimitStructure]]:
    """Rows of the assumptions on fill and walls, with their structures."""
    name, fills, scene = "passive_shaken" if shaken else "passive", structure.made.fills, structure.scene
    open_, where = not all(_states(scene, fill, name) for fill in fills), fills[0].where
    if any(getattr(fill, name) > 0.0 for fill in fills):
        row = AssumedRow("fill", "without passive pressure of the fill", None, key=f"{where}.{name}=0", counts=open_)
        yield row, _with_fills(structure, **{name: 0.0})
    if any(getattr(fill, name) < 1.0 for fill in fills):
        yield AssumedRow("fill", "with all of K_p", None, key=f"{where}.{name}=1"), _with_fills(structure, **{name: 1.0})
    if "walls" in scene.structure:
        bare = replace(scene, structure={key: value for key, value in scene.structure.items() if key != "walls"})
        yield AssumedRow("walls", "without spandrel walls", None, key="without structure.walls"), limit_structure(bare)
    ringed = [i for i, span in enumerate(scene.structure.get("spans") or ()) if span.get("rings", 1) > 1]
    if ringed:
        spans = [{**span, "rings": 1} for span in scene.structure["spans"]]
        one = limit_structure(replace(scene, structure={**scene.structure, "spans": spans}))
        yield AssumedRow("rings", "with rings that are one", None, key=" ".join(f"structure.spans[{i}].rings=1" for i in ringed)), one
    if any(load.get("kind") == "vehicle" for load in scene.loads):
        other = "2:1" if fills[0].spread == "boussinesq" else "boussinesq"
        open_ = not all(_states(scene, fill, "spread") for fill in fills)
        row = AssumedRow("spread", f"with wheels spread {BY[other]}", None, key=f"{where}.spread={other}", counts=open_)
        yield row, _with_fills(structure, spread=other)


def _with_fills(structure: LimitStructure, **keys: Any) -> LimitStructure:
    return replace(structure, made=structure.made._replace(fills=[replace(fill, **keys) for fill in structure.made.fills]))


def _states(scene: Scene, fill: Fill, name: str) -> bool:
    """True where a scene gives a key of a fill; files always do."""
    number = fill.where.removeprefix("structures[").partition("]")[0]
    table = scene.structures[int(number)] if number.isdigit() else scene.structure
    given = table.get("fill") or {}
    return table.get("kind") == "file" or name in given


def _in_words(structure: LimitStructure) -> str:
    """Return the assumptions of a scene on its fill, and if the scene states them."""
    fill, scene = structure.made.fills[0], structure.scene

    def by(name: str) -> str:
        return "" if _states(scene, fill, name) else " by default"

    name = "passive" if structure.loads().kind == "live" else "passive_shaken"
    said = [f"{getattr(fill, name):.3g} of K_p{by(name)}"]
    if any(load.get("kind") == "vehicle" for load in scene.loads):
        said.append(f"wheels spread {BY[fill.spread]}{by('spread')}")
    return ", ".join([*said, "joints that crush" if structure.assembly.laws.crushing.any() else "joints of any strength"])


def _row(whole: WholeAnalysis, crossing: Crossing | None, row: AssumedRow, changed: LimitStructure) -> AssumedRow:
    """A row with its factor, 0 where the structure does not stand; or with why there is no finite one."""
    how = replace(whole.how, begins_at_parts=False)
    if not changed.made.fills:
        how = replace(how, analysis=LimitOptions(starts=0), most=0)  # the associated factor alone, a programme each
    try:
        if crossing is not None:
            first = float(crossing.position[crossing.worst])
            changed, crossing = at_worst(changed.of(anywhere(changed.scene, crossing.load)), first=first)
        changed = replace(changed, asked=changed.asked.model_copy(update={"check": None, "curve": None}))
        found = analyse_whole(changed, changed.loads(), how, ()).analysis
    except InputError as failure:
        return replace(row, why=f"no answer, {failure}")
    place = None if crossing is None else float(crossing.position[crossing.worst])
    if not found.stands:
        return replace(row, factor=0.0)
    if found.is_endless:
        return replace(row, why=ENDLESS)
    return replace(row, factor=found.governing.factor, position=place)
