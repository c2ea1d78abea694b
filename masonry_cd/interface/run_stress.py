# SPDX-License-Identifier: GPL-3.0-or-later
"""The stress of a run as tables: of blocks, joints, and the elements and nodes of meshed blocks."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.analysis.deformed import Pose, base_at, moved_nodes, solids_of
from masonry_cd.analysis.stress.elements import centres, element_columns, element_peaks, require_meshes
from masonry_cd.analysis.stress.peaks import StressPeaks, principal, require_stress, stress_peaks
from masonry_cd.foundation.extras import require
from masonry_cd.interface.open_run import OpenRun
from masonry_cd.interface.tables import columns_of, frame_of
from reports.stress import block_columns, joint_columns

if TYPE_CHECKING:
    from pandas import DataFrame

    from masonry_cd.io.results import Results

STRESSES = ("xx", "yy", "zz", "xy", "yz", "xz", "s1", "s2", "s3")


class RunStress(OpenRun):
    """The tables of a run that kept stress."""

    def stress(self, time: float | None = None) -> DataFrame:
        """The mean stress of the blocks at the frame next to a time [s], the last one by default; ``attrs["time"]`` is that of the frame.

        A row per block: xx, yy, zz, xy, yz, xz in the world frame, and the principal stresses s1, s2, s3, the largest tension first [Pa]:
        means over the block, since the frame before. NaN of supports, and before the first step.

        Raises:
            InputError: a time outside the run, or a run that kept no stress: ``report.stress = true`` in its scene asks for it.

        >>> import masonry_cd as mc
        >>> run = mc.run(mc.scene("examples/trilithon.toml", "run.duration=0.1", "report.stress=true"), progress=False)
        >>> bool(run.stress(0.1).loc["left", "zz"] < run.stress(0.1).loc["lintel", "zz"] < 0.0)
        True
        """
        with self._at(time) as (found, frame):
            require_stress(found)
            return frame_of(_with_principal(found.stress[frame]), self.structure.names, "block", unit="Pa", time=float(self.time[frame]))

    def elements(self, time: float | None = None) -> DataFrame:
        """The mean stress of the elements of meshed blocks at the frame next to a time [s], the last one by default; ``attrs["time"]`` is
        that of the frame.

        A row per element, by its block and number in it: centre x, y, z as built [m], xx, yy, zz, xy, yz, xz in the world frame, and the
        principal stresses s1, s2, s3, the largest tension first [Pa]: means since the frame before, NaN before the first step.

        Raises:
            InputError: a time outside the run, or a run that kept no stress of meshed blocks.

        >>> import masonry_cd as mc
        >>> asked = ["deformable=tetrahedra", "mesh_size=1.0", "young=5e9", "damping=0.1", "damping_frequency=20"]
        >>> keys = ["run.duration=0.02", "run.planar=true", "report.stress=true", *(f"material.{key}" for key in asked)]
        >>> run = mc.run(mc.scene("examples/trilithon.toml", *keys), progress=False)
        >>> bool(run.elements().loc["left"]["s3"].max() < 0.0)
        True
        >>> float(run.nodes().loc["left"]["uz"].min()) > -1e-4, run.nodes().attrs["units"]["uz"]
        (True, 'm')
        """
        with self._at(time) as (found, frame):
            meshes = require_meshes(found)
            columns = columns_of("xyz", centres(meshes)) | _with_principal(found.element_stress[frame])
            return self._by_block(columns, meshes.block, meshes.element_start, "element", time=float(self.time[frame]))

    def nodes(self, time: float | None = None) -> DataFrame:
        """Where the nodes of meshed blocks are at the frame next to a time [s], the last one by default; see :meth:`elements`.

        A row per node, by its block and number in it: place x, y, z, and displacement relative to the support that moves least ux, uy, uz,
        world frame [m].

        Raises:
            InputError: as :meth:`elements`.
        """
        with self._at(time) as (found, frame):
            meshes, solids = require_meshes(found), solids_of(found.blocks)
            relative = moved_nodes(found, Pose.of(found, solids, frame), frame)
            place = base_at(found, solids, frame).in_world(relative)
            columns = columns_of("xyz", place) | columns_of(("ux", "uy", "uz"), relative - meshes.nodes)
            return self._by_block(columns, meshes.block, meshes.node_start, "node", time=float(self.time[frame]))

    @cached_property
    def element_stress(self) -> DataFrame:
        """A row per element of meshed blocks: its largest compression and tension over the run, when, and the strength; as in
        element_stress.csv.

        Raises:
            InputError: the run kept no stress of meshed blocks.
        """
        with self.results() as found:
            meshes, peaks = require_meshes(found), element_peaks(found)
            assert peaks is not None
            columns = {name: values for name, values in element_columns(found, peaks).items() if name not in ("block", "element")}
            return self._by_block(columns, meshes.block, meshes.element_start, "element")

    @cached_property
    def block_stress(self) -> DataFrame:
        """A row per block: its largest compression and tension over the run, when, and the strength; as in stress.csv.

        Raises:
            InputError: the run kept no stress.
        """
        return self._peaks(block_columns, "block")

    @cached_property
    def joint_stress(self) -> DataFrame:
        """A row per joint: the largest compression at its edge and its largest normal force over the run; as in joint_stress.csv.

        Raises:
            InputError: the run kept no stress.
        """
        return self._peaks(joint_columns, "joint")

    def _peaks(self, columns_of: Callable[[Results, StressPeaks], dict[str, Any]], what: str) -> DataFrame:
        """The largest stresses over the run, a row per block or joint."""
        with self.results() as found:
            columns = columns_of(found, stress_peaks(found, self._report.opened))
        return frame_of(columns, columns.pop(what), what)

    def _by_block(self, columns: dict[str, Any], blocks: np.ndarray, start: np.ndarray, what: str, **about: Any) -> DataFrame:
        """A table of elements or nodes by the name of their block and their number in it.

        Args:
            columns: (N,) each.
            blocks: (M,) numbers of the meshed blocks.
            start: (M + 1,) where the rows of each begin.
            what: element or node.
            about: attributes of the table.
        """
        require("a table", "pandas")
        import pandas

        counts = np.diff(start).tolist()
        names = [(self.structure.names[b], k) for b, count in zip(blocks.tolist(), counts, strict=True) for k in range(count)]
        table = frame_of(columns, **about)
        table.index = pandas.MultiIndex.from_tuples(names, names=["block", what])
        return table


def _with_principal(tensor: np.ndarray) -> dict[str, np.ndarray]:
    """Stresses (N, 6) and the principal ones as columns [Pa]."""
    tensor = np.asarray(tensor, dtype=float)
    return columns_of(STRESSES, np.concatenate([tensor, principal(tensor)], axis=1))
