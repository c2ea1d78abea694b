# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows of the gauges that a run keeps in every step, see :mod:`masonry_cd.io.gauges`."""

from __future__ import annotations

import numpy as np

from masonry_cd.app.step_contacts import contacts_of, reactions_of
from masonry_cd.io.gauges import Gauges
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.model.joints import JointMeasures, Joints
from masonry_cd.mechanics.model.state import rotation_matrices


class GaugeRows:
    """The rows of steps that have not gone to the writer yet.

    Args:
        gauges: of the run.
        stepper: at its start.
        joints: at rest.
        support: to which displacements are relative, -1 without one.
    """

    def __init__(self, gauges: Gauges, stepper: Stepper, joints: Joints, support: int) -> None:
        self.gauges, self._stepper, self._joints, self._support = gauges, stepper, joints, support
        self._rows: dict[str, list[np.ndarray]] = {name: [] for name in self.empty()}
        centre = stepper.assembly.centre
        block, place = [g.block for g in gauges.points], np.array([g.place for g in gauges.points]).reshape(-1, 3)
        ends = np.array([g.blocks for g in gauges.cracks], dtype=np.int64).reshape(-1, 2)
        self._points = np.array(block, dtype=np.int64), place
        self._cracks = ends, np.array([g.points for g in gauges.cracks]).reshape(-1, 2, 3)
        self._arms = place - centre[self._points[0]], self._cracks[1] - centre[ends]

    def empty(self) -> dict[str, np.ndarray]:
        """No rows of each dataset."""
        g, made = self.gauges, dict[str, np.ndarray]()
        if g.guides:
            made |= {f"guides/{name}": np.empty((0, len(g.guides))) for name in ("force", "moment", "displacement", "momentum")}
        if g.points:
            made |= {"gauges/points": np.empty((0, len(g.points), 6)), "gauges/base": np.empty((0, 6))}
        if g.joints:
            made["gauges/joints"] = np.empty((0, len(g.joints), 8))
        if g.cracks:
            made["gauges/cracks"] = np.empty((0, len(g.cracks), 3))
        if g.supports:
            made["gauges/supports"] = np.empty((0, len(g.supports), 3))
        return made

    def step(self, now: JointMeasures, joint_of_pairs: np.ndarray) -> None:
        """Take a step, after which the joints measure ``now``; ``joint_of_pairs`` names the joint of each pair or -1."""
        g, stepper = self.gauges, self._stepper
        if g.guides:
            for name, values in stepper.driven()._asdict().items():
                self._rows[f"guides/{name}"].append(values)
        if g.points or g.cracks:
            self._moved()
        if g.joints:
            self._rows["gauges/joints"].append(self._of_joints(now, joint_of_pairs))
        if g.supports:
            reactions = reactions_of(stepper, contacts_of(stepper, joint_of_pairs))
            self._rows["gauges/supports"].append(reactions[[s.block for s in g.supports], :3])

    def take(self) -> dict[str, np.ndarray]:
        """The rows, which are forgotten here."""
        found = {name: np.array(rows) for name, rows in self._rows.items() if rows}
        for rows in self._rows.values():
            rows.clear()
        return found

    def _moved(self) -> None:
        """How points and cracks have moved."""
        state, centre = self._stepper.state, self._stepper.assembly.centre
        rotation = rotation_matrices(state.orientation)
        if self.gauges.points:
            block, place = self._points
            arm = np.sum(rotation[block] * self._arms[0][:, None, :], axis=-1)
            gone, velocity = state.position[block] + arm - place, state.velocity[block]
            speed = velocity[:, :3] + np.cross(velocity[:, 3:], arm)
            self._rows["gauges/points"].append(np.concatenate([gone, speed], axis=1))
            base = np.zeros(6)
            if self._support >= 0:
                base[:3] = state.position[self._support] - centre[self._support]
                base[3:] = state.velocity[self._support, :3]
            self._rows["gauges/base"].append(base)
        if self.gauges.cracks:
            ends, places = self._cracks
            arm = np.sum(rotation[ends] * self._arms[1][..., None, :], axis=-1)
            gone = state.position[ends] + arm - places
            self._rows["gauges/cracks"].append(gone[:, 1] - gone[:, 0])

    def _of_joints(self, now: JointMeasures, joint_of_pairs: np.ndarray) -> np.ndarray:
        """(Q, 8)."""
        joints = self._joints
        force, point = self._stepper.joint_forces(joint_of_pairs, joints.count)
        out = np.zeros((len(self.gauges.joints), 8))
        for row, gauge in zip(out, self.gauges.joints, strict=True):
            j = gauge.joint
            row[0], row[1], row[2], row[3] = now.opening[j], now.sliding[j], force[0, j], force[1, j]
            if force[0, j] != 0.0:
                polygon = joints.polygon[joints.polygon_start[j] : joints.polygon_start[j + 1]]
                row[4:7], row[7] = _bending(polygon, joints.normal[j], force[0, j], self._as_built(j, point[j]))
        return out

    def _as_built(self, j: int, place: np.ndarray) -> np.ndarray:
        """A place (3,) seen by the first block of a joint as it was built [m]."""
        state, b = self._stepper.state, int(self._joints.block_a[j])
        rotation = rotation_matrices(state.orientation[b : b + 1])[0]
        return np.asarray(np.sum(rotation * (place - state.position[b])[:, None], axis=0) + self._stepper.assembly.centre[b])


def _bending(polygon: np.ndarray, normal: np.ndarray, force: float, place: np.ndarray) -> tuple[np.ndarray, float]:
    """Moment (3,) of a normal force about the middle of a joint [N m], and the depth that it compresses [m].

    The depth is that of a linear pressure without tension: three times the distance of the force from the edge that it is nearest to along
    its eccentricity, at most the depth of the joint there. Polygon (n, 3), place (3,) [m].
    """
    middle = polygon.mean(axis=0)
    arm = place - middle
    arm = arm - np.sum(arm * normal) * normal
    far = float(np.sqrt(np.sum(arm * arm)))
    extent = np.sum((polygon - middle) * (arm / far if far > 0.0 else polygon[1] - polygon[0]), axis=1)
    depth = float(extent.max() - extent.min())
    if far == 0.0:
        return np.zeros(3), depth / float(np.sqrt(((polygon[1] - polygon[0]) ** 2).sum()))
    return np.cross(arm, normal) * force, min(depth, 3.0 * max(float(extent.max()) - far, 0.0))
