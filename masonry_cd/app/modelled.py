# SPDX-License-Identifier: GPL-3.0-or-later
"""What is in a model, in the words in which pages list it: masses, beside what structures and loads say of themselves."""

from __future__ import annotations

import numpy as np

from masonry_cd.mechanics.model.blocks import Assembly

NAMED = 12  # groups whose masses are listed, the heaviest


def masses(assembly: Assembly) -> str:
    """The masses of the free blocks, what rides on them included, in a line."""
    free, riding = ~assembly.fixed, sum(block.carried.mass for block in assembly.blocks if block.carried is not None)
    by_group = np.bincount(assembly.group_of[free], assembly.mass[free], minlength=len(assembly.groups))
    heaviest = [k for k in np.argsort(-by_group, kind="stable").tolist() if by_group[k] > 0.0]
    named = [f"{assembly.groups[k]} {1e-3 * by_group[k]:.4g} t" for k in heaviest[:NAMED]]
    named += ["and others"] if len(heaviest) > NAMED else []
    fill = f"; {1e-3 * riding:.4g} t of it is fill that rides on blocks" if riding else ""
    return f"masses: {1e-3 * assembly.mass[free].sum():.4g} t free to move, {', '.join(named)}{fill}"
