r"""Draws polygons and lines off-screen with VTK, in parallel projection, and returns an image.

A picture is a few layers, each one mesh whatever the number of blocks: the faces of all blocks, their edges, the bands of all
joints. Parallel projection keeps lengths in the plane of the picture, so that one scale bar holds everywhere in it.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.freed_memory import give_back_freed_memory

SAMPLES = 2  # of a picture, in each direction
LIGHTS = (((-0.5, 0.6, 0.9), 0.50), ((0.9, 0.1, 0.5), 0.16), ((0.0, 0.0, 1.0), 0.12))  # towards the light (right, up, viewer), strength
AMBIENT = 0.45
NO_CONTEXT = (
    "pictures: no off-screen OpenGL here; on Debian and Ubuntu: apt-get install libegl1 libgl1 (or go without: report.crack_map = false)"
)


@dataclass(frozen=True, eq=False)
class View:
    """A direction to look in: unit vectors to the right, up, and towards the viewer, (3,) each."""

    name: str
    right: np.ndarray
    up: np.ndarray
    towards: np.ndarray

    @property
    def is_oblique(self) -> bool:
        """Whether it looks along no axis, so that a picture does not show by itself where the axes point."""
        return bool(np.abs(self.towards).max() < 0.999)

    def plane(self, points: np.ndarray) -> np.ndarray:
        """Points (N, 3) in the plane of the picture, (N, 2): right and up [m]."""
        return np.stack([points @ self.right, points @ self.up], axis=1)


@dataclass(frozen=True)
class Window:
    """The part of a view's plane that the picture shows [m]."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def width(self) -> float:
        """[m]"""
        return self.right - self.left

    @property
    def height(self) -> float:
        """[m]"""
        return self.top - self.bottom

    def joined(self, other: Window) -> Window:
        """The smallest window around this one and another."""
        left, right = min(self.left, other.left), max(self.right, other.right)
        return Window(left, right, min(self.bottom, other.bottom), max(self.top, other.top))

    def fitted(self, pixels: tuple[int, int]) -> Window:
        """The smallest window around this one that has the shape of an image (width, height)."""
        width = max(self.width, self.height * pixels[0] / pixels[1])
        height = width * pixels[1] / pixels[0]
        x, y = (self.left + self.right) / 2, (self.bottom + self.top) / 2
        return Window(x - width / 2, x + width / 2, y - height / 2, y + height / 2)


@dataclass(frozen=True, eq=False)
class Surface:
    """Polygons F with colours (F, 3) uint8; lit ones are shaded, others keep their colour exactly. Less than opaque ones come last."""

    points: np.ndarray
    loops: np.ndarray
    loop_start: np.ndarray
    colours: np.ndarray
    lit: bool = True
    opacity: float = 1.0


@dataclass(frozen=True, eq=False)
class Lines:
    """Straight lines between pairs (E, 2) of points."""

    points: np.ndarray
    pairs: np.ndarray
    colour: str
    width: float  # pixels


Layer = Surface | Lines


def view_named(name: str) -> View:
    """A view by name: front (along y), back, side (from +x), top, isometric.

    Raises:
        InputError: an unknown name.
    """
    turn, tilt = np.radians(32.0), np.radians(24.0)
    towards = {
        "front": (0.0, -1.0, 0.0),
        "back": (0.0, 1.0, 0.0),
        "side": (1.0, 0.0, 0.0),
        "top": (0.0, 0.0, 1.0),
        "isometric": (np.sin(turn) * np.cos(tilt), -np.cos(turn) * np.cos(tilt), np.sin(tilt)),
    }
    if name not in towards:
        raise InputError(f'view: "{name}" is none; views: auto, {", ".join(towards)}')
    viewer = np.array(towards[name])
    upward = np.array([0.0, 1.0, 0.0]) if name == "top" else np.array([0.0, 0.0, 1.0])
    right = np.cross(upward, viewer)
    right /= np.linalg.norm(right)
    return View(name, right, np.cross(viewer, right), viewer)


def render(layers: Sequence[Layer], view: View, window: Window, pixels: tuple[int, int], samples: int = SAMPLES) -> np.ndarray:
    """Draw layers into an image (height, width, 3) uint8 on white; each pixel is the mean of samples x samples rendered ones.

    Raises:
        InputError: no off-screen OpenGL; names the packages that bring it.
    """
    with Canvas(view, pixels, samples) as canvas:
        return canvas.draw(layers, window)


class Canvas:
    """A picture that is drawn anew as often as needed: opening OpenGL takes longer than to draw. Use it as a context manager.

    Args:
        view: of all pictures.
        pixels: width and height.
        samples: along a side of a pixel.

    Raises:
        InputError: no off-screen OpenGL; names the packages that bring it.
    """

    def __init__(self, view: View, pixels: tuple[int, int], samples: int = SAMPLES) -> None:
        require_context()
        import pyvista

        self._view, self._pixels, self._samples = view, pixels, samples
        self._size = [samples * n for n in pixels]
        self._plotter = pyvista.Plotter(off_screen=True, window_size=self._size, lighting="none")
        context: Any = self._plotter.render_window
        context.SetMultiSamples(0)  # the samples are taken here, alike on every driver
        self._plotter.set_background("white")  # type: ignore[arg-type]  # a wrapper hides its signature
        _light(self._plotter, view)

    def __enter__(self) -> Canvas:
        return self

    def __exit__(self, *_: object) -> None:
        self._plotter.close()
        give_back_freed_memory()

    def draw(self, layers: Sequence[Layer], window: Window) -> np.ndarray:
        """Draw layers into an image (height, width, 3) uint8 on white."""
        self._plotter.clear_actors()
        for layer in layers:
            _add(self._plotter, layer, self._samples)
        _aim(self._plotter.camera, layers, self._view, window)
        self._plotter.render()  # once, with all layers: a screenshot alone renders the first time only
        image = self._plotter.screenshot(None, return_img=True)
        if image is None or image.shape[:2] != (self._size[1], self._size[0]):
            raise InputError(NO_CONTEXT)
        if self._samples == 1:
            return np.array(image[..., :3])
        fine = image[..., :3].reshape(self._pixels[1], self._samples, self._pixels[0], self._samples, 3)
        return np.asarray(fine.mean(axis=(1, 3)).round().astype(np.uint8))


@cache
def require_context() -> None:
    """Check that VTK can draw without a display; where it cannot, it would end the process.

    Raises:
        InputError: it cannot; names the packages that bring it.
    """
    if not sys.platform.startswith("linux"):
        return
    try:
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  (registers the kinds of render window)
        from vtkmodules.vtkCommonCore import vtkLogger
        from vtkmodules.vtkRenderingCore import vtkRenderWindow
    except ImportError:
        raise InputError(NO_CONTEXT) from None
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)  # it warns of each kind of window that it tries in vain
    kind = vtkRenderWindow().GetClassName()
    if kind == "vtkRenderWindow" or (
        kind == "vtkOSOpenGLRenderWindow" and not _loadable("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")
    ):
        raise InputError(NO_CONTEXT)


def _loadable(*names: str) -> bool:
    """True where one of these shared libraries is installed."""
    for name in names:
        try:
            ctypes.CDLL(name)
        except OSError:
            continue
        return True
    return False


def _light(plotter: Any, view: View) -> None:
    """Lights that keep their place beside the viewer, so that every view is lit alike."""
    import pyvista

    for (right, up, towards), strength in LIGHTS:
        direction = right * view.right + up * view.up + towards * view.towards
        plotter.add_light(pyvista.Light(position=direction, focal_point=(0, 0, 0), light_type="scene light", intensity=strength))


def _add(plotter: Any, layer: Layer, samples: int) -> None:
    """Add one layer as one mesh."""
    import pyvista

    if isinstance(layer, Lines):
        if len(layer.pairs):
            cells = np.insert(layer.pairs, 0, 2, axis=1).ravel()
            mesh = pyvista.PolyData(layer.points, lines=cells)
            plotter.add_mesh(mesh, color=layer.colour, line_width=samples * layer.width, lighting=False, render=False)
        return
    if len(layer.loop_start) < 2:
        return
    cells = np.insert(layer.loops, layer.loop_start[:-1], np.diff(layer.loop_start))
    mesh = pyvista.PolyData(layer.points, faces=cells)
    mesh.cell_data["colour"] = layer.colours
    look = {"ambient": AMBIENT, "diffuse": 1.0, "specular": 0.0} if layer.lit else {}
    plotter.add_mesh(mesh, scalars="colour", rgb=True, lighting=layer.lit, opacity=layer.opacity, show_edges=False, render=False, **look)


def _aim(camera: Any, layers: Sequence[Layer], view: View, window: Window) -> None:
    """Point a parallel camera at the window, far enough away to see everything."""
    middle = (window.left + window.right) / 2 * view.right + (window.bottom + window.top) / 2 * view.up
    depth = np.concatenate([layer.points @ view.towards for layer in layers if len(layer.points)])
    span = float(np.ptp(depth)) + window.height
    camera.parallel_projection = True
    camera.focal_point = middle + view.towards * depth.mean()
    camera.position = middle + view.towards * (float(depth.max()) + span)
    camera.up = view.up
    camera.parallel_scale = window.height / 2
    camera.clipping_range = (0.5 * span, 2.5 * span)
