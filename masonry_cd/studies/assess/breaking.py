# SPDX-License-Identifier: GPL-3.0-or-later
"""Assumptions on failure other than by joints that open and slip: bonds that soften and stones that crack."""

from __future__ import annotations

from masonry_cd.app.scene import Scene
from masonry_cd.mechanics.model.stones import Stones
from masonry_cd.studies.assess.joint_levels import OF_STIFFNESS, base_stiffness
from masonry_cd.studies.assess.levels import ENERGY, STIFFNESS, STONES, Assumption, LeftOut, Level, Tables, laws_of, refusal

HALF, TWICE = 0.5, 2.0  # of fracture energies, as tests of them scatter, and of the stiffness of joints whose bond softens
WEAKER, STRONGER = 0.7, 1.4  # tensile strengths of stone
OF_ENERGY, OF_STRENGTH = ("fracture_energy", "shear_fracture_energy"), ("tensile_strength", "cohesion")
WHOLE_COST = 0.3  # of a run with whole stones, times that with pieces, about (rubble wall of 58 stones)


def softens(scene: Scene) -> bool:
    """Return True if some bond of the scene softens."""
    return any(law.fracture_energy for law in scene.material.joints.values())


def softening_stiffness(scene: Scene, tables: Tables) -> list[Assumption | LeftOut]:
    """Joints half and twice as stiff, where a bond softens, which needs a stiffness of its own."""
    return _of_joints(STIFFNESS, base_stiffness(scene), OF_STIFFNESS, scene, tables)


def bond_energy(scene: Scene, tables: Tables) -> list[Assumption | LeftOut]:
    """Brittler and tougher bonds; none where no bond softens."""
    return _of_joints(ENERGY, "as given", OF_ENERGY, scene, tables) if softens(scene) else []


def _of_joints(name: str, base: str, keys: tuple[str, ...], scene: Scene, tables: Tables) -> list[Assumption | LeftOut]:
    """Half and twice the values of some keys of the laws of joints, and why the scene does not take one: bonds would snap back."""

    def scaled(factor: float) -> Level:
        def change(tables: Tables) -> None:
            for law in laws_of(tables):
                law |= {key: factor * law[key] for key in keys if key in law}

        return Level(f"x {factor:.3g}", change)

    why = {factor: refusal(scene, tables, scaled(factor)) for factor in (HALF, TWICE)}
    taken = [factor for factor in why if not why[factor]]
    low, high = min(1.0, *taken, 1.0), max(1.0, *taken, 1.0)
    levels = tuple(scaled(factor) for factor in taken)
    known = [Assumption(name, base, levels, between=lambda u: scaled(low * (high / low) ** u))] if taken else []
    return [*known, *(LeftOut(f"{name} x {factor:g}", text) for factor, text in why.items() if text)]


def stone_strength(scene: Scene, tables: Tables) -> list[Assumption]:
    """Whole stones, weaker and stronger ones; none where stones do not crack."""

    def scaled(factor: float) -> Level:
        def change(tables: Tables) -> None:
            for law in laws_of(tables, "stones"):
                law |= {key: factor * law[key] for key in OF_STRENGTH if key in law}
                if "tensile_strength" not in law:
                    law["tensile_strength"] = factor * Stones.model_validate(law).strength  # of its kind
                law |= {key: factor**2 * law[key] for key in OF_ENERGY if key in law}  # as brittle: the spring stores by the square

        return Level(f"x {factor:.3g}", change)

    def whole(tables: Tables) -> None:
        del tables["material"]["stones"]

    if not scene.material.stones:
        return []
    levels = (Level("whole", whole, WHOLE_COST), scaled(WEAKER), scaled(STRONGER))
    fixed = refusal(scene, tables, levels[0])  # pieces of a file need a strength

    def between(u: float) -> Level:
        return scaled(WEAKER * (STRONGER / WEAKER) ** u)

    return [Assumption(STONES, "as given", levels[1:] if fixed else levels, statics=True, between=between)]
