# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of a structure with all other blocks held: interlock by the clause, rigid bodies by hand, the free least mechanism below them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from limit_loads import joined, push_loads
from models import GRAVITY, box, ground

from masonry_cd.analysis.limit import macro
from masonry_cd.analysis.limit.found import ASSOCIATED, FREE, SEARCH
from masonry_cd.analysis.limit.macro import Effort, analyse_element
from masonry_cd.analysis.limit.part import INTERLOCK, Whole, part_of, resting
from masonry_cd.analysis.limit.problem import Bars, limit_problem
from masonry_cd.analysis.limit.programme import largest
from masonry_cd.analysis.limit.rigid_groups import rigid_groups
from masonry_cd.mechanics.model.blocks import Block
from structures.macro_elements.element import IN_PLANE, OVERTURNING, PIERS, VERTICAL_BENDING, MacroElement

MU, HIGH = 0.6, 0.5  # friction; height of a course [m]
EFFORT = Effort(2, 10_000)


def whole_of(blocks: list[Block], bars: Bars | None = None) -> Whole:
    """A structure whose parts are looked at; group "floor" rests on walls."""
    assembly, joints = joined(blocks, MU)
    return Whole(assembly, joints, push_loads(assembly).dead, bars or Bars.none(), GRAVITY, lambda group: group == "floor")


def stack(name: str, courses: int, x: float = 0.0, y: float = -1.0, width: float = 0.5, length: float = 2.0) -> list[Block]:
    """Courses on one another, ``name.1`` and so on."""
    low = [(x, y, HIGH * k) for k in range(courses)]
    return [box(f"{name}.{k + 1}", at, (x + width, y + length, at[2] + HIGH)) for k, at in enumerate(low)]


def element(whole: Whole, *names: str, mechanisms: tuple[str, ...] = (OVERTURNING,), **more) -> MacroElement:
    """A part by the first word of its blocks' names."""
    own = np.array([b for b, name in enumerate(whole.assembly.names) if name.split(".")[0] in names])
    return MacroElement(" ".join(names), "wall", own, ((1.0, 0.0, 0.0),), mechanisms, **more)


def toothed() -> list[Block]:
    """A facade of six courses of 0.5 m, every second one bonded with a cross wall behind it, whose stones reach 0.4 m in."""
    blocks = [ground(8.0)]
    for k in range(6):
        low, high = HIGH * k, HIGH * (k + 1)
        if k % 2:
            blocks += [box(f"facade.{k}a", (0.0, -1.5, low), (0.5, -0.3, high)), box(f"facade.{k}b", (0.0, 0.3, low), (0.5, 1.5, high))]
            blocks += [box(f"facade.{k}c", (0.4, -0.3, low), (0.5, 0.3, high))]
            blocks += [box(f"cross.{k}", (-2.0, -0.3, low), (0.4, 0.3, high))]
        else:
            blocks += [box(f"facade.{k}", (0.0, -1.5, low), (0.5, 1.5, high)), box(f"cross.{k}", (-2.0, -0.3, low), (0.0, 0.3, high))]
    return blocks


def test_the_friction_of_interlock_is_that_of_the_clause_over_every_second_bed() -> None:
    """F = 0.4 n (n + 1) phi mu l^2 t_s w is the sum of 0.8 mu (i h_b) l t_s w; here the cross wall rests in beds 1, 3 and 5 from below."""
    whole = whole_of(toothed())
    facade = element(whole, "facade")
    part = part_of(whole, resting(whole, facade.blocks), np.array([1.0, 0.0, 0.0]))
    weight, over, wide = 2000.0 * GRAVITY, 0.4, 0.6
    by_hand = sum(INTERLOCK * MU * weight * over * wide * HIGH * courses for courses in (5, 3, 1))
    assert part.interlock == pytest.approx(by_hand, rel=1e-9)
    n, phi = 6, HIGH / over
    clause = 0.4 * n * (n + 1) * phi * MU * over**2 * wide * weight
    every = sum(INTERLOCK * MU * weight * over * wide * HIGH * courses for courses in range(1, n + 1))
    assert clause == pytest.approx(every, rel=1e-9)


def test_interlock_raises_the_factor_by_its_work() -> None:
    """About the foot: W b/2 + sum F_k z_k = alpha W h/2, the friction 0.8 mu N in the beds on which the cross wall rests."""
    whole = whole_of(toothed())
    facade = element(whole, "facade")
    found = analyse_element(whole, facade, (1.0, 0.0, 0.0), Effort(0, 0))
    simple = next(one for one in found.mechanisms if one.name == "simple overturning")
    own = whole.assembly.mass[facade.blocks]
    centre = whole.assembly.centre[facade.blocks]
    friction = [INTERLOCK * MU * 2000.0 * GRAVITY * 0.4 * 0.6 * HIGH * courses for courses in (5, 3, 1)]
    work = GRAVITY * np.sum(own * (0.5 - centre[:, 0])) + np.dot(friction, HIGH * np.array([1, 3, 5]))
    assert simple.oscillator.alpha == pytest.approx(work / (GRAVITY * np.sum(own * centre[:, 2])), rel=1e-3)
    bare = [block for block in toothed() if not block.name.startswith("cross")]
    alone = analyse_element(whole_of(bare), element(whole_of(bare), "facade"), (1.0, 0.0, 0.0), Effort(0, 0)).mechanisms[0]
    assert alone.oscillator.alpha < 0.9 * simple.oscillator.alpha


def turned(blocks: list[Block], degrees: float) -> list[Block]:
    """Blocks turned about the upright axis."""
    a = np.radians(degrees)
    turn = np.array([[np.cos(a), -np.sin(a), 0.0], [np.sin(a), np.cos(a), 0.0], [0.0, 0.0, 1.0]])
    return [replace(block, vertices=block.vertices @ turn.T) for block in blocks]


@pytest.mark.parametrize("degrees", [30.0, 45.0, 118.0])
def test_an_oblique_wall_bears_what_one_along_an_axis_does(degrees: float) -> None:
    """The friction of interlock is that of the weight above a bed and of nothing compared with it, and so are the factors."""
    a, found = np.radians(degrees), []
    for blocks, way in ((toothed(), (1.0, 0.0, 0.0)), (turned(toothed(), degrees), (np.cos(a), np.sin(a), 0.0))):
        whole = whole_of(blocks)
        found.append(analyse_element(whole, replace(element(whole, "facade"), directions=(way,)), way, Effort(0, 0)))
    one, other = found
    assert other.interlock == pytest.approx(one.interlock, rel=1e-6)
    assert sorted(made.name for made in other.mechanisms) == sorted(made.name for made in one.mechanisms)
    factors = [sorted(made.oscillator.alpha for made in each.mechanisms) for each in found]
    assert factors[1] == pytest.approx(factors[0], rel=1e-3)


def test_rigid_bodies_start_at_no_less_than_their_blocks() -> None:
    assembly, joints = joined([ground(4.0), *stack("w", 4)], MU)
    problem = limit_problem(assembly, joints, push_loads(assembly, (1.0, 0.3, 0.0)))
    free = largest(problem, problem.dead, problem.live, 10.0)
    two = rigid_groups(problem, assembly, [np.array([1, 2]), np.array([3, 4])])
    bodies = largest(two.problem, two.problem.dead, two.problem.live, 10.0)
    assert two.problem.unknowns == 12 and problem.unknowns == 24
    assert bodies.factor >= free.factor - 1e-6
    velocity = two.of_blocks(bodies.velocity)
    assert float(problem.live @ velocity) == pytest.approx(float(two.problem.live @ bodies.velocity), rel=1e-9)
    spun = problem.block_velocity(velocity, assembly.count)
    assert np.abs(spun[1, 3:] - spun[2, 3:]).max() <= 1e-9 * np.abs(spun).max()


def test_a_wall_alone_overturns_at_its_slenderness_and_no_free_mechanism_starts_sooner() -> None:
    whole = whole_of([ground(4.0), *stack("w", 6)])
    found = analyse_element(whole, element(whole, "w"), (1.0, 0.0, 0.0), EFFORT)
    assert [one.oscillator.alpha for one in found.mechanisms] == pytest.approx([0.5 / 3.0] * len(found.mechanisms), rel=1e-4)
    assert {one.name for one in found.mechanisms if not one.name.startswith(FREE)} == {"simple overturning"}
    assert found.numbers.has_agreement


def test_a_mechanism_of_a_part_whose_solver_ended_early_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(macro, "largest", lambda *given: replace(largest(*given), stopped="MaxIterations"))
    whole = whole_of([ground(8.0), *stack("wall", 2)])
    sources = {one.source for one in analyse_element(whole, element(whole, "wall"), (1.0, 0.0, 0.0), EFFORT).mechanisms}
    assert sources == {SEARCH, f"{ASSOCIATED}, the solver stopped before it met its tolerance"}


def test_a_wall_held_by_ties_at_its_top_bends_between() -> None:
    """Two bodies, foot and top held: the least over the heights of hinges tried, above that of the wall alone."""
    wall = [ground(8.0), box("back", (-3.0, -1.0, 0.0), (-1.0, 1.0, 3.0)), *stack("w", 6)]
    names = [block.name for block in wall]
    ends = np.array(2 * [[names.index("w.6"), names.index("back")]])
    tie = Bars(ends, np.array([[[0.25, y, 2.9], [-1.5, y, 2.9]] for y in (-0.8, 0.8)]), np.array([np.inf, np.inf]))
    whole = whole_of(wall, tie)
    found = analyse_element(whole, element(whole, "w", mechanisms=(OVERTURNING, VERTICAL_BENDING)), (1.0, 0.0, 0.0), EFFORT)
    bends = [one for one in found.mechanisms if one.name == VERTICAL_BENDING]
    assert bends and all(one.oscillator.alpha > 2.0 * 0.5 / 3.0 for one in bends)
    assert not any(one.name == "simple overturning" for one in found.mechanisms)  # the tie never yields


def test_a_floor_that_spans_between_walls_loads_and_shakes_the_part_by_its_share() -> None:
    floor = Block("floor", *_plate((0.0, -1.0, 3.0), (4.5, 1.0, 3.2)), 2000.0, "floor")
    walls = [ground(8.0), *stack("near", 6, 0.0), *stack("far", 6, 4.0), floor]
    whole = whole_of(walls)
    near = element(whole, "near")
    part = part_of(whole, resting(whole, near.blocks), np.array([-1.0, 0.0, 0.0]))
    share = 0.5 * 2000.0 * GRAVITY * 4.5 * 2.0 * 0.2
    held = float(part.problem.live.reshape(-1, part.problem.columns.size)[:, 0].sum()) * part.problem.weight
    assert held == pytest.approx(-(2000.0 * GRAVITY * 3.0 * 0.5 * 2.0 + share), rel=1e-9)


def _plate(low: tuple[float, float, float], high: tuple[float, float, float]):
    made = box("plate", low, high)
    return made.vertices, made.faces


def test_piers_rock_in_parallel_under_what_they_carry() -> None:
    """Two piers of 0.5 by 1.5 m under a beam: (W_p/2 + W_b) b = alpha (W_p h/2 + W_b h) for both together."""
    blocks = [ground(8.0), *stack("p1", 3, 0.0), *stack("p2", 3, 2.0), box("beam.1", (0.0, -1.0, 1.5), (2.5, 1.0, 2.0))]
    whole = whole_of(blocks)
    piers = tuple(np.array([b for b, name in enumerate(whole.assembly.names) if name.startswith(which)]) for which in ("p1", "p2"))
    found = analyse_element(whole, element(whole, "p1", "p2", "beam", mechanisms=(PIERS,), piers=piers), (1.0, 0.0, 0.0), Effort(0, 0))
    pier, beam = 2 * 2000.0 * 0.5 * 2.0 * 1.5, 2000.0 * 2.5 * 2.0 * 0.5
    by_hand = (0.5 * pier * 0.5 + beam * 0.5) / (0.5 * pier * 1.5 + beam * 1.5)
    assert found.mechanisms[0].name == PIERS
    assert found.mechanisms[0].oscillator.alpha == pytest.approx(by_hand, rel=1e-3)


def test_what_is_held_on_all_sides_has_no_mechanism() -> None:
    blocks = [ground(8.0), *stack("w", 2), box("stop", (0.5, -1.0, 0.0), (1.5, 1.0, 3.0))]
    whole = whole_of(blocks)
    found = analyse_element(whole, element(whole, "w", mechanisms=(OVERTURNING, IN_PLANE)), (1.0, 0.0, 0.0), EFFORT)
    assert not found.mechanisms


def test_one_joint_hinges() -> None:
    whole = whole_of([ground(8.0), *stack("one", 1, width=0.2)])
    found = analyse_element(whole, element(whole, "one"), (1.0, 0.0, 0.0), EFFORT)
    assert {one.name for one in found.mechanisms if one.name.startswith(FREE)} == {f"{FREE}: 1 joint hinges"}
