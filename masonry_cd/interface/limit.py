# SPDX-License-Identifier: GPL-3.0-or-later
"""Limit analysis of a scene: the load factor, the mechanism, the check by a code."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_cd.app.folders import free_folder
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.extras import require
from masonry_cd.interface.plots import Page
from masonry_cd.interface.returned import RunWarning
from masonry_cd.interface.scenes import Scene, scene
from masonry_cd.interface.sealed import Sealed
from masonry_cd.interface.tables import frame_of_rows
from masonry_cd.interface.temporary import TemporaryFolder

if TYPE_CHECKING:
    from pandas import DataFrame
    from PIL.Image import Image

    from masonry_cd.app.limit_case import LimitCase


class LimitAnalysis(Sealed):
    """What a limit analysis found. Made by :func:`masonry_cd.limit_analysis`; ``print`` shows the lines of the command."""

    def __init__(self, case: LimitCase, folder: Path | None = None) -> None:
        self._case, self._folder = case, folder

    @property
    def folder(self) -> Path | None:
        """The folder into which it was written, if it was."""
        return self._folder

    @property
    def stands(self) -> bool:
        """Whether the structure bears its dead loads."""
        return self._case.analysis.stands

    @property
    def factor(self) -> float | None:
        """The load factor, of associated sliding: an upper value. None where the structure does not stand, where supports move, or where no
        factor is finite."""
        found: float | None = self.summary["associated"]
        return found

    @property
    def least(self) -> float | None:
        """The least factor found for sliding without dilation; None where none was searched for or found."""
        return self.summary["least"]["factor"] if self.summary["least"] else None

    @cached_property
    def summary(self) -> dict[str, Any]:
        """What limit.json holds."""
        from masonry_cd.app.limit_case import summary

        return summary(self._case)

    @cached_property
    def blocks(self) -> DataFrame:
        """How each block moves in the mechanism: velocities over the largest one of any corner, angular ones per metre."""
        from reports.limit.tables import BLOCKS, block_rows

        rows = block_rows(self._case.collapse, self._case.assembly)
        return frame_of_rows([dict(zip(BLOCKS, row, strict=True)) for row in rows], "block")

    @cached_property
    def joints(self) -> DataFrame:
        """What each joint does in the mechanism, its forces [N] and where they act [m]."""
        from reports.limit.tables import JOINTS, joint_rows

        rows = joint_rows(self._case.collapse, self._case.assembly, self._case.joints)
        return frame_of_rows([dict(zip(JOINTS, row, strict=True)) for row in rows], "joint")

    @property
    def check(self) -> DataFrame | None:
        """The check by a code, value by value: symbol, value, unit, clause, meaning; ``attrs["verdicts"]`` say what is satisfied,
        not satisfied or not decided.

        None without a table ``[limit.check]``, and where the structure does not stand.
        """
        if self._case.check is None:
            return None
        numbers = self._case.check.numbers()
        return frame_of_rows(numbers["steps"], "symbol", verdicts=numbers["verdicts"])

    @property
    def verdict(self) -> dict[str, Any] | None:
        """The one verdict of the check: ``state``, ``ratio``, ``demand``, ``capacity``, ``margin``, ``mechanism``, ``search``, ``words``.

        None without a table ``[limit.check]``.
        """
        found: dict[str, Any] | None = self.summary["verdict"]
        return found

    @property
    def capacity(self) -> DataFrame | None:
        """The capacity curve, point by point: displacement of the control block [m], factor, what moves; ``attrs["end"]`` says why it ends.

        None without a table ``[limit.curve]``.
        """
        from masonry_cd.app.limit_curve import curve_rows

        if self._case.curve is None:
            return None
        curve = self._case.curve
        return frame_of_rows(curve_rows(curve), "point", end=curve.end, control=self._case.assembly.names[curve.control.block])

    def mechanism(self, view: str = "auto") -> Image:
        """The moved blocks with hinges and slips, as an image that a notebook shows; ``view`` as in :meth:`Scene.picture`."""
        return self._picture("mechanism.png", view)

    def thrust(self, view: str = "auto") -> Image:
        """The forces at collapse, as an image.

        Raises:
            InputError: the structure does not stand.
        """
        if not self.stands:
            raise InputError("limit analysis", "the structure does not stand: there are no forces to draw")
        return self._picture("thrust.png", view)

    def capacity_curve(self, view: str = "auto") -> Image:
        """The capacity curve and the structure at marked points, as an image.

        Raises:
            InputError: the scene has no table ``[limit.curve]``.
        """
        if self._case.curve is None:
            raise InputError("limit analysis", "no curve was followed: give the scene a table [limit.curve]")
        return self._picture("capacity.png", view)

    def write(self, folder: str | os.PathLike[str], *, force: bool = False) -> Page:
        """Write what ``masonry-cd limit`` writes into a folder, and return its page.

        Raises:
            InputError: a folder that holds such files already, without ``force``.
        """
        from masonry_cd.app.limit_case import EVERY
        from masonry_cd.app.limit_files import write

        self._folder = Path(folder)
        free_folder(self._folder, EVERY, force)
        write(self._case, self._folder)
        return Page(self._folder / "limit.html")

    def _picture(self, name: str, view: str) -> Image:
        require("a picture", "PIL")
        from PIL import Image as images

        from masonry_cd.app.limit_files import draw

        keeper = TemporaryFolder()
        draw(self._case, keeper.path, view)
        with images.open(keeper.path / name) as found:
            return found.copy()

    def __str__(self) -> str:
        from masonry_cd.app.limit_case import lines

        return "\n".join(lines(self._case))

    def __repr__(self) -> str:
        found = "does not stand" if not self.stands else "no load factor" if self.factor is None else f"load factor {self._known()}"
        return f'<LimitAnalysis "{self._case.scene.title}": {self._case.loads.words}, {found}>'

    def _known(self) -> str:
        """What is known of the factor: from the least found up to the associated one, which is an upper value."""
        return f"at most {self.factor:.5g}" if self.least is None else f"{self.least:.5g} (least found) to {self.factor:.5g}"


def limit_analysis(
    source: Scene | str | os.PathLike[str] | Mapping[str, Any], folder: str | os.PathLike[str] | None = None, *, force: bool = False
) -> LimitAnalysis:
    """The largest load that a scene bears at rest, and how it gives way, as ``masonry-cd limit`` finds them.

    Args:
        source: a scene, or what :func:`masonry_cd.scene` makes one of; its table ``limit`` says what is multiplied.
        folder: where tables, pictures and page are written; nowhere by default.
        force: overwrite what the folder holds.

    Raises:
        InputError: anything wrong with the scene, or a limit analysis without an answer.

    >>> import masonry_cd as mc
    >>> found = mc.limit_analysis(mc.scene("examples/arch.toml", limit={"push": "x"}))
    >>> found.stands, round(found.factor, 3), found.least <= found.factor + 1e-9
    (True, 0.239, True)
    >>> int((found.joints["state"] == "hinge").sum())
    4
    """
    from masonry_cd.app.limit_case import case_of

    found = LimitAnalysis(case_of(scene(source).checked))
    if folder is not None:
        found.write(folder, force=force)
    for line in found.summary["notes"]:
        warnings.warn(line, RunWarning, stacklevel=2)
    return found
