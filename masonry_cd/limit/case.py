# SPDX-License-Identifier: GPL-3.0-or-later
"""The limit analysis of a scene: the whole under its load, its parts with all other blocks held, and the one verdict on all of them."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.analysis.code_check.check import borne_by_another, with_borne
from masonry_cd.analysis.code_check.ground import Ground, ground_of
from masonry_cd.analysis.code_check.level import foundation_of
from masonry_cd.analysis.code_check.site import known_at
from masonry_cd.analysis.code_check.verdicts import NO_SEARCH, CheckVerdict, refused, undecided, worst
from masonry_cd.analysis.limit.descent import watched
from masonry_cd.analysis.limit.found import says_the_same
from masonry_cd.analysis.limit.macro import ElementAnalysis
from masonry_cd.app.doubts import check_doubts, doubts
from masonry_cd.app.limit_structure import LimitStructure, limit_structure
from masonry_cd.app.progress import Progress
from masonry_cd.app.scene import Scene, read_scene
from masonry_cd.app.summary import masses
from masonry_cd.foundation.errors import InputError
from masonry_cd.limit.assumed import Assumed, assumed
from masonry_cd.limit.checked import Checked, checked, gravest, in_order, way_words, weakest_of
from masonry_cd.limit.kept import KeptParts
from masonry_cd.limit.parts import along, analysed, asked_for, effort_of, in_pieces, whole_of
from masonry_cd.limit.rating import Rating, rating, refuse_rating
from masonry_cd.limit.search import doubt_of, search_numbers, ways
from masonry_cd.limit.service import Service, refuse_service, service
from masonry_cd.limit.vehicle import PATTERNS, Crossing, at_worst
from masonry_cd.limit.whole import WholeAnalysis, analyse_whole, as_part
from masonry_cd.mechanics.contact.find_joints import built_gap, loose_contacts
from masonry_cd.mechanics.model.joint_laws import held
from masonry_cd.mechanics.solvers.options import cores

if TYPE_CHECKING:
    from masonry_cd.analysis.code_check.steps import CodeCheck
    from masonry_cd.analysis.code_check.table import CheckTable
    from masonry_cd.analysis.limit.analysis import Analysis
    from masonry_cd.app.static_loads import StaticLoads

LEVEL = 1e-9
TIES_ASK = (
    "ties make a mechanism start later and stiffer: by displacements, and under the spectrum of a floor, its shorter period may be asked "
    "for more than without them"
)
GAP = 1e-8  # share of the width of a structure from which on gaps of its joints are reported


@dataclass(frozen=True)
class WantedMechanisms:
    """Mechanisms and parts to look at in addition to those that the scene asks for.

    Attributes:
        parts: the macro-elements of the structure's kind, in addition to those of ``[[limit.mechanism]]``.
        curve: the mechanism of the whole, followed also where the scene has no table ``[limit.curve]``.
        whole: look at the whole as well where the scene multiplies a load.
        jobs: processes for the parts; as many as there are cores by default.
        quiet: do not say how long it still takes.
    """

    parts: bool = False
    curve: bool = False
    whole: bool = True
    jobs: int | None = None
    quiet: bool = True


@dataclass(frozen=True, eq=False)
class LimitCase:
    """A scene and its limit analysis."""

    structure: LimitStructure  # with the scene
    wanted: WantedMechanisms
    ground: Ground | None  # whose motion a check asks for; None without one
    whole: WholeAnalysis | None  # None where the scene multiplies nothing and parts alone are looked at
    crossing: Crossing | None  # of a vehicle whose worst place was looked for
    parts: tuple[ElementAnalysis, ...]  # macro-elements, one for each and each push
    mechanisms: tuple[Checked, ...]  # of the whole and of all parts, the governing one first
    decides: Checked | None  # the mechanism with the verdict; None without a check
    notes: tuple[str, ...]  # what must not be overlooked
    modelled: tuple[str, ...]  # a line on masses, and on ties, floors and fill
    seconds: float

    @property
    def scene(self) -> Scene:
        """The scene that is analysed."""
        return self.structure.scene

    @cached_property
    def assumed(self) -> Assumed:
        """The load factor of the whole with each thing that is assumed of it assumed otherwise."""
        return Assumed() if self.whole is None else assumed(self.structure, self.whole, self.crossing)

    @cached_property
    def rating(self) -> Rating | None:
        """What each vehicle may weigh; None where the scene does not ask for it, or the bridge does not stand."""
        if self.structure.asked.rating is None or self.whole is None or not self.whole.analysis.stands:
            return None
        return rating(self.structure, self.wanted.jobs or cores(), self.wanted.quiet)

    @cached_property
    def service(self) -> Service | None:
        """The checks in service; None where the scene does not ask for them, or the bridge does not stand."""
        if self.structure.asked.service is None or self.whole is None or not self.whole.analysis.stands:
            return None
        return service(self.structure, self.wanted.quiet)

    @cached_property
    def verdict(self) -> CheckVerdict | None:
        """The verdict that all outputs show; None without a check."""
        return None if self.structure.asked.check is None else _verdict(self)

    @cached_property
    def check(self) -> CodeCheck | None:
        """The check of the mechanism that decides, value by value, with the least acceleration that a mechanism just bears."""
        decides, weakest = self.decides, weakest_of(self.mechanisms)
        if decides is None or decides.check is None or weakest is None:
            return None
        made, tied = decides.check, self.whole is not None and len(self.whole.loads.bars.strength) > 0
        if tied and decides.level is not None and (len(made.verdicts) > 1 or decides.level.counted):
            made = replace(made, notes=(*made.notes, TIES_ASK))
        if weakest is decides:
            return self._with_borne(decides, made)
        assert weakest.check is not None
        note = f"what is just borne is that of {weakest.label}, which meets the least share of its demand"
        return borne_by_another(made, self._with_borne(weakest, weakest.check), note)

    def _with_borne(self, each: Checked, made: CodeCheck) -> CodeCheck:
        """The check of a mechanism with the acceleration of the ground that it just bears."""
        asked = self.structure.asked.check
        assert asked is not None and each.level is not None and self.ground is not None
        return with_borne(made, asked, each.level, each.one.oscillator, self.ground)


def limit_case(
    source: Scene | Path | str,
    changes: Sequence[str] = (),
    wanted: WantedMechanisms | None = None,
    keep: Callable[[LimitStructure], KeptParts] | None = None,
) -> LimitCase:
    """Analyse a scene.

    Args:
        source: a scene, or its file.
        changes: of its keys, ``key=value``, where it is a file.
        wanted: what is looked at in addition to what it asks for.
        keep: opens what keeps the parts that are done with; they are not kept by default.

    Raises:
        InputError: anything wrong with the scene, or a limit analysis without an answer.
    """
    begin, wanted = time.perf_counter(), wanted or WantedMechanisms()
    scene = source if isinstance(source, Scene) else read_scene(source, changes)
    with_parts = wanted.parts or bool(scene.limit.get("mechanism"))
    structure, crossing = limit_structure(scene), None
    refuse_rating(structure)
    refuse_service(structure)
    if whole_too := wanted.whole and (not with_parts or has_pattern(scene)):
        structure, crossing = at_worst(structure, wanted.quiet)
    with scene.locating():
        asked, ground = structure.asked.check, None
        if asked is not None:  # refused before anything is computed
            foundation_of(asked, structure.assembly)
            ground = ground_of(asked, scene.folder, known_at(scene.site, asked))
        parts, rows, notes = _parts(structure, ground, wanted, keep) if with_parts else ([], [], [])
        whole, of_whole, on_parts = _whole(structure, parts, wanted) if whole_too else (None, [], [])
        assembly = structure.assembly if whole is None else whole.assembly
        rows = in_order([*checked(of_whole, asked, ground, assembly), *rows])
        decides = gravest(rows)
        loads = structure.loads_of_parts() if whole is None else whole.loads
    on_whole = [] if whole is None else _notes_on(whole, asked)
    notes = [*on_whole, *on_parts, *notes, *_notes_on_structure(structure), *loads.notes]
    modelled, seconds = (masses(assembly), *structure.made.notes), time.perf_counter() - begin
    return LimitCase(structure, wanted, ground, whole, crossing, tuple(parts), tuple(rows), decides, tuple(notes), modelled, seconds)


def _parts(
    structure: LimitStructure, ground: Ground | None, wanted: WantedMechanisms, keep: Callable[[LimitStructure], KeptParts] | None
) -> tuple[list[ElementAnalysis], list[Checked], list[str]]:
    """The macro-elements that a scene asks for, each under its pushes, their mechanisms with checks on a ground, and notes on them.

    Raises:
        InputError: what a check of parts does not know, or a table that names no part.
    """
    asked, scene = structure.asked, structure.scene
    check_gravity_along_z("limit: what looks at macro-elements", scene.run.gravity)
    if asked.begin is not None:
        raise InputError("limit.from", "macro-elements are those of the structure as built")
    if asked.check is not None and asked.check.limit_state == "SLC":
        raise InputError(
            "limit.check.limit_state", "SLC is checked by displacements only, and of macro-elements the least mechanism alone is followed"
        )
    pushes, effort = asked_for(structure, wanted.parts), effort_of(asked, scene.run.seed)
    whole = whole_of(structure, structure.loads_of_parts())
    kept = None if keep is None else keep(structure)
    found, rows = list[ElementAnalysis](), list[Checked]()
    for one in analysed(whole, pushes, effort, (wanted.jobs or cores(), wanted.quiet), kept):
        found.append(replace(one, doubt=doubt_of(one, effort)))
        rows += checked(found[-1:], asked.check, ground, structure.assembly)
        if kept is not None:
            kept.add(one, in_order(rows))
    notes = in_pieces(list(dict.fromkeys(element for element, _ in pushes)), structure.joints)
    if kept is not None and kept.others:
        notes.append(f"{kept.others} kept parts are of another scene, other blocks or another version: they were analysed again")
    return found, rows, [*notes, *_remarks(found)]


def _remarks(parts: Sequence[ElementAnalysis]) -> list[str]:
    """A line for each mechanism of a part and push that the solver has no answer for."""
    return [f"{one.element.name}, push {way_words(one.direction)}: {remark}" for one in parts for remark in one.remarks]


def _whole(
    structure: LimitStructure, parts: Sequence[ElementAnalysis], wanted: WantedMechanisms
) -> tuple[WholeAnalysis, list[ElementAnalysis], list[str]]:
    """The whole under the load of its scene, what is known of its mechanisms: its own, and without ``parts`` those of rigid bodies of its
    parts that may go along the push; and notes on these parts.

    Raises:
        InputError: loads that do not suit what is required, or no answer.
    """
    loads, asked = structure.loads(), structure.asked
    how = ways(structure, loads)
    if asked.check is not None:
        _refuse_check(loads, structure.scene.run.gravity)
    overturns = structure.is_upright and loads.direction is not None and loads.direction[2] == 0.0
    along_push: list[ElementAnalysis] = []
    if overturns and not parts and asked.begin is None and (asked.check is not None or (loads.kind == "push" and how.begins_at_parts)):
        effort = replace(effort_of(asked, structure.scene.run.seed), starts=0, most_points=0)
        pushes = along(structure, loads.direction or ())
        along_push = list(analysed(whole_of(structure, loads), pushes, effort, (wanted.jobs or cores(), wanted.quiet)))
    begun_at = parts or (along_push if how.begins_at_parts else [])
    with Progress(0, wanted.quiet, what="descent to the least factor") as progress, watched(progress.more):
        whole = analyse_whole(structure, loads, how, begun_at, wanted.curve)
    if not overturns or not whole.has_factor or whole.analysis.bears_nothing:
        return whole, [], _remarks(along_push)
    own = as_part(whole)
    return whole, [own, *(_next_to(own, one) for one in along_push if asked.check)], _remarks(along_push)


def _next_to(own: ElementAnalysis, part: ElementAnalysis) -> ElementAnalysis:
    """A part next to the whole, whose search counts for it: of one that holds all blocks only what the whole's own numbers do not say."""
    found = part.mechanisms
    if len(part.element.blocks) == len(own.element.blocks):
        found = tuple(one for one in found if not any(says_the_same(other, one) for other in own.mechanisms))
    return replace(part, mechanisms=found, doubt=own.doubt, numbers=own.numbers, search=own.search)


def has_pattern(scene: Scene) -> bool:
    """True of a scene that names what a limit analysis of the whole multiplies."""
    if any(scene.limit.get(name) for name in PATTERNS):
        return True
    from loads.static import patterns

    with scene.locating():
        return any(patterns(scene.loads, scene.folder))


def check_gravity_along_z(where: str, gravity: Sequence[float]) -> None:
    """Refuse gravity along which heights do not count.

    Raises:
        InputError: names the key.
    """
    if not any(gravity):
        raise InputError(where, "needs gravity, but run.gravity is zero")
    if gravity[2] > 0.0 or math.hypot(*gravity[:2]) > LEVEL * math.hypot(*gravity):
        raise InputError(where, "needs run.gravity along -z, along which heights count")


def _refuse_check(loads: StaticLoads, gravity: Sequence[float]) -> None:
    """Refuse a check of loads whose factor is not that of a horizontal push.

    Raises:
        InputError: names the key.
    """
    if loads.kind not in ("push", "tilt"):
        raise InputError("limit.check", f"needs a push or a tilt, not {loads.words}")
    if loads.kind == "tilt" and not loads.has_only_gravity:
        raise InputError("limit.check", "needs a push where point loads or ties act: they do not turn with a tilt")
    across = abs(float(np.sum(np.asarray(loads.direction) * np.asarray(gravity))))
    if across > LEVEL * math.hypot(*gravity):
        raise InputError("limit.check", "the push must be level, at right angles to gravity")
    check_gravity_along_z("limit.check", gravity)


def _verdict(case: LimitCase) -> CheckVerdict:
    """The verdict of the governing mechanism, on those that no check could be made of, on parts that the solver has no answer for, and on a
    whole that has no load factor at which a mechanism would start.

    It names the load factors of the whole with what is assumed of it assumed otherwise.
    """
    found = [] if case.decides is None else [case.decides.verdict()]
    found = [replace(one, reason="; ".join([one.reason, *case.assumed.brief])) for one in found]
    row, own = case.assumed.decides, 0.0 if case.whole is None else case.whole.analysis.governing.factor
    if row is not None and found and found[0].ratio is not None and found[0].ratio * (row.factor or 0.0) < own:
        found.append(undecided(f"{row.line}; the scene does not state it, and with so little the demand is not met", found[0].search))
    for each in case.mechanisms:
        if each.check is not None and each.decides is None and each.one.mechanism is not None:  # among the gravest of its part
            found.append(undecided(f"{each.words}: no check, {each.no_displacement}", each.part.numbers))
    found += [undecided(remark) for remark in _remarks([part for part in case.parts if not part.mechanisms])]
    whole = case.whole
    if whole is not None and not (whole.has_factor and not whole.analysis.bears_nothing):
        found.append(_unchecked(whole.analysis))
    return worst(found) or undecided("no part has a mechanism below the largest factor that is looked for")


def _unchecked(analysis: Analysis) -> CheckVerdict:
    """The verdict on a structure that has no load factor at which a mechanism would start."""
    if not analysis.stands:
        return refused(f"the structure does not stand under its dead loads, it bears {100.0 * max(analysis.standing, 0.0):.3g} % of them")
    if analysis.is_endless:
        return undecided(f"no finite load factor was found; {NO_SEARCH}", search_numbers(analysis))
    return refused("the structure has no resistance to this load, and any amount of it starts the motion", search_numbers(analysis))


def _notes_on(whole: WholeAnalysis, asked: CheckTable | None) -> list[str]:
    """Notes on the analysis of the whole."""
    notes = [whole.left] if whole.left else []
    if asked is not None and (not whole.has_factor or whole.analysis.bears_nothing):
        notes.append("limit.check: no check: there is no load factor at which a mechanism would start")
    return [*notes, *whole.analysis.remarks]


def _notes_on_structure(structure: LimitStructure) -> list[str]:
    """Values that are likely in another unit, contacts and gaps that count as none, laws that limit analysis does not know."""
    assembly, scene, check = structure.assembly, structure.scene, structure.asked.check
    notes = doubts(scene, assembly, structure.joints)
    if scene.ground:
        notes.append("[[ground]]: limit analysis treats these supports as rigid")
    if check is not None and check.record is not None:
        notes += check_doubts(scene, check.record)
    if loose := loose_contacts(assembly):
        notes.append(f"{loose} pairs of blocks touch along a line or in a point only: limit analysis ignores these contacts")
    gap = built_gap(assembly)
    if gap > GAP * assembly.width:
        notes.append(f"joints as built have gaps or overlaps of up to {gap:.2g} m, which are ignored")
    return notes + [law.in_limit for law in held(assembly.laws) if law.in_limit]
