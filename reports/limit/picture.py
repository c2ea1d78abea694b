"""The pictures of a limit analysis: the mechanism with its hinges and slips, and the line of thrust at collapse."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.deformed import Solids
from masonry_cd.analysis.limit.analysis import Collapse
from masonry_cd.analysis.limit.mechanism import STATES, STILL, Mechanism
from masonry_cd.foundation.quantities import counted, force
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.joints import Joints
from reports.drawing.figure import INK, Box, Paint, Sheet, layout
from reports.drawing.render import Layer, Lines, Surface, View, Window, render, view_named
from reports.drawing.structure_picture import (
    SUPPORT,
    around,
    auto_view,
    block_layers,
    box_swatch,
    rgb,
    structure_window,
    tie_swatch,
    within_sight,
)
from reports.drawing.tie_lines import LABELLED, DrawnTies
from reports.limit.ties import LimitTie, drawn_ties
from reports.maps.thrust import COLOUR, THINNEST, joint_ribbons

AMPLITUDE = 0.07  # largest displacement drawn, as a share of the structure's size
COLOURS = {"hinge": "#d55e00", "slide": "#0072b2", "hinge and slide": "#cc79a7", "open": "#009e73"}
STANDS, MOVES, REST = "#ddd8cc", "#f0d9a8", "#9aa0a6"
DOT = 7.0  # radius of a hinge [pixels]
BAND = 4.0  # width of a joint that is at work [pixels]
SIDES = 16  # of a dot
GLASS = 0.25  # opacity of the blocks around the line of thrust


@dataclass(frozen=True, eq=False)
class Subject:
    """What the pictures show."""

    collapse: Collapse
    blocks: Sequence[Block]
    joints: Joints
    ties: Sequence[LimitTie] = ()


def mechanism_picture(subject: Subject, path: Path, title: str, facts: str, view: str = "auto") -> None:
    """Draw the moved blocks, hinges, slips, openings and ties into a PNG.

    Raises:
        InputError: an unknown view, no off-screen OpenGL, or a path that cannot be written.
    """
    solids, moves, joints = Solids.from_blocks(subject.blocks), subject.collapse.mechanism, subject.joints
    looking = view_of_motion(solids, moves, view)
    free = ~solids.fixed[solids.vertex_block]
    reach = AMPLITUDE * float(np.ptp(solids.vertices[free], axis=0).max())
    moved = moved_points(moves, solids.centre, solids.vertices, solids.vertex_block, reach)
    window = structure_window(solids, looking).joined(around(looking.plane(moved[free]), 0.06))
    plan = layout(window.width / window.height)
    window = window.fitted(plan.pixels)
    colours = np.where(moves.moving[:, None], rgb(MOVES), rgb(STANDS))
    colours[solids.fixed] = rgb(SUPPORT)
    layers: list[Layer] = [*block_layers(solids, within_sight(solids, moved), colours, looking, window)]
    behind = (1.0 + float(np.ptp(moved @ looking.towards))) * looking.towards  # in parallel projection, hidden by all that moved
    layers.append(Lines(within_sight(solids, solids.vertices) - behind, solids.edges(), REST, 1.2))
    depth = 0.0 if looking.is_oblique else float(np.ptp(moved @ looking.towards))  # a front view shows joints through the thickness
    layers += _joint_layers(moves, joints, solids, reach, looking, window.width / plan.pixels[0], depth)
    ties = drawn_ties(subject.ties, lambda points, block: moved_points(moves, solids.centre, points, block, reach))
    sheet = Sheet(plan)
    sheet.model(_with_ties(layers, ties, looking, window, plan.pixels))
    sheet.head(title, facts)
    rows: list[tuple[Paint, str]] = [(partial(box_swatch, colour=MOVES), f"moves: {counted(int(moves.moving.sum()), 'block')}")]
    rows += [(partial(_line_swatch, colour=COLOURS[name]), f"{name}: {counted(moves.count(name), 'joint')}") for name in STATES[1:]]
    rows += _tie_rows(ties)
    note = f"largest displacement drawn as {reach:.3g} m; thin lines: as built"
    _key(sheet, rows, note, looking, window)
    sheet.save(path)


def thrust_picture(subject: Subject, path: Path, title: str, facts: str, view: str = "auto") -> None:
    """Draw the line of thrust at collapse, where the resultants cross the joints, and the ties into a PNG.

    Raises:
        InputError: an unknown view, no off-screen OpenGL, or a path that cannot be written.
    """
    solids, collapse, joints = Solids.from_blocks(subject.blocks), subject.collapse, subject.joints
    looking = view_of_motion(solids, collapse.mechanism, view)
    window = structure_window(solids, looking)
    plan = layout(window.width / window.height)
    window = window.fitted(plan.pixels)
    pixel = window.width / plan.pixels[0]
    place, strength = np.nan_to_num(collapse.force_point), np.maximum(collapse.normal_force, 0.0)
    ribbons, largest = joint_ribbons((joints.block_a, joints.block_b), place, strength, solids, looking, pixel)
    crossed = (strength >= THINNEST * max(largest, 1e-300)) & np.isfinite(collapse.force_point).all(axis=1)
    ahead = 2.0 * window.height * looking.towards
    shade = np.tile((255 * rgb(STANDS)).astype(np.uint8), (len(solids.face_block), 1))
    layers: list[Layer] = [
        Lines(solids.vertices, solids.edges(), REST, 1.0),
        Surface(ribbons.points + ahead, ribbons.loops, ribbons.loop_start, ribbons.colours, lit=False),
        dots(place[crossed] + ahead, INK, looking, 0.5 * DOT * pixel),
        Surface(solids.vertices, solids.loops, solids.loop_start, shade, opacity=GLASS),
    ]
    ties = drawn_ties(subject.ties, lambda points, block: points)
    sheet = Sheet(plan)
    sheet.model(_with_ties(layers, ties, looking, window, plan.pixels))
    sheet.head(title, facts)
    colour = "#" + "".join(f"{part:02x}" for part in COLOUR)
    rows: list[tuple[Paint, str]] = [(partial(_line_swatch, colour=colour), f"normal force, at most {force(largest)}")]
    rows.append((partial(_dot_swatch, colour=INK), "resultant in a joint"))
    rows += _tie_rows(ties)
    note = f"forces at collapse: where they are not unique, one of many sets; those below {THINNEST:.0%} of the largest are not drawn"
    _key(sheet, rows, note, looking, window)
    sheet.save(path)


def _with_ties(layers: list[Layer], ties: DrawnTies, view: View, window: Window, pixels: tuple[int, int]) -> np.ndarray:
    """The image of layers, and before them the ties with their labels."""
    nearest = max((float((layer.points @ view.towards).max()) for layer in layers if len(layer.points)), default=0.0)
    return ties.labelled(render([*layers, *ties.layers(view, nearest + 1.0)], view, window, pixels), view, window)


def _tie_rows(ties: DrawnTies) -> list[tuple[Paint, str]]:
    """What the key says of ties."""
    if not len(ties.ends):
        return []
    return [(tie_swatch, "tie, with what it pulls" if len(ties.ends) <= LABELLED else "tie, some with what they pull")]


def view_of_motion(solids: Solids, moves: Mechanism, view: str) -> View:
    """The view asked for; by itself as of the structure, but not along the axis in which it moves."""
    if view != "auto":
        return view_named(view)
    usual = view_named(auto_view(solids))
    speed = np.abs(moves.velocity[:, :3]).max(axis=0, initial=0.0)
    along = not usual.is_oblique and abs(usual.towards[int(np.argmax(speed))]) > 0.5
    return view_named("isometric") if along else usual


def moved_points(moves: Mechanism, centre: np.ndarray, points: np.ndarray, block: np.ndarray, reach: float) -> np.ndarray:
    """Points (N, 3) of blocks (N,) when the largest velocity has become a displacement ``reach`` [m]; blocks turn rigidly."""
    turn = reach * moves.velocity[:, 3:]
    angle = np.maximum(np.linalg.norm(turn, axis=1), 1e-300)[:, None]
    axis, arm = (turn / angle)[block], points - centre[block]
    sine, cosine = np.sin(angle)[block], np.cos(angle)[block]
    along = axis * np.sum(axis * arm, axis=1, keepdims=True)
    turned = cosine * (arm - along) + along + sine * np.cross(axis, arm)
    return centre[block] + reach * moves.velocity[block, :3] + turned


def _joint_layers(moves: Mechanism, joints: Joints, solids: Solids, reach: float, view: View, pixel: float, depth: float) -> list[Layer]:
    """Outlines of the joints at work, halfway between their blocks and by ``depth`` [m] before them, and dots at the hinges."""
    owner = np.repeat(np.arange(joints.count), np.diff(joints.polygon_start))
    corners = _between(moves, joints, solids, joints.polygon, owner, reach) + (pixel + depth) * view.towards
    after = np.arange(1, len(owner) + 1)
    after[joints.polygon_start[1:] - 1] = joints.polygon_start[:-1]
    layers: list[Layer] = []
    for name, colour in COLOURS.items():
        at_work = moves.state[owner] == STATES.index(name)
        pairs = np.stack([np.flatnonzero(at_work), after[at_work]], axis=1)
        layers.append(Lines(corners, pairs, colour, BAND))
    hinged = np.isin(moves.state, [STATES.index("hinge"), STATES.index("hinge and slide")]) & (moves.rotation > STILL)
    which = np.flatnonzero(hinged)
    lifted = (3.0 * DOT * pixel + depth) * view.towards
    places = _between(moves, joints, solids, moves.hinge[which], which, reach) + lifted
    for name in ("hinge", "hinge and slide"):
        layers.append(dots(places[moves.state[which] == STATES.index(name)], COLOURS[name], view, DOT * pixel))
    return layers


def _between(moves: Mechanism, joints: Joints, solids: Solids, points: np.ndarray, joint: np.ndarray, reach: float) -> np.ndarray:
    """Points (N, 3) of joints (N,), halfway between where the two blocks carry them."""
    first, second = (moved_points(moves, solids.centre, points, block[joint], reach) for block in (joints.block_a, joints.block_b))
    return 0.5 * (first + second)


def dots(places: np.ndarray, colour: str, view: View, radius: float) -> Surface:
    """Discs at places (n, 3) that face the viewer."""
    turn = 2.0 * math.pi * np.arange(SIDES) / SIDES
    rim = radius * (np.cos(turn)[:, None] * view.right + np.sin(turn)[:, None] * view.up)
    points = (places[:, None] + rim).reshape(-1, 3)
    shade = np.tile((255 * rgb(colour)).astype(np.uint8), (len(places), 1))
    return Surface(points, np.arange(len(points)), np.arange(0, len(points) + 1, SIDES), shade, lit=False)


def _line_swatch(axes: Any, place: Box, colour: str) -> None:
    left, bottom, width, height = place
    axes.plot([left, left + width], [bottom + height / 2] * 2, color=colour, linewidth=BAND)


def _dot_swatch(axes: Any, place: Box, colour: str) -> None:
    left, bottom, width, height = place
    axes.plot([left + width / 2], [bottom + height / 2], "o", color=colour, markersize=DOT)


def _key(sheet: Sheet, rows: Sequence[tuple[Paint, str]], note: str, view: View, window: Window) -> None:
    """The signs, a note, and the scale bar."""
    boxes = sheet.plan.keys(2)
    axes = sheet.axes(*boxes[0])
    sheet.swatches(axes, rows, 0, boxes[0][3] - 6, pitch=28.0)  # room for six
    axes, top, width = sheet.axes(*boxes[1]), boxes[1][3], boxes[1][2]
    sheet.scale_bar(axes, window.width / sheet.plan.pixels[0], 10, top - 44, width - 60)
    columns = (38 if sheet.plan.beside else 80) - (10 if view.is_oblique else 0)  # the triad stands beside it
    for k, line in enumerate(textwrap.wrap(note, columns)):
        axes.text(0, top - 100 - 24 * k, line, fontsize=12, color=INK, va="center")
    if view.is_oblique:
        sheet.triad(axes, view, (width - 60, top - 110))
