# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of limit analysis about a few blocks, and all that the command says of one."""

from __future__ import annotations

from pathlib import Path

from models import box, ground
from small_runs import write_scene

from masonry_cd.limit.case import LimitCase
from masonry_cd.limit.words import lines
from masonry_cd.mechanics.model.blocks import Block

PUSH = '[[loads]]\nkind = "push"\ndirection = "x"\nrate = 0.1\n'
TILT = '[[loads]]\nkind = "tilt"\ndirection = "x"\nrate = 0.1\n'
RUN = "run = {dt = 1e-3, duration = 1.0}\n"
TIE = '[[loads]]\nkind = "tie"\nname = "rod"\nblocks = ["a", "ground"]\npoints = [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]]\n'


def scene(folder: Path, blocks: list[Block], tables: str, mu: float = 0.65, joints: str = "", run: str = RUN) -> Path:
    """A scene file about blocks."""
    return write_scene(folder, blocks, f"material = {{density = 2000.0, friction = {mu}{joints}}}\n{run}{tables}")


def pillar() -> list[Block]:
    return [ground(2.0), box("a", (0.0, -0.2, 0.0), (0.5, 0.2, 1.5))]


def said(case: LimitCase) -> list[str]:
    """All that the command says of an analysis."""
    return [*lines(case), *case.notes]
