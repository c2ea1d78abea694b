# SPDX-License-Identifier: GPL-3.0-or-later
"""The runs of an assessment: the base case, its ensemble, each level of each assumption, and, if asked for, pairs of levels."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

from loads import shakes
from masonry_cd.analysis.assessment.assessment import BASE, ENSEMBLE, LEVEL, PAIR
from masonry_cd.app.doubts import assess_doubts
from masonry_cd.app.scene import Scene
from masonry_cd.app.scene_text import is_within, keys_of
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.masonry_kinds import RIGID
from masonry_cd.studies.assess.assumptions import DAMPING, POINTS, STIFFNESS, Assumption, Level, assumptions_of
from masonry_cd.studies.study.designs import Asked, Space
from masonry_cd.studies.study.plan import SIZE, Maker, Planned, StudyPlan, space_of, tables_of
from masonry_cd.studies.study.study_file import Study

DESIGN = "assess"


@dataclass(frozen=True)
class RunRole:
    """Part of an assessment to which a run belongs: its kind, and which levels of which assumptions it has."""

    kind: str  # base | ensemble | level | pair
    levels: tuple[tuple[Assumption, Level], ...] = ()
    member: int = 0

    def values(self) -> dict[str, str]:
        """Levels by their assumptions, as text."""
        return {assumption.name: level.name for assumption, level in self.levels}


class AssessMaker(Maker):
    """Makes the scenes of an assessment's runs."""

    def __init__(self, study: Study, space: Space, known: Sequence[Assumption]) -> None:
        super().__init__(study, space)
        self._levels = {(one.name, level.name): (one, level) for one in known for level in one.levels}

    def tables(self, asked: Asked) -> dict[str, Any]:
        """The tables of a run's scene. Statics is asked for where an answer of limit analysis may change.

        Raises:
            InputError: the ensemble has nothing to perturb.
        """
        tables = copy.deepcopy(super().tables(Asked()))
        if not (asked.values or asked.member):  # the keys that the scene calls meant so are all there
            quiet, keys = self.study.scene.quiet_checks, [key for key, _ in keys_of(tables)]
            tables["quiet_checks"] = [name for name in quiet if any(is_within(key, name) for key in keys)]
        chosen = [self._levels[item] for item in asked.values.items()]
        for _, level in chosen:
            level.change(tables)
        if asked.member or (chosen and not any(one.statics for one, _ in chosen)):
            tables.pop("limit", None)
        if asked.member:
            self._perturb(tables, asked)
        return tables

    def planned(self, asked: Asked) -> Planned:
        """The run with its name, and what it costs."""
        tables, cost = self.tables(asked), 1.0
        for item in asked.values.items():
            cost *= self._levels[item][1].cost
        return Planned(self.name(tables), asked, cost * max(1, self.study.scene.run.steps))


class AssessPlan(StudyPlan):
    """The runs of an assessment.

    Args:
        scene: checked.
        all_pairs: two levels of every two assumptions as well.

    Raises:
        InputError: a scene whose values are none, or nothing that is varied.
    """

    def __init__(self, scene: Scene, all_pairs: bool = False) -> None:
        tables = tables_of(scene) | {"quiet_checks": []}
        if isinstance(tables.get("limit"), Mapping):
            tables["limit"] = {key: value for key, value in tables["limit"].items() if key != "curve"}
        self.shakes = not scene.limit or shakes(scene.loads)
        self.known, self.left_out = assumptions_of(scene, tables, self.shakes)
        if not self.known:
            raise InputError(scene.origin.of("assess"), "assess.leave_out: nothing is left to vary")
        self.doubtful = assess_doubts(scene)
        self.parts = list(self._parts(scene.assess.members, all_pairs))
        asked = (Asked(member=part.member or None, change=SIZE * part.member, values=part.values()) for part in self.parts)
        super().__init__(AssessMaker(*space_of(scene, tables), self.known), asked, DESIGN)

    def _parts(self, members: int, all_pairs: bool) -> Iterator[RunRole]:
        """The runs, the base case first."""
        yield RunRole(BASE)
        if self.shakes:
            yield from (RunRole(ENSEMBLE, member=k) for k in range(1, members))
        for one in self.known:
            yield from (RunRole(LEVEL, ((one, level),)) for level in one.levels)
        if all_pairs:
            for first, second in combinations([one for one in self.known if not one.reference], 2):
                for levels in product(ends_of(first), ends_of(second)):
                    if not (first.name == STIFFNESS and second.name in (DAMPING, POINTS) and levels[0].name == RIGID):
                        yield RunRole(PAIR, ((first, levels[0]), (second, levels[1])))


def ends_of(assumption: Assumption) -> tuple[Level, ...]:
    """The two outer levels of an assumption that are no coarser than the base case, or its only one."""
    levels = tuple(level for level in assumption.levels if not level.coarser)
    return levels if len(levels) < 2 else (levels[0], levels[-1])
