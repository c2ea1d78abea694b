# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of a study, drawn from its runs when they are asked for; each an image that a notebook shows."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from masonry_cd.analysis.fragility.findings import Findings
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.extras import require
from masonry_cd.interface.plots import Page, shown
from masonry_cd.interface.sealed import Sealed
from masonry_cd.io.results import Results
from reports.study.joint_maps import JointStudy

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from PIL.Image import Image

SHARES = ("opened", "slid", "lost")


class StudyPlots(Sealed):
    """What ``study.plot`` offers. A picture that the design or the runs do not allow is refused, with the names of those that there are.

    Args:
        found: what the runs say.
        joints: what they did to the joints; None where that is not known.
    """

    def __init__(self, found: Findings, joints: Callable[[], JointStudy | None]) -> None:
        self._found, self._study, self._joints = found, found.study, joints

    def fragility(self) -> Image:
        """The probability that each limit state is exceeded, over the intensity, with its band and what was counted."""
        return self._diagram("fragility")

    def stripes(self) -> Image:
        """Every run above its level, with the 16, 50 and 84 % of each level."""
        return self._diagram("stripes")

    def ida(self) -> Image:
        """A line per record of an incremental dynamic analysis, with its quantiles."""
        return self._diagram("ida")

    def cloud(self) -> Image:
        """A point per run over its intensity, with the regression."""
        return self._diagram("cloud")

    def spread(self) -> Image:
        """The share of the runs up to a value, where no intensity varies."""
        return self._diagram("spread")

    def tornado(self) -> Image:
        """Which of what varied goes with the damage."""
        return self._diagram("tornado")

    def force_displacement(self, measured: Path | str | None = None) -> Figure:
        """The first push of every run whose folder was kept, laid over each other, with the force over the displacement.

        Args:
            measured: a CSV file with the curve of a test, displacement [m] and force [N], to be drawn beside them.

        Raises:
            InputError: no run was kept, one has no push by displacement, or a file that is no such curve.
        """
        from masonry_cd.analysis.pushover import require_pushes
        from reports.laboratory import curves_figure, read_measured

        curves = []
        for name in self._study.text("run"):
            file = self._study.folder / "runs" / name / "result.h5"
            if file.is_file():
                with Results.open(file) as found:
                    curves.append((name, *require_pushes(found)[0].means[:2]))
        if not curves:
            raise InputError("force_displacement", 'no run was kept; a study with run = {keep = "all"} keeps the folders of its runs')
        return shown(curves_figure(curves, [] if measured is None else read_measured(Path(measured))))

    def probability(self, of: str = "opened", level: float | None = None) -> Image:
        """The structure with each joint coloured by the share of the runs in which it opened, slid, or was lost.

        Args:
            of: opened, slid or lost.
            level: of the intensity, for openings; all runs by default.

        Raises:
            InputError: no such map.
        """
        if of not in SHARES:
            raise InputError("probability", f'"{of}" is none{suggest(of, SHARES)}; one of {", ".join(SHARES)}')
        return self._map(f"probability_{of}" + (f"_at_{level:g}" if level is not None else ""))

    def median_opening(self) -> Image:
        """The structure with each joint coloured by the largest opening that half of the runs exceed."""
        return self._map("median_opening")

    def page(self) -> Page:
        """study.html with all of it, which needs no network; tables and pictures in the folder are written again with it."""
        from reports.study.outputs import PAGE, write_study

        write_study(self._study.folder)
        return Page(self._study.folder / PAGE)

    def _diagram(self, name: str) -> Image:
        """One of the diagrams."""
        from reports.study.outputs import DIAGRAMS, diagrams

        known = diagrams(self._found)
        if f"{name}.png" not in known:
            raise InputError(name, f"not of this study; it has {_names(known)}")
        return drawn(lambda path: DIAGRAMS[f"{name}.png"].draw(self._found, path))

    def _map(self, name: str) -> Image:
        """One of the maps of the joints."""
        found = self._joints()
        known = found.maps(every_level=True) if found is not None else {}
        if found is None or f"{name}.png" not in known:
            raise InputError(name, f"no joint of this study shows it; there are {_names(known)}")
        return drawn(lambda path: found.draw([replace(known[f"{name}.png"], path=path)]))


def _names(known: Iterable[str]) -> str:
    """Names of pictures, for a message."""
    return ", ".join(name.removesuffix(".png") for name in known) or "none"


def drawn(draw: Callable[[Path], object]) -> Image:
    """A picture that is drawn into a file, which then goes."""
    require("a picture", "PIL")
    from PIL import Image as images

    with TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        draw(path)
        with images.open(path) as picture:
            picture.load()
            return picture.copy()
