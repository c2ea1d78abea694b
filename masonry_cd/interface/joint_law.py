# SPDX-License-Identifier: GPL-3.0-or-later
r"""Own joint laws: stresses in the joints as built, by a function of their openings, slips and history.

Each joint has an integration point per corner of its polygon, drawn in towards the centroid so that the points have the second moment of
the area: exact for rectangles and triangles, with equal shares of the area. At the middle of a step, with d the vector from where block a
carries a point to where block b does, and n, t1, t2 carried by a,

    opening = d . n,      slip = (d . t1, d . t2),      force on b = - A_k (s_n n + s_1 t1 + s_2 t2),

the stresses s from the law, tension positive. The opposite acts on a at the same place, so momentum is kept.

**Limits.** The law comes on top of contact and friction, which stay: it can bind, drag, damp and soften, and cannot make a joint shorten.
It acts on joints as built, wherever their blocks go, and from the first step on: elastic joints settle without it. It is explicit: with the
largest stiffness k of the law, a step is refused that is longer than

    2 / omega,      omega^2 = 2 max over the blocks of the sum over their points of k A_k (1 / m + r_k^2 / I_least).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.plugins import CALLED, find
from masonry_cd.foundation.signatures import require_call
from masonry_cd.interface.own_forces import Now, Pushes, Pushing
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints

Law = Callable[[np.ndarray, np.ndarray, np.ndarray, float, np.ndarray], Any]


@dataclass(frozen=True)
class JointLaw:
    """A law of the joints, for ``mc.Simulation(scene, law=...)``; see the head of this file for what it can do and what it cannot.

    Attributes:
        function: ``f(opening, slip, history, step, stress)`` over K points at once: openings (K,) [m], slips (K, 2) [m], history (K, H),
            which it may change, and the length of the step [s]; it fills the stresses (K, 3), normal and along both axes [Pa]. Compiled by
            ``numba.njit`` it loops over the points as fast as the program itself.
        stiffness: the largest that the law has anywhere [Pa/m]; the time step is judged by it.
        history: H, numbers that a point remembers; zero at the start.
        joints: numbers of the joints that have the law; all of them when not given.
    """

    function: Law
    stiffness: float
    history: int = 0
    joints: Sequence[int] | None = None


def law_of(given: JointLaw | str) -> JointLaw:
    """A law, or that of an installed package by its name.

    Raises:
        InputError: no package has it, or what it has is not a law.
    """
    found = find("joint_laws", given, "law", {}) if isinstance(given, str) else given
    if not isinstance(found, JointLaw):
        raise InputError("law", f"a JointLaw is needed, or the name of one that a package adds; got a {type(found).__name__}")
    return found


class BoundLaw(Pushing):
    """A law on the joints of an assembly, with what its points remember.

    Raises:
        InputError: no function, a joint that there is none of, or a time step that is too long.
    """

    keeps_plane = True  # as the joints do: what leads out of it cancels between mirror images

    def __init__(self, law: JointLaw, joints: Joints, assembly: Assembly, longest: float) -> None:
        require_call(law.function, CALLED["joint_laws"]["function"], "law", "law")
        if not law.stiffness > 0.0 or law.history < 0:
            raise InputError("law", "a stiffness above zero [Pa/m] and a history of 0 numbers or more are needed")
        chosen = np.arange(joints.count) if law.joints is None else np.unique(np.asarray(law.joints, dtype=np.int64))
        if len(chosen) and not 0 <= chosen.min() <= chosen.max() < joints.count:
            raise InputError("law.joints", f"there are joints 0 to {joints.count - 1}")
        self._law, self._absent = law, assembly.absent
        self._place(joints, chosen, assembly)
        self.history = np.zeros((len(self._area), law.history))
        self._trial = self.history
        self._check_step(assembly, longest)

    def _place(self, joints: Joints, chosen: np.ndarray, assembly: Assembly) -> None:
        """The points of the chosen joints, seen from both blocks, their shares of the area, and their axes."""
        places, areas, axes, of = [np.zeros((0, 3))], [np.zeros(0)], [np.zeros((0, 3, 3))], [np.zeros(0, dtype=np.int64)]
        for j in chosen.tolist():
            corners = joints.polygon[joints.polygon_start[j] : joints.polygon_start[j + 1]]
            points = integration_points(corners, joints.normal[j])
            first = corners[1] - corners[0]
            t1 = first / np.sqrt(np.sum(first * first))
            frame = np.stack([joints.normal[j], t1, np.cross(joints.normal[j], t1)])
            places.append(points)
            areas.append(np.full(len(points), joints.area[j] / len(points)))
            axes.append(np.broadcast_to(frame, (len(points), 3, 3)))
            of.append(np.full(len(points), j))
        place, joint = np.concatenate(places), np.concatenate(of)
        self._area, self._axes = np.concatenate(areas), np.concatenate(axes)
        self._a, self._b = joints.block_a[joint], joints.block_b[joint]
        self._on_a, self._on_b = place - assembly.centre[self._a], place - assembly.centre[self._b]

    def _check_step(self, assembly: Assembly, longest: float) -> None:
        """Refuse a step that the law makes unstable."""
        least = np.linalg.eigvalsh(assembly.inertia)[:, 0]
        total = np.zeros(assembly.count)
        for block, arm in ((self._a, self._on_a), (self._b, self._on_b)):
            np.add.at(total, block, self._law.stiffness * self._area * (1.0 / assembly.mass[block] + (arm**2).sum(axis=1) / least[block]))
        omega = float(np.sqrt(2.0 * total[~assembly.fixed].max(initial=0.0)))
        if omega * longest > 2.0:
            raise InputError(
                "law", f"run.dt {longest:g} s is too long for a stiffness of {self._law.stiffness:g} Pa/m; use at most {2.0 / omega:.2g} s"
            )

    def pushes(self, now: Now) -> Pushes:
        """The forces of the joints at the places of now.

        Raises:
            InputError: stresses that are not finite.
        """
        on_a, on_b = (np.einsum("kij,kj->ki", now.rotation[block], arm) for block, arm in ((self._a, self._on_a), (self._b, self._on_b)))
        at_a, at_b = now.position[self._a] + on_a, now.position[self._b] + on_b
        axes = np.einsum("kij,kaj->kai", now.rotation[self._a], self._axes)
        apart = np.einsum("kai,ki->ka", axes, at_b - at_a)
        stress, self._trial = np.zeros((len(self._area), 3)), self.history.copy()
        self._law.function(np.ascontiguousarray(apart[:, 0]), np.ascontiguousarray(apart[:, 1:]), self._trial, now.step, stress)
        if not np.isfinite(stress).all():
            raise InputError("law", f"at {now.time:g} s its stresses are not finite")
        force = -self._area[:, None] * np.einsum("ka,kai->ki", stress, axes)
        if self._absent is not None:
            force[self._absent[self._a] | self._absent[self._b]] = 0.0
        middle = 0.5 * (at_a + at_b)
        block, arms = np.concatenate([self._b, self._a]), np.concatenate([middle - now.position[self._b], middle - now.position[self._a]])
        every = np.concatenate([force, -force])
        return Pushes(block, every, arms)

    def update_blocks(self, absent: np.ndarray | None) -> None:
        """Joints of blocks that are absent, (B,) bool, carry nothing; None: all are there."""
        self._absent = absent

    def taken(self) -> None:
        """Accept the histories of the points: the last requested step was made."""
        self.history = self._trial

    def copied(self) -> BoundLaw:
        """A copy with the same history, independent of this one."""
        other = BoundLaw.__new__(BoundLaw)
        other.__dict__.update(self.__dict__)
        other.history = self.history.copy()
        return other


def integration_points(corners: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """A point for each corner (N, 3) of a flat polygon, about its centroid, with the polar second moment of its area."""
    middle = corners.mean(axis=0)
    area, centre, polar = 0.0, np.zeros(3), 0.0
    for k in range(len(corners)):
        p, q = corners[k] - middle, corners[(k + 1) % len(corners)] - middle
        piece = 0.5 * float(np.sum(normal * np.cross(p, q)))
        area, centre = area + piece, centre + piece * (p + q) / 3.0
        polar += piece / 6.0 * float(np.sum(p * p) + np.sum(q * q) + np.sum(p * q))
    centre = centre / area
    polar = polar / area - float(np.sum(centre * centre))
    arms = corners - middle
    return np.asarray(middle + centre + np.sqrt(polar / float((arms * arms).sum(axis=1).mean())) * arms)
