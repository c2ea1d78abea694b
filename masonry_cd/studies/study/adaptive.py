# SPDX-License-Identifier: GPL-3.0-or-later
"""Stripes of which only the telling runs are made: batch by batch, at the levels from which most is learnt about the fragility.

A batch follows from the finished runs of those before it alone, never from the order in which they end, so the runs are the same for any
number of workers. Motions take turns, in an order that the seed shuffles: each run takes the motion that was run least so far, of those
that were not run at its level. A run that failed teaches nothing, and is not repeated.
"""

from __future__ import annotations

import random

import numpy as np

from masonry_cd.analysis.fragility.sequential import Grid
from masonry_cd.foundation.errors import InputError
from masonry_cd.studies.study.designs import DesignedRun, Space
from masonry_cd.studies.study.study_file import AdaptiveTable

Pair = tuple[str, float]  # of a motion and a level


class AdaptiveStripes:
    """The batches of a study.

    Raises:
        InputError: lists vary, each value of which would have a fragility of its own.
    """

    def __init__(self, space: Space, table: AdaptiveTable) -> None:
        for key in space.varied.lists:
            raise InputError(f'vary."{key}"', "[adaptive] takes distributions; a list has a fragility for each of its values")
        self.space, self.table = space, table
        self.motions = list(space.motions)
        random.Random(space.tables.seed).shuffle(self.motions)
        self.levels = np.array([level for level in space.levels if level is not None])
        self.grid = Grid.over(self.levels)
        self.known: dict[Pair, bool | None] = {}  # whether a run exceeded the limit state; None of one that has no result
        self.waiting: set[Pair] = set()

    def first(self) -> list[DesignedRun]:
        """The first batch."""
        return self._batch()

    def after(self, asked: DesignedRun, exceeded: bool | None) -> list[DesignedRun]:
        """The next batch, once all runs of the last one have ended."""
        assert asked.level is not None
        pair = (asked.motion, asked.level)
        self.known[pair] = exceeded
        self.waiting.discard(pair)
        return [] if self.waiting or self.ended else self._batch()

    @property
    def spread(self) -> tuple[float, float]:
        """The standard deviations of ln theta and of ln beta by the runs so far."""
        return self.grid.spread(self._posterior())

    @property
    def ended(self) -> bool:
        """Return True if the fragility is known well enough, or as many runs are made as there may be."""
        return len(self.known) >= self._most or self._enough

    @property
    def line(self) -> str:
        """How well the fragility is known, as text."""
        theta, beta = (f"{100.0 * each:.1f} %" for each in self.spread)
        short = "" if self._enough else f", and {100.0 * self.table.theta:g} % and {100.0 * self.table.beta:g} % are wanted"
        all_runs = len(self.motions) * len(self.levels)
        return f"{self.table.limit_state}: {len(self.known)} of {all_runs} runs know its median to {theta} and its beta to {beta}{short}"

    @property
    def _enough(self) -> bool:
        theta, beta = self.spread
        return theta <= self.table.theta and beta <= self.table.beta

    @property
    def _most(self) -> int:
        return min(self.table.runs or len(self.motions) * len(self.levels), len(self.motions) * len(self.levels))

    def _posterior(self) -> np.ndarray:
        """(G,) weights of the grid."""
        exceeded, runs = np.zeros(len(self.levels)), np.zeros(len(self.levels))
        for (_, level), over in self.known.items():
            if over is not None:
                place = int(np.argmax(self.levels == level))
                runs[place] += 1
                exceeded[place] += over
        return self.grid.posterior(exceeded, runs)

    def _batch(self) -> list[DesignedRun]:
        """The runs from which most is learnt, with their motions."""
        made = set(self.known)
        free = np.array([sum((motion, level) not in made for motion in self.motions) for level in self.levels.tolist()])
        count = min(self.table.batch, self._most - len(made))
        for place in self.grid.most_telling(self._posterior(), free, count):
            level = float(self.levels[place])
            turns = {motion: sum(one == motion for one, _ in made) for motion in self.motions if (motion, level) not in made}
            made.add((min(turns, key=turns.__getitem__), level))
        self.waiting = made - set(self.known)
        return [DesignedRun(motion, level, values=self.space.draw(motion, level)) for motion, level in sorted(self.waiting)]
