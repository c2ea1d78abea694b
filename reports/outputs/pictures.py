# SPDX-License-Identifier: GPL-3.0-or-later
"""Crack maps, and stress with its map."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from masonry_cd.io.summary import Summary
from reports.drawing.figure import Sheet, save_polygons
from reports.files import Job, Output
from reports.maps.sequence import draw_animation, draw_crack_maps, times_within
from reports.outputs import crack_scene_at, frame_at, style_of


def _write_crack_map(job: Job) -> Iterable[Path]:
    """Write the map of a frame."""
    Sheet.drawn(crack_scene_at(job.results, job.settings, job.time)).save(job.folder / "crack_map.png")
    return [job.folder / "crack_map.png"]


def _write_vector(job: Job) -> Iterable[Path]:
    """Write that map as polygons."""
    return save_polygons(crack_scene_at(job.results, job.settings, job.time), job.folder, "crack_map")


def _write_times(job: Job) -> Iterable[Path]:
    """Write maps at some times; warn of times beyond the end of a run that skipped rests or was interrupted."""
    times, beyond = times_within(job.results, job.settings.times)
    if beyond:
        at = ", ".join(f"{time:g}" for time in beyond)
        why = "which was interrupted" if job.summary.stopped else "whose quiet times were skipped"
        line = f"report.times: no map at {at} s: the run, {why}, ends at {job.results.time[-1]:g} s"
        job.summary |= Summary(warnings=(*job.summary.warnings, line))
    return draw_crack_maps(job.results, job.folder, times, style_of(job.settings)) if times else []


def _write_animation(job: Job) -> Iterable[Path]:
    """Write the animation of the run."""
    draw_animation(job.results, job.folder / "crack_map.gif", style_of(job.settings))
    return [job.folder / "crack_map.gif"]


def _write_stress(job: Job) -> Iterable[Path]:
    """Write the tables, and the numbers of the summary.

    Raises:
        InputError: the run kept no stress.
    """
    from masonry_cd.analysis.stress.peaks import stress_peaks
    from masonry_cd.analysis.stress.summary import stress_summary
    from reports.stress import write_stress

    peaks = stress_peaks(job.results, job.settings.opened)
    found = stress_summary(job.results, peaks)
    job.summary |= Summary() if found is None else Summary(stress=found)
    return write_stress(job.results, peaks, job.folder)


def _write_stress_map(job: Job) -> Iterable[Path]:
    """Write the map of a frame where a time is given, otherwise of the whole run."""
    from reports.maps.stress_map import stress_scene

    if job.summary.stress is None:
        return []
    frame, path = None if job.time is None else frame_at(job.results, job.time), job.folder / "stress_map.png"
    scene = stress_scene(job.results, frame, style_of(job.settings))
    Sheet.drawn(scene).save(path)
    return [path, *(save_polygons(scene, job.folder, "stress_map") if job.settings.vector else [])]


PICTURES = ("pyvista", "matplotlib", "PIL")
OUTPUTS = {
    "stress": Output(
        {
            "stress.csv": "every block: largest mean compression and tension with their times, final stress, share of the strength",
            "joint_stress.csv": "every joint: largest compression at its edge, largest normal force",
            "element_stress.csv": "every element of meshed blocks: largest compression and tension with their times, final stress",
        },
        _write_stress,
        lambda job: job.results.has_stress,
        20,
    ),
    "stress_map": Output(
        {
            "stress_map.png": "the structure, its blocks coloured by their largest compression",
            "stress_map.svg": "that map as polygons",
            "stress_map.pdf": "that map as polygons",
        },
        _write_stress_map,
        lambda job: job.results.has_stress,
        21,
    ),
    "crack_map": Output(
        {"crack_map.png": "the structure at the end, its joints coloured by opening and sliding"},
        _write_crack_map,
        place=30,
        needs=PICTURES,
    ),
    "vector": Output(
        {"crack_map.svg": "that map as polygons", "crack_map.pdf": "that map as polygons"}, _write_vector, place=31, needs=PICTURES
    ),
    "times": Output({}, _write_times, place=32, needs=PICTURES),
    "animation": Output(
        {"crack_map.gif": "that map through the run"},
        _write_animation,
        lambda job: job.settings.animation and job.results.frames > 1,
        33,
        needs=PICTURES,
    ),
}
