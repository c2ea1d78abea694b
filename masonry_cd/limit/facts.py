# SPDX-License-Identifier: GPL-3.0-or-later
"""limit.json: the whole with its factor, mechanism and certificate, every mechanism with its check, the parts, and the verdict first."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from masonry_cd.analysis.limit.outcome import mechanism_facts, on_the_whole
from masonry_cd.limit.checked import looked_at, way_words

if TYPE_CHECKING:
    from masonry_cd.analysis.limit.macro import ElementAnalysis
    from masonry_cd.limit.case import LimitCase
    from masonry_cd.limit.whole import WholeAnalysis


def facts(case: LimitCase) -> dict[str, Any]:
    """The contents of limit.json. What belongs to the whole is missing where parts alone were looked at."""
    from masonry_cd import __version__

    asked = case.structure.asked.check
    found = {
        "title": case.scene.title,
        "version": __version__,
        "blocks": case.structure.assembly.count,
        "joints": case.structure.joints.count,
        **({} if case.whole is None else of_the_whole(case.whole)),
        **({} if case.crossing is None else {"crossing": case.crossing.numbers()}),
        "mechanisms": [each.row for each in case.mechanisms],
        "parts": [_of_a_part(case, part) for part in case.parts],
        "assumed": case.assumed.numbers(),
        "service": None if case.service is None else case.service.numbers(),
        "rating": None if case.rating is None else case.rating.numbers(),
        "check": None if case.check is None else case.check.numbers() | {"basis": _basis(case)},
        "hazard": None if case.scene.site is None or not case.scene.site.known else case.scene.site.numbers(),
        "left_open": [] if asked is None else list(asked.by.left_open(asked.at(asked.building_height or 0.0) if asked.building else asked)),
        "verdict": None if case.verdict is None else case.verdict.numbers(),
        "modelled": list(case.modelled),
        "notes": list(case.notes),
        "seconds": case.seconds,
    }
    verdict = on_the_whole(found)
    return {"title": case.scene.title, "on_the_whole": None if verdict is None else verdict.as_dict()} | found


def of_the_whole(whole: WholeAnalysis) -> dict[str, Any]:
    """Factor, mechanism, forces and certificate of the whole."""
    analysis, answer, loads = whole.analysis, whole.analysis.associated, whole.loads
    finite = analysis.stands and not analysis.unlimited
    return {
        "joints": whole.joints.count,
        "points": analysis.problem.points.count,
        "planar": analysis.problem.axis is not None,
        "pattern": {"kind": loads.kind, "words": loads.words, "direction": loads.direction},
        "stands": analysis.stands,
        "dead_load_borne": analysis.standing,
        "bears_nothing": analysis.stands and analysis.bears_nothing,
        "no_finite_factor": analysis.unlimited,
        "associated": None,
        "least": None,
        "starts": analysis.starts,
        "mechanism": mechanism_facts(whole.collapse.mechanism, whole.assembly.names, "least" if analysis.least else "associated"),
        "crushed": [asdict(one) for one in whole.crushed],
        "little_left": None if whole.spare is None else asdict(whole.spare),
        "ties": [tie.row() for tie in whole.ties],
        "certificate": asdict(answer.certificate) if finite else None,
        "solver": {"method": answer.optimum.method, "iterations": answer.optimum.iterations, "seconds": answer.seconds},
        **_factors(whole),
    }


def _factors(whole: WholeAnalysis) -> dict[str, Any]:
    """The factors that there are; of supports that move, the force that they still bear [N]."""
    analysis, factor, least = whole.analysis, whole.analysis.associated.factor, whole.analysis.least
    if not whole.has_factor:
        return {}
    if analysis.problem.moves_support:
        return {"support_force": -factor * analysis.problem.weight}
    out: dict[str, Any] = {} if analysis.unlimited else {"associated": factor}
    if whole.loads.kind == "tilt" and not analysis.unlimited:
        out["angle_degrees"] = math.degrees(math.atan(factor))
    if least is not None:
        out["least"] = {
            "factor": least.optimum.factor, "gap": least.gap, "starts": least.starts, "agreeing": least.agreeing,
            "spread": least.spread, "found": list(least.found),
        }  # fmt: skip
    return out


def _basis(case: LimitCase) -> dict[str, Any]:
    """The basis of the check: the search, why "satisfied" does not follow from it, and the mechanisms that were looked at."""
    each = case.decides
    assert each is not None
    looked = [other.row for other in looked_at(each, case.mechanisms)]
    return {"search": each.part.search, "doubt": each.doubt, "looked": looked, "numbers": asdict(each.part.numbers)}


def _of_a_part(case: LimitCase, part: ElementAnalysis) -> dict[str, Any]:
    """A part under a push: its blocks, the search within it, what holds it."""
    numbers = asdict(part.numbers)
    search = None if numbers["least"] is None else {key: numbers[key] for key in ("least", "starts", "agreeing", "spread")}
    return {
        "element": part.element.name, "kind": part.element.kind, "push": way_words(part.direction), "points": part.points,
        "interlock_n": part.interlock, "search": search, "held": part.held, "remarks": list(part.remarks),
        "blocks": [case.structure.assembly.names[b] for b in part.element.blocks],
    }  # fmt: skip
