# SPDX-License-Identifier: GPL-3.0-or-later
"""Pulses found again from what they left of blocks that slide and fall by formulas: how many are answered, and are in their range."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ndtr

from masonry_cd.analysis.calibration.observations import Observation
from masonry_cd.analysis.calibration.weights import Proposal, log_ratio, next_proposal, weights
from masonry_cd.analysis.distributions import effective, quantiles

COUNT, ROUNDS, WANTED, LEAST, PULSES = 100, 8, 30.0, 15.0, 150  # as in examples/attribute_columns.toml
ERROR, WRONG = 0.015, 0.05  # [m], and of what was seen


def left(z: np.ndarray) -> np.ndarray:
    """(N, 5) of pulses (N, 3): a stele fallen, a column fallen, the slip of a base along x and y, and that of a drum [m]."""
    a, period, angle = 0.5 * np.exp(0.4 * z[:, 0]), 0.6 * np.exp(0.4 * z[:, 1]), np.pi * (ndtr(z[:, 2]) - 0.5)
    slip = [0.8 * np.maximum(a - friction, 0.0) * period**2 for friction in (0.3, 0.5)]
    return np.column_stack([a * period > 0.3, a * period**2 > 0.6, slip[0] * np.cos(angle), slip[0] * np.sin(angle), slip[1]])


def observed(z: np.ndarray, draw: np.random.Generator) -> list[Observation]:
    """The traces of a pulse (3,), with errors."""
    fell, down, *slips = left(z[None])[0]
    seen = [bool(value) != bool(draw.random() < WRONG) for value in (fell, down)]
    tables = [{"what": "fallen", "name": str(k), "blocks": ["a"], "value": value, "error": WRONG} for k, value in enumerate(seen)]
    made = [float(value + ERROR * draw.standard_normal()) for value in slips]
    tables += [{"what": "gauge", "gauge": str(k), "column": "ux", "value": value, "error": ERROR} for k, value in enumerate(made)]
    return [Observation.model_validate(table) for table in tables]


def calibrated(of: list[Observation], seed: int) -> tuple[np.ndarray, np.ndarray, int]:
    """Samples, their weights, and the number of rounds."""
    proposals, z = [Proposal.prior(3)], np.zeros((0, 3))
    while True:
        z = np.concatenate([z, proposals[-1].draw(COUNT, (seed, len(proposals)))])
        ratio = log_ratio(z, proposals, [COUNT] * len(proposals))
        likelihood = np.sum([one.log_likelihood(values) for one, values in zip(of, left(z).T, strict=True)], axis=0)
        w = weights(ratio + likelihood)
        if effective(w) >= WANTED or len(proposals) == ROUNDS:
            return z, w, len(proposals)
        proposals.append(next_proposal(z, ratio, likelihood))


def test_strong_pulses_are_answered_in_rounds_and_their_ranges_hold_nine_of_ten() -> None:
    draw = np.random.default_rng(1)
    inside, rounds, answered = np.zeros(3), [], 0
    for seed in range(PULSES):
        true = draw.standard_normal(3)
        z, w, count = calibrated(observed(true, draw), seed)
        rounds.append(count)
        if effective(w) >= LEAST:
            answered += 1
            ends = np.array([quantiles(values, w) for values in z.T])
            inside += (ends[:, 0] <= true) & (true <= ends[:, 2])
    assert np.mean(np.array(rounds) > 1) > 0.2  # a single round does not answer these
    assert answered >= 0.99 * PULSES
    assert inside / answered == pytest.approx(0.9, abs=3.0 * np.sqrt(0.09 / answered))
    assert inside.mean() / answered == pytest.approx(0.9, abs=0.03)
