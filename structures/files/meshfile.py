"""Blocks from and to meshes: OBJ with an object per block, STL with a closed shell per block, VTU with a cell per block, VTM.

Such files state neither their unit nor which way is up, so the user does; z is up here. OBJ keeps polygons and names. An STL is
a soup of triangles: shells that share no corner are different blocks, ``b0``, ``b1`` ... in the order of the file. In a VTU every
volume cell is convex and a block by itself, unless a cell array ``block`` of whole numbers joins several cells into one block with parts.

Repair mends what can be mended without a guess: corners closer than the tolerance become one, faces that have lost all their
area go, and so do faces given twice; loops are turned to agree with each other, and the shell outwards.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.arrays import LARGEST
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.files import read_text
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Faces, triangles
from structures.files import foreign, vtkfile
from structures.geometry.compound_block import compound_block

FORMATS = (".obj", ".stl", ".vtu", ".vtm")
WRITTEN = (*FORMATS, ".vtkhdf")
READERS = {suffix: f"structures.files.mesh_readers:read_{suffix[1:]}" for suffix in (".stl", ".vtu", ".vtm")}  # each runs in a child

MET = 100  # corners within the tolerance of one: a solid has a few
Shell = tuple[np.ndarray, Faces]


def read(path: Path, density: float, scale: float, up: str, repair: bool = False, tolerance: float = 1e-6) -> list[Block]:
    """Read a mesh file.

    Args:
        density: of all blocks [kg/m3].
        scale: metres per unit of the file.
        up: the axis of the file that points upwards, "y" or "z".
        repair: mend duplicate corners and the orientation of faces.
        tolerance: distance within which corners are one, when repairing [m].

    Returns:
        The blocks, not checked yet.

    Raises:
        InputError: one line that names the file, and the line or block.
    """
    blocks = []
    for name, shells in _read_obj(path) if path.suffix.lower() == ".obj" else _read_apart(path):
        parts = [(placed(vertices, scale, up), faces) for vertices, faces in shells]
        if not all((np.abs(vertices) <= LARGEST).all() for vertices, _ in parts):
            raise InputError(f'{path.name}: block "{name}": a corner has coordinates that are no finite numbers, or far too large')
        try:
            if repair:
                parts = [mended(vertices, faces, tolerance) for vertices, faces in parts]
            blocks.append(compound_block(name, parts, density, "block"))
        except InputError as failure:
            raise InputError(f"{path.name}: {failure}") from None
    if not blocks:
        raise InputError(f"{path.name}: no blocks in it")
    return blocks


def placed(vertices: np.ndarray, scale: float, up: str) -> np.ndarray:
    """Metres, with z up: y up is turned about x."""
    turned = vertices if up == "z" else np.stack([vertices[:, 0], -vertices[:, 2], vertices[:, 1]], axis=1)
    return np.asarray(turned * scale, dtype=float)


def _read_obj(path: Path) -> list[tuple[str, list[Shell]]]:
    """Objects (``o``; ``g`` where there are none) with their faces; indices count from one, or back from the end."""
    points: list[list[float]] = []
    objects: dict[str, list[list[int]]] = {}
    named = [line.split(maxsplit=1) for line in _text(path) if line[:2] in ("o ", "g ")]
    mark = "o" if any(word == "o" for word, *_ in named) else "g"
    name = "b0"
    for number, line in enumerate(_text(path), start=1):
        word, *rest = line.split("#")[0].split() or [""]
        try:
            if word == "v":
                if len(rest) < 3:
                    raise InputError(f"{path.name}: line {number}: a vertex has three coordinates: {line.strip()[:60]}")
                points.append([float(x) for x in rest[:3]])
            elif word == mark:
                name = " ".join(rest) or "b0"
            elif word == "f":
                corners = [int(corner.split("/")[0]) for corner in rest]
                if len(corners) < 3 or 0 in corners:
                    raise InputError(f"{path.name}: line {number}: a face has three corners or more, counted from 1: {line.strip()[:60]}")
                objects.setdefault(name, []).append([i - 1 if i > 0 else len(points) + i for i in corners])
        except InputError:
            raise
        except ValueError:
            raise InputError(f"{path.name}: line {number}: no number where one belongs: {line.strip()[:60]}") from None
    found = []
    vertices = np.array(points).reshape(-1, 3)
    for name, faces in objects.items():
        used = sorted({i for face in faces for i in face})
        if used[0] < 0 or used[-1] >= len(vertices):
            raise InputError(f'{path.name}: block "{name}": a face names a vertex outside 1 to {len(vertices)}')
        number_of = {old: new for new, old in enumerate(used)}
        found.append((name, [(vertices[used], tuple(tuple(number_of[i] for i in face) for face in faces))]))
    return found


def _text(path: Path) -> list[str]:
    try:
        return read_text(path, path.name).splitlines()
    except UnicodeDecodeError:
        raise InputError(f"{path.name}: no text in UTF-8") from None


def _read_apart(path: Path) -> list[tuple[str, list[Shell]]]:
    """The shells of a file that a library reads, in a child process; those of one number are one block."""
    found: dict[int, tuple[str, list[Shell]]] = {}
    for number, name, vertices, faces in foreign.read(READERS[path.suffix.lower()], path)[0]:
        found.setdefault(number, (name, []))[1].append((vertices, faces))
    return list(found.values())


def mended(vertices: np.ndarray, faces: Faces, tolerance: float) -> Shell:
    """Weld corners, drop faces without area and those given twice, and turn all loops to run counter-clockwise seen from outside.

    Args:
        tolerance: corners closer than this are one [m].

    Raises:
        InputError: this would make one corner of more than MET, on the average.
    """
    from scipy.spatial import cKDTree  # takes as long to load as a small run

    tree = cKDTree(vertices)
    met = int(tree.query_ball_point(vertices, tolerance, return_length=True).sum())
    if met > MET * len(vertices):
        raise InputError(
            f"{1e3 * tolerance:g} mm, within which corners are one, is as far as {met // len(vertices)} of them are apart; mind the units"
        )
    first, pairs = np.arange(len(vertices)), tree.query_pairs(tolerance, output_type="ndarray")
    np.minimum.at(first, pairs[:, 1], pairs[:, 0])
    while (first != first[first]).any():
        first = first[first]
    used, index = np.unique(first, return_inverse=True)
    loops = []
    for face in faces:
        loop = [int(index[i]) for i in face]
        loop = [i for i, before in zip(loop, loop[-1:] + loop[:-1], strict=True) if i != before]
        if len(set(loop)) >= 3:
            loops.append(loop)
    loops = _agreeing(list({frozenset(loop): loop for loop in reversed(loops)}.values())[::-1])
    shell = tuple(tuple(loop) for loop in loops)
    if shell and _volume(vertices[used], shell) < 0:
        shell = tuple(tuple(reversed(loop)) for loop in shell)
    return vertices[used], shell


def _agreeing(loops: list[list[int]]) -> list[list[int]]:
    """Turn loops so that neighbours run along their common edge in opposite directions, starting from the first of each shell."""
    at_edge: dict[frozenset[int], list[int]] = {}
    for number, loop in enumerate(loops):
        for a, b in zip(loop, loop[1:] + loop[:1], strict=True):
            at_edge.setdefault(frozenset((a, b)), []).append(number)
    seen: set[int] = set()
    for start in range(len(loops)):
        queue = [] if start in seen else [start]
        seen.add(start)
        while queue:
            number = queue.pop()
            loop = loops[number]
            for a, b in zip(loop, loop[1:] + loop[:1], strict=True):
                for other in at_edge.pop(frozenset((a, b)), ()):  # whoever comes first sees all
                    if other in seen:
                        continue
                    seen.add(other)
                    theirs = loops[other]
                    if (a, b) in zip(theirs, theirs[1:] + theirs[:1], strict=True):
                        loops[other] = theirs[::-1]
                    queue.append(other)
    return loops


def _volume(vertices: np.ndarray, faces: Faces) -> float:
    return float(np.linalg.det((vertices - vertices.mean(axis=0))[triangles(faces)]).sum() / 6.0)


def write(path: Path, blocks: Sequence[Block]) -> None:
    """Write blocks, z up, in metres: OBJ (an object each), STL, VTM (a data set each), or VTU and VTKHDF (a polyhedron per convex part).

    STL has single precision and no names; VTU and VTKHDF have the arrays block, fixed and group.

    Raises:
        InputError: another format.
    """
    suffix = path.suffix.lower()
    if suffix == ".obj":
        with replacing(path) as part:
            part.write_text(_obj(blocks), encoding="utf-8")
    elif suffix == ".stl":
        import trimesh

        meshes = [trimesh.Trimesh(b.vertices, triangles(b.faces), process=False) for b in blocks]
        trimesh.util.concatenate(meshes).export(path)
    elif suffix == ".vtu":
        _write_vtu(path, blocks)
    elif suffix == ".vtm":
        vtkfile.write_vtm(path, blocks)
    elif suffix == ".vtkhdf":
        vtkfile.write_vtkhdf(path, blocks)
    else:
        raise InputError(f"{path.name}: blocks are written as {', '.join(WRITTEN)}, or as .json")


def _obj(blocks: Sequence[Block]) -> str:
    lines, count = ["# z up, in metres"], 1
    for block in blocks:
        lines.append(f"o {block.name}")
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in block.vertices.tolist()]
        lines += ["f " + " ".join(str(count + i) for i in face) for face in block.faces]
        count += len(block.vertices)
    return "\n".join(lines) + "\n"


def _write_vtu(path: Path, blocks: Sequence[Block]) -> None:
    import meshio

    points: list[np.ndarray] = []
    cells: dict[str, list[Any]] = {}
    owner: dict[str, list[int]] = {}
    count = 0
    for number, block in enumerate(blocks):
        for part in block.convex_parts:
            kind = f"polyhedron{len(part.vertices)}"
            cells.setdefault(kind, []).append([np.array(face) + count for face in part.faces])
            owner.setdefault(kind, []).append(number)
            points.append(part.vertices)
            count += len(part.vertices)
    groups = list(dict.fromkeys(block.group for block in blocks))
    fixed, group = np.array([b.fixed for b in blocks], dtype=int), np.array([groups.index(b.group) for b in blocks])
    data = {
        "block": [np.array(numbers) for numbers in owner.values()],
        "fixed": [fixed[numbers] for numbers in owner.values()],
        "group": [group[numbers] for numbers in owner.values()],
    }
    meshio.Mesh(np.concatenate(points), list(cells.items()), cell_data=data).write(path)
