# SPDX-License-Identifier: GPL-3.0-or-later
"""Are these blocks sound? Closed, oriented outwards, planar, convex, apart from each other: each error names its blocks. Spheres, which
have no faces of their own, are sound where their numbers are, and apart from all others.

A shell is closed and consistently oriented when each directed edge occurs once and its reverse occurs once; it points
outwards when its volume is positive. A shell with planar faces is convex when no vertex lies outside the plane of any
face. All tests run over flat arrays of all blocks at once, so that thousands of blocks take a fraction of a second.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from masonry_cd.foundation.arrays import LARGEST
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.contact.find_joints import MOST_INEXACT, inexactness
from masonry_cd.mechanics.model.blocks import Block, ConvexShapes
from masonry_cd.mechanics.model.geometry import Polyhedra, Polyhedron, area_vectors, mass_properties
from masonry_cd.mechanics.model.polygon import next_in_loop
from structures.geometry.overlap import overlapping_pairs, overlapping_spheres
from structures.size import MOST_CORNERS

FLATNESS = 1e-5  # of faces and of convexity, relative to the size of the block
SLIGHT = 1e-3  # overlap that closing gaps takes away, relative to the median size of the blocks
OVERLAP = 1e-6  # depth, relative to the size of the smaller block
FILLED = 1e-6  # volume of the convex parts of a block, relative to its own
THIN = 1e-6  # width of a face, relative to the size of the block
COMPARED = 2_000_000  # pairs of faces and vertices that are compared at a time: some 200 MB
WARPED = 2e-3  # relative to the size of the block: faces farther off than this are no warped ones but another shape
NEARLY_LEVEL = 0.02  # [rad] a face at less than this to its neighbour is a piece of the same side
LONGEST_NAME = 200  # characters of a block or group, which tables, pages and closing lines show whole


class Unsound(InputError):
    """Blocks that are not sound; ``faulty`` are the names of those that share the fault, ``blocks`` the whole structure."""

    def __init__(self, place: object, text: str, faulty: Sequence[str] = (), blocks: Sequence[Block] = ()) -> None:
        super().__init__(place, text)
        self.faulty, self.blocks = tuple(faulty), tuple(blocks)


@dataclass(frozen=True, eq=False)
class Shells:
    """S polyhedra, the block of each (S,), and the diagonals of their bounding boxes (S,) [m]."""

    flat: Polyhedra
    owner: np.ndarray
    size: np.ndarray

    @classmethod
    def of(cls, items: Sequence[tuple[int, Polyhedron]]) -> Shells:
        """From pairs of a block's number and a polyhedron."""
        flat = Polyhedra.of([shell for _, shell in items])
        first = flat.vertex_start[:-1]
        low, high = np.minimum.reduceat(flat.vertices, first), np.maximum.reduceat(flat.vertices, first)
        return cls(flat, np.array([i for i, _ in items]), np.linalg.norm(high - low, axis=1))


def check(blocks: Sequence[Block], source: str = "", overlap: float = 0.0) -> None:
    """Check a structure.

    Args:
        blocks: convex, or with convex parts.
        source: what the message begins with, such as the name of the file they come from.
        overlap: depth up to which blocks may be in each other [m].

    Raises:
        Unsound: one line that names the block, or the two blocks that overlap.
    """
    with _located(blocks, source):
        _check(blocks, overlap)


def check_shells(blocks: Sequence[Block], source: str = "") -> None:
    """Check names and shells alone: closed, outward, with planar faces. They may overlap, and need not be convex.

    Raises:
        Unsound: one line that names the block.
    """
    with _located(blocks, source):
        _check_shells(blocks)


@contextmanager
def _located(blocks: Sequence[Block], source: str) -> Iterator[None]:
    """Put the source before the message of a fault, and the structure next to it."""
    try:
        yield
    except Unsound as failure:
        failure.blocks = tuple(blocks)
        raise failure.under(source) from None


def _check_shells(blocks: Sequence[Block]) -> tuple[Shells | None, list[tuple[int, Polyhedron]]]:
    """The shells of all polyhedra and, after these, of their parts: flat, and as they are with the block of each; None of spheres alone."""
    if not blocks:
        raise Unsound("structure", "no blocks")
    _check_names(blocks)
    for block in blocks:
        _check_sphere(block)
    solid = [(i, block) for i, block in enumerate(blocks) if not block.radius]
    whole = [(i, _checked(Polyhedron(block.vertices, block.faces), block)) for i, block in solid]
    parts = [(i, _checked(part, block)) for i, block in solid for part in block.parts]
    if not whole:
        return None, []
    shells = Shells.of(whole + parts)
    _check_closed(blocks, shells)
    _check_faces(blocks, shells)
    _check_volume(blocks, shells)
    return shells, whole + parts


def deepest_overlap(blocks: Sequence[Block]) -> tuple[float, int]:
    """How deep polyhedra of a checked structure are in each other at most [m], and how many pairs are."""
    items = [(i, part) for i, block in enumerate(blocks) if not block.radius for part in block.convex_parts]
    if not items:
        return 0.0, 0
    shells = Shells.of(items)
    fixed = np.array([blocks[i].fixed for i in shells.owner])
    _, depths = overlapping_pairs(shells.flat, shells.owner, fixed, OVERLAP * shells.size)
    return float(depths.max(initial=0.0)), len(depths)


def _check(blocks: Sequence[Block], overlap: float) -> None:
    shells, items = _check_shells(blocks)
    if shells is not None:
        whole = [not block.parts for block in blocks if not block.radius]
        convex = np.array(whole + [True] * (len(items) - len(whole)))
        check_convex(blocks, shells, convex)
        if len(items) > len(whole):
            _check_filled(blocks)
            shells = Shells.of([item for item, keep in zip(items, convex, strict=True) if keep])
        _check_overlap(blocks, shells, overlap)
    if any(block.radius for block in blocks):
        _check_spheres_apart(blocks)


def _check_names(blocks: Sequence[Block]) -> None:
    seen: set[str] = set()
    for block in blocks:
        if block.name in seen:
            raise Unsound(f'block "{block.name}"', "two blocks have this name", [block.name])
        seen.add(block.name)
        for what, word in (("name", block.name), ("group", block.group)):
            if any(c < " " or "\ud800" <= c <= "\udfff" for c in word):  # results and terminals take neither
                raise Unsound(f'block "{block.name}"', f"its {what} has control characters or halves of a character", [block.name])
            if len(word) > LONGEST_NAME:
                raise Unsound(f'block "{block.name}"', f"its {what} has {len(word)} characters; at most {LONGEST_NAME}", [block.name])
        if math.isnan(block.density):
            raise Unsound(f'block "{block.name}"', "brings no density of its own, and material.density is missing", [block.name])
        if not 0 < block.density < np.inf:
            raise Unsound(f'block "{block.name}"', f"density must be above 0 kg/m3, got {block.density:g}", [block.name])


def _check_sphere(block: Block) -> None:
    """Refuse a radius that is none, and a centre that is not finite."""
    if not 0.0 <= block.radius < np.inf:
        raise Unsound(f'block "{block.name}"', f"radius must be above 0 m, got {block.radius:g}", [block.name])
    if block.radius and not np.isfinite(block.vertices).all():
        raise Unsound(f'block "{block.name}"', "its centre is not finite", [block.name])


def _checked(shell: Polyhedron, block: Block) -> Polyhedron:
    """Refuse what cannot be put into arrays: wrong shapes, indices out of range, coordinates that are not finite."""
    vertices = shell.vertices
    if vertices.ndim != 2 or vertices.shape[1] != 3 or len(vertices) < 4:
        raise Unsound(
            f'block "{block.name}"', f"vertices must be at least 4 points of 3 coordinates, got shape {vertices.shape}", [block.name]
        )
    if not np.isfinite(vertices).all():
        row = int(np.flatnonzero(~np.isfinite(vertices).all(axis=1))[0])
        raise Unsound(f'block "{block.name}"', f"vertex {row} is not finite", [block.name])
    if np.abs(vertices).max() > LARGEST:
        row = int(np.abs(vertices).max(axis=1).argmax())
        raise Unsound(f'block "{block.name}"', f"vertex {row} is more than {LARGEST:g} m away from the origin", [block.name])
    if len(shell.faces) < 4:
        raise Unsound(f'block "{block.name}"', f"open shell, it has only {len(shell.faces)} faces", [block.name])
    _refuse_faces(shell, block, "")
    for number, face in enumerate(shell.faces):
        if len(face) < 3 or len(set(face)) < len(face):
            raise Unsound(f'block "{block.name}"', f"face {number} is degenerate, it needs 3 or more different vertices", [block.name])
    return shell


def refuse_corners(block: Block, source: str = "") -> None:
    """Refuse faces of more corners than are checked in a while, and of corners that there are not.

    Raises:
        Unsound: names the block and the face.
    """
    _refuse_faces(block, block, source)
    for part in block.parts:
        _refuse_faces(part, block, source)


def _refuse_faces(shell: Block | Polyhedron, block: Block, source: str) -> None:
    """See :func:`refuse_corners`, of the shell of a block or of one of its parts."""
    where, last = f'{source}: block "{block.name}"'.removeprefix(": "), len(shell.vertices) - 1
    for number, face in enumerate(shell.faces):
        if len(face) > MOST_CORNERS:
            count = f"{len(face)} corners, at most {MOST_CORNERS} are allowed"
            raise Unsound(where, f"face {number} has {count}; make it coarser", [block.name])
        if face and (min(face) < 0 or max(face) > last):
            raise Unsound(where, f"face {number} names a vertex outside 0 to {last}", [block.name])


def _check_closed(blocks: Sequence[Block], shells: Shells) -> None:
    """Each directed edge once, and its reverse once."""
    flat, owner = shells.flat, shells.owner
    after = flat.loops[next_in_loop(flat.loop_start)]
    total = len(flat.vertices)
    edge, reverse = flat.loops * total + after, after * total + flat.loops
    face_of = flat.face_of_entry()
    _, first, counts = np.unique(edge, return_index=True, return_counts=True)
    bad = np.concatenate([first[counts > 1], np.flatnonzero(~np.isin(edge, reverse))])
    if not len(bad):
        return
    entry = int(bad[0])
    shell_of = flat.owner_of_face()[face_of]
    shell, faulty = int(shell_of[entry]), _names(blocks, owner[shell_of[bad]])
    name, face = blocks[owner[shell]].name, int(face_of[entry] - flat.face_start[shell])
    start = flat.vertex_start[shell]
    middle = 0.5 * (flat.vertices[flat.loops[entry]] + flat.vertices[after[entry]])
    ends = f"{flat.loops[entry] - start}-{after[entry] - start} at ({', '.join(f'{x:.4g}' for x in middle)})"
    if (counts > 1).any():
        raise Unsound(f'block "{name}"', f"{_twice(shells, face_of[edge == edge[entry]], face_of[reverse == edge[entry]], ends)}", faulty)
    raise Unsound(f'block "{name}"', f"open shell, edge {ends}, of face {face}, has no face on its other side", faulty)


def _twice(shells: Shells, along: np.ndarray, against: np.ndarray, ends: str) -> str:
    """Describe the fault where several faces run the same way along an edge, and others against it."""
    flat = shells.flat
    numbers = (along - flat.face_start[flat.owner_of_face()[along]]).tolist()
    first, second = (frozenset(flat.loops[flat.loop_start[f] : flat.loop_start[f + 1]].tolist()) for f in along[:2])
    if first == second:
        return f"faces {numbers[0]} and {numbers[1]} are one face given twice; leave one out"
    if len(along) + len(against) > 2:
        return f"{len(along) + len(against)} faces meet in edge {ends}, which has two sides only"
    return f"two faces run the same way along edge {ends}; one of them, such as face {numbers[0]}, is reversed"


def _check_faces(blocks: Sequence[Block], shells: Shells) -> None:
    """No face without area, none that is warped."""
    flat, owner, shell = shells.flat, shells.owner, shells.flat.owner_of_face()
    counts, points = np.diff(flat.loop_start), flat.vertices[flat.loops]
    first = np.repeat(points[flat.loop_start[:-1]], counts, axis=0)
    area = np.linalg.norm(area_vectors(flat.vertices, flat.loops, flat.loop_start), axis=1)
    extent = np.maximum.reduceat(np.linalg.norm(points - first, axis=1), flat.loop_start[:-1])
    thin = area <= 0.5 * THIN * shells.size[shell] * extent
    if thin.any():
        face = int(np.flatnonzero(thin)[0])
        number = face - flat.face_start[shell[face]]
        raise Unsound(
            f'block "{blocks[owner[shell[face]]].name}"',
            f"face {number} is degenerate, its area is {area[face]:.3g} m2",
            _names(blocks, owner[shell[thin]]),
        )
    off = np.abs(np.einsum("li,li->l", points - first, np.repeat(flat.normals, counts, axis=0)))
    distance = np.maximum.reduceat(off, flat.loop_start[:-1])
    not_flat = distance > FLATNESS * shells.size[shell]
    if not_flat.any():
        face = int(np.argmax(distance / shells.size[shell]))
        number = face - flat.face_start[shell[face]]
        raise Unsound(
            f'block "{blocks[owner[shell[face]]].name}"',
            f"face {number} is not planar, a corner is {1e3 * distance[face]:.3g} mm off "
            f"({1e3 * FLATNESS * shells.size[shell[face]]:.2g} mm would count as flat); move it into the plane, or give triangles",
            _names(blocks, owner[shell[not_flat]]),
        )


def _check_volume(blocks: Sequence[Block], shells: Shells) -> None:
    """Positive volume: the faces point outwards."""
    flat, owner = shells.flat, shells.owner
    areas = area_vectors(flat.vertices, flat.loops, flat.loop_start)
    inner = np.add.reduceat(flat.vertices, flat.vertex_start[:-1]) / np.diff(flat.vertex_start)[:, None]
    reach = flat.vertices[flat.loops[flat.loop_start[:-1]]] - inner[flat.owner_of_face()]
    volume = np.add.reduceat(np.einsum("fi,fi->f", areas, reach), flat.face_start[:-1]) / 3.0
    if (volume <= 0).any():
        worst = int(np.flatnonzero(volume <= 0)[0])
        what = "its faces are reversed, they must run counter-clockwise seen from outside" if volume[worst] < 0 else "it has no volume"
        raise Unsound(f'block "{blocks[owner[worst]].name}"', what, _names(blocks, owner[volume <= 0]))


def _check_filled(blocks: Sequence[Block]) -> None:
    """The convex parts of a block fill it."""
    for block in blocks:
        if block.parts:
            whole = mass_properties(block.vertices, block.faces).volume
            filled = sum(mass_properties(part.vertices, part.faces).volume for part in block.parts)
            if abs(filled - whole) > FILLED * whole:
                why = "they reach into each other or beyond it" if filled > whole else "some of it is in none of them"
                said = f"its parts have {filled:.6g} m3, the block has {whole:.6g} m3: {why}"
                raise Unsound(f'block "{block.name}"', f"{said}; parts left out have it cut into convex ones here", [block.name])


def check_convex(blocks: Sequence[Block], shells: Shells, wanted: np.ndarray) -> None:
    """No vertex of a shell outside the plane of any of its faces."""
    flat, owner, shell = shells.flat, shells.owner, shells.flat.owner_of_face()
    faces = np.flatnonzero(wanted[shell])
    start = np.cumsum([0, *np.diff(flat.vertex_start)[shell[faces]]])
    outside: list[tuple[float, int, int]] = []  # the worst of each portion: how far, face and vertex
    faulty: set[int] = set()
    for portion in np.split(np.arange(len(faces)), np.flatnonzero(np.diff(start[:-1] // COMPARED)) + 1):
        face, vertex, above = _heights(shells, faces[portion])
        worst = int(np.argmax(above))
        outside.append((float(above[worst]), int(face[worst]), int(vertex[worst])))
        faulty.update(shell[face[above > FLATNESS]].tolist())
    far, face_number, corner = max(outside, key=lambda found: found[0])
    if far > FLATNESS:
        s = int(shell[face_number])
        raise Unsound(
            f'block "{blocks[owner[s]].name}"',
            f"not convex, vertex {corner - flat.vertex_start[s]} lies "
            f"{1e3 * far * shells.size[s]:.3g} mm outside face {face_number - flat.face_start[s]}; "
            f"{'make its faces flat, or ' if far < WARPED else ''}split it into convex blocks",
            _names(blocks, owner[sorted(faulty)]),
        )


def _heights(shells: Shells, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Each pair of a face and a vertex of its shell (n,), and how far above the plane the vertex lies, over the size of the shell."""
    flat, shell = shells.flat, shells.flat.owner_of_face()
    counts = np.diff(flat.vertex_start)[shell[faces]]
    face, ends = np.repeat(faces, counts), np.cumsum(counts)
    vertex = np.arange(ends[-1]) - np.repeat(ends - counts, counts) + flat.vertex_start[shell[face]]
    on_face = flat.vertices[flat.loops[flat.loop_start[face]]]
    return face, vertex, np.einsum("ni,ni->n", flat.vertices[vertex] - on_face, flat.normals[face]) / shells.size[shell[face]]


def _check_overlap(blocks: Sequence[Block], shells: Shells, overlap: float) -> None:
    """No two blocks in the same place, but for a depth that is let pass [m]."""
    owner = shells.owner
    fixed = np.array([blocks[i].fixed for i in owner])
    pairs, depths = overlapping_pairs(shells.flat, owner, fixed, np.maximum(OVERLAP * shells.size, overlap))
    pairs, depths = _beyond_inexact(blocks, pairs, depths)
    if not len(depths):
        return
    deepest = int(np.argmax(depths))
    a, b = (blocks[i].name for i in sorted(owner[pairs[deepest]]))
    more = f"; {len(depths) - 1} more pairs overlap" if len(depths) > 1 else ""
    slight = depths[deepest] <= SLIGHT * float(np.median(shells.size))
    wide = _round_up(2.0 * depths[deepest])
    remedy = f"; of a file, structure.gaps = {wide:g} [m] brings their faces together, structure.overlap lets it be" if slight else ""
    raise Unsound(
        f'blocks "{a}" and "{b}"', f"they overlap by {1e3 * depths[deepest]:.4g} mm{more}{remedy}", _names(blocks, owner[pairs].ravel())
    )


def _beyond_inexact(blocks: Sequence[Block], pairs: np.ndarray, depths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs (n, 2) and depths (n,) [m] of overlaps that are more than inexact coordinates, as gaps of joints may be."""
    free = np.array([not block.fixed for block in blocks])
    if not len(depths) or depths.min() > MOST_INEXACT or not free.any():
        return pairs, depths
    shapes = ConvexShapes.of(blocks, np.zeros((len(blocks), 3)))
    deep = depths > inexactness(float(shapes.size[free[shapes.part_block]].min()))
    return pairs[deep], depths[deep]


def _check_spheres_apart(blocks: Sequence[Block]) -> None:
    """No sphere instead of another block."""
    pairs, depths = _beyond_inexact(blocks, *overlapping_spheres(blocks, OVERLAP))
    if len(depths):
        deepest = int(np.argmax(depths))
        a, b = (blocks[i].name for i in sorted(pairs[deepest]))
        more = f"; {len(depths) - 1} more pairs overlap" if len(depths) > 1 else ""
        raise Unsound(f'blocks "{a}" and "{b}"', f"they overlap by {1e3 * depths[deepest]:.4g} mm{more}", _names(blocks, pairs.ravel()))


def warp(block: Block) -> float:
    """How far the faces of a polyhedron are from planes [m]: corners off their own face, and off a neighbour's that nearly continues it."""
    flat = Polyhedra.of([Polyhedron(block.vertices, block.faces)])
    after, face = flat.loops[next_in_loop(flat.loop_start)], flat.face_of_entry()
    edge, reverse = flat.loops * len(flat.vertices) + after, after * len(flat.vertices) + flat.loops
    order = np.argsort(edge, kind="stable")
    there = order[np.searchsorted(edge[order], reverse) % len(edge)]
    neighbour = np.where(edge[there] == reverse, face[there], face)
    level = np.einsum("ei,ei->e", flat.normals[face], flat.normals[neighbour]) > math.cos(NEARLY_LEVEL)
    plane, other = np.concatenate([face[level], face]), np.concatenate([neighbour[level], face])
    counts = np.diff(flat.loop_start)[other]
    ends = np.cumsum(counts)
    entry = np.arange(ends[-1]) - np.repeat(ends - counts, counts) + np.repeat(flat.loop_start[other], counts)
    reach = flat.vertices[flat.loops[entry]] - np.repeat(flat.vertices[flat.loops[flat.loop_start[plane]]], counts, axis=0)
    return float(np.abs(np.sum(reach * np.repeat(flat.normals[plane], counts, axis=0), axis=1)).max())


def _round_up(value: float) -> float:
    """The next value of one digit above: 0.00137 -> 0.002."""
    power = 10.0 ** math.floor(math.log10(value))
    return math.ceil(value / power) * power


def _names(blocks: Sequence[Block], indices: np.ndarray) -> list[str]:
    """Names of blocks given by their indices, each once."""
    return [blocks[i].name for i in np.unique(indices)]
