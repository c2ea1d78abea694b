# SPDX-License-Identifier: GPL-3.0-or-later
"""The choice of the next intensity: against entropies by enumeration, and on samples of a fragility that is known."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy.special import entr, ndtr

from masonry_cd.analysis.fragility.fragility import fit_counts
from masonry_cd.analysis.fragility.sequential import Grid

LEVELS = np.arange(1.0, 11.0)
THETA, BETA = 2.5, 0.3
MOTIONS, RUNS = 40, 80


def gain(grid: Grid, weights: np.ndarray, levels: list[int]) -> float:
    """The fall of the entropy of the posterior that runs at some levels are expected to bring, over all their outcomes."""
    left = 0.0
    for outcome in product((True, False), repeat=len(levels)):
        joint = weights.copy()
        for level, over in zip(levels, outcome, strict=True):
            joint = joint * (grid.chance[:, level] if over else 1.0 - grid.chance[:, level])
        left += joint.sum() * entr(joint / joint.sum()).sum()
    return float(entr(weights).sum() - left)


def test_each_level_is_the_one_from_which_most_is_learnt_by_enumeration() -> None:
    grid = Grid.over(LEVELS)
    weights = grid.posterior(np.array([0, 1, 3, 0, 0, 0, 0, 0, 0, 0]), np.array([0, 4, 4, 0, 0, 0, 0, 0, 0, 0]))
    chosen = grid.most_telling(weights, np.full(len(LEVELS), MOTIONS), 3)
    for k, level in enumerate(chosen):
        gains = [gain(grid, weights, [*chosen[:k], other]) for other in range(len(LEVELS))]
        assert gains[level] == pytest.approx(max(gains), rel=1e-3)


def test_a_level_whose_runs_are_all_made_is_not_chosen() -> None:
    grid = Grid.over(LEVELS)
    weights = grid.posterior(np.zeros(10), np.zeros(10))
    best = grid.most_telling(weights, np.full(10, MOTIONS), 1)[0]
    free = np.where(np.arange(10) == best, 0, 1)
    assert sorted(grid.most_telling(weights, free, 12)) == [k for k in range(10) if k != best]


def test_the_posterior_of_many_runs_has_the_deviations_of_the_maximum_likelihood() -> None:
    grid, runs = Grid.over(LEVELS), np.full(10, 80.0)
    z = np.log(LEVELS / 4.0) / 0.5
    p, slope = ndtr(z), np.exp(-0.5 * z**2) / np.sqrt(2.0 * np.pi)
    weight = runs * slope**2 / (p * (1.0 - p))  # Fisher's information of ln theta and ln beta
    rows = np.stack([-np.full(10, 1.0 / 0.5), -z])
    deviations = np.sqrt(np.diag(np.linalg.inv(rows * weight @ rows.T)))
    assert grid.spread(grid.posterior(runs * p, runs)) == pytest.approx(deviations, rel=0.08)


def test_a_known_fragility_is_found_from_fewer_runs_than_whole_stripes_take() -> None:
    grid, chance = Grid.over(LEVELS), ndtr(np.log(LEVELS / THETA) / BETA)
    misses: dict[str, list[float]] = {"adaptive": [], "stripes": []}
    for seed in range(40):
        rng = np.random.default_rng(seed)
        over = rng.random((10, MOTIONS)) < chance[:, None]
        runs = np.zeros(10, dtype=int)
        while runs.sum() < RUNS:
            exceeded = np.array([over[k, :n].sum() for k, n in enumerate(runs)])
            for level in grid.most_telling(grid.posterior(exceeded, runs), MOTIONS - runs, 8):
                runs[level] += 1
        each = RUNS // len(LEVELS)
        for name, made in (("adaptive", runs), ("stripes", np.full(10, each))):
            counted = np.array([over[k, :n].sum() for k, n in enumerate(made)], dtype=float)
            misses[name].append(float(np.log(fit_counts(LEVELS, counted[None], made[None].astype(float)).theta[0] / THETA)))
    error = {name: float(np.sqrt(np.mean(np.square(values)))) for name, values in misses.items()}
    assert error["adaptive"] < 0.08
    assert error["adaptive"] < 0.75 * error["stripes"]  # which stripes reach with 1.8 times as many runs
    assert abs(np.mean(misses["adaptive"])) < 0.03
