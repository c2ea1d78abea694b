# SPDX-License-Identifier: GPL-3.0-or-later
"""A run in the shapes of other programs: forces, lines of thrust, labelled arrays, meshes, traces."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from masonry_cd.analysis.damage.macro_elements import DamageSnapshot
from masonry_cd.analysis.deformed import Pose, solids_of
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.extras import require
from masonry_cd.interface.frames import JOINTS, REACTIONS, dataset
from masonry_cd.interface.open_run import OpenRun
from masonry_cd.interface.tables import columns_of, frame_of
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.state import rotation_matrices
from reports.maps.thrust import thrust_lines

if TYPE_CHECKING:
    from obspy import Stream
    from pandas import DataFrame
    from pyvista import PolyData
    from trimesh import Scene as TrimeshScene
    from xarray import Dataset

OLD = "this run was made before its forces were kept as vectors; run its scene again"
QUANTITIES = {"displacement": ("DISP", "m"), "velocity": ("VEL", "m/s")}  # of traces


class ThrustLine(NamedTuple):
    """The line of thrust at a time: a straight piece from the centre of each joint's pressure to where those of its block meet."""

    lines: np.ndarray  # (L, 2, 3) world frame [m]
    force: np.ndarray  # (L,) normal force of the joint [N]
    joint: np.ndarray  # (L,) number of the joint
    block: np.ndarray  # (L,) number of the block that the piece is in


class RunExports(OpenRun):
    """Exports of a run; ``time`` picks the frame next to it [s], the last one where none is given."""

    def joint_forces(self, time: float | None = None) -> DataFrame:
        """A row per joint: the force on its block b, fx, fy, fz [N], of which the opposite acts on block a, and where it acts, x, y, z [m].

        Means over the step before the frame; places are NaN where a joint has no force.

        Raises:
            InputError: a time outside the run, or a run of an older version.
        """
        with self._at(time) as (found, frame):
            if not found.has_joint_history("force"):
                raise InputError("joint_forces", f"{OLD}")
            names = np.array(self.structure.names, dtype=object)
            columns = {
                "block_a": names[found.joints.block_a],
                "block_b": names[found.joints.block_b],
                **columns_of(REACTIONS[:3], found.joints_at("force", frame)),
                **columns_of("xyz", found.joints_at("force_point", frame)),
            }
            return frame_of(columns, np.arange(found.joints.count), "joint", time=float(found.time[frame]))

    def reactions(self, time: float | None = None) -> DataFrame:
        """A row per support: its force fx, fy, fz [N] and moment mx, my, mz about its centre of mass [N m] on what it carries.

        Raises:
            InputError: as :meth:`joint_forces`.
        """
        with self._at(time) as (found, frame):
            every = found.reaction
            if every is None:
                raise InputError("reactions", f"{OLD}")
            names = [block.name for block in found.blocks if block.fixed]
            return frame_of(columns_of(REACTIONS, every[frame]), names, "block", time=float(found.time[frame]))

    def thrust(self, time: float | None = None) -> ThrustLine:
        """The line of thrust, as a crack map with ``thrust`` draws it.

        Raises:
            InputError: a time outside the run.
        """
        with self._at(time) as (found, frame):
            solids = solids_of(found.blocks)
            apart = DamageSnapshot.at(found, frame, self._thresholds).separated
            force = np.where(apart, 0.0, found.joints_at("normal_force", frame))
            joints, place = found.joints, np.nan_to_num(found.joints_at("force_point", frame))
            lines, strength, joint, block = thrust_lines((joints.block_a, joints.block_b), place, force, solids)
            return ThrustLine(lines, strength, joint, block)

    def to_xarray(self) -> Dataset:
        """All frames as a Dataset of xarray over time, block, joint and support; each variable says its unit.

        Raises:
            InputError: xarray is not installed.
        """
        require("to_xarray", "xarray")
        with self.results() as found:
            return dataset(_arrays(found), found.blocks, found.joints, {"title": found.title, "scene": found.scene})

    def mesh(self, time: float | None = None) -> PolyData:
        """The faces of all blocks where they are at a time, a mesh of pyvista with the arrays that the files for ParaView have.

        Raises:
            InputError: a time outside the run, or pyvista is not installed.
        """
        require("mesh", "pyvista")
        from reports.paraview import blocks_as_polydata

        with self._at(time) as (found, frame):
            return blocks_as_polydata(found, frame, self._thresholds)

    def to_trimesh(self, time: float | None = None) -> TrimeshScene:
        """The blocks where they are at a time, a scene of trimesh with a mesh for each, by its name.

        Raises:
            InputError: a time outside the run, or trimesh is not installed.
        """
        require("to_trimesh", "trimesh")
        import trimesh

        with self._at(time) as (found, frame):
            solids = solids_of(found.blocks)
            points = _world(found, frame).moved(solids, solids.vertices, solids.vertex_block)
            made, there = trimesh.Scene(), found.present(frame)
            for b, block in [(b, block) for b, block in enumerate(found.blocks) if there[b]]:
                faces = [(loop[0], loop[k], loop[k + 1]) for loop in block.faces for k in range(1, len(loop) - 1)]
                mesh = trimesh.Trimesh(points[solids.vertex_block == b], faces, process=False)
                made.add_geometry(mesh, node_name=block.name, geom_name=block.name)
            return made

    def to_traces(self, block: str, quantity: str = "velocity") -> Stream:
        """How the centre of mass of a block moves, a Stream of obspy with traces X, Y and Z, a sample per frame.

        Args:
            block: its name.
            quantity: velocity [m/s], or displacement from where it was built [m]; of the ground outside, not relative to the base.

        Raises:
            InputError: no such block or quantity, frames that are not evenly spaced, or obspy is not installed.
        """
        require("to_traces", "obspy")
        from obspy import Stream, Trace, UTCDateTime

        if quantity not in QUANTITIES:
            raise InputError("to_traces", f'"{quantity}" is none; quantities: {", ".join(QUANTITIES)}')
        with self.results() as found:
            index, time = self.structure.index(block), self.time
            step = float(np.diff(time).mean()) if len(time) > 1 else 0.0
            even = len(time) > 1 and np.abs(np.diff(time)[:-1] - np.diff(time)[0]).max(initial=0.0) < 1e-6 * step
            if not even:
                raise InputError("to_traces", "the frames of this run are not evenly spaced in time")
            whole = len(time) if abs(time[-1] - time[-2] - (time[1] - time[0])) < 1e-6 * step else len(time) - 1
            if quantity == "velocity":
                values = np.asarray(found.velocity[:whole, index, :3], dtype=float)
            else:
                values = np.asarray(found.position[:whole, index], dtype=float) - solids_of(found.blocks).centre[index]
        header = {
            "delta": float(time[1] - time[0]),
            "station": block[:5],
            "starttime": UTCDateTime(float(time[0])),
            "processing": [f"masonry_cd: to_traces(quantity={quantity})"],  # by which from_traces knows what it is
        }
        return Stream([Trace(column.copy(), {**header, "channel": axis}) for axis, column in zip("XYZ", values.T, strict=True)])


def _world(found: Results, frame: int) -> Pose:
    """Where the blocks are in the world frame."""
    rotation = rotation_matrices(np.asarray(found.orientation[frame], dtype=float))
    return Pose(float(found.time[frame]), np.asarray(found.position[frame], dtype=float), rotation, found.gradient(frame))


def _arrays(found: Results) -> dict[str, np.ndarray]:
    """All frames of a run, by the names of VARIABLES."""
    made = {"time": found.time}
    made |= {name: np.asarray(getattr(found, name)[: found.frames]) for name in ("position", "orientation", "velocity")}
    made |= {name: found.joint_history(name) for name in JOINTS}
    if found.has_joint_history("force") and found.reaction is not None:
        made |= {"force": found.joint_history("force"), "reaction": np.asarray(found.reaction)}
    return made
