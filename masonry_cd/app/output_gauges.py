# SPDX-License-Identifier: GPL-3.0-or-later
"""The table ``[output]`` of a scene, found on the structure: blocks, places and joints by number."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from masonry_cd.app.output_table import CORNER, CrackTable, JointTable, OutputTable, PointGaugeTable, SupportGaugeTable
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.io.gauges import CrackGauge, Gauges, JointGauge, PointGauge, SupportGauge
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.model.place_on_block import outside_block, require_on_block

OFF = 0.01  # share of the extent of the structure by which a place may lie off it
TOUCHING = 1e-9  # of the same: places as near have no line between them


def gauges_of(output: OutputTable, assembly: Assembly, joints: Joints) -> Gauges:
    """Find what the tables name.

    Raises:
        InputError: names the key: an unknown block, a place off its block or off the structure, no such joint.
    """
    return Gauges(
        points=tuple(_point(table, assembly, f"output.point[{i}]") for i, table in enumerate(output.point)),
        joints=tuple(_joint(table, assembly, joints, f"output.joint[{i}]") for i, table in enumerate(output.joint)),
        cracks=tuple(_crack(table, assembly, f"output.crack[{i}]") for i, table in enumerate(output.crack)),
        supports=tuple(_support(table, assembly, f"output.support[{i}]") for i, table in enumerate(output.support)),
    )


def _block(name: str, assembly: Assembly, where: str) -> int:
    """A block by its name, or the only one of a group."""
    if name not in assembly.names:
        group = [b for b, block in enumerate(assembly.blocks) if block.group == name]
        if len(group) == 1:
            return group[0]
        if group:
            raise InputError(where, f'"{name}" is a group of {len(group)} blocks; give one of them, "{assembly.names[group[0]]}"')
        raise InputError(where, f'"{name}" is not a block{suggest(name, assembly.names)}')
    return assembly.names.index(name)


def _nearest(place: Sequence[float], assembly: Assembly, where: str) -> int:
    """The block on which a place lies: a free one where it lies on several."""
    corners = np.concatenate([block.vertices for block in assembly.blocks if not block.fixed])
    off = np.array([outside_block(block, np.asarray(place, dtype=float)) for block in assembly.blocks])
    size = float(np.ptp(corners, axis=0).max())
    if off.min() > OFF * size:
        at, low, high = (", ".join(f"{x:.4g}" for x in v) for v in (place, corners.min(axis=0), corners.max(axis=0)))
        near = assembly.names[int(np.argmin(off))]
        raise InputError(
            where, f'({at}) m lies {off.min():.3g} m off the structure, from ({low}) to ({high}) m; the nearest block is "{near}"'
        )
    near_enough = np.maximum(off, 0.0) <= max(float(off.min()), 0.0) + TOUCHING * size
    return int(np.flatnonzero(near_enough)[np.argmin(assembly.fixed[near_enough])])


def _point(table: PointGaugeTable, assembly: Assembly, where: str) -> PointGauge:
    if table.block is None:
        assert table.place is not None
        block = _nearest(table.place, assembly, f"{where}.place")
    else:
        block = _block(table.block, assembly, f"{where}.block")
    called, place = assembly.names[block], assembly.centre[block]
    if table.place is not None:
        require_on_block(assembly.blocks[block], table.place, f"{where}.place")
        place = np.array(table.place)
        called += f" ({', '.join(f'{x:.4g}' for x in place)})"
    elif table.corner is not None:
        found = CORNER.fullmatch(table.corner)
        assert found is not None
        signs = np.array([{"+": 1.0, "-": -1.0}.get(sign, 0.0) for sign in found.groups()])
        corners = assembly.blocks[block].vertices
        place, called = corners[int(np.argmax(np.sum(corners * signs, axis=1)))], f"{called} {table.corner}"
    return PointGauge(table.name or called, block, tuple(map(float, place)), table.relative)


def _joint(table: JointTable, assembly: Assembly, joints: Joints, where: str) -> JointGauge:
    if not joints.count:
        raise InputError(where, "the structure has no joints")
    if table.blocks is None:
        assert table.place is not None
        _nearest(table.place, assembly, f"{where}.place")
        index = int(np.argmin(np.sum((joints.centres() - np.array(table.place)) ** 2, axis=1)))
    else:
        ends = {_block(name, assembly, f"{where}.blocks") for name in table.blocks}
        found = [j for j in range(joints.count) if {int(joints.block_a[j]), int(joints.block_b[j])} == ends]
        if not found:
            raise InputError(f"{where}.blocks", f'no joint is between "{table.blocks[0]}" and "{table.blocks[1]}" as built')
        index = max(found, key=lambda j: float(joints.area[j]))
    pair = f"{assembly.names[int(joints.block_a[index])]} - {assembly.names[int(joints.block_b[index])]}"
    return JointGauge(table.name or pair, index)


def _crack(table: CrackTable, assembly: Assembly, where: str) -> CrackGauge:
    points = np.array(table.points)
    if table.blocks is None:
        ends = [_nearest(place, assembly, f"{where}.points[{i}]") for i, place in enumerate(table.points)]
    else:
        ends = [_block(name, assembly, f"{where}.blocks") for name in table.blocks]
        for i, (block, place) in enumerate(zip(ends, table.points, strict=True)):
            require_on_block(assembly.blocks[block], place, f"{where}.points[{i}]")
    if ends[0] == ends[1]:
        raise InputError(f"{where}.points", f'both are on block "{assembly.names[ends[0]]}"; blocks = ["...", "..."] names two')
    if float(np.sqrt(((points[1] - points[0]) ** 2).sum())) <= TOUCHING:
        raise InputError(f"{where}.points", "both ends are at one point, the gauge has no direction")
    name = table.name or f"{assembly.names[ends[0]]} to {assembly.names[ends[1]]}"
    first, second = (tuple(map(float, place)) for place in points)
    return CrackGauge(name, (ends[0], ends[1]), (first, second))


def _support(table: SupportGaugeTable, assembly: Assembly, where: str) -> SupportGauge:
    block = _block(table.block, assembly, f"{where}.block")
    if not assembly.fixed[block]:
        raise InputError(f"{where}.block", f'"{table.block}" is not fixed; [[output.joint]] has the forces between free blocks')
    return SupportGauge(table.name or table.block, block)
