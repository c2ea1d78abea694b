# SPDX-License-Identifier: GPL-3.0-or-later
r"""The steps of LMGC90 judged by our measure: its contacts and reactions put into a friction problem of ours.

The friction problem of a step (see ``masonry_cd.mechanics.friction.problem``) needs the velocities at its start. LMGC90's wheel does not
give them, but its positions do, from rest on:

    x+ = x + h (1 - theta) v + h theta v+      =>      v+ = ((x+ - x) / h - (1 - theta) v) / theta,

and likewise for rotations. Contact points, axes and forces are LMGC90's own; masses and inertias ours. Its contacts are those of the
configuration q_m = q + h (1 - theta) v.

**Two errors.** Given impulses p, the motion follows: u = W p + q, and so the error is measured, for LMGC90 as for us. LMGC90 also reports
local velocities of its own. They date from the sweep, are not those of the motion (the bodies move on with the former, which
the check shows), and often look better; the error with them in place of u is given next to it.

**Check.** Velocities and reactions were found apart, so M (v+ - v_free) = H^T p shows whether all was read rightly; the largest
relative residual is returned too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.spatial.transform import Rotation

from benchmarks.scenes import GRAVITY, BenchScene
from masonry_cd.mechanics.friction.contact_geometry import Geometry
from masonry_cd.mechanics.friction.law_terms import error_norms
from masonry_cd.mechanics.friction.problem import FrictionProblem, LocalProblem, natural_map_error


@dataclass(frozen=True)
class Judged:
    """Natural map errors of the sampled steps, and how badly LMGC90's motion and reactions disagree."""

    errors: np.ndarray  # (K,) scaled, u = W p + q
    own: np.ndarray  # (K,) scaled, u as LMGC90 reports it
    residual: float  # largest |M (v+ - v_free) - H^T p| over |H^T p|


def judge(scene: BenchScene, result: dict[str, np.ndarray]) -> Judged:
    """Measure the sampled steps of a result of ``lmgc90.py``."""
    assembly = scene.assembly()
    turn = np.einsum("kbji,bjl->kbil", result["axes"], result["axes"][0])  # (N + 1, B, 3, 3) body to world
    linear, angular = _velocities(result["position"], turn, scene.dt, scene.theta)
    errors, own, residuals = [], [], []
    for k in result["sampled"]:
        old, half = k - 1, scene.dt * (1.0 - scene.theta)
        position = result["position"][old] + half * linear[old]
        rotation = Rotation.from_rotvec(half * angular[old]).as_matrix() @ turn[old]
        inertia = rotation @ assembly.inertia @ rotation.transpose(0, 2, 1)
        velocity = np.concatenate([linear, angular], axis=2)
        found = {name: result[f"{name}_{k}"] for name in ("icdbdy", "ianbdy", "coor", "uc", "rloc", "vloc", "gap")}
        problem, impulse = _problem(scene, found, position, inertia, assembly.mass, assembly.fixed, velocity[old], velocity[k])
        errors.append(natural_map_error(problem, impulse))
        own.append(_own_error(problem, impulse, found, scene.dt))
        residuals.append(_residual(problem, impulse, velocity[k][~assembly.fixed]))
    return Judged(np.array(errors), np.array(own), max(residuals))


def _velocities(position: np.ndarray, turn: np.ndarray, dt: float, theta: float) -> tuple[np.ndarray, np.ndarray]:
    """Linear and angular velocities (N + 1, B, 3) at the ends of the steps of a motion from rest."""
    linear, angular = np.zeros_like(position), np.zeros_like(position)
    for k in range(1, len(position)):
        spin = Rotation.from_matrix(turn[k] @ turn[k - 1].transpose(0, 2, 1)).as_rotvec()
        linear[k] = ((position[k] - position[k - 1]) / dt - (1.0 - theta) * linear[k - 1]) / theta
        angular[k] = (spin / dt - (1.0 - theta) * angular[k - 1]) / theta
    return linear, angular


def _problem(
    scene: BenchScene,
    found: dict[str, np.ndarray],
    position: np.ndarray,
    inertia: np.ndarray,
    mass: np.ndarray,
    fixed: np.ndarray,
    old: np.ndarray,
    new: np.ndarray,
) -> tuple[FrictionProblem, np.ndarray]:
    """The friction problem at q_m and LMGC90's impulses (C, 3), rows (n, t, s)."""
    blocks = np.stack([found["icdbdy"], found["ianbdy"]], axis=1).astype(np.int64) - 1
    frame = found["uc"].reshape(-1, 3, 3)[:, [1, 0, 2]]  # (C, 3 rows, 3): t, n, s -> n, t, s
    jacobian = Geometry.by_arms(frame, found["coor"][:, None] - position[blocks]).rows(blocks)
    offset = np.zeros((len(blocks), 3))
    offset[:, 0] = np.maximum(found["gap"].ravel(), 0.0) / scene.dt
    for side in range(2):
        driven = fixed[blocks[:, side]]
        offset[driven] += np.einsum("cij,cj->ci", jacobian[driven, side], new[blocks[driven, side]])
    inverse_mass = np.zeros((int((~fixed).sum()), 6, 6))
    inverse_mass[:, :3, :3] = np.eye(3) / mass[~fixed, None, None]
    inverse_mass[:, 3:, 3:] = np.linalg.inv(inertia[~fixed])
    v_free = old[~fixed] + scene.dt * np.array([0.0, 0.0, -GRAVITY, 0.0, 0.0, 0.0])
    number = np.where(fixed, -1, np.cumsum(~fixed) - 1)
    mu = np.full(len(blocks), scene.friction)
    problem = FrictionProblem(inverse_mass, v_free, number[blocks], Geometry.by_rows(jacobian), offset, mu, np.zeros_like(offset))
    return problem, scene.dt * found["rloc"][:, [1, 0, 2]]


def _own_error(problem: FrictionProblem, impulse: np.ndarray, found: dict[str, np.ndarray], dt: float) -> float:
    """The natural map error with LMGC90's local velocities."""
    u = np.ascontiguousarray(found["vloc"][:, [1, 0, 2]])
    u[:, 0] += np.maximum(found["gap"].ravel(), 0.0) / dt
    scale = problem.arrays().d
    seen = LocalProblem(sparse.diags(np.repeat(scale, 3)).tocsr(), u - scale[:, None] * impulse, problem.mu)  # it has these velocities
    residual, _ = error_norms(seen.arrays(), impulse)
    _, size = error_norms(problem.arrays(), impulse)
    return float(residual / size)


def _residual(problem: FrictionProblem, impulse: np.ndarray, velocity: np.ndarray) -> float:
    """How far the velocities (B, 6) that were seen are from those that the impulses make, relative to what the impulses do."""
    made = problem.body_velocity(impulse)
    return float(np.linalg.norm(velocity - made) / np.linalg.norm(made - problem.v_free))
