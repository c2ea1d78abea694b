# SPDX-License-Identifier: GPL-3.0-or-later
"""All combinations: of the lists and ranges that vary, the levels, and the motions."""

from __future__ import annotations

from collections.abc import Iterator

from masonry_cd.foundation.errors import InputError
from masonry_cd.studies.study.space import Asked, Space


def runs(space: Space) -> Iterator[Asked]:
    """The runs.

    Raises:
        InputError: something varies by a distribution, of which a grid has no points.
    """
    for key in space.varied.keys:
        raise InputError(f'vary."{key}"', 'a grid takes lists and ranges; design = "sample" takes distributions')
    for motion in space.motions:
        for level in space.levels:
            for values in space.combinations():
                yield Asked(motion, level, values=values)
