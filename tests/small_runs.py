# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of a few blocks from file to summary, and Ctrl-C on their way."""

from __future__ import annotations

import json
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from masonry_cd.app.case import prepare
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.io.summary import Summary
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.model.blocks import Block
from structures.files import blockfile

FROM_FILE = 'structure = {kind = "file", path = "blocks.json"}\n'


def write_scene(folder: Path, blocks: Sequence[Block] | Sequence[dict[str, Any]], text: str) -> Path:
    """Write blocks.json, of blocks or of tables as a block file has them, and next to it scene.toml with the tables of a text."""
    made = [block for block in blocks if isinstance(block, Block)]
    if made:
        blockfile.write(folder / "blocks.json", made)
    else:
        (folder / "blocks.json").write_text(json.dumps({"units": "m", "blocks": list(blocks)}), encoding="utf-8")
    path = folder / "scene.toml"
    path.write_text(FROM_FILE + text, encoding="utf-8")
    return path


def ran(scene: Path, *changes: str) -> Summary:
    """The summary of a run of a scene, into the folder ``out`` next to it."""
    return run_case(prepare(read_scene(scene, changes)), scene.parent / "out")


@contextmanager
def ctrl_c_before_step(number: int) -> Iterator[None]:
    """Runs of this process feel Ctrl-C before their step of a number."""
    advance = Stepper.step

    def step(self: Stepper) -> object:
        if self.steps == number:
            signal.raise_signal(signal.SIGINT)
        return advance(self)

    with pytest.MonkeyPatch.context() as pressed:
        pressed.setattr(Stepper, "step", step)
        yield
