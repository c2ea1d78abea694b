# SPDX-License-Identifier: GPL-3.0-or-later
"""The lines of a limit analysis: the factor and its reliability, the mechanism, those of parts, the code check."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.analysis.code_check.verdicts import NON_LINEAR
from masonry_cd.analysis.limit.candidates import UNTIED
from masonry_cd.analysis.limit.crushed import crushed_lines
from masonry_cd.analysis.limit.macro import MOST
from masonry_cd.analysis.limit.mechanism import STATES
from masonry_cd.analysis.limit.outcome import on_the_whole
from masonry_cd.analysis.limit.ties import tie_lines
from masonry_cd.foundation.quantities import counted, force
from masonry_cd.limit.checked import least_of, looked_at, way_words
from masonry_cd.limit.curve import curve_lines
from masonry_cd.limit.facts import facts
from masonry_cd.limit.search import certificate_lines, search_words
from masonry_cd.limit.whole import THE_WHOLE, WholeAnalysis
from masonry_cd.mechanics.model.joint_laws import LAWS

if TYPE_CHECKING:
    from masonry_cd.limit.case import LimitCase

SAME = 1e-4  # share of the factor by which the least and the associated one may differ and agree
NAMED = 6  # blocks that a line names


def lines(case: LimitCase) -> list[str]:
    """All lines of the analysis: the verdict, what was found, the code check, and what is modelled."""
    verdict = on_the_whole(facts(case))
    how = _how_lines(case.whole) if case.whole is not None and case.whole.has_factor else []
    return [
        *([] if verdict is None else [verdict.line]),
        *found_lines(case),
        *([] if case.assumed.range is None else case.assumed.lines),
        *([] if case.rating is None else case.rating.lines),
        *([] if case.service is None else case.service.lines),
        *how,
        *_part_lines(case),
        *([] if case.check is None else case.check.lines(_checked_lines(case))),
        *case.modelled[1:],
    ]


def _checked_lines(case: LimitCase) -> list[str]:
    """The mechanism that is checked, and the height at which it is held."""
    each = case.decides
    assert each is not None and each.level is not None
    looked, made = looked_at(each, case.mechanisms), each.one.oscillator
    taken = f"; e* = 1 is used, on the safe side: {made.doubt}" if made.doubt else ""
    by = "ratio by accelerations" if any(one.height != each.height for one in looked) else "a0*"
    if each.decides is not None and each.decides.check == NON_LINEAR:
        by = "ratio, by displacements,"
    which = f"checked: the least {by} of {counted(len(looked), 'mechanism')} looked at, {each.one.source}"
    return [f"{which}, {counted(each.one.moving, 'moving block')}, alpha0 {made.alpha:.4g}{taken}", each.level.words]


def found_lines(case: LimitCase) -> list[str]:
    """The lines of the outcome, and of the joints at their compressive strength; the first line says of what."""
    if case.whole is None:
        return [_parts_in_words(case)]
    without = case.assumed.lines if case.assumed.range is None else []  # of a bridge they are a table
    return [*_factor_lines(case, case.whole), *without, *crushed_lines(case.whole.crushed, case.whole.spare)]


def _part_lines(case: LimitCase) -> list[str]:
    """The parts, the governing mechanism of each, and which are held; none where parts were not analysed by themselves."""
    some = [each.words for each in least_of(case.mechanisms) if each.part.element.name != THE_WHOLE]
    head = [_parts_in_words(case)] if case.whole is not None and case.parts else []
    held = [f"{one.element.name} {way_words(one.direction)}" for one in case.parts if one.held]
    return [*head, *some, *([f"held, no mechanism below a factor of {MOST:g}: {', '.join(held)}"] if held else [])]


def _parts_in_words(case: LimitCase) -> str:
    """The number of parts analysed."""
    elements = len({one.element.name for one in case.parts})
    pushes = len(case.parts)
    of = f"{counted(elements, 'macro-element')} under {pushes} push{'es' if pushes != 1 else ''}"
    return f"{of}, each with all other blocks held, {counted(case.structure.assembly.count, 'block')}"


def _factor_lines(case: LimitCase, whole: WholeAnalysis) -> list[str]:
    """The factor of the whole; the first line says of what."""
    analysis, answer, loads = whole.analysis, whole.analysis.associated, whole.loads
    space = "in a plane" if analysis.problem.axis is not None else "in space"
    counts = counted(whole.assembly.count, "block"), counted(whole.joints.count, "joint")
    out = [f"{', '.join(counts)}, {counted(analysis.problem.points.count, 'contact point')}, {space}"]
    if not analysis.stands:
        borne = f", it bears {100.0 * analysis.standing:.3g} % of them" if analysis.standing > 1e-6 else ""
        return [*out, f"does not stand under its dead loads{borne}: {_who(whole)} give way"]
    out.append("stands under its dead loads")
    if case.crossing is not None:
        out.append(case.crossing.line())
    if analysis.unlimited:
        return [*out, *_unlimited_lines(whole), *_started_before(case, whole)]
    if analysis.problem.moves_support:
        borne = force(-answer.factor * analysis.problem.weight)
        return [*out, f"{loads.words}: the supports that move still bear {borne} against it", *_least_lines(case, whole)]
    if analysis.bears_nothing:
        return [*out, f"{loads.words}: no load factor: the structure has no resistance to this load, any amount of it starts the motion"]
    angle = f", an angle of {math.degrees(math.atan(answer.factor)):.4g} degrees" if loads.kind == "tilt" else ""
    out.append(f"{loads.words}: load factor {answer.factor:.5g}{angle} (associated: sliding opens joints; an upper bound)")
    return [*out, *_least_lines(case, whole)]


def _least_lines(case: LimitCase, whole: WholeAnalysis) -> list[str]:
    """The least factor next to the associated one."""
    analysis, least, upper = whole.analysis, whole.analysis.least, whole.analysis.associated.factor
    if least is None:
        return [] if analysis.problem.moves_support else [search_words(analysis)]
    apart = upper - least.optimum.factor > SAME * abs(upper)
    between = f"Coulomb's law allows {least.optimum.factor:.5g} to {upper:.5g} at least; a run finds one of its values"
    agree = "both agree: dilation of sliding joints makes no difference here"
    return [search_words(analysis), *_started_before(case, whole), between if apart else agree]


def _started_before(case: LimitCase, whole: WholeAnalysis) -> list[str]:
    """A line where a mechanism found without the ties starts, with them, below the least factor of the search."""
    least = whole.analysis.least
    of_whole = [each.one for each in case.mechanisms if each.part.element.name == THE_WHOLE]
    factors = [one.oscillator.alpha for one in of_whole if UNTIED in one.source]
    if least is None or not factors or min(factors) >= (1.0 - SAME) * least.optimum.factor:
        return []
    return [
        f"a mechanism found without the ties starts, with the work of the ties added, at {min(factors):.5g}: less than the search found"
    ]


def _how_lines(whole: WholeAnalysis) -> list[str]:
    """The mechanism and the certificate, a line each."""
    moves = whole.collapse.mechanism
    crushing = f"; {int(moves.crushing.sum())} of them crush" if whole.analysis.problem.sections is not None else ""
    return [
        f"mechanism: {_who(whole)} move; joints: " + ", ".join(f"{moves.count(state)} {state}" for state in STATES[1:]) + crushing,
        *tie_lines(whole.ties, NAMED),
        *certificate_lines(whole.analysis),
        *([] if whole.curve is None else curve_lines(whole.curve, whole.assembly.names)),
    ]


def _who(whole: WholeAnalysis) -> str:
    """The blocks that move, some by name."""
    moving = np.flatnonzero(whole.collapse.mechanism.moving)
    some = ", ".join(f'"{whole.assembly.names[b]}"' for b in moving[:NAMED])
    free = int((~whole.assembly.fixed).sum())
    return f"{len(moving)} of {free} blocks ({some}{' ...' if len(moving) > NAMED else ''})"


def _unlimited_lines(whole: WholeAnalysis) -> list[str]:
    """Loads of which any multiple is borne as long as joints that slide open, and what would end that."""
    words, analysis = whole.loads.words, whole.analysis
    if analysis.least is not None:
        return [
            f"{words}: no finite associated load factor: where sliding opens joints the blocks are wedged, and bear any multiple",
            search_words(analysis),
            "what is wedged bears by forces that no load makes, as friction on faces that need not be pressed: count on the least factor",
        ]
    return [
        f"{words}: no finite load factor: the load does no work on any mechanism of these joints, so that any multiple is borne",
        f"it would be finite with {', or '.join(_missing(whole))}",
        f"{search_words(analysis)}: where joints let go of a thrust as they slide, less may be borne",
    ]


def _missing(whole: WholeAnalysis) -> list[str]:
    """Changes that would make the factor finite, with the keys."""
    loads, assembly = whole.loads, whole.assembly
    if not loads.live[~assembly.fixed].any() and loads.support_velocity is None:
        return ["a load on blocks that are free: it acts on supports alone"]
    out = [law.bounds for law in LAWS if law.bounds and not law.where(assembly.laws).all()]
    if np.isinf(loads.bars.strength).any():
        out.append("ties that yield (their yield_force)")
    if loads.support_velocity is None:
        out.append("supports that give way (blocks that hold them in place of fixed ones)")
    return out or ["blocks that are free where it acts"]
