# SPDX-License-Identifier: GPL-3.0-or-later
"""One contact, solved through the public solver: Signorini's and Coulomb's conditions for any mass, geometry, friction and magnitude."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from masonry_cd.mechanics.friction.contact_geometry import Geometry
from masonry_cd.mechanics.friction.problem import FrictionProblem, natural_map_error
from masonry_cd.mechanics.solvers import SOLVERS, Options

DIGITS = 1e-9  # of what is compared, times the condition number of W
CONDITION = 1e4  # worst of W that is requested
UNIT = st.floats(-1.0, 1.0).map(lambda x: x if abs(x) > 1e-9 else 0.0)  # squares of smaller ones may be lost
FRICTION = st.one_of(st.sampled_from([0.0, 0.3, 0.6, 1.0, 3.0]), st.floats(0.0, 3.0))
ROUNDING = 1.0 + 1e-12
ROUNDED = 1e-15  # of velocities, against the largest of them


def solve(problem: FrictionProblem) -> np.ndarray:
    """Impulse (m,) of the only contact, by sweeps that no tolerance ends."""
    return SOLVERS["nlgs"](problem, Options(tolerance=1e-300, max_iterations=3), None).impulse[0]


@st.composite
def contacts(draw: st.DrawFn, m: int, elastic: bool = False, friction: st.SearchStrategy[float] = FRICTION) -> FrictionProblem:
    """One body with a full mass matrix on a support: H random, W of a condition number up to CONDITION, any scale of mass and velocity."""
    n = 6 if m == 3 else 3
    root, h = draw(arrays(float, (n, n), elements=UNIT)), draw(arrays(float, (m, n), elements=UNIT))
    inverse_mass = (root @ root.T + 0.05 * np.eye(n)) * 10.0 ** draw(st.integers(-8, 8))
    w = h @ inverse_mass @ h.T
    assume(np.trace(w) > 1e-3 * np.trace(inverse_mass))
    assume(np.linalg.cond(w) < CONDITION)
    speed, offset = draw(arrays(float, n, elements=UNIT)), draw(arrays(float, m, elements=UNIT))
    speed, offset = 10.0 ** draw(st.integers(-8, 8)) * speed, 10.0 ** draw(st.integers(-8, 8)) * offset
    jacobian = np.zeros((1, 2, m, n))
    jacobian[0, 0] = h
    compliance = draw(arrays(float, m, elements=st.floats(0.0, 3.0))) * np.trace(w) if elastic else np.zeros(m)
    mu = np.array([draw(friction)])
    problem = FrictionProblem(
        inverse_mass[None], speed[None], np.array([[0, -1]]), Geometry.by_rows(jacobian), offset[None], mu, compliance[None]
    )
    assume(np.linalg.norm(problem.free_relative_velocity()) > 1e-3 * (np.linalg.norm(h @ speed) + np.linalg.norm(offset)) > 0.0)
    return problem


def one_contact(elastic: bool = False, friction: st.SearchStrategy[float] = FRICTION) -> st.SearchStrategy[FrictionProblem]:
    """A contact in a plane or in space."""
    return st.sampled_from([2, 3]).flatmap(lambda m: contacts(m, elastic, friction))


def scaled(problem: FrictionProblem, p: np.ndarray) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Impulse and velocity in the unit of |q|, the tolerance on them, and mu: r = p sqrt(d) / |q / sqrt(d)|, z likewise."""
    w = problem.delassus_diagonal()[0]
    root = np.sqrt(np.trace(w) / len(p))
    size = np.linalg.norm(problem.free_relative_velocity()) / root
    z = problem.apply(p[None])[0] / root / size
    return p * root / size, z, DIGITS * np.linalg.cond(w), float(problem.mu[0])


@given(one_contact(elastic=True))
def test_normal_impulse_and_velocity_are_complementary(problem: FrictionProblem) -> None:
    r, z, tolerance, _ = scaled(problem, solve(problem))
    assert r[0] >= 0.0
    assert z[0] >= -tolerance
    assert abs(r[0] * z[0]) <= tolerance * (1.0 + r[0])


@given(one_contact(elastic=True))
def test_the_impulse_lies_in_the_cone_and_friction_opposes_the_sliding(problem: FrictionProblem) -> None:
    r, z, tolerance, mu = scaled(problem, solve(problem))
    friction, sliding = np.linalg.norm(r[1:]), np.linalg.norm(z[1:])
    assert friction <= mu * r[0] * ROUNDING
    if sliding > tolerance:  # on the edge of the cone, against the velocity
        assert (mu * r[0] - friction) * sliding <= tolerance * (1.0 + r[0])
        assert r[1:] @ z[1:] == pytest.approx(-friction * sliding, abs=tolerance * (1.0 + r[0]))


@given(one_contact(elastic=True))
def test_the_error_of_the_answer_is_rounding(problem: FrictionProblem) -> None:
    p = solve(problem)
    assert natural_map_error(problem, p[None]) <= DIGITS * 1e-3 * np.linalg.cond(problem.delassus_diagonal()[0])


@given(one_contact())
def test_a_support_at_rest_takes_energy_out_of_the_body(problem: FrictionProblem) -> None:
    """p . u <= 0, and the kinetic energy does not grow."""
    problem = replace(problem, offset=np.zeros_like(problem.offset))
    assume(np.linalg.norm(problem.free_relative_velocity()) > 0.0)
    p = solve(problem)
    r, z, tolerance, _ = scaled(problem, p)
    assert r @ z <= tolerance * (1.0 + np.linalg.norm(r))
    mass = np.linalg.inv(problem.inverse_mass[0])
    before, after = problem.v_free[0], problem.body_velocity(p[None])[0]
    assert after @ mass @ after <= before @ mass @ before * (1.0 + 1e-9)


@given(one_contact(), st.integers(-6, 6), st.integers(-6, 6), st.integers(-6, 6))
def test_units_change_nothing_but_the_numbers(problem: FrictionProblem, kilogram: int, metre: int, second: int) -> None:
    """Mass, length and time in other units, powers of four so that they round alike: the impulse has the unit kg m / s."""
    mass, length, time = 4.0**kilogram, 4.0**metre, 4.0**second
    n, free = problem.v_free.shape[1], problem.dimension
    unit = np.array([length] * free + [1.0] * (n - free))  # linear velocities have lengths, angular ones none
    other = replace(
        problem,
        inverse_mass=problem.inverse_mass / mass / length**2 * np.outer(unit, unit),
        v_free=problem.v_free * unit / time,
        geometry=Geometry.by_rows(problem.jacobian * length / unit),
        offset=problem.offset * length / time,
    )
    p = solve(problem)
    np.testing.assert_allclose(solve(other), p * mass * length / time, rtol=1e-12, atol=0.0)
    assert natural_map_error(other, solve(other)[None]) == pytest.approx(natural_map_error(problem, p[None]), rel=1e-6, abs=1e-14)


@given(contacts(3), st.floats(-np.pi, np.pi))
def test_the_tangents_are_a_choice(problem: FrictionProblem, angle: float) -> None:
    """The impulse for one pair of tangents, turned, solves the problem written in another pair."""
    turn = np.eye(3)
    turn[1:, 1:] = [[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]
    other = replace(problem, geometry=Geometry.by_rows(turn @ problem.jacobian), offset=problem.offset @ turn.T)
    _, _, tolerance, _ = scaled(problem, solve(problem))
    assert natural_map_error(other, (turn @ solve(problem))[None]) <= tolerance


@given(one_contact(friction=st.just(0.0)))
def test_without_friction_it_has_the_closed_form(problem: FrictionProblem) -> None:
    """p_n = max(0, -q_n / W_nn), and nothing along the tangents."""
    w, q, p = problem.delassus_diagonal()[0], problem.free_relative_velocity()[0], solve(problem)
    assert not p[1:].any()
    assert p[0] == pytest.approx(max(0.0, -q[0] / w[0, 0]), rel=1e-12, abs=0.0)


@given(one_contact(), st.integers(-320, -20))
def test_friction_too_small_to_be_felt_is_none(problem: FrictionProblem, power: int) -> None:
    """Down to the smallest of all numbers: the normal impulse is that without friction, and the tangential one stays in the cone."""
    w, q = problem.delassus_diagonal()[0], problem.free_relative_velocity()[0]
    p = solve(replace(problem, mu=np.array([10.0**power])))
    assert p[0] == pytest.approx(max(0.0, -q[0] / w[0, 0]), rel=1e-12, abs=0.0)
    assert np.linalg.norm(p[1:]) <= 10.0**power * p[0] * ROUNDING


@given(contacts(2))
def test_in_a_plane_it_is_one_of_the_four_closed_forms(problem: FrictionProblem) -> None:
    """Open, sticking, or slipping to one of two sides: no more is possible, and those that do not fit are no answer."""
    w, q, p, mu = problem.delassus_diagonal()[0], problem.free_relative_velocity()[0], solve(problem), problem.mu[0]
    forms = [np.zeros(2), -np.linalg.solve(w, q)]
    for side in (-1.0, 1.0):
        edge = np.array([1.0, side * mu])
        if w[0] @ edge != 0.0:
            forms.append(-q[0] / (w[0] @ edge) * edge)
    fitting = [form for form in forms if natural_map_error(problem, form[None]) < DIGITS * np.linalg.cond(w)]
    size = np.linalg.norm(q) / np.linalg.eigvalsh(w)[0]
    assert min(np.linalg.norm(p - form) for form in fitting) <= 1e-6 * size


@given(one_contact())
def test_a_contact_that_opens_by_itself_may_stay_without_impulse(problem: FrictionProblem) -> None:
    """Where q_n >= 0 no impulse solves the problem, and where q_n < 0 none does not."""
    nothing = np.zeros((1, problem.dimension))
    q = problem.free_relative_velocity()[0]
    assume(q[0] >= 0.0 or -q[0] > ROUNDED * np.linalg.norm(q))  # below, an error this small against the slip is none
    opens = q[0] >= 0.0
    assert (natural_map_error(problem, nothing) <= ROUNDED) == opens
    assert opens or solve(problem)[0] > 0.0
