# SPDX-License-Identifier: GPL-3.0-or-later
"""The structure report: counts that can be done by hand."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from models import box, ground, tower, wall
from solids import build

import structures
from masonry_cd.mechanics.model.blocks import Block
from structures.summary import lines, odd_size, report, warnings


def test_a_stack_counted_by_hand() -> None:
    made = report(tower(5, side=0.5, height=0.25))
    assert (made["blocks"], made["fixed"], made["joints"], made["contacts"], made["pieces"]) == (5, 1, 5, 20, 1)
    assert made["mass"] == pytest.approx(5 * 0.5 * 0.5 * 0.25 * 2000.0)
    assert made["centre_of_mass"] == pytest.approx([0.0, 0.0, 0.625])
    assert made["hyperstaticity"] == 3 * 20 - 6 * 5
    assert made["extent"] == pytest.approx([0.5, 0.5, 1.25])
    assert made["groups"]["block"] == {"blocks": 5, "mass": pytest.approx(625.0)}


def test_smallest_and_largest_block_are_named() -> None:
    made = report(wall(3, 2, length=0.4))
    assert made["smallest"]["volume"] == pytest.approx(0.5 * made["largest"]["volume"])
    assert made["smallest"]["name"].startswith("c1.")
    text = "\n".join(lines(made))
    assert made["largest"]["name"] in text
    assert f"hyperstatic to degree {made['hyperstaticity']}" in text


def test_two_stacks_are_two_pieces() -> None:
    blocks = [
        ground(1.0),
        box("a", (-0.5, -0.5, 0.0), (0.0, 0.5, 0.5)),
        box("slab", (4.0, -1.0, -0.5), (5.0, 1.0, 0.0), fixed=True),
        box("b", (4.2, -0.5, 0.0), (4.8, 0.5, 0.5)),
    ]
    assert report(blocks)["pieces"] == 2


def test_a_block_that_touches_nothing_is_named() -> None:
    made = report([*tower(2), box("stray", (5.0, 5.0, 5.0), (5.5, 5.5, 5.5))])
    assert (made["loose"], made["hanging"], made["adrift"]) == (["stray"], [], [])
    (line,) = warnings(made)
    assert line.startswith('block "stray" touches no other block, and falls; of a file, structure.gaps = WIDTH [m] closes')


def test_a_piece_without_a_support_is_named() -> None:
    blocks = [*tower(2), box("low", (5.0, 0.0, 5.0), (5.5, 0.5, 5.5)), box("high", (5.0, 0.0, 5.5), (5.5, 0.5, 6.0))]
    made = report(blocks)
    assert (made["loose"], made["adrift"], made["pieces"]) == ([], ["low", "high"], 2)
    assert warnings(made)[0].startswith(
        "2 blocks (low, high): in a piece of the structure that touches no support, and falls as a whole; of a file, "
    )


def test_a_block_between_two_others_hangs() -> None:
    """Nothing but friction holds it; those next to it stand on the ground."""
    blocks = [ground(2.0), *(box(f"b{k}", (0.5 * k - 1.0, -0.5, 0.3 * (k == 1)), (0.5 * k - 0.5, 0.5, 1.0)) for k in range(3))]
    made = report(blocks)
    assert made["hanging"] == ["b1"]
    assert warnings(made)[0].startswith("1 hangs: nothing is under b1, only friction on the sides")


@pytest.mark.parametrize("kind", ["wall", "column", "vault", "dome"])
def test_every_kind_is_one_piece_by_default(kind: str) -> None:
    made = report(build(kind))
    assert made["hyperstaticity"] > 0
    assert made["pieces"] == 1
    assert made["hanging"] == []


def on_its_side(blocks: list[Block], up: str) -> list[Block]:
    """Blocks whose file states the other upward axis: z is taken for -y, or for +y."""
    sign = {"-y": 1.0, "+y": -1.0}[up]
    turned = [np.stack([b.vertices[:, 0], -sign * b.vertices[:, 2], sign * b.vertices[:, 1]], axis=1) for b in blocks]
    parts = [[replace(p, vertices=np.stack([p.vertices[:, 0], -sign * p.vertices[:, 2], sign * p.vertices[:, 1]], axis=1)) for p in b.parts]
             for b in blocks]  # fmt: skip
    return [replace(b, vertices=v, parts=tuple(p)) for b, v, p in zip(blocks, turned, parts, strict=True)]


@pytest.mark.parametrize("kind", ["wall", "tower", "column", "dome", "aqueduct", "arch", "vault"])
@pytest.mark.parametrize("up", ["+y", "-y"])
def test_a_structure_on_its_side_is_recognised(kind: str, up: str) -> None:
    size = {"radius": 2.0, "thickness": 0.3} if kind == "arch" else {}
    blocks = structures.build({"kind": kind, **size}, 2000.0, Path())
    assert report(blocks)["side"] == ""
    made = report(on_its_side(blocks, up))
    assert made["side"] == up
    (line,) = (line for line in warnings(made) if "hang" in line)
    assert f"does the structure lie on its side? far fewer would hang if {up} pointed upwards" in line


def test_what_hangs_in_an_upright_structure_puts_it_on_no_side() -> None:
    """Courses between two abutments: all hang but the lowest, and each would rest on its neighbour, were x upwards."""
    abutments = [
        box("left", (-2.0, -0.5, -1.0), (-1.0, 0.5, 1.0), fixed=True),
        box("right", (1.0, -0.5, -1.0), (2.0, 0.5, 1.0), fixed=True),
    ]
    between = [box(f"b{k}", (-1.0 + 0.5 * k, -0.5, 0.0), (-0.5 + 0.5 * k, 0.5, 1.0)) for k in range(4)]
    made = report([*abutments, *between])
    assert (made["hanging"], made["side"]) == (["b0", "b1", "b2", "b3"], "")
    cantilever = report([ground(5.0), box("stone", (0, 0, 0), (1, 1, 1)), box("glued", (1, 0, 0.5), (2, 1, 1))])
    assert (cantilever["hanging"], cantilever["side"]) == (["glued"], "")


@pytest.mark.parametrize(
    ("height", "said"),
    [(0.25, "smaller than 0.3 m"), (0.35, ""), (40.0, ""), (290.0, "and no block thinner than "), (310.0, "larger than 300 m")],
)
def test_a_structure_of_odd_size_asks_for_its_unit(height: float, said: str) -> None:
    found = odd_size([ground(5.0), box("stone", (0, 0, 0), (height / 6, height / 6, height))])
    assert [said in line for line in found] == ([True] if said else [])
