# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks of a VRML world, version 1.0 or 2.0 (97), in a child process (:mod:`structures.files.foreign`).

They are its IndexedFaceSets, each placed by the transformations above it, as often as it is used, and named by the nearest DEF.

Both versions are trees of ``DEF name Type { field value ... Type { ... } }``. Of version 2 a Shape has a geometry, whose Coordinate belongs
to it; of version 1 Coordinate3, transformations and ShapeHints hold for what follows them within a Separator. Shapes that are no face sets
are counted; prototypes, which may hold any, are refused. VRML has metres and y up, by which the caller turns it.
Sources: ISO/IEC 14772-1; VRML 1.0 specification.
"""

from __future__ import annotations

import gzip
import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from structures.files.foreign import FileContents, Refused
from structures.files.surface_readers import pieces_of

TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[{}\[\]]|[^\s,{}\[\]"#]+|#[^\n\r]*')
HEADS, PACKED = ("#VRML V1.0", "#VRML V2.0"), b"\x1f\x8b"
GROUPS = ("Group", "Transform", "Anchor", "Billboard", "Collision", "Separator", "TransformSeparator", "WWWAnchor", "Shape")
PLACING = ("Transform", "Translation", "Rotation", "Scale", "MatrixTransform")
OTHER = ("Box", "Cone", "Cylinder", "Sphere", "Cube", "Extrusion", "ElevationGrid", "IndexedLineSet", "PointSet", "Inline", "WWWInline")
PROTOTYPES = ("PROTO", "EXTERNPROTO")
DEEPEST = 60  # nodes within nodes
MOST = 100_000  # face sets: USE within USE multiplies them


@dataclass
class Node:
    """A node of the tree, its fields and the nodes that stand in it without a field."""

    kind: str
    name: str = ""
    fields: dict[str, list[Any]] = field(default_factory=dict)
    inside: list[Node] = field(default_factory=list)

    def nodes(self, *names: str) -> list[Node]:
        """The nodes in some fields, or those without one."""
        return [one for name in names for one in self.fields.get(name, ()) if isinstance(one, Node)] or self.inside

    def numbers(self, name: str, *usual: float) -> list[float]:
        """The numbers of a field."""
        return [float(word) for word in self.fields[name]] if name in self.fields else [*usual]


@dataclass
class NodeState:
    """The rules that hold where a node stands."""

    place: np.ndarray  # (4, 4)
    name: str = ""
    points: Sequence[float] = ()
    clockwise: bool = False


def read(path: Path) -> FileContents:
    """The shells of a world.

    Raises:
        Refused: no VRML, a prototype, numbers that do not fit, no faces.
    """
    data = path.read_bytes()
    text = (gzip.decompress(data) if data.startswith(PACKED) else data).decode("utf-8", "replace")
    if not text.lstrip("\ufeff").startswith(HEADS):
        raise Refused(path.name, f"does not begin with {' or '.join(HEADS)}")
    unread: Counter[str] = Counter()
    try:
        words = [word for word in TOKEN.findall(text) if not word.startswith("#")]
        if other := next((word for word in words if word in PROTOTYPES), None):
            raise Refused(path.name, f"{other}: prototypes are not read; write their shapes")
        tree = Node("Group", inside=_Parser(words).world())
        objects = [*_face_sets(tree, NodeState(np.eye(4)), unread, 0)]
    except (ValueError, IndexError, KeyError, TypeError, RecursionError):
        raise Refused(path.name, "not the nodes and face sets of a VRML world: cut short or damaged") from None
    if not objects and unread:
        seen = ", ".join(f"{count} {what}" for what, count in unread.items())
        raise Refused(path.name, f"no IndexedFaceSet in it; {seen} not read")
    notes = [f"{path.name}: {count} {what} not read" for what, count in unread.items()]
    return FileContents(
        pieces_of(path, objects), (), [*notes, f"{path.name}: metres and y up, as VRML has it, where the scene says nothing else"]
    )


class _Parser:
    """The tree of a row of words."""

    def __init__(self, words: Sequence[str]) -> None:
        self.words, self.at, self.known = words, 0, dict[str, Node]()

    def world(self) -> list[Node]:
        """The nodes that the world begins with."""
        found = []
        while self.at < len(self.words):
            if self.words[self.at] == "ROUTE":
                self.at += 4
            else:
                found.append(self._node(0))
        return found

    def _node(self, depth: int) -> Node:
        name = ""
        if self.words[self.at] == "USE":
            self.at += 2
            return self.known[self.words[self.at - 1]]
        if self.words[self.at] == "DEF":
            name = self.words[self.at + 1]
            self.at += 2
        made = Node(self.words[self.at], name)
        if depth > DEEPEST or self.words[self.at + 1] != "{":
            raise ValueError
        self.at += 2
        while self.words[self.at] != "}":
            if self.words[self.at] == "ROUTE":
                self.at += 4
            elif self._is_node():
                made.inside.append(self._node(depth + 1))
            else:
                key = self.words[self.at]
                self.at += 1
                made.fields[key] = self._value(depth)
        self.at += 1
        if name:
            self.known[name] = made
        return made

    def _is_node(self) -> bool:
        return self.words[self.at] in ("DEF", "USE") or self.words[self.at + 1] == "{"

    def _value(self, depth: int) -> list[Any]:
        """The value of a field: a list in brackets, a node, or the numbers, texts or the word that follow."""
        if self.words[self.at] == "[":
            self.at += 1
            found: list[Any] = []
            while self.words[self.at] != "]":
                found.append(self._node(depth + 1) if self._is_node() else self.words[self.at])
                self.at += 0 if isinstance(found[-1], Node) else 1
            self.at += 1
            return found
        if self._is_node():
            return [self._node(depth + 1)]
        first = self.at
        while self.words[self.at][0] in '+-.0123456789"':
            self.at += 1
        self.at += first == self.at
        return [*self.words[first : self.at]]


def _face_sets(node: Node, state: NodeState, unread: Counter[str], depth: int) -> Iterator[tuple[str, np.ndarray, list[list[int]]]]:
    """Name, corners in the world and faces of the face sets within a node; what holds for its neighbours goes into the state."""
    if depth > DEEPEST or sum(unread.values()) > MOST:
        raise ValueError
    name, kind = node.name or state.name, node.kind
    if kind in PLACING and not node.fields.get("children"):
        state.place = state.place @ _matrix(node)
    elif kind in GROUPS:
        own = NodeState(state.place @ _matrix(node) if kind == "Transform" else state.place, name, state.points, state.clockwise)
        for one in node.nodes("children", "geometry", "collide"):
            yield from _face_sets(one, own, unread, depth + 1)
        if kind == "Group" and not node.fields:  # of version 1 it lets its state out
            state.place, state.points, state.clockwise = own.place, own.points, own.clockwise
    elif kind in ("Switch", "LOD"):
        choices = node.nodes("choice", "level", "children")
        chosen = int(node.numbers("whichChoice" if "whichChoice" in node.fields else "whichChild", -1)[0]) if kind == "Switch" else 0
        unread["choices of a Switch, hidden,"] += len(choices) - (0 <= chosen < len(choices)) if kind == "Switch" else 0
        if 0 <= chosen < len(choices):
            yield from _face_sets(choices[chosen], NodeState(state.place, name, state.points, state.clockwise), unread, depth + 1)
    elif kind in ("Coordinate3", "Coordinate"):
        state.points = node.numbers("point")
    elif kind == "ShapeHints":
        state.clockwise = node.fields.get("vertexOrdering") == ["CLOCKWISE"]
    elif kind == "IndexedFaceSet":
        yield name, *_faces(node, state)
    elif kind in OTHER:
        unread[kind] += 1


def _faces(node: Node, state: NodeState) -> tuple[np.ndarray, list[list[int]]]:
    """The corners of a face set in the world (V, 3), and its faces as seen from outside."""
    own = next((one.numbers("point") for one in node.fields.get("coord", ()) if isinstance(one, Node)), state.points)
    points = np.array(own, dtype=float).reshape(-1, 3) @ state.place[:3, :3].T + state.place[:3, 3]
    loops: list[list[int]] = [[]]
    for index in node.numbers("coordIndex"):
        if index < 0.0:
            loops.append([])
        else:
            loops[-1].append(int(index))
    inwards = (state.clockwise or node.fields.get("ccw") == ["FALSE"]) != (np.linalg.det(state.place[:3, :3]) < 0.0)
    return points, [loop[::-1] if inwards else loop for loop in loops if loop]


def _matrix(node: Node) -> np.ndarray:
    """The matrix (4, 4) of a transformation: T C R SR S SR^-1 C^-1."""
    if node.kind == "MatrixTransform":
        return np.array(node.numbers("matrix", *np.eye(4).ravel())).reshape(4, 4).T  # of rows times it
    centre, turn = node.numbers("center", 0, 0, 0), _turned(node.numbers("scaleOrientation", 0, 0, 1, 0))
    scale = np.diag([*node.numbers("scale" if "scale" in node.fields else "scaleFactor", 1, 1, 1), 1.0])
    moves = [_moved(node.numbers("translation", 0, 0, 0)), _moved(centre), _turned(node.numbers("rotation", 0, 0, 1, 0)), turn]
    return np.asarray(np.linalg.multi_dot([*moves, scale, turn.T, _moved([-x for x in centre])]))


def _moved(by: Sequence[float]) -> np.ndarray:
    out = np.eye(4)
    out[:3, 3] = by
    return out


def _turned(rotation: Sequence[float]) -> np.ndarray:
    """A rotation by an axis and an angle (4,), by Rodrigues' formula."""
    axis, angle = np.array(rotation[:3], dtype=float), float(rotation[3])
    out = np.eye(4)
    if angle and (size := float(np.linalg.norm(axis))) > 0.0:
        x, y, z = axis / size
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        out[:3, :3] += math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)
    return out
