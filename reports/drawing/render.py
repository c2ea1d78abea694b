# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws scenes off screen with VTK, as a few meshes whatever the number of blocks: all faces, all edges, the bands of all joints."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from ctypes.util import find_library
from functools import cache
from typing import Any

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.extras import require
from masonry_cd.foundation.freed_memory import give_back_freed_memory
from reports.drawing.parts import Layer, Lines, View, Window
from reports.drawing.scene import PictureScene, cut_layers, joint_layers, placed, tie_layers, ties_of

SAMPLES = 2  # of a picture, in each direction
LIGHTS = (((-0.5, 0.6, 0.9), 0.50), ((0.9, 0.1, 0.5), 0.16), ((0.0, 0.0, 1.0), 0.12))  # towards the light (right, up, viewer), strength
AMBIENT = 0.45
NO_CONTEXT = "off-screen OpenGL is missing; on Debian and Ubuntu, run apt-get install libegl1 libgl1 (or set report.crack_map = false)"


class NoContext(InputError):
    """VTK cannot draw without a display here."""


def render(scene: PictureScene, pixels: tuple[int, int], samples: int | None = None) -> np.ndarray:
    """Draw a scene into an image (height, width, 3) uint8 on white; a pixel is the mean of samples x samples rendered ones, see SAMPLES."""
    with Canvas(scene.view, pixels, samples) as canvas:
        return canvas.draw(scene)


class Canvas:
    """A picture of a size that is drawn again as often as needed: opening OpenGL takes longer than to draw. Use it as a context manager.

    Raises:
        InputError: no off-screen OpenGL; names the packages that bring it.
    """

    def __init__(self, view: View, pixels: tuple[int, int], samples: int | None = None) -> None:
        require_context()
        require("this", "pyvista")
        import pyvista

        self._view, self._pixels, self._samples = view, pixels, samples or SAMPLES
        self._size = [self._samples * n for n in pixels]
        self._plotter = pyvista.Plotter(off_screen=True, window_size=self._size, lighting="none")
        context: Any = self._plotter.render_window
        context.SetMultiSamples(0)  # the samples are taken here, alike on every driver
        self._plotter.set_background("white")  # type: ignore[arg-type]  # a wrapper hides its signature
        _add_lights(self._plotter, view)

    def __enter__(self) -> Canvas:
        return self

    def __exit__(self, *_: object) -> None:
        self._plotter.close()
        give_back_freed_memory()

    def draw(self, scene: PictureScene) -> np.ndarray:
        """Draw a scene, seen as the canvas was made for, but for words, into an image (height, width, 3) uint8 on white."""
        layers = [*cut_layers(scene), *joint_layers(scene), *tie_layers(ties_of(scene))]
        layers = placed(layers, self._view, scene.window.height)
        self._plotter.clear_actors()
        for layer in layers:
            _add(self._plotter, layer, self._samples)
        _aim(self._plotter.camera, layers, self._view, scene.window)
        self._plotter.render()  # once, with all layers: a screenshot alone renders the first time only
        image = self._plotter.screenshot(None, return_img=True)
        if image is None or image.shape[:2] != (self._size[1], self._size[0]):
            raise NoContext("pictures", NO_CONTEXT)
        if self._samples == 1:
            return np.array(image[..., :3])
        n = self._samples  # added one by one, which takes a tenth of the time of a mean over both axes
        parts = [image[i::n, k::n, :3] for i in range(n) for k in range(n)]
        total = np.zeros(parts[0].shape, dtype=np.uint16)
        for part in parts:
            total += part
        return (total / n**2).round().astype(np.uint8)


@cache
def require_context() -> None:
    """Check that VTK can draw without a display; where it cannot, it would end the process.

    Raises:
        InputError: it cannot; names the packages that bring it.
    """
    require("a picture", "pyvista", "vtkmodules")
    if not sys.platform.startswith("linux"):
        return
    try:
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  (registers the kinds of render window)
        from vtkmodules.vtkCommonCore import vtkLogger
        from vtkmodules.vtkRenderingCore import vtkRenderWindow
    except ImportError:
        raise NoContext("pictures", NO_CONTEXT) from None
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)  # it warns of each kind of window that it tries in vain
    kind = vtkRenderWindow().GetClassName()
    if kind == "vtkRenderWindow" or (kind == "vtkOSOpenGLRenderWindow" and find_library("OSMesa") is None):
        raise NoContext("pictures", NO_CONTEXT)


def _add_lights(plotter: Any, view: View) -> None:
    """Lights that keep their place at the viewer's side, so that every view is lit alike."""
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
