# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene of a run at rest as the page's viewer takes it: arrays by name and numbers for JSON.

The viewer carries each point of a block, and the polygons of its joints, by the motions of :mod:`reports.page.motion`; colours come from
the palette that all pictures share, classes from the scales of the crack map.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from masonry_cd.analysis.damage.definitions import STATES, Thresholds
from masonry_cd.analysis.damage.joint_damage import JointDamage
from masonry_cd.analysis.deformed import Solids
from masonry_cd.io.results import Results
from reports.drawing import palette
from reports.drawing.parts import Lines, Surface
from reports.drawing.scene import PictureScene
from reports.drawing.solids import auto_view, families_of
from reports.maps.framing import COLLAPSE
from reports.page.motion import PageMotion

COLOURS = {
    "stone": palette.STONE, "support": palette.SUPPORT, "fallen": palette.FALLEN, "parted": palette.PARTED, "edge": palette.EDGE,
    "axes": palette.AXES, "tie": palette.PULLING,
}  # fmt: skip
COLUMNS = (
    "max_opening", "residual_opening", "max_sliding", "residual_sliding", "max_rotation", "contact_area_loss", "first_opening_time", "area",
)  # fmt: skip


def model_arrays(scene: PictureScene) -> dict[str, np.ndarray]:
    """Faces, edges and joints of a scene, but for the vertices of its blocks."""
    faces = next(layer for layer in scene.layers if isinstance(layer, Surface) and layer.owner is not None)
    edges = next(layer for layer in scene.layers if isinstance(layer, Lines) and layer.outline)
    joints = scene.joints
    assert faces.owner is not None and joints is not None
    owner = np.zeros(len(faces.points), np.uint32)
    owner[faces.loops] = np.repeat(faces.owner, np.diff(faces.loop_start))
    return {
        "vertex_block": owner,
        "loops": faces.loops.astype(np.uint32),
        "loop_start": faces.loop_start.astype(np.uint32),
        "edges": edges.pairs.astype(np.uint32),
        "joint_a": joints.blocks[0].astype(np.uint32),
        "joint_b": joints.blocks[1].astype(np.uint32),
        "joint_normal": joints.normals[0].astype(np.float32),
        "polygon_start": joints.start.astype(np.uint32),
    }


def blocks_and_damage(results: Results, solids: Solids, scene: PictureScene, table: JointDamage) -> dict[str, np.ndarray]:
    """All that does not move: the model, the groups, the damage table."""
    origin = origin_of(solids)
    family = np.zeros(len(results.blocks), np.uint8)
    for k, item in enumerate(families_of(results.blocks)):
        family[item.members] = min(k, 255)
    assert scene.joints is not None
    return {
        **model_arrays(scene),
        "polygon": (scene.joints.corners[0] - origin).astype(np.float32),
        "centre": (solids.centre - origin).astype(np.float32),
        "fixed": solids.fixed.astype(np.uint8),
        "family": family,
        "state": np.array([STATES.index(word) for word in table.state], np.uint8),
        **{f"damage/{name}": getattr(table, name).astype(np.float32) for name in COLUMNS},
    }


def names_and_words(results: Results, solids: Solids, thresholds: Thresholds) -> dict[str, Any]:
    """Return the data that fit into JSON."""
    free = _free(solids)
    away = np.linalg.norm(solids.centre - origin_of(solids), axis=1)
    return {
        "names": [block.name for block in results.blocks],
        "groups": [block.group for block in results.blocks],
        "families": [{"text": item.text, "colour": item.colour} for item in families_of(results.blocks)],
        "smallest": float(np.median(solids.sizes[free].min(axis=1))),
        "top": int(np.argmax(np.where(free, solids.centre[:, 2] - 1e-9 * away, -np.inf))),
        "states": STATES,
        "meaning": thresholds.in_words(),
        "colours": COLOURS,
        "scene": results.scene,
    }


def camera(solids: Solids, moved: PageMotion) -> dict[str, Any]:
    """From where the model is looked at first, and the box that it shows: the blocks at rest and wherever they went, those flung away
    left out. A planar structure that moved most across its plane is not looked at from the front."""
    free, origin = _free(solids), origin_of(solids)
    rest = solids.vertices[free[solids.vertex_block]]
    low, high = rest.min(axis=0), rest.max(axis=0)
    reach = COLLAPSE * float((high - low).max())
    place = (solids.centre + moved.displacement)[:, free]  # (F, B, 3)
    near = ((place > low - reach) & (place < high + reach)).all(axis=2)[..., None]
    half = 0.5 * solids.sizes[free]
    lowest = np.where(near, place - half, np.inf).min(axis=(0, 1))
    highest = np.where(near, place + half, -np.inf).max(axis=(0, 1))
    most = np.abs(moved.displacement[:, free]).max(axis=(0, 1))
    view = auto_view(solids)
    return {
        "view": "isometric" if view == "front" and most[1] > most[0] else view,
        "low": (np.minimum(low, lowest) - origin).tolist(),
        "high": (np.maximum(high, highest) - origin).tolist(),
    }


def origin_of(solids: Solids) -> np.ndarray:
    """The middle of the free blocks (3,) [m]: numbers near zero lose nothing in float32."""
    drawn = solids.vertices[_free(solids)[solids.vertex_block]]
    return np.asarray((drawn.min(axis=0) + drawn.max(axis=0)) / 2.0)


def _free(solids: Solids) -> np.ndarray:
    """(B,) the blocks that are free; all where none is."""
    return ~solids.fixed if not solids.fixed.all() else solids.fixed
