# SPDX-License-Identifier: GPL-3.0-or-later
"""An ensemble: the same scene under tiny perturbations, which show how far a chaotic run spreads. The first member is the scene itself."""

from __future__ import annotations

from collections.abc import Iterator

from masonry_cd.studies.study.space import Asked, Space
from masonry_cd.studies.study.study_file import EnsembleTable
from masonry_cd.studies.study.varied import uniform_numbers


def runs(space: Space) -> Iterator[Asked]:
    """The runs: as many members for each motion and each combination of what varies; a member's change is drawn by its number alone."""
    asked = space.tables.ensemble or EnsembleTable()
    for motion in space.motions:
        for values in space.combinations():
            drawn = values | space.draw(motion, *values.items())
            for member in range(asked.members):
                u = float(uniform_numbers(space.tables.seed, ("member", member), 1)[0])
                change = 0.0 if member == 0 else asked.size * (2.0 * u - 1.0)
                yield Asked(motion, member=member, change=change, values=drawn)
