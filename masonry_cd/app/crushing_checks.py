# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run says to joints that crush: which key is missing."""

from __future__ import annotations

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.materials import Material

KEY = "material.joints"


def refuse_crushing_in_a_run(material: Material) -> None:
    """Refuse rigid joints with a compressive strength.

    Raises:
        InputError: names the pair of groups, and the key that is missing.
    """
    for pair, law in material.joint_laws.items():
        if law.compressive_strength is not None and law.normal_stiffness is None and material.joint_moduli is None:
            raise InputError(
                f"{KEY}.{pair}.normal_stiffness",
                "missing beside compressive_strength: in a run a rigid joint does not shorten, "
                "and cannot crush; masonry-cd limit takes rigid joints that crush",
            )
