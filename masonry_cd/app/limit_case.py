"""The limit analysis of a scene: what the command ``masonry-cd limit`` does."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.app.scene import Scene, read_scene
from masonry_cd.contact.find_joints import built_gap, find_joints, loose_contacts
from masonry_cd.errors import InputError
from masonry_cd.limit.analysis import Analysis, Collapse, Options, analyse
from masonry_cd.limit.mechanism import STATES
from masonry_cd.limit.problem import plane_of
from masonry_cd.model.blocks import Assembly
from masonry_cd.model.joints import Joints
from masonry_cd.quantities import force, in_words

if TYPE_CHECKING:
    from loads.statics import LimitTable, StaticLoads

OUTPUTS = ("limit.json", "blocks.csv", "joints.csv", "mechanism.png", "thrust.png")
TURNS = 30  # most rounds in which the angle of a tilt is found
SAME_TILT = 1e-9  # change of lambda at which it is
STARTS = 3  # of the search for the least factor in a plane
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
    notes: tuple[str, ...]
    seconds: float

    @property
    def collapse(self) -> Collapse:
        """What moves, and the forces then."""
        return self.analysis.collapse(self.joints.count)


def limit_case(path: Path | str, changes: Sequence[str] = ()) -> LimitCase:
    """Analyse a scene.

    Args:
        path: the scene file.
        changes: ``key=value`` that change it.

    Raises:
        InputError: anything wrong with the scene, or a limit analysis without an answer.
    """
    from loads.statics import limit_table, static_loads
    from masonry_cd.app.case import make_structures

    begin = time.perf_counter()
    scene = read_scene(path, changes)
    blocks, notes, bars = make_structures(scene)
    try:
        asked = limit_table(scene.limit)
        assembly = Assembly.from_blocks(blocks, scene.material.friction, scene.material.joints)
        loads = static_loads(scene.loads, asked, scene.run.gravity, scene.folder, assembly, [(bar.where, bar.load()) for bar in bars])
        joints = find_joints(assembly)
        analysis = _analyse(assembly, joints, loads, asked, scene.run.seed)
    except InputError as error:
        raise scene.at_fault(error) from None
    loose = loose_contacts(assembly)
    if loose:
        notes.append(f"{loose} pairs of blocks touch along a line or in a point only: these contacts bear nothing here")
    gap = built_gap(assembly)
    if gap > 1e-8 * assembly.width:
        notes.append(f"joints as built have gaps or overlaps of up to {gap:.2g} m, which count as none")
    if assembly.laws.apex.any():
        notes.append("bond counts as plastic: it is brittle, and what it adds to the factor is an upper bound")
    return LimitCase(scene, assembly, joints, loads, analysis, (*notes, *loads.notes), time.perf_counter() - begin)


def _analyse(assembly: Assembly, joints: Joints, loads: StaticLoads, asked: LimitTable, seed: int) -> Analysis:
    """The limit analysis; of a tilt beside loads that do not turn with it, at the angle that belongs to its own factor."""
    usual = STARTS if plane_of(assembly, loads.at()) is not None else 0
    options = Options(asked.sides, usual if asked.starts is None else asked.starts, seed)
    if loads.kind != "tilt" or (loads.only_gravity and not assembly.laws.apex.any()):
        return analyse(assembly, joints, loads.at(), options)
    factor, last = 0.0, math.inf
    for _ in range(TURNS):
        found = analyse(assembly, joints, loads.at(1.0 / math.sqrt(1.0 + factor**2)), options)
        factor, last = found.associated.factor, factor
        if not found.stands or abs(factor - last) <= SAME_TILT * (1.0 + abs(factor)):
            return found
    raise InputError(f"limit.tilt: the angle of collapse is not found in {TURNS} rounds; push gives the factor of a body force")


def summary(case: LimitCase) -> dict[str, Any]:
    """What limit.json holds."""
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
        "associated": None,
        "least": None,
        "mechanism": _mechanism(case),
        "certificate": asdict(answer.certificate) if analysis.stands else None,
        "solver": {"method": answer.optimum.method, "iterations": answer.optimum.iterations, "seconds": answer.seconds},
        "seconds": case.seconds,
        "notes": list(case.notes),
    }
    if not analysis.stands:
        return out
    if analysis.problem.moves_support:
        out["support_force"] = -answer.factor * analysis.problem.weight
        return out
    out["associated"] = answer.factor
    if case.loads.kind == "tilt":
        out["angle_degrees"] = math.degrees(math.atan(answer.factor))
    if least is not None:
        out["least"] = {
            "factor": least.optimum.factor, "gap": least.gap, "starts": least.starts, "agreeing": least.agreeing,
            "found": list(least.found),
        }  # fmt: skip
    return out


def _mechanism(case: LimitCase) -> dict[str, Any]:
    """Which blocks move and how many joints are at work."""
    moves = case.collapse.mechanism
    names = [case.assembly.names[b] for b in np.flatnonzero(moves.moving)]
    return {"of": "least" if case.analysis.least else "associated", "moving_blocks": names} | {
        f"joints_{state.replace(' ', '_')}": moves.count(state) for state in STATES
    }


def lines(case: LimitCase) -> list[str]:
    """The analysis in words."""
    analysis, answer, least = case.analysis, case.analysis.associated, case.analysis.least
    space = "in a plane" if analysis.problem.axis is not None else "in space"
    out = [f"{case.assembly.count} blocks, {case.joints.count} joints, {analysis.problem.points.count} contact points, {space}"]
    if not analysis.stands:
        borne = f", it bears {100.0 * analysis.standing:.3g} % of them" if analysis.standing > 1e-6 else ""
        out.append(f"does not stand under its dead loads{borne}: {_who(case)} give way")
        return [*out, *case.notes]
    out.append("stands under its dead loads")
    if analysis.problem.moves_support:
        out.append(f"{case.loads.words}: the supports that move still bear {force(-answer.factor * analysis.problem.weight)} against it")
    else:
        angle = f", an angle of {math.degrees(math.atan(answer.factor)):.4g} degrees" if case.loads.kind == "tilt" else ""
        out.append(f"{case.loads.words}: load factor {answer.factor:.5g}{angle} (associated: sliding opens joints; an upper value)")
    if least is not None:
        sure = f"{least.agreeing} of {least.starts} starts came to it, none to less; no proof that it is the least"
        out.append(f"sliding without dilation: {least.optimum.factor:.5g} is the least found; {sure}")
        apart = answer.factor - least.optimum.factor > SAME * abs(answer.factor)
        between = f"Coulomb's law allows {least.optimum.factor:.5g} to {answer.factor:.5g} at least; a run finds one of its values"
        out.append(between if apart else "both agree: how joints slide makes no difference here")
    elif not analysis.problem.moves_support:
        out.append(_no_least(case))
    moves = case.collapse.mechanism
    out.append(f"mechanism: {_who(case)} move; joints: " + ", ".join(f"{moves.count(state)} {state}" for state in STATES[1:]))
    made = answer.certificate
    out.append(
        f"certificate: static {made.static:.8g}, kinematic {made.kinematic:.8g}, gap {made.gap:.1e}; residuals: "
        f"equilibrium {made.equilibrium:.1e}, friction {made.friction:.1e}, flow {made.flow:.1e}; "
        f"{answer.optimum.method}, {in_words(answer.seconds)}"
    )
    return [*out, *case.notes]


def _no_least(case: LimitCase) -> str:
    """Why there is no least factor."""
    off = "not searched for; limit.starts = 2 does, at some twenty times the cost of each"
    sought = "no start came to an end" if case.scene.limit.get("starts") else off
    return f"sliding without dilation may give way at less: {sought}"


def _who(case: LimitCase) -> str:
    """The blocks that move, some by name."""
    moving = np.flatnonzero(case.collapse.mechanism.moving)
    free = int((~case.assembly.fixed).sum())
    some = ", ".join(f'"{case.assembly.names[b]}"' for b in moving[:NAMED])
    return f"{len(moving)} of {free} blocks ({some}{' ...' if len(moving) > NAMED else ''})"


def write(case: LimitCase, folder: Path, pictures: bool = True, view: str = "auto") -> list[Path]:
    """Write limit.json, the tables and the pictures into a folder, which is made if need be.

    Raises:
        InputError: an unknown view, no off-screen OpenGL for the pictures; the tables are written by then.
    """
    from masonry_cd.app.summary import write_json
    from reports.limit.tables import write_tables

    folder.mkdir(parents=True, exist_ok=True)
    for name in OUTPUTS:
        (folder / name).unlink(missing_ok=True)
    write_json(summary(case), folder / "limit.json")
    collapse = case.collapse
    written = [folder / "limit.json", *write_tables(collapse, case.assembly, case.joints, folder)]
    if pictures:
        from reports.limit.picture import mechanism_picture, thrust_picture

        drawn = (collapse, case.assembly.blocks, case.joints)
        facts = _facts(case)
        mechanism_picture(*drawn, folder / "mechanism.png", f"{case.scene.title}: mechanism", facts, view)
        written.append(folder / "mechanism.png")
        if case.analysis.stands:
            thrust_picture(*drawn, folder / "thrust.png", f"{case.scene.title}: forces at collapse", facts, view)
            written.append(folder / "thrust.png")
    return written


def _facts(case: LimitCase) -> str:
    """The line below the title of a picture."""
    analysis = case.analysis
    if not analysis.stands:
        return "does not stand under its dead loads"
    if analysis.problem.moves_support:
        return f"{case.loads.words}: the supports still bear {force(-analysis.associated.factor * analysis.problem.weight)}"
    least = f" · least found without dilation {analysis.least.optimum.factor:.4g}, drawn" if analysis.least else ""
    return f"{case.loads.words} · load factor {analysis.associated.factor:.4g} (associated){least}"
