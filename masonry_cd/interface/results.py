# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs: what the folder of a run holds, as tables, arrays and pictures. Also of runs that were interrupted or killed, or are at work."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.analysis.damage.crack_pattern import VISIBLE, CrackAgreement, Polyline, agreement, cracked, joint_lines
from masonry_cd.analysis.damage.end_state import end_state
from masonry_cd.analysis.damage.joint_damage import joint_damage
from masonry_cd.analysis.damage.part_damage import PartDamage
from masonry_cd.analysis.deformed import base_at, solids_of
from masonry_cd.analysis.gauge_histories import unit_of_column
from masonry_cd.analysis.outputs.measured import Measured, damage_numbers
from masonry_cd.analysis.pushover import push_curves, require_pushes
from masonry_cd.app.closing_lines import closing_lines, damage_line
from masonry_cd.app.per_step import QUANTITIES
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.interface.plots import Plots
from masonry_cd.interface.returned import closing_as_html
from masonry_cd.interface.run_exports import RunExports
from masonry_cd.interface.run_stress import RunStress
from masonry_cd.interface.scenes import Scene, scene_of
from masonry_cd.interface.tables import columns_of, frame_of, frame_of_rows
from masonry_cd.io.summary import Summary, read_summary
from masonry_cd.mechanics.model.joint_laws import histories
from reports.damage import damage_of, damage_settings
from reports.laboratory import histories_of
from reports.page.motion import read_motion, rotation_vectors

if TYPE_CHECKING:
    from pandas import DataFrame

MEASURES = {  # of joints over time, and their units
    "opening": "m",
    "sliding": "m",
    "rotation": "rad",
    "contact_area": "m2",
    "normal_force": "N",
    "shear_force": "N",
    **{history.name: history.unit for history in histories()},
    "mean_normal_force": "N",
    "edge_stress": "Pa",
}
MOTIONS = ("ux", "uy", "uz", "rx", "ry", "rz")
VELOCITIES = ("vx", "vy", "vz", "wx", "wy", "wz")


class Run(RunExports, RunStress):
    """The results of a run, read from its folder on first use. Made by :func:`masonry_cd.run` and :func:`masonry_cd.open`.

    Tables are DataFrames of pandas with columns as in the CSV files; ``table.attrs["units"]`` says their units. ``print(run)`` shows the
    closing lines of the command line.
    """

    @cached_property
    def _summary(self) -> Summary:
        """Return the outcome of the run."""
        with self.results() as found:
            written = read_summary(self.folder) or found.closing or Summary()
            if written.has("joints_opened"):
                return written
            end = end_state(found, self._thresholds)
            numbers = damage_numbers(Measured(found, damage_settings(self._report)), end)
            return Summary(title=self.title, stopped=end.stopped) | written | numbers

    @cached_property
    def summary(self) -> dict[str, Any]:
        """Return the outcome of the run, as in summary.json; of a run that was killed, what its frames show.

        Raises:
            InputError: a file summary.json that is none.
        """
        return self._summary.as_dict()

    @property
    def stopped(self) -> str:
        """The reason why the run ended before its time; empty where it did not. :func:`masonry_cd.resume` continues it."""
        return self._summary.stopped

    @property
    def provisional(self) -> str:
        """The reason why residual values and grades are provisional; empty where the run ended at rest."""
        return self._summary.provisional

    @property
    def warnings(self) -> list[str]:
        """Warnings of the run, a line each."""
        return [*self._words, *self._summary.warnings]

    @cached_property
    def scene(self) -> Scene:
        """The scene that made the run."""
        with self.results() as found:
            return scene_of(found)

    @cached_property
    def damage(self) -> PartDamage:
        """The damage by part, from which the tables ``parts``, ``hinges``, ``levels`` and ``history`` are made."""
        with self.results() as found:
            return damage_of(found, self._report)

    @cached_property
    def joints(self) -> DataFrame:
        """A row per joint: its blocks, area, place x, y, z, the largest and the residual opening and sliding, state; as in joints.csv."""
        with self.results() as found:
            table = dict(vars(joint_damage(found, self._thresholds)))
            places = found.joints.centres()
        index, of_laws = table.pop("joint"), table.pop("of_laws")
        return frame_of(table | of_laws | dict(zip("xyz", places.T, strict=True)), index, "joint", provisional=self.provisional)

    @cached_property
    def parts(self) -> DataFrame:
        """A row per part, the structure last: grade and its reason, mechanism, joints by state, drift, lost blocks; as in damage.csv."""
        return frame_of_rows(self.damage.parts, "part", provisional=self.damage.provisional)

    @cached_property
    def hinges(self) -> DataFrame:
        """A row per joint that was a hinge: where, how wide, when; as in hinges.csv."""
        return frame_of_rows(self.damage.hinges, "joint")

    @cached_property
    def levels(self) -> DataFrame:
        """A row per part and level: displacements and drift; as in drift.csv."""
        return frame_of_rows(self.damage.levels)

    @cached_property
    def history(self) -> DataFrame:
        """A row per frame and part: what is open, slid, apart; as in damage_history.csv."""
        return frame_of_rows(self.damage.history)

    @cached_property
    def steps(self) -> DataFrame:
        """A row per time step, by the time at its end: the step of the loads, iterations, contacts, error and seconds, penetration."""
        with self.results() as found:
            time = found.per_step("step_time")
            columns = {
                name.rpartition("/")[2]: found.per_step(name)[: len(time)].astype(np.int64 if quantity.whole else np.float64)
                for name, quantity in QUANTITIES.items()
                if name != "step_time" and not name.startswith("energy/")
            }
        return frame_of({name: values for name, values in columns.items() if len(values) == len(time)}, time, "time")

    @cached_property
    def energy(self) -> DataFrame:
        """A row per time step: what was put in, where it went, and the balance [J]."""
        with self.results() as found:
            time, energies = found.per_step("step_time"), found.energies
        return frame_of({name: values[: len(time)] for name, values in energies.items()}, time, "time", unit="J")

    def blocks(self, time: float | None = None) -> DataFrame:
        """Where the blocks are at the frame next to a time [s], the last one by default; ``attrs["time"]`` is that of the frame.

        A row per block: position of its centre of mass x, y, z, displacement relative to the support that moves least ux, uy, uz, rotation
        vector rx, ry, rz, velocity vx, vy, vz and angular velocity wx, wy, wz, these two in the world frame.

        Raises:
            InputError: a time outside the run.

        >>> import masonry_cd as mc
        >>> run = mc.run(mc.scene("examples/trilithon.toml", "run.duration=0.01"), progress=False)
        >>> lintel = run.blocks(0.01).loc["lintel"]
        >>> (lintel[["x", "y", "z"]].astype(float).round(3) + 0.0).tolist()
        [0.0, 0.0, 2.7]
        >>> run.blocks().attrs["units"]["ux"], run.joints.attrs["units"]["area"]
        ('m', 'm2')
        """
        with self._at(time) as (found, frame):
            solids = solids_of(found.blocks)
            moved = read_motion(found, solids, np.array([frame]))
            columns = {
                "group": [block.group for block in found.blocks],
                "fixed": [block.fixed for block in found.blocks],
                **columns_of("xyz", found.position[frame]),
                **columns_of(MOTIONS, np.concatenate([moved.displacement[0], moved.rotation[0]], axis=1)),
                **columns_of(VELOCITIES, found.velocity[frame]),
            }
        return frame_of(columns, self.structure.names, "block", time=float(self.time[frame]))

    def motion(self, block: str) -> DataFrame:
        """How a block moves: a row per frame with the columns of :meth:`blocks`, and base_x, base_y, base_z, how far the base has moved.

        Raises:
            InputError: no block has this name.
        """
        index = self.structure.index(block)
        with self.results() as found:
            every, solids = slice(0, found.frames), solids_of(found.blocks)
            place, turned = (np.asarray(of[every, [index]], dtype=float) for of in (found.position, found.orientation))
            base = base_at(found, solids, every)
            columns = {
                **columns_of("xyz", place[:, 0]),
                **columns_of(MOTIONS[:3], base.seen(place)[:, 0] - solids.centre[index]),
                **columns_of(MOTIONS[3:], rotation_vectors(base.orientations(turned)[:, 0])),
                **columns_of(VELOCITIES, found.velocity[: found.frames, index]),
                **columns_of(("base_x", "base_y", "base_z"), base.shift),
            }
        return frame_of(columns, self.time, "time")

    def joint_history(self, measure: str = "opening") -> DataFrame:
        """How a measure of the joints goes: a row per frame, a column per joint.

        Args:
            measure: opening, sliding [m], rotation [rad], contact_area [m2], normal_force, shear_force [N], or bonded, a share of the area;
                of runs that kept stress mean_normal_force [N] and edge_stress [Pa], means since the frame before.

        Raises:
            InputError: no such measure, or one that the run did not write.
        """
        if measure not in MEASURES:
            raise InputError("joint_history", f'"{measure}" is none{suggest(measure, MEASURES)}; measures: {", ".join(MEASURES)}')
        with self.results() as found:
            if not found.has_joint_history(measure):
                raise InputError("joint_history", f"the run has written no {measure}")
            values = found.joint_history(measure)
        return frame_of(dict(enumerate(values.T)), self.time, "time", unit=MEASURES[measure])

    def crack_agreement(
        self, drawn: Sequence[Polyline], within: float, along: Sequence[float] = (1.0, 0.0, 0.0), width: float = VISIBLE
    ) -> CrackAgreement:
        """How far the cracks at the end of the run agree with a crack map drawn of the real wall: shares of length found and false.

        Args:
            drawn: polylines of the map [m], of points (place along the elevation, height).
            within: largest distance of one crack from the other [m], at most the size of a stone.
            along: (3,) level direction of the elevation.
            width: least opening or sliding of a crack [m].

        Raises:
            InputError: no line, or a distance that is not above zero.
        """
        with self.results() as found:
            return agreement(joint_lines(found, along)[cracked(found, width)], drawn, within)

    def force_displacement(self, push: str | None = None) -> DataFrame:
        """The force of a push by displacement: a row per step, by the time at its end, as in force_displacement.csv.

        Columns: displacement, force along the push, moment that holds from turning, and inertia, the rate of momentum of all blocks;
        ``attrs["numbers"]`` has peak, stiffness, bilinear idealisation and cycles, as in summary.json.

        Args:
            push: its name, or that of a prop; the first push when not given.

        Raises:
            InputError: the run has no push, or none of this name.
        """
        with self.results() as found:
            curves = push_curves(found) if push else require_pushes(found)
        names = [curve.name for curve in curves]
        if push and push not in names:
            there = ", ".join(names) or "none"
            raise InputError("force_displacement", f'"{push}" is not a push or prop{suggest(push, names)}; there are {there}')
        curve = curves[names.index(push) if push else 0]
        columns = {name: getattr(curve, name) for name in ("displacement", "force", "moment", "inertia")}
        return frame_of(columns, curve.time, "time", numbers=curve.numbers().as_dict())

    def gauge(self, name: str) -> DataFrame:
        """Return the record of a point, joint, crack or support of the scene's [output]: a row per step, as in points.csv and so on.

        Raises:
            InputError: none has this name.
        """
        with self.results() as found:
            by_name = {own: columns for kind in histories_of(found).values() for own, columns in kind.items()}
        if name not in by_name:
            raise InputError("gauge", f'"{name}" is none{suggest(name, by_name)}; there are {", ".join(by_name)}')
        columns = dict(by_name[name])
        frame = frame_of(columns, columns.pop("time"), "time")
        frame.attrs["units"] |= {column: unit_of_column(column) for column in ("time", *columns)}
        return frame

    @property
    def plot(self) -> Plots:
        """Its pictures: ``run.plot.crack_map()``, ``.stress_map()``, ``.energy()``, ``.history()``, ``.page()``,
        ``.force_displacement()``, ``.gauges()``."""
        return Plots(self.results, self._report, lambda: self._summary, lambda: self.damage)

    @property
    def lines(self) -> list[str]:
        """The closing lines of the run, as on the command line."""
        found = self._summary
        return closing_lines(found) if found.has("solver") else [f"{self.title}: {self.stopped}", damage_line(found)]

    def __str__(self) -> str:
        return "\n".join(self.lines)

    def __repr__(self) -> str:
        end = f", {self.stopped}" if self.stopped else ""
        return f'<Run "{self.title}": {len(self.time)} frames to {self.time[-1]:g} s{end}>'

    def _repr_html_(self) -> str:
        return closing_as_html(self.lines, self.warnings)


def open_run(folder: str | os.PathLike[str]) -> Run:
    """The run in a folder, also one that was interrupted or killed, or is at work; made here or by the command line.

    Raises:
        InputError: no run is there, or nothing of its results can be read.
    """
    return Run(Path(folder))
