# SPDX-License-Identifier: GPL-3.0-or-later
"""Contacts by fours of joints: H v, H^T p, their scales and H^T R H are those of their rows, whether these have frames or not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scenes

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.friction.contact_geometry import Geometry
from masonry_cd.mechanics.friction.natural_map import project_to_cone
from masonry_cd.mechanics.friction.operators import Elimination, ProblemArrays, put_in_order
from masonry_cd.mechanics.friction.problem import FrictionProblem
from masonry_cd.mechanics.linalg.ordering import Pattern
from masonry_cd.mechanics.linalg.threads import own_arena
from masonry_cd.mechanics.linalg.vectors import LANES, load_four
from masonry_cd.mechanics.solvers.admm_subtrees import augment
from masonry_cd.mechanics.solvers.admm_workspace import AdmmWorkspace, KeptFactors, allocate_workspace
from masonry_cd.mechanics.solvers.contact_groups import (
    SCALE,
    STIFFNESS,
    add_to_wrench,
    add_wrench,
    fill_group,
    no_wrench,
    put_three,
    three,
    twist_of,
    velocity_at,
)


@entry()
def workspace(given: ProblemArrays, elimination: Elimination, kept: KeptFactors) -> AdmmWorkspace:
    """The workspace of ADMM, with the problem in order."""
    work = allocate_workspace(own_arena(), given, elimination, kept)
    put_in_order(given, elimination.order, 0, len(elimination.order), work.problem)
    return work


@entry()
def products(work: AdmmWorkspace, v: np.ndarray, p: np.ndarray, u: np.ndarray) -> None:
    """Fill the groups of one subtree, u = H v and momentum = H^T p, p and u (L, 12), and the matrix with R = 1 + number of the contact."""
    problem, groups = work.problem, work.groups
    for g in range(groups.subtree[0], groups.subtree[1]):
        fill_group(problem, groups, g)
        twist, wrench = twist_of(groups, g, v, problem), no_wrench()
        for row in range(groups.start[g], groups.start[g + 1]):
            put_three(u, row, 0, velocity_at(groups, row, twist))
            wrench = add_to_wrench(groups, row, wrench, three(p, row, 0))
            for lane in range(LANES):
                groups.table[row, LANES * STIFFNESS + lane] = 1.0 + groups.contact[row, lane]
        add_wrench(groups, g, wrench, work.iterates.momentum, problem)
    augment(work, 0)


@entry()
def projections(x, mu, stretch, out):
    """Each of the points x (4, 3) projected onto the cones, out (2, 12): in lanes, and one by one in the stretched norm."""
    factor, width = load_four(stretch, 0, 0), load_four(mu, 0, 0)
    lanes = load_four(x, 0, 0), load_four(x, 0, 4), load_four(x, 0, 8)
    put_three(out, 0, 0, project_to_cone(lanes, width, width * factor, 1.0 / (1.0 + width * width * factor)))
    for k in range(4):
        root = np.sqrt(stretch[0, k])
        wide = root * mu[0, k]
        n, t1, t2 = project_to_cone((x[0, k], root * x[0, 4 + k], root * x[0, 8 + k]), wide, wide, 1.0 / (1.0 + wide * wide))
        out[1, k], out[1, 4 + k], out[1, 8 + k] = n, t1 / root, t2 / root


def grouped(problem: FrictionProblem) -> tuple[AdmmWorkspace, Pattern]:
    """The contacts of a problem by groups of joints, in the order of elimination."""
    pattern = Pattern.of(len(problem.v_free), problem.bodies[:, 0], problem.bodies[:, 1])
    found = pattern.locate(problem.bodies, problem.bodies)
    assert found is not None
    kept = KeptFactors(pattern.symbolic, *(np.empty(0, dtype=np.float32) for _ in range(2)), np.empty(problem.contacts))
    return workspace(problem.arrays(), Elimination(pattern.order, *found[:2]), kept), pattern


def uneven() -> FrictionProblem:
    """Joints between rigid blocks in space, of four contacts and of fewer."""
    problem = scenes.thrown(0.3)
    return problem.subset(np.arange(problem.contacts) % 7 != 0)


def odd_rows() -> FrictionProblem:
    """Blocks in space one of whose contacts has a row that no frame has, and joints that give way."""
    problem = scenes.softened(scenes.thrown(0.3), 0.3)
    jacobian = problem.jacobian.copy()
    jacobian[5, 0, 1, 4] += 1e-3
    return replace(problem, geometry=Geometry.by_rows(jacobian))


def coupled() -> FrictionProblem:
    """Blocks in space whose coordinates are not those of their centres of mass."""
    return scenes.off_centre(scenes.thrown(0.3))


def in_plane() -> FrictionProblem:
    """The first two rows of contacts in space, by three unknowns of their blocks."""
    problem, kept = scenes.softened(scenes.thrown(0.3), 0.3), [0, 2, 4]
    return replace(
        problem, geometry=Geometry.by_rows(problem.jacobian[:, :, :2, kept]), inverse_mass=problem.inverse_mass[:, kept][:, :, kept],
        v_free=problem.v_free[:, kept], offset=problem.offset[:, :2], compliance=problem.compliance[:, :2],
    )  # fmt: skip


def planar() -> FrictionProblem:
    """Joints between rigid blocks in a plane that give way."""
    return scenes.in_plane(scenes.softened(uneven(), 0.3))


PROBLEMS = {"rigid": uneven, "coupled": coupled, "planar": planar, "odd rows": odd_rows, "rows in a plane": in_plane}


@pytest.mark.parametrize("name", PROBLEMS)
def test_groups_have_the_operators_of_the_rows(name: str) -> None:
    """u = H v, H^T p, d and the blocks of M + H^T R H, each summed up from the rows of H in numpy."""
    problem = PROBLEMS[name]()
    work, pattern = grouped(problem)
    groups = work.groups
    assert bool(len(groups.frame)) == (name in ("rigid", "coupled", "planar"))
    generator, (blocks, n), m = np.random.default_rng(1), problem.v_free.shape, problem.dimension
    v, impulse = generator.normal(size=(blocks, n)), generator.normal(size=(problem.contacts, m))
    v_sorted, p, u = (
        np.append(v[pattern.order], np.zeros((1, n)), axis=0),
        np.zeros((len(groups.table), 12)),
        np.zeros((len(groups.table), 12)),
    )
    on = groups.contact >= 0
    for i in range(m):
        p[:, LANES * i : LANES * (i + 1)][on] = impulse[groups.contact[on], i]
    work.iterates.momentum[:] = 0.0
    products(work, v_sorted, p, u)

    assert np.array_equal(np.sort(groups.contact[on]), np.arange(problem.contacts))
    h = problem.jacobian_matrix().toarray()
    expected = (h @ v.ravel()).reshape(-1, m)
    for i in range(m):
        np.testing.assert_allclose(u[:, LANES * i : LANES * (i + 1)][on], expected[groups.contact[on], i], atol=1e-11)
    np.testing.assert_allclose(work.iterates.momentum[pattern.place], (h.T @ impulse.ravel()).reshape(-1, n), atol=1e-11)
    d = np.trace(problem.delassus_diagonal(), axis1=1, axis2=2) / m
    scale = groups.table[:, LANES * SCALE : LANES * (SCALE + 1)]
    np.testing.assert_allclose(scale[on], d[groups.contact[on]], rtol=1e-11)
    assert not scale[~on].any()

    mass = np.zeros((blocks * n, blocks * n))
    for b in range(blocks):
        mass[b * n : (b + 1) * n, b * n : (b + 1) * n] = np.linalg.inv(problem.inverse_mass[b])
    matrix = (mass + h.T @ (np.repeat(1.0 + np.arange(problem.contacts), m)[:, None] * h)).reshape(blocks, n, blocks, n)
    column, row, own = pattern.symbolic.column, pattern.symbolic.row, pattern.order
    for j in range(blocks):
        np.testing.assert_allclose(
            work.factor.diagonal[j].reshape(n, n), matrix[own[j], :, own[j]], rtol=1e-9, atol=1e-9 * abs(matrix).max()
        )
        for e in range(column[j], column[j + 1]):
            np.testing.assert_allclose(work.factor.lower[e], matrix[own[row[e]], :, own[j]], rtol=1e-9, atol=1e-9 * abs(matrix).max())


def test_joints_of_equal_size_stand_side_by_side() -> None:
    """A wall's joints have four contacts each; only the last group of a subtree is not full."""
    problem = scenes.wall(6, 20)
    groups = grouped(problem)[0].groups
    assert problem.contacts <= groups.contact.size <= 1.05 * problem.contacts + 16


def test_lanes_are_projected_as_one_by_one() -> None:
    """Inside the cone, on it, beyond it and in its polar; without friction; at the apex; in a stretched norm."""
    generator, out = np.random.default_rng(2), np.empty((2, 12))
    for _ in range(50):
        x, mu, stretch = 2.0 * generator.normal(size=(1, 12)), generator.uniform(0.0, 1.5, (1, 4)), generator.uniform(0.3, 2.0, (1, 4))
        x[0, ::5], mu[0, 0], x[0, [3, 7, 11]] = 0.0, 0.0, 0.0
        projections(x, mu, stretch, out)
        np.testing.assert_allclose(out[0], out[1], rtol=1e-13, atol=1e-14)
