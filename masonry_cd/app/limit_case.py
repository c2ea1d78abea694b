# SPDX-License-Identifier: GPL-3.0-or-later
"""The limit analysis of a scene: what the command ``masonry-cd limit`` does."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.analysis.code_check.verdicts import NO_SEARCH, Basis, Judgement, judgement, refused
from masonry_cd.analysis.limit.analysis import Analysis, Collapse, Options, analyse, with_more_starts
from masonry_cd.analysis.limit.candidates import UNTIED, with_untied
from masonry_cd.analysis.limit.capacity import CapacityCurve
from masonry_cd.analysis.limit.crushed import CrushedJoint, LittleLeft, crushed_joints, crushed_lines, little_left
from masonry_cd.analysis.limit.mechanism import STATES
from masonry_cd.analysis.limit.outcome import mechanism_facts, on_the_whole
from masonry_cd.analysis.outputs.folders import files_of
from masonry_cd.app.doubts import check_doubts, doubts
from masonry_cd.app.limit_check import check_mechanism, suits
from masonry_cd.app.limit_curve import curve_lines, follow
from masonry_cd.app.limit_finite import unlimited_lines
from masonry_cd.app.limit_from import NO_CURVE, against_undamaged, left_state
from masonry_cd.app.limit_parts import begun_at_parts
from masonry_cd.app.limit_search import Ways, certificate_lines, search_numbers, search_words, ways
from masonry_cd.app.limit_structure import limit_structure
from masonry_cd.app.limit_vehicle import Crossing, at_worst
from masonry_cd.app.modelled import masses
from masonry_cd.app.scene import Scene, read_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import counted, force
from masonry_cd.mechanics.contact.find_joints import built_gap, loose_contacts
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joint_laws import held
from masonry_cd.mechanics.model.joints import Joints

if TYPE_CHECKING:
    from masonry_cd.analysis.code_check.steps import CodeCheck
    from masonry_cd.analysis.limit.macro import PartMechanism
    from masonry_cd.analysis.limit.ties import LimitTie
    from masonry_cd.app.static_loads import StaticLoads

EVERY = files_of("limit")  # that a folder of an analysis may hold
TURNS = 30  # most rounds in which the angle of a tilt is found
SAME_TILT = 1e-9  # change of lambda at which it is
SAME = 1e-4  # share of the factor by which the least and the associated one may differ and agree
NAMED = 6  # blocks that a line names


@dataclass(frozen=True, eq=False)
class LimitCase:
    """A scene and its limit analysis."""

    scene: Scene
    assembly: Assembly
    joints: Joints
    loads: StaticLoads
    analysis: Analysis
    check: CodeCheck | None
    notes: tuple[str, ...]
    seconds: float
    curve: CapacityCurve | None = None
    verdict: Judgement | None = None  # the one that all outputs show; None where no check is asked for
    crossing: Crossing | None = None  # of a vehicle whose worst place was looked for
    modelled: tuple[str, ...] = ()  # masses, ties, floors and fill, in words
    left: LittleLeft | None = None  # of the strength under the dead loads

    @cached_property
    def crushed(self) -> tuple[CrushedJoint, ...]:
        """The joints that are at their compressive strength at the factor."""
        if not self.analysis.stands or self.analysis.endless:
            return ()
        return crushed_joints(self.analysis.problem, self.collapse, self.assembly, self.joints)

    @cached_property
    def collapse(self) -> Collapse:
        """What moves, and the forces then."""
        return self.analysis.collapse(self.joints.count)

    @cached_property
    def ties(self) -> list[LimitTie]:
        """The ties and what they pull then; none of a structure that does not stand."""
        from masonry_cd.analysis.limit.ties import limit_ties

        if not self.analysis.stands:
            return []
        bars, weight = self.loads.bars, self.analysis.problem.weight
        return limit_ties(self.loads.tie_names, bars, self.collapse.bars, self.assembly.names, weight)


def limit_case(path: Path | str, changes: Sequence[str] = (), curve: bool = False) -> LimitCase:
    """Analyse a scene file, changed by some ``key=value``; ``curve`` as of :func:`case_of`.

    Raises:
        InputError: see :func:`case_of`.
    """
    return case_of(read_scene(path, changes), curve)


def case_of(scene: Scene, curve: bool = False, parts: Sequence[PartMechanism] = (), quiet: bool = True) -> LimitCase:
    """Analyse a scene.

    Args:
        scene: what is analysed.
        curve: follow the mechanism, also where the scene has no table ``[limit.curve]``.
        parts: mechanisms of macro-elements, at which a search for the least factor begins as well where they go with the push.
        quiet: do not say how long the places of a vehicle still take.

    Raises:
        InputError: anything wrong with the scene, or a limit analysis without an answer.
    """
    from masonry_cd.app.limit_table import CurveTable

    begin = time.perf_counter()
    scene, crossing = at_worst(scene, quiet)
    structure = limit_structure(scene)
    asked, assembly, joints, notes = structure.asked, structure.assembly, structure.joints, list(structure.made.notes)
    with scene.locating():
        loads = structure.loads()
        if asked.check is not None:
            suits(loads, scene.run.gravity)
        left = None if asked.begin is None else left_state(asked, scene.folder, assembly, joints, loads)
        how = ways(assembly, joints, loads, asked, scene.run.seed)
        analysis, built = _analyse(assembly, joints, loads, how.analysis), (assembly, joints)
        if loads.kind == "push" and analysis.starts > 1 and (parts or analysis.problem.axis is None):
            analysis = begun_at_parts(analysis, structure, loads, parts)
        analysis = _searched_on(analysis, assembly, joints, how)
        if left is not None:
            assembly, joints, loads, whole = left.assembly, left.joints, left.loads, analysis
            analysis = _searched_on(_analyse(assembly, joints, loads, how.analysis), assembly, joints, how)
            notes.append(f"{left.words}; {against_undamaged(analysis, whole)}")
        table = asked.curve or (CurveTable() if curve else None)
        if table is not None and asked.begin is not None:
            raise InputError("limit.curve", NO_CURVE)
        if analysis.endless:
            table = None
        followed = None if table is None else follow(table, assembly, joints, loads, how.curve)
        check = None
        if asked.check is not None and analysis.stands and not (analysis.bears_nothing or analysis.endless):
            analysis, untied = with_untied(analysis, assembly, joints, how.analysis)
            check = check_mechanism(
                asked.check, analysis, untied, (assembly, joints), loads, scene.run.gravity, scene.folder, how, followed
            )
        elif asked.check is not None:
            notes.append("limit.check: no check: there is no load factor at which a mechanism would start")
        verdict = None if asked.check is None else check.judgement if check is not None else _unchecked(analysis)
        notes += analysis.remarks
        spare = little_left(analysis.problem, assembly, joints) if analysis.stands else None
    notes += doubts(scene, *built)
    if asked.check is not None and asked.check.record is not None:
        notes += check_doubts(scene, asked.check.record)
    loose = loose_contacts(built[0])
    if loose:
        notes.append(f"{loose} pairs of blocks touch along a line or in a point only: these contacts bear nothing here")
    gap = built_gap(built[0])
    if gap > 1e-8 * assembly.width:
        notes.append(f"joints as built have gaps or overlaps of up to {gap:.2g} m, which count as none")
    notes += [law.in_limit for law in held(assembly.laws) if law.in_limit]
    seconds = time.perf_counter() - begin
    modelled, notes = (masses(assembly), *structure.made.notes), [*notes, *loads.notes]
    return LimitCase(scene, assembly, joints, loads, analysis, check, tuple(notes), seconds, followed, verdict, crossing, modelled, spare)


def _unchecked(analysis: Analysis) -> Judgement:
    """The verdict on a structure that has no load factor at which a mechanism would start."""
    if not analysis.stands:
        return refused(f"the structure does not stand under its dead loads, it bears {100.0 * max(analysis.standing, 0.0):.3g} % of them")
    if analysis.endless:
        return judgement((), Basis(numbers=search_numbers(analysis)), ("no finite load factor was found", NO_SEARCH))
    return refused("the structure bears no such load, the least of it sets it in motion", search_numbers(analysis))


def _analyse(assembly: Assembly, joints: Joints, loads: StaticLoads, options: Options) -> Analysis:
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


def _searched_on(analysis: Analysis, assembly: Assembly, joints: Joints, how: Ways) -> Analysis:
    """An analysis whose search goes on until starts agree, where one was made."""
    if not analysis.starts:
        return analysis
    return with_more_starts(analysis, assembly, joints, how.analysis.starts, how.most, how.analysis.seed)


def summary(case: LimitCase) -> dict[str, Any]:
    """What limit.json holds, the verdict on the whole first."""
    facts = _numbers(case)
    return {"title": facts["title"], "on_the_whole": on_the_whole(facts).as_dict()} | facts


def _numbers(case: LimitCase) -> dict[str, Any]:
    """What was found."""
    from masonry_cd import __version__

    analysis, answer, least = case.analysis, case.analysis.associated, case.analysis.least
    out: dict[str, Any] = {
        "title": case.scene.title,
        "version": __version__,
        "blocks": case.assembly.count,
        "joints": case.joints.count,
        "points": analysis.problem.points.count,
        "planar": analysis.problem.axis is not None,
        "pattern": {"kind": case.loads.kind, "words": case.loads.words, "direction": case.loads.direction},
        "stands": analysis.stands,
        "dead_load_borne": analysis.standing,
        "bears_nothing": analysis.stands and analysis.bears_nothing,
        "no_finite_factor": analysis.unlimited,
        "associated": None,
        "least": None,
        "starts": analysis.starts,
        "mechanism": mechanism_facts(case.collapse.mechanism, case.assembly.names, "least" if least else "associated"),
        "crushed": [asdict(one) for one in case.crushed],
        "little_left": None if case.left is None else asdict(case.left),
        "ties": [tie.row() for tie in case.ties],
        "check": None if case.check is None else case.check.numbers(),
        "verdict": None if case.verdict is None else case.verdict.numbers(),
        "certificate": asdict(answer.certificate) if analysis.stands and not analysis.unlimited else None,
        "solver": {"method": answer.optimum.method, "iterations": answer.optimum.iterations, "seconds": answer.seconds},
        "seconds": case.seconds,
        "modelled": list(case.modelled),
        "notes": list(case.notes),
    }
    if case.crossing is not None:
        out["crossing"] = case.crossing.numbers()
    if not analysis.stands or analysis.endless:
        return out
    if analysis.problem.moves_support:
        out["support_force"] = -answer.factor * analysis.problem.weight
        return out
    out["associated"] = None if analysis.unlimited else answer.factor
    if case.loads.kind == "tilt" and not analysis.unlimited:
        out["angle_degrees"] = math.degrees(math.atan(answer.factor))
    if least is not None:
        out["least"] = {
            "factor": least.optimum.factor, "gap": least.gap, "starts": least.starts, "agreeing": least.agreeing,
            "spread": least.spread, "found": list(least.found),
        }  # fmt: skip
    return out


def lines(case: LimitCase) -> list[str]:
    """The analysis in words: what was found, the check by a code, and what to know of both."""
    how = _how_lines(case) if case.analysis.stands and not case.analysis.endless else ()
    checked = case.check.lines() if case.check else [case.verdict.words] if case.verdict else []
    return [*found_lines(case), *how, *checked, *case.notes]


def found_lines(case: LimitCase) -> list[str]:
    """What was found, in words, and the joints at their compressive strength."""
    return [*_factor_lines(case), *crushed_lines(case.crushed, case.left)]


def _factor_lines(case: LimitCase) -> list[str]:
    """What was found; the first line says of what."""
    analysis, answer, least = case.analysis, case.analysis.associated, case.analysis.least
    space = "in a plane" if analysis.problem.axis is not None else "in space"
    counts = counted(case.assembly.count, "block"), counted(case.joints.count, "joint")
    out = [f"{', '.join(counts)}, {counted(analysis.problem.points.count, 'contact point')}, {space}"]
    if not analysis.stands:
        borne = f", it bears {100.0 * analysis.standing:.3g} % of them" if analysis.standing > 1e-6 else ""
        out.append(f"does not stand under its dead loads{borne}: {_who(case)} give way")
        return out
    out.append("stands under its dead loads")
    if case.crossing is not None:
        out.append(case.crossing.line())
    if analysis.unlimited:
        return [*out, *unlimited_lines(case.loads, case.assembly, analysis), *_started_before(case)]
    if analysis.problem.moves_support:
        out.append(f"{case.loads.words}: the supports that move still bear {force(-answer.factor * analysis.problem.weight)} against it")
    elif analysis.bears_nothing:
        return [*out, f"{case.loads.words}: no load factor: the structure bears no such load, the least of it sets it in motion"]
    else:
        angle = f", an angle of {math.degrees(math.atan(answer.factor)):.4g} degrees" if case.loads.kind == "tilt" else ""
        out.append(f"{case.loads.words}: load factor {answer.factor:.5g}{angle} (associated: sliding opens joints; an upper value)")
    if least is not None:
        out += [search_words(analysis), *_started_before(case)]
        apart = answer.factor - least.optimum.factor > SAME * abs(answer.factor)
        between = f"Coulomb's law allows {least.optimum.factor:.5g} to {answer.factor:.5g} at least; a run finds one of its values"
        out.append(between if apart else "both agree: how joints slide makes no difference here")
    elif not analysis.problem.moves_support:
        out.append(search_words(analysis))
    return out


def _started_before(case: LimitCase) -> list[str]:
    """A line where a mechanism found without the ties starts, with them, below the least factor of the search."""
    least, looked = case.analysis.least, () if case.check is None else case.check.basis.looked
    factors = [one.alpha0 for one in looked if UNTIED in one.found]
    if least is None or not factors or min(factors) >= (1.0 - SAME) * least.optimum.factor:
        return []
    return [
        f"a mechanism found without the ties starts, with the work of the ties added, at {min(factors):.5g}: less than the search found"
    ]


def _how_lines(case: LimitCase) -> list[str]:
    """The mechanism and the certificate, a line each."""
    moves = case.collapse.mechanism
    from masonry_cd.analysis.limit.ties import tie_lines

    return [
        f"mechanism: {_who(case)} move; joints: " + ", ".join(f"{moves.count(state)} {state}" for state in STATES[1:]) + _crushed(case),
        *tie_lines(case.ties, NAMED),
        *certificate_lines(case.analysis),
        *([] if case.curve is None else curve_lines(case.curve, case.assembly.names)),
    ]


def _crushed(case: LimitCase) -> str:
    """How many joints crush; nothing where none can."""
    crushing = int(case.collapse.mechanism.crushing.sum())
    return f"; {crushing} of them crush" if case.analysis.problem.sections is not None else ""


def _who(case: LimitCase) -> str:
    """The blocks that move, some by name."""
    moving = np.flatnonzero(case.collapse.mechanism.moving)
    some = ", ".join(f'"{case.assembly.names[b]}"' for b in moving[:NAMED])
    free = int((~case.assembly.fixed).sum())
    return f"{len(moving)} of {free} blocks ({some}{' ...' if len(moving) > NAMED else ''})"
