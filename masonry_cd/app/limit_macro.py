# SPDX-License-Identifier: GPL-3.0-or-later
"""The macro-elements of a scene: ``masonry-cd limit --macro-elements`` and ``[[limit.mechanism]]``."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.analysis.code_check.level import foundation_of
from masonry_cd.analysis.code_check.verdicts import Judgement
from masonry_cd.analysis.limit.macro import Effort, ElementAnalysis, analyse_element
from masonry_cd.analysis.limit.part import Whole
from masonry_cd.app.doubts import doubts
from masonry_cd.app.limit_check import heights_along_z
from masonry_cd.app.limit_parts import whole_of
from masonry_cd.app.limit_structure import limit_structure
from masonry_cd.app.macro_parts import elements_of, in_pieces
from masonry_cd.app.macro_verdicts import MacroRow, judged, rows_of
from masonry_cd.app.modelled import masses
from masonry_cd.app.progress import Progress
from masonry_cd.app.scene import Scene
from masonry_cd.foundation import system
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import counted
from masonry_cd.foundation.workers import workers
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.solvers.options import cores

if TYPE_CHECKING:
    from masonry_cd.app.limit_table import LimitTable
    from masonry_cd.app.static_loads import StaticLoads
    from structures.macro_elements import MacroElement

STARTS = 2  # of the free search within a part, beside those at the mechanisms of practice
SEARCHED = 2_500  # contact points of a part up to which it is made unasked: some 10 s of processor time for a push


@dataclass(frozen=True, eq=False)
class MacroCase:
    """A scene and the analysis of its macro-elements."""

    scene: Scene
    assembly: Assembly
    joints: Joints
    loads: StaticLoads
    parts: tuple[ElementAnalysis, ...]  # one for each macro-element and push
    rows: tuple[MacroRow, ...]  # every mechanism, the least ratio first; without a check the least a0
    verdict: Judgement | None  # None where no check is asked for
    notes: tuple[str, ...]
    seconds: float
    modelled: tuple[str, ...] = ()  # masses, ties, floors and fill, in words


def macro_case(scene: Scene, every: bool, jobs: int | None = None, quiet: bool = True) -> MacroCase:
    """Analyse the macro-elements of a scene.

    Args:
        scene: what is analysed.
        every: those of its structure's kind, beside the chosen ones of ``[[limit.mechanism]]``.
        jobs: processes; as many as there are cores by default.
        quiet: do not say how long the parts still take.

    Raises:
        InputError: anything wrong with the scene, or a table that names no block.
    """
    from loads.motion import parse_direction
    from structures.macro_elements import groups, macro_elements

    begin = time.perf_counter()
    built = limit_structure(scene)
    asked, assembly, joints = built.asked, built.assembly, built.joints
    with scene.locating():
        _suits(asked, scene)
        named = macro_elements(built.made.blocks, groups if scene.kind is None else scene.kind.parts)
        elements = elements_of(asked.mechanism, named, every, assembly)
        apart = in_pieces(elements, joints)
        loads = built.loads(asked.model_copy(update={"push": parse_direction("x"), "tilt": None, "live": ()}))  # each part has its own push
        structure = whole_of(built, loads)
        effort = Effort(
            STARTS if asked.starts is None else asked.starts,
            SEARCHED if asked.starts is None else 2**62,
            scene.run.seed,
            asked.check is not None and asked.check.by_displacements,
        )
        parts = _analysed(structure, elements, effort, (jobs or cores(), quiet))
        rows = rows_of(parts, asked.check, scene.folder, foundation_of(asked.check, assembly), effort)
    notes = [*apart, *doubts(scene, assembly, joints)]
    notes += [*built.made.notes, *(f"{one.element.name}: {remark}" for one in parts for remark in one.remarks), *loads.notes]
    verdict = None if asked.check is None else judged(rows, parts)
    seconds, modelled = time.perf_counter() - begin, (masses(assembly), *built.made.notes)
    return MacroCase(scene, assembly, joints, loads, tuple(parts), rows, verdict, tuple(notes), seconds, modelled)


def _suits(asked: LimitTable, scene: Scene) -> None:
    """Refuse what a check of parts does not know.

    Raises:
        InputError: names the key.
    """
    heights_along_z("limit: what looks at macro-elements", scene.run.gravity)
    if asked.begin is not None:
        raise InputError("limit.from", "macro-elements are those of the structure as built")
    if asked.check is not None and asked.check.limit_state == "SLC":
        raise InputError(
            "limit.check.limit_state", "SLC is checked by displacements only, and of macro-elements the least mechanism alone is followed"
        )


def _analysed(whole: Whole, elements: Sequence[MacroElement], effort: Effort, how: tuple[int, bool]) -> list[ElementAnalysis]:
    """All parts under all their pushes, in order, on so many processes that share the structure; quiet or not."""
    (jobs, quiet), found = how, []
    asked = [(element, way) for element in elements for way in element.directions]
    whole.prepare()
    several = jobs > 1 and len(asked) > 1
    with workers(jobs, system.INHERITS, _share, whole, effort) if several else nullcontext() as pool:
        runs = [pool.submit(_one, each) for each in asked] if pool else []
        made = (run.result() for run in runs) if pool else (analyse_element(whole, element, way, effort) for element, way in asked)
        with Progress(len(asked), quiet, what="push of a part") as progress:
            for one in made:
                found.append(one)
                progress(len(found))
    return found


_SHARED: list[Any] = []  # structure and effort, in each process of a pool


def _share(whole: Whole, effort: Effort) -> None:
    _SHARED[:] = [whole, effort]


def _one(asked: tuple[MacroElement, tuple[float, float, float]]) -> ElementAnalysis:
    """A part, in a process of the pool."""
    whole, effort = _SHARED
    return analyse_element(whole, *asked, effort)


def lines(case: MacroCase) -> list[str]:
    """The analysis in words: the least mechanism of each part, ranked, and the verdict."""
    pushes, elements = len(case.parts), len({one.element.name for one in case.parts})
    out = [f"{counted(elements, 'macro-element')} under {pushes} pushes, each with all else held, {case.assembly.count} blocks"]
    out += [row.words for row in least_rows(case.rows)]
    held = [f"{one.element.name} {_way(one.direction)}" for one in case.parts if not one.mechanisms]
    if held:
        out.append(f"held, no mechanism below a factor of 5: {', '.join(held)}")
    return [*out, *([] if case.verdict is None else [case.verdict.words]), *case.notes]


def least_rows(rows: Sequence[MacroRow]) -> list[MacroRow]:
    """The first row of each part and push."""
    first: dict[tuple[str, str], MacroRow] = {}
    for row in rows:
        first.setdefault((row.element, row.push), row)
    return list(first.values())


def _way(direction: np.ndarray) -> str:
    from masonry_cd.app.macro_verdicts import way_words

    return way_words(direction)
