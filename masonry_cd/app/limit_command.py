"""The command ``masonry-cd limit``: the structure as a whole, its macro-elements, or both, and the one verdict of all."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from masonry_cd.app.scene import Scene, read_scene
from masonry_cd.foundation.errors import InputError

PATTERNS = ("push", "tilt", "live")  # keys of [limit] that multiply something
KINDS = ("push", "tilt", "settlement", "spreading")  # loads that do


@dataclass(frozen=True)
class Asked:
    """What is asked of the command."""

    folder: Path
    curve: bool = False
    macro_elements: bool = False
    run: Path | None = None
    pictures: bool = True
    view: str = "auto"


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
    from masonry_cd.app.limit_case import case_of, lines, write
    from masonry_cd.app.limit_macro import lines as macro_lines
    from masonry_cd.app.limit_macro import macro_case
    from masonry_cd.app.macro_files import write_macro

    scene = read_scene(path, changes)
    parts = asked.macro_elements or bool(scene.limit.get("mechanism"))
    if asked.run is not None and not parts:
        raise InputError("--run: stands beside macro-elements only; give --macro-elements")
    if asked.run is not None and not (asked.run / "damage.csv").exists():
        raise InputError(f"--run: {asked.run} has no damage.csv; a run writes it where [report] damage = true")
    whole = case_of(scene, asked.curve) if not parts or has_pattern(scene) else None
    found = macro_case(scene, asked.macro_elements, whole=None if whole is None else whole.verdict) if parts else None
    if whole is not None and found is not None:
        whole = replace(whole, verdict=found.verdict)  # the least of all that was looked at
    written = []
    if whole is not None:
        say("\n".join(lines(whole)))
        written += write(whole, asked.folder, asked.pictures, asked.view)
    if found is not None:
        say("\n".join(macro_lines(found)))
        written += write_macro(found, asked.folder, asked.pictures, asked.view, asked.run)
    return written


def has_pattern(scene: Scene) -> bool:
    """Whether a scene names what a limit analysis of the whole multiplies."""
    return any(scene.limit.get(name) for name in PATTERNS) or any(
        load.get("kind") in KINDS and load.get("control") != "displacement" for load in scene.loads
    )
