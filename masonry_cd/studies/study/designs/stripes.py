# SPDX-License-Identifier: GPL-3.0-or-later
"""Stripes: every motion at every level of intensity (Jalayer & Cornell, 2009). What is random is drawn anew for each run."""

from __future__ import annotations

from collections.abc import Iterator

from masonry_cd.studies.study.space import Asked, Space


def runs(space: Space) -> Iterator[Asked]:
    """The runs; a draw follows from motion, level and the values of lists, so more of these change none that is there."""
    for motion in space.motions:
        for level in space.levels:
            for values in space.combinations():
                yield Asked(motion, level, values=values | space.draw(motion, level, *values.items()))
