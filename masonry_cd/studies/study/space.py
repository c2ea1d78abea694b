# SPDX-License-Identifier: GPL-3.0-or-later
"""What a design chooses from: motions, levels, values of lists and draws of distributions; and a run as a design asks for it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import Any

from masonry_cd.studies.study.records import Motion, Records
from masonry_cd.studies.study.study_file import StudyTables
from masonry_cd.studies.study.varied import Varied, uniform_numbers


@dataclass(frozen=True, slots=True)
class Asked:
    """A run as a design asks for it."""

    motion: str = ""
    level: float | None = None
    member: int | None = None  # of an ensemble
    change: float = 0.0  # relative, of what an ensemble perturbs
    values: Mapping[str, Any] = field(default_factory=dict)  # of the keys that vary


@dataclass(frozen=True, eq=False)
class Space:
    """What a design chooses from."""

    tables: StudyTables
    records: Records | None
    varied: Varied

    @property
    def motions(self) -> list[str]:
        """Names of the motions; one without a name where the scene has its own loads."""
        return [""] if self.records is None else [motion.name for motion in self.records.motions]

    @property
    def levels(self) -> list[float | None]:
        """The levels of intensity; None alone where nothing is scaled to one."""
        intensity = self.tables.intensity
        return [None] if intensity is None or intensity.levels is None else [*intensity.levels]

    def motion(self, name: str) -> Motion:
        """A motion by its name."""
        assert self.records is not None
        return self.records.by_name[name]

    def combinations(self) -> Iterator[dict[str, Any]]:
        """A value for each key that varies by a list, in all combinations."""
        for values in product(*self.varied.lists.values()):
            yield dict(zip(self.varied.lists, values, strict=True))

    def draw(self, *words: object) -> dict[str, float]:
        """A value for each distribution, which the study's seed and some words decide alone: what else is in the design changes none."""
        keys = self.varied.keys
        return self.varied.draw(uniform_numbers(self.tables.seed, words, len(keys))) if keys else {}
