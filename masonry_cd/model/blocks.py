"""Blocks and their assembly: all that stays constant during a run.

A block is a closed polyhedron of uniform density. Volume, centre of mass and inertia are exact: the solid is the signed
sum of the tetrahedra spanned by an inner point and the triangles of the faces, and the second moments of a tetrahedron
(0, a, b, c) are polynomials of its corners (Tonon, J. Math. Stat. 1(1), 2005).

The body frame of a block has its origin at the centre of mass and is parallel to the world axes at the start of the run,
so every orientation starts as the unit quaternion (1, 0, 0, 0).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from masonry_cd.errors import InputError
from masonry_cd.model.materials import JointLaw, JointLaws, friction_table, joint_table

Faces = tuple[tuple[int, ...], ...]
NEXT, LAST = [1, 2, 0], [2, 0, 1]  # axes in cyclic order after x, y, z


@dataclass(frozen=True, eq=False)
class Polyhedron:
    """A closed polyhedron: vertices (V, 3) [m] and faces as loops of vertex indices, counter-clockwise from outside."""

    vertices: np.ndarray
    faces: Faces


@dataclass(frozen=True, eq=False)
class Block:
    """One block as the user describes it.

    Attributes:
        name: unique in the assembly.
        vertices: (V, 3) corners in the world frame [m].
        faces: loops of vertex indices, zero-based, counter-clockwise seen from outside.
        density: [kg/m3].
        group: the name by which friction and reports address it (``base``, ``arch``, ``pier`` ...).
        fixed: True for a support, which moves as prescribed.
        parts: convex parts that fill the block; empty when the block itself is convex.
    """

    name: str
    vertices: np.ndarray
    faces: Faces
    density: float
    group: str = "block"
    fixed: bool = False
    parts: tuple[Polyhedron, ...] = ()

    @property
    def convex_parts(self) -> tuple[Polyhedron, ...]:
        """The convex parts for contact detection."""
        return self.parts or (Polyhedron(self.vertices, self.faces),)


@dataclass(frozen=True)
class MassProperties:
    """Volume [m3], centre of mass (3,) [m], and second moments about it: inertia per density (3, 3) [m5]."""

    volume: float
    centre: np.ndarray
    unit_inertia: np.ndarray


def triangles(faces: Faces) -> np.ndarray:
    """Fan-triangulate convex face loops into an (n, 3) array of vertex indices."""
    fans = [(face[0], face[i], face[i + 1]) for face in faces for i in range(1, len(face) - 1)]
    return np.array(fans, dtype=np.int64).reshape(-1, 3)


def mass_properties(vertices: np.ndarray, faces: Faces) -> MassProperties:
    """Integrate a closed polyhedron exactly.

    Args:
        vertices: (V, 3) [m].
        faces: convex loops, counter-clockwise from outside. A reversed shell gives a negative volume.
    """
    inner = vertices.mean(axis=0)  # integrate near the block: far from the origin the moments would cancel
    corners = (vertices - inner)[triangles(faces)]  # (n, 3 corners, 3)
    sixfold = np.linalg.det(corners)  # six times the signed volume of each tetrahedron
    volume = sixfold.sum() / 6.0
    total = corners.sum(axis=1)
    first = np.einsum("n,ni->i", sixfold, total) / 24.0
    second = (np.einsum("n,nki,nkj->ij", sixfold, corners, corners) + np.einsum("n,ni,nj->ij", sixfold, total, total)) / 120.0
    centre = first / volume
    second -= volume * np.outer(centre, centre)
    inertia = np.trace(second) * np.eye(3) - second
    return MassProperties(float(volume), inner + centre, inertia)


@dataclass(frozen=True, eq=False)
class Shapes:
    """The convex parts of all blocks in flat arrays, in the body frames, as the detection kernels read them.

    P parts, V vertices, F faces, L loop entries, E edges; ``*_start`` arrays delimit the entries of a part or face.
    """

    part_block: np.ndarray  # (P,) block of each part
    vertex_start: np.ndarray  # (P + 1,)
    vertices: np.ndarray  # (V, 3) in the body frame [m]
    face_start: np.ndarray  # (P + 1,)
    face_normals: np.ndarray  # (F, 3) outward unit normals in the body frame
    loop_start: np.ndarray  # (F + 1,)
    loops: np.ndarray  # (L,) vertex indices, counted over all parts
    edge_start: np.ndarray  # (P + 1,)
    edges: np.ndarray  # (E, 4): its two vertices and its two faces, left face first
    radius: np.ndarray  # (P,) largest distance of a vertex from the block's centre of mass [m]
    size: np.ndarray  # (P,) smallest width of the part over its face normals [m]


@dataclass(frozen=True, eq=False)
class Assembly:
    """All blocks of a structure: constant data in flat arrays. Build it with :meth:`from_blocks`."""

    blocks: tuple[Block, ...]
    names: tuple[str, ...]
    groups: tuple[str, ...]  # the distinct groups
    group_of: np.ndarray  # (B,) index into groups
    fixed: np.ndarray  # (B,) bool: supports
    support_of: np.ndarray  # (B,) index of the prescribed motion, -1 for a free block
    mass: np.ndarray  # (B,) [kg]
    inertia: np.ndarray  # (B, 3, 3) about the centre of mass, body frame [kg m2]
    centre: np.ndarray  # (B, 3) centres of mass at the start [m]
    volume: np.ndarray  # (B,) [m3]
    friction: np.ndarray  # (G, G) coefficient of friction between groups
    laws: JointLaws  # of the joints between groups
    shapes: Shapes = field(repr=False)

    @property
    def count(self) -> int:
        """Number of blocks B, supports included."""
        return len(self.names)

    @property
    def reach(self) -> np.ndarray:
        """Farthest corner of each block from its centre of mass, (B,) [m]."""
        out = np.zeros(self.count)
        np.maximum.at(out, self.shapes.part_block, self.shapes.radius)
        return out

    @classmethod
    def from_blocks(
        cls, blocks: Sequence[Block], friction: float | Mapping[str, float], joints: Mapping[str, JointLaw] | None = None
    ) -> Assembly:
        """Collect blocks into an assembly.

        Args:
            blocks: checked blocks (see ``structures.geometry.checks``), at least one of them free.
            friction: one coefficient, or coefficients by pair of groups ``"arch-base"`` with ``"default"`` for the rest.
            joints: laws of the joints by pair of groups, likewise; a pair without one is rigid and dry.

        Raises:
            InputError: a name given twice, no free block, a pair that names an unknown group, or a law that friction does not allow.
        """
        names = tuple(block.name for block in blocks)
        if len(set(names)) < len(names):
            twice = next(name for i, name in enumerate(names) if name in names[:i])
            raise InputError(f'block "{twice}": two blocks have this name')
        if all(block.fixed for block in blocks):
            raise InputError("structure: no free block, nothing can move")
        groups = tuple(dict.fromkeys(block.group for block in blocks))
        properties = [mass_properties(block.vertices, block.faces) for block in blocks]
        volume = np.array([p.volume for p in properties])
        density = np.array([block.density for block in blocks])
        centre = np.array([p.centre for p in properties])
        fixed = np.array([block.fixed for block in blocks])
        coefficients = friction_table(friction, groups)
        return cls(
            blocks=tuple(blocks),
            names=names,
            groups=groups,
            group_of=np.array([groups.index(block.group) for block in blocks]),
            fixed=fixed,
            support_of=np.where(fixed, 0, -1),
            mass=volume * density,
            inertia=np.array([p.unit_inertia for p in properties]) * density[:, None, None],
            centre=centre,
            volume=volume,
            friction=coefficients,
            laws=joint_table(joints or {}, groups, coefficients),
            shapes=_shapes(blocks, centre),
        )


def _shapes(blocks: Sequence[Block], centre: np.ndarray) -> Shapes:
    """Flatten the convex parts of all blocks into the arrays of :class:`Shapes`."""
    part_block, radius, size = [], [], []
    vertices, normals = [], []
    loops: list[int] = []
    edges: list[tuple[int, int, int, int]] = []
    starts: dict[str, list[int]] = {"vertex": [0], "face": [0], "loop": [0], "edge": [0]}
    for index, block in enumerate(blocks):
        for part in block.convex_parts:
            local = part.vertices - centre[index]
            base, face_base = starts["vertex"][-1], starts["face"][-1]
            part_normals = np.array([loop_normal(local[list(face)]) for face in part.faces])
            part_block.append(index)
            radius.append(np.linalg.norm(local, axis=1).max())
            size.append(np.ptp(local @ part_normals.T, axis=0).min())
            vertices.append(local)
            normals.append(part_normals)
            for face in part.faces:
                loops.extend(base + i for i in face)
                starts["loop"].append(len(loops))
            edges.extend(_edges(part.faces, base, face_base))
            starts["vertex"].append(base + len(local))
            starts["face"].append(face_base + len(part.faces))
            starts["edge"].append(len(edges))
    return Shapes(
        part_block=np.array(part_block),
        vertex_start=np.array(starts["vertex"]),
        vertices=np.concatenate(vertices),
        face_start=np.array(starts["face"]),
        face_normals=np.concatenate(normals),
        loop_start=np.array(starts["loop"]),
        loops=np.array(loops),
        edge_start=np.array(starts["edge"]),
        edges=np.array(edges),
        radius=np.array(radius),
        size=np.array(size),
    )


def loop_normal(loop: np.ndarray) -> np.ndarray:
    """Unit normal of a planar loop (n, 3) by Newell's sum, which holds for any convex or non-convex polygon."""
    spoke = loop - loop[0]
    rest = np.concatenate([spoke[1:], spoke[:1]])
    ahead, back = spoke.take(NEXT, axis=1), spoke.take(LAST, axis=1)
    cross = ahead * rest.take(LAST, axis=1) - back * rest.take(NEXT, axis=1)  # numpy's own takes several times as long on a few rows
    area = 0.5 * cross.sum(axis=0)
    return area / np.sqrt(area @ area)


def _edges(faces: Faces, vertex_base: int, face_base: int) -> list[tuple[int, int, int, int]]:
    """List each edge once as (vertex, vertex, face to its left, face to its right), indices counted over all parts."""
    left = {(a, b): f for f, face in enumerate(faces) for a, b in zip(face, face[1:] + face[:1], strict=True)}
    return [(vertex_base + a, vertex_base + b, face_base + f, face_base + left[b, a]) for (a, b), f in left.items() if a < b]
