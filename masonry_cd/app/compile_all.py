# SPDX-License-Identifier: GPL-3.0-or-later
"""``python -m masonry_cd.app.compile_all SCENE ...``: compiles what the usual scenes need, and what those given do, for a wheel.

The folder NUMBA_CACHE_DIR then holds what ``hatch_build.py`` puts into the wheel: ``make wheel``.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from masonry_cd.app.case import prepare
from masonry_cd.app.scene import read_scene
from masonry_cd.app.warmup import SceneKind, compile_seldom, compiling
from masonry_cd.foundation import jit, processor
from masonry_cd.foundation.errors import InputError


def usual_kinds() -> list[SceneKind]:
    """Rigid blocks and such as strain uniformly, in a plane and in space, with and without joint laws per area; and spheres."""
    found = [SceneKind("auto", planar, by_area) for planar in (True, False) for by_area in (False, True)]
    found += [SceneKind("auto", planar, True, strained=strained) for planar, strained in ((True, 3), (False, 6))]
    found += [SceneKind("auto", planar, True, stress=True) for planar in (True, False)]
    found += [SceneKind(solver, planar) for solver in ("nlgs", "admm") for planar in (True, False)]
    return [*found, SceneKind("auto", False, spheres=True)]


def compile_all(scenes: Sequence[Path]) -> None:
    """Compile the kernels of the usual kinds of scenes, and those that the structures, loads and checks of some scenes call in addition.

    Raises:
        InputError: nothing would be kept, or it would be for another processor than most have; or a scene is wrong.
    """
    if not jit.keeps():
        raise InputError("", f"nothing would be kept: {jit.why_nothing_is_kept()}")
    name, _ = processor.target()
    if name != processor.NAME:
        raise InputError("", f"kernels would be compiled for {name}, not for {processor.NAME}, which most processors understand")
    for kind in usual_kinds():
        with compiling(kind):
            pass
        if kind.solver == "auto" and kind.planar:
            compile_seldom(kind)
    for scene in scenes:
        print(f"{scene}: its structure and loads", flush=True)
        prepare(read_scene(scene, ()))


if __name__ == "__main__":
    try:
        compile_all([Path(name) for name in sys.argv[1:]])
    except InputError as error:
        sys.exit(f"masonry_cd.app.compile_all: {error}")
