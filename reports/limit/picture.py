# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of a limit analysis: the mechanism with its hinges and slips, and the line of thrust at collapse."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from masonry_cd.analysis.deformed import Solids
from masonry_cd.analysis.limit.analysis import Collapse
from masonry_cd.analysis.limit.mechanism import STATES, STILL, Mechanism
from masonry_cd.analysis.limit.ties import LimitTie
from masonry_cd.foundation.quantities import counted, force
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.fill import BARS, CoveredFaces, Fill
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.model.polygon import next_in_loop
from reports.drawing.figure import LABELLED
from reports.drawing.palette import AT_WORK, CRUSHED, EDGE, FILL, INK, MOVES, PULLING, REST, STANDS, THRUST
from reports.drawing.parts import BEFORE, BEHIND, KeyPanel, Layer, Lines, Sign, Surface, Ties, View, Window, painted, ribbon, view_named
from reports.drawing.scene import PictureScene
from reports.drawing.solids import MARGIN, auto_view, block_layers, fill_layer, structure_window, two_colours, within_sight
from reports.maps.thrust import THINNEST, joint_ribbons

AMPLITUDE = 0.07  # largest displacement drawn, as a share of the structure's size
DOT = 0.008  # radius of a hinge, as a share of the picture's height
BAND = 4.0  # width of a joint that is at work [pixels]
SIDES = 16  # of a dot
GLASS = 0.25  # opacity of the blocks around the line of thrust
PIXEL = 1e-3  # of a picture, as a share of its height
AWAY = 0.1  # share of the speed of the blocks that leads away from the viewer at which a picture is drawn from the other side


@dataclass(frozen=True, eq=False)
class LimitSubject:
    """The contents of the pictures."""

    moves: Mechanism
    blocks: Sequence[Block]
    joints: Joints
    ties: Sequence[LimitTie] = ()
    fills: Sequence[Fill] = ()  # of bridges


def mechanism_scene(subject: LimitSubject, title: str, facts: str, view: str = "auto") -> PictureScene:
    """The mechanism, its largest displacement a share of the structure's size.

    Raises:
        InputError: an unknown view.
    """
    solids, moves = Solids.from_blocks(subject.blocks), subject.moves
    looking = view_of_motion(solids, moves, view)
    reach = AMPLITUDE * float(np.ptp(solids.vertices[~solids.fixed[solids.vertex_block]], axis=0).max())

    def moved(points: np.ndarray, block: np.ndarray) -> np.ndarray:
        return moved_points(moves, solids.centre, points, block, reach)

    vertices, joints = moved(solids.vertices, solids.vertex_block), subject.joints
    window = structure_window(solids, looking, vertices)
    corner_joint = np.repeat(np.arange(joints.count), np.diff(joints.polygon_start))
    corners = _between(moved, joints, joints.polygon, corner_joint)
    rows = [Sign("box", f"moves: {counted(int(moves.moving.sum()), 'block')}", (MOVES,))]
    fill = CoveredFaces.of(subject.fills, [block.name for block in subject.blocks])
    filled = [] if fill is None else [fill_layer(fill, moved, len(subject.blocks))]
    for layer in filled:
        window = window.joined(Window.around(looking.plane(layer.points), MARGIN))
        rows.append(Sign("box", "fill", (FILL, EDGE)))
    at_work = [name for name in STATES[1:] if moves.count(name)]
    radius = DOT * window.height
    hinges = {name: np.flatnonzero((moves.state == STATES.index(name)) & (moves.rotation > STILL)) for name in ("hinge", "hinge and slide")}
    rows += [Sign("line", f"{name}: {counted(moves.count(name), 'joint')}", (AT_WORK[name],)) for name in at_work]
    crushed = int(moves.crushing.sum())
    rows += [Sign("line", f"crushes: {counted(crushed, 'joint')}", (CRUSHED,))] * bool(crushed)
    return PictureScene(
        view=looking,
        window=window,
        layers=[
            *moving_layers(solids, vertices, moves.moving, solids),
            *filled,
            *_outlines(moves, joints, corners, looking),
            *(
                dots(_between(moved, joints, moves.hinge[j], j), AT_WORK[name], looking, radius, through(looking))
                for name, j in hinges.items()
            ),
        ],
        ties=drawn_ties(subject.ties, moved),
        title=title,
        facts=facts,
        key=[
            KeyPanel(rows + _tie_signs(subject.ties)),
            KeyPanel(ruler=True, note=f"largest displacement drawn as {reach:.3g} m; thin lines: as built"),
        ],
    )


def thrust_scene(subject: LimitSubject, collapse: Collapse, title: str, facts: str, view: str = "auto") -> PictureScene:
    """The forces at collapse.

    Raises:
        InputError: an unknown view.
    """
    solids, joints = Solids.from_blocks(subject.blocks), subject.joints
    looking = view_of_motion(solids, subject.moves, view)
    window = structure_window(solids, looking)
    place, strength = np.nan_to_num(collapse.force_point), np.maximum(collapse.normal_force, 0.0)
    line, largest = joint_ribbons((joints.block_a, joints.block_b), place, strength, solids, looking, PIXEL * window.height)
    crossed = (strength >= THINNEST * max(largest, 1e-300)) & np.isfinite(collapse.force_point).all(axis=1)
    vertices = within_sight(solids, solids.vertices)
    rows = [Sign("line", f"normal force, at most {force(largest)}", (THRUST,)), Sign("dot", "resultant in a joint", (INK,))]
    note = f"forces at collapse: where they are not unique, one of many sets; those below {THINNEST:.0%} of the largest are not drawn"
    return PictureScene(
        view=looking,
        window=window,
        layers=[
            Lines(vertices, solids.edges(), REST, 1.0),
            line,
            dots(place[crossed], INK, looking, 0.5 * DOT * window.height, BEFORE),
            Surface(vertices, solids.loops, solids.loop_start, painted(STANDS, len(solids.face_block)), opacity=GLASS),
        ],
        ties=drawn_ties(subject.ties, lambda points, block: points),
        title=title,
        facts=facts,
        key=[KeyPanel(rows + _tie_signs(subject.ties)), KeyPanel(ruler=True, note=note)],
    )


def moving_layers(solids: Solids, vertices: np.ndarray, moving: np.ndarray, built: Solids) -> list[Layer]:
    """The blocks of a mechanism with vertices (V, 3), those that are moving (B,) in a colour of theirs, over their outlines as built."""
    outlines = Lines(within_sight(built, built.vertices), built.edges(), REST, 1.2, BEHIND)
    return [*block_layers(solids, within_sight(solids, vertices), two_colours(solids, moving, MOVES, STANDS)), outlines]


def drawn_ties(ties: Sequence[LimitTie], moved: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Ties:
    """Ties as a picture shows them, without the fill; ``moved`` says where points (n, 3) of blocks (n,) are drawn."""
    ties = [tie for tie in ties if not tie.label.startswith(BARS)]
    ends = [[moved(tie.points[:, k], tie.blocks[:, k]).mean(axis=0) for k in range(2)] for tie in ties]
    pulls = np.array([tie.total for tie in ties])
    return Ties(np.array(ends, dtype=float).reshape(-1, 2, 3), tuple(tie.words for tie in ties), pulls)


def _tie_signs(ties: Sequence[LimitTie]) -> list[Sign]:
    """Return the signs of the ties that are drawn in the key."""
    ties = [tie for tie in ties if not tie.label.startswith(BARS)]
    return [Sign("line", "tie, with what it pulls" if len(ties) <= LABELLED else "tie, some with what they pull", (PULLING,))] * bool(ties)


def view_of_motion(solids: Solids, moves: Mechanism, view: str) -> View:
    """The view required; by itself as of the structure, but not along the axis in which it moves, and from where the blocks move to."""
    if view != "auto":
        return view_named(view)
    usual = view_named(auto_view(solids))
    speed = np.abs(moves.velocity[:, :3]).max(axis=0, initial=0.0)
    along = not usual.is_oblique and abs(usual.towards[int(np.argmax(speed))]) > 0.5
    found = view_named("isometric") if along else usual
    return _from_ahead(found, moves) if found.is_oblique else found


def _from_ahead(view: View, moves: Mechanism) -> View:
    """The view, turned half round where blocks would move away from it, behind those that stand."""
    velocity = moves.velocity[moves.moving, :3]
    towards = float((velocity[:, :2] @ view.towards[:2]).sum())
    if towards >= -AWAY * float(np.linalg.norm(velocity[:, :2], axis=1).sum()):
        return view
    half = np.array([-1.0, -1.0, 1.0])
    return View(view.name, half * view.right, half * view.up, half * view.towards)


def moved_points(moves: Mechanism, centre: np.ndarray, points: np.ndarray, block: np.ndarray, reach: float) -> np.ndarray:
    """Points (N, 3) of blocks (N,) when the largest velocity has become a displacement ``reach`` [m]; blocks turn rigidly."""
    turn = reach * moves.velocity[:, 3:]
    angle = np.maximum(np.linalg.norm(turn, axis=1), 1e-300)[:, None]
    axis, arm = (turn / angle)[block], points - centre[block]
    sine, cosine = np.sin(angle)[block], np.cos(angle)[block]
    along = axis * np.sum(axis * arm, axis=1, keepdims=True)
    turned = cosine * (arm - along) + along + sine * np.cross(axis, arm)
    return centre[block] + reach * moves.velocity[block, :3] + turned


def _outlines(moves: Mechanism, joints: Joints, corners: np.ndarray, view: View) -> list[Layer]:
    """Outlines of the joints at work with their corners (N, 3) where they are drawn, and around them those of joints that crush; a front
    view shows them through the thickness."""
    state, crushed = (np.repeat(part, np.diff(joints.polygon_start)) for part in (moves.state, moves.crushing))
    pairs = np.stack([np.arange(len(state)), next_in_loop(joints.polygon_start)], axis=1)
    crush = Lines(corners, pairs[crushed], CRUSHED, 2.0 * BAND, through(view), lift=0.5 * PIXEL)
    return [crush, *(Lines(corners, pairs[state == STATES.index(n)], c, BAND, through(view), lift=PIXEL) for n, c in AT_WORK.items())]


def through(view: View) -> int:
    """The place of signs at joints: before everything in a view along an axis, where blocks would hide what is within their thickness."""
    return 0 if view.is_oblique else BEFORE


def _between(moved: Callable[[np.ndarray, np.ndarray], np.ndarray], joints: Joints, points: np.ndarray, joint: np.ndarray) -> np.ndarray:
    """Points (N, 3) of joints (N,), halfway between where the two blocks carry them."""
    return np.asarray(0.5 * (moved(points, joints.block_a[joint]) + moved(points, joints.block_b[joint])))


def dots(places: np.ndarray, colour: str, view: View, radius: float, place: int) -> Surface:
    """Discs at places (n, 3) that face the viewer, lifted by three of their radii."""
    turn = 2.0 * math.pi * np.arange(SIDES) / SIDES
    rim = radius * (np.cos(turn)[:, None] * view.right + np.sin(turn)[:, None] * view.up)
    lifted = places + 3.0 * radius * view.towards
    return ribbon(lifted[:, None] + rim, painted(colour, len(places)), place=place)
