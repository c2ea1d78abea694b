# SPDX-License-Identifier: GPL-3.0-or-later
"""The solid that the blocks fill together, meshed by gmsh in tetrahedra.

The blocks are united first, so that the mesh does not have to follow the joints and may be as coarse as the structure allows; blocks
of another density or stiffness stay apart, with a common face. Boolean operations of gmsh cost time with everything in its model:
the union is therefore built from clusters of neighbours, each in a model of its own (1,254 blocks: 6 s instead of 56 s). Supports
are not meshed: their imprint on the structure shows where it is held.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import mass_properties

CLUSTER = 48  # blocks united at a time
MERGE = 24  # united clusters united at a time
VOLUME = 1e-6  # relative difference between the volume of the mesh and of the blocks that is accepted
MOST = 60_000  # tetrahedra that the default size aims to stay below
LIMIT = 1e6  # of them, whatever size is requested: gigabytes of a factor
FILL = 8.5  # a regular tetrahedron fills side^3 / 8.5

Tags = list[tuple[int, int]]


@dataclass(frozen=True, eq=False)
class SolidMesh:
    """T tetrahedra on N points, and the triangles by which S supports hold them."""

    points: np.ndarray  # (N, 3) [m]
    tetrahedra: np.ndarray  # (T, 4)
    kind: np.ndarray  # (T,) index into the kinds of material
    support: np.ndarray  # (F,) index of the support that a triangle touches
    triangles: np.ndarray  # (F, 3)
    size: float  # requested [m]

    @property
    def volume(self) -> float:
        """[m3]"""
        a, b, c, d = (self.points[self.tetrahedra[:, k]] for k in range(4))
        return float(np.abs(np.einsum("ti,ti->t", b - a, np.cross(c - a, d - a))).sum() / 6.0)


def solid_mesh(blocks: Sequence[Block], kinds: np.ndarray, size: float | None = None) -> SolidMesh:
    """Mesh the union of the free blocks.

    Args:
        blocks: of the structure, supports included.
        kinds: (B,) blocks of equal kind are united; the entries of supports are not read.
        size: of the tetrahedra [m]; about the thickness of the structure when not given.

    Raises:
        InputError: gmsh is missing or cannot mesh the solid.
    """
    from masonry_cd.foundation.gmsh_session import gmsh_session

    volume = sum(mass_properties(b.vertices, b.faces).volume for b in blocks if not b.fixed)
    _check_count(volume, size)
    with gmsh_session() as gmsh, tempfile.TemporaryDirectory() as folder:
        home = gmsh.model.getCurrent()
        for united in (True, False):  # where the union fails, the blocks are only glued to each other: slow, but it always works
            gmsh.model.add("solid")
            try:
                mesh = _meshed(gmsh, blocks, kinds, size, Path(folder) if united else None)
                problem = f"the mesh fills {mesh.volume:.9g} of {volume:.9g} m3"
                if abs(mesh.volume - volume) <= VOLUME * volume:
                    return mesh
            except Exception as failure:  # gmsh raises nothing narrower
                problem = str(failure).splitlines()[0] if str(failure) else "gmsh gave no reason"
            finally:
                gmsh.model.setCurrent("solid")  # a failure may have left another one
                gmsh.model.remove()
                gmsh.model.setCurrent(home)
    raise InputError("modal", f"gmsh cannot mesh the solid of these blocks: {problem}")


def _check_count(volume: float, size: float | None) -> None:
    """Refuse tetrahedra of a size that makes too many of them."""
    count = 0.0 if size is None else FILL * volume / size / size / size
    if not count <= LIMIT:
        raise InputError("modal.mesh_size", f"{size:g} m makes about {count:.2g} tetrahedra, at most {LIMIT:g} are allowed")


def _meshed(gmsh: Any, blocks: Sequence[Block], kinds: np.ndarray, size: float | None, folder: Path | None) -> SolidMesh:
    """Build the solid in gmsh's current model and mesh it."""
    occ = gmsh.model.occ
    gmsh.option.setNumber("Geometry.OCCAutoFix", 0)  # repairs that sound blocks do not need
    home, free = gmsh.model.getCurrent(), np.array([not block.fixed for block in blocks])
    solids, solid_kind = [], []
    for kind in np.unique(kinds[free]):
        members = [blocks[int(i)] for i in np.flatnonzero(free & (kinds == kind))]
        parts: Sequence[Block | Path] = [_unite(gmsh, members, folder, f"k{kind}")] if folder else members
        gmsh.model.setCurrent(home)
        added = [tag for part in parts for tag in _add(occ, part)]
        solids += added
        solid_kind += [kind] * len(added)
    supports = [i for i in range(len(blocks)) if blocks[i].fixed]
    tools = [tag for i in supports for tag in _add(occ, blocks[i])]
    pieces = occ.fragment(solids, tools)[1] if len(solids) + len(tools) > 1 else [solids]
    occ.synchronize()
    imprints = _imprints(gmsh, pieces, len(solids))
    kind_of = {tag: kind for made, kind in zip(pieces[: len(solids)], solid_kind, strict=True) for _, tag in made}
    occ.remove(list({tag for made in pieces[len(solids) :] for tag in made}), recursive=True)
    occ.synchronize()
    size = size or _default_size(gmsh, kind_of)
    for option in ("MeshSizeMin", "MeshSizeMax"):
        gmsh.option.setNumber(f"Mesh.{option}", size)
    gmsh.model.mesh.generate(3)
    return _collected(gmsh, kind_of, imprints, size)


def _unite(gmsh: Any, blocks: Sequence[Block], folder: Path, name: str) -> Path:
    """A file with the union of blocks, built cluster by cluster."""
    middles = np.array([block.vertices.mean(axis=0) for block in blocks])
    parts: list[Path] = []
    for k, cluster in enumerate(_clusters(middles, np.arange(len(blocks)))):
        parts.append(_fuse(gmsh, [blocks[i] for i in cluster], folder / f"{name}-{k}.brep"))
    level = 0
    while len(parts) > 1:
        level += 1
        groups = [parts[k : k + MERGE] for k in range(0, len(parts), MERGE)]
        parts = [_fuse(gmsh, group, folder / f"{name}-{level}-{k}.brep") for k, group in enumerate(groups)]
    return parts[0]


def _clusters(middles: np.ndarray, members: np.ndarray) -> list[np.ndarray]:
    """Halve a set of blocks across its longest side until the pieces are small."""
    if len(members) <= CLUSTER:
        return [members]
    axis = int(np.argmax(np.ptp(middles[members], axis=0)))
    order = members[np.argsort(middles[members, axis], kind="stable")]
    half = len(order) // 2
    return _clusters(middles, order[:half]) + _clusters(middles, order[half:])


def _fuse(gmsh: Any, parts: Sequence[Block | Path], path: Path) -> Path:
    """Unite blocks or files of solids in a model of their own, and write the union to a file."""
    gmsh.model.add("cluster")
    try:
        tags = [tag for part in parts for tag in _add(gmsh.model.occ, part)]
        if len(tags) > 1:
            gmsh.model.occ.fuse(tags[:1], tags[1:])
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    finally:
        gmsh.model.remove()
    return path


def _add(occ: Any, part: Block | Path) -> Tags:
    """Add a block, or the solids of a file."""
    if isinstance(part, Path):
        return [tag for tag in occ.importShapes(str(part)) if tag[0] == 3]
    corners = [occ.addPoint(*vertex) for vertex in part.vertices]
    lines: dict[tuple[int, int], int] = {}
    faces = []
    for face in part.faces:
        loop = []
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            if (b, a) in lines:
                loop.append(-lines[b, a])
            else:
                lines[a, b] = occ.addLine(corners[a], corners[b])
                loop.append(lines[a, b])
        faces.append(occ.addPlaneSurface([occ.addCurveLoop(loop)]))
    return [(3, occ.addVolume([occ.addSurfaceLoop(faces)]))]


def _imprints(gmsh: Any, pieces: Sequence[Tags], solids: int) -> list[set[int]]:
    """For each support the surfaces that it shares with the structure."""

    def skin(made: Tags) -> set[int]:
        return {surface for tag in made for _, surface in gmsh.model.getBoundary([tag], oriented=False)}

    whole = set().union(*(skin(made) for made in pieces[:solids]))
    return [skin(made) & whole for made in pieces[solids:]]


def _default_size(gmsh: Any, volumes: dict[int, int]) -> float:
    """Twice the volume over the surface, which is the thickness of a wall and half that of a pillar; larger for large structures."""
    occ = gmsh.model.occ
    volume = sum(occ.getMass(3, tag) for tag in volumes)
    skin = gmsh.model.getBoundary([(3, tag) for tag in volumes], combined=True, oriented=False)
    area = sum(occ.getMass(2, tag) for _, tag in skin)
    return float(max(2.0 * volume / area, (FILL * volume / MOST) ** (1.0 / 3.0)))


def _collected(gmsh: Any, volumes: dict[int, int], imprints: Sequence[set[int]], size: float) -> SolidMesh:
    """Read the mesh out of gmsh."""
    mesh = gmsh.model.mesh
    tags, coordinates, _ = mesh.getNodes()
    row = np.zeros(int(tags.max()) + 1, dtype=np.int64)
    row[tags.astype(np.int64)] = np.arange(len(tags))

    def corners(dimension: int, entity: int, nodes: int) -> np.ndarray:
        found = mesh.getElements(dimension, entity)[2]
        return row[found[0].astype(np.int64)].reshape(-1, nodes) if len(found) else np.zeros((0, nodes), dtype=np.int64)

    tets = {tag: corners(3, tag, 4) for tag in volumes}
    held = [(s, corners(2, surface, 3)) for s, surfaces in enumerate(imprints) for surface in sorted(surfaces)]
    tetrahedra = np.concatenate(list(tets.values()))
    triangles = np.concatenate([t for _, t in held]) if held else np.zeros((0, 3), dtype=np.int64)
    used, flat = np.unique(tetrahedra, return_inverse=True)
    return SolidMesh(
        points=coordinates.reshape(-1, 3)[used],
        tetrahedra=flat.reshape(-1, 4),
        kind=np.repeat([volumes[tag] for tag in tets], [len(t) for t in tets.values()]),
        support=np.repeat([s for s, _ in held], [len(t) for _, t in held]).astype(np.int64),
        triangles=np.searchsorted(used, triangles),
        size=size,
    )
