# SPDX-License-Identifier: GPL-3.0-or-later
"""A Latin hypercube sample of all that varies: distributions by their quantiles, lists, levels and motions by their places."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from masonry_cd.studies.study.space import Asked, Space


def runs(space: Space) -> Iterator[Asked]:
    """The runs; another number of samples makes all of them anew."""
    from scipy.stats.qmc import LatinHypercube

    lists, keys = space.varied.lists, space.varied.keys
    count = space.tables.samples
    assert count is not None
    places = LatinHypercube(d=len(keys) + len(lists) + 2, rng=space.tables.seed).random(count)
    for u in places:
        values: dict[str, Any] = space.varied.draw(u[: len(keys)])
        values |= {key: _at(u[len(keys) + i], lists[key]) for i, key in enumerate(lists)}
        ordered = {key: values[key] for key in space.varied.columns}
        yield Asked(_at(u[-2], space.motions), _at(u[-1], space.levels), values=ordered)


def _at(u: float, choices: Sequence[Any]) -> Any:
    """The choice at a share of a list."""
    return choices[min(int(u * len(choices)), len(choices) - 1)]
