# SPDX-License-Identifier: GPL-3.0-or-later
"""The command ``masonry-cd limit``: from a scene to its limit analysis, and its files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from masonry_cd.app.folders import free_folder
from masonry_cd.app.result import Result
from masonry_cd.app.scene import Scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.limit.case import LimitCase, WantedMechanisms, limit_case
from masonry_cd.limit.kept import NAME, KeptParts
from masonry_cd.limit.words import lines


@dataclass(frozen=True)
class LimitFiles:
    """The folder for the files of an analysis, and what is written there.

    Attributes:
        folder: for them, created if missing.
        force: overwrite those that are there.
        resume: continue an analysis of this scene that was stopped in this folder; parts that are kept there are not analysed again.
        pictures: draw them.
        view: of the pictures.
        run: folder of a run, whose damage stands next to the parts.
    """

    folder: Path
    force: bool = False
    resume: bool = False
    pictures: bool = True
    view: str = "auto"
    run: Path | None = None


def limit(scene: Scene, wanted: WantedMechanisms, files: LimitFiles | None = None) -> Result[LimitCase]:
    """Analyse a scene and write what was found.

    Args:
        scene: what is analysed.
        wanted: what is looked at in addition to what it asks for.
        files: where it is written; nowhere by default.

    Raises:
        InputError: anything wrong with the scene or the folders.
    """
    if files is not None:
        _refuse_files(scene, wanted, files)
    if files is None:
        case = limit_case(scene, wanted=wanted)
        return Result(case, lines(case), case.notes)
    from masonry_cd.limit.files import write

    folder, resume = files.folder, files.resume
    case = limit_case(scene, wanted=wanted, keep=lambda structure: KeptParts.to(folder, structure, resume))
    written = write(case, folder, files.pictures, files.view, files.run)
    (folder / NAME).unlink(missing_ok=True)
    return Result(case, lines(case), case.notes, written)


def _refuse_files(scene: Scene, wanted: WantedMechanisms, files: LimitFiles) -> None:
    """Refuse folders and views before anything is computed.

    Raises:
        InputError: names the option.
    """
    from masonry_cd.limit.files import EVERY
    from reports.drawing.parts import view_named

    free_folder(files.folder, EVERY, files.force or files.resume)
    if files.pictures and files.view != "auto":
        view_named(files.view)
    if files.run is None:
        return
    if not (wanted.parts or scene.limit.get("mechanism")):
        raise InputError("--run", "its damage stands next to macro-elements only; give --macro-elements")
    if not (files.run / "damage.csv").exists():
        raise InputError("--run", f"{files.run} has no damage.csv; set [report] damage = true in its scene and run it again")
