# SPDX-License-Identifier: GPL-3.0-or-later
"""Sobol indices against closed forms: the Ishigami function, a sum with a choice in it, and answers of which nothing can be said."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats.qmc import Halton

from masonry_cd.analysis.assessment.indices import LARGEST_ERROR, LEAST, Unknown, indices_of

pytest.importorskip("sklearn")
THREE = [Unknown(name, "-pi to pi") for name in "abc"]
A, B = 7.0, 0.1


def ishigami(u: np.ndarray) -> np.ndarray:
    """sin x1 + A sin^2 x2 + B x3^4 sin x1 for x in (-pi, pi): Ishigami & Homma, Proc. ISUMA, 1990."""
    x = np.pi * (2.0 * u - 1.0)
    return np.sin(x[:, 0]) + A * np.sin(x[:, 1]) ** 2 + B * x[:, 2] ** 4 * np.sin(x[:, 0])


def of_ishigami(runs: int):
    u = Halton(3, rng=1).random(runs)
    return indices_of(THREE, u, ishigami(u))


def test_indices_of_the_ishigami_function_are_those_of_its_closed_form() -> None:
    first = 0.5 * (1.0 + B * np.pi**4 / 5.0) ** 2
    second, together = A**2 / 8.0, B**2 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    whole = first + second + together
    exact = np.array([[first, second, 0.0], [first + together, second, together]]) / whole
    for runs, within in ((150, 0.03), (110, 0.07)):
        found = of_ishigami(runs)
        assert np.stack([found.first, found.total]) == pytest.approx(exact, abs=within)
        for values, index, (low, high) in zip((found.first, found.total), exact, (found.first_band, found.total_band), strict=True):
            assert ((low <= values) & (values <= high)).all()
            assert ((low - 0.01 <= index) & (index <= high)).all()  # 0.01: that of the samples of an index that is 0
            assert (high - low < 0.15 + found.error**2).all()


def test_a_surrogate_that_misses_runs_left_out_gives_no_indices_and_says_by_how_much() -> None:
    found = of_ishigami(60)
    assert found.error > LARGEST_ERROR
    assert np.isnan(found.first).all()
    assert f"by {100 * found.error:.0f} % of their spread" in found.refused


def test_a_choice_and_a_number_that_add_have_the_shares_of_their_variances() -> None:
    unknowns = [Unknown("bond", "", ("as given", "joints", "straight")), Unknown("friction", "0.4 to 0.8")]
    u = Halton(2, rng=2).random(40)
    steps = np.array([0.0, 3.0, 1.0])
    y = steps[np.minimum((3 * u[:, 0]).astype(int), 2)] + 4.0 * u[:, 1]
    parts = np.array([steps.var(), 16.0 / 12.0])
    found = indices_of(unknowns, u, y)
    assert found.first == pytest.approx(parts / parts.sum(), abs=0.02)
    assert found.total == pytest.approx(found.first, abs=0.02)


def test_noise_few_runs_and_an_answer_that_hardly_moves_have_no_indices() -> None:
    u = Halton(3, rng=3).random(60)
    assert "misses runs left out" in indices_of(THREE, u, np.random.default_rng(1).normal(size=60)).refused
    y = np.where(np.arange(60) < LEAST * 3 - 1, ishigami(u), np.nan)
    assert indices_of(THREE, u, y).refused == "8 runs are data, and 9 are wanted"
    assert indices_of(THREE, u, 1.0 + 1e-3 * u[:, 0], felt=0.05).refused == "it hardly moves"
