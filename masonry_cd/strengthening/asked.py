# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene becomes the question of a strengthening: candidates, target, and the limit analyses that have to reach it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.analysis.limit.part import Whole, resting
from masonry_cd.analysis.limit.problem import Bars, plane_of
from masonry_cd.analysis.limit.strengthening import Candidates
from masonry_cd.app.limit_structure import LimitStructure, limit_structure
from masonry_cd.app.scene import Scene
from masonry_cd.app.strengthen_table import StrengthenTable
from masonry_cd.foundation.errors import InputError
from masonry_cd.limit.case import WantedMechanisms, check_gravity_along_z, has_pattern
from masonry_cd.limit.checked import way_words
from masonry_cd.limit.parts import asked_for, whole_of
from masonry_cd.limit.whole import THE_WHOLE
from masonry_cd.strengthening.goal import Goal, goal_of

if TYPE_CHECKING:
    from structures.ties import TieRowTable

STARTS = 2  # of the search for the least factor in space, where the scene names none

Rows = Sequence[Mapping[str, Any]]  # tables [[structure.ties]]


@dataclass(frozen=True, eq=False)
class StrengtheningTask:
    """The question."""

    scene: Scene  # whose limit analyses are by accelerations, and search for the least factor
    structure: LimitStructure  # without candidates
    table: StrengthenTable
    goal: Goal
    pushes: tuple[tuple[float, float, float], ...]  # of the whole
    with_parts: bool  # macro-elements are looked at as well
    rows: tuple[dict[str, Any], ...]  # of the candidates, (N,): keys of [[structure.ties]] but the section and the yield force
    lengths: np.ndarray  # (N,) [m]
    candidates: Candidates
    notes: tuple[str, ...]

    def analyses(self, rows: Rows) -> Iterator[tuple[Scene, WantedMechanisms]]:
        """The limit analyses of the structure with more ties: the whole under each push, and the macro-elements."""
        made = replace(self.scene, structure=self.scene.structure | {"ties": [*self.scene.structure.get("ties", ()), *rows]})
        own = {key: value for key, value in made.limit.items() if key not in ("push", "tilt", "live", "mechanism")}
        for push in self.pushes:
            yield replace(made, limit=own | {"push": list(push)}), WantedMechanisms()
        if self.with_parts:
            yield made, WantedMechanisms(self.table.macro_elements, whole=False)

    def parts(self, whole: Whole) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
        """A part for associated sliding: its name with the push, the blocks that are free (B,), and the direction (3,)."""
        for push in self.pushes:
            yield f"{THE_WHOLE}, push {way_words(np.asarray(push))}", ~whole.assembly.fixed, np.asarray(push)
        for element, way in asked_for(self.structure, self.table.macro_elements) if self.with_parts else ():
            yield f"{element.name}, push {way_words(np.asarray(way))}", resting(whole, element.blocks), np.asarray(way)

    def whole(self, force: np.ndarray) -> Whole:
        """The structure with candidates of yield forces (N,) [N]."""
        own, more = whole_of(self.structure, self.structure.loads_of_parts()), self.candidates.bars_at(force)
        names = ("blocks", "points", "strength")
        return replace(own, bars=Bars(*(np.concatenate([getattr(own.bars, name), getattr(more, name)]) for name in names)))


def asked_of(scene: Scene) -> StrengtheningTask:
    """The question that a scene asks.

    Raises:
        InputError: anything wrong with the scene.
    """
    if scene.structures:
        raise InputError(scene.origin.of("structures"), "structures: masonry-cd strengthen takes one [structure]")
    with scene.locating():
        if scene.strengthen is None:
            raise InputError("strengthen", "missing; masonry-cd strengthen needs factor or zeta_E, and candidates")
        table = scene.strengthen
    notes, limit = list[str](), dict(scene.limit)
    structure = limit_structure(scene)
    with scene.locating():
        if structure.asked.starts == 0:
            raise InputError("limit.starts", "0 makes no search for the least factor, by which a strengthening is verified: at least 2")
        if structure.asked.begin is not None:
            raise InputError("limit.from", "masonry-cd strengthen takes a structure as built")
        check_gravity_along_z("strengthen", scene.run.gravity)
        check = structure.asked.check
        if check is not None and check.checks_displacements:
            if check.limit_state == "SLC":
                raise InputError("limit.check.limit_state", "SLC is checked by displacements, and ties are found by accelerations")
            limit["check"] = {**limit["check"], "displacements": False}
            notes.append("ties are found by accelerations: limit.check.displacements counts as false; masonry-cd limit makes that check")
        limit.pop("curve", None)
        scene = replace(scene, limit=limit)
        structure = structure.of(scene)
        goal, pushes = goal_of(table, structure), _pushes(table, structure)
        rows, lengths, candidates, more = _candidates(table, structure)
        if structure.asked.starts is None and check is None and not _is_planar(structure, candidates, pushes):
            scene = replace(scene, limit=limit | {"starts": STARTS})
            structure = structure.of(scene)
        with_parts = table.macro_elements or bool(structure.asked.mechanism)
        if not pushes and not with_parts:
            raise InputError("strengthen", 'nothing to strengthen against; give pushes = ["x"], limit.push, or macro_elements = true')
    return StrengtheningTask(scene, structure, table, goal, pushes, with_parts, rows, lengths, candidates, (*notes, *more))


def _pushes(table: StrengthenTable, structure: LimitStructure) -> tuple[tuple[float, float, float], ...]:
    """The pushes of the whole.

    Raises:
        InputError: one that is not level, or a scene that multiplies something else.
    """
    if table.pushes is not None:
        for push in table.pushes:
            if abs(push.vector[2]) > 0.0:
                raise InputError("strengthen.pushes", f"must be level, got {push.label}")
        return tuple(push.vector for push in table.pushes)
    if not has_pattern(structure.scene):
        return ()
    loads = structure.loads()
    if loads.kind != "push" or loads.direction is None or loads.direction[2]:
        raise InputError("strengthen", f'needs level pushes, not {loads.words}: give pushes = ["x"]')
    return (loads.direction,)


def _is_planar(structure: LimitStructure, candidates: Candidates, pushes: Sequence[tuple[float, float, float]]) -> bool:
    """True of a structure that moves in a plane with all candidates, under each push."""
    loads, mass = structure.loads_of_parts().at(), structure.assembly.mass[:, None]
    own = [replace(loads, live=mass * np.array([*push, 0.0, 0.0, 0.0])) for push in pushes]
    return all(plane_of(structure.assembly, replace(each, bars=bars)) is not None for each in own for bars in (loads.bars, candidates.bars))


def _candidates(table: StrengthenTable, structure: LimitStructure) -> tuple[tuple[dict[str, Any], ...], np.ndarray, Candidates, list[str]]:
    """The candidates of tables and rules: keys, lengths [m], bars with forces and prices; and lines on what rules leave out.

    Raises:
        InputError: a candidate that holds on to nothing, or has the name of another tie; a rule that gives none.
    """
    from structures.tie_lines import by_rule, one_by_one
    from structures.ties import TieRowTable, ties_of

    blocks, catalogue, notes = structure.made.blocks, table.catalogue, list[str]()
    largest = float(catalogue[-1].yield_force or 0.0)
    lines, most = [], []
    for place, keys in one_by_one(blocks, table.ties, "strengthen.ties"):
        own = table.ties[int(place[place.index("[") + 1 : -1])].largest_force
        lines.append((place, keys))
        most.append(min(largest, own or largest))
    for rule in table.rules:
        made, left = by_rule(blocks, rule, table.spacing, table.plate)
        lines += [("strengthen.rules", keys) for keys in made]
        most += [largest] * len(made)
        notes += [left] if left else []
    names = [str(keys["name"]) for _, keys in lines]
    taken = [bar.keys["name"] for bar in structure.made.ties]
    for k, name in enumerate(names):
        if name in taken or name in names[:k]:
            raise InputError(lines[k][0], f'"{name}" is the name of another tie')
    bars = []
    for place, keys in lines:
        row: TieRowTable = TieRowTable.model_validate(keys | {"diameter": catalogue[-1].diameter, "yield_force": 1.0})
        try:
            bars.append(ties_of(blocks, [row])[0])
        except InputError as error:
            fault = error.faults[0]
            raise InputError(fault.place.replace("structure.ties[0]", place), fault.text) from None
    number = {name: b for b, name in enumerate(structure.assembly.names)}
    every = [bar for made in bars for bar in made]
    found = Bars(
        np.array([[number[block] for block in bar.blocks] for bar in every]), np.array([bar.points for bar in every]),
        np.array([bar.keys["yield_force"] for bar in every]),
    )  # fmt: skip
    lengths = np.array([np.average([math.dist(*bar.points) for bar in made], weights=[bar.keys["area"] for bar in made]) for made in bars])
    prices = table.prices
    per_force = 1e-3 * (prices.force + prices.per_kn_m * lengths)
    owner = np.repeat(np.arange(len(bars)), [len(made) for made in bars])
    anchors = np.full(len(bars), 2.0 * prices.anchor)
    return tuple(keys for _, keys in lines), lengths, Candidates(found, owner, np.array(most), per_force, anchors), notes
