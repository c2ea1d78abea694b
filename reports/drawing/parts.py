# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of scenes: surfaces, lines, ties and keys in plain arrays, views and windows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from dataclasses import replace as replaced

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.extras import require
from masonry_cd.foundation.quantities import classes

BEHIND, AMONG, BEFORE = -1, 0, 1  # places of a layer: behind everything, where it is, before everything


@dataclass(frozen=True, eq=False)
class View:
    """A direction to look in: unit vectors to the right, up, and towards the viewer, (3,) each."""

    name: str
    right: np.ndarray
    up: np.ndarray
    towards: np.ndarray

    @property
    def is_oblique(self) -> bool:
        """Return True if it looks along no axis."""
        return bool(np.abs(self.towards).max() < 0.999)

    def plane(self, points: np.ndarray) -> np.ndarray:
        """Points (N, 3) in the plane of the picture, (N, 2): right and up [m]."""
        return np.stack([points @ self.right, points @ self.up], axis=1)


def view_named(name: str) -> View:
    """A view by name: front (along y), back, side (from +x), left (from -x), top, isometric.

    Raises:
        InputError: an unknown name.
    """
    turn, tilt = np.radians(32.0), np.radians(24.0)
    towards = {
        "front": (0.0, -1.0, 0.0),
        "back": (0.0, 1.0, 0.0),
        "side": (1.0, 0.0, 0.0),
        "left": (-1.0, 0.0, 0.0),
        "top": (0.0, 0.0, 1.0),
        "isometric": (np.sin(turn) * np.cos(tilt), -np.cos(turn) * np.cos(tilt), np.sin(tilt)),
    }
    if name not in towards:
        raise InputError("view", f'"{name}" is not a view; choose auto, {", ".join(towards)}')
    viewer = np.array(towards[name])
    upward = np.array([0.0, 1.0, 0.0]) if name == "top" else np.array([0.0, 0.0, 1.0])
    right = np.cross(upward, viewer)
    right /= np.linalg.norm(right)
    return View(name, right, np.cross(viewer, right), viewer)


@dataclass(frozen=True)
class Window:
    """The part of a view's plane that the picture shows [m]."""

    left: float
    right: float
    bottom: float
    top: float

    @classmethod
    def around(cls, plane: np.ndarray, margin: float) -> Window:
        """The window around points (N, 2), with a margin as a share of the larger side."""
        (left, bottom), (right, top) = plane.min(axis=0), plane.max(axis=0)
        pad = margin * max(right - left, top - bottom)
        return cls(float(left - pad), float(right + pad), float(bottom - pad), float(top + pad))

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

    def within(self, other: Window) -> Window:
        """Return the intersection with another window."""
        left, right = max(self.left, other.left), min(self.right, other.right)
        return Window(left, right, max(self.bottom, other.bottom), min(self.top, other.top))

    def fitted(self, pixels: tuple[int, int]) -> Window:
        """The smallest window around this one that has the shape of an image (width, height)."""
        width = max(self.width, self.height * pixels[0] / pixels[1])
        height = width * pixels[1] / pixels[0]
        x, y = (self.left + self.right) / 2, (self.bottom + self.top) / 2
        return Window(x - width / 2, x + width / 2, y - height / 2, y + height / 2)


@dataclass(frozen=True, eq=False)
class Surface:
    """P polygons. Less than opaque ones come last."""

    points: np.ndarray  # (N, 3) [m]
    loops: np.ndarray  # (L,) indices of points
    loop_start: np.ndarray  # (P + 1,)
    colours: np.ndarray  # (P, 3) uint8
    lit: bool = True  # shaded; others keep their colour exactly
    opacity: float = 1.0
    place: int = AMONG
    lift: float = 0.0  # towards the viewer, as a share of the picture's height
    owner: np.ndarray | None = None  # (P,) the block of each polygon, or (2, P) the two of a joint
    inside: np.ndarray | None = None  # (B, 3) uint8 colours of the blocks where a plane cuts them
    spared: float | None = 0.0  # what a cut leaves before its plane [m]; None: everything

    def some(self, chosen: np.ndarray) -> Surface:
        """The polygons chosen (P,) bool."""
        sides = np.diff(self.loop_start)
        owner = None if self.owner is None else self.owner[..., chosen]
        loops, start = self.loops[np.repeat(chosen, sides)], np.cumsum([0, *sides[chosen]])
        return replaced(self, loops=loops, loop_start=start, colours=self.colours[chosen], owner=owner)


@dataclass(frozen=True, eq=False)
class Lines:
    """Straight lines between pairs (E, 2) of points."""

    points: np.ndarray  # (N, 3) [m]
    pairs: np.ndarray
    colour: str
    width: float  # pixels
    place: int = AMONG
    lift: float = 0.0
    outline: bool = False  # of polygons, which a picture of polygons outlines by itself


Layer = Surface | Lines


@dataclass(frozen=True, eq=False)
class Ties:
    """T ties, drawn before everything else with their tension next to their middle."""

    ends: np.ndarray = field(default_factory=lambda: np.zeros((0, 2, 3)))  # (T, 2, 3) [m]
    texts: tuple[str, ...] = ()  # of their labels
    tension: np.ndarray = field(default_factory=lambda: np.zeros(0))  # (T,) [N]


class ColourClasses:
    """Classes of a value, each with a colour and its lower bound; the last is open."""

    def __init__(self, bounds: Sequence[float], colours: tuple[str, float, float], factor: float) -> None:
        require("a picture", "matplotlib")
        from matplotlib import colormaps

        name, low, high = colours  # of a colour map, and the part of it in use
        self.bounds = list(bounds)
        self.factor = factor  # of the bounds, into the unit of the key
        self.colours = np.round(255 * colormaps[name](np.linspace(low, high, len(self.bounds)))[:, :3]).astype(np.uint8)

    def __call__(self, values: np.ndarray) -> np.ndarray:
        """(N, 3) uint8 colours of values (N,)."""
        return self.colours[np.clip(np.searchsorted(self.bounds, values, side="right") - 1, 0, len(self.colours) - 1)]

    @property
    def middle(self) -> str:
        """The colour that stands for all of them."""
        return hexed(self.colours[len(self.colours) // 2])


class Scale(ColourClasses):
    """Classes of a length [m], in the key in mm, from a threshold to a largest value in steps of 1-2-5; one more class lies beyond."""

    def __init__(self, smallest: float, largest: float, colours: tuple[str, float, float]) -> None:
        super().__init__(classes(smallest, largest), colours, 1e3)


@dataclass(frozen=True)
class Sign:
    """A row of a key: a sign, and what it means."""

    kind: str  # box, band (dashes of two colours), line, dot; empty for none
    text: str
    colours: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class KeyPanel:
    """A part of a key: a scale of colours with its name, or the scale bar and the axes; signs; a note."""

    signs: Sequence[Sign] = ()
    scale: tuple[str, ColourClasses] | None = None
    dashed: bool = False
    ruler: bool = False
    note: str = ""
    wide: int = 1  # places that it takes where they are side by side


RULER = KeyPanel(ruler=True)


def rgb(colour: str) -> np.ndarray:
    """``#rrggbb`` as (3,) in 0..1."""
    return np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0


def hexed(colour: np.ndarray) -> str:
    """A colour (3,) of uint8 as ``#rrggbb``."""
    return "#" + "".join(f"{int(part):02x}" for part in colour)


def painted(colour: str, count: int) -> np.ndarray:
    """(count, 3) uint8 of one colour."""
    return np.tile((255 * rgb(colour)).astype(np.uint8), (count, 1))


def ribbon(corners: np.ndarray, colours: np.ndarray, **look: object) -> Surface:
    """Polygons of equally many corners, (P, n, 3) [m], that keep their colours (P, 3) uint8."""
    points = corners.reshape(-1, 3)
    start = np.arange(0, len(points) + 1, corners.shape[1])
    return Surface(points, np.arange(len(points)), start, colours, lit=False, **look)  # type: ignore[arg-type]
