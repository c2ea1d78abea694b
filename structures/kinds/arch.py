# SPDX-License-Identifier: GPL-3.0-or-later
r"""Arches of straight-edged voussoirs on abutments or on buttresses.

The lines of the ring, semicircular, segmental, pointed, three-centred or flat, are those of :mod:`structures.courser.arch_profiles`; each
voussoir is the quadrilateral between two joints. At the springings lie fixed abutments, or buttresses: piers of whole blocks whose
topmost one is the skewback, cut to the springing joint. The intrados springs at z = 0, and the feet of buttresses lie below.

Groups: ``arch``, ``buttress1`` (left), ``buttress2`` and ``base``. Voussoirs are numbered from the left springing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field, WithJsonSchema

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.foundation.fields import is_number
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.blocks import Block
from structures import size
from structures.courser.arch_profiles import AGREE, RingTable, joints_of, voussoirs
from structures.geometry.prism import prism_xz, rectangle
from structures.kind import StructureKind, scaled
from structures.layout.ground import AROUND
from structures.macro_elements import EAST, HINGES, WEST, BlockLayout, MacroElement
from structures.schema import Length, WallHeight


def _abutment(value: Any) -> float | None:
    """true -> nan (the default depth), false -> None, a number -> itself."""
    if isinstance(value, bool):
        return math.nan if value else None
    if isinstance(value, (int, float)) and is_number(value) and value > 0:
        return float(value)
    raise ValueError("must be true, false or the depth of the abutments above 0 [m]")


_ABUTMENT: dict[str, Any] = {"anyOf": [{"type": "boolean"}, {"type": "number", "exclusiveMinimum": 0}]}


class ArchTable(RingTable):
    """The [structure] table of an arch."""

    width: Length = 1.0
    """across the arch, along y"""
    abutment: Annotated[float | None, Unit("m"), BeforeValidator(_abutment), WithJsonSchema(_ABUTMENT)] = Field(
        math.nan, json_schema_extra={"default": True}
    )
    """true: fixed blocks at the springings; a number: their depth; false: none"""
    buttress_width: Length | None = None
    """along x; with it the arch stands on buttresses"""
    buttress_height: WallHeight | None = None
    """below the springing; by default twice the width of the buttress"""
    buttress_courses: int | None = Field(None, ge=1, le=1000)
    """by default blocks half as high as wide"""


def build(table: Mapping[str, Any], density: float, folder: Path) -> list[Block]:
    """Build an arch on its abutments or buttresses: blocks ``v1`` to ``vN`` in the group ``arch``, fixed ones in ``base``.

    Raises:
        InputError: a key that is missing, unknown, out of range or in contradiction with another.
    """
    arch = parse_table(ArchTable, table, "structure")
    intrados, extrados = joints_of(arch)
    polygons = voussoirs(intrados, extrados)
    blocks = [_block(f"v{i + 1}", polygon, arch.width, density, "arch") for i, polygon in enumerate(polygons)]
    if arch.buttress_width is not None:
        blocks += _buttresses(arch, intrados[0], extrados[0], float(extrados[:, 1].max()), density)
    elif arch.buttress_height is not None or arch.buttress_courses is not None:
        raise InputError("structure.buttress_width", "missing; it makes the buttresses whose height or courses are given")
    elif arch.abutment is not None:
        depth = arch.thickness if math.isnan(arch.abutment) else arch.abutment
        left = seat(intrados[0], extrados[0], intrados[1], depth)
        right = seat(intrados[-1], extrados[-1], intrados[-2], depth)
        blocks.append(_block("abutment1", left, 1.5 * arch.width, density, "base", fixed=True))
        blocks.append(_block("abutment2", right, 1.5 * arch.width, density, "base", fixed=True))
    return blocks


def _block(name: str, polygon: np.ndarray, width: float, density: float, group: str, fixed: bool = False) -> Block:
    vertices, faces = prism_xz(polygon, -0.5 * width, 0.5 * width)
    return Block(name, vertices, faces, density, group, fixed)


def seat(intrados: np.ndarray, extrados: np.ndarray, towards: np.ndarray, depth: float) -> np.ndarray:
    """An abutment: the springing joint prolonged at both ends and drawn back from the arch by its depth.

    The joint is prolonged so that a voussoir which slides at the springing keeps its seat.
    """
    along = extrados - intrados
    overhang = min(0.5, 0.5 * abs(intrados[0]) / math.hypot(*along)) * along
    back = np.array([along[1], -along[0]]) / math.hypot(*along)
    if back @ (towards - intrados) > 0:
        back = -back
    inside, outside = intrados - overhang, extrados + overhang
    return np.array([inside, outside, outside + depth * back, inside + depth * back])


def _buttresses(arch: ArchTable, inner: np.ndarray, outer: np.ndarray, top: float, density: float) -> list[Block]:
    """A pier of whole blocks under either springing, each on half of the ground, a fixed slab.

    Args:
        inner, outer: ends of the left springing joint (2,) [m].
        top: of the ring [m].

    Raises:
        InputError: the springing joint is wider than the buttress.
    """
    wide = arch.buttress_width or 0.0
    bed = float(inner[0] - outer[0])
    if wide < bed * (1.0 - AGREE):
        raise InputError("structure.buttress_width", f"must be at least the width of the springing, {bed:.4g} m, got {wide:g}")
    height = arch.buttress_height or 2.0 * wide
    size.check_size(arch.voussoirs + 2.0 * (arch.buttress_courses or 2.0 * height / wide), "buttress_height")
    beds = np.linspace(-height, 0.0, (arch.buttress_courses or max(1, round(2.0 * height / wide))) + 1)
    near, far = float(inner[0]), float(inner[0]) - max(wide, bed)
    pieces = [rectangle(near, far, low, high) for low, high in pairwise(beds)]
    if outer[1] > AGREE * arch.thickness:  # the skewback
        corners = [(near, beds[-2]), (near, 0.0), (outer[0], outer[1]), (far, outer[1]), (far, beds[-2])]
        pieces[-1] = np.array(corners if bed < wide * (1.0 - AGREE) else corners[:3] + corners[4:])
    margin = AROUND * (height + top)
    slab = rectangle(far - margin, 0.0, -height - 0.5 * wide, -height)  # to midspan, where the two meet: what falls lands on the ground
    blocks = []
    for number, side in enumerate(([1.0, 1.0], [-1.0, 1.0]), start=1):
        for k, piece in enumerate(pieces, start=1):
            blocks.append(_block(f"buttress{number}.{k}", piece * side, arch.width, density, f"buttress{number}"))
        blocks.append(_block(f"base{number}", slab * side, arch.width + 2.0 * margin, density, "base", fixed=True))
    return blocks


def parts(layout: BlockLayout) -> list[MacroElement]:
    """An arch in its plane."""
    return [MacroElement("arch", "span", np.flatnonzero(~layout.fixed), (EAST, WEST), (HINGES,))]


KIND = StructureKind(
    build, ArchTable, first={"span": 4.0, "thickness": 0.4, "width": 1.0, "voussoirs": 27},
    resized=partial(scaled, ArchTable, counts={"voussoirs": 2, "buttress_courses": 1}), parts=parts,
)  # fmt: skip
