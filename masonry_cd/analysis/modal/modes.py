# SPDX-License-Identifier: GPL-3.0-or-later
r"""Elastic modes of a block structure: frequencies, participating masses and shapes, to compare with measured ones.

Rigid blocks in unilateral contact have no elastic frequency. Two companions on the same geometry have one:

    continuum   the blocks bonded to one elastic solid, in second-order tetrahedra        (:mod:`masonry_cd.analysis.modal.continuum`)
    joints      rigid blocks on elastic joints of stiffness E / block length per area     (:mod:`masonry_cd.analysis.modal.elastic_joints`)

Both are linear: no joint opens, and the weight does not matter. Frequencies go with the square root of the modulus, so that one measured
frequency fixes it: E = E_0 (f_measured / f_computed)^2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from masonry_cd.analysis.modal.shapes import ModeShapes
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.footings import Footings
from masonry_cd.mechanics.model.geometry import mass_properties

MOST_MODES = 10_000
METHODS = ("continuum", "joints")
AXES = "xyz"


@dataclass(frozen=True, eq=False)
class Modes:
    """The lowest n modes of one model; rigid motions that the supports leave free are counted in the facts, not listed."""

    method: str
    young: float | Mapping[str, float]  # as given, or scaled [Pa]
    poisson: float
    frequencies: np.ndarray  # (n,) [Hz]
    participation: np.ndarray  # (n, 3) share of the mass of the free blocks in x, y and z
    points: np.ndarray  # (P, 3) centroids of the free blocks [m]
    names: tuple[str, ...]  # of these blocks
    shapes: np.ndarray  # (n, P, 3) displacements there; the largest of a mode anywhere is 1
    field: ModeShapes  # displacements at other points, see Shapes.at, in the same scale
    facts: Mapping[str, Any]  # size of the model, time taken

    @property
    def count(self) -> int:
        """Number of modes n."""
        return len(self.frequencies)

    def scaled(self, factor: float) -> Modes:
        """The modes for a modulus that is a factor larger."""
        young = {key: value * factor for key, value in self.young.items()} if isinstance(self.young, Mapping) else self.young * factor
        facts = {key: [factor * item for item in value] if key.endswith("stiffness_pa_m") else value for key, value in self.facts.items()}
        return replace(self, young=young, frequencies=self.frequencies * np.sqrt(factor), facts=facts)

    def turned(self, signs: np.ndarray) -> Modes:
        """The modes with other signs, (n,) of 1 and -1."""
        return replace(self, shapes=signs[:, None, None] * self.shapes, field=self.field.scaled(signs))


def modal(
    blocks: Sequence[Block],
    young: float | Mapping[str, float],
    poisson: float = 0.2,
    *,
    method: str = "continuum",
    modes: int = 6,
    size: float | None = None,
    order: int = 2,
    stiffness: tuple[float, float] | tuple[np.ndarray, np.ndarray] | None = None,
    restraint: Mapping[str, str] | None = None,
    footings: Footings | None = None,
) -> Modes:
    """The lowest elastic modes of a structure.

    Args:
        blocks: checked blocks, supports included.
        young: modulus [Pa], or moduli by group of blocks, with ``"default"`` for the rest.
        poisson: Poisson's ratio.
        method: ``continuum`` or ``joints``.
        modes: how many.
        size: of the tetrahedra of the continuum [m]; about the thickness of the structure when not given.
        order: of the tetrahedra, 2 or 1.
        stiffness: normal and tangential stiffness of all joints, or of each (J,) [Pa/m], instead of those from the modulus.
        restraint: by group of supports the directions that they hold, such as ``{"base": "xyz", "roller": "z"}``; all when not given.
        footings: blocks on springs of the ground, for ``joints``; None: supports hold what stands on them.

    Raises:
        InputError: a value out of range, an unknown method or group, a block tied to no support, a solid that cannot be meshed.
    """
    if method not in METHODS:
        raise InputError("modal.method", f'unknown method "{method}"{suggest(method, METHODS)}; one of {", ".join(METHODS)}')
    if not 0.0 <= poisson < 0.5:
        raise InputError("modal.poisson", f"must be at least 0 and below 0.5, got {poisson:g}")
    if not 1 <= modes <= MOST_MODES:
        raise InputError("modal.modes", f"must be 1 to {MOST_MODES}, got {modes}")
    if all(block.fixed for block in blocks):
        raise InputError("modal", "no free block, nothing can vibrate")
    moduli, held = young_of(blocks, young), _held(blocks, restraint or {})
    if method == "continuum":
        from masonry_cd.analysis.modal.continuum import continuum_modes

        if size is not None and not 0.0 < size < np.inf:
            raise InputError("modal.mesh_size", f"must be above 0 m, got {size:g}")
        found = continuum_modes(blocks, moduli, poisson, modes, size=size, order=order, held=held)
    else:
        from masonry_cd.analysis.modal.elastic_joints import joint_modes

        for value in stiffness or ():
            least, most = float(np.min(value)), float(np.max(value))
            if not 0.0 < least <= most < np.inf:
                raise InputError("modal", f"stiffnesses of joints must be above 0 Pa/m, got {least:g}")
        found = joint_modes(blocks, moduli, poisson, modes, stiffness=stiffness, held=held, footings=footings)
    return _modes(method, young, poisson, blocks, found)


def young_of(blocks: Sequence[Block], young: float | Mapping[str, float]) -> np.ndarray:
    """The modulus of each block, (B,) [Pa].

    Raises:
        InputError: an unknown group, a group without a value, or a value that is not a modulus in Pa.
    """
    groups = {block.group for block in blocks}
    table = dict(young) if isinstance(young, Mapping) else {"default": young}
    for group, value in table.items():
        key = f"modal.young.{group}" if isinstance(young, Mapping) else "modal.young"
        if group != "default" and group not in groups:
            raise InputError(key, f'"{group}" is not a group of blocks{suggest(group, groups)}; groups: {", ".join(sorted(groups))}')
        if not 1e5 <= value <= 1e13:
            raise InputError(key, f"should be between 1e5 and 1e13 Pa, got {value:g}")
    lacking = next((b.group for b in blocks if not b.fixed and b.group not in table and "default" not in table), None)
    if lacking is not None:
        raise InputError("modal.young", f"no value for the group {lacking}; add it or a default")
    return np.array([table.get(block.group, table.get("default", 1.0)) for block in blocks], dtype=float)


def _held(blocks: Sequence[Block], restraint: Mapping[str, str]) -> dict[str, np.ndarray]:
    """Return for each group of supports which of x, y and z are held."""
    groups = {block.group for block in blocks if block.fixed}
    for group, axes in restraint.items():
        if group not in groups:
            raise InputError(
                f"modal.restraint.{group}",
                f'"{group}" is not a group of supports{suggest(group, groups)}; groups: {", ".join(sorted(groups))}',
            )
        if not set(axes) <= set(AXES):
            raise InputError(f"modal.restraint.{group}", f'should be made of the letters x, y and z, got "{axes}"')
    return {group: np.array([axis in axes for axis in AXES]) for group, axes in restraint.items()}


def _modes(method: str, young: float | Mapping[str, float], poisson: float, blocks: Sequence[Block], found: Mapping[str, Any]) -> Modes:
    """Scale the shapes and take them at the centroids."""
    free = [block for block in blocks if not block.fixed]
    skin = found["field"].skin()
    length = np.linalg.norm(skin.shapes, axis=2)
    largest = np.argmax(length, axis=1)
    rows = np.arange(len(largest))
    top = skin.shapes[rows, largest]
    sign = np.sign(top[rows, np.argmax(np.abs(top), axis=1)])
    field = found["field"].scaled(sign / length[rows, largest])
    points = np.array([mass_properties(block.vertices, block.faces).centre for block in free])
    return Modes(
        method=method,
        young=young,
        poisson=poisson,
        frequencies=found["frequencies"],
        participation=found["participation"],
        points=points,
        names=tuple(block.name for block in free),
        shapes=field.at(points)[0],
        field=field,
        facts=found["facts"],
    )
