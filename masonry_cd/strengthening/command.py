# SPDX-License-Identifier: GPL-3.0-or-later
"""The command ``masonry-cd strengthen``: from a scene to its least strengthening, its files, and runs before and after."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from masonry_cd.app.folders import free_folder
from masonry_cd.app.result import Result, Say, silent
from masonry_cd.app.scene import Scene, parse_scene
from masonry_cd.strengthening.design import StrengtheningDesign, strengthened
from masonry_cd.strengthening.facts import facts, lines

SHAKEN = "shaken"  # folder of the runs


@dataclass(frozen=True)
class StrengtheningFiles:
    """The folder for the files of a strengthening, and what is written there.

    Attributes:
        folder: for them, created if missing.
        force: overwrite those that are there.
        pictures: draw them.
        view: of the pictures.
        shake: run the scene with its own loads before and after.
        quiet: no progress of these runs.
    """

    folder: Path
    force: bool = False
    pictures: bool = True
    view: str = "auto"
    shake: bool = False
    quiet: bool = True


def strengthen(scene: Scene, files: StrengtheningFiles | None = None, say: Say = silent) -> Result[StrengtheningDesign]:
    """Find the least ties that bring a scene to its target, and write what was found.

    Args:
        scene: with a table [strengthen].
        files: where it is written; nowhere by default.
        say: takes a line for each round.

    Raises:
        InputError: anything wrong with the scene or the folder, or a target that the candidates do not reach.
    """
    if files is None:
        made = strengthened(scene, say)
        found = facts(made)
        return Result(made, lines(found), found["notes"])
    from masonry_cd.strengthening.files import EVERY, write
    from reports.drawing.parts import view_named

    free_folder(files.folder, EVERY, files.force)
    if files.shake:
        scene.refuse_static()
    if files.pictures and files.view != "auto":
        view_named(files.view)
    made = strengthened(scene, say)
    found, written = write(made, files.folder, files.pictures, files.view)
    shown = lines(found)
    if files.shake:
        more, rows = _shaken(made, files, say)
        written, shown = [*written, *more], [*shown, *rows]
    return Result(made, shown, found["notes"], written)


def _shaken(made: StrengtheningDesign, files: StrengtheningFiles, say: Say) -> tuple[list[Path], list[str]]:
    """The runs of the scene before and after, the files of their comparison, and it as lines."""
    from masonry_cd.app.commands.run import RunRequest, run
    from masonry_cd.strengthening.files import scene_text
    from reports.compare.comparison import compare, markdown, write_comparison

    scene, place = made.asked.scene, files.folder / SHAKEN
    for name, rows in (("before", []), ("after", made.rows)):
        run(parse_scene(scene_text(scene, rows), scene.path), place / name, RunRequest(force=files.force, quiet=files.quiet), say)
    found = compare([place / "before", place / "after"], ["before", "after"])
    return write_comparison(found, place), markdown(found).splitlines()
