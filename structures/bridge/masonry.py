# SPDX-License-Identifier: GPL-3.0-or-later
"""Voussoirs, piers and abutments of a bridge, drawn out across the road, and the faces on which its fill lies."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.fill import FillFace
from masonry_cd.mechanics.model.geometry import Faces
from masonry_cd.mechanics.model.polygon import clip
from structures.bridge.layout import SAME, BridgeLayout, BridgeSupport
from structures.courser.bond import even
from structures.courser.courses import divided
from structures.geometry.compound_block import compound_block
from structures.geometry.prism import prism_xz, rectangle

SLAB = 0.5  # thickness of the fixed feet [m]


def drawn_out(layout: BridgeLayout, polygon: np.ndarray, near: float, far: float) -> tuple[np.ndarray, Faces]:
    """A polygon (n, 2) of the x-z plane between two places across the road, slanted by the skew."""
    vertices, faces = prism_xz(polygon, near, far)
    vertices[:, 0] += layout.slant * vertices[:, 1]
    return vertices, faces


def face_of(layout: BridgeLayout, line: np.ndarray, near: float, far: float) -> np.ndarray:
    """Corners (4, 3) of the face over a line (2, 2) of the x-z plane from left to right, counter-clockwise seen from above [m]."""
    (x0, z0), (x1, z1) = line
    corners = np.array([[x0, near, z0], [x1, near, z1], [x1, far, z1], [x0, far, z0]])
    corners[:, 0] += layout.slant * corners[:, 1]
    return corners


def arches(layout: BridgeLayout, density: float) -> tuple[list[Block], list[FillFace]]:
    """The voussoirs, ``arch1.v3``, of several rings ``arch1_ring2.v3``, of several strips ``arch1.v3.2``; and their extradoses."""
    blocks, faces = list[Block](), list[FillFace]()
    for number, profile in enumerate(layout.profiles, start=1):
        rings = len(profile.lines) - 1
        for r, (inner, outer) in enumerate(pairwise(profile.lines)):
            group = f"arch{number}" if rings == 1 else f"arch{number}_ring{r + 1}"
            for k in range(len(inner) - 1):
                polygon = np.array([inner[k], inner[k + 1], outer[k + 1], outer[k]])
                for s, (near, far) in enumerate(pairwise(_cuts(layout, k + r)), start=1):
                    name = f"{group}.v{k + 1}" + (f".{s}" if layout.keys.strips > 1 else "")
                    blocks.append(Block(name, *drawn_out(layout, polygon, near, far), density, group))
                    low, high = max(near, -layout.clear), min(far, layout.clear)
                    line = _bare(layout, number - 1, outer[k : k + 2])
                    if r == rings - 1 and high - low > SAME and len(line):
                        faces.append(FillFace(name, "extrados", face_of(layout, line, low, high)))
    return blocks, faces


def _bare(layout: BridgeLayout, span: int, line: np.ndarray) -> np.ndarray:
    """Return the part of a line (2, 2) of the extrados of a span above the backing next to it, (2, 2) or none (0, 2) [m]."""
    if layout.keys.backing is None:
        return line
    level = layout.backing_level(layout.supports[span + int(line[:, 0].mean() > layout.profiles[span].axis)])
    height = line[:, 1] - level
    if height.max() <= SAME:
        return np.zeros((0, 2))
    cut = line[0] + (line[1] - line[0]) * np.clip(height[0] / (height[0] - height[1]), 0.0, 1.0) if height.min() < -SAME else line[0]
    return np.array([cut if height[0] < -SAME else line[0], cut if height[1] < -SAME else line[1]])


def _cuts(layout: BridgeLayout, row: int) -> list[float]:
    """Where a row of voussoirs is cut across the width, in running bond [m]."""
    half, strips = 0.5 * layout.keys.width, layout.keys.strips
    return [-half, *even(-half, half, strips, odd=row % 2 == 1 and strips > 1), half]


def supports(layout: BridgeLayout, density: float) -> tuple[list[Block], list[FillFace]]:
    """Piers and abutments with their fixed feet, and what the fill touches of them."""
    blocks, faces = list[Block](), list[FillFace]()
    half = 0.5 * layout.keys.width
    for support in layout.supports:
        top = top_of(support, layout.keys.walls is not None)
        beds = divided(support.foot, support.springing, math.inf if support.keys.rigid else support.keys.course_height)
        pieces = [[rectangle(support.left, support.right, low, high)] for low, high in pairwise(beds[:-1])]
        pieces += _head(support, top, beds[-2])
        names = [support.name] if support.keys.rigid else [f"{support.name}.{course}" for course in range(1, len(pieces) + 1)]
        for name, polygons in zip(names, pieces, strict=True):
            parts = [drawn_out(layout, polygon, -half, half) for polygon in polygons]
            block = compound_block(name, parts, density, "base" if support.keys.rigid else support.name)
            blocks.append(replace(block, fixed=support.keys.rigid))
        open_ = pairwise(top) if layout.keys.backing is None else ()
        for part in (np.array(pair) for pair in open_ if pair[1][0] - pair[0][0] > SAME):
            name = next(name for name, own in zip(names, pieces, strict=True) if max(p[:, 1].max() for p in own) > part[:, 1].max() - SAME)
            faces.append(FillFace(name, "top", face_of(layout, part, -layout.clear, layout.clear)))
        if not support.keys.rigid:
            faces += backs(layout, support, [block for block in blocks if block.name.startswith(f"{support.name}.")])
    return blocks + _feet(layout, density), faces


def _head(support: BridgeSupport, top: list[tuple[float, float]], low: float) -> list[list[np.ndarray]]:
    """The topmost stones of a support from a level up, by their convex parts (n, 2).

    Both skewbacks are cut from one stone, so that either thrust has a bed of the whole pier. Where the foot of one lies over the top of the
    other, each has a stone of its own, and level courses lie between them.
    """
    before = [] if support.before is None else [support.before.intrados[-1]]
    after = [] if support.after is None else [support.after.intrados[0]]
    left = _without_middles(np.array([(support.left, low), (support.right, low), *after, *top[::-1], *before]))
    stones = []
    if support.rise is not None and not support.keys.rigid:
        bed, foot = support.rise
        for z in np.linspace(bed, foot, round((foot - bed) / support.keys.course_height) + 1).tolist():
            if left[:, 1].max() <= z + SAME:  # a level skewback is the top of its stone
                break
            stones.append(clip(left, z - left[:, 1], SAME))
            left = clip(left, left[:, 1] - z, SAME)
    return [convex_parts(stone) for stone in (*stones, left)]


def is_steep(line: np.ndarray) -> bool:
    """Return True if an extrados (n, 2) rises by more than 45 degrees where it begins, from its springing on."""
    across, up = np.abs(line[1] - line[0])
    return bool(up > across)


def top_of(support: BridgeSupport, walls: bool) -> list[tuple[float, float]]:
    """The line from the end of the one extrados to the beginning of the other: level where a wall stands on it next to a steep one.

    It steps where the pier goes on next to its lower springing.
    """
    first, last = support.seats
    middle, level = support.split, 0.5 * float(first[1] + last[1])
    if support.before is None or support.after is None:
        return [tuple(first.tolist()), tuple(last.tolist())]
    one, other = (
        support.rise is not None or (walls and is_steep(line)) for line in (support.before.extrados[::-1], support.after.extrados)
    )
    left = float(first[1]) if one else float(last[1]) if other else level
    right = float(last[1]) if other else float(first[1]) if one else level
    line = [tuple(first.tolist()), (middle, left), (middle, right), tuple(last.tolist())]
    return [point for i, point in enumerate(line) if i == 0 or abs(point[0] - line[i - 1][0]) + abs(point[1] - line[i - 1][1]) > SAME]


def convex_parts(outline: np.ndarray) -> list[np.ndarray]:
    """Convex polygons (n, 2) that fill one, counter-clockwise."""
    whole = _without_middles(outline)
    if _is_convex(whole):
        return [whole]
    from shapely.geometry import Polygon

    from structures.geometry.polygons import convex_pieces

    return convex_pieces(Polygon(whole))


def _without_middles(polygon: np.ndarray) -> np.ndarray:
    """A polygon (n, 2) without corners twice and corners in the middle of a side."""
    kept = polygon[np.abs(polygon - np.roll(polygon, 1, axis=0)).max(axis=1) > SAME]
    return np.asarray(kept[np.abs(_turns(kept)) > SAME])


def _turns(polygon: np.ndarray) -> np.ndarray:
    before, after = polygon - np.roll(polygon, 1, axis=0), np.roll(polygon, -1, axis=0) - polygon
    return np.asarray(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])


def _is_convex(polygon: np.ndarray) -> bool:
    return bool((_turns(polygon) > 0.0).all())


def backs(layout: BridgeLayout, support: BridgeSupport, own: list[Block]) -> list[FillFace]:
    """The backs of blocks of an abutment, against which there is fill; none of a pier."""
    if support.before is not None and support.after is not None:
        return []
    outside, found = support.left if support.before is None else support.right, list[FillFace]()
    half = layout.clear
    for block in own:
        x = block.vertices[:, 0] - layout.slant * block.vertices[:, 1]
        z = block.vertices[np.abs(x - outside) < 1e-6, 2]
        low, high = float(z.min()), float(z.max())
        corners = np.array([[outside, -half, low], [outside, -half, high], [outside, half, high], [outside, half, low]])
        corners[:, 0] += layout.slant * corners[:, 1]
        found.append(FillFace(block.name, "back", corners[::-1] if outside == support.left else corners))
        if found[-1].area[0] * (outside - 0.5 * (support.left + support.right)) < 0.0:
            found[-1] = FillFace(block.name, "back", found[-1].corners[::-1])
    return found


def _feet(layout: BridgeLayout, density: float) -> list[Block]:
    """A fixed slab under each support of blocks, up to the middle of the spans next to it."""
    found, margin = list[Block](), 0.5 * (layout.deck - min(support.foot for support in layout.supports))
    for i, support in enumerate(layout.supports):
        if support.keys.rigid:
            continue
        start = support.left - margin if i == 0 else _reach(layout, i - 1, support.left)
        end = support.right + margin if i == len(layout.supports) - 1 else _reach(layout, i, support.right)
        polygon = rectangle(start, end, support.foot - SLAB, support.foot)
        half = 0.5 * layout.keys.width + margin
        found.append(Block(f"foot_{support.name}", *drawn_out(layout, polygon, -half, half), density, "base", fixed=True))
    return found


def _reach(layout: BridgeLayout, span: int, face: float) -> float:
    """How far a foot reaches under a span: to its middle, or to a fixed support on its far side."""
    adjacent = layout.supports[span : span + 2]
    far = next((s for s in adjacent if s.keys.rigid), None)
    if far is None:
        return layout.profiles[span].axis
    return far.right if far.right < face else far.left
