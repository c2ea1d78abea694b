# SPDX-License-Identifier: GPL-3.0-or-later
"""The blocks of a run in flat arrays, as a result file holds them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import h5py
import numpy as np

from masonry_cd.io.layout import MESH_ARRAYS
from masonry_cd.mechanics.dynamics.element_stress import meshes_of, starts
from masonry_cd.mechanics.dynamics.strain import Strains
from masonry_cd.mechanics.model.blocks import Assembly, Block, CarriedLoad
from masonry_cd.mechanics.model.fill import CoveredFaces, Fill
from masonry_cd.mechanics.model.geometry import Faces


def write_blocks(group: h5py.Group, blocks: tuple[Block, ...], fills: Sequence[Fill] = ()) -> None:
    """Write the blocks, and the faces on which the fills of bridges lie, in flat arrays."""
    text = h5py.string_dtype()
    group.create_dataset("name", data=[b.name for b in blocks], dtype=text)
    group.create_dataset("group", data=[b.group for b in blocks], dtype=text)
    if any(b.structure for b in blocks):
        group.create_dataset("structure", data=[b.structure for b in blocks], dtype=text)
    if any(b.stone for b in blocks):
        group.create_dataset("stone", data=[b.stone for b in blocks], dtype=text)
    group["fixed"] = np.array([b.fixed for b in blocks])
    if any(b.radius for b in blocks):
        group["radius"] = np.array([b.radius for b in blocks])
    group["density"] = np.array([b.density for b in blocks])
    if any(b.carried is not None for b in blocks):
        carried = [b.carried or CarriedLoad(0.0, np.zeros(3), np.zeros((3, 3))) for b in blocks]
        for name in CarriedLoad._fields:
            group[f"carried_{name}"] = np.array([getattr(each, name) for each in carried])
    if (fill := CoveredFaces.of(fills, [b.name for b in blocks])) is not None:
        for name, values in fill._asdict().items():
            group[f"fill_{name}"] = values
    # of a sphere its centre
    shells: list[tuple[np.ndarray, Faces]] = [(b.vertices[:1], ()) if b.radius else (b.vertices, b.faces) for b in blocks]
    group["vertex_start"] = np.cumsum([0, *(len(vertices) for vertices, _ in shells)])
    group["vertices"] = np.concatenate([vertices for vertices, _ in shells])
    group["face_start"] = np.cumsum([0, *(len(faces) for _, faces in shells)])
    group["loop_start"] = np.cumsum([0, *(len(face) for _, faces in shells for face in faces)])
    group["loops"] = np.array([i for _, faces in shells for face in faces for i in face], dtype=np.int64)


def read_blocks(group: h5py.Group) -> Iterator[Block]:
    """Read back what :func:`write_blocks` wrote."""
    names, groups = group["name"].asstr()[...], group["group"].asstr()[...]
    structures = group["structure"].asstr()[...] if "structure" in group else [""] * len(names)
    stones = group["stone"].asstr()[...] if "stone" in group else [""] * len(names)
    radii = group["radius"][...] if "radius" in group else np.zeros(len(names))
    arrays = {name: group[name][...] for name in ("fixed", "density", "vertex_start", "vertices", "face_start", "loop_start", "loops")}
    carried = _carried(group, len(names))
    for i, name in enumerate(names):
        vertices = arrays["vertices"][arrays["vertex_start"][i] : arrays["vertex_start"][i + 1]]
        if radii[i]:
            ball = Block.sphere(name, vertices[0], float(radii[i]), float(arrays["density"][i]), groups[i], bool(arrays["fixed"][i]))
            yield replace(ball, structure=structures[i])
            continue
        loops = range(arrays["face_start"][i], arrays["face_start"][i + 1])
        faces = tuple(tuple(arrays["loops"][arrays["loop_start"][f] : arrays["loop_start"][f + 1]].tolist()) for f in loops)
        yield Block(
            name, vertices, faces, float(arrays["density"][i]), groups[i], bool(arrays["fixed"][i]), structure=structures[i],
            carried=carried[i], stone=stones[i],
        )  # fmt: skip


def read_fill(group: h5py.Group) -> CoveredFaces | None:
    """The faces on which fill lies; None without one, and in a file of an older version."""
    return CoveredFaces(*(group[f"fill_{name}"][...] for name in CoveredFaces._fields)) if "fill_block" in group else None


def _carried(group: h5py.Group, count: int) -> list[CarriedLoad | None]:
    """Return the carried values of each block."""
    if "carried_mass" not in group:
        return [None] * count
    mass, centre, inertia = (group[f"carried_{name}"][...] for name in CarriedLoad._fields)
    return [CarriedLoad(float(m), c, i) if m else None for m, c, i in zip(mass, centre, inertia, strict=True)]


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
