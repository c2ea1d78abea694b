# SPDX-License-Identifier: GPL-3.0-or-later
"""Entities of a drawing, as values: outlines, paths, texts, inserts, and what is none of these, each with its handle and its layer.

A child process reads them from the file (:mod:`structures.plans.dxf_file`), in the order of their fields, by which :func:`entity_of` makes
them again.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from structures.files.foreign import points_of

MOST_BULGE = 1e4  # of an arc: with more it is a whole circle to a thousandth of a degree
LONGEST_NAME = 255  # characters, of a layer in DXF
PATH, TEXT, INSERT, OTHER = KINDS = ("path", "text", "insert", "other")


class Entity(NamedTuple):
    """An entity of a drawing, in the drawing's unit or, once scaled, in metres."""

    kind: str  # one of KINDS
    handle: str  # hexadecimal; of what an insert brings, that of the insert with a number, A3/2
    drawn_as: str  # LINE, LWPOLYLINE, HATCH ...
    layer: str
    points: np.ndarray  # (P, 3): x, y, bulge of the piece that begins there; of a text the ends of its line, of an insert its place
    text: str = ""  # of a text; of an insert the block's name and its attributes, TAG=value
    closed: bool = False
    width: float = 0.0  # of a polyline that has one
    owner: str = ""  # handle of the insert that brings it

    def scaled(self, factor: float, origin: Sequence[float] = (0.0, 0.0)) -> Entity:
        """In another unit, about another origin [of the new unit]."""
        points = self.points.copy()
        points[:, :2] = points[:, :2] * factor - np.asarray(origin)
        return self._replace(points=points, width=self.width * factor)

    @property
    def line(self) -> Any:
        """A line of shapely from the first of its points to the last."""
        import shapely

        return shapely.LineString(self.points[[0, -1], :2])


def entity_of(kind: Any, handle: str, drawn_as: str, layer: str, points: Any, text: str, closed: Any, width: Any, owner: str) -> Entity:
    """An entity of a reader's answer.

    Raises:
        ValueError, TypeError, AttributeError: no answer of ours, or places that are no numbers.
    """
    places = points_of(points)
    if kind not in KINDS or not (np.isfinite(places).all() and np.isfinite(width)):
        raise ValueError(f"{drawn_as} {handle} on layer {layer} has places that are no numbers")
    if kind == PATH and np.abs(places[:, 2]).max(initial=0.0) > MOST_BULGE:
        raise ValueError(f"{drawn_as} {handle} on layer {layer} has a bulge of more than {MOST_BULGE:g}")
    text = "\n".join(map(_plain, text.split("\n")))
    return Entity(kind, _plain(handle), _plain(drawn_as), _plain(layer), places, text, bool(closed), float(width), _plain(owner))


def _plain(words: str) -> str:
    """Words of a drawing, which are shown as they are, without control characters and what no name is long enough for."""
    shown = "".join(c if c.isprintable() else "?" for c in words)
    return shown if len(shown) <= LONGEST_NAME else shown[:LONGEST_NAME] + "..."
