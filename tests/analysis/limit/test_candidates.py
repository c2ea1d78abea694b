# SPDX-License-Identifier: GPL-3.0-or-later
"""The mechanisms that a check looks at: what ties add to each, which dilate or spread, and the least a0* of a fixed set of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from limit_loads import everything, joined, push_loads
from models import GRAVITY, box, ground

from masonry_cd.analysis.limit.analysis import Analysis, LimitOptions, analyse
from masonry_cd.analysis.limit.candidates import (
    UNTIED,
    candidates,
    tied_factor,
    with_untied,
)
from masonry_cd.analysis.limit.found import ASSOCIATED, SEARCH, FoundMechanism, dilation
from masonry_cd.analysis.limit.mechanism import mechanism
from masonry_cd.analysis.limit.oscillator import Oscillator, oscillator
from masonry_cd.analysis.limit.problem import Bars, limit_problem
from masonry_cd.mechanics.model.blocks import Assembly, Block


def found_of(blocks: list[Block], friction: float, bars: Bars | None = None) -> tuple[Analysis, list[FoundMechanism], list[Oscillator]]:
    """An analysis under a push along x, the mechanisms looked at, and their oscillators."""
    assembly, joints = joined(blocks, friction)
    loads, options = replace(push_loads(assembly), bars=bars or Bars.none()), LimitOptions(starts=2)
    analysis = analyse(assembly, joints, loads, options)
    analysis, untied, _ = with_untied(analysis, assembly, joints, options)
    looked = candidates(analysis, untied, everything(assembly, joints, analysis, loads))
    return analysis, looked, [one.oscillator for one in looked]


def pillar() -> list[Block]:
    """0.5 m wide and 1.5 m high, in the middle of its plate."""
    return [ground(2.0), box("a", (0.0, -0.2, 0.0), (0.5, 0.2, 1.5))]


def rod(strength: float) -> Bars:
    """From half-way up the pillar straight back to the ground."""
    return Bars(np.array([[1, 0]]), np.array([[[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]]]), np.array([strength]))


def test_a_mechanism_found_without_its_tie_has_the_work_of_the_tie_in_its_factor() -> None:
    """About the edge at x = 0.5: W b/2 + N lever = alpha W h/2; the rod's lever is 1.5 sin 45."""
    _, looked, made = found_of(pillar(), 0.65, rod(500.0))
    by_hand = (2000.0 * GRAVITY * 0.3 * 0.25 + 500.0 * np.sqrt(0.5) * 1.5) / (2000.0 * GRAVITY * 0.3 * 0.75)
    assert {one.source for one in looked} == {SEARCH, ASSOCIATED, SEARCH + UNTIED, ASSOCIATED + UNTIED}
    assert [one.oscillator.alpha for one in looked] == pytest.approx([by_hand] * len(looked), rel=1e-6)
    assert [one.fraction for one in made] == pytest.approx([1.0] * len(made), rel=1e-6)


def test_without_the_ties_that_hold_it_up_a_structure_has_no_mechanism_and_a_remark_says_so() -> None:
    """A beam that its rod holds: on its edge alone it falls."""
    beam = [ground(2.0), box("a", (0.0, -0.2, 0.0), (0.5, 0.2, 0.5)), box("beam", (0.2, -0.2, 0.5), (2.2, 0.2, 0.8))]
    assembly, joints = joined(beam, 0.65)
    rod = Bars(np.array([[2, 0]]), np.array([[[0.3, 0.0, 0.7], [0.3, 0.0, -0.2]]]), np.array([1e5]))
    loads = replace(push_loads(assembly), bars=rod)
    analysis = analyse(assembly, joints, loads, LimitOptions(starts=1))
    assert analysis.stands
    kept, untied, why = with_untied(analysis, assembly, joints, LimitOptions(starts=1))
    assert kept is analysis and not untied and "without its ties" in why


def test_in_space_a_tie_that_a_mechanism_stretches_pulls_in_the_search() -> None:
    """The pillar next to a block that makes it no structure in a plane; its rod bears as by hand."""
    aside = box("aside", (3.0, 0.5, 0.0), (4.0, 1.5, 0.3))
    analysis, _, _ = found_of([ground(5.0), *pillar()[1:], aside], 0.65, rod(500.0))
    by_hand = (2000.0 * GRAVITY * 0.3 * 0.25 + 500.0 * np.sqrt(0.5) * 1.5) / (2000.0 * GRAVITY * 0.3 * 0.75)
    assert analysis.problem.axis is None and analysis.least is not None
    assert analysis.least.optimum.factor == pytest.approx(by_hand, rel=1e-4)


def test_what_a_tie_that_does_not_yield_holds_never_starts() -> None:
    lower = box("b", (1.0, -0.2, 0.0), (1.5, 0.2, 1.2))  # leans at 0.5 / 1.2, the other one at 0.5 / 1.5 and not before its rod yields
    _, looked, _ = found_of([*pillar(), lower], 0.65, rod(np.inf))
    assert [one.oscillator.alpha for one in looked] == pytest.approx([0.5 / 1.2] * len(looked), rel=1e-6)
    assert not any(one.source.endswith(UNTIED) for one in looked)


def test_a_mechanism_of_a_solver_that_ended_early_says_so() -> None:
    analysis, _, _ = found_of(pillar(), 0.65)
    early = replace(analysis.associated, optimum=replace(analysis.associated.optimum, stopped="MaxIterations"))
    assembly, joints = joined(pillar(), 0.65)
    part = everything(assembly, joints, analysis, push_loads(assembly))
    sources = [one.source for one in candidates(replace(analysis, associated=early), [], part)]
    assert sources == [SEARCH, f"{ASSOCIATED}, the solver stopped before it met its tolerance"]


def test_what_slides_dilates_as_associated_and_not_in_the_search() -> None:
    """A slab that slides and lifts by mu: gravity takes from the push all that friction would, half of the power of both."""
    _, looked, made = found_of([ground(4.0), box("slab", (0.0, -1.0, 0.0), (2.0, 1.0, 0.4))], 0.3)
    assert [one.source for one in looked] == [SEARCH, ASSOCIATED]
    assert [one.oscillator.alpha for one in looked] == pytest.approx([0.3, 0.3], rel=1e-6)
    assert [one.dilation for one in looked] == pytest.approx([0.0, 0.5], abs=1e-6)
    assert not made[0].doubt and "dilates" in made[1].doubt
    assert made[1].acceleration() == pytest.approx(0.3 * GRAVITY, rel=1e-6)


def test_what_spreads_over_many_bodies_is_no_oscillator() -> None:
    """Twelve pillars that lean one by one: the same e* = 1 by its formula; and one that leans next to a heavy one that hardly moves."""
    apart = [box(f"p{k}", (k, -0.2, 0.0), (k + 0.5, 0.2, 1.5)) for k in range(12)]
    assembly, joints = joined([ground(20.0), *apart], 0.65)
    options = LimitOptions(starts=0)
    analysis = analyse(assembly, joints, push_loads(assembly), options)
    part = everything(assembly, joints, analysis, push_loads(assembly))
    (lean,) = candidates(analysis, [], part)
    assert lean.mechanism is not None
    factor = lean.oscillator.alpha
    every = replace(lean.mechanism, velocity=np.tile([1.0, 0, 0, 0, 0, 0], (13, 1)), speed=np.r_[0.0, np.ones(12)])
    assert "12 bodies" in oscillator(part, every, factor, 0.0).doubt
    some = replace(every, speed=np.r_[0.0, np.ones(5), np.zeros(7)])
    assert not oscillator(part, some, factor, 0.0).doubt
    slow = replace(some, velocity=every.velocity * np.r_[0.0, 1.0, np.full(11, 0.01)][:, None])
    made = oscillator(part, slow, factor, 0.0)
    assert "22 % only of the weight" in made.doubt  # 1.04^2 / (5 * 1.0004)
    assert made.fraction == 1.0 and made.acceleration() == pytest.approx(factor * GRAVITY)


def wall() -> list[Block]:
    """Three stacks of two courses side by side under two lintels: blocks hinge, slide and bend in many ways."""
    blocks = [ground(6.0)]
    for k in range(3):
        for c in range(2):
            blocks.append(box(f"s{k}.{c}", (1.2 * k, -0.2, 0.8 * c), (1.2 * k + 0.5, 0.2, 0.8 * c + 0.8)))
    return [*blocks, *(box(f"l{k}", (1.2 * k + 0.25, -0.2, 1.6), (1.2 * k + 1.45, 0.2, 1.9)) for k in range(2))]


def some_bars(assembly: Assembly, count: int, seed: int) -> Bars:
    """Ties in the plane between blocks drawn at random, from centre to centre."""
    random = np.random.default_rng(seed)
    ends = np.array([random.choice(assembly.count, 2, replace=False) for _ in range(count)])
    return Bars(ends, assembly.centre[ends], random.uniform(50.0, 3000.0, count))


@pytest.mark.parametrize("seed", range(4))
def test_more_ties_never_lower_the_least_acceleration_over_a_fixed_set_of_mechanisms(seed: int) -> None:
    assembly, joints = joined(wall(), 0.5)
    bare = push_loads(assembly)
    analysis = analyse(assembly, joints, bare, LimitOptions(starts=3, seed=seed))
    assert analysis.least is not None
    optima = [analysis.associated.optimum, *analysis.least.ends]
    moves = [mechanism(analysis.problem, assembly, joints, optimum.velocity) for optimum in optima]
    bars, first, last = some_bars(assembly, 8, seed), 0.0, 0.0
    for count in range(len(bars.strength) + 1):
        some = Bars(bars.blocks[:count], bars.points[:count], bars.strength[:count])
        problem = limit_problem(assembly, joints, replace(bare, bars=some))
        part = everything(assembly, joints, analysis, replace(bare, bars=some))
        looked = [oscillator(part, moved, tied_factor(problem, optimum), 0.0) for optimum, moved in zip(optima, moves, strict=True)]
        least = min(one.acceleration() for one in looked)
        assert least >= last
        first, last = least if not count else first, least
    assert last > 1.05 * first


def random_wall(random: np.random.Generator) -> list[Block]:
    """Three courses of stones of random lengths."""
    blocks = [ground(8.0)]
    for course in range(3):
        cuts = np.cumsum([0.0, *random.uniform(0.5, 1.1, 4)])
        high = 0.5 * course
        for k, (low, end) in enumerate(zip(cuts[:-1] / cuts[-1] * 3.0, cuts[1:] / cuts[-1] * 3.0, strict=True)):
            blocks.append(box(f"s{course}.{k}", (low, -0.2, high), (end, 0.2, high + 0.5)))
    return blocks


def random_church(random: np.random.Generator) -> list[Block]:
    """A facade before two side walls, in three courses of random heights, with straight joints between the walls."""
    blocks, low = [ground(12.0)], 0.0
    for course in range(3):
        high = low + float(random.uniform(0.6, 1.2))
        blocks.append(box(f"facade.{course}", (4.0, -1.5, low), (4.5, 1.5, high)))
        for name, y in (("south", -1.5), ("north", 1.1)):
            blocks.append(box(f"{name}.{course}", (0.0, y, low), (4.0, y + 0.4, high)))
        low = high
    return blocks


@pytest.mark.parametrize(("make", "seed"), [(random_wall, 1), (random_wall, 2), (random_church, 3), (random_church, 4)])
def test_over_random_walls_and_churches_more_ties_never_lower_the_ratio(make, seed: int) -> None:
    """Each tie raises alpha_0 of each mechanism of a fixed set, or leaves it, and no e*: so the least a_0 never falls."""
    random = np.random.default_rng(seed)
    assembly, joints = joined(make(random), 0.5)
    bare = push_loads(assembly)
    analysis = analyse(assembly, joints, bare, LimitOptions(starts=2, seed=seed))
    assert analysis.stands and analysis.least is not None
    optima = [analysis.associated.optimum, *analysis.least.ends]
    moves = [mechanism(analysis.problem, assembly, joints, optimum.velocity) for optimum in optima]
    dilates = [dilation(analysis.problem, optimum) for optimum in optima]
    ends = np.array([random.choice(assembly.count, 2, replace=False) for _ in range(5)])
    assert analysis.problem.axis is not None or make is random_church
    strength, before = random.uniform(1e3, 2e4, 5), (0.0, [0.0] * len(optima), None)
    for count in range(6):
        bars = Bars(ends[:count], assembly.centre[ends[:count]], strength[:count])
        problem = limit_problem(assembly, joints, replace(bare, bars=bars))
        factors = [tied_factor(problem, optimum) for optimum in optima]
        made = [
            oscillator(everything(assembly, joints, analysis, bare), moved, factor, dilates[k])
            for k, (factor, moved) in enumerate(zip(factors, moves, strict=True))
        ]
        least, fractions = min(one.acceleration() for one in made), [one.fraction for one in made]
        assert least >= before[0] and all(now >= then - 1e-12 for now, then in zip(factors, before[1], strict=True))
        assert before[2] is None or fractions == before[2]
        before = least, factors, fractions
