# SPDX-License-Identifier: GPL-3.0-or-later
r"""Prestwood bridge, loaded to collapse across its quarter point: the ring, with the fill as weight and as earth pressure.

The fill weighs gamma h on the extrados, h the depth under the road. A load of width w at the road spreads by 1 : 2 on either side. Where
the ring sways into the fill, on the side away from the load, it pushes back with at most K_p gamma h, K_p = (1 + sin phi) / (1 - sin phi).
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.studies.laboratory.case import Case, Found, Row, limit_factor
from structures.geometry.prism import prism_xz

SPAN, RISE, THICK, WIDTH, COVER = 6.55, 1.428, 0.22, 3.8, 0.165  # of the intrados; width; fill above the crown's extrados [m]
COLLAPSE, PLACE, STRIP = 228.0, 0.25, 0.3  # [kN]; share of the span; width of the load along the span [m]
WEIGHT = 20e3  # of brickwork and of fill [N/m3]
SPREAD = 0.5  # on either side, per depth
FRICTION, ANGLE = 0.6, np.radians(37.0)  # of joints, and of the fill
SHARES = (0.0, 0.25, 0.5)  # of K_p that the fill brings
VOUSSOIRS = 40
MOST = 1000.0  # that is looked at [kN]

RADIUS = (0.25 * SPAN**2 + RISE**2) / (2.0 * RISE)  # of the intrados [m]
CENTRE = RISE - RADIUS  # its height above the springings [m]
ROAD = RISE + THICK + COVER  # [m]


def edges() -> np.ndarray:
    """(VOUSSOIRS + 1, 2) cosines and sines of the joints, from left to right."""
    half = np.arcsin(0.5 * SPAN / RADIUS)
    angle = 0.5 * np.pi + np.linspace(half, -half, VOUSSOIRS + 1)
    return np.column_stack([np.cos(angle), np.sin(angle)])


def extrados() -> np.ndarray:
    """(VOUSSOIRS + 1, 2) x and z of the outer ends of the joints [m]."""
    return np.array([0.0, CENTRE]) + (RADIUS + THICK) * edges()


def ring() -> list[Block]:
    """The voussoirs between two abutments, whose faces are those of the first and last joint."""
    ways, centre = edges(), np.array([0.0, CENTRE])
    inner, outer = centre + RADIUS * ways, extrados()
    density = WEIGHT / 9.81
    blocks = []
    for name, k, along in (("left", 0, -1.0), ("right", -1, 1.0)):
        off = along * 0.5 * np.array([ways[k, 1], -ways[k, 0]])
        face = [outer[k], inner[k], inner[k] + off, outer[k] + off]
        blocks.append(Block(name, *prism_xz(_turned_left(np.array(face)), 0.0, WIDTH), density, "base", fixed=True))
    for k in range(VOUSSOIRS):
        loop = np.array([inner[k], inner[k + 1], outer[k + 1], outer[k]])
        blocks.append(Block(f"v{k + 1}", *prism_xz(_turned_left(loop), 0.0, WIDTH), density, "ring"))
    return blocks


def _turned_left(loop: np.ndarray) -> np.ndarray:
    """A loop that runs counter-clockwise in x and z."""
    x, z = loop.T
    return loop if float(np.sum(x * np.roll(z, -1) - z * np.roll(x, -1))) > 0.0 else loop[::-1]


def loads(load: float, share: float) -> tuple[list[dict[str, Any]], list[int]]:
    """Those of a scene, and the places of those that grow: a line load [kN] in all, and a share of K_p in the fill."""
    outer, at = extrados(), (PLACE - 0.5) * SPAN
    passive = share * (1.0 + np.sin(ANGLE)) / (1.0 - np.sin(ANGLE))
    half = 0.5 * STRIP + SPREAD * (ROAD - float(np.interp(at, outer[:, 0], outer[:, 1])))
    constant: list[dict[str, Any]] = []
    growing: list[dict[str, Any]] = []
    for k, ((x0, z0), (x1, z1)) in enumerate(pairwise(outer.tolist())):
        x, depth = 0.5 * (x0 + x1), ROAD - 0.5 * (z0 + z1)
        attack = {"kind": "point", "block": f"v{k + 1}", "point": [x, 0.5 * WIDTH, 0.5 * (z0 + z1)]}
        constant.append({**attack, "force": [0.0, 0.0, -WEIGHT * WIDTH * depth * (x1 - x0)]})
        across = WEIGHT * WIDTH * depth * passive * abs(z1 - z0) if x > 0.0 else 0.0
        down = 1e3 * load * max(0.0, min(x1, at + half) - max(x0, at - half)) / (2.0 * half)
        if across > 0.0 or down > 0.0:
            growing.append({**attack, "force": [-across, 0.0, -down]})
    return constant + growing, list(range(len(constant), len(constant) + len(growing)))


def collapse(folder: Path, share: float) -> float:
    """The load that the ring still carries together with the pressure that it calls up [kN]: both grow, to the load and to the share."""
    low, high = 0.0, MOST
    while high - low > 1e-3 * MOST:
        middle = 0.5 * (low + high)
        tables, live = loads(middle, share)
        material = {"density": WEIGHT / 9.81, "friction": FRICTION}
        scene = {"title": f"Prestwood bridge, {share:g} of K_p", "material": material, "loads": tables}
        stands = limit_factor(folder, ring(), scene, live) >= 1.0
        low, high = (middle, high) if stands else (low, middle)
    return 0.5 * (low + high)


def compute(folder: Path, say: Callable[[str], object]) -> Found:
    """The collapse load by limit analysis."""
    found = Found(axes=("share of the passive earth pressure", "collapse load [kN]"))
    factors = []
    for share in SHARES:
        factors.append(collapse(folder / f"passive_{share:g}", share))
        say(f"{share:g} of K_p: {factors[-1]:.1f} kN")
        words = "fill as weight alone" if share == 0.0 else f"fill with {share:g} of its passive pressure"
        found.rows.append(Row(f"collapse load, {words}", "kN", COLLAPSE, factors[-1], None))
    found.computed.append(("limit analysis", np.array(SHARES), np.array(factors)))
    found.measured.append(("measured", np.array([SHARES[0], SHARES[-1]]), np.array([COLLAPSE, COLLAPSE])))
    return found


CASE = Case(
    "arch_bridge",
    "A brick arch bridge loaded to collapse",
    "Page, Research Report 110 of the Transport and Road Research Laboratory, 1987: Prestwood bridge, 228 kN on a line across the quarter "
    "point, a mechanism of four hinges",
    "span 6.55 m, rise 1.428 m, ring 0.22 m, width 3.8 m, 0.165 m of fill over the crown; 20 kN/m3 of brickwork and fill, 37 degrees in "
    "the fill, friction 0.6; the ring a part of a circle in 40 voussoirs; the load 0.3 m wide at the road, spread by 1 : 2",
    "the distorted shape of the ring; the fill's strength; how much of its passive pressure a ring calls up before it gives way",
    "The ring with the fill as dead weight carries little more than half. What the fill pushes back with, on the side on which the ring "
    "sways into it, makes the difference: with half of its passive pressure, as assessments of such bridges assume, six sevenths are "
    "reached. The whole of it would push the ring over the other way. Here the fill is weight and pressure, not a body.",
    compute,
)
