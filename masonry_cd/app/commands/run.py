# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene is computed and its results are written: what ``masonry-cd run`` does."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from masonry_cd.app.dump import parse_steps
from masonry_cd.app.folders import RUN, free_folder
from masonry_cd.app.progress import Interrupted
from masonry_cd.app.result import Result, Say, silent
from masonry_cd.app.scene import Scene
from masonry_cd.io import checkpoint
from masonry_cd.io.summary import Summary

if TYPE_CHECKING:
    from masonry_cd.app.case import Case
    from masonry_cd.app.run_case import Own


@dataclass(frozen=True)
class RunRequest:
    """The options of a run."""

    force: bool = False  # overwrite the results that are there
    resume: bool = False  # go on from the last checkpoint
    dump: Sequence[str] = ()  # steps whose friction problems are written, "120" or "120,121"
    explain: bool = False  # list what was left out
    quiet: bool = False  # no progress
    own: Own | None = None  # code that steps the case itself
    place: Callable[[Path], Scene] | None = None  # puts a scene that is in no file into the folder; called once all is checked


def run(scene: Scene, folder: Path, asked: RunRequest | None = None, say: Say = silent) -> Result[Summary | None]:
    """Compute a scene; see :func:`computed`."""
    asked = asked or RunRequest()
    free_folder(folder, RUN, asked.force or asked.resume)
    if asked.resume:
        checkpoint.require(folder / checkpoint.NAME)
    parse_steps(asked.dump)
    from masonry_cd.app.case import prepare  # numba and the kernels come with it, after the cheap checks

    return computed(prepare(scene), folder, asked, say)


def computed(case: Case, folder: Path, asked: RunRequest, say: Say = silent) -> Result[Summary | None]:
    """Compute a case that is prepared, and write everything into a folder, which is created if missing.

    Args:
        case: from :func:`masonry_cd.app.case.prepare`.
        folder: for the results.
        asked: in addition to the scene.
        say: takes the lines on what is about to be computed.

    Raises:
        InputError: see :func:`masonry_cd.app.run_case.run_case`.

    Returns:
        the summary; None where a signal came after the last step and before it was written, which ``resume`` makes up for.
    """
    from masonry_cd.app.closing_lines import closing_lines
    from masonry_cd.app.run_case import file_names, run_case

    for line in _announced(case):
        say(line)
    if asked.place is not None:
        case = replace(case, scene=replace(asked.place(folder), run=case.scene.run))  # whose duration may follow from the loads
    try:
        summary = run_case(case, folder, asked.quiet, asked.resume, parse_steps(asked.dump), own=asked.own)
    except Interrupted as signal:  # the steps are done; what is left to write is not
        return Result(None, stopped=str(signal), signal=signal.number, resumable=True, warnings=[f"{signal} before all files were written"])
    lines = closing_lines(summary)
    if asked.explain:
        lines += ["left out, and why:", *(f"- {line}" for line in summary.explanation)]
    written = [folder / name for name in (*file_names(), *summary.dumped) if (folder / name).exists()]
    return Result(summary, lines, [*summary.warnings], written, summary.stopped, summary.signal, resumable=bool(summary.signal))


def _announced(case: Case) -> list[str]:
    """The lines on what is about to be computed."""
    from masonry_cd.app.closing_lines import announced

    settings = case.scene.run
    joints = f"{case.assembly.count} blocks, {case.joints.count} joints"
    head = f"{case.scene.title}: {joints}, {announced(settings)}, solver {settings.solver}"
    return [head, *case.notes, *case.loading.lines, *(f"warning: {line}" for line in case.warnings)]
