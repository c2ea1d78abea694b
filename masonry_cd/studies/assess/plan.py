# SPDX-License-Identifier: GPL-3.0-or-later
"""The runs of an assessment: the base case, its ensemble, each level of each assumption; if requested, pairs of levels, and all at once.

Where all vary at once, each number is uniform over the range of its levels, moduli and soil in their logarithms, and each choice as likely
as the others. Settings of the computation have no probabilities and stay as they are; rigid joints are no value of a range, so all joints
are elastic where their stiffness varies. The runs are points of Halton's sequence, scrambled: more of them leave the first as they are.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

from loads import shakes
from masonry_cd.analysis.assessment.assessment import BASE, ENSEMBLE, GLOBAL, LEVEL, PAIR
from masonry_cd.app.doubts import assess_doubts
from masonry_cd.app.scene import Scene
from masonry_cd.app.scene_text import is_within, keys_of
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.masonry_kinds import RIGID
from masonry_cd.studies.assess.assumptions import assumptions_of
from masonry_cd.studies.assess.joint_levels import is_elastic
from masonry_cd.studies.assess.levels import DAMPING, NUMERICAL, POINTS, STIFFNESS, Assumption, Level
from masonry_cd.studies.study.designs import DesignedRun, Space
from masonry_cd.studies.study.plan import SIZE, Maker, Planned, StudyPlan, space_of, tables_of
from masonry_cd.studies.study.study_file import ReadStudy

DESIGN = "assess"
OF_EACH = 10  # runs for each unknown, where all vary at once (Loeppky, Sacks & Welch, Technometrics 51(4), 2009)


@dataclass(frozen=True)
class RunRole:
    """Part of an assessment to which a run belongs: its kind, and which levels of which assumptions it has."""

    kind: str  # base | ensemble | level | pair | global
    levels: tuple[tuple[Assumption, Level], ...] = ()
    member: int = 0
    at: tuple[float, ...] = ()  # point of the unit cube where all vary at once

    def values(self) -> dict[str, str]:
        """Levels by their assumptions, as text."""
        return {assumption.name: level.name for assumption, level in self.levels}

    def asked(self) -> DesignedRun:
        """The run: levels by their names, or all assumptions by their coordinates."""
        values: Mapping[str, Any] = self.values()
        if self.at:
            values = {assumption.name: u for (assumption, _), u in zip(self.levels, self.at, strict=True)}
        return DesignedRun(member=self.member or None, change=SIZE * self.member, values=values)


class AssessMaker(Maker):
    """Makes the scenes of an assessment's runs."""

    def __init__(self, study: ReadStudy, space: Space, known: Sequence[Assumption]) -> None:
        super().__init__(study, space)
        self._known = {one.name: one for one in known}

    def tables(self, asked: DesignedRun) -> dict[str, Any]:
        """The tables of a run's scene. Statics is required where an answer of limit analysis may change.

        Raises:
            InputError: the ensemble has nothing to perturb.
        """
        tables = copy.deepcopy(super().tables(DesignedRun()))
        if not (asked.values or asked.member):  # the keys that quiet_checks lists are all there
            quiet, keys = self.study.scene.quiet_checks, [key for key, _ in keys_of(tables)]
            tables["quiet_checks"] = [name for name in quiet if any(is_within(key, name) for key in keys)]
        for level in self._levels(asked):
            level.change(tables)
        if asked.member or (asked.values and not any(self._known[name].statics for name in asked.values)):
            tables.pop("limit", None)
        if asked.member:
            self._perturb(tables, asked)
        return tables

    def planned(self, asked: DesignedRun) -> Planned:
        """The run with its name, and what it costs."""
        tables, cost = self.tables(asked), 1.0
        for level in self._levels(asked):
            cost *= level.cost
        return Planned(self.name(tables), asked, cost * max(1, self.study.scene.run.steps))

    def _levels(self, asked: DesignedRun) -> list[Level]:
        """The levels that a run has, by their names or by coordinates."""
        by_name = {(one.name, level.name): level for one in self._known.values() for level in one.levels}
        return [self._known[name].at(at) if isinstance(at, float) else by_name[name, at] for name, at in asked.values.items()]


class AssessPlan(StudyPlan):
    """The runs of an assessment.

    Args:
        scene: checked.
        all_pairs: two levels of every two assumptions as well.
        at_once: runs in which all properties of the structure vary at once as well.

    Raises:
        InputError: a scene whose values are none, or nothing that is varied.
    """

    def __init__(self, scene: Scene, all_pairs: bool = False, at_once: bool = False) -> None:
        tables = tables_of(scene) | {"quiet_checks": []}
        if isinstance(tables.get("limit"), Mapping):
            tables["limit"] = {key: value for key, value in tables["limit"].items() if key != "curve"}
        self.shakes = not scene.limit or shakes(scene.loads)
        self.known, self.left_out = assumptions_of(scene, tables, self.shakes)
        if not self.known:
            raise InputError(scene.origin.of("assess"), "assess.leave_out: nothing is left to vary")
        self.doubtful = assess_doubts(scene)
        self.unknown = self._unknown(scene) if at_once else []
        self.parts = [*self._parts(scene.assess.members, all_pairs), *self._at_once(scene.assess.samples)]
        super().__init__(AssessMaker(*space_of(scene, tables), self.known), (part.asked() for part in self.parts), DESIGN)

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

    def _unknown(self, scene: Scene) -> list[Assumption]:
        """The assumptions on the structure that may vary at once: joints that stay rigid have no damping."""
        rigid = not is_elastic(scene) and STIFFNESS not in (one.name for one in self.known)
        found = [one for one in self.known if one.name not in NUMERICAL and not (rigid and one.name == DAMPING)]
        if len(found) < 2:
            raise InputError(scene.origin.of("assess"), "assess.leave_out: fewer than two properties are left to vary at once")
        return found

    def _at_once(self, samples: int | None) -> Iterator[RunRole]:
        """Runs in which all vary."""
        from scipy.stats.qmc import Halton

        if not self.unknown:
            return
        for u in Halton(len(self.unknown), rng=0).random(samples or OF_EACH * len(self.unknown)).tolist():
            yield RunRole(GLOBAL, tuple((one, one.at(at)) for one, at in zip(self.unknown, u, strict=True)), at=tuple(u))


def ends_of(assumption: Assumption) -> tuple[Level, ...]:
    """The two outer levels of an assumption that are no coarser than the base case, or its only one."""
    levels = tuple(level for level in assumption.levels if not level.coarser)
    return levels if len(levels) < 2 else (levels[0], levels[-1])
