# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole of a structure under the load that its scene multiplies: factor, mechanism, forces, capacity curve."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.analysis.limit.analysis import Analysis, Collapse, LimitOptions, analyse, with_more_starts
from masonry_cd.analysis.limit.candidates import Source, candidates, with_mechanisms, with_overturning, with_untied
from masonry_cd.analysis.limit.capacity import CapacityCurve, CurveOptions, capacity_curve
from masonry_cd.analysis.limit.crushed import CrushedJoint, LittleLeft, crushed_joints, little_left
from masonry_cd.analysis.limit.found import FoundMechanism, gravest_followed
from masonry_cd.analysis.limit.linkage import with_displacements
from masonry_cd.analysis.limit.macro import ElementAnalysis
from masonry_cd.analysis.limit.oscillator import BY_CURVE, Oscillator, oscillator
from masonry_cd.analysis.limit.part import FreedPart, part_of
from masonry_cd.analysis.limit.problem import Bars
from masonry_cd.analysis.limit.ties import LimitTie, limit_ties
from masonry_cd.app.limit_table import CurveTable
from masonry_cd.foundation.errors import InputError
from masonry_cd.limit.curve import follow
from masonry_cd.limit.left_state import NO_CURVE, against_undamaged, left_state
from masonry_cd.limit.parts import whole_of
from masonry_cd.limit.search import SearchSettings, doubt, search_numbers, search_words
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joint_laws import at_start_only
from masonry_cd.mechanics.model.joints import Joints
from structures.macro_elements import MacroElement

if TYPE_CHECKING:
    from masonry_cd.app.limit_structure import LimitStructure
    from masonry_cd.app.static_loads import StaticLoads

THE_WHOLE = "the whole"
TURNS = 30  # most rounds in which the angle of a tilt is found
SAME_TILT = 1e-9  # change of lambda at which it is
SAME_SHAKEN = 1e-4  # share of a factor by which the one that shakes the fill may differ from it
ALONG = 0.999  # cosine of the angle between two pushes up to which they are one
BEGUN = 6  # mechanisms of parts at which the search begins, three or four cone programmes each


@dataclass(frozen=True, eq=False)
class WholeAnalysis:
    """A structure and its limit analysis."""

    structure: LimitStructure  # as analysed: where a run left it, if the scene says so
    loads: StaticLoads
    analysis: Analysis
    how: SearchSettings
    untied: Sequence[Source]  # mechanisms found without the ties
    no_untied: str  # the reason why there are none of these; empty where there are, and without ties
    curve: CapacityCurve | None = None
    left: str = ""  # by a run: from where it is, and what that does to the factor
    spare: LittleLeft | None = None  # of the strength under the dead loads

    @property
    def assembly(self) -> Assembly:
        """Its blocks."""
        return self.structure.assembly

    @property
    def joints(self) -> Joints:
        """Their joints."""
        return self.structure.joints

    @cached_property
    def crushed(self) -> tuple[CrushedJoint, ...]:
        """The joints that are at their compressive strength at the factor."""
        if not self.has_factor:
            return ()
        return crushed_joints(self.analysis.problem, self.collapse, self.assembly, self.joints)

    @cached_property
    def collapse(self) -> Collapse:
        """The mechanism, and the forces that go with it."""
        return self.analysis.collapse(self.joints.count)

    @cached_property
    def ties(self) -> list[LimitTie]:
        """The ties with their tension at collapse; none of a structure that does not stand."""
        if not self.analysis.stands:
            return []
        return limit_ties(self.loads.tie_names, self.loads.bars, self.collapse.bars, self.assembly.names, self.analysis.problem.weight)

    @property
    def has_factor(self) -> bool:
        """True of a structure that stands, and of which some finite factor is known."""
        return self.analysis.stands and not self.analysis.is_endless


def analyse_whole(
    structure: LimitStructure, loads: StaticLoads, how: SearchSettings, parts: Sequence[ElementAnalysis], curve: bool = False
) -> WholeAnalysis:
    """Analyse a structure under the load that its scene multiplies.

    Args:
        structure: with its scene.
        loads: on it.
        how: how far its least factor is searched for.
        parts: macro-elements, at whose governing mechanisms the search begins as well where they go with the push.
        curve: follow the mechanism, also where the scene has no table ``[limit.curve]``.

    Raises:
        InputError: loads that do not fit, or a limit analysis without an answer.
    """
    asked, words = structure.asked, ""
    loads = _with_shaken_fill(structure, loads)
    left = None if asked.begin is None else left_state(structure, loads)
    analysis = _analysed(structure, loads, how.analysis)
    if loads.kind == "push" and analysis.starts > 1 and (parts or how.begins_at_parts):
        analysis = _begun_at_parts(analysis, structure, loads, parts)
    analysis = _searched_on(analysis, structure, how)
    if left is not None:
        (structure, loads, words), built = left, analysis
        analysis = _searched_on(_analysed(structure, loads, how.analysis), structure, how)
        words = f"{words}; {against_undamaged(analysis, built)}"
    assembly, joints = structure.assembly, structure.joints
    table = asked.curve or (CurveTable() if curve else None)
    if table is not None and asked.begin is not None:
        raise InputError("limit.curve", NO_CURVE)
    followed = None if table is None or analysis.is_endless else follow(table, assembly, joints, loads, how.curve)
    untied, without, spare = list[Source](), "", None
    if asked.check is not None and analysis.stands and not (analysis.bears_nothing or analysis.is_endless):
        analysis, untied, without = with_untied(analysis, assembly, joints, how.analysis)
    if analysis.stands:
        spare = little_left(analysis.problem, assembly, joints)
    return WholeAnalysis(structure, loads, analysis, how, untied, without, followed, words, spare)


def _with_shaken_fill(structure: LimitStructure, loads: StaticLoads) -> StaticLoads:
    """Loads whose fill, under a push, is shaken by the associated factor that they have then; that factor by secants.

    Pressures grow with the square of it or so: at less than this factor they are less than their secant, on the safe side.

    Raises:
        InputError: it is not found, or no answer.
    """
    if loads.kind != "push" or not structure.made.fills:
        return loads
    known = list[tuple[float, float]]()  # factors by which the fill is shaken, and by how much more is borne
    by, alone = 0.0, LimitOptions(starts=0)
    for _ in range(TURNS):
        analysis = _analysed(structure, loads, alone)
        if not analysis.stands or analysis.unlimited:
            return loads
        known.append((by, analysis.associated.factor - by))
        if abs(known[-1][1]) <= SAME_SHAKEN * analysis.associated.factor:
            return loads
        (a, more_a), (b, more_b) = known[0] if len(known) == 1 else known[-2], known[-1]
        by = b + more_b if more_a == more_b else max(a - more_a * (b - a) / (more_b - more_a), 0.0)
        loads = structure.loads(shaken_by=by)
    raise InputError("limit.push", f"the factor at which the fill is shaken by it is not found in {TURNS} rounds")


def _analysed(structure: LimitStructure, loads: StaticLoads, options: LimitOptions) -> Analysis:
    """The limit analysis; of a tilt with loads that do not turn with it, at the angle that belongs to its own factor."""
    assembly, joints = structure.assembly, structure.joints
    if loads.kind != "tilt" or (loads.has_only_gravity and not assembly.laws.apex.any()):
        return analyse(assembly, joints, loads.at(), options)
    factor, last = 0.0, math.inf
    for _ in range(TURNS):
        turned = loads.at(1.0 / math.sqrt(1.0 + factor**2))
        found = analyse(assembly, joints, turned, replace(options, starts=0))  # the search is for the last angle
        factor, last = found.associated.factor, factor
        if found.unlimited:
            return found
        if not found.stands or abs(factor - last) <= SAME_TILT * (1.0 + abs(factor)):
            return analyse(assembly, joints, turned, options) if found.stands and options.starts else found
    raise InputError("limit.tilt", f"the angle of collapse is not found in {TURNS} rounds; push gives the factor of a body force")


def _begun_at_parts(analysis: Analysis, structure: LimitStructure, loads: StaticLoads, parts: Sequence[ElementAnalysis]) -> Analysis:
    """An analysis under a push whose search has begun at the governing mechanisms of parts as well, and at what would overturn below the
    factor found then. As it was where gravity is not along -z or the push not level."""
    way = np.asarray(loads.direction)
    if not structure.is_upright or abs(way[2]) > 0.0:
        return analysis
    some = [part.mechanisms[0] for part in parts if part.mechanisms and float(part.direction @ way) > ALONG]
    first = sorted((one for one in some if one.mechanism), key=lambda one: one.oscillator.alpha)[:BEGUN]
    known = [one.mechanism for one in first if one.mechanism]
    return with_overturning(with_mechanisms(analysis, structure.assembly, structure.joints, known), whole_of(structure, loads), way)


def _searched_on(analysis: Analysis, structure: LimitStructure, how: SearchSettings) -> Analysis:
    """An analysis whose search goes on until starts agree, where one was made."""
    if not analysis.starts:
        return analysis
    made = how.analysis
    return with_more_starts(analysis, structure.assembly, structure.joints, made.starts, how.most, made.seed)


def as_part(whole: WholeAnalysis) -> ElementAnalysis:
    """The whole under its push as the part that holds everything, with the mechanisms that were found of it, the least a0* first."""
    assembly, loads, analysis, check = whole.assembly, whole.loads, whole.analysis, whole.structure.asked.check
    assert loads.direction is not None
    way, free = np.asarray(loads.direction), ~assembly.fixed
    element = MacroElement(THE_WHOLE, "whole", np.flatnonzero(free), (loads.direction,), ())
    around = whole_of(whole.structure, loads)
    part = FreedPart(around, assembly, free, analysis.problem, around.gravity * way, loads.at(), Bars.none())
    found = sorted(candidates(analysis, whole.untied, part), key=lambda one: one.oscillator.acceleration())
    if check is not None and check.checks_displacements:
        found = _followed(whole, part, found)
    words = "; ".join(filter(None, [search_words(analysis), whole.no_untied]))
    points, numbers = analysis.problem.points.count, search_numbers(analysis)
    return ElementAnalysis(element, way, tuple(found), points, 0.0, (), numbers, doubt(analysis), words)


def _followed(whole: WholeAnalysis, part: FreedPart, found: Sequence[FoundMechanism]) -> list[FoundMechanism]:
    """The mechanisms, the gravest with the displacement at which their factor vanishes: by the capacity curve where that is known or in a
    plane, where hinges may pass to other joints, else as linkages of bodies."""
    if reason := at_start_only(whole.assembly.laws):
        return [replace(one, oscillator=replace(one.oscillator, end=reason)) for one in found]
    linked = part_of(part.whole, part.free, np.asarray(whole.loads.direction))

    def follow(k: int, one: FoundMechanism) -> Oscillator:
        made = one.oscillator if one.oscillator.doubt else _by_the_curve(whole, part, one) if k == 0 else None
        if made is not None and (made.doubt or made.falls):
            return made
        return with_displacements(linked, one, whole.structure.scene.run.seed)

    return gravest_followed(found, follow)


def _by_the_curve(whole: WholeAnalysis, part: FreedPart, one: FoundMechanism) -> Oscillator | None:
    """The oscillator of a mechanism by the capacity curve of the structure; None where that is not known and expensive."""
    assert one.mechanism is not None
    curve, moves = whole.curve, one.mechanism
    if curve is None or not curve.falls or not moves.moving[curve.control.block]:
        if whole.analysis.problem.axis is None:
            return None
        control = int(np.argmax(moves.velocity[:, :3] @ part.push))
        curve = capacity_curve(whole.assembly, whole.joints, whole.loads.at(), CurveOptions(whole.how.curve, control=control))
    return replace(oscillator(part, moves, one.oscillator.alpha, one.dilation, curve), by=BY_CURVE)
