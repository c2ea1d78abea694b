# SPDX-License-Identifier: GPL-3.0-or-later
"""The stiffness of elastic contacts: that of the law of their groups, or, on joints of masonry, of their joint as built.

A joint of masonry keeps its stiffness for the whole run, however its blocks turn, so that a spring's energy is its own. Blocks that meet
where they had no joint, fallen ones, have that of two cubes of their volumes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_cd.foundation import libm
from masonry_cd.mechanics.contact.find_joints import find_joints, joint_parts
from masonry_cd.mechanics.dynamics.cohesive_curve import opening_at_end
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joint_laws.tables import JointLaws
from masonry_cd.mechanics.model.joint_stiffness import joint_stiffness
from masonry_cd.mechanics.model.joints import Joints


@dataclass(frozen=True, eq=False)
class PairStiffness:
    """k_n and k_t by the pair of parts that touch, (J, 2) of the joints as built [N/m3]; infinite where no block deforms."""

    key: np.ndarray  # (J,) number of a pair of parts, ascending
    stiffness: np.ndarray  # (J, 2)
    parts: int  # of all blocks
    softness: np.ndarray  # (B, 2) of half a cube of each block's volume, over E and over G [m3/N]; 0 of one that does not deform

    @classmethod
    def of(cls, assembly: Assembly) -> PairStiffness | None:
        """That of the joints of an assembly; None where no masonry gives them one."""
        if assembly.laws.moduli is None:
            return None
        parts = len(assembly.shapes.part_block)
        key = joint_parts(assembly) @ [parts, 1]
        order, values = np.argsort(key, kind="stable"), masonry_stiffness(assembly, find_joints(assembly))
        half = 0.5 * libm.cbrt(assembly.volume)
        softness = np.stack([half / modulus for modulus in block_moduli(assembly)], axis=1)
        return cls(key[order], np.stack(values, axis=1)[order], parts, softness)

    def of_contacts(self, pairs: np.ndarray, blocks: np.ndarray) -> np.ndarray:
        """k_n and k_t of contacts (C, 2) [N/m3], by their parts (C, 2) and blocks (C, 2)."""
        with np.errstate(divide="ignore"):  # between blocks that do not deform
            out = 1.0 / self.softness[blocks].sum(axis=1)
        key = pairs @ [self.parts, 1]
        place = np.minimum(np.searchsorted(self.key, key), len(self.key) - 1)
        if len(self.key):
            known = self.key[place] == key
            out[known] = self.stiffness[place[known]]
        return np.where(np.isfinite(out), out, 0.0)


def block_moduli(assembly: Assembly) -> tuple[np.ndarray, np.ndarray]:
    """E and G by which the joints of each block deform, (B,) each [Pa]; infinite of supports, and of blocks that deform themselves."""
    stiff = assembly.unyielding
    if assembly.deformation is not None:
        stiff[assembly.deformation.block] = True
    young, shear = assembly.laws.moduli or (np.inf, np.inf)
    return np.where(stiff, np.inf, young), np.where(stiff, np.inf, shear)


def masonry_stiffness(assembly: Assembly, joints: Joints) -> tuple[np.ndarray, np.ndarray]:
    """k_n and k_t of joints (J,) by the moduli of the assembly's masonry [N/m3]; infinite where no block deforms."""
    return joint_stiffness(assembly, joints, *block_moduli(assembly))


def softest_spring(laws: JointLaws, masonry: PairStiffness | None) -> float:
    """The least k_n of all joints [N/m3]; infinite where all are rigid."""
    own = float(laws.normal_stiffness[laws.normal_stiffness > 0.0].min(initial=np.inf))
    return own if masonry is None else min(own, float(masonry.stiffness[:, 0].min(initial=np.inf)))


def most_stretched(laws: JointLaws, masonry: PairStiffness | None) -> float:
    """How far an intact joint can be drawn apart at the most [m]."""
    elastic = laws.normal_stiffness > 0.0
    own = float((laws.apex[elastic] / laws.normal_stiffness[elastic]).max(initial=0.0))
    own = max(own, float(opening_at_end(laws).max(initial=0.0)))
    of_masonry = float(laws.apex[~elastic].max(initial=0.0))
    return own if masonry is None else max(own, of_masonry / float(masonry.stiffness[:, 0].min(initial=np.inf)))


def stiffness_of_joints(assembly: Assembly, joints: Joints) -> tuple[np.ndarray, np.ndarray]:
    """k_n and k_t of joints (J,) [N/m3]: of their law, or else of the masonry; 0: rigid."""
    laws, pair = assembly.laws, assembly.rows(joints.block_a, joints.block_b)
    own = laws.normal_stiffness[pair], laws.tangential_stiffness[pair]
    if laws.moduli is None:
        return own
    of_masonry = (np.where(np.isfinite(values), values, 0.0) for values in masonry_stiffness(assembly, joints))
    normal, tangential = (np.where(own[0] > 0.0, a, b) for a, b in zip(own, of_masonry, strict=True))
    return normal, tangential
