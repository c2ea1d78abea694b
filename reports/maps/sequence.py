# SPDX-License-Identifier: GPL-3.0-or-later
"""Crack maps in a row: PNGs at given times, and a GIF of a whole run.

All maps of a row share view, amplification, window and colour classes, so that only the damage changes from one to the next.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.extras import require
from masonry_cd.io.results import Results
from reports.drawing.figure import Sheet, layout_of
from reports.drawing.render import Canvas
from reports.maps.crack_map import crack_scene
from reports.maps.framing import Framing, MapStyle, framing

MOST_FRAMES = 60  # of an animation
WIDTH = 900  # of an animation [pixels]
REST = 1500  # how long its last frame stays [ms]


def frames_at(results: Results, times: Sequence[float]) -> list[int]:
    """The frames next to some times [s], in their order.

    Raises:
        InputError: a time outside the run, or no number.
    """
    have = results.time
    margin = _margin(have)
    for time in times:
        if not (np.isfinite(time) and have[0] - margin <= time <= have[-1] + margin):
            raise InputError("time", f"{time:g} s lies outside the run, which has frames from {have[0]:g} to {have[-1]:g} s")
    return [int(np.argmin(np.abs(have - time))) for time in times]


def slack(spacing: float) -> float:
    """How far before the first and after the last frame a time may lie [s], for frames apart by ``spacing`` [s]."""
    return 0.51 * spacing + 1e-9


def times_within(results: Results, times: Sequence[float]) -> tuple[list[float], list[float]]:
    """Times [s] that a run has reached, and those beyond its end."""
    end = float(results.time[-1]) + _margin(results.time)
    return [time for time in times if time <= end], [time for time in times if time > end]


def _margin(times: np.ndarray) -> float:
    """The slack of frames at some times (F,) [s]."""
    return slack(float(np.diff(times).max(initial=0.0)))


def draw_crack_maps(results: Results, folder: Path, times: Sequence[float], style: MapStyle | None = None) -> list[Path]:
    """Draw the crack maps next to some times [s] into ``crack_map_1.25s.png`` and so on; return the files.

    Raises:
        InputError: a time outside the run, or what :func:`reports.maps.framing.framing` says.
    """
    frames = list(dict.fromkeys(frames_at(results, times)))
    framed = framing(results, frames, style or MapStyle())
    paths = []
    for frame in frames:
        paths.append(folder / f"crack_map_{results.time[frame]:.6g}s.png")
        Sheet.drawn(crack_scene(results, frame, framed)).save(paths[-1])
    return paths


def draw_animation(
    results: Results, path: Path, style: MapStyle | None = None, most: int = MOST_FRAMES, progress: Callable[[int], None] | None = None
) -> int:
    """Draw a GIF of the run, in its own time where it has no more than ``most`` frames a viewer can follow; return their number.

    Raises:
        InputError: a run of a single frame, a path that cannot be written, or what :func:`reports.maps.framing.framing` says.
    """
    require("a picture", "PIL")
    from PIL import Image

    if results.frames < 2:
        raise InputError("animation", "the result has a single frame")
    frames = np.unique(np.linspace(0, results.frames - 1, min(results.frames, most)).round().astype(int)).tolist()
    framed = framing(results, frames, style or MapStyle())
    images: list[Any] = []
    scenes = (crack_scene(results, frame, framed) for frame in frames)
    first = next(scenes)
    still = Sheet.around(replace(first, title="", facts=""), [panel for panel in first.key if not panel.signs]).pixels()
    with Canvas(framed.view, layout_of(first).pixels, samples=1) as canvas:
        for k, scene in enumerate(chain([first], scenes)):
            pixels = Sheet.drawn_on(canvas, scene, [panel for panel in scene.key if panel.signs]).pixels(still)
            size = (WIDTH, round(WIDTH * pixels.shape[0] / pixels.shape[1]))
            images.append(Image.fromarray(pixels).resize(size, Image.Resampling.BOX if size[0] * 2 == pixels.shape[1] else None))
            if progress is not None:
                progress(k + 1)
    palette = _palette(images, framed)
    flat = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    shown = [max(20, round(1000 * step)) for step in np.diff(results.time[frames])] + [REST]
    try:
        with replacing(path) as part:
            flat[0].save(part, save_all=True, append_images=flat[1:], duration=shown, loop=0, optimize=False)
    except OSError as error:
        raise InputError(path, f"cannot be written: {error.strerror}") from None
    return len(images)


def _palette(images: Sequence[Any], framed: Framing) -> Any:
    """One palette for all frames, or their colours would flicker: those of the classes exactly, the others from a few of the frames."""
    from PIL import Image

    exact = np.concatenate([[[255, 255, 255]], *(scale.colours for scale in framed.scales)]).astype(np.uint8)
    picked = [images[k] for k in sorted({0, len(images) // 2, len(images) - 1})]
    width, height = picked[0].size
    joined = Image.new("RGB", (width, height * len(picked)))
    for k, image in enumerate(picked):
        joined.paste(image, (0, k * height))
    free = 256 - len(exact)
    others = (joined.quantize(colors=free, method=Image.Quantize.MEDIANCUT).getpalette() or [])[: 3 * free]
    palette = Image.new("P", (1, 1))
    palette.putpalette(exact.ravel().tolist() + others)
    return palette
