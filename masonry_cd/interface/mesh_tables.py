# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of meshed blocks: a row per element or node, by its block and number in it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.analysis.deformed import Pose, base_shift, moved_nodes, solids_of
from masonry_cd.analysis.stress.elements import centres, element_columns, element_peaks, require_meshes
from masonry_cd.analysis.stress.peaks import principal
from masonry_cd.foundation.extras import require
from masonry_cd.interface.tables import columns_of, frame_of
from masonry_cd.io.results import Results

if TYPE_CHECKING:
    from pandas import DataFrame

STRESSES = ("xx", "yy", "zz", "xy", "yz", "xz", "s1", "s2", "s3")


def element_table(found: Results, frame: int) -> DataFrame:
    """Centres as built [m] and mean stresses [Pa] of the elements at a frame.

    Raises:
        InputError: the run kept no stress of meshed blocks.
    """
    meshes = require_meshes(found)
    tensor = np.asarray(found.element_stress[frame], dtype=float)
    stresses = np.concatenate([tensor, principal(tensor)], axis=1)
    columns = columns_of("xyz", centres(meshes)) | columns_of(STRESSES, stresses)
    return _table(columns, _numbered(found, meshes.block, meshes.element_start), "element", float(found.time[frame]))


def node_table(found: Results, frame: int) -> DataFrame:
    """Places of the nodes at a frame, and displacements relative to the support that moves least [m].

    Raises:
        InputError: the run kept no stress of meshed blocks.
    """
    meshes, solids = require_meshes(found), solids_of(found.blocks)
    relative = moved_nodes(found, Pose.of(found, solids, frame), frame)
    place = relative + base_shift(found, solids, np.asarray(found.position[frame], dtype=float))
    columns = columns_of("xyz", place) | columns_of(("ux", "uy", "uz"), relative - meshes.nodes)
    return _table(columns, _numbered(found, meshes.block, meshes.node_start), "node", float(found.time[frame]))


def element_peak_table(found: Results) -> DataFrame:
    """Largest compression and tension of each element over the run, when, and the strength.

    Raises:
        InputError: the run kept no stress of meshed blocks.
    """
    require_meshes(found)
    peaks = element_peaks(found)
    assert peaks is not None
    columns = element_columns(found, peaks)
    return _table(columns, list(zip(columns.pop("block"), columns.pop("element").tolist(), strict=True)), "element")


def _numbered(found: Results, blocks: np.ndarray, start: np.ndarray) -> list[tuple[str, int]]:
    """The name of the block and the number in it of each node or element."""
    return [(found.blocks[b].name, k) for m, b in enumerate(blocks.tolist()) for k in range(int(start[m + 1] - start[m]))]


def _table(columns: dict[str, Any], names: list[tuple[str, int]], what: str, time: float | None = None) -> DataFrame:
    """A table by the block and the number of an element or node."""
    require("a table", "pandas")
    import pandas

    table = frame_of(columns)
    table.index = pandas.MultiIndex.from_tuples(names, names=["block", what])
    table.attrs |= {} if time is None else {"time": time}
    return table
