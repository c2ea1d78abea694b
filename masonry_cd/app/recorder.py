# SPDX-License-Identifier: GPL-3.0-or-later
"""Records of a run: scalars of every step, frames now and then, peaks of the joints, shocks."""

from __future__ import annotations

from typing import Any

import numpy as np

from masonry_cd.analysis.damage.step_peaks import StepPeaks
from masonry_cd.app.gauge_rows import GaugeRows
from masonry_cd.app.measured_joints import MeasuredJoints
from masonry_cd.app.pair_joints import PairJoints
from masonry_cd.app.per_step import QUANTITIES, MadeStep
from masonry_cd.app.staying_support import staying_support
from masonry_cd.app.step_contacts import contacts_of, reactions_of
from masonry_cd.io.block_arrays import Meshes
from masonry_cd.io.gauges import Gauges
from masonry_cd.io.layout import (
    BONDED,
    CLOSING,
    EDGE_STRESS,
    ELEMENT_STRESS,
    FORCE,
    GRADIENT,
    JOINT_PEAKS,
    MEAN_NORMAL_FORCE,
    NODE_DISPLACEMENT,
    PRESENT,
    REACTION,
    SHOCK_PEAKS,
    STRESS,
)
from masonry_cd.io.result_writer import ResultWriter
from masonry_cd.mechanics.dynamics.mean_stress import MeanStress
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper, StepReport
from masonry_cd.mechanics.dynamics.pauses import Aftermath
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.edge_stress import edge_stresses
from masonry_cd.mechanics.model.joints import JointMeasures, JointPeaks, Joints

ROWS_AT_ONCE = 256  # steps whose numbers are handed to the writer together
NAME_BYTES = 160  # of a shock, in UTF-8: 40 letters of any script


class Recorder:
    """Writes what the run yields: scalars of every step, frames at the chosen rate, peaks of the joints; where it is requested, stress.

    Args:
        writer: of the result file.
        stepper: at the start of the run.
        joints: of its assembly at rest.
        shocks: the loads come as shocks in a row.
        stress: keep the stress of blocks and joints.
        gauges: what is kept in every step besides.
        reported: the blocks as results have them, those that are released free; None: those of the stepper.
        changes: blocks may come and go.
    """

    def __init__(
        self,
        writer: ResultWriter,
        stepper: Stepper,
        joints: Joints,
        shocks: bool = False,
        stress: bool = False,
        gauges: Gauges | None = None,
        reported: Assembly | None = None,
        changes: bool = False,
    ) -> None:
        self._writer, self._stepper, self._joints, self._changes = writer, stepper, joints, changes
        self._reported = stepper.assembly if reported is None else reported
        self.measured = MeasuredJoints(stepper, joints, changes)
        self.frames = 0
        self.peaks = JointPeaks(joints)
        self.stress = MeanStress(stepper, joints) if stress else None
        velocity, tick = stepper.system.loads.support_velocity, stepper.settings.dt
        support = staying_support(stepper.assembly, velocity, tick, joints, self._reported.fixed)
        self.step_peaks = StepPeaks(self._reported, joints, support)
        writer.begin_step_peaks(self.step_peaks.arrays, support)
        meshes = Meshes.of(stepper.assembly, stepper.system.strains) if stress else None
        self._meshed = meshes is not None
        if meshes is not None:
            writer.begin_meshes(meshes)
        self._rows: list[tuple[float, ...]] = []  # of steps, not yet with the writer
        self._tensions: list[np.ndarray] = []  # likewise
        self._pair_joints = PairJoints(stepper.assembly)
        self._quantities = dict(QUANTITIES)
        writer.extend({name: np.empty(0) for name in self._quantities})  # every dataset exists before the first flush
        if len(stepper.tensions):
            writer.extend({"ties/tension": np.empty((0, len(stepper.tensions)))})
        self._gauges = None if gauges is None or not gauges.any else GaugeRows(gauges, stepper, joints, support)
        if self._gauges is not None:
            writer.extend(self._gauges.empty())
        writer.extend({CLOSING: np.empty(0, dtype=np.uint8)})
        if shocks:
            writer.extend({f"shocks/{name}": rows[:0] for name, rows in self._aftermath(Aftermath("", 0.0, 0.0, 0)).items()})

    def step(self, report: StepReport, load_step: int) -> JointMeasures:
        """Record a step, which applied a step of the loads; return the measures of the joints after it."""
        stepper = self._stepper
        made = MadeStep(stepper, report, load_step)
        self._rows.append(tuple(quantity.value(made) for quantity in self._quantities.values()))
        self._tensions.append(stepper.tensions)
        now = self.now()
        if self._gauges is not None:
            self._gauges.step(now, self._joint_of_pairs())
        if len(self._rows) == ROWS_AT_ONCE:
            self._to_writer()
        self.peaks.update(now, stepper.state.time)
        self.step_peaks.update(now, stepper.state)
        if self.stress is not None:
            self.stress.take_step(self._joint_of_pairs())
        return now

    @property
    def blocks(self) -> tuple[Block, ...]:
        """As results have them."""
        return self._reported.blocks

    def now(self) -> JointMeasures:
        """The measures of the joints."""
        return self.measured.now()

    def write_frame(self, now: JointMeasures) -> None:
        """Write the state and the joints."""
        rows, of_laws = frame_rows(self._stepper, self._joints, now, self._joint_of_pairs(), self._reported.fixed)
        self._writer.append(rows)
        self._writer.append({f"joints/{name}": values for name, values in of_laws.items()})
        if self._changes:
            absent = self._stepper.assembly.absent
            self._writer.append({PRESENT: np.ones(self._stepper.assembly.count, dtype=bool) if absent is None else ~absent})
        if self.stress is not None:
            self._write_stress_frame(self.stress, of_laws.get(BONDED, np.zeros(self._joints.count)) > 0.0)
        self.frames += 1

    def _write_stress_frame(self, stress: MeanStress, bonded: np.ndarray) -> None:
        """Write the stress since the last frame; ``bonded`` (J,) are joints that carry tension."""
        force, moment = stress.joint_forces()
        edge = edge_stresses(self._joints, self._stepper.assembly, self._stepper.state, force, moment, bonded)
        own = {f"joints/{MEAN_NORMAL_FORCE}": force, f"joints/{EDGE_STRESS}": edge}
        self._writer.append({STRESS: stress.stresses()} | own)
        if self._meshed:
            of_meshes = {NODE_DISPLACEMENT: stress.node_displacements(), ELEMENT_STRESS: stress.of_elements()}
            self._writer.append({name: values.astype(np.float32) for name, values in of_meshes.items()})
        stress.begin()

    def write_shock(self, shock: Aftermath) -> None:
        """Write when a shock acted, the frame at the end of its rest, and the peaks of the joints so far."""
        self._writer.extend({f"shocks/{name}": rows for name, rows in self._aftermath(shock).items()})

    def _aftermath(self, shock: Aftermath) -> dict[str, np.ndarray]:
        """A row of each dataset of /shocks."""
        row: dict[str, Any] = {"start": shock.start, "end": shock.end, "frame": shock.frame}
        row |= {name: getattr(self.peaks, name) for name in JOINT_PEAKS}
        row |= {f"peaks/{name}": self.step_peaks.arrays[name] for name in SHOCK_PEAKS}
        name = np.array([shock.name.encode()], dtype=f"S{NAME_BYTES}")
        return {"name": name} | {key: np.asarray(value)[None] for key, value in row.items()}

    def flushed_rows(self) -> tuple[dict[str, int], str]:
        """Write all that waits, and the peaks, to the disc; return how many rows each dataset now has, and their mark."""
        self.close()
        self._writer.sync()
        return self._writer.rows(), self._writer.mark()

    def close(self) -> None:
        """Write the peaks and what waits in the buffers."""
        self._to_writer()
        self._writer.flush()
        self._writer.write_peaks({name: getattr(self.peaks, name) for name in JOINT_PEAKS}, self.step_peaks.arrays)

    def _to_writer(self) -> None:
        """Give the numbers of the last steps to the writer."""
        if self._rows:
            self._writer.extend(dict(zip(self._quantities, np.array(self._rows).T, strict=True)))
            if len(self._tensions[0]):
                self._writer.extend({"ties/tension": np.array(self._tensions)})
            if self._gauges is not None:
                self._writer.extend(self._gauges.take())
            self._rows.clear()
            self._tensions.clear()

    def _joint_of_pairs(self) -> np.ndarray:
        """The joint of each pair of the detector, -1 for pairs that are none."""
        return self._pair_joints.of(self._stepper.detector.pairs)


def frame_rows(
    stepper: Stepper, joints: Joints, now: JointMeasures, pair_joint: np.ndarray, supports: np.ndarray
) -> tuple[dict[str, np.ndarray | float], dict[str, np.ndarray]]:
    """Return a frame: the state, joints and supports by the names of datasets, and the memory (J,) of joint laws by its own names.

    Args:
        stepper: after a step, or at the start.
        joints: as built.
        now: their measures.
        pair_joint: (P,) the joint of each pair of the detector, -1 for pairs that are none.
        supports: (B,) bool: blocks whose reactions are kept.
    """
    state, deformation = stepper.state, stepper.assembly.deformation
    rows: dict[str, np.ndarray | float] = {"time": state.time}
    rows |= {"position": state.position, "orientation": state.orientation, "velocity": state.velocity}
    if deformation is not None:
        rows[GRADIENT] = deformation.gradients(state.strain)
    rows |= {f"joints/{name}": getattr(now, name) for name in ("opening", "sliding", "rotation", "contact_area")}
    force, point = stepper.joint_forces(pair_joint, joints.count)
    rows |= {"joints/normal_force": force[0], "joints/shear_force": force[1], "joints/force_point": point}
    contacts = contacts_of(stepper, pair_joint)
    rows |= {f"joints/{FORCE}": contacts.of_joints(joints.count), REACTION: reactions_of(stepper, contacts)[supports]}
    return rows, stepper.joint_histories(pair_joint, joints)
