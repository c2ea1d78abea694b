# SPDX-License-Identifier: GPL-3.0-or-later
"""The meshes of blocks that are cut into elements, as a result file holds them: only where a run keeps their stress."""

from __future__ import annotations

from dataclasses import dataclass

import h5py
import numpy as np

from masonry_cd.io.layout import MESH_ARRAYS
from masonry_cd.mechanics.dynamics.element_stress import meshes_of, starts
from masonry_cd.mechanics.dynamics.strain import Strains
from masonry_cd.mechanics.model.blocks import Assembly


@dataclass(frozen=True, eq=False)
class Meshes:
    """The meshes of M blocks, one after the other: K nodes, E elements of d + 1 corners, tetrahedra or, in a plane, triangles."""

    block: np.ndarray  # (M,) numbers of the blocks
    node_start: np.ndarray  # (M + 1,)
    nodes: np.ndarray  # (K, 3) as built, world frame [m]; in a plane in the middle of the block
    element_start: np.ndarray  # (M + 1,)
    elements: np.ndarray  # (E, d + 1) nodes, counted over all

    @classmethod
    def of(cls, assembly: Assembly, strains: Strains | None) -> Meshes | None:
        """Those of an assembly; None: no block is meshed."""
        if strains is None or strains.warps is None:
            return None
        own, block = meshes_of(strains.warps), np.flatnonzero(strains.warps.of_block >= 0)
        node_start, element_start = starts(own)
        nodes = np.concatenate([assembly.centre[b] + mesh.nodes for b, mesh in zip(block, own, strict=True)])
        elements = np.concatenate([mesh.elements + first for mesh, first in zip(own, node_start[:-1], strict=True)])
        return cls(block, node_start, nodes, element_start, elements)

    @classmethod
    def read(cls, file: h5py.File) -> Meshes:
        """Those of a result file that has them."""
        return cls(**{name: file[f"meshes/{name}"][...] for name in MESH_ARRAYS})

    def write(self, file: h5py.File) -> None:
        """Write them into a result file."""
        for name in MESH_ARRAYS:
            file[f"meshes/{name}"] = getattr(self, name)

    @property
    def block_of_node(self) -> np.ndarray:
        """(K,) number of the block of each node."""
        return np.repeat(self.block, np.diff(self.node_start))

    @property
    def block_of_element(self) -> np.ndarray:
        """(E,) number of the block of each element."""
        return np.repeat(self.block, np.diff(self.element_start))

    @property
    def numbers(self) -> int:
        """Real numbers of a frame: displacements of the nodes, stresses of the elements."""
        return 3 * len(self.nodes) + 6 * len(self.elements)
