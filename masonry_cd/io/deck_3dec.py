# SPDX-License-Identifier: GPL-3.0-or-later
"""A deck for 3DEC 7 (Itasca): rigid blocks, joints of Mohr and Coulomb, gravity, and the base motion as tables.

    block create polyhedron      a block; corners of each face clockwise seen from outside
    block property density       by group           block fix, block apply velocity    supports, and how they move
    block contact property       by pair of groups, and for contacts to come by the table of materials
    model solve                  first at rest under gravity, then the motion over the duration of the run

3DEC has springs in all joints, so the scene has to have them: ``material.joints.normal_stiffness``. Its dashpots and time step are its own.
Source: 3DEC 7 command reference.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from masonry_cd.foundation.errors import InputError
from masonry_cd.io.deck import AXES, Deck

RATIO = 1e-5  # of unbalanced forces, at which the structure is at rest


def files(deck: Deck) -> dict[str, str]:
    """The text of each file, by its name.

    Raises:
        InputError: joints without a stiffness of their own, those that crush or soften, or blocks that are not convex.
    """
    laws = deck.assembly.laws
    if any(not laws.normal_stiffness[i, j] > 0.0 for _, _, i, j in deck.pairs()):
        raise InputError(
            "--format", "3DEC needs a stiffness in all joints; give material.joints a normal_stiffness for each pair of groups"
        )
    if laws.crushing.any():
        raise InputError("--format", "joints of 3DEC do not crush, but some of this scene do (compressive_strength)")
    if laws.fracture.any():
        raise InputError("--format", "bonds of 3DEC decks break at once, but some of this scene soften (fracture_energy)")
    for block in deck.assembly.blocks:
        if len(block.convex_parts) > 1:
            raise InputError("--format", f'block "{block.name}" is not convex, and 3DEC needs convex blocks')
    return {"deck.3ddat": "\n".join(_lines(deck)) + "\n"}


def _lines(deck: Deck) -> Iterator[str]:
    groups, a = deck.groups(), deck.assembly
    yield f"; {' '.join(deck.title.split())}: m, kg, s, Pa"
    yield from ("model new", "model config dynamic", "model large-strain on", "", "; blocks")
    for b, block in enumerate(a.blocks):
        yield f"; {' '.join(block.name.split())}"
        faces = (" ".join(f"({x!r},{y!r},{z!r})" for x, y, z in block.vertices[list(face[::-1])].tolist()) for face in block.faces)
        yield f"block create polyhedron group {_quoted(deck.group_of(b))} ..."
        yield " ...\n".join(f"  face {face}" for face in faces)
    yield from ("", "; materials")
    for group, own in groups.items():
        densities = {a.blocks[b].density for b in own}
        if len(densities) > 1:
            raise InputError("--format", f'blocks of the group "{group}" have several densities; give each group one density')
        yield f"block property density {densities.pop()!r} range group {_quoted(group)}"
    yield from ("", "; joints", "block contact generate-subcontacts", "block contact jmodel assign mohr")
    entries = [(_law(deck, i, j), f"range group-intersection {_quoted(one)} {_quoted(other)}") for one, other, i, j in deck.pairs()]
    yield f"block contact material-table default property {entries[0][0]}"
    yield f"block contact property {entries[0][0]}"
    for law, where in entries:
        yield f"block contact property {law} {where}"
        yield f"block contact material-table add jmodel mohr property {law} {where}"
    yield from ("", "; supports and gravity")
    held = {group: own for group, own in groups.items() if a.fixed[own[0]]}
    yield from (f"block fix range group {_quoted(group)}" for group in held)
    yield f"model gravity {' '.join(map(repr, deck.gravity.tolist()))}"
    yield from (f"model solve ratio-local {RATIO!r}", "", "; base motion")
    for motion in range(deck.support_velocity.shape[1]):
        for d in deck.moving(motion):
            rows = deck.support_velocity[:, motion, d].tolist()
            pairs = " ...\n".join(f"  ({k * deck.dt!r},{v!r})" for k, v in enumerate(rows))
            yield f"table {_quoted(f'v{AXES[d]}{motion}')} add ...\n{pairs}"
    for group, own in held.items():
        motion = int(a.support_of[own[0]])
        for d in deck.moving(motion):
            yield f"block apply velocity-{AXES[d]} 1 table {_quoted(f'v{AXES[d]}{motion}')} range group {_quoted(group)}"
    yield from ("model dynamic active on", "block mechanical damping rayleigh 0 0", f"model solve time {deck.steps * deck.dt!r}")


def _law(deck: Deck, i: int, j: int) -> str:
    """The properties of joints between two groups: the friction an angle, cohesion and tension until they break."""
    laws, mu = deck.assembly.laws, float(deck.assembly.friction[i, j])
    values = {
        "stiffness-normal": laws.normal_stiffness[i, j],
        "stiffness-shear": laws.tangential_stiffness[i, j],
        "friction": math.degrees(math.atan(mu)),
        "cohesion": mu * laws.apex[i, j],
        "tension": min(laws.tension[i, j], laws.apex[i, j]),
    }
    return " ".join(f"{name} {float(value)!r}" for name, value in values.items())


def _quoted(text: str) -> str:
    return "'" + text.replace("'", "") + "'"
