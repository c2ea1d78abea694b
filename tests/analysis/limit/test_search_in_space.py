# SPDX-License-Identifier: GPL-3.0-or-later
"""The search in space: starts one by one are the starts together, it goes on until some agree, and it begins at the structure's parts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from limit_loads import joined, push_loads
from models import box, ground

from masonry_cd.analysis.limit.analysis import Analysis, Options, analyse, with_more_starts
from masonry_cd.analysis.limit.search import CAP, Search, least_factor, polished
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
    return assembly, joints, analyse(assembly, joints, push_loads(assembly, (-1.0, 0.0, 0.0)), Options(starts=starts))


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
    assert analysis.least is not None and not analysis.least.agreed  # each end has its own mechanism
    more = with_more_starts(analysis, assembly, joints, 2, 8, 0)
    assert more.least is not None and more.least.agreed and more.starts < 8
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
    assert line.startswith("the least factor: the solver ended before its tolerance (MaxIterations after ")
    assert with_more_starts(analysis, assembly, joints, 2, 8, 0).remarks == ()  # of the least pair then, which converged


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
