# SPDX-License-Identifier: GPL-3.0-or-later
"""Crack maps in a row: one framing for all, and an animation whose colours stay those of the classes."""

from __future__ import annotations

import platform
import resource
from pathlib import Path

import numpy as np
import pytest
from hostile import refused_at
from made_run import at_rest, box, shifted, turned, write_run
from pictures import COLUMN, opening_scale, pixels

from masonry_cd.foundation.freed_memory import keep_freed_memory
from masonry_cd.io.results import Results
from reports.drawing.parts import Surface, Window, view_named
from reports.drawing.render import Canvas
from reports.drawing.scene import Scene
from reports.maps.framing import MapStyle, framing
from reports.maps.sequence import animation, crack_maps, frames_at


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A column whose top opens by 10 mm, slides by 0.2 m, and comes back to 10 mm, five frames 0.1 s apart."""
    rest = at_rest(COLUMN)
    hinge = turned(rest, 3, (0.5, 0.0, 2.0), np.degrees(0.0101))
    return write_run(tmp_path / "run.h5", COLUMN, [rest, hinge, shifted(rest, 3, (0.2, 0, 0)), hinge, hinge])


def test_times_find_the_frames_next_to_them(run: Path) -> None:
    with Results.open(run) as results:
        assert frames_at(results, [0.0, 0.12, 0.4, 0.44]) == [0, 1, 4, 4]
        for wrong in (-1.0, 0.6, float("nan")):
            with refused_at("time"):
                frames_at(results, [wrong])


def test_maps_of_a_sequence_are_alike_in_all_but_the_damage(run: Path, tmp_path: Path) -> None:
    """Alone, the frame of the hinge would be amplified; in a row with a slip of 0.2 m, all are in true shape and one window."""
    with Results.open(run) as results:
        alone, row = framing(results, [1], MapStyle()), framing(results, [0, 1, 2], MapStyle())
        assert (alone.factor, row.factor) == (5.0, 1.0)
        paths = crack_maps(results, tmp_path, [0.0, 0.1, 0.2, 0.21])
    assert [path.name for path in paths] == ["crack_map_0s.png", "crack_map_0.1s.png", "crack_map_0.2s.png"]
    first, second, third = (pixels(path) for path in paths)
    assert first.shape == second.shape == third.shape
    below = slice(first.shape[0] * 3 // 4, None)  # the foot of the column, which none of them moves
    left = slice(0, first.shape[1] * 2 // 3)
    np.testing.assert_array_equal(first[below, left], second[below, left])
    np.testing.assert_array_equal(first[below, left], third[below, left])
    assert (first != second).any()


def test_an_animation_plays_in_the_time_of_the_run(run: Path, tmp_path: Path) -> None:
    from PIL import Image

    with Results.open(run) as results:
        assert animation(results, tmp_path / "run.gif") == 5
        assert animation(results, tmp_path / "short.gif", most=3) == 3
    with Image.open(tmp_path / "run.gif") as film:
        shown = []
        for k in range(film.n_frames):
            film.seek(k)
            shown.append(film.info["duration"])
            if k == 1:
                frame = np.asarray(film.convert("RGB"))
        assert film.info["loop"] == 0
    assert shown[:-1] == [100] * 4 or sum(shown[:-1]) == 400  # equal frames may be joined
    ten = opening_scale().colours[opening_scale().bounds.index(0.01)]
    assert (frame == ten).all(axis=2).sum() > 100  # exactly, in spite of the palette


def test_a_single_frame_makes_no_animation(tmp_path: Path) -> None:
    blocks = [box("base", (-1, -1, -1), (1, 1, 0), "base", fixed=True), box("stone", (-0.5, -0.5, 0), (0.5, 0.5, 1))]
    with (
        Results.open(write_run(tmp_path / "run.h5", blocks, [at_rest(blocks)])) as results,
        refused_at("animation"),
    ):
        animation(results, tmp_path / "run.gif")


def test_a_canvas_draws_each_picture_anew_and_once(monkeypatch):
    """Layers are added without drawing: each costs a pass of OpenGL otherwise."""
    import pyvista

    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]])
    drawn = []
    render = pyvista.Plotter.render
    monkeypatch.setattr(pyvista.Plotter, "render", lambda self: (drawn.append(1), render(self))[1])
    with Canvas(view_named("front"), (40, 40), samples=1) as canvas:
        for number, colour in enumerate(([255, 0, 0], [0, 255, 0], [0, 0, 255])):
            before = len(drawn)
            layers = [
                Surface(square + [0, k, 0], np.arange(4), np.array([0, 4]), np.array([colour], np.uint8), lit=False) for k in range(3)
            ]
            image = canvas.draw(Scene(view_named("front"), Window(0.0, 1.0, 0.0, 1.0), layers))
            assert image[20, 20].tolist() == colour
            assert number == 0 or len(drawn) == before + 1  # the first picture opens OpenGL as well


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another allocator")
def test_memory_of_pictures_goes_back_to_the_system() -> None:
    """Of the 180 MB that a picture of 4.8 million samples takes, a process that keeps what its steps free has hardly any afterwards."""

    def draw(pixels: tuple[int, int]) -> float:
        """Resident memory after a picture [MB]."""
        square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]])
        layer = Surface(square, np.arange(4), np.array([0, 4]), np.array([[255, 0, 0]], np.uint8), lit=False)
        with Canvas(view_named("front"), pixels) as canvas:
            canvas.draw(Scene(view_named("front"), Window(0.0, 1.0, 0.0, 1.0), [layer]))
        return float(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * resource.getpagesize() / 1e6

    keep_freed_memory()
    first = draw((10, 10))  # opens OpenGL
    assert draw((1200, 1000)) - first < 60.0
