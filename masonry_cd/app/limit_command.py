# SPDX-License-Identifier: GPL-3.0-or-later
"""The command ``masonry-cd limit``: the structure as a whole, its macro-elements, or both, and the one verdict of all."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from masonry_cd.analysis.code_check.verdicts import worst
from masonry_cd.analysis.limit.outcome import on_the_check, on_the_whole
from masonry_cd.app.scene import Scene, read_scene
from masonry_cd.foundation.errors import InputError

if TYPE_CHECKING:
    from masonry_cd.app.limit_case import LimitCase
    from masonry_cd.app.limit_macro import MacroCase

PATTERNS = ("push", "tilt", "live")  # keys of [limit] that multiply something


@dataclass(frozen=True)
class Asked:
    """What is asked of the command."""

    folder: Path
    curve: bool = False
    macro_elements: bool = False
    run: Path | None = None
    pictures: bool = True
    view: str = "auto"
    quiet: bool = False


def limit_command(path: Path, changes: Sequence[str], asked: Asked, say: Callable[[str], object]) -> list[Path]:
    """Analyse a scene file, say what was found and write it.

    Args:
        path: of the scene.
        changes: of its keys, ``key=value``.
        asked: what is looked at and where it goes.
        say: prints.

    Raises:
        InputError: anything wrong with the scene or the folder of the run.
    """
    from masonry_cd.app.limit_case import lines, summary
    from masonry_cd.app.limit_files import write
    from masonry_cd.app.limit_macro import lines as macro_lines
    from masonry_cd.app.macro_files import write_macro

    scene = read_scene(path, changes)
    parts = asked.macro_elements or bool(scene.limit.get("mechanism"))
    if asked.run is not None and not parts:
        raise InputError("--run", "stands beside macro-elements only; give --macro-elements")
    if asked.run is not None and not (asked.run / "damage.csv").exists():
        raise InputError("--run", f"{asked.run} has no damage.csv; a run writes it where [report] damage = true")
    whole, found = looked_at(scene, asked.macro_elements, asked.curve, quiet=asked.quiet)
    written = []
    judged = found.verdict if found is not None else None
    verdict = on_the_whole(summary(whole)) if whole is not None else on_the_check(judged.numbers() if judged is not None else None)
    if verdict is not None:
        say(verdict.line)
    if whole is not None:
        say("\n".join(lines(whole)))
        written += write(whole, asked.folder, asked.pictures, asked.view)
    if found is not None:
        known = () if whole is None else whole.notes
        say("\n".join(line for line in macro_lines(found) if line not in known))
        written += write_macro(found, asked.folder, asked.pictures, asked.view, asked.run)
    return written


def looked_at(
    scene: Scene, every: bool = False, curve: bool = False, jobs: int | None = None, quiet: bool = True
) -> tuple[LimitCase | None, MacroCase | None]:
    """The whole of a scene where it names a push or has no parts to look at, its macro-elements, and the one verdict in both.

    Args:
        scene: what is analysed.
        every: look at the parts of the structure's kind as well as at those of ``[[limit.mechanism]]``.
        curve: follow the mechanism of the whole.
        jobs: processes for the parts; as many as there are cores by default.
        quiet: do not say how long it still takes.

    Raises:
        InputError: anything wrong with the scene.
    """
    from masonry_cd.app.limit_case import case_of
    from masonry_cd.app.limit_macro import macro_case

    found = macro_case(scene, every, jobs, quiet) if every or scene.limit.get("mechanism") else None
    known = [] if found is None else [one.mechanisms[0] for one in found.parts if one.mechanisms]
    whole = case_of(scene, curve, known, quiet) if found is None or has_pattern(scene) else None
    verdicts = [one.verdict for one in (found, whole) if one is not None and one.verdict is not None]
    if whole is not None and found is not None and verdicts:
        whole, found = replace(whole, verdict=worst(verdicts)), replace(found, verdict=worst(verdicts))
    return whole, found


def has_pattern(scene: Scene) -> bool:
    """Whether a scene names what a limit analysis of the whole multiplies."""
    if any(scene.limit.get(name) for name in PATTERNS):
        return True
    from loads.static import patterns

    with scene.locating():
        return any(patterns(scene.loads, scene.folder))
