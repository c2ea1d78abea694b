# SPDX-License-Identifier: GPL-3.0-or-later
"""The search in space: starts one by one are the starts together, it goes on until some agree, and it begins at the structure's parts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from limit_loads import joined, push_loads
from models import box, ground

from masonry_cd.analysis.limit import descent
from masonry_cd.analysis.limit.analysis import Analysis, LimitOptions, analyse, with_more_starts
from masonry_cd.analysis.limit.descent import Search
from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.analysis.limit.programme import Programme, largest
from masonry_cd.analysis.limit.search import CAP, least_factor, polished
from masonry_cd.analysis.limit.solution import merged
from masonry_cd.limit.case import limit_case
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints
from structures.files import blockfile

ALONE = 0.5 / 3.0  # factor of the slab that leans alone


def wedged(starts: int) -> tuple[Assembly, Joints, Analysis]:
    """A slab between two cheeks that it need not press; pushed out, it falls with them at 0.258 or alone at 1/6."""
    cheeks = [box("left", (0.0, -1.6, 0.0), (1.0, -1.0, 3.0)), box("right", (0.0, 1.0, 0.0), (1.0, 1.6, 3.0))]
    assembly, joints = joined([ground(8.0), box("slab", (0.0, -1.0, 0.0), (0.5, 1.0, 3.0)), *cheeks], 0.6)
    return assembly, joints, analyse(assembly, joints, push_loads(assembly, (-1.0, 0.0, 0.0)), LimitOptions(starts=starts))


def test_starts_that_are_left_out_leave_the_others_as_they_are() -> None:
    _, _, analysis = wedged(0)
    every = least_factor(analysis.problem, analysis.associated.optimum, 4, 7)
    two = least_factor(analysis.problem, analysis.associated.optimum, 2, 7)
    last = least_factor(analysis.problem, analysis.associated.optimum, 4, 7, 2, two)
    both = merged(two, last, 4)
    assert every is not None and two is not None and both is not None
    assert (every.starts, two.starts) == (4, 2) and both.found == pytest.approx(every.found, rel=1e-9)


def test_a_search_goes_on_until_two_starts_agree_and_no_farther() -> None:
    assembly, joints, analysis = wedged(2)
    assert analysis.least is not None and not analysis.least.has_agreement  # each end has its own mechanism
    more = with_more_starts(analysis, assembly, joints, 2, 8, 0)
    assert more.least is not None and more.least.has_agreement and more.starts < 8
    assert more.least.optimum.factor == pytest.approx(ALONE, rel=1e-4)
    assert with_more_starts(more, assembly, joints, 2, 8, 0).starts == more.starts


def test_rounds_from_the_least_pair_lower_it_and_are_no_start() -> None:
    _, _, analysis = wedged(2)
    assert analysis.least is not None
    lower = polished(analysis.problem, analysis.least, CAP * analysis.associated.factor)
    assert lower.optimum.factor <= analysis.least.optimum.factor and lower.gap < 1e-3
    assert (lower.starts, lower.ends, lower.agreeing) == (analysis.least.starts, analysis.least.ends, analysis.least.agreeing)


def test_a_least_pair_whose_solver_ended_early_is_reported_and_no_other() -> None:
    assembly, joints, analysis = wedged(2)
    assert analysis.least is not None and analysis.remarks == ()
    early = replace(analysis.least.optimum, stopped="MaxIterations")
    analysis = replace(analysis, least=replace(analysis.least, optimum=early))
    (line,) = analysis.remarks
    assert line.startswith("the least factor: the solver stopped before it met its tolerance (MaxIterations after ")
    assert with_more_starts(analysis, assembly, joints, 2, 8, 0).remarks == ()  # of the least pair then, which converged


def towers(*halves: float) -> LimitProblem:
    """Towers of three cubes in a row, of a width of twice each of ``halves``, pushed along x, which each overturn at their slenderness."""
    blocks = [ground(40.0)]
    for k, half in enumerate(halves):
        blocks += [box(f"{k}.{i}", (-half, 3.0 * k, float(i)), (half, 3.0 * k + 1.0, i + 1.0)) for i in range(3)]
    assembly, joints = joined(blocks, 0.8)
    return analyse(assembly, joints, push_loads(assembly, (1.0, 0.0, 0.0)), LimitOptions(starts=0)).problem


def test_rounds_among_the_blocks_that_move_lead_to_the_pair_of_all(monkeypatch: pytest.MonkeyPatch) -> None:
    problem, sizes = towers(0.6, 0.4, 0.6, 0.7, 0.6), list[int]()
    priced = Programme.priced

    def counted(self: Programme, *given: Any) -> Programme:
        sizes.append(self.problem.points.count)
        return priced(self, *given)

    monkeypatch.setattr(Programme, "priced", counted)
    monkeypatch.setattr(descent, "LARGE", 0)
    associated = largest(problem, problem.dead, problem.live, 10.0)
    least = least_factor(problem, associated, 2, 0)
    assert least is not None and least.optimum.factor == pytest.approx(0.4 / 1.5, rel=1e-4)
    assert least.optimum.force.shape == (problem.points.count, 3) and problem.unknowns == len(least.optimum.velocity)
    assert min(sizes) == problem.points.count // 5 and sizes[-1] == problem.points.count


def test_a_mechanism_that_forces_elsewhere_do_not_go_with_is_no_pair() -> None:
    """The wider tower does not overturn, as the other one has before."""
    problem = towers(0.6, 0.4)
    search, n = Search(problem, 10.0), problem.unknowns // 2
    for own, slenderness in ((slice(n, None), 0.4 / 1.5), (slice(0, n), None)):
        alone = np.where(np.isin(np.arange(problem.unknowns), np.arange(problem.unknowns)[own]), 1.0, 0.0)
        found = largest(problem, problem.dead * alone, problem.live * alone, 10.0)
        pair = search.confirmed(found.velocity * alone / float(problem.live @ (found.velocity * alone)))
        assert (pair is None) if slenderness is None else pair is not None and pair[0].factor == pytest.approx(slenderness, rel=1e-4)


def test_programmes_that_are_set_up_once_give_what_each_gives_by_itself() -> None:
    _, _, analysis = wedged(0)
    problem, cap = analysis.problem, CAP * analysis.associated.factor
    one, alone = Search(problem, cap), Search(problem, cap)
    pressed = one.descend(one.mechanism_of(np.maximum(analysis.associated.optimum.force[:, 0], 0.0)))
    second, again = one.descend(one.mechanism_of(one.least_normal)), alone.descend(alone.mechanism_of(alone.least_normal))
    assert pressed is not None and second is not None and again is not None
    assert second[0].factor == pytest.approx(again[0].factor, rel=1e-9)


def test_of_two_walls_that_no_start_joins_the_slenderer_one_is_found_as_a_part(tmp_path: Path) -> None:
    """The search of the whole may come to either; a part is begun at in any case, and the least of all is of the slenderer one."""
    thick, thin = box("thick", (0.0, -1.0, 0.0), (0.5, 1.0, 3.0)), box("thin", (4.0, -1.0, 0.0), (4.48, 1.0, 3.0))
    blockfile.write(tmp_path / "blocks.json", [ground(8.0), replace(thick, group="thick"), replace(thin, group="thin", name="thin")])
    path = tmp_path / "scene.toml"
    path.write_text(
        'structure = {kind = "file", path = "blocks.json"}\nmaterial = {density = 2000.0, friction = 0.6}\n'
        'limit = {push = "x", starts = 2}\n[[loads]]\nkind = "point"\nblock = "thick"\nforce = [0.0, 1.0, 0.0]\n'
    )
    found = limit_case(path).whole.analysis.least
    assert found is not None and found.starts >= 3
    assert found.optimum.factor == pytest.approx(0.48 / 3.0, rel=1e-3)
