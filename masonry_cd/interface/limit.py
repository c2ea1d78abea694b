# SPDX-License-Identifier: GPL-3.0-or-later
"""Limit analysis of a scene: the load factor, the mechanisms of the whole and of its parts, the code check."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_cd.app.folders import free_folder
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.extras import require
from masonry_cd.interface.plots import Page
from masonry_cd.interface.returned import returned
from masonry_cd.interface.scenes import Scene, scene
from masonry_cd.interface.sealed import Sealed
from masonry_cd.interface.tables import frame_of_rows
from masonry_cd.interface.temporary import TemporaryFolder

if TYPE_CHECKING:
    from pandas import DataFrame
    from PIL.Image import Image

    from masonry_cd.limit.case import LimitCase, WantedMechanisms
    from masonry_cd.limit.checked import Checked
    from masonry_cd.limit.whole import WholeAnalysis


class LimitAnalysis(Sealed):
    """A limit analysis. Made by :func:`masonry_cd.limit_analysis` and :func:`masonry_cd.macro_elements`; ``print`` shows the lines of the
    command."""

    def __init__(self, case: LimitCase, folder: Path | None = None) -> None:
        self._case, self._folder = case, folder

    @property
    def _whole(self) -> WholeAnalysis:
        if self._case.whole is None:
            raise InputError("limit analysis", "the scene multiplies no load, and parts alone were looked at; give it limit.push")
        return self._case.whole

    @property
    def folder(self) -> Path | None:
        """The folder into which it was written, if it was."""
        return self._folder

    @property
    def stands(self) -> bool:
        """True of a structure that bears its dead loads.

        Raises:
            InputError: parts alone were looked at, as blocks, joints, curve and the pictures of the whole then raise, too.
        """
        return self._whole.analysis.stands

    @property
    def factor(self) -> float | None:
        """The load factor, of associated sliding: an upper bound. None where the structure does not stand, where supports move, where no
        factor is finite, or where parts alone were looked at."""
        found: float | None = self.summary.get("associated")
        return found

    @property
    def least(self) -> float | None:
        """The least factor found for sliding without dilation; None where none was searched for or found."""
        found = self.summary.get("least")
        return found["factor"] if found else None

    @cached_property
    def summary(self) -> dict[str, Any]:
        """The contents of limit.json."""
        from masonry_cd.limit.facts import facts

        return facts(self._case)

    @cached_property
    def blocks(self) -> DataFrame:
        """How each block moves in the mechanism: velocities over the largest one of any corner, angular ones per metre."""
        from reports.limit.tables import BLOCKS, block_rows

        rows = block_rows(self._whole.collapse, self._whole.assembly)
        return frame_of_rows([dict(zip(BLOCKS, row, strict=True)) for row in rows], "block")

    @cached_property
    def joints(self) -> DataFrame:
        """State of each joint in the mechanism, its forces [N] and where they act [m]."""
        from reports.limit.tables import JOINTS, joint_rows

        rows = joint_rows(self._whole.collapse, self._whole.assembly, self._whole.joints)
        return frame_of_rows([dict(zip(JOINTS, row, strict=True)) for row in rows], "joint")

    @property
    def mechanisms(self) -> DataFrame:
        """All mechanisms of the whole and of its parts, the governing one first, with the columns of mechanisms.csv: ``alpha0``,
        ``e_star``, ``a0_m_s2`` over the confidence factor and ``demand_m_s2``, ``d0_m``, ``displacement_m`` and its demand, ``ratio`` and
        ``verdict`` of the check that decides.

        Without a table ``[limit.check]`` the least a0* comes first, and there is no demand, ratio or verdict.
        """
        return _frame(self._case.mechanisms)

    @property
    def parts(self) -> DataFrame:
        """The governing mechanism of each part and push, as :attr:`mechanisms` has all."""
        from masonry_cd.limit.checked import least_of

        return _frame(least_of(self._case.mechanisms))

    @property
    def held(self) -> tuple[str, ...]:
        """Parts and pushes without a mechanism below five times the weight."""
        return tuple(f"{part['element']} {part['push']}" for part in self.summary["parts"] if part["held"])

    @property
    def check(self) -> DataFrame | None:
        """The code check of the mechanism that decides, value by value: symbol, value, unit, clause, meaning, formula, part of the
        check, and ``line``, the formula with its numbers; ``attrs["verdicts"]`` say what is satisfied, not satisfied or not decided.

        None without a table ``[limit.check]``, and where the structure does not stand.
        """
        check = self._case.check
        if check is None:
            return None
        numbers = check.numbers()
        return frame_of_rows(numbers["steps"], "symbol", verdicts=numbers["verdicts"])

    @property
    def verdict(self) -> dict[str, Any] | None:
        """The one verdict of the check: ``state``, its ``confidence`` and ``because``, ``ratio``, ``demand``, ``capacity``, ``margin``,
        ``mechanism``, ``search``, ``words``.

        None without a table ``[limit.check]``.
        """
        found: dict[str, Any] | None = self.summary["verdict"]
        return found

    @property
    def assumed(self) -> DataFrame:
        """The load factor with what is assumed assumed otherwise, one thing at a time: ``words``, ``factor``, ``key`` that states it,
        ``position`` of the first axle [m], ``counts`` where the verdict would take it; ``attrs["decides"]`` is the row that it takes,
        ``attrs["range"]`` the least and the largest factor of a bridge.
        """
        found = self.summary["assumed"]
        return frame_of_rows(found["rows"], decides=found["decides"], range=found["range"])

    @property
    def rating(self) -> DataFrame | None:
        """The load rating by vehicle: ``axles`` [N], load factor ``computed`` as the scene states it, the ``factor`` that counts and what
        ``decides`` it, ``ratio`` to the one asked, ``axle_load_n`` and ``axle_load_t`` borne with that, ``position`` of the first axle [m],
        what ``gives_way``; ``attrs["level"]`` is the heaviest level of CS 454 that is borne.

        None without a table ``[limit.rating]``.
        """
        found = self.summary["rating"]
        return None if found is None else frame_of_rows(found["rows"], "vehicle", level=found["level"], asked=found["asked"])

    @property
    def service(self) -> DataFrame | None:
        """The checks in service: ``check``, ``words``, the ``factor`` up to which it is met, ``asked``, ``position`` of the first axle [m],
        ``met``.

        None without a table ``[limit.service]``.
        """
        found = self.summary["service"]
        return None if found is None else frame_of_rows(found["rows"], "check", asked=found["asked"])

    @property
    def capacity(self) -> DataFrame | None:
        """The capacity curve, point by point: displacement of the control block [m], factor, what moves; ``attrs["end"]`` says why it ends.

        None without a table ``[limit.curve]``.
        """
        from masonry_cd.limit.curve import curve_rows

        curve = self._whole.curve
        if curve is None:
            return None
        return frame_of_rows(curve_rows(curve), "point", end=curve.end, control=self._whole.assembly.names[curve.control.block])

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
        if self._whole.curve is None:
            raise InputError("limit analysis", "no curve was followed: give the scene a table [limit.curve]")
        return self._picture("capacity.png", view)

    def write(self, folder: str | os.PathLike[str], *, force: bool = False) -> Page:
        """Write what ``masonry-cd limit`` writes into a folder, and return its page.

        Raises:
            InputError: a folder that holds such files already, without ``force``.
        """
        from masonry_cd.limit.files import EVERY, write

        self._folder = Path(folder)
        free_folder(self._folder, EVERY, force)
        write(self._case, self._folder)
        return Page(self._folder / "limit.html")

    def _picture(self, name: str, view: str) -> Image:
        require("a picture", "PIL")
        from PIL import Image as images

        from masonry_cd.limit.pictures import draw_whole

        keeper = TemporaryFolder()
        draw_whole(self._whole, self._case.scene.title, keeper.path, view)
        with images.open(keeper.path / name) as found:
            return found.copy()

    def __str__(self) -> str:
        from masonry_cd.limit.words import lines

        return "\n".join(lines(self._case))

    def __repr__(self) -> str:
        verdict = self.summary["on_the_whole"]
        found = verdict["grade"] if verdict else f"{len({part['element'] for part in self.summary['parts']})} parts"
        return f'<LimitAnalysis "{self._case.scene.title}": {found}>'


def _frame(rows: Sequence[Checked]) -> DataFrame:
    """Mechanisms as a table with the heads of the CSV file."""
    from reports.limit.tables import MECHANISMS

    return frame_of_rows([{head: each.row[name] for name, head in MECHANISMS.items()} for each in rows])


def limit_analysis(
    source: Scene | str | os.PathLike[str] | Mapping[str, Any],
    folder: str | os.PathLike[str] | None = None,
    *,
    macro_elements: bool = False,
    jobs: int | None = None,
    force: bool = False,
) -> LimitAnalysis:
    """The largest load that a scene bears at rest, and how it gives way, as ``masonry-cd limit`` finds them.

    Args:
        source: a scene, or what :func:`masonry_cd.scene` makes one of; its table ``limit`` says what is multiplied.
        folder: where tables, pictures and page are written; nowhere by default.
        macro_elements: look at each part of the structure with all other blocks held as well.
        jobs: processes for the parts; as many as there are cores by default.
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
    from masonry_cd.limit.case import WantedMechanisms

    return _analysed(source, WantedMechanisms(macro_elements, jobs=jobs), folder, force)


def macro_elements(
    source: Scene | str | os.PathLike[str] | Mapping[str, Any],
    folder: str | os.PathLike[str] | None = None,
    *,
    chosen: bool = False,
    jobs: int | None = None,
    force: bool = False,
) -> LimitAnalysis:
    """The parts of a structure one by one, each with all other blocks held, and no load on the whole.

    Args:
        source: a scene, or what :func:`masonry_cd.scene` makes one of; its table ``limit`` may choose or add parts, and check them.
        folder: where tables, pictures and page are written; nowhere by default.
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
    from masonry_cd.limit.case import WantedMechanisms

    return _analysed(source, WantedMechanisms(not chosen, whole=False, jobs=jobs), folder, force)


def _analysed(
    source: Scene | str | os.PathLike[str] | Mapping[str, Any], wanted: WantedMechanisms, folder: str | os.PathLike[str] | None, force: bool
) -> LimitAnalysis:
    """A scene analysed, and written into a folder where one is given."""
    from masonry_cd.limit.command import LimitFiles, limit

    asked = scene(source)  # which holds the files of its arrays
    where = None if folder is None else Path(folder)
    return LimitAnalysis(returned(limit(asked.checked, wanted, None if where is None else LimitFiles(where, force)), level=4), where)
