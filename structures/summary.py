# SPDX-License-Identifier: GPL-3.0-or-later
"""A structure in numbers: blocks, joints, masses, what touches what, and how hyperstatic it is.

Every corner of a joint carries one normal and two tangential forces, and every free block has six equations of equilibrium. The
degree of hyperstaticity is the difference of the two numbers; it is a lower bound of the dimension of the space of
self-balanced contact forces, among which a rigid-block model cannot choose.

What may not stand as it is built is in :mod:`structures.standing`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from masonry_cd.foundation.quantities import length
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.model.links import Link
from structures.standing import in_words, standing

SMALL, LARGE = 0.3, 300.0  # extent of a structure beyond which its unit is doubted [m]
THICK = 10.0  # ... and the least extent of the thinnest of its blocks [m]: panels of whole walls are thinner


def odd_size(blocks: Sequence[Block]) -> list[str]:
    """A line where the free blocks of a structure are so small or large in all that their unit is likely another."""
    free = [block.vertices for block in blocks if not block.fixed]
    return _odd(_extent(free), _thinnest(free)) if free else []


def _odd(extent: Sequence[float], thinnest: float) -> list[str]:
    size = max(extent)
    if size < SMALL:
        than = f"smaller than {SMALL:g} m"
    elif size > LARGE:
        than = f"larger than {LARGE:g} m"
    elif thinnest > THICK:
        than = f"and no block thinner than {length(thinnest)}"
    else:
        return []
    return [f"structure: {length(size)} in its largest extent, {than}: is it given in metres? A file's unit is its key units"]


def _thinnest(corners: Sequence[np.ndarray]) -> float:
    """The least extent of any of some blocks, corners each (V, 3) [m]."""
    return min(float(np.ptp(own, axis=0).min()) for own in corners)


def _extent(corners: Sequence[np.ndarray]) -> list[float]:
    """Return the extent of the box around corners, each (V, 3) [m]."""
    return [float(x) for x in np.ptp(np.concatenate(corners), axis=0)]


def report(blocks: Sequence[Block], links: tuple[Link, ...] = ()) -> dict[str, Any]:
    """Describe a structure, whose blocks links may hold together.

    Returns:
        blocks, fixed, joints, joint_area [m2], contacts, pieces, mass [kg], volume [m3], centre_of_mass [m], extent [m], thinnest [m],
        hyperstaticity, smallest and largest (name, volume, size), loose, hanging, adrift and side (see
        :class:`structures.standing.Standing`), groups (blocks, mass). Masses and volumes are those of the free blocks.
    """
    assembly = replace(Assembly.from_blocks(blocks, 0.5), links=links)
    joints = find_joints(assembly)
    stands = standing(assembly)
    contacts, free = len(stands.contacts.gap), ~assembly.fixed
    mass, volume = assembly.mass[free], assembly.volume[free]
    corners = [block.vertices for block in blocks if not block.fixed]
    order = np.flatnonzero(free)[np.argsort(volume, kind="stable")]
    return {
        "blocks": int(free.sum()),
        "fixed": int(assembly.fixed.sum()),
        "joints": joints.count,
        "joint_area": float(joints.area.sum()),
        "contacts": contacts,
        "pieces": stands.pieces,
        "mass": float(mass.sum()),
        "volume": float(volume.sum()),
        "centre_of_mass": [float(x) for x in mass @ assembly.centre[free] / mass.sum()],
        "extent": _extent(corners),
        "thinnest": _thinnest(corners),
        "hyperstaticity": 3 * contacts - 6 * int(free.sum()),
        "smallest": _one(assembly, int(order[0])),
        "largest": _one(assembly, int(order[-1])),
        "smallest_joint": _smallest(assembly, joints),
        "loose": list(stands.loose),
        "hanging": list(stands.hanging),
        "adrift": list(stands.adrift),
        "side": stands.side,
        "groups": _groups(assembly),
    }


def lines(made: Mapping[str, Any]) -> list[str]:
    """A report as text, a line for each matter."""
    x, y, z = (round(c, 6) + 0.0 for c in made["centre_of_mass"])
    small, large = made["smallest"], made["largest"]
    extent = " x ".join(f"{v:.4g}" for v in made["extent"])
    ones = "one" if made["fixed"] == 1 else "ones"
    text = [
        f"{made['blocks']} blocks and {made['fixed']} fixed {ones}, {made['joints']} joints of {made['joint_area']:.4g} m2, "
        + (f"{made['pieces']} piece{'s' if made['pieces'] > 1 else ''}" if made["pieces"] else "loose spheres"),
        f"{extent} m, {made['volume']:.4g} m3, {made['mass'] / 1e3:.4g} t, centre of mass at ({x:.4g}, {y:.4g}, {z:.4g}) m",
        f"{made['contacts']} contacts at rest: {3 * made['contacts']} unknown forces, {6 * made['blocks']} equations, "
        f"hyperstatic to degree {made['hyperstaticity']}",
        f"smallest block {small['name']} of {small['volume']:.3g} m3, largest {large['name']} of {large['volume']:.3g} m3",
    ]
    groups = [f"{name} {group['blocks']} ({group['mass'] / 1e3:.4g} t)" for name, group in made["groups"].items()]
    return [*text, "groups: " + ", ".join(groups)]


def warnings(made: Mapping[str, Any]) -> list[str]:
    """Return the lines of a report on what may not stand as it is built."""
    return _odd(made["extent"], made["thinnest"]) + in_words(made["loose"], made["hanging"], made["adrift"], made["side"])


def _one(assembly: Assembly, index: int) -> dict[str, Any]:
    size = np.ptp(assembly.blocks[index].vertices, axis=0)
    return {"name": assembly.names[index], "volume": float(assembly.volume[index]), "size": [float(x) for x in size]}


def _smallest(assembly: Assembly, joints: Joints) -> dict[str, Any] | None:
    if not joints.count:
        return None
    k = int(np.argmin(joints.area))
    a, b = assembly.names[joints.block_a[k]], assembly.names[joints.block_b[k]]
    return {"blocks": [a, b], "area": float(joints.area[k])}


def _groups(assembly: Assembly) -> dict[str, dict[str, Any]]:
    out = {}
    for g, name in enumerate(assembly.groups):
        members = assembly.group_of == g
        out[name] = {"blocks": int(members.sum()), "mass": float(assembly.mass[members].sum())}
    return out
