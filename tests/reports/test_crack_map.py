# SPDX-License-Identifier: GPL-3.0-or-later
"""Crack maps, alone and in a row: what they show is counted in their pixels, and what stands around the model is kept apart."""

from __future__ import annotations

import ctypes
import os
import platform
import resource
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hostile import refused_at
from made_run import at_rest, box, shifted, turned, write_run
from pictures import BASE, COLUMN, crack_map, main_colours, model_area, opening_scale, pixels, shares

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.deformed import Pose, Solids
from masonry_cd.foundation.freed_memory import keep_freed_memory
from masonry_cd.foundation.quantities import nice
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.blocks import Block
from reports.drawing import palette
from reports.drawing.figure import Sheet
from reports.drawing.parts import Scale, Surface, Window, rgb, view_named
from reports.drawing.render import Canvas
from reports.drawing.scene import PictureScene
from reports.drawing.solids import auto_view, families_of, structure_scene, within_sight
from reports.maps import framing
from reports.maps.sequence import draw_animation, draw_crack_maps, frames_at


def drawn(path: Path, blocks: list[Block], states: list, **options: object) -> np.ndarray:
    """The crack map of a made run."""
    with Results.open(write_run(path.with_suffix(".h5"), blocks, states)) as results:
        crack_map(results, path, style=framing.MapStyle(**options))  # type: ignore[arg-type]
    return pixels(path)


def sliding_scale() -> Scale:
    return Scale(1e-4, 0.05, palette.SLIDING)


def test_opened_and_slid_joints_are_distinguished(tmp_path: Path) -> None:
    """A hinge open by 10 mm and a joint slid by 3 mm: each class shows its own colour in the model, and no other class does."""
    rest = at_rest(COLUMN)
    hinge = turned(rest, 3, (0.5, 0.0, 2.0), np.degrees(0.0101))
    opened = model_area(drawn(tmp_path / "opened.png", COLUMN, [rest, hinge]), 0.3)
    slid = model_area(drawn(tmp_path / "slid.png", COLUMN, [rest, shifted(rest, [2, 3], (0.003, 0, 0))]), 0.3)
    still = model_area(drawn(tmp_path / "still.png", COLUMN, [rest, rest]), 0.3)
    opening, sliding = opening_scale(), sliding_scale()
    ten, three = opening.bounds.index(0.01), sliding.bounds.index(0.002)
    assert np.flatnonzero(shares(opened, opening.colours) > 50).tolist() == [ten]
    assert np.flatnonzero(shares(slid, sliding.colours) > 50).tolist() == [three]
    assert shares(opened, sliding.colours).max() < 20
    assert shares(slid, opening.colours).max() < 20
    assert max(shares(still, opening.colours).max(), shares(still, sliding.colours).max()) < 20


def test_parted_faces_and_fallen_blocks_show(tmp_path: Path) -> None:
    rest = at_rest(COLUMN)
    image = drawn(tmp_path / "fallen.png", COLUMN, [rest, shifted(rest, 3, (1.3, 0, -2.0))])
    area = image[120 : image.shape[0] - 240]
    fallen = np.abs(area.astype(int) - (255 * rgb(palette.FALLEN))).max(axis=2) < 14
    assert fallen.sum() > 10_000
    assert shares(area, (255 * rgb(palette.PARTED)).astype(np.uint8)[None])[0] > 200


def test_without_joints_the_key_is_silent_on_them(tmp_path: Path) -> None:
    """A ball on a floor has none; a column of blocks has the colours of opening and sliding in its key."""
    ball = [COLUMN[0], Block.sphere("ball", np.array([0.0, 0.0, 0.5]), 0.5, 2000.0)]
    scales = [scale.colours[2:] for scale in (opening_scale(), sliding_scale())]
    with_joints, without = (drawn(tmp_path / f"{len(blocks)}.png", blocks, [at_rest(blocks)] * 2) for blocks in (COLUMN, ball))
    assert min(shares(with_joints, colours).min() for colours in scales) > 20
    assert max(shares(without, colours).max() for colours in scales) < 20


def test_the_same_run_gives_the_same_picture(tmp_path: Path) -> None:
    rest = at_rest(COLUMN)
    states = [rest, turned(rest, 3, (0.5, 0.0, 2.0), 0.5)]
    assert (drawn(tmp_path / "a.png", COLUMN, states) == drawn(tmp_path / "b.png", COLUMN, states)).all()


def test_small_displacements_are_amplified_and_large_ones_are_not(tmp_path: Path) -> None:
    rest = at_rest(COLUMN)
    factors = []
    for shift in (0.0, 1e-12, 0.002, 0.3, 2.5):
        with Results.open(write_run(tmp_path / "run.h5", COLUMN, [rest, shifted(rest, 3, (shift, 0, 0))])) as results:
            solids = Solids.from_blocks(results.blocks)
            largest = framing.largest_displacement(Pose.of(results, solids), solids)
            factors.append(framing.amplification(largest, shift > 1, 3.0))
    assert factors == [1.0, 1.0, 20.0, 1.0, 1.0]


def test_a_block_flung_far_does_not_make_the_structure_a_dot() -> None:
    rest = Window(-1.0, 1.0, 0.0, 3.0)
    window = framing.followed(rest, np.array([[-0.5, 0.0], [80.0, 0.5], [0.2, 2.9]]), np.arange(3))
    assert window.left == rest.left and window.top == rest.top
    assert window.width <= rest.width + framing.REACH * rest.height + 1e-9


@pytest.mark.parametrize("stone", [box("stone", (1.8, 0.4, 2.0), (2.0, 0.6, 2.2)), Block.sphere("ball", np.array([1.9, 0.5, 2.1]), 0.1)])
def test_what_has_fallen_for_ever_is_left_out_of_the_picture(stone: Block, tmp_path: Path) -> None:
    """A ball that rolled off as a stone that fell off: the picture is as wide and high as without it."""
    blocks = [*COLUMN, stone]
    rest, sizes = at_rest(blocks), []
    for fall in ((0.0, 0.0, 0.0), (3.0, 0.0, -40.0)):
        with Results.open(write_run(tmp_path / "run.h5", blocks, [rest, shifted(rest, len(COLUMN), fall)])) as results:
            window = framing.framing(results, [1], framing.MapStyle()).window
            sizes.append((window.width, window.height))
    assert sizes[0] == sizes[1]


def test_a_block_is_in_the_picture_whole_or_not_at_all() -> None:
    """One lies across the limit, 3 m next to the structure."""
    rest = Window(-1.0, 1.0, 0.0, 3.0)
    corners = np.array([[3.8, 0.0], [4.2, 0.0], [4.2, 0.4], [3.8, 0.4]])
    window = framing.followed(rest, corners, np.zeros(4, dtype=int), framing.COLLAPSE)
    assert window.right > 4.2


@pytest.mark.parametrize(("out", "held"), [(0.9, True), (3.0, False)])
def test_the_rubble_of_a_collapse_is_in_the_picture_but_not_what_flew_off(tmp_path: Path, out: float, held: bool) -> None:
    """The top block of a column lies on the ground next to it, at a share of the column's height from it."""
    rest = at_rest(COLUMN)
    fallen = shifted(rest, 3, (3.0 * out, 0, -2.0))
    with Results.open(write_run(tmp_path / "run.h5", COLUMN, [rest, fallen])) as results:
        window = framing.framing(results, [1], framing.MapStyle(view="front")).window
    assert (window.right > fallen.position[3, 0]) == held


def test_classes_run_1_2_5_and_do_not_depend_on_the_run() -> None:
    scale = opening_scale()
    np.testing.assert_allclose(np.array(scale.bounds) * 1e3, [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50])
    picked = scale(np.array([1e-4, 1.5e-4, 2e-4, 0.049, 0.05, 3.0]))
    assert [int(np.flatnonzero((scale.colours == c).all(axis=1))[0]) for c in picked] == [0, 0, 1, 7, 8, 8]
    grey = scale.colours @ np.array([0.299, 0.587, 0.114])
    assert (np.diff(grey) < -8).all(), "wider must be darker in grey print"
    assert (np.diff(sliding_scale().colours @ np.array([0.299, 0.587, 0.114])) < -4).all()


def test_round_numbers() -> None:
    assert [nice(v) for v in (1.0, 1.99, 2.0, 4.9, 5.0, 9.9, 0.06)] == [1.0, 1.0, 2.0, 2.0, 5.0, 5.0, 0.05]


def test_views_are_right_handed_and_keep_up() -> None:
    for name in ("front", "back", "side", "left", "top", "isometric"):
        view = view_named(name)
        np.testing.assert_allclose(np.cross(view.right, view.up), view.towards, atol=1e-12)
    np.testing.assert_allclose(view_named("front").right, [1, 0, 0])


def test_planar_structures_are_seen_from_the_front() -> None:
    assert auto_view(Solids.from_blocks(COLUMN)) == "front"
    assert auto_view(Solids.from_blocks([*COLUMN, box("beside", (-0.5, 0.5, 0), (0.5, 1.5, 1))])) == "isometric"


def test_scale_bar_is_true(tmp_path: Path) -> None:
    """A block of 2 m is as many pixels wide as its scale bar, which says 2 m or what else it says, promises."""
    blocks = [box("base", (-1, -1, -0.2), (1, 1, 0), "base", fixed=True), box("cube", (-1, -1, 0), (1, 1, 1), "stone")]
    Sheet.drawn(structure_scene(blocks, "a cube")).save(tmp_path / "cube.png")
    image = pixels(tmp_path / "cube.png").astype(int)
    stone = np.abs(image - 255 * rgb("#e6d9bd")).max(axis=2) < 14
    ink = (image == 255 * rgb("#23272b")).all(axis=2)
    bar_row = image.shape[0] - ink[::-1].sum(axis=1).argmax() - 1  # the outline of the bar is the longest line of ink
    bar = max(np.split(row := np.flatnonzero(ink[bar_row]), np.flatnonzero(np.diff(row) > 1) + 1), key=len)  # the axes stand next to it
    width = np.flatnonzero(stone[: image.shape[0] // 2].sum(axis=0) > 50)
    metres_per_pixel = 2.0 / np.ptp(width)
    assert (np.ptp(bar) * metres_per_pixel) == pytest.approx(nice(np.ptp(bar) * metres_per_pixel * 1.05), rel=0.02)


def test_numbered_groups_share_a_colour_where_there_are_many() -> None:
    many = [BASE, *(box(f"b{k}", (k, 0, 0), (k + 1, 1, 1), f"pier{k}") for k in range(20))]
    assert [family.text for family in families_of(many)] == ["base (1)", "pier0 to pier19 (20)"]
    assert len(families_of(many[:5])) == 5


def test_bad_input_is_one_line(tmp_path: Path) -> None:
    rest = at_rest(COLUMN)
    with Results.open(write_run(tmp_path / "run.h5", COLUMN, [rest])) as results:
        with refused_at("view"):
            crack_map(results, tmp_path / "x.png", style=framing.MapStyle(view="fornt"))
        with refused_at("scale"):
            framing.MapStyle(scale=0.0)
        with refused_at("frame 1"):
            crack_map(results, tmp_path / "x.png", frame=1)
        with refused_at("largest"):
            framing.MapStyle(thresholds=Thresholds(opened=0.1))
        with refused_at("x.png"):
            crack_map(results, tmp_path / "none" / "x.png")


def _loads(library: str) -> bool:
    """Return True if the system has a shared library."""
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the kinds of render window are those of Linux")
def test_without_opengl_the_packages_are_named() -> None:
    """VTK would end the process where it finds no OpenGL at all; the check comes first."""
    code = "from reports.drawing.render import require_context; require_context()"
    hidden = {k: v for k, v in os.environ.items() if k != "DISPLAY"} | {"VTK_DEFAULT_OPENGL_WINDOW": "vtkOSOpenGLRenderWindow"}
    if any(_loads(name) for name in ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")):
        pytest.skip("OSMesa is installed here")
    done = subprocess.run([sys.executable, "-c", code], env=hidden, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "NoContext: pictures: off-screen OpenGL is missing; on Debian and Ubuntu, run apt-get install libegl1 libgl1" in done.stderr


def meshes_of_a_wall(folder: Path, courses: int, monkeypatch: pytest.MonkeyPatch) -> int:
    """How many meshes a picture has, of a wall of as many blocks per course as courses, its upper half slid and one corner fallen."""
    import pyvista

    blocks = [box("base", (-1, -0.25, -0.5), (courses + 2, 0.25, 0), "base", fixed=True)]
    for k in range(courses):
        ends = 0.5 * (k % 2) + np.arange(courses)
        blocks += [box(f"c{k}b{i}", (x, -0.25, 0.5 * k), (x + 1, 0.25, 0.5 * k + 0.5)) for i, x in enumerate(ends)]
    rest, corner = at_rest(blocks), courses // 4
    moved = shifted(shifted(rest, slice(courses**2 // 2 + 1, None), (0.03, 0, 0)), slice(len(blocks) - corner, None), (3.0, 0, -20.0))
    drawn, add = [], pyvista.Plotter.add_mesh
    with monkeypatch.context() as watched, Results.open(write_run(folder / "run.h5", blocks, [rest, moved])) as results:
        watched.setattr(pyvista.Plotter, "add_mesh", lambda *given, **named: drawn.append(1) or add(*given, **named))
        crack_map(results, folder / "wall.png")
    return len(drawn)


@pytest.mark.validation
def test_a_picture_of_ten_thousand_blocks_has_as_many_meshes_as_one_of_a_few(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """So that drawing takes seconds, not minutes."""
    few = meshes_of_a_wall(tmp_path, 4, monkeypatch)
    assert meshes_of_a_wall(tmp_path, 100, monkeypatch) == few > 0
    assert palette.FALLEN in main_colours(tmp_path / "wall.png")


def test_a_wide_ground_is_drawn_around_the_structure_and_what_has_fallen() -> None:
    """A block of 2 m on a slab that reaches 50 m: drawn to 0.35 of 2 m around it, or around where it lies; an inclined slab as it is."""
    blocks = [box("ground", (-50, -50, -1), (50, 50, 0), "base", fixed=True), box("stone", (0, 0, 0), (1, 1, 2))]
    solids = Solids.from_blocks(blocks)
    slab, stone = (solids.vertex_block == k for k in range(2))

    def drawn(shift: float) -> tuple[float, float]:
        moved = solids.vertices + np.where(stone, shift, 0.0)[:, None] * [1.0, 0.0, 0.0]
        found = within_sight(solids, moved)
        assert (found[stone] == moved[stone]).all() and (found[slab][:, 2] == moved[slab][:, 2]).all()
        return float(found[slab, 0].min()), float(found[slab, 0].max())

    assert drawn(0.0) == pytest.approx((-0.7, 1.7))
    assert drawn(1.5) == pytest.approx((-0.7, 3.2))
    assert drawn(30.0) == pytest.approx((-0.7, 4.2))  # flung away: by the size of the structure and a quarter, no farther
    tilted = solids.vertices + np.where(slab, 0.1 * solids.vertices[:, 0], 0.0)[:, None] * [0.0, 0.0, 1.0]
    assert (within_sight(solids, tilted) == tilted).all()


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
        alone, row = framing.framing(results, [1], framing.MapStyle()), framing.framing(results, [0, 1, 2], framing.MapStyle())
        assert (alone.factor, row.factor) == (5.0, 1.0)
        paths = draw_crack_maps(results, tmp_path, [0.0, 0.1, 0.2, 0.21])
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
        assert draw_animation(results, tmp_path / "run.gif") == 5
        assert draw_animation(results, tmp_path / "short.gif", most=3) == 3
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


def test_a_single_frame_makes_no_animation_and_a_map_needs_its_frame(tmp_path: Path) -> None:
    with Results.open(write_run(tmp_path / "run.h5", COLUMN, [at_rest(COLUMN)])) as results:
        with refused_at("animation"):
            draw_animation(results, tmp_path / "run.gif")
        with refused_at("frame 1"):
            crack_map(results, tmp_path / "x.png", frame=1)
    with refused_at("largest"):
        framing.MapStyle(thresholds=Thresholds(opened=0.1))


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
            image = canvas.draw(PictureScene(view_named("front"), Window(0.0, 1.0, 0.0, 1.0), layers))
            assert image[20, 20].tolist() == colour
            assert number == 0 or len(drawn) == before + 1  # the first picture opens OpenGL as well


def test_a_pixel_is_the_mean_of_its_samples() -> None:
    """A square that ends in the middle of the column of pixels at 20 covers half of the samples there, and all or none elsewhere."""
    square = np.array([[0.0, 0, 0], [0.5, 0, 0], [0.5, 0, 1], [0, 0, 1]])
    layer = Surface(square, np.arange(4), np.array([0, 4]), np.array([[200, 0, 100]], np.uint8), lit=False)
    drawn = PictureScene(view_named("front"), Window(0.0, 1.0, 0.0, 1.0), [layer])
    with Canvas(view_named("front"), (41, 41), samples=2) as canvas:
        row = canvas.draw(drawn)[20]
    assert (row[2:20] == [200, 0, 100]).all() and (row[21:39] == 255).all()
    assert np.abs(row[20] - 0.5 * (np.array([200.0, 0.0, 100.0]) + 255.0)).max() <= 1.0


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another allocator")
def test_memory_of_pictures_goes_back_to_the_system() -> None:
    """A picture of 4.8 million samples, four to a pixel, takes 180 MB; one that keeps what its steps free has hardly any."""

    def draw(pixels: tuple[int, int]) -> float:
        """Resident memory after a picture [MB]."""
        square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]])
        layer = Surface(square, np.arange(4), np.array([0, 4]), np.array([[255, 0, 0]], np.uint8), lit=False)
        with Canvas(view_named("front"), pixels, samples=2) as canvas:
            canvas.draw(PictureScene(view_named("front"), Window(0.0, 1.0, 0.0, 1.0), [layer]))
        return float(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * resource.getpagesize() / 1e6

    keep_freed_memory()
    first = draw((10, 10))  # opens OpenGL
    assert draw((1200, 1000)) - first < 60.0
