# SPDX-License-Identifier: GPL-3.0-or-later
"""Masses as pages list them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from made_run import box

from masonry_cd.app.summary import masses
from masonry_cd.mechanics.model.blocks import Assembly, Carried


def test_masses_are_those_of_the_free_blocks_by_group_with_what_rides_on_them():
    """Two cubes of 1 m at 2,000 kg/m3; on one of them ride 500 kg of fill."""
    fill = Carried(500.0, np.array([0.5, 0.5, 1.2]), np.zeros((3, 3)))
    blocks = [
        box("ground", (-2, -2, -1), (2, 2, 0), "base", fixed=True),
        box("stone", (0, 0, 0), (1, 1, 1), "wall"),
        replace(box("vault", (-1.5, 0, 0), (-0.5, 1, 1), "arch"), carried=fill),
    ]
    said = masses(Assembly.from_blocks(blocks, 0.6))
    assert said == "masses: 4.5 t free to move, arch 2.5 t, wall 2 t; 0.5 t of it is fill that rides on blocks"
