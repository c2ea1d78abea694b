# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole of a structure under the load that its scene multiplies: factor, mechanism, forces, capacity curve."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.analysis.limit.analysis import Analysis, Collapse, Options, analyse, with_more_starts
from masonry_cd.analysis.limit.candidates import Untied, candidates, with_mechanisms, with_overturning, with_untied
from masonry_cd.analysis.limit.capacity import CapacityCurve, CurveOptions, capacity_curve
from masonry_cd.analysis.limit.crushed import CrushedJoint, LittleLeft, crushed_joints, little_left
from masonry_cd.analysis.limit.held import held_at
from masonry_cd.analysis.limit.linkage import with_displacements
from masonry_cd.analysis.limit.macro import ElementAnalysis, PartMechanism, grave, named
from masonry_cd.analysis.limit.oscillator import Oscillator, oscillator
from masonry_cd.analysis.limit.part import part_of
from masonry_cd.analysis.limit.ties import LimitTie, limit_ties
from masonry_cd.app.limit_table import CurveTable
from masonry_cd.foundation.errors import InputError
from masonry_cd.limit.checked import PartLooked
from masonry_cd.limit.curve import follow
from masonry_cd.limit.left_state import NO_CURVE, against_undamaged, left_state
from masonry_cd.limit.parts import whole_of
from masonry_cd.limit.search import Ways, doubt, search_numbers, search_words
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
ALONG = 0.999  # cosine of the angle between two pushes up to which they are one
BEGUN = 6  # mechanisms of parts at which the search begins, three or four cone programmes each


@dataclass(frozen=True, eq=False)
class WholeAnalysis:
    """A structure and its limit analysis."""

    assembly: Assembly  # as analysed: where a run left it, if the scene says so
    joints: Joints
    loads: StaticLoads
    analysis: Analysis
    how: Ways
    untied: Untied = field(default_factory=Untied)  # mechanisms found without the ties
    curve: CapacityCurve | None = None
    left: str = ""  # by a run: from where it is, and what that does to the factor
    spare: LittleLeft | None = None  # of the strength under the dead loads

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
        """The ties with what they pull then; none of a structure that does not stand."""
        if not self.analysis.stands:
            return []
        return limit_ties(self.loads.tie_names, self.loads.bars, self.collapse.bars, self.assembly.names, self.analysis.problem.weight)

    @property
    def has_factor(self) -> bool:
        """True of a structure that stands, and of which some finite factor is known."""
        return self.analysis.stands and not self.analysis.endless


def analyse_whole(
    structure: LimitStructure, loads: StaticLoads, how: Ways, parts: Sequence[PartMechanism], curve: bool = False
) -> WholeAnalysis:
    """Analyse a structure under the load that its scene multiplies.

    Args:
        structure: with its scene.
        loads: on it.
        how: far its least factor is searched for.
        parts: mechanisms of macro-elements, at which the search begins as well where they go with the push.
        curve: follow the mechanism, also where the scene has no table ``[limit.curve]``.

    Raises:
        InputError: loads that do not fit, or a limit analysis without an answer.
    """
    asked, assembly, joints, words = structure.asked, structure.assembly, structure.joints, ""
    left = None if asked.begin is None else left_state(asked, structure.scene.folder, assembly, joints, loads)
    analysis = _analysed(assembly, joints, loads, how.analysis)
    if loads.kind == "push" and analysis.starts > 1 and (parts or how.begins_at_parts):
        analysis = _begun_at_parts(analysis, structure, loads, parts)
    analysis = _searched_on(analysis, assembly, joints, how)
    if left is not None:
        assembly, joints, loads, built = left.assembly, left.joints, left.loads, analysis
        analysis = _searched_on(_analysed(assembly, joints, loads, how.analysis), assembly, joints, how)
        words = f"{left.words}; {against_undamaged(analysis, built)}"
    table = asked.curve or (CurveTable() if curve else None)
    if table is not None and asked.begin is not None:
        raise InputError("limit.curve", NO_CURVE)
    followed = None if table is None or analysis.endless else follow(table, assembly, joints, loads, how.curve)
    untied, spare = Untied(), None
    if asked.check is not None and analysis.stands and not (analysis.bears_nothing or analysis.endless):
        analysis, untied = with_untied(analysis, assembly, joints, how.analysis)
    if analysis.stands:
        spare = little_left(analysis.problem, assembly, joints)
    return WholeAnalysis(assembly, joints, loads, analysis, how, untied, followed, words, spare)


def _analysed(assembly: Assembly, joints: Joints, loads: StaticLoads, options: Options) -> Analysis:
    """The limit analysis; of a tilt beside loads that do not turn with it, at the angle that belongs to its own factor."""
    if loads.kind != "tilt" or (loads.only_gravity and not assembly.laws.apex.any()):
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


def _begun_at_parts(analysis: Analysis, structure: LimitStructure, loads: StaticLoads, parts: Sequence[PartMechanism]) -> Analysis:
    """An analysis under a push whose search has begun at mechanisms of parts as well, and at what would overturn below the factor found
    then. As it was where gravity is not along -z or the push not level."""
    way = np.asarray(loads.direction)
    if not structure.upright or abs(way[2]) > 0.0:
        return analysis
    some = sorted((one for one in parts if one.found and float(one.direction @ way) > ALONG), key=lambda one: one.oscillator.alpha)
    known = [one.found.mechanism for one in some[:BEGUN] if one.found]
    return with_overturning(with_mechanisms(analysis, structure.assembly, structure.joints, known), whole_of(structure, loads), way)


def _searched_on(analysis: Analysis, assembly: Assembly, joints: Joints, how: Ways) -> Analysis:
    """An analysis whose search goes on until starts agree, where one was made."""
    if not analysis.starts:
        return analysis
    return with_more_starts(analysis, assembly, joints, how.analysis.starts, how.most, how.analysis.seed)


def as_part(whole: WholeAnalysis, structure: LimitStructure) -> PartLooked:
    """The whole under its push as the part that holds everything, with the mechanisms that were found of it, the least a0* first."""
    assembly, joints, loads = whole.assembly, whole.joints, whole.loads
    assert loads.direction is not None
    way, free = np.asarray(loads.direction), np.flatnonzero(~assembly.fixed)
    element = MacroElement(THE_WHOLE, "whole", free, (loads.direction,), ())
    push, around = math.hypot(*structure.scene.run.gravity) * way, whole_of(structure, loads)
    found = []
    for one in candidates(whole.analysis, whole.untied, assembly, joints):
        moving = one.mechanism.moving & ~assembly.fixed
        made = oscillator(one, assembly, joints, push, None, loads.live)
        name, stones = named(one.mechanism, around, ~assembly.fixed)
        line = held_at(one.mechanism, assembly, joints)
        found.append(PartMechanism(element, way, name, one.source, made, int(moving.sum()), line, np.zeros(0), one, stones))
    found.sort(key=lambda one: one.oscillator.acceleration())
    if structure.asked.check is not None and structure.asked.check.by_displacements:
        found = _followed(whole, structure, found)
    words = "; ".join([search_words(whole.analysis), *([whole.untied.remark] if whole.untied.remark else [])])
    part = ElementAnalysis(element, way, tuple(found), whole.analysis.least, whole.analysis.problem.points.count, 0.0, ())
    return PartLooked(part, doubt(whole.analysis), search_numbers(whole.analysis), words)


def _followed(whole: WholeAnalysis, structure: LimitStructure, found: Sequence[PartMechanism]) -> list[PartMechanism]:
    """The mechanisms, the gravest with the displacement at which their factor vanishes: by the capacity curve where that is known or in a
    plane, where hinges may pass to other joints, else as linkages of bodies."""
    assembly, loads, out = whole.assembly, whole.loads, []
    if reason := at_start_only(assembly.laws):
        return [replace(one, oscillator=replace(one.oscillator, end=reason)) for one in found]
    part = part_of(whole_of(structure, loads), ~assembly.fixed, np.asarray(loads.direction))
    gravest = grave(found)
    for k, one in enumerate(found):
        assert one.found is not None
        if k not in gravest:
            out.append(replace(one, found=None))
            continue
        made = one.oscillator if one.oscillator.doubt else _by_the_curve(whole, one, part.push) if k == 0 else None
        if made is None or not (made.doubt or made.falls):
            made = with_displacements(part, one.found, one.oscillator, structure.scene.run.seed)
        out.append(replace(one, oscillator=made))
    return out


def _by_the_curve(whole: WholeAnalysis, one: PartMechanism, push: np.ndarray) -> Oscillator | None:
    """The oscillator of a mechanism by the capacity curve of the structure; None where that is not known and expensive."""
    assert one.found is not None
    curve, moves = whole.curve, one.found.mechanism
    if curve is None or not curve.falls or not moves.moving[curve.control.block]:
        if whole.analysis.problem.axis is None:
            return None
        control = int(np.argmax(moves.velocity[:, :3] @ push))
        curve = capacity_curve(whole.assembly, whole.joints, whole.loads.at(), CurveOptions(whole.how.curve, control=control))
    return oscillator(one.found, whole.assembly, whole.joints, push, curve, whole.loads.live)
