# SPDX-License-Identifier: GPL-3.0-or-later
"""The start of a limit analysis, of the whole or of parts: the blocks of a scene, their joints, and its table ``[limit]``."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from masonry_cd.foundation.quantities import pressure
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly, refuse_spheres
from masonry_cd.mechanics.model.joints import Joints

if TYPE_CHECKING:
    from masonry_cd.app.limit_table import LimitTable
    from masonry_cd.app.scene import Scene
    from masonry_cd.app.static_loads import StaticLoads
    from structures import MadeStructure


@dataclass(frozen=True, eq=False)
class LimitStructure:
    """The structure of a scene."""

    scene: Scene
    made: MadeStructure  # blocks, notes on them, and ties
    asked: LimitTable
    assembly: Assembly
    joints: Joints

    @property
    def is_upright(self) -> bool:
        """True where gravity acts along -z."""
        x, y, z = self.scene.run.gravity
        return z < 0.0 and x == y == 0.0

    def of(self, scene: Scene) -> LimitStructure:
        """The structure with a scene that differs in its loads and its table ``[limit]`` only.

        Raises:
            InputError: a bad table.
        """
        from masonry_cd.app.limit_table import limit_of

        return replace(self, scene=scene, asked=limit_of(scene))

    def loads_of_parts(self) -> StaticLoads:
        """The loads as its parts bear them, each of which has a push of its own.

        Raises:
            InputError: a bad table.
        """
        from loads.motion import parse_direction

        return self.loads(self.asked.model_copy(update={"push": parse_direction("x"), "tilt": None, "live": ()}))

    def loads(self, asked: LimitTable | None = None, shaken_by: float = 0.0) -> StaticLoads:
        """Return the loads on it, as its own table or another one asks for them, its fill under a push ``shaken_by`` so much of gravity.

        Raises:
            InputError: a bad table, or no pattern.
        """
        from masonry_cd.app.static_loads import static_loads

        scene, ties = self.scene, [(bar.where, bar.load()) for bar in self.made.ties]
        table, fills = asked or self.asked, self.made.fills
        return static_loads(scene.loads, table, scene.run.gravity, scene.folder, self.assembly, ties, fills, shaken_by)


def limit_structure(scene: Scene) -> LimitStructure:
    """The structure of a scene; joints have no stiffness of the masonry's moduli, since limit analysis is of rigid blocks.

    Those of bridges crush at the strength of their kind of masonry, unless the scene says that they do not: under wheels it decides.

    Raises:
        InputError: with file and line of the scene where a key is at fault.
    """
    from masonry_cd.app.case import make_structures
    from masonry_cd.app.limit_table import limit_of

    scene.refuse_tables("limit analysis", "links", "events")
    made, material = make_structures(scene), scene.material
    masonry = material.masonry
    if made.fills and masonry is not None and "crushing" not in masonry.model_fields_set:
        material = material.model_copy(update={"masonry": masonry.model_copy(update={"crushing": True})})
        crushes = f"joints without a strength of their own crush at {pressure(masonry.strength)}, of {masonry.kind}"
        made = made._replace(notes=[*made.notes, f"material.masonry: {crushes}, as those of bridges do; crushing = false: they do not"])
    with scene.locating():
        refuse_spheres(made.blocks, "structure", "limit analysis")
        asked = limit_of(scene)
        assembly = replace(Assembly.from_blocks(made.blocks, material.with_rigid_joints), deformation=None)
        return LimitStructure(scene, made, asked, assembly, find_joints(assembly))
