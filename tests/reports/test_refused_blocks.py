# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of what is wrong: every faulty block is seen in its colour, whatever is the matter with it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from models import tower

from masonry_cd.mechanics.model.blocks import Block
from reports.drawing.figure import COLUMN, TITLE, WIDTH
from reports.drawing.palette import FAULTY, INK
from reports.drawing.refused_blocks import problem_picture
from structures.geometry.checks import Unsound, check

TOWER = tower(4)
RED = np.array([int(FAULTY[i : i + 2], 16) for i in (1, 3, 5)])


def faulty(which: str) -> list[Block]:
    """A tower whose second stone has a fault."""
    block = TOWER[2]
    bad = {
        "open": replace(block, faces=block.faces[1:]),
        "reversed": replace(block, faces=tuple(face[::-1] for face in block.faces)),
        "bent": replace(block, vertices=block.vertices + np.where(np.arange(8)[:, None] == 6, [0.0, 0.0, 0.02], 0.0)),
        "overlap": replace(block, vertices=block.vertices + [0.0, 0.0, 0.02]),
        "not finite": replace(block, vertices=np.where(np.arange(8)[:, None] == 0, np.nan, block.vertices)),
    }[which]
    return [*TOWER[:2], bad, *TOWER[3:]]


@pytest.mark.parametrize(("which", "names"), [("open", 1), ("reversed", 1), ("bent", 1), ("overlap", 2), ("not finite", 0)])
def test_faulty_blocks_are_drawn_in_colour(tmp_path: Path, which: str, names: int) -> None:
    from matplotlib.image import imread

    with pytest.raises(Unsound) as failure:
        check(faulty(which), "tower.json")
    fault = failure.value
    assert TOWER[2].name in fault.faulty
    problem_picture(fault.blocks, fault.faulty, str(fault), tmp_path / "problem.png")
    image = (255 * imread(tmp_path / "problem.png")[..., :3]).round().astype(int)
    hue = np.abs(image - (image.max(axis=-1, keepdims=True) / RED.max()) * RED).max(axis=-1) < 12  # the colour, however it is lit
    red = int((hue & (image.max(axis=-1) > 90)).sum())
    assert (red > 10000 * names) if names else (red < 2000)
    named = (image[TITLE + 10 : -50, : WIDTH - COLUMN - 100] == [int(INK[i : i + 2], 16) for i in (1, 3, 5)]).all(axis=-1).sum()
    assert (named > 50) if names else (named == 0), "names beside the model, with a line to each block"
