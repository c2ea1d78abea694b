"""What a structure is, in numbers: blocks, joints, masses, what touches what, and how hyperstatic it is.

Every corner of a joint carries one normal and two tangential forces, and every free block has six equations of equilibrium. The
degree of hyperstaticity is the difference of the two numbers; it is a lower bound of the dimension of the space of
self-balanced contact forces, among which a rigid-block model cannot choose.

A block hangs when no contact pushes it upwards at all: then nothing but friction on its sides holds it, as where no lintel or arch spans an
opening. It may stand, but seldom should.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from masonry_cd.contact.detector import ContactSet, Detector
from masonry_cd.contact.find_joints import find_joints
from masonry_cd.errors import InputError
from masonry_cd.model.blocks import Assembly, Block
from masonry_cd.model.joints import Joints
from masonry_cd.model.state import State, rotation_matrices

UPRIGHT = 1e-4  # sine of the slope of a joint: less is upright


def report(blocks: Sequence[Block]) -> dict[str, Any]:
    """Describe a structure.

    Returns:
        blocks, fixed, joints, joint_area [m2], contacts, pieces, mass [kg], volume [m3], centre_of_mass [m], extent [m], hyperstaticity,
        smallest and largest (name, volume, size), hanging (names), groups (blocks, mass). Masses and volumes are those of the free blocks.

    Raises:
        InputError: a free block that touches nothing.
    """
    assembly = Assembly.from_blocks(blocks, 0.5)
    joints = find_joints(assembly)
    found = _contacts(assembly)
    pairs, contacts = np.unique(found.bodies, axis=0).reshape(-1, 2), len(found.gap)
    free = ~assembly.fixed
    _check_loose(assembly, pairs)
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (assembly.count, assembly.count))
    touched = np.zeros(assembly.count, dtype=bool)
    touched[pairs] = True
    _, label = connected_components(graph, directed=False)
    mass, volume = assembly.mass[free], assembly.volume[free]
    corners = np.concatenate([block.vertices for block in blocks if not block.fixed])
    order = np.flatnonzero(free)[np.argsort(volume, kind="stable")]
    return {
        "blocks": int(free.sum()),
        "fixed": int(assembly.fixed.sum()),
        "joints": joints.count,
        "joint_area": float(joints.area.sum()),
        "contacts": contacts,
        "pieces": len(np.unique(label[free | touched])),
        "mass": float(mass.sum()),
        "volume": float(volume.sum()),
        "centre_of_mass": [float(x) for x in mass @ assembly.centre[free] / mass.sum()],
        "extent": [float(x) for x in np.ptp(corners, axis=0)],
        "hyperstaticity": 3 * contacts - 6 * int(free.sum()),
        "smallest": _one(assembly, int(order[0])),
        "largest": _one(assembly, int(order[-1])),
        "smallest_joint": _smallest(assembly, joints),
        "hanging": _hanging(assembly, found),
        "groups": _groups(assembly),
    }


def lines(made: Mapping[str, Any]) -> list[str]:
    """A report in words, a line for each matter."""
    x, y, z = (round(c, 6) + 0.0 for c in made["centre_of_mass"])
    small, large = made["smallest"], made["largest"]
    extent = " x ".join(f"{v:.4g}" for v in made["extent"])
    text = [
        f"{made['blocks']} blocks and {made['fixed']} fixed ones, {made['joints']} joints of {made['joint_area']:.4g} m2, "
        f"{made['pieces']} piece{'s' if made['pieces'] > 1 else ''}",
        f"{extent} m, {made['volume']:.4g} m3, {made['mass'] / 1e3:.4g} t, centre of mass at ({x:.4g}, {y:.4g}, {z:.4g}) m",
        f"{made['contacts']} contacts at rest: {3 * made['contacts']} unknown forces, {6 * made['blocks']} equations, "
        f"hyperstatic to degree {made['hyperstaticity']}",
        f"smallest block {small['name']} of {small['volume']:.3g} m3, largest {large['name']} of {large['volume']:.3g} m3",
    ]
    if made["hanging"]:
        names = ", ".join(made["hanging"][:3]) + (" ..." if len(made["hanging"]) > 3 else "")
        text.append(f"{len(made['hanging'])} hang: nothing is under {names}, only friction on the sides (does something span the opening?)")
    groups = [f"{name} {group['blocks']} ({group['mass'] / 1e3:.4g} t)" for name, group in made["groups"].items()]
    return [*text, "groups: " + ", ".join(groups)]


def _contacts(assembly: Assembly) -> ContactSet:
    """The contacts at rest, over faces, edges or corners."""
    state = State.at_rest(assembly)
    still = np.zeros((assembly.count, 6))
    return Detector(assembly).detect(state.position, rotation_matrices(state.orientation), still, 0.0, 0.0, np.zeros(3))


def _hanging(assembly: Assembly, contacts: ContactSet) -> list[str]:
    """Names of the free blocks that no contact pushes upwards."""
    push = np.zeros(assembly.count)  # steepest upward normal on each block
    np.maximum.at(push, contacts.bodies[:, 0], contacts.normal[:, 2])  # normals point to the first of the two
    np.maximum.at(push, contacts.bodies[:, 1], -contacts.normal[:, 2])
    return [assembly.names[b] for b in np.flatnonzero((push < UPRIGHT) & ~assembly.fixed)]


def _check_loose(assembly: Assembly, pairs: np.ndarray) -> None:
    """Refuse free blocks that touch nothing."""
    touched = np.zeros(assembly.count, dtype=bool)
    touched[pairs.ravel()] = True
    loose = np.flatnonzero(~touched & ~assembly.fixed)
    if len(loose):
        more = f", and {len(loose) - 1} more" if len(loose) > 1 else ""
        raise InputError(f'block "{assembly.names[loose[0]]}"{more}: touches no other block')


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
