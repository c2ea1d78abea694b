# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of a run and of a study: maps as images, plots as figures of matplotlib, the page; each shows itself in a notebook."""

from __future__ import annotations

import html
import io
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from masonry_cd.foundation.errors import InputError, parse_table, suggest
from masonry_cd.foundation.extras import require
from masonry_cd.interface.sealed import Sealed
from masonry_cd.io.results import Results
from reports.settings import Report

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from PIL.Image import Image

    from masonry_cd.analysis.damage.part_damage import PartDamage
    from masonry_cd.analysis.fragility.findings import Findings
    from masonry_cd.io.summary import Summary
    from reports.drawing.scene import PictureScene
    from reports.study.joint_maps import JointStudy

HEIGHT = 900  # of a page in a notebook [pixels]


class Plots(Sealed):
    """The pictures of ``run.plot``.

    Args:
        results: opens the result file.
        settings: ``[report]`` of the scene.
        summary: of the run.
        damage: of the run, by part.
    """

    def __init__(
        self,
        results: Callable[[], AbstractContextManager[Results]],
        settings: Report,
        summary: Callable[[], Summary],
        damage: Callable[[], PartDamage],
    ) -> None:
        self._results, self._settings, self._summary, self._damage = results, settings, summary, damage

    def crack_map(self, time: float | None = None, **keys: Any) -> Image:
        """The structure at the frame next to a time [s], the last by default: what is open and what has slid, by colour.

        Args:
            time: of the frame.
            keys: of ``[report]`` instead of the scene's: view, scale, cut, thrust, opened, slid, largest.

        Raises:
            InputError: an unknown key, a time outside the run, or a cut outside the structure.
        """
        from reports.outputs import crack_scene_at

        settings = self._changed(keys)
        with self._results() as found:
            return image_of(crack_scene_at(found, settings, time))

    def stress_map(self, time: float | None = None, **keys: Any) -> Image:
        """The structure with its blocks coloured by their compression: the largest of the run, or that at the frame next to a time [s].

        Args:
            time: of the frame; None: of the whole run, block by block.
            keys: of ``[report]`` instead of the scene's: view, scale, cut.

        Raises:
            InputError: an unknown key, a time outside the run, a cut outside the structure, or a run that kept no stress.
        """
        from reports.maps.stress_map import stress_scene
        from reports.outputs import frame_at, style_of

        style = style_of(self._changed(keys))
        with self._results() as found:
            return image_of(stress_scene(found, None if time is None else frame_at(found, time), style))

    def energy(self) -> Figure:
        """Draw the energy put in, where it went, and the balance, over time."""
        from reports.outputs.energy import energy_figure

        with self._results() as found:
            return shown(energy_figure(found))

    def force_displacement(self, measured: Path | str | None = None) -> Figure:
        """The pushes of the run: force against displacement.

        Args:
            measured: a CSV file with the curve of a test, displacement [m] and force [N], to be drawn with them.

        Raises:
            InputError: the run has no push by displacement, or a file that is not such a curve.
        """
        from masonry_cd.analysis.pushover import require_pushes
        from reports.laboratory import push_figure, read_measured

        with self._results() as found:
            curves = require_pushes(found)
            return shown(push_figure(curves, [] if measured is None else read_measured(Path(measured)), found.title))

    def gauges(self) -> Figure:
        """The histories of the points, joints, cracks and supports that the scene names under [output].

        Raises:
            InputError: it names none.
        """
        from reports.laboratory import gauges_figure, histories_of

        with self._results() as found:
            return shown(gauges_figure(histories_of(found), found.title))

    def history(self, *blocks: str, axis: str = "") -> Figure:
        """Displacement of some blocks relative to the base over time, the highest block by default, and the velocity of the base.

        Args:
            blocks: their names.
            axis: x, y or z; by default the one along which they move most.

        Raises:
            InputError: no block has a name, or no such axis.
        """
        from reports.drawing.history_figure import history_figure

        with self._results() as found:
            return shown(history_figure(found, blocks, axis))

    def page(self, path: Path | str | None = None) -> Page:
        """The page of the run, which needs no network.

        Args:
            path: where it is written; report.html in the folder of the run by default.

        Raises:
            InputError: a path that cannot be written.
        """
        from reports.outputs import PAGE, write_page

        with self._results() as found:
            place = found.path.with_name(PAGE) if path is None else Path(path)
            write_page(found, place, self._settings, self._summary(), self._damage())
        return Page(place)

    def _changed(self, keys: dict[str, Any]) -> Report:
        """The settings with other values of some keys."""
        return parse_table(Report, self._settings.model_dump(exclude_unset=True) | keys, "report")


class Page:
    """An HTML file; a notebook shows it, and :meth:`open` does so in the browser."""

    def __init__(self, path: Path) -> None:
        self.path = path
        """Where it lies."""

    def open(self) -> bool:
        """Open it in the browser; False where there is none."""
        import webbrowser

        return webbrowser.open(self.path.absolute().as_uri())

    def __repr__(self) -> str:
        return f"<Page {self.path}>"

    def _repr_html_(self) -> str:
        inside = html.escape(self.path.read_text(encoding="utf-8"))
        return f'<iframe srcdoc="{inside}" style="width:100%;height:{HEIGHT}px;border:1px solid #ccc"></iframe>'


def shown(figure: Any) -> Any:
    """A figure that a notebook shows, also one that has not loaded pyplot."""

    def png() -> bytes:
        """The figure as a PNG."""
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png")
        return buffer.getvalue()

    figure._repr_png_ = png
    return figure


SHARES = ("opened", "slid", "lost")


class StudyPlots(Sealed):
    """The pictures of ``study.plot``. One that the design or the runs do not allow is refused, with the names of those that there are.

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
            measured: a CSV file with the curve of a test, displacement [m] and force [N], to be drawn with them.

        Raises:
            InputError: no run was kept, one has no push by displacement, or a file that is not such a curve.
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


def image_of(scene: PictureScene) -> Image:
    """A scene that is drawn, as an image that a notebook shows."""
    require("a picture", "PIL")
    from PIL import Image as images

    from reports.drawing.figure import Sheet

    return images.fromarray(Sheet.drawn(scene).pixels())


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
