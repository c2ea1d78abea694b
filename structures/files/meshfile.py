# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks from and to meshes; which formats there are is in :mod:`structures.files.formats`.

Most such files state neither their unit nor which way is up, so the user does; z is up here. OBJ keeps polygons and names. In a soup of
triangles closed shells are different blocks, ``b0``, ``b1`` ... in the order of the file, whether or not they share corners. In a VTU every
volume cell is convex and a block by itself, unless a cell array ``block`` of whole numbers joins several cells into one block with parts.
What this program writes holds one line more, a comment or an attribute, with names, groups, supports and densities, which it reads back.

Repair fixes what needs no guess: corners closer than the tolerance become one, faces that have lost all their area go, and
so do faces given twice, fins and walls inside; edges of more than two faces are taken apart (:mod:`structures.files.manifold`); loops are
turned to agree with each other, and the shell outwards.
"""

from __future__ import annotations

import itertools
import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.arrays import LARGEST
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.extras import require
from masonry_cd.foundation.files import read_text
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Faces, triangles
from structures.files import foreign, solidfile, vtkfile
from structures.files.foreign import FileShell
from structures.files.formats import CAD, FORMATS
from structures.files.manifold import apart_at_edges, outwards, without_fins
from structures.geometry.compound_block import compound_block
from structures.geometry.near_points import numbered

MET = 100  # corners within the tolerance of one: a solid has a few
MARK = "masonry-cd: "  # before what the formats themselves have no place for: unit, axis, and names, groups and supports
MARKED = ("obj", "vtu", "vtm", "vtkhdf", "msh")
DEFAULT = "block"  # group of a block for which the file states none


@dataclass(frozen=True)
class Loaded:
    """Contents of a mesh file, with its statements on unit and axes."""

    stones: list[list[FileShell]]  # the convex parts of each block, or its shell; the first has its name, group and support
    metres: float | None = None  # of its unit
    up: str | None = None
    firm: bool = True  # whether what it says is to be relied upon
    notes: Sequence[str] = ()  # what of it was not read


def load(path: Path, format_: str, **asked: Any) -> Loaded:
    """Read a mesh file.

    Args:
        path: of the file.
        format_: of :data:`structures.files.formats.FORMATS`, all but json.
        asked: keywords of its reader, ``chord`` of a CAD model.

    Raises:
        InputError: one line that names the file, and the line or block.
    """
    pieces, figures, notes = foreign.read(FORMATS[format_].reader, path, asked, foreign.of_model(path) if format_ in CAD else None)
    parts: dict[int, list[FileShell]] = {}
    for piece in pieces:
        parts.setdefault(piece.number, []).append(piece)
    stones, marks = list(parts.values()), _marks(path, format_)
    if marks and len(marks["blocks"]) == len(stones):
        for stone, mark in zip(stones, marks["blocks"], strict=True):
            name, group, density = str(mark["name"]), str(mark["group"]), float(mark.get("density", 0.0))
            stone[0] = stone[0]._replace(name=name, group=group, fixed=bool(mark["fixed"]), density=density)
        return Loaded(stones, 1.0, "z", firm=False, notes=notes)
    _name_apart(stones)
    if format_ in CAD:
        for stone in stones:
            for k, piece in enumerate(stone):
                vertices, faces = repaired(piece.vertices, piece.faces, figures[0])
                stone[k] = piece._replace(vertices=vertices, faces=faces)
        return Loaded(stones, 1.0 if format_ == "step" else None, notes=notes)
    if format_ in ("gltf", "vrml"):
        return Loaded(stones, 1.0, "y", firm=False, notes=notes)
    if format_ in ("3mf", "dxf") and figures and figures[0] > 0.0:
        return Loaded(stones, float(figures[0]), "z" if format_ == "3mf" else None, notes=notes)
    return Loaded(stones, notes=notes)


def _name_apart(stones: Sequence[list[FileShell]]) -> None:
    """Number the blocks that share a name, as copies of one object do: ``name.0``, ``name.1`` ..., since the name of a block is its own."""
    count = Counter(stone[0].name for stone in stones)
    taken, numbers = set(count), {name: itertools.count() for name, times in count.items() if times > 1}
    for stone in stones:
        if (name := stone[0].name) in numbers:
            stone[0] = stone[0]._replace(name=next(own for k in numbers[name] if (own := f"{name}.{k}") not in taken))


def blocks_of(
    loaded: Loaded, source: str, density: float, scale: float, up: str, repair: bool = False, tolerance: float = 1e-6
) -> list[Block]:
    """The blocks of a mesh file in metres with z up.

    Args:
        loaded: the file.
        source: its name in messages.
        density: of the blocks for which the file states none [kg/m3].
        scale: metres per unit of the file.
        up: the axis of the file that points upwards, "y" or "z".
        repair: merge duplicate corners and the orientation of faces.
        tolerance: distance within which corners are one, when repairing [m].

    Returns:
        The blocks, not checked yet.

    Raises:
        InputError: one line that names the file and the block.
    """
    blocks = []
    for stone in loaded.stones:
        of, parts = stone[0], [(placed(piece.vertices, scale, up), piece.faces) for piece in stone]
        if not all((np.abs(vertices) <= LARGEST).all() for vertices, _ in parts):
            raise InputError(source, f'block "{of.name}": a corner has coordinates that are no finite numbers, or far too large')
        try:
            if repair:
                parts = [repaired(vertices, faces, tolerance) for vertices, faces in parts]
            if not all(len(vertices) for vertices, _ in parts):
                raise InputError(f'block "{of.name}"', "a face without corners")
            group = of.group or ("base" if of.fixed else DEFAULT)
            block = compound_block(of.name, parts, of.density if of.density > 0.0 else density, group)
            blocks.append(replace(block, fixed=True) if of.fixed else block)
        except InputError as failure:
            raise failure.under(source) from None
    if not blocks:
        raise InputError(source, "no blocks in it")
    return blocks


def placed(vertices: np.ndarray, scale: float, up: str) -> np.ndarray:
    """Metres, with z up: y up is turned about x."""
    turned = vertices if up == "z" else np.stack([vertices[:, 0], -vertices[:, 2], vertices[:, 1]], axis=1)
    return np.asarray(turned * scale, dtype=float)


def _marks(path: Path, format_: str) -> dict[str, Any] | None:
    """Return the notes that this program wrote next to the shells of a file; None where it did not write it, or another has changed it."""
    if format_ not in MARKED:
        return None
    try:
        if format_ == "vtkhdf":
            import h5py

            with h5py.File(path, "r") as file:
                text = str(file["VTKHDF"].attrs[MARK.strip(" :")])
        else:
            text = next(line.partition(MARK)[2] for line in read_text(path, path.name).splitlines() if MARK in line)
            text = text.removesuffix("-->").strip()
        marks = json.loads(text)
        sound = marks["units"] == "m" and all({"name", "group", "fixed"} <= set(block) for block in marks["blocks"])
        sound = sound and all(isfinite(block.get("density", 0.0)) for block in marks["blocks"])
    except (OSError, KeyError, ValueError, TypeError, StopIteration, InputError, RecursionError):
        return None
    return marks if sound else None


def marks_of(blocks: Sequence[Block]) -> str:
    """Unit, axis, and what the shells of blocks do not say of them, as one line."""
    entries = [{"name": b.name, "group": b.group, "fixed": b.fixed, **({"density": b.density} if b.density > 0.0 else {})} for b in blocks]
    text = json.dumps({"units": "m", "up": "z", "blocks": entries})
    return MARK + text.replace("--", "\\u002d\\u002d")  # which would end a comment of XML


def repaired(vertices: np.ndarray, faces: Faces, tolerance: float) -> tuple[np.ndarray, Faces]:
    """Weld corners, drop faces without area and those given twice, and turn all loops to run counter-clockwise seen from outside.

    Args:
        tolerance: corners closer than this are one [m].

    Raises:
        InputError: this would make one corner of more than MET, on the average.
    """
    from scipy.spatial import cKDTree  # takes as long to load as a small run

    met = int(cKDTree(vertices).query_ball_point(vertices, tolerance, return_length=True).sum())
    if met > MET * len(vertices):
        raise InputError(
            "",
            f"{1e3 * tolerance:g} mm, within which corners are one, is as far as {met // len(vertices)} of them are apart; mind the units",
        )
    points, index = numbered(vertices, tolerance)
    loops = []
    for face in faces:
        loop = [int(index[i]) for i in face]
        loop = [i for i, before in zip(loop, loop[-1:] + loop[:-1], strict=True) if i != before]
        if len(set(loop)) >= 3:
            loops.append(loop)
    loops = _agreeing(without_fins(points, list({frozenset(loop): loop for loop in reversed(loops)}.values())[::-1]))
    points, loops = apart_at_edges(points, outwards(points, loops))
    shell = tuple(tuple(loop) for loop in loops)
    if shell and _volume(points, shell) < 0:
        shell = tuple(tuple(reversed(loop)) for loop in shell)
    return points, shell


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
                others = at_edge.pop(frozenset((a, b)), [])  # whoever comes first sees all
                for other in others if len(others) == 2 else ():
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


WRITERS = {".stl": "trimesh", ".vtu": "meshio", ".vtm": "pyvista", ".vtkhdf": "pyvista"}  # what each ending is written by


def write(path: Path, blocks: Sequence[Block]) -> None:
    """Write blocks, z up, in metres: OBJ (an object each), STL, VTM (a data set each), or VTU and VTKHDF (a polyhedron per convex part).

    STL has single precision and no names; VTU and VTKHDF have the arrays block, fixed and group.

    Raises:
        InputError: another format; a library that is not installed.
    """
    suffix = path.suffix.lower()
    require_writer(path)
    if suffix == ".vtm":  # its folder of data sets bears its name
        vtkfile.write_vtm(path, blocks)
        with replacing(path) as part:
            part.write_text(_marked(path, blocks), encoding="utf-8")
        return
    with replacing(path) as part:
        _write(part, suffix, blocks)


def require_writer(path: Path) -> None:
    """Check that blocks can be written into a file of this ending, before anything is made.

    Raises:
        InputError: another format; a library that is not installed.
    """
    suffix = path.suffix.lower()
    written = [ending for format_ in FORMATS.values() if format_.written for ending in format_.endings]
    if suffix not in (*written, *solidfile.ENDINGS):
        raise InputError(path.name, f"blocks are written as {', '.join(written)}")
    if suffix in WRITERS:
        require(f"blocks as {suffix}", WRITERS[suffix])


def _write(path: Path, suffix: str, blocks: Sequence[Block]) -> None:
    """Write blocks into one file."""
    if suffix == ".obj":
        path.write_text(_obj(blocks), encoding="utf-8")
    elif suffix == ".stl":
        import trimesh

        meshes = [trimesh.Trimesh(b.vertices, triangles(b.faces), process=False) for b in blocks]
        trimesh.util.concatenate(meshes).export(path)
    elif suffix == ".vtu":
        vtkfile.write_vtu(path, blocks)
        path.write_text(_marked(path, blocks), encoding="utf-8")
    elif suffix == ".vtkhdf":
        import h5py

        vtkfile.write_vtkhdf(path, blocks)
        with h5py.File(path, "r+") as file:
            file["VTKHDF"].attrs[MARK.strip(" :")] = marks_of(blocks).removeprefix(MARK)
    else:
        solidfile.write(path, blocks)
    if suffix == ".msh":
        with path.open("a", encoding="utf-8") as file:
            file.write(f"$Comments\n{marks_of(blocks)}\n$EndComments\n")


def _marked(path: Path, blocks: Sequence[Block]) -> str:
    """The text of a file of VTK with the marks of the blocks at its end."""
    return path.read_text(encoding="utf-8").rstrip() + f"\n<!-- {marks_of(blocks)} -->\n"


def _obj(blocks: Sequence[Block]) -> str:
    lines, count = ["# z up, in metres", f"# {marks_of(blocks)}"], 1
    for block in blocks:
        lines += [f"o {block.name}", f"g {block.group}"]
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in block.vertices.tolist()]
        lines += ["f " + " ".join(str(count + i) for i in face) for face in block.faces]
        count += len(block.vertices)
    return "\n".join(lines) + "\n"
