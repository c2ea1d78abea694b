# SPDX-License-Identifier: GPL-3.0-or-later
"""Weights over samples against posteriors in closed form; what follows from them; likelihoods."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from scipy.stats import chi2, ks_2samp, norm

from masonry_cd.analysis.calibration.motion_map import motion_map
from masonry_cd.analysis.calibration.observations import Observation
from masonry_cd.analysis.calibration.posterior import Posterior, correlation
from masonry_cd.analysis.calibration.weights import Proposal, log_prior, log_ratio, next_proposal, weights
from masonry_cd.analysis.distributions import by_chance, distance, effective, quantiles

A = np.array([[1.0, 0.5, 0.0], [0.0, 1.0, -0.7], [0.3, 0.0, 1.0], [0.5, 0.5, 0.5]])  # of y = A z, observed with these errors
S = np.array([0.1, 0.05, 0.2, 0.1])
Y = np.array([0.8, -1.1, 0.4, 0.3])


def sampled(rounds: int, count: int = 300, seed: int = 0) -> tuple[np.ndarray, np.ndarray, list[float]]:
    """Samples of the linear problem, their weights, and the effective number after each round."""
    proposals, z, sizes = [Proposal.prior(3)], np.zeros((0, 3)), []
    for t in range(rounds):
        z = np.concatenate([z, proposals[-1].draw(count, (seed, t))])
        likelihood = -0.5 * np.sum(((Y - z @ A.T) / S) ** 2, axis=1)
        ratio = log_ratio(z, proposals, [count] * len(proposals))
        w = weights(ratio + likelihood)
        sizes.append(effective(w))
        proposals.append(next_proposal(z, ratio, likelihood))
    return z, w, sizes


def test_a_linear_problem_with_normal_errors_has_the_posterior_of_its_closed_form() -> None:
    precision = np.eye(3) + A.T @ np.diag(S**-2) @ A
    covariance = np.linalg.inv(precision)
    mean = covariance @ A.T @ (Y / S**2)
    z, w, sizes = sampled(rounds=5)
    found = w @ z
    away = z - found
    std = np.sqrt(np.diag(covariance))
    assert sizes[0] < 10.0 < 200.0 < sizes[-1]  # the prior alone hardly meets it, the proposals that follow do
    assert np.abs((found - mean) / std).max() < 4.0 / np.sqrt(sizes[-1])
    assert np.abs((w[:, None] * away).T @ away - covariance).max() / std.max() ** 2 < 6.0 / np.sqrt(sizes[-1])


def test_equal_seeds_have_equal_bits_and_others_have_not() -> None:
    first, again, other = (sampled(rounds=2, count=40, seed=seed) for seed in (0, 0, 1))
    assert np.array_equal(first[0], again[0])
    assert np.array_equal(first[1], again[1])
    assert not np.array_equal(first[0], other[0])


def test_a_proposal_draws_from_its_own_density() -> None:
    z = np.array([[1.0, 2.0], [1.5, 1.0], [-2.0, 0.5], [0.0, 0.0]])
    proposal = next_proposal(z, np.zeros(4), np.array([0.0, -0.5, -0.2, -1.0]))
    drawn = proposal.draw(4000, (3, 1))
    ratio = np.exp(log_prior(drawn) - proposal.log_density(drawn))  # of which the mean is the integral of the prior
    assert ratio.mean() == pytest.approx(1.0, abs=4.0 * ratio.std() / np.sqrt(4000))
    assert ratio.max() < 10.0  # the share of the prior bounds it


def test_without_enough_possible_samples_the_next_proposal_is_the_prior() -> None:
    z = np.zeros((5, 2))
    likelihood = np.array([0.0, 0.0, -np.inf, -np.inf, -np.inf])
    assert next_proposal(z, np.zeros(5), likelihood).factor is None
    assert not weights(np.full(5, -np.inf)).any()
    assert effective(np.zeros(5)) == 0.0


def test_a_range_of_90_percent_has_the_next_draw_in_90_percent_of_cases_however_few_the_samples() -> None:
    draw = np.random.default_rng(3)
    for weight, within in ((np.ones(39), 0.003), (np.arange(1.0, 40.0), 0.015)):
        w = weight / weight.sum()
        ends = np.array([quantiles(one, w) for one in draw.normal(size=(4000, 39))])
        assert np.diff(norm.cdf(ends[:, [0, 2]])).mean() == pytest.approx(0.9, abs=within)
    values = draw.normal(size=39)
    assert quantiles(values, np.full(39, 1 / 39)) == pytest.approx(np.quantile(values, [0.05, 0.5, 0.95], method="weibull"))
    assert quantiles(np.arange(5.0), np.array([0.0, 0.0, 0.5, 0.5, 0.0])) == [2.0, 2.5, 3.0]
    assert quantiles(-values, w) == pytest.approx([-q for q in quantiles(values, w)[::-1]])


def test_weighted_correlations_are_those_of_repeated_samples() -> None:
    rows = np.array([[3.0, 1.0, 2.0, 5.0], [0.5, 2.0, -1.0, 4.0]])
    times = np.array([10, 40, 30, 20])
    repeated = np.repeat(rows, times, axis=1)
    assert correlation(rows, times / 100) == pytest.approx(np.corrcoef(repeated))


def test_the_distance_of_distributions_is_kolmogorovs_and_weights_count_as_repeated_samples() -> None:
    draw = np.random.default_rng(4)
    a, b = draw.normal(0.0, 1.0, 300), draw.normal(0.3, 1.0, 200)
    even = np.full(300, 1 / 300), np.full(200, 1 / 200)
    apart = distance(a, even[0], b, even[1])
    assert apart == pytest.approx(ks_2samp(a, b).statistic)
    assert by_chance(apart, 300, 200) == pytest.approx(ks_2samp(a, b, method="asymp").pvalue, rel=0.2)
    times = np.array([1, 2, 3, 4] * 75)
    assert distance(a, times / times.sum(), b, even[1]) == pytest.approx(ks_2samp(np.repeat(a, times), b).statistic)


def test_an_unknown_that_nothing_depends_on_is_not_learnt() -> None:
    idle = np.random.default_rng(1).normal(size=2000).tolist()
    both = made(1.0, unknowns={"x": made(1.0).unknowns["x"], "idle": idle})
    assert both.unlearnt == ["idle"]
    assert both.verdict.sure == "good"
    assert "the observations say nothing of it" in next(line for line in both.lines if line.startswith("idle"))
    alone = made(1.0, unknowns={"idle": idle})
    assert alone.verdict.words == "the observations do not tell"


def test_a_map_of_the_motion_is_the_likelihood_over_two_unknowns_whatever_the_prior() -> None:
    z = Proposal.prior(2).draw(4000, (2, 0))
    x, y = 5.0 + z[:, 0], 1.0 + 0.2 * z[:, 1]
    off = ((x * y**2 - 6.0) / 0.5) ** 2
    w = weights(-0.5 * off)
    tracemalloc.start()
    found = motion_map(("T", "a"), np.array([y, x]), w, np.full(4000, 1 / 4000))
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 8 * 81 * 81 * 4000 / 4  # bytes; a quarter of a kernel for each sample
    exact = np.exp(-0.5 * ((found.up[:, None] * found.across[None, :] ** 2 - 6.0) / 0.5) ** 2)
    dense = (np.abs(found.across - 1.0) < 0.3)[None, :] & (np.abs(found.up - 5.0) < 1.5)[:, None]
    assert np.corrcoef(found.likelihood[dense], exact[dense])[0, 1] > 0.95
    outside = found.density < found.levels[1]
    assert found.density[outside].sum() / found.density.sum() == pytest.approx(0.1, abs=0.01)
    assert found.likeliest["a"] * found.likeliest["T"] ** 2 == pytest.approx(6.0, abs=0.5)


def observation(**keys: object) -> Observation:
    table = {"what": "frequency", "mode": 1, "value": 10.0, "share": 0.1} | keys
    return Observation.model_validate({key: value for key, value in table.items() if value is not None})


def test_likelihoods_are_those_of_their_distributions() -> None:
    predicted = np.array([8.0, 10.0, 13.0])
    normal = observation().log_likelihood(predicted)
    assert np.diff(normal) == pytest.approx(np.diff(norm.logpdf(10.0, predicted, 1.0)))
    wide = observation(what="gauge", mode=None, gauge="a", column="opening", spread="lognormal", value=2e-3)
    found = wide.log_likelihood(np.array([1e-3, 2e-3, 0.0, np.nan]))
    assert found[1] - found[0] == pytest.approx(0.5 * (np.log(2.0) / 0.1) ** 2)
    assert (found[2:] == -np.inf).all()
    seen = {"what": "fallen", "mode": None, "share": None, "error": 0.1, "blocks": ["a", "b", "c"]}
    fell = observation(**seen, value=True).log_likelihood(np.array([3.0, 1.0]))  # of three blocks as many have fallen
    assert np.exp(fell) == pytest.approx([0.9**3, 0.9 * 0.1**2])
    stood = observation(**seen, value=False).log_likelihood(np.array([3.0, 1.0]))
    assert np.exp(stood) == pytest.approx([0.1**3, 0.1 * 0.9**2])


def made(value: float, **keys: object) -> Posterior:
    """A posterior of one unknown x = z over a normal prior, of which 2 x was observed as a frequency; 3 x is not observed yet."""
    z = Proposal.prior(1).draw(2000, (1, 0))
    observed = (observation(value=value, share=None, error=0.5), observation(value=None, mode=2, share=None, error=0.1))
    predicted = np.stack([2.0 * z[:, 0], 3.0 * z[:, 0]], axis=1)
    w, even = weights(observed[0].log_likelihood(predicted[:, 0])), np.full(2000, 1 / 2000)
    given = {"title": "t", "scene": "s", "program": "p", "unknowns": {"x": z[:, 0].tolist()}, "units": {}, "enough": 30.0}
    sizes = {"rounds": np.ones(2000, dtype=int), "sizes": (effective(w),), "weights": w, "prior": even}
    return Posterior(**(given | sizes | {"observations": observed, "predicted": predicted} | keys))  # type: ignore[arg-type]


def test_ranges_predictions_and_gains_are_those_of_one_linear_unknown() -> None:
    found = made(1.0)
    precision = 1.0 + (2.0 / 0.5) ** 2
    mean, std = 2.0 * 1.0 / 0.25 / precision, precision**-0.5
    one = found.ranges["x"]
    assert [one["low"], one["median"], one["high"]] == pytest.approx([mean - 1.645 * std, mean, mean + 1.645 * std], abs=0.15 * std)
    assert [one["prior_low"], one["prior_high"]] == pytest.approx([-1.645, 1.645], abs=0.01)
    again, new = found.checks
    assert again["off"] == pytest.approx((1.0 - 2.0 * mean) / np.hypot(0.5, 2.0 * std), abs=0.02)
    assert again["gain"] == pytest.approx((2 * std) ** 2 / ((2 * std) ** 2 + 0.25), abs=0.02)  # of one unknown r is 1
    assert new["gain"] == pytest.approx((3 * std) ** 2 / ((3 * std) ** 2 + 0.01), abs=0.02)
    assert "helps most: frequency mode 2, which is not measured yet" in found.lines[-1]


def test_a_misfit_has_the_probability_of_chi_squared_over_the_posterior() -> None:
    z = np.linspace(-8.0, 8.0, 20001)
    density = norm.pdf(z) * norm.pdf(1.0, 2.0 * z, 0.5)
    exact = np.sum(density * chi2.sf(((1.0 - 2.0 * z) / 0.5) ** 2, 1)) / density.sum()
    assert made(1.0).misfit == pytest.approx(exact, abs=0.02)
    assert made(1.0).verdict.sure == "good"
    beyond = made(9.0, enough=1.0)  # no x within the prior gives it
    assert beyond.misfit is not None
    assert beyond.misfit < 0.05
    assert "does not explain" in beyond.verdict.words


def test_too_few_effective_samples_are_no_answer() -> None:
    found = made(1.0, enough=1e4)
    assert found.refused
    assert found.verdict.words == "refused"
    assert len(found.lines) == 2  # no range is said
