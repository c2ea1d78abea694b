# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs scenes, and resumes runs that were stopped, as the command line does."""

from __future__ import annotations

import os
import signal
import warnings
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_cd.app.folders import RUN, free_folder
from masonry_cd.app.progress import Interrupted
from masonry_cd.interface.scenes import Scene, origin_of, scene
from masonry_cd.interface.temporary import TemporaryFolder

if TYPE_CHECKING:
    from masonry_cd.app.case import Case
    from masonry_cd.app.run_case import Own
    from masonry_cd.interface.results import Run


class RunWarning(UserWarning):
    """What a run must not pass over in silence: ``warnings.simplefilter("error", mc.RunWarning)`` makes errors of them."""


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
        folder: for the results, made if need be; by default a temporary one that lasts as long as the run that is returned.
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
    asked = scene(source)
    keeper = TemporaryFolder() if folder is None else None
    place = keeper.path if keeper is not None else Path(str(folder))
    free_folder(place, RUN, force)
    from masonry_cd.app.case import prepare  # numba and the kernels come with it, after the cheap checks

    case = prepare(asked.checked)
    return _computed(replace(case, scene=asked.placed(place, force)), place, keeper, progress)


def recorded(case: Case, asked: Scene, folder: str | os.PathLike[str] | None, own: Own, progress: bool = True, force: bool = False) -> Run:
    """Run a case that is prepared with code of its own, see :func:`run`."""
    keeper = TemporaryFolder() if folder is None else None
    place = keeper.path if keeper is not None else Path(str(folder))
    free_folder(place, RUN, force)
    return _computed(replace(case, scene=asked.placed(place, force)), place, keeper, progress, own=own)


def resume(source: Run | str | os.PathLike[str], *, progress: bool = True) -> Run:
    """Resume a run that was stopped or killed, from its last checkpoint; it ends with the bits of an unbroken one.

    Args:
        source: the run, or its folder; also of a run of the command line, whose scene file and the files it names must be where they were.
        progress: see :func:`run`.

    Raises:
        InputError: nothing to resume, or files that have changed since.
    """
    from masonry_cd.interface.results import Run as Opened
    from masonry_cd.io import checkpoint
    from masonry_cd.io.results import Results

    place, keeper = (source.folder, source.keeper) if isinstance(source, Opened) else (Path(source), None)
    checkpoint.require(place / checkpoint.NAME)
    with Results.open(place / RUN[0]) as found:
        asked = origin_of(found).checked()
    from masonry_cd.app.case import prepare

    return _computed(prepare(asked), place, keeper, progress, resumed=True)


def _computed(
    case: Case, folder: Path, keeper: TemporaryFolder | None, progress: bool, resumed: bool = False, own: Own | None = None
) -> Run:
    """Compute a case into a folder; a signal other than Ctrl-C has its usual effect afterwards."""
    from masonry_cd.app.run_case import run_case
    from masonry_cd.interface.results import Run as Opened

    try:
        number = int(run_case(case, folder, quiet=not progress, resume=resumed, own=own)["signal"])
    except Interrupted as asked:  # while the reports were drawn: the results are whole
        number = asked.number
    if number not in (0, signal.SIGINT):
        signal.raise_signal(number)
    made = Opened(folder, keeper)
    for line in made.warnings:
        warnings.warn(line, RunWarning, stacklevel=3 if own is None else 4)  # of who called
    return made
