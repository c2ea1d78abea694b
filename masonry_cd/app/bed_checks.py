# SPDX-License-Identifier: GPL-3.0-or-later
r"""How little of elastic joints carries once they are open, and whether their points resolve it; where not, a run says so.

A rectangular bed of area A without tension, open by o at its far edge under a force N, touches over the share s of its depth, for which

    s^2 / (1 - s) = 2 N / (k_n A o),

and has its force s / 3 of the depth inside its edge. Below the share that ``joint_points`` resolve (``resolved_share``) the outermost
point carries alone, with the force at the very edge: the joint is too strong by about 2 s / 3, an arch as one that is thicker.

Every joint that opens passes through such shares. What counts is where it stays: a joint is looked at while it is at least WIDE of as open
as it gets, and bears what makes its points matter. Below MATTERS the edge is as good as the bed, as in all joints that are stiff.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.io.results import Results
from masonry_cd.io.summary_tables import Beds
from masonry_cd.mechanics.contact.joint_points import GRAVITY, LIGHT, MOST, resolved_share
from masonry_cd.mechanics.dynamics.pair_stiffness import stiffness_of_joints
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import OPENED

WIDE = 0.5  # of the largest opening of a joint, from which on it is looked at
MATTERS = 0.03  # share of the depth in contact below which a force at the very edge changes a joint's moment by less than 2 %


def beds(assembly: Assembly, results: Results) -> Beds | None:
    """How open elastic joints were resolved, for the summary; None where no joint is elastic."""
    joints, law = results.joints, assembly.laws
    stiffness, _ = stiffness_of_joints(assembly, joints)
    by_points = np.flatnonzero((stiffness > 0.0) & ~_meshed(assembly)[np.stack([joints.block_a, joints.block_b])].any(axis=0))
    if not len(by_points):
        return None
    points = law.points[assembly.rows(joints.block_a, joints.block_b)][by_points].astype(int)
    resolved = np.array([resolved_share(n) for n in range(3, MOST + 1, 2)])[(points - 3) // 2]
    opening, force = (results.joint_history(name)[:, by_points] for name in ("opening", "normal_force"))
    share = touching_share(force, stiffness[by_points] * joints.area[by_points] * opening)
    weight = np.where(assembly.fixed, np.inf, GRAVITY * assembly.mass)
    bears = force >= LIGHT * np.minimum(weight[joints.block_a], weight[joints.block_b])[by_points]
    seen = bears & (opening >= np.maximum(OPENED, WIDE * opening.max(axis=0, initial=0.0)))
    coarse = np.where(seen & (share < resolved) & (share > MATTERS), share, 0.0).max(axis=0, initial=0.0)
    least, unresolved = float(share[seen].min()) if seen.any() else None, int((coarse > 0.0).sum())
    if not unresolved:
        return Beds(share_least=least, unresolved=0)
    worst = int(coarse.argmax())
    ends = (assembly.names[block[by_points[worst]]] for block in (joints.block_a, joints.block_b))
    where = " - ".join(f'"{name}"' for name in ends)
    return Beds(
        share_least=least,
        unresolved=unresolved,
        share=float(coarse[worst]),
        points=int(points[worst]),
        resolved=float(resolved[worst]),
        where=where,
    )


def touching_share(force: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    """The share s of the depth over which beds touch, by their normal force [N] and k_n A o [N]; see the head of this file."""
    with np.errstate(divide="ignore", invalid="ignore"):
        share = 2.0 / (1.0 + np.sqrt(1.0 + 2.0 * stiffness / np.maximum(force, 0.0)))
    return np.where(force > 0.0, share, 0.0)


def _meshed(assembly: Assembly) -> np.ndarray:
    """(B,) True of blocks that are meshed, whose joints have the points of their facets."""
    out, own = np.zeros(assembly.count, dtype=bool), assembly.deformation
    if own is not None:
        out[own.block] = own.mesh_size > 0.0
    return out
