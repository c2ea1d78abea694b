# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks as solids for CAD programs and gmsh: STEP, BREP, and MSH, a mesh of tetrahedra block by block.

Each block is a solid of its own with plane faces, in metres, as the blocks have them; a sphere is a sphere. STEP and BREP keep the order of
the blocks, and STEP their names and groups: a product for each block, whose occurrence in the whole is named after the group. A mesh has a
physical group for each group of blocks, and nodes of its own for each block.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.gmsh_session import gmsh_session, silent
from masonry_cd.mechanics.model.blocks import Block
from structures.files import step_names

ENDINGS = (".step", ".brep", ".msh")
KEPT = 1e-7  # of its volume, by which a solid may differ from its block
HXT = 10  # gmsh's number of the method whose time grows with the number of solids, not with its square
COARSE = 0.7  # size of the elements of a mesh, in cube roots of the volume of a block


def write(path: Path, blocks: Sequence[Block]) -> None:
    """Write blocks as solids, in the format of the path's ending.

    Raises:
        InputError: a block whose faces make no solid; names it.
    """
    with gmsh_session() as gmsh:
        for key in ("OCCFixDegenerated", "OCCFixSmallEdges", "OCCFixSmallFaces", "OCCSewFaces"):
            gmsh.option.setNumber(f"Geometry.{key}", 0)
        gmsh.option.setString("Geometry.OCCTargetUnit", "M")
        tags = [_solid(gmsh, block) for block in blocks]
        gmsh.model.occ.synchronize()
        if path.suffix == ".msh":
            _mesh(gmsh, blocks, tags)
        with silent():
            gmsh.write(str(path))
    if path.suffix == ".step":
        text = step_names.put(path.read_text(encoding="ascii"), [block.name for block in blocks], [block.group for block in blocks])
        with replacing(path) as part:
            part.write_text(text, encoding="ascii")


def _solid(gmsh: Any, block: Block) -> int:
    """The solid of a block; its tag."""
    occ = gmsh.model.occ
    if block.radius:
        return int(occ.addSphere(*block.vertices.mean(axis=0), block.radius))
    points = [occ.addPoint(*vertex) for vertex in block.vertices]
    edges: dict[tuple[int, int], int] = {}
    faces = []
    try:
        for face in block.faces:
            sides = []
            for a, b in zip(face, (*face[1:], face[0]), strict=True):
                if (b, a) in edges:
                    sides.append(-edges[b, a])
                else:
                    sides.append(edges.setdefault((a, b), occ.addLine(points[a], points[b])))
            faces.append(occ.addPlaneSurface([occ.addCurveLoop(sides)]))
        tag = int(occ.addVolume([occ.addSurfaceLoop(faces)]))
        volume, wanted = abs(float(occ.getMass(3, tag))), block.mass_properties.volume - block.carried_volume
    except Exception as failure:  # gmsh raises plain ones
        reason = str(failure).splitlines()[0] if str(failure) else type(failure).__name__
        raise InputError(f'block "{block.name}"', f"its faces make no solid ({reason})") from None
    if abs(volume - wanted) > KEPT * wanted:
        raise InputError(f'block "{block.name}"', f"its solid has {volume:.9g} m3, the block has {wanted:.9g} m3")
    return tag


def _mesh(gmsh: Any, blocks: Sequence[Block], tags: Sequence[int]) -> None:
    """Mesh all solids, elements about as large as the smaller blocks allow."""
    for group in dict.fromkeys(block.group for block in blocks):
        gmsh.model.addPhysicalGroup(3, [tag for tag, block in zip(tags, blocks, strict=True) if block.group == group], name=group)
    sizes = np.array([block.mass_properties.volume - block.carried_volume for block in blocks if not block.fixed] or [1.0])
    gmsh.option.setNumber("Mesh.MeshSizeMax", COARSE * float(np.median(sizes)) ** (1.0 / 3.0))
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.option.setNumber("Mesh.Algorithm3D", HXT)
    gmsh.model.mesh.generate(3)
