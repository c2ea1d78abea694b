# SPDX-License-Identifier: GPL-3.0-or-later
"""What a drawing holds, as values: outlines, paths, texts, inserts, and what is none of these, each with its handle and its layer.

A child process reads them from the file (:mod:`structures.plans.dxf_file`); they cross over as pieces of :mod:`structures.files.foreign`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from structures.files.foreign import Piece

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


def to_pieces(entities: Iterable[Entity]) -> list[Piece]:
    """Entities as a reader's answer."""
    return [
        Piece(KINDS.index(e.kind), "\n".join((e.handle, e.owner, e.drawn_as, e.text)), e.points, (), e.layer, e.closed, e.width)
        for e in entities
    ]


def from_pieces(pieces: Iterable[Piece]) -> list[Entity]:
    """Entities of a reader's checked answer.

    Raises:
        ValueError: no answer of ours, or places that are no numbers.
    """
    found = []
    for piece in pieces:
        handle, owner, drawn_as, text = piece.name.split("\n", 3)
        if not (0 <= piece.number < len(KINDS) and np.isfinite(piece.vertices).all() and np.isfinite(piece.density)):
            raise ValueError(f"{drawn_as} {handle} on layer {piece.group} has places that are no numbers")
        if piece.number == KINDS.index(PATH) and np.abs(piece.vertices[:, 2]).max(initial=0.0) > MOST_BULGE:
            raise ValueError(f"{drawn_as} {handle} on layer {piece.group} has a bulge of more than {MOST_BULGE:g}")
        handle, owner, drawn_as, layer = (_plain(words) for words in (handle, owner, drawn_as, piece.group))
        text = "\n".join(map(_plain, text.split("\n")))
        found.append(Entity(KINDS[piece.number], handle, drawn_as, layer, piece.vertices, text, piece.fixed, piece.density, owner))
    return found


def _plain(words: str) -> str:
    """Words of a drawing, which are shown as they are, without control characters and what no name is long enough for."""
    shown = "".join(c if c.isprintable() else "?" for c in words)
    return shown if len(shown) <= LONGEST_NAME else shown[:LONGEST_NAME] + "..."
