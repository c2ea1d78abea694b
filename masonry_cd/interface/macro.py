# SPDX-License-Identifier: GPL-3.0-or-later
"""The macro-elements of a scene: each part with all else held, the table that ranks them, the one verdict."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_cd.app.folders import free_folder
from masonry_cd.interface.plots import Page
from masonry_cd.interface.returned import RunWarning
from masonry_cd.interface.scenes import Scene, scene
from masonry_cd.interface.sealed import Sealed
from masonry_cd.interface.tables import frame_of_rows

if TYPE_CHECKING:
    from pandas import DataFrame

    from masonry_cd.app.limit_macro import MacroCase
    from masonry_cd.app.macro_verdicts import MacroRow


class MacroElements(Sealed):
    """What was found of the parts of a structure. Made by :func:`masonry_cd.macro_elements`; ``print`` shows the lines of the command."""

    def __init__(self, case: MacroCase, folder: Path | None = None) -> None:
        self._case, self._folder = case, folder

    @property
    def folder(self) -> Path | None:
        """The folder into which it was written, if it was."""
        return self._folder

    @property
    def parts(self) -> DataFrame:
        """The gravest mechanism of each part and push, the least ratio first, with the columns of macro_elements.csv: ``alpha0``,
        ``e_star``, ``a0_m_s2`` over the confidence factor and ``demand_m_s2``, ``d0_m``, ``displacement_m`` borne and what is asked for,
        ``ratio`` and ``verdict`` of the check that decides.

        Without a table ``[limit.check]`` the least a0* comes first, and there is no demand, ratio or verdict.
        """
        from masonry_cd.app.limit_macro import least_rows

        return _frame(least_rows(self._case.rows))

    @property
    def mechanisms(self) -> DataFrame:
        """All mechanisms of all parts, as :attr:`parts` has the gravest."""
        return _frame(self._case.rows)

    @property
    def held(self) -> tuple[tuple[str, str], ...]:
        """Parts and pushes without a mechanism below five times the weight."""
        from masonry_cd.app.macro_verdicts import way_words

        return tuple((one.element.name, way_words(one.direction)) for one in self._case.parts if not one.mechanisms)

    @property
    def verdict(self) -> dict[str, Any] | None:
        """The one verdict: ``state``, ``ratio``, ``demand``, ``capacity``, ``mechanism``, ``words``; None without ``[limit.check]``."""
        return None if self._case.verdict is None else self._case.verdict.numbers()

    @cached_property
    def summary(self) -> dict[str, Any]:
        """What macro_elements.json holds."""
        from masonry_cd.app.macro_files import macro_summary

        return macro_summary(self._case)

    def write(self, folder: str | os.PathLike[str], *, force: bool = False) -> Page:
        """Write what ``masonry-cd limit --macro-elements`` writes of the parts into a folder, and return its page.

        Raises:
            InputError: a folder that holds such files already, without ``force``.
        """
        from masonry_cd.app.macro_files import MACRO_OUTPUTS, write_macro

        self._folder = Path(folder)
        free_folder(self._folder, MACRO_OUTPUTS, force)
        write_macro(self._case, self._folder)
        return Page(self._folder / "macro_elements.html")

    def __str__(self) -> str:
        from masonry_cd.app.limit_macro import lines

        return "\n".join(lines(self._case))

    def __repr__(self) -> str:
        names = len({one.element.name for one in self._case.parts})
        state = "" if self._case.verdict is None else f", {self._case.verdict.state}"
        return f'<MacroElements "{self._case.scene.title}": {names} parts{state}>'


def _frame(rows: Sequence[MacroRow]) -> DataFrame:
    """Rows as a table with the heads of the CSV file."""
    from reports.limit.page import COLUMNS, HEADS

    return frame_of_rows([{head: getattr(row, name) for name, head in zip(COLUMNS, HEADS, strict=True)} for row in rows])


def macro_elements(
    source: Scene | str | os.PathLike[str] | Mapping[str, Any],
    folder: str | os.PathLike[str] | None = None,
    *,
    chosen: bool = False,
    jobs: int | None = None,
    force: bool = False,
) -> MacroElements:
    """The parts of a structure one by one, each with all else held, as ``masonry-cd limit --macro-elements`` looks at them.

    Args:
        source: a scene, or what :func:`masonry_cd.scene` makes one of; its table ``limit`` may choose or add parts, and check them.
        folder: where table, pictures and page are written; nowhere by default.
        chosen: look at the parts of ``[[limit.mechanism]]`` only, not at all that the kind of the structure names.
        jobs: processes; as many as there are cores by default.
        force: overwrite what the folder holds.

    Raises:
        InputError: anything wrong with the scene, or a part that names no block.

    >>> import masonry_cd as mc
    >>> wall = {"kind": "wall", "length": 2.0, "height": 2.0, "thickness": 0.4, "course_height": 0.5}
    >>> walls = {"structure": wall, "material": {"density": 2000.0, "friction": 0.6}, "limit": {"starts": 2}}
    >>> found = mc.macro_elements(mc.scene(walls), jobs=1)
    >>> found.parts["element"].iloc[0], round(float(found.parts["alpha0"].min()), 2)
    ('wall', 0.2)
    """
    from masonry_cd.app.limit_macro import macro_case

    found = MacroElements(macro_case(scene(source).checked, not chosen, jobs))
    if folder is not None:
        found.write(folder, force=force)
    for line in found.summary["notes"]:
        warnings.warn(line, RunWarning, stacklevel=2)
    return found
