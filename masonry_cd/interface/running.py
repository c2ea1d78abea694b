# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs scenes, and resumes runs that were stopped, as the command line does."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_cd.app.folders import RUN, free_folder
from masonry_cd.app.result import Result
from masonry_cd.interface.returned import returned
from masonry_cd.interface.scenes import Scene, origin_of, scene
from masonry_cd.interface.temporary import TemporaryFolder, place_of
from masonry_cd.io.checkpoint import NAME, require

if TYPE_CHECKING:
    from masonry_cd.app.case import Case
    from masonry_cd.app.run_case import Own
    from masonry_cd.interface.results import Run


def run(
    source: Scene | str | os.PathLike[str] | Mapping[str, Any],
    folder: str | os.PathLike[str] | None = None,
    *,
    progress: bool = True,
    force: bool = False,
) -> Run:
    """Compute a scene.

    Args:
        source: a scene, or what :func:`masonry_cd.scene` makes one of.
        folder: for the results, created if missing; by default a temporary one that lasts as long as the run that is returned.
        progress: say on standard error how far it is: a bar on a terminal, a line every ten seconds elsewhere.
        force: overwrite what the folder holds.

    The whole scene is checked before anything is written. Ctrl-C, or the button that interrupts a notebook, ends the run after its step:
    what is returned reads as any other run, ``stopped`` says why it ended, and :func:`masonry_cd.resume` continues it. A loop of runs
    looks at ``stopped`` and breaks. In other threads than the main one nothing interrupts a run. Warnings of the run are shown as
    :class:`RunWarning`.

    Raises:
        InputError: anything wrong with the scene, or a folder that holds results already.

    >>> import masonry_cd as mc
    >>> run = mc.run(mc.scene("examples/trilithon.toml", "run.duration=0.01"), progress=False)
    >>> run
    <Run "Trilithon": 2 frames to 0.01 s>
    >>> run.summary["steps"], run.summary["joints"], run.stopped
    (20, 4, '')
    >>> run.joints.loc[0, ["block_a", "block_b", "state"]].tolist()
    ['ground', 'left', 'intact']
    """
    from masonry_cd.app.commands.run import RunRequest
    from masonry_cd.app.commands.run import run as command

    asked, (place, keeper) = scene(source), place_of(folder)
    settings = RunRequest(force, quiet=not progress, place=lambda there: asked.placed(there, force))
    return _returned(command(asked.checked, place, settings), place, keeper)


def recorded(case: Case, asked: Scene, folder: str | os.PathLike[str] | None, own: Own, progress: bool = True, force: bool = False) -> Run:
    """Run a case that is prepared with code of its own, see :func:`run`."""
    from masonry_cd.app.commands.run import RunRequest, computed

    place, keeper = place_of(folder)
    free_folder(place, RUN, force)
    settings = RunRequest(force, quiet=not progress, own=own, place=lambda there: asked.placed(there, force))
    return _returned(computed(case, place, settings), place, keeper, 5)


def resume(source: Run | str | os.PathLike[str], *, progress: bool = True) -> Run:
    """Resume a run that was stopped or killed, from its last checkpoint; it ends with the bits of an unbroken one.

    Args:
        source: the run, or its folder; also of a run of the command line, whose scene file and the files it names must be where they were.
        progress: see :func:`run`.

    Raises:
        InputError: nothing to resume, or files that have changed since.
    """
    from masonry_cd.app.commands.run import RunRequest
    from masonry_cd.app.commands.run import run as command
    from masonry_cd.interface.results import Run as Opened
    from masonry_cd.io.results import Results

    place, keeper = (source.folder, source.keeper) if isinstance(source, Opened) else (Path(source), None)
    require(place / NAME)
    with Results.open(place / RUN[0]) as found:
        asked = origin_of(found).checked()
    return _returned(command(asked, place, RunRequest(resume=True, quiet=not progress)), place, keeper)


def _returned(result: Result[Any], folder: Path, keeper: TemporaryFolder | None, level: int = 4) -> Run:
    """The run that a command left in a folder, whose warnings are shown to the caller of the function that calls this one."""
    from masonry_cd.interface.results import Run as Opened

    made = Opened(folder, keeper)
    return returned(replace(result, value=made, warnings=made.warnings), level)
