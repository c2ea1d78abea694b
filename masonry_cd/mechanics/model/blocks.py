# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks and their assembly: all that stays constant during a run.

A block is a closed polyhedron of uniform density, or a sphere; its mass properties are exact (:mod:`masonry_cd.mechanics.model.geometry`,
:mod:`masonry_cd.mechanics.model.sphere`).
The body frame of a block has its origin at the centre of mass and is parallel to the world axes at the start of the run,
so every orientation starts as the unit quaternion (1, 0, 0, 0).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.deformation import Deformation, deformation_of
from masonry_cd.mechanics.model.footings import Footings
from masonry_cd.mechanics.model.geometry import Faces, MassProperties, Polyhedra, Polyhedron, mass_properties
from masonry_cd.mechanics.model.joint_laws import JointLaw, joint_table, refuse_unfelt
from masonry_cd.mechanics.model.joint_laws.friction import friction_table
from masonry_cd.mechanics.model.joint_laws.restitution import restitution_table
from masonry_cd.mechanics.model.joint_laws.rolling import rolling_table
from masonry_cd.mechanics.model.joint_laws.tables import JointLaws
from masonry_cd.mechanics.model.links import Link
from masonry_cd.mechanics.model.materials import Material
from masonry_cd.mechanics.model.sphere import ball_centre, facetted_ball, sphere_properties
from masonry_cd.mechanics.model.stones import CrackPlanes


class CarriedLoad(NamedTuple):
    """A load that a block carries and moves as if it were a part of it, such as the fill above a voussoir."""

    mass: float  # [kg]
    centre: np.ndarray  # (3,) of mass, world frame [m]
    inertia: np.ndarray  # (3, 3) about that centre, world frame [kg m2]

    def moved(self, turn: np.ndarray, centre: np.ndarray) -> CarriedLoad:
        """Turned by (3, 3), with its centre at a place (3,) [m]."""
        return CarriedLoad(self.mass, centre, turn @ self.inertia @ turn.T)


@dataclass(frozen=True, eq=False)
class Block:
    """One block as the user describes it.

    Attributes:
        name: unique in the assembly.
        vertices: (V, 3) corners in the world frame [m].
        faces: loops of vertex indices, zero-based, counter-clockwise seen from outside.
        density: [kg/m3]; NaN for that of the material, which :func:`structures.build` puts in its place.
        group: the name by which friction and reports address it (``base``, ``arch``, ``pier`` ...).
        fixed: True for a support, which moves as prescribed.
        parts: convex parts that fill the block; empty when the block itself is convex.
        structure: the one that it belongs to where a scene has several, else empty.
        radius: of a sphere [m], whose vertices and faces are then the facetted ball by which it is drawn (:meth:`sphere` makes one); 0 of
            a polyhedron.
        carried: a mass that moves with it; None: nothing.
        stone: the name of the stone that it is a piece of; empty of a block that is whole.
    """

    name: str
    vertices: np.ndarray
    faces: Faces
    density: float = math.nan
    group: str = "block"
    fixed: bool = False
    parts: tuple[Polyhedron, ...] = ()
    structure: str = ""
    radius: float = 0.0
    carried: CarriedLoad | None = None
    stone: str = ""

    @classmethod
    def sphere(
        cls, name: str, centre: np.ndarray, radius: float, density: float = math.nan, group: str = "block", fixed: bool = False
    ) -> Block:
        """A sphere about a centre (3,) [m]."""
        return cls(name, *facetted_ball(centre, radius), density, group, fixed, radius=radius)

    @property
    def convex_parts(self) -> tuple[Polyhedron, ...]:
        """The convex parts that fill the block; of a sphere the ball by which it is drawn."""
        return self.parts or (Polyhedron(self.vertices, self.faces),)

    @property
    def mass_properties(self) -> MassProperties:
        """Volume, centre of mass and inertia per density; what the block carries counts as more volume."""
        own = sphere_properties(self.vertices, self.radius) if self.radius else mass_properties(self.vertices, self.faces)
        if self.carried is None:
            return own
        whole = own.volume + self.carried_volume
        centre = (own.volume * own.centre + self.carried_volume * self.carried.centre) / whole
        inertia = own.unit_inertia + self.carried.inertia / self.density
        for volume, place in ((own.volume, own.centre), (self.carried_volume, self.carried.centre)):
            arm = place - centre
            inertia = inertia + volume * ((arm @ arm) * np.eye(3) - np.outer(arm, arm))
        return MassProperties(whole, centre, inertia)

    @property
    def carried_volume(self) -> float:
        """Volume of the block's own material that weighs as much as what it carries [m3]."""
        return 0.0 if self.carried is None else self.carried.mass / self.density


def refuse_spheres(blocks: Sequence[Block], place: str, what: str) -> None:
    """Refuse blocks of which one is a sphere.

    Args:
        blocks: any.
        place: key of the scene that is at fault.
        what: has no spheres, such as "limit analysis".

    Raises:
        InputError: names the first sphere.
    """
    first = next((block.name for block in blocks if block.radius), None)
    if first is not None:
        raise InputError(place, f'{what} has no spheres, and block "{first}" is one')


class ConvexShapes(NamedTuple):
    """The P convex parts of all blocks, in the body frames, as the detection kernels read them.

    A sphere is a part of one vertex, its centre, and no face: a point rounded by its radius.
    """

    solids: Polyhedra
    part_block: np.ndarray  # (P,) block of each part
    radius: np.ndarray  # (P,) largest distance of the part's surface from the block's centre of mass [m]
    size: np.ndarray  # (P,) smallest width of the part over its face normals, or the diameter of a sphere [m]
    rounding: np.ndarray  # (P,) radius of a sphere, 0 of polyhedra [m]

    @classmethod
    def of(cls, blocks: Sequence[Block], centre: np.ndarray) -> ConvexShapes:
        """The convex parts of blocks with the centres of mass ``centre`` (B, 3) [m]."""
        parts = [(index, part) for index, block in enumerate(blocks) for part in _detected(block)]
        rounding = np.array([blocks[index].radius for index, _ in parts])
        local = [part.vertices - centre[index] for index, part in parts]
        solids = Polyhedra.of([Polyhedron(own, part.faces) for own, (_, part) in zip(local, parts, strict=True)]).with_edges()
        normals = np.split(solids.normals, solids.face_start[1:-1])
        return cls(
            solids=solids,
            part_block=np.array([index for index, _ in parts]),
            radius=np.array([np.linalg.norm(own, axis=1).max() for own in local]) + rounding,
            size=np.array([2.0 * r or _width(own, n) for own, n, r in zip(local, normals, rounding, strict=True)]),
            rounding=rounding,
        )


def _detected(block: Block) -> tuple[Polyhedron, ...]:
    """The parts of a block that contact detection sees."""
    return (Polyhedron(ball_centre(block.vertices)[None], ()),) if block.radius else block.convex_parts


def _width(vertices: np.ndarray, normals: np.ndarray) -> float:
    """Smallest width of a polyhedron, corners (V, 3) [m], over its face normals (F, 3)."""
    return float(np.ptp(np.einsum("vd,fd->vf", vertices, normals), axis=0).min())


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
    friction: np.ndarray  # (G, G) coefficient of friction between groups; as the tables below also of planes, see ``rows``
    rolling: np.ndarray  # (G, G) rolling friction of spheres between groups: arm over radius
    restitution: np.ndarray  # (G, G) Newton's coefficient between groups
    laws: JointLaws  # of the joints between groups
    shapes: ConvexShapes = field(repr=False)
    deformation: Deformation | None = None  # of the blocks that deform; None: all are rigid
    absent: np.ndarray | None = None  # (B,) bool: free blocks that are not there, and meet nothing; None: all are there
    links: tuple[Link, ...] = ()  # that hold blocks together
    footings: Footings | None = None  # blocks on springs of the ground; None: all supports move as prescribed
    planes: CrackPlanes | None = None  # along which stones crack; None: no stone does

    @property
    def count(self) -> int:
        """Number of blocks B, supports included."""
        return len(self.names)

    @property
    def links_there(self) -> tuple[Link, ...]:
        """Those of which no block is absent."""
        absent = self.absent
        return self.links if absent is None else tuple(link for link in self.links if not absent[list(link.blocks)].any())

    def rows(self, a: np.ndarray | int, b: np.ndarray | int) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns of the tables of friction and joint laws for pairs of blocks: their groups, or the planes within a stone."""
        return (self.group_of[a], self.group_of[b]) if self.planes is None else self.planes.rows(a, b, self.group_of)

    def with_laws(self, material: Material) -> Assembly:
        """The blocks with the friction and the joint laws of a material.

        Raises:
            InputError: a pair that names an unknown group, or a law that friction does not allow.
        """
        friction, laws = _tables(self.groups, material, self.planes)
        return replace(self, friction=friction, laws=laws)

    @property
    def unyielding(self) -> np.ndarray:
        """Supports and footings, (B,) bool: joints deform on their other side alone."""
        out = self.fixed.copy()
        if self.footings is not None:
            out[self.footings.blocks[:, 0]] = True
        return out

    @property
    def affine(self) -> tuple[int, ...]:
        """Two zeros where blocks deform, else one: kernels know the length when they are compiled, so that rigid blocks cost no more."""
        return (0,) if self.deformation is None else (0, 0)

    @property
    def reach(self) -> np.ndarray:
        """Farthest corner of each block from its centre of mass, (B,) [m]."""
        out = np.zeros(self.count)
        np.maximum.at(out, self.shapes.part_block, self.shapes.radius)
        return out

    @cached_property
    def turning_mass(self) -> np.ndarray:
        """Least moment of inertia of each block over its reach, (B,) [kg m]: a moment over it bounds the acceleration of its corners."""
        return np.asarray(np.linalg.eigvalsh(self.inertia)[:, 0] / self.reach)

    def in_metres(self, motions: np.ndarray) -> np.ndarray:
        """Motions (..., S, 3 or 6) of supports [m] or [m/s], angular ones as what they move the farthest corner of a support by."""
        if motions.shape[-1] == 3:
            return motions
        return np.asarray(motions * np.repeat([1.0, float(self.reach[self.fixed].max(initial=0.0))], 3))

    @property
    def width(self) -> float:
        """Smallest width of a free block [m]."""
        return float(self.shapes.size[~self.fixed[self.shapes.part_block]].min())

    @classmethod
    def from_blocks(cls, blocks: Sequence[Block], material: Material | float) -> Assembly:
        """Collect blocks into an assembly.

        Args:
            blocks: checked blocks (see ``structures.geometry.checks``), at least one of them free.
            material: of the blocks and their joints; a number stands for the coefficient of friction of rigid blocks on dry rigid joints.

        Raises:
            InputError: a name given twice, no free block, a pair that names an unknown group, a law that friction does not allow, spheres
                that would deform or have springs or bonds, rolling friction without spheres, or restitution of what is elastic.
        """
        if not isinstance(material, Material):
            material = Material(friction=material)
        names = tuple(block.name for block in blocks)
        if len(set(names)) < len(names):
            twice = next(name for i, name in enumerate(names) if name in names[:i])
            raise InputError(f'block "{twice}"', "two blocks have this name")
        if all(block.fixed for block in blocks):
            raise InputError("structure", "no free block, nothing can move")
        groups = tuple(dict.fromkeys(block.group for block in blocks))
        properties = [block.mass_properties for block in blocks]
        heavy = np.array([p.volume for p in properties])
        volume = heavy - np.array([block.carried_volume for block in blocks])
        density = np.array([block.density for block in blocks])
        centre = np.array([p.centre for p in properties])
        fixed = np.array([block.fixed for block in blocks])
        _check_rigid_spheres(blocks, groups, material)
        _check_dry_spheres(blocks, groups, material.joint_laws)
        group_of = np.array([groups.index(block.group) for block in blocks])
        inertia = np.array([p.unit_inertia for p in properties]) * density[:, None, None]
        planes = CrackPlanes.of([block.stone for block in blocks], group_of, len(groups), centre) if material.stones else None
        friction, laws = _tables(groups, material, planes)
        deformation = deformation_of(fixed, group_of, groups, inertia, volume, material)
        restitution = restitution_table(material.restitution, groups, laws.by_area[: len(groups), : len(groups)], deformation is not None)
        rolling = _rolling(blocks, material.rolling_friction, groups)
        return cls(
            blocks=tuple(blocks),
            names=names,
            groups=groups,
            group_of=group_of,
            fixed=fixed,
            support_of=np.where(fixed, 0, -1),
            mass=heavy * density,
            inertia=inertia,
            centre=centre,
            volume=volume,
            friction=friction,
            rolling=rolling if planes is None else planes.grown(rolling),
            restitution=restitution if planes is None else planes.grown(restitution),
            laws=laws,
            shapes=ConvexShapes.of(blocks, centre),
            deformation=deformation,
            planes=planes,
        )

    def placed(self, position: np.ndarray, rotation: np.ndarray) -> Assembly:
        """The assembly with its blocks moved, as if built there: body frames are parallel to the world axes again.

        Args:
            position: (B, 3) centres of mass [m].
            rotation: (B, 3, 3) by which each block is turned from where it is here.
        """
        solids, part_block = self.shapes.solids, self.shapes.part_block
        of_vertex = np.repeat(part_block, np.diff(solids.vertex_start))
        of_face = part_block[solids.owner_of_face()]
        turned = solids._replace(
            vertices=np.einsum("vij,vj->vi", rotation[of_vertex], solids.vertices),
            normals=np.einsum("fij,fj->fi", rotation[of_face], solids.normals),
        )
        moved = []
        for b, block in enumerate(self.blocks):
            corners = [
                (part - self.centre[b]) @ rotation[b].T + position[b] for part in (block.vertices, *(p.vertices for p in block.parts))
            ]
            parts = tuple(Polyhedron(own, part.faces) for own, part in zip(corners[1:], block.parts, strict=True))
            new = replace(block, vertices=corners[0], parts=parts)
            if block.carried is not None:
                centre = (block.carried.centre - self.centre[b]) @ rotation[b].T + position[b]
                new = replace(new, carried=block.carried.moved(rotation[b], centre))
            moved.append(new)
        inertia = np.einsum("bij,bjk,blk->bil", rotation, self.inertia, rotation)
        shapes = self.shapes._replace(solids=turned)
        deformation = None if self.deformation is None else self.deformation.turned(rotation)
        return replace(
            self, blocks=tuple(moved), centre=np.array(position, dtype=float), inertia=inertia, shapes=shapes, deformation=deformation
        )


def _tables(groups: Sequence[str], material: Material, planes: CrackPlanes | None) -> tuple[np.ndarray, JointLaws]:
    """Friction and joint laws between groups, and of the planes within their stones."""
    friction = friction_table(material.friction, groups)
    laws = joint_table(material.joint_laws, groups, friction, material.joint_moduli)
    if planes is None:
        return friction, laws
    return planes.with_laws(material.stones, groups, friction, laws)


def _rolling(blocks: Sequence[Block], rolling: float | Mapping[str, float], groups: Sequence[str]) -> np.ndarray:
    """The rolling friction between groups, (G, G)."""
    table = rolling_table(rolling, groups)
    if table.any() and not any(block.radius for block in blocks):
        raise InputError("material.rolling_friction", "no block is a sphere, so nothing rolls by this law")
    return table


def _check_rigid_spheres(blocks: Sequence[Block], groups: Sequence[str], material: Material) -> None:
    """Refuse spheres in groups that deform."""
    for group in dict.fromkeys(block.group for block in blocks if block.radius and not block.fixed):
        if material.of_group(group, groups) is not None:
            raise InputError("material.deformable", f'the group {group} has spheres, which are rigid; deformable.{group} = "rigid" says so')


def _check_dry_spheres(blocks: Sequence[Block], groups: Sequence[str], joints: Mapping[str, JointLaw]) -> None:
    """Refuse laws of joints that are all with spheres; where others have them too, as by default, they are left out for spheres."""
    faced = np.array([any(block.group == group and not block.radius for block in blocks) for group in groups])
    free = np.array([any(block.group == group and not block.fixed for block in blocks) for group in groups])
    if not faced.all():
        refuse_unfelt(joints, groups, faced[:, None] & faced & (free[:, None] | free))
