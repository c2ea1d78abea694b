# SPDX-License-Identifier: GPL-3.0-or-later
r"""Joints that crush, in the programmes of a limit analysis: their cells are bars that yield.

With the corners x_k of a joint, their forces r_k, and the forces N_c of its cells (:mod:`masonry_cd.analysis.limit.sections`),

    sum_k (r_kn + f_k) (1, x_k) - sum_c N_c (1, x_c) = 0,        0 <= N_c <= (f + f_t) A_c.

So a joint brings unknowns to the velocities, its closing rate a(x) = a_0 + a_1 . x: H gets the columns (1, x_k) in the rows of normals,
u_kn + a(x_k) is what friction cones see, and each cell is a row (1, x_c) of G, a bar that grows longer by a(x_c) and yields. Friction is
as it was: a joint that crushes follows normality in N and M, one that slides does not dilate where none does.

The cells' forces are forces that the joint bears: a factor by cells is never above that of the domain itself. They are cut where the
mechanism crushes, and the programme is solved again, until that adds next to nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, hstack, vstack

from masonry_cd.analysis.limit.problem import LimitProblem
from masonry_cd.analysis.limit.sections import Sections, sections
from masonry_cd.analysis.limit.solution import Optimum
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import pressure
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints

ROUNDS = 12  # of cuts at most
FINE = 3e-4  # share of the factor below which what a round of cuts adds is next to nothing: each adds a tenth or so of the one before
CRUSHES = 1e-6  # closing rate of a corner, as a share of the largest velocity, from which a joint crushes


def crushable(problem: LimitProblem, assembly: Assembly, joints: Joints) -> LimitProblem:
    """A problem whose joints crush where they have a strength; itself where none has."""
    found = sections(assembly, joints, problem.points, problem.axis)
    return problem if found is None else with_cells(with_rates(problem, found), found)


def with_rates(problem: LimitProblem, found: Sections) -> LimitProblem:
    """The closing rates of sections as unknowns; the uniform tension from which the cells' stress counts is a dead load of theirs."""
    count, each = len(found.joint), 1 + found.levers
    place = np.full(int(problem.points.joint.max()) + 1, -1)
    place[found.joint] = np.arange(count)
    owner = place[problem.points.joint]
    points = np.flatnonzero(owner >= 0)
    basis = found.basis(problem.points.point[points], owner[points])
    row = np.repeat(problem.directions * points, each)
    column = (each * owner[points, None] + np.arange(each)).ravel()
    rates = coo_matrix((basis.ravel(), (row, column)), (problem.jacobian.shape[0], count * each))
    held = np.bincount(column, (basis * problem.tension[points, None]).ravel(), minlength=count * each)
    return replace(
        problem,
        jacobian=hstack([problem.jacobian, rates], format="csr"),
        bars=hstack([problem.bars, csr_matrix((problem.bars.shape[0], count * each))], format="csr"),
        dead=np.concatenate([problem.dead, held]),
        live=np.concatenate([problem.live, np.zeros(count * each)]),
    )


def with_cells(problem: LimitProblem, found: Sections) -> LimitProblem:
    """The cells of sections as bars behind the ties, in place of those that were there."""
    each, ties = 1 + found.levers, problem.ties
    cells = found.cells
    basis = np.concatenate([np.ones((len(cells.owner), 1)), cells.centroid[:, : found.levers]], axis=1)
    column = problem.unknowns - each * len(found.joint) + each * cells.owner[:, None] + np.arange(each)
    row = np.repeat(np.arange(len(cells.owner)), each)
    bars = coo_matrix((basis.ravel(), (row, column.ravel())), (len(cells.owner), problem.unknowns))
    strength = np.concatenate([problem.strength[:ties], found.force / problem.weight])
    return replace(problem, bars=vstack([problem.bars[:ties], bars], format="csr"), strength=strength, sections=found)


def closing_rates(problem: LimitProblem, velocity: np.ndarray) -> np.ndarray:
    """(S, 1 + n) a_0 and a_1 of the sections, from the unknowns of a problem that has some."""
    found = problem.sections
    assert found is not None
    return velocity[problem.unknowns - problem.rates :].reshape(-1, 1 + found.levers)


def crushed_open(problem: LimitProblem, velocity: np.ndarray) -> np.ndarray:
    """Velocities (unknowns,) with the closing rates of joints whose blocks overlap, which are linear over the joint.

    With a = -u_n the cells where it closes are at their strength, and those where it opens bear nothing.
    """
    found, out = problem.sections, velocity.copy()
    if found is None:
        return out
    left, each = problem.unknowns - problem.rates, 1 + found.levers
    out[left:] = 0.0
    opening = (problem.jacobian @ out)[:: problem.directions]
    size = CRUSHES * float(np.abs(out).max(initial=0.0))
    for s in np.flatnonzero(np.isin(found.joint, problem.points.joint[opening < -size])):
        points = np.flatnonzero(problem.points.joint == found.joint[s])
        basis = found.basis(problem.points.point[points], np.full(len(points), s))
        out[left + each * s : left + each * (s + 1)] = np.linalg.lstsq(basis, -opening[points])[0]
    return out


def section_forces(problem: LimitProblem, best: Optimum) -> np.ndarray:
    """(S,) the normal forces of the sections, from the uniform tension of their bond on [N]."""
    found = problem.sections
    assert found is not None
    lifted = problem.weight * (best.force[:, 0] + problem.tension)
    return np.bincount(problem.points.joint, lifted, minlength=int(found.joint.max()) + 1)[found.joint]


def block_shares(problem: LimitProblem, best: Optimum, joints: int) -> np.ndarray:
    """Share of the area of each of a given number of joints (J,) that its stress block takes, nan of joints that do not crush."""
    out = np.full(joints, np.nan)
    if problem.sections is not None:
        out[problem.sections.joint] = section_forces(problem, best) / (problem.sections.strength * problem.sections.area)
    return out


def cut_where_it_crushes(problem: LimitProblem, best: Optimum) -> LimitProblem | None:
    """The problem with cells cut where a mechanism crushes, None where it crushes nothing."""
    if problem.sections is None:
        return None
    found, rate = problem.sections, closing_rates(problem, best.velocity)
    crushes = found.closing(rate) > CRUSHES * float(np.abs(best.velocity).max(initial=0.0))
    if not crushes.any():
        return None
    return with_cells(problem, found.cut_for(rate, section_forces(problem, best), crushes))


def solved_finely(
    problem: LimitProblem, solve: Callable[[LimitProblem], Optimum], enough: float = math.inf
) -> tuple[LimitProblem, Optimum]:
    """A problem and its optimum, the cells of its joints cut until that adds no more than FINE of the factor.

    Args:
        problem: that may have sections.
        solve: the largest factor of a problem.
        enough: a factor above which it need not be found any closer.
    """
    best = solve(problem)
    for _ in range(ROUNDS):
        if best.factor > enough:
            break
        finer = cut_where_it_crushes(problem, best)
        if finer is None:
            break
        again, before = solve(finer), best.factor
        problem, best = finer, again
        if again.factor - before <= FINE * abs(again.factor):
            break
    return problem, best


def refuse_crushed_at_rest(problem: LimitProblem, alone: Optimum, assembly: Assembly, stands: Callable[[LimitProblem], bool]) -> None:
    """Refuse a strength below the stress that dead loads make.

    Args:
        problem: whose dead loads are not borne.
        alone: the largest share of them that is.
        assembly: its blocks.
        stands: whether a problem bears all of them.

    Raises:
        InputError: the structure would stand if its joints did not crush; names the joint that is at its strength most.
    """
    found = problem.sections
    assert found is not None
    force = section_forces(problem, alone)
    if not stands(_uncrushed(problem)):
        return
    worst = int(np.argmax(np.where(found.closing(closing_rates(problem, alone.velocity)) > 0.0, force / found.area, -np.inf)))
    a, b = problem.points.bodies[np.flatnonzero(problem.points.joint == found.joint[worst])[0]]
    strength = found.strength[worst] - found.tension[worst]
    groups = "-".join(assembly.groups[assembly.group_of[block]] for block in (a, b))
    mean = force[worst] / found.area[worst] - found.tension[worst]
    raise InputError(
        "material.joints",
        f'the joint "{assembly.names[a]}" - "{assembly.names[b]}" ({groups}) crushes at {pressure(strength)} under the '
        f"dead loads alone: {100.0 * alone.factor:.3g} % of them are borne, with a mean stress of {pressure(mean)} in this joint",
    )


def _uncrushed(problem: LimitProblem) -> LimitProblem:
    """The problem of joints that do not crush."""
    left, ties = problem.unknowns - problem.rates, problem.ties
    return replace(
        problem, jacobian=problem.jacobian[:, :left], bars=problem.bars[:ties, :left], dead=problem.dead[:left], live=problem.live[:left],
        strength=problem.strength[:ties], sections=None,
    )  # fmt: skip
