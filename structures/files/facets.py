# SPDX-License-Identifier: GPL-3.0-or-later
"""Volumes of the OpenCASCADE kernel as shells of flat facets, in the child process that reads them (:mod:`structures.files.foreign`).

A flat face is its loop of corners. The sides of curved faces become chords, and what is between them strips or facets of gmsh's mesher with
all corners on the surface. Volumes that share a face have the same facets there. This module imports nothing but numpy, and gmsh when it is
called.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.gmsh_session import gmsh_session
from structures.files.foreign import Faces, Refused

FINEST = 64  # most facets along one curve
EXTERNAL = re.compile(rb"\bAPPLIED_EXTERNAL_IDENTIFICATION_ASSIGNMENT\s*\(")
FORMATS = {".step": "step", ".stp": "step", ".brep": "brep"}  # as gmsh calls them; which would use the file's name


@contextmanager
def opened(path: Path, labels: bool = True) -> Iterator[Any]:
    """The kernel with the volumes of a file in it, and their labels if requested, which take long.

    Raises:
        Refused: the file cannot be read, or holds no volume.
    """
    with gmsh_session() as gmsh:
        try:
            if path.suffix.lower() == ".geo":
                gmsh.merge(str(path))
            else:
                gmsh.option.setString("Geometry.OCCTargetUnit", "M")
                gmsh.option.setNumber("Geometry.OCCImportLabels", labels)
                gmsh.model.occ.importShapes(str(path), highestDimOnly=False, format=FORMATS[path.suffix.lower()])
            gmsh.model.occ.synchronize()
            found = gmsh.model.occ.getEntities(3)
        except Exception as failure:  # gmsh raises bare exceptions
            raise Refused(path.name, f"cannot be read: {(str(failure).splitlines() or [''])[0]}") from None
        if not found:
            hint = '; a .geo file begins with SetFactory("OpenCASCADE");' if path.suffix.lower() == ".geo" else ""
            raise Refused(path.name, f"no volume of the OpenCASCADE kernel in it{hint}")
        yield gmsh


def left_out(gmsh: Any, path: Path) -> list[str]:
    """Take faces, curves and points that bound no volume out of a CAD model: a line on these, and one on parts in other files."""
    if path.suffix.lower() == ".geo":  # a program, which draws what it needs
        return []
    found = []
    for dimension, what in ((2, "faces"), (1, "curves"), (0, "points")):
        bare = [pair for pair in gmsh.model.getEntities(dimension) if not len(gmsh.model.getAdjacencies(*pair)[0])]
        gmsh.model.occ.remove(bare, recursive=True)
        gmsh.model.occ.synchronize()
        found += [f"{len(bare)} {what}"] if bare else []
    lines = [f"{path.name}: {', '.join(found)} that bound no solid not read"] if found else []
    count = len(EXTERNAL.findall(path.read_bytes())) if FORMATS[path.suffix.lower()] == "step" else 0
    return [*lines, *([f"{path.name}: {count} parts of it are in other files, which are not read; export one file"] if count else [])]


def curved_faces(gmsh: Any, chord: float | None, source: str) -> int:
    """How many faces are curved.

    Raises:
        Refused: some are, and nothing says how far their facets may be off.
    """
    curved = [tag for _, tag in gmsh.model.getEntities(2) if gmsh.model.getType(2, tag) != "Plane"]
    if curved and chord is None:
        where = ", ".join(f"{x:.4g}" for x in gmsh.model.occ.getCenterOfMass(2, curved[0]))
        raise Refused(
            "structure.chord",
            f"missing; {source} has {len(curved)} curved face{'s' if len(curved) > 1 else ''}, the first at "
            f"({where}): say how far flat facets may be off",
        )
    return len(curved)


def shells_of(
    gmsh: Any, volumes: Sequence[int], chord: float | None, tolerance: float, source: str
) -> tuple[list[list[np.ndarray]], float]:
    """The facets of the shells of some volumes, polygons (n, 3) each, and how far they are off curved faces.

    Args:
        gmsh: the kernel.
        volumes: numbers of the volumes.
        chord: how far a facet may be off its curved face.
        tolerance: corners this close are one.
        source: name of the file.

    Raises:
        Refused: facets that stay farther off than the chord error allowed.
    """
    gmsh.model.mesh.clear()
    gmsh.model.occ.synchronize()
    faces = {tag: [f for _, f in gmsh.model.getBoundary([(3, tag)], oriented=False)] for tag in volumes}
    curves = {f: [abs(c) for _, c in gmsh.model.getBoundary([(2, f)], oriented=False)] for own in faces.values() for f in own}
    curved = {f for f in curves if gmsh.model.getType(2, f) != "Plane"}
    for curve in {c for own in curves.values() for c in own}:
        gmsh.model.mesh.setTransfiniteCurve(curve, 1 + _segments(gmsh, curve, chord, tolerance))
    gmsh.model.mesh.generate(1)
    nodes = {curve: _nodes(gmsh, curve) for curve in {c for own in curves.values() for c in own}}
    loops = {f: _loop([nodes[c] for c in own], tolerance) for f, own in curves.items() if f not in curved}
    facets = {f: strip for f in curved if (strip := _strip([nodes[c] for c in curves[f]], tolerance)) is not None}
    facets |= {f: [loop] for f, loop in loops.items() if loop is not None}
    facets |= _meshed(gmsh, curves.keys() - facets.keys(), curved)
    off = max((_off(gmsh, face, facets[face]) for face in curved), default=0.0)
    if curved and chord is not None and off > chord:
        raise Refused("structure.chord", f"{source}: some facets stay {off / chord:.3g} times the chord off; cut smaller stones")
    return [[polygon for f in faces[volume] for polygon in facets[f]] for volume in volumes], off


def _segments(gmsh: Any, curve: int, chord: float | None, tolerance: float) -> int:
    """How many chords stand for a curve so that none is farther off than half the chord error: surfaces add as much again."""
    if gmsh.model.getType(1, curve) == "Line" or chord is None:
        return 1
    (start,), (end,) = gmsh.model.getParametrizationBounds(1, curve)
    closed = np.linalg.norm(np.subtract(*(gmsh.model.getValue(1, curve, [t]) for t in (start, end)))) <= tolerance
    count = 3 if closed else 1
    while count < FINEST:
        ends = gmsh.model.getValue(1, curve, np.linspace(start, end, count + 1)).reshape(-1, 3)
        middle = gmsh.model.getValue(1, curve, np.linspace(start, end, 2 * count + 1)[1::2]).reshape(-1, 3)
        if np.linalg.norm(middle - 0.5 * (ends[:-1] + ends[1:]), axis=1).max() <= 0.5 * chord:
            break
        count += 1
    return count


def _nodes(gmsh: Any, curve: int) -> np.ndarray:
    """The nodes of a curve from its start to its end; those of a closed one begin and end alike."""
    _, places, at = gmsh.model.mesh.getNodes(1, curve)
    start, end = (gmsh.model.getValue(1, curve, bound) for bound in gmsh.model.getParametrizationBounds(1, curve))
    return np.concatenate([[start], places.reshape(-1, 3)[np.argsort(at)], [end]])


def _loop(sides: Sequence[np.ndarray], tolerance: float) -> np.ndarray | None:
    """The corners of a face that its sides enclose in a single loop; None where there are several."""
    left = [np.asarray(side) for side in sides]
    loop = [left.pop(0)]
    while left:
        end = loop[-1][-1]
        k = next((k for k, side in enumerate(left) if min(np.linalg.norm(side[[0, -1]] - end, axis=1)) <= tolerance), None)
        if k is None:
            return None
        side = left.pop(k)
        loop.append(side if np.linalg.norm(side[0] - end) <= tolerance else side[::-1])
    return np.concatenate([side[:-1] for side in loop])


def _strip(sides: Sequence[np.ndarray], tolerance: float) -> list[np.ndarray] | None:
    """The facets of a face around a body, such as a drum's: between two closed curves of as many nodes; None for any other face."""
    if len(sides) != 2 or len(sides[0]) != len(sides[1]) or any(np.abs(side[0] - side[-1]).max() > tolerance for side in sides):
        return None
    below, above = sides[0][:-1], sides[1][:-1]
    turns = [np.roll(run, k, axis=0) for run in (above, above[::-1]) for k in range(len(above))]
    facing = min(turns, key=lambda turn: float(np.linalg.norm(turn - below, axis=1).sum()))
    corners = np.stack([below, np.roll(below, -1, axis=0), np.roll(facing, -1, axis=0), facing], axis=1)
    return [flat for quadrilateral in corners for flat in _flat(quadrilateral)]


def _meshed(gmsh: Any, faces: set[int], curved: set[int]) -> dict[int, list[np.ndarray]]:
    """Flat facets by gmsh's mesher, for curved faces and flat ones with holes: their corners are nodes of their sides, if it can be."""
    if not faces:
        return {}
    for name, value in (("MeshSizeExtendFromBoundary", 0), ("MeshSizeMax", 1e22), ("MeshOnlyVisible", 1)):
        gmsh.option.setNumber(f"Mesh.{name}", value)
    gmsh.model.setVisibility(gmsh.model.getEntities(), 0)
    gmsh.model.setVisibility([(2, face) for face in faces], 1, recursive=True)
    for face in faces & curved:
        if len(gmsh.model.getBoundary([(2, face)], oriented=False)) == 4:
            gmsh.model.mesh.setTransfiniteSurface(face)
            gmsh.model.mesh.setRecombine(2, face)
    gmsh.model.mesh.generate(2)
    gmsh.option.setNumber("Mesh.MeshOnlyVisible", 0)
    tags, places, _ = gmsh.model.mesh.getNodes()
    place_of = dict(zip(tags, places.reshape(-1, 3), strict=True))
    out: dict[int, list[np.ndarray]] = {}
    for face in faces:
        out[face] = []
        kinds, _, numbers = gmsh.model.mesh.getElements(2, face)
        for kind, nodes in zip(kinds, numbers, strict=True):
            corners = gmsh.model.mesh.getElementProperties(kind)[3]
            out[face] += [flat for row in nodes.reshape(-1, corners) for flat in _flat(np.array([place_of[node] for node in row]))]
    return out


def _off(gmsh: Any, face: int, facets: Sequence[np.ndarray]) -> float:
    """How far the middles of facets are off their curved face at most."""
    centres = np.array([facet.mean(axis=0) for facet in facets])
    nearest = np.reshape(gmsh.model.getClosestPoint(2, face, centres.ravel())[0], (-1, 3))
    return float(np.linalg.norm(centres - nearest, axis=1).max())


def _flat(polygon: np.ndarray) -> list[np.ndarray]:
    """A quadrilateral whose corners lie in a plane stays one; otherwise its two triangles."""
    if len(polygon) == 3:
        return [polygon]
    a, b, c, d = polygon
    size = np.linalg.norm(c - a) * np.linalg.norm(d - b)
    if abs(np.linalg.det([b - a, c - a, d - a])) <= 1e-7 * size * np.sqrt(size):
        return [polygon]
    return [polygon[[0, 1, 2]], polygon[[0, 2, 3]]]


def gathered(polygons: Sequence[np.ndarray]) -> tuple[np.ndarray, Faces]:
    """Polygons as vertices, each corner by itself, and faces."""
    ends = np.cumsum([0, *map(len, polygons)])
    return np.concatenate(polygons), tuple(tuple(range(a, b)) for a, b in pairwise(ends))
