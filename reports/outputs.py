"""What the folder of a run gets from the reports, by the settings of the scene's ``[report]``."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.damage.grades import read_grades
from masonry_cd.analysis.damage.part_damage import PartDamage, part_damage
from masonry_cd.analysis.deformed import Solids
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.extras import require
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.blocks import Block
from reports.damage.joint_files import damage_settings, thresholds_of
from reports.damage.part_files import in_short, write_part_damage
from reports.extra import extra_report
from reports.maps.crack_map import sheet_of
from reports.maps.framing import MapStyle, framing, view_and_cut
from reports.maps.sequence import animation, crack_maps, frames_at, slack, times_within
from reports.settings import Report

ANIMATION = "crack_map.gif"
PAGE = "report.html"
PRINT = "report.pdf"


def style_of(settings: Report) -> MapStyle:
    """How crack maps are drawn."""
    thresholds = thresholds_of(settings)
    beyond = 10.0 * max(thresholds.opened, thresholds.slid)  # models at another scale set their thresholds, and need not set this as well
    largest = settings.largest if settings.largest > beyond / 10.0 else beyond
    return MapStyle(settings.view, settings.scale, thresholds, largest, settings.cut, settings.thrust)


def check(settings: Report, blocks: Sequence[Block], end: float, spacing: float) -> None:
    """Check what only the reports know of, before a run takes its time.

    Args:
        settings: of the scene.
        blocks: of its structure.
        end: of the run [s].
        spacing: of its frames [s].

    Raises:
        InputError: names the key of ``[report]``.
    """
    if settings.draws:
        require("report: a picture", "pyvista", "matplotlib", "PIL", without=" (or go without: report.crack_map = false)")
    if settings.html:
        require("report.html: the page", "matplotlib")
    read_grades(settings.grades)
    beyond = next((time for time in settings.times if time > end + slack(spacing)), None)
    if beyond is not None:
        raise InputError(f"report.times: {beyond:g} s lies beyond the run, which ends at {end:g} s")
    if settings.cut:
        try:
            view_and_cut(Solids.from_blocks(blocks), style_of(settings))
        except InputError as error:
            raise InputError(f"report.{error}") from None


def check_again(settings: Report, results: Results) -> None:
    """Check the settings of reports that are redone on a run's results.

    Raises:
        InputError: names the setting.
    """
    read_grades(settings.grades)
    framing(results, [0], style_of(settings))


def damage_of(results: Results, settings: Report, frames: np.ndarray | None = None) -> PartDamage:
    """The damage by part, its history at some frames, the last among them, or at all."""
    return part_damage(results, damage_settings(settings), frames)


def parse_times(results: Results, text: str) -> list[float]:
    """Times given as ``1,2,3`` [s].

    Raises:
        InputError: something that is no number, or a time outside the run.
    """
    times = []
    for word in text.split(","):
        try:
            times.append(float(word))
        except ValueError:
            raise InputError(f'--times: "{word.strip()}" is no number; write seconds, 1,2.5,4') from None
    frames_at(results, times)
    return times


def draw_crack_map(results: Results, path: Path, settings: Report, frame: int = -1) -> None:
    """Draw one crack map."""
    frame = frame % results.frames
    sheet_of(results, frame, framing(results, [frame], style_of(settings))).save(path)


def draw_vector(results: Results, folder: Path, settings: Report, frame: int = -1) -> list[Path]:
    """Draw the crack map as polygons, in SVG and PDF."""
    from reports.maps.crack_map import vector_maps

    return vector_maps(results, folder, style_of(settings), frame)


def frame_at(results: Results, time: float | None) -> int:
    """The frame next to a time [s]; the last for None."""
    return -1 if time is None else frames_at(results, [time])[0]


def draw_times(results: Results, folder: Path, settings: Report, times: Sequence[float]) -> list[Path]:
    """Draw crack maps at times [s], all in one framing."""
    return crack_maps(results, folder, times, style_of(settings))


def draw_animation(results: Results, path: Path, settings: Report, progress: Callable[[int], None] | None = None) -> int:
    """Draw the animation; return its number of frames."""
    return animation(results, path, style_of(settings), progress=progress)


def write_stress(
    results: Results, folder: Path, settings: Report, time: float | None = None, drawn: bool = True
) -> tuple[list[Path], dict[str, Any]]:
    """Write stress.csv, joint_stress.csv and, where it is to be ``drawn``, the stress map, of the whole run or at a time [s].

    Returns:
        the files, and the summary's share.

    Raises:
        InputError: the run kept no stress.
    """
    from masonry_cd.analysis.stress.peaks import stress_peaks
    from masonry_cd.analysis.stress.summary import stress_summary
    from reports.stress.files import write_stress

    peaks = stress_peaks(results, settings.opened)
    written = write_stress(results, peaks, folder)
    found = stress_summary(results, peaks)
    if drawn and found:
        written += draw_stress_map(results, folder, settings, time)
    return written, found


def draw_stress_map(results: Results, folder: Path, settings: Report, time: float | None = None) -> list[Path]:
    """Draw the stress map, of the whole run or at a time [s], as polygons as well where the settings ask for them; return the files."""
    from reports.maps import stress_map

    frame, style, path = None if time is None else frame_at(results, time), style_of(settings), folder / stress_map.FILE
    stress_map.stress_sheet(results, frame, style).save(path)
    return [path, *(stress_map.vector_stress_maps(results, folder, frame, style) if settings.vector else [])]


def write_extra(results: Results, folder: Path, names: Sequence[str]) -> list[Path]:
    """Write further reports by their names in :func:`reports.extra.extra_report`; return the files."""
    written: list[Path] = []
    for name in dict.fromkeys(names):
        report = extra_report(name)
        report.write(results, folder)
        written += [folder / file for file in report.files if (folder / file).exists()]
    return written


def write_page(results: Results, path: Path, settings: Report, summary: Mapping[str, Any], damage: PartDamage) -> None:
    """Write the page that shows a run."""
    from reports import page

    style = style_of(settings)
    page.write_page(results, path, summary, thresholds_of(settings), settings.scale, style.largest, damage)


def write_pdf(page: Path, path: Path) -> None:
    """Print the page."""
    from reports.page import pdf

    pdf.write_pdf(page, path)


def write_asked(results: Results, folder: Path, settings: Report, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Write the tables, pictures and the page that a scene asks for, beside joints.csv; return what they add to the summary."""
    more: dict[str, Any] = {}
    if settings.damage or settings.html:
        damage = damage_of(results, settings)
        if settings.damage:
            write_part_damage(damage, folder)
            more["parts"] = in_short(damage.parts)
        if settings.html:
            write_page(results, folder / PAGE, settings, summary, damage)
    if results.has_stress:
        more["stress"] = write_stress(results, folder, settings)[1]
    if settings.crack_map:
        draw_crack_map(results, folder / "crack_map.png", settings)
    if settings.vector:
        draw_vector(results, folder, settings)
    times, beyond = times_within(results, settings.times)
    if times:
        draw_times(results, folder, settings, times)
    if beyond:  # of a run that left out rests or was interrupted, or the settings had been refused
        at = ", ".join(f"{time:g}" for time in beyond)
        why = "which was interrupted" if summary.get("stopped") else "whose rests were cut short"
        line = f"report.times: no map at {at} s: the run, {why}, ends at {results.time[-1]:g} s"
        more["warnings"] = [*summary.get("warnings", ()), line]
    if settings.animation and results.frames > 1:
        draw_animation(results, folder / ANIMATION, settings)
    write_extra(results, folder, settings.extra)
    return more
