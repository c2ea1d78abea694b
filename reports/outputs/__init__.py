# SPDX-License-Identifier: GPL-3.0-or-later
"""Outputs in the folder of a run, by the settings of the scene's ``[report]``: a module here for each kind of output."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from masonry_cd.analysis.damage.grades import read_grades
from masonry_cd.analysis.damage.part_damage import PartDamage
from masonry_cd.analysis.deformed import Solids, frame_index
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.extras import require
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.mechanics.model.blocks import Block
from reports.damage import thresholds_of
from reports.drawing.scene import PictureScene
from reports.files import Job, output_of
from reports.maps.crack_map import crack_scene
from reports.maps.framing import MapStyle, framing, view_and_cut
from reports.maps.sequence import frames_at, slack
from reports.settings import OUTPUTS, Report

PAGE, PRINT = "report.html", "report.pdf"


def style_of(settings: Report) -> MapStyle:
    """How crack maps are drawn."""
    thresholds = thresholds_of(settings)
    beyond = 10.0 * max(thresholds.opened, thresholds.slid)  # models at another scale set their thresholds, and need not set this as well
    largest = settings.largest if settings.largest > beyond / 10.0 else beyond
    return MapStyle(settings.view, settings.scale, thresholds, largest, settings.cut, settings.thrust)


def check(settings: Report, blocks: Sequence[Block], end: float, spacing: float) -> None:
    """Check what only the reports know of, before a run takes its time, to an ``end`` [s] with frames apart by a ``spacing`` [s].

    Raises:
        InputError: names the key of ``[report]``.
    """
    check_needs(settings)
    read_grades(settings.grades)
    beyond = next((time for time in settings.times if time > end + slack(spacing)), None)
    if beyond is not None:
        raise InputError("report.times", f"{beyond:g} s lies beyond the run, which ends at {end:g} s")
    if settings.cut:
        try:
            view_and_cut(Solids.from_blocks(blocks), style_of(settings))
        except InputError as error:
            raise error.each(lambda fault: fault._replace(place=f"report.{fault.place}")) from None


def check_needs(settings: Report) -> None:
    """Check that the libraries of what the settings ask for are installed.

    Raises:
        InputError: names the key and the library.
    """
    for name in (*OUTPUTS, *settings.by_name):
        if getattr(settings, name, False):
            require(f"report.{name}", *output_of(name).needs, without=f" (or leave the output out: --set report.{name}=false)")


def check_again(settings: Report, results: Results) -> None:
    """Check the settings of reports that are redone on a run's results.

    Raises:
        InputError: names the setting.
    """
    read_grades(settings.grades)
    framing(results, [0], style_of(settings))


def parse_times(results: Results, text: str) -> list[float]:
    """Times given as ``1,2,3`` [s].

    Raises:
        InputError: something that is not a number, or a time outside the run.
    """
    times = []
    for word in text.split(","):
        try:
            times.append(float(word))
        except ValueError:
            raise InputError("--times", f'"{word.strip()}" is not a number; write times in seconds, such as 1,2.5,4') from None
    frames_at(results, times)
    return times


def frame_at(results: Results, time: float | None) -> int:
    """The frame next to a time [s]; the last for None."""
    return frame_index(results, -1) if time is None else frames_at(results, [time])[0]


def crack_scene_at(results: Results, settings: Report, time: float | None) -> PictureScene:
    """The crack map next to a time [s], the last for None.

    Raises:
        InputError: a time outside the run, or no such view or plane.
    """
    frame = frame_at(results, time)
    return crack_scene(results, frame, framing(results, [frame], style_of(settings)))


def write_page(results: Results, path: Path, settings: Report, summary: Summary, damage: PartDamage) -> None:
    """Write the page that shows a run."""
    from reports import page

    style = style_of(settings)
    page.write_page(results, path, summary, thresholds_of(settings), settings.scale, style.largest, damage)


def write_asked(results: Results, folder: Path, settings: Report, summary: Summary) -> Summary:
    """Write the outputs that a scene asks for, in addition to joints.csv; return the summary with what they add."""
    job = Job(results, folder, settings, summary)
    job.write()
    return job.summary
