# SPDX-License-Identifier: GPL-3.0-or-later
"""The natural map: its projection is the nearest point of Coulomb's cone, and its residual is zero at solutions and nowhere else."""

from __future__ import annotations

import numba
import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import sparse

from masonry_cd.mechanics.friction.natural_map import project_to_cone
from masonry_cd.mechanics.friction.problem import LocalProblem, natural_map_error

VECTOR = arrays(float, 3, elements=st.floats(-10.0, 10.0).map(lambda x: x if abs(x) > 1e-9 else 0.0))
FRICTION = st.one_of(st.sampled_from([0.0, 0.6, 1.0]), st.floats(0.0, 3.0).map(lambda mu: mu if mu > 1e-9 else 0.0))
ROUNDING = 1e-13


@numba.njit
def _project(x: np.ndarray, mu: float) -> tuple[float, float, float]:
    return project_to_cone((x[0], x[1], x[2]), mu, mu, 1.0 / (1.0 + mu * mu))


def project(x: np.ndarray, mu: float) -> np.ndarray:
    """The point of Coulomb's cone nearest to x (3,), as the kernels compute it."""
    return np.array(_project(x, mu))


def residual(p: np.ndarray, u: np.ndarray, mu: float) -> float:
    """| p - P_K(p - (u + mu |u_t| n)) | of one contact with W = 1."""
    q = u - p
    error = natural_map_error(LocalProblem(sparse.identity(3, format="csr"), q[None], np.array([mu])), p[None])
    return error * float(np.linalg.norm(q)) if q.any() else error


@given(VECTOR, FRICTION)
def test_the_projection_lands_in_the_cone_and_stays_there(x: np.ndarray, mu: float) -> None:
    y = project(x, mu)
    size = 1.0 + np.linalg.norm(x)
    assert y[0] >= 0.0
    assert np.linalg.norm(y[1:]) <= mu * y[0] + ROUNDING * size
    np.testing.assert_allclose(project(y, mu), y, rtol=0.0, atol=ROUNDING * size)


@given(VECTOR, VECTOR, FRICTION)
def test_the_projection_takes_no_two_points_apart(x: np.ndarray, y: np.ndarray, mu: float) -> None:
    assert np.linalg.norm(project(x, mu) - project(y, mu)) <= np.linalg.norm(x - y) + ROUNDING * (np.linalg.norm(x) + np.linalg.norm(y))


@given(VECTOR, FRICTION)
def test_what_the_projection_takes_off_is_polar_to_the_cone(x: np.ndarray, mu: float) -> None:
    """Moreau's decomposition x = y + z: y in K, z in the polar cone mu |z_t| <= -z_n, y . z = 0. It makes y the nearest point."""
    y = project(x, mu)
    z, size = x - y, 1.0 + np.linalg.norm(x)
    assert mu * np.linalg.norm(z[1:]) <= -z[0] + 10.0 * ROUNDING * size
    assert abs(y @ z) <= 10.0 * ROUNDING * size**2


@given(VECTOR, FRICTION, st.integers(-300, 300))
def test_the_projection_has_no_length_of_its_own(x: np.ndarray, mu: float, power: int) -> None:
    scale = 2.0**power
    np.testing.assert_allclose(project(scale * x, mu), scale * project(x, mu), rtol=1e-15, atol=0.0)


@given(st.sampled_from(["open", "stick", "slip"]), st.floats(0.01, 10.0), st.floats(0.0, 10.0), st.floats(-np.pi, np.pi), FRICTION)
def test_the_residual_is_zero_at_solutions(status: str, normal: float, tangent: float, angle: float, mu: float) -> None:
    """Open contacts without impulse, sticking ones inside the cone, slipping ones on its edge."""
    direction = np.array([0.0, np.cos(angle), np.sin(angle)])
    axis = np.array([1.0, 0.0, 0.0])
    p, u = np.zeros(3), np.zeros(3)
    if status == "open":
        u = normal * axis + tangent * direction
    elif status == "stick":
        p = normal * (axis + mu * tangent / 10.0 * direction)
    else:
        p, u = normal * (axis - mu * direction), tangent * direction
    assert residual(p, u, mu) <= ROUNDING * (1.0 + np.linalg.norm(p) + np.linalg.norm(u))


@given(VECTOR, VECTOR, FRICTION)
def test_the_residual_bounds_every_violation_of_the_law(p: np.ndarray, u: np.ndarray, mu: float) -> None:
    """With e = r - P_K(r - w), w = u + mu |u_t| n: r is within |e| of K, w within |e| of K*, and |r . w| <= |e| (|r| + |w| + |e|).

    So where the residual vanishes, all of the law holds.
    """
    assume((u - p).any())
    w = u + np.array([mu * np.linalg.norm(u[1:]), 0.0, 0.0])
    size = 1.0 + np.linalg.norm(p) + np.linalg.norm(w)
    e, slope = residual(p, u, mu) + 10.0 * ROUNDING * size, np.hypot(1.0, mu)
    assert -p[0] <= e
    assert np.linalg.norm(p[1:]) - mu * p[0] <= slope * e
    assert -u[0] <= slope * e
    assert abs(p @ w) <= e * (np.linalg.norm(p) + np.linalg.norm(w) + e)


@given(st.floats(0.1, 10.0), st.floats(-np.pi, np.pi), st.floats(0.1, 3.0), st.floats(1e-3, 1.0))
def test_the_residual_sees_each_way_of_breaking_the_law(normal: float, angle: float, mu: float, amount: float) -> None:
    """Pulling, leaving the cone, moving inwards, impulse at an open contact, slip inside the cone, and slip along its friction."""
    axis, direction = np.array([1.0, 0.0, 0.0]), np.array([0.0, np.cos(angle), np.sin(angle)])
    edge, still = normal * (axis + mu * direction), np.zeros(3)
    broken = [
        (-amount * axis, still),
        (edge + amount * direction, still),
        (edge, -amount * axis),
        (normal * axis, amount * axis),
        (normal * axis, amount * direction),
        (edge, amount * direction),
    ]
    for p, u in broken:
        assert residual(p, u, mu) >= 0.05 * min(amount, normal, mu * normal, mu * amount)
