# SPDX-License-Identifier: GPL-3.0-or-later
"""Cloud: every motion once, as it was recorded (Jalayer, 2003). What is random is drawn for each."""

from __future__ import annotations

from collections.abc import Iterator

from masonry_cd.studies.study.space import Asked, Space


def runs(space: Space) -> Iterator[Asked]:
    """The runs."""
    for motion in space.motions:
        for values in space.combinations():
            yield Asked(motion, values=values | space.draw(motion, *values.items()))
