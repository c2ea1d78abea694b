# SPDX-License-Identifier: GPL-3.0-or-later
"""A run for ParaView, or a scene for another program: what ``masonry-cd export`` writes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from masonry_cd.analysis.outputs.folders import files_of
from masonry_cd.app.case import Case, prepare
from masonry_cd.app.folders import free_folder
from masonry_cd.app.result import Result
from masonry_cd.app.scene import Scene
from masonry_cd.foundation import own_files
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.io import deck_3dec, deck_lmgc90
from masonry_cd.io.deck import Deck
from masonry_cd.io.results import Results
from reports import outputs, paraview
from reports.settings import report_of

DECKS: dict[str, Callable[[Deck], dict[str, str]]] = {"lmgc90": deck_lmgc90.files, "3dec": deck_3dec.files}
PARAVIEW = ("vtkhdf", "pvd")


def export(folder: Path, form: str = "vtkhdf", output: Path | None = None) -> Result[None]:
    """Write a run for ParaView.

    Args:
        folder: of the run.
        form: vtkhdf or pvd.
        output: folder for the files; ``paraview`` in that of the run when not given.

    Raises:
        InputError: no run, or no such format.
    """
    if form in DECKS:
        raise InputError(folder, f"is the folder of a run; a deck for {form} needs a scene file")
    with Results.open(folder / "result.h5") as results:
        thresholds = outputs.thresholds_of(report_of(results.tables))
        written = paraview.export(results, output or folder / "paraview", form, thresholds)
        return Result(None, warnings=results.words, written=written)


def deck(scene: Scene, form: str, folder: Path, force: bool = False) -> Result[None]:
    """Write a scene as the deck of another program: blocks, materials, supports, gravity and base motion.

    Args:
        scene: whose tables are checked.
        form: lmgc90 or 3dec.
        folder: for the files, created if missing.
        force: overwrite the files that are there.

    Raises:
        InputError: no such format, what the other program has no words for, or files that are there.
    """
    if form not in DECKS:
        every = [*PARAVIEW, *DECKS]
        none = f'"{form}" is not a format{suggest(form, every)}; choose one of {", ".join(every)}'
        raise InputError("--format", f"{form} exports a run; give its folder" if form in PARAVIEW else none)
    case = prepare(scene)
    texts = DECKS[form](_deck(case))
    names = files_of("export")
    free_folder(folder, tuple(name for name in names if name in texts), force)
    own_files.begin(folder, names)
    for name, text in texts.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        with replacing(folder / name) as part:
            part.write_text(text, encoding="ascii", errors="replace")
    return Result(None, list(case.notes), list(case.warnings), [folder / name for name in texts])


def _deck(case: Case) -> Deck:
    """Return the deck of a case.

    Raises:
        InputError: loads in addition to a constant gravity and supports that move along the axes; events, links, restitution.
    """
    loading, run = case.loading, case.scene.run
    if loading.forces is not None:
        raise InputError("--format", "decks have motions of supports only, but this scene has ties, forces or pushes on blocks")
    if not np.allclose(loading.acceleration, run.gravity, rtol=0.0, atol=1e-9):
        raise InputError("--format", "decks have a constant gravity only, but loads of this scene change it or accelerate all blocks")
    if case.events:
        raise InputError("--format", "decks have a constant model, but events change that of this scene ([[events]])")
    if case.assembly.footings is not None:
        raise InputError("--format", "decks have supports with a prescribed motion, but those of this scene stand on [[ground]]")
    if case.assembly.links or case.assembly.restitution.any():
        what = "links" if case.assembly.links else "restitution"
        raise InputError("--format", f"decks have contacts without links or restitution, but this scene has {what}")
    if loading.support_velocity[..., 3:].any():
        raise InputError("--format", "decks have supports that move without turning, but some of this scene turn")
    if run.first_velocities is not None:
        raise InputError("--format", "blocks of a deck start at rest, but those of this scene do not (run.first_velocities)")
    motion = loading.support_velocity[: run.steps + 1, :, :3]
    return Deck(case.scene.title, case.assembly, motion, np.array(run.gravity), run.dt, run.theta, run.tolerance)
