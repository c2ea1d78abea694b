# SPDX-License-Identifier: GPL-3.0-or-later
"""The least strengthening of a scene, as ``masonry-cd strengthen`` finds it: ties, parts before and after, and the strengthened scene."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_cd.interface.limit import LimitAnalysis
from masonry_cd.interface.plots import Page
from masonry_cd.interface.returned import returned
from masonry_cd.interface.scenes import Scene, scene
from masonry_cd.interface.sealed import Sealed
from masonry_cd.interface.tables import frame_of_rows

if TYPE_CHECKING:
    from pandas import DataFrame

    from masonry_cd.strengthening.design import StrengtheningDesign as Design


class Strengthening(Sealed):
    """The least ties that bring a scene to its target. Made by :func:`masonry_cd.strengthen`; ``print`` shows the lines of the command."""

    def __init__(self, made: Design, source: Scene, folder: Path | None = None) -> None:
        self._made, self._source, self._folder = made, source, folder

    @property
    def folder(self) -> Path | None:
        """The folder into which it was written, if it was."""
        return self._folder

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The contents of strengthen.json."""
        from masonry_cd.strengthening.facts import facts

        return facts(self._made)

    @property
    def ties(self) -> DataFrame:
        """The ties: where they lie, least force and bar [N, m], worth of one kN more in load factor, cost."""
        return frame_of_rows(self.summary["ties"], "name")

    @property
    def parts(self) -> DataFrame:
        """Each part and push: its least mechanism before, with the least forces, and with bars."""
        return frame_of_rows(self.summary["parts"])

    @property
    def cost(self) -> float:
        """The cost of the bars and their anchors."""
        return self._made.cost

    @property
    def before(self) -> tuple[LimitAnalysis, ...]:
        """The limit analyses without the ties: of the whole under each push, then of the macro-elements."""
        return tuple(LimitAnalysis(case) for case in self._made.before)

    @property
    def after(self) -> tuple[LimitAnalysis, ...]:
        """These analyses with the bars."""
        return tuple(LimitAnalysis(case) for case in self._made.after)

    @property
    def scene(self) -> Scene:
        """The scene with its ties, to run or analyse."""
        return self._source.changed(structure={"ties": [*self._source.tables["structure"].get("ties", ()), *self._made.rows]})

    @property
    def page(self) -> Page:
        """strengthen.html with all of it.

        Raises:
            InputError: it was written into no folder.
        """
        from masonry_cd.foundation.errors import InputError

        if self._folder is None:
            raise InputError("strengthen", "was written into no folder; give it one")
        return Page(self._folder / "strengthen.html")

    def __str__(self) -> str:
        from masonry_cd.strengthening.facts import lines

        return "\n".join(lines(self.summary))

    def __repr__(self) -> str:
        return f'<Strengthening "{self._made.asked.scene.title}": {self.summary["on_the_whole"]["grade"]}>'


def strengthen(
    source: Scene | str | os.PathLike[str] | Mapping[str, Any],
    folder: str | os.PathLike[str] | None = None,
    *,
    shake: bool = False,
    force: bool = False,
) -> Strengthening:
    """The least ties that bring a scene to a load factor, as ``masonry-cd strengthen`` finds them.

    Args:
        source: a scene, or what :func:`masonry_cd.scene` makes one of; its table ``strengthen`` has target and candidates.
        folder: where tables, pictures, page and strengthened scene are written; nowhere by default.
        shake: run the scene with its own loads before and after, into the folder.
        force: overwrite what the folder holds.

    Raises:
        InputError: anything wrong with the scene, or a target that its candidates do not reach.

    >>> import masonry_cd as mc
    >>> pier, wall = mc.box((-2, -0.2, 0), (-1, 0.2, 3)), mc.box((0, -0.2, 0), (0.5, 0.2, 3))
    >>> made = mc.scene(
    ...     structure={"blocks": [mc.box((-4, -4, -1), (4, 4, 0)), pier, wall], "fixed": ["b0", "b1"]},
    ...     material={"density": 2000.0, "friction": 0.8},
    ...     limit={"push": "x"},
    ...     strengthen={"factor": 0.3, "ties": [{"along": "x", "height": 2.5, "at": [0.0], "parts": ["b1", "b2"]}]},
    ... )
    >>> found = mc.strengthen(made)
    >>> found.ties["least_force"].round().tolist(), round(found.summary["factor"]["before"], 4)
    ([944.0], 0.1667)
    """
    from masonry_cd.foundation.errors import InputError
    from masonry_cd.strengthening.command import StrengtheningFiles
    from masonry_cd.strengthening.command import strengthen as command

    if shake and folder is None:
        raise InputError("shake", "needs a folder for its runs")
    asked = scene(source)
    where = None if folder is None else Path(folder)
    made = returned(command(asked.checked, None if where is None else StrengtheningFiles(where, force, shake=shake)))
    return Strengthening(made, asked, where)
