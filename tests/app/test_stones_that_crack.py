# SPDX-License-Identifier: GPL-3.0-or-later
"""Stones that crack along planes laid beforehand: how they are cut, a lintel and a flat arch in closed form, and what a run says."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from masonry_cd.analysis.damage.stones import cracked
from masonry_cd.analysis.pushover import require_pushes
from masonry_cd.app.case import prepare
from masonry_cd.app.run_case import RESULTS, run_case
from masonry_cd.app.scene import parse_scene
from masonry_cd.app.scene_text import dump_toml
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.materials import Material
from masonry_cd.mechanics.model.stones import Stones
from masonry_cd.studies.laboratory.case import limit_factor, run_in
from structures import MadeStructure
from structures.files import blockfile
from structures.geometry.checks import check
from structures.geometry.prism import box
from structures.layout.pieces import in_pieces

SPAN, WIDE, HIGH, DENSITY, GRAVITY = 2.0, 0.4, 0.3, 2500.0, 9.81
YOUNG, STRENGTH = 3e10, 3e6


def stone(low: tuple[float, ...], high: tuple[float, ...], name: str = "stone", group: str = "wall", **keys: Any) -> Block:
    return Block(name, *box(low, high), DENSITY, group, **keys)


def cut(block: Block, **keys: Any) -> list[Block]:
    base = stone((-9.0, -9.0, -1.0), (9.0, 9.0, 0.0), "base", "base", fixed=True)
    made = in_pieces(MadeStructure([base, block], []), {"wall": Stones(tensile_strength=STRENGTH, young=YOUNG, **keys)})
    check(made.blocks)
    return list(made.blocks)[1:]


# --- cutting -------------------------------------------------------------------------------------------------------------------


def test_a_stone_is_cut_across_its_longest_extent_and_its_pieces_know_it() -> None:
    pieces = cut(stone((0.0, 0.0, 0.0), (0.3, 0.8, 0.2)))
    assert [(piece.name, piece.stone, piece.group) for piece in pieces] == [("stone/1", "stone", "wall"), ("stone/2", "stone", "wall")]
    assert [np.ptp(piece.vertices, axis=0) == pytest.approx([0.3, 0.4, 0.2]) for piece in pieces] == [True, True]


def test_a_cross_and_cells_fill_the_stone_and_cells_are_prisms_where_axes_are_given() -> None:
    block = stone((0.0, 0.0, 0.0), (0.5, 0.3, 0.4))
    whole = block.mass_properties.volume
    for keys, count in (({"planes": "cross", "across": ["x", "z"]}, 4), ({"planes": "voronoi", "pieces": 7}, 7)):
        pieces = cut(block, **keys)
        assert len(pieces) == count
        volumes = np.array([piece.mass_properties.volume for piece in pieces])
        assert volumes.sum() == pytest.approx(whole, rel=1e-9)
        assert volumes.min() > 0.3 * whole / count  # no slivers
    for piece in cut(block, planes="voronoi", pieces=6, across=["x", "z"]):
        assert np.ptp(piece.vertices[:, 1]) == pytest.approx(0.3)
    again, other = (cut(block, planes="voronoi", pieces=6, seed=seed) for seed in (0, 1))
    assert all(np.array_equal(a.vertices, b.vertices) for a, b in zip(again, cut(block, planes="voronoi", pieces=6), strict=True))
    assert not np.array_equal(again[0].vertices, other[0].vertices)


def test_pieces_of_one_stone_have_the_law_of_its_planes_and_others_that_of_their_joints(tmp_path: Path) -> None:
    blocks = [*cut(stone((0.0, 0.0, 0.0), (1.0, 0.5, 0.5))), *cut(stone((1.0, 0.0, 0.0), (2.0, 0.5, 0.5), "next"))]
    blockfile.write(tmp_path / "blocks.json", [stone((0, 0, -1), (2, 1, 0), "base", "base", fixed=True), *blocks])
    blocks = blockfile.read(tmp_path / "blocks.json", DENSITY)
    material = Material(friction=0.5, stones={"wall": Stones(tensile_strength=STRENGTH, young=YOUNG)})
    assembly = Assembly.from_blocks(blocks, material)
    a, b = np.array([1, 2, 3, 1]), np.array([2, 3, 4, 0])
    rows = assembly.rows(a, b)
    assert assembly.laws.tension[rows].tolist() == [STRENGTH, 0.0, STRENGTH, 0.0]
    assert assembly.laws.normal_stiffness[rows].tolist() == [YOUNG / 0.5, 0.0, YOUNG / 0.5, 0.0]
    assert assembly.friction[rows].tolist() == [0.85, 0.5, 0.85, 0.5]
    assert (assembly.friction * assembly.laws.apex)[rows] == pytest.approx([2.0 * STRENGTH, 0.0, 2.0 * STRENGTH, 0.0])


def test_a_kind_gives_strength_and_modulus_of_its_table_and_keys_of_the_scene_win() -> None:
    psi = 6894.757
    granite, own = Stones(kind="granite"), Stones(kind="granite", tensile_strength=STRENGTH)
    assert (granite.strength, granite.modulus) == (pytest.approx(800.0 * psi), pytest.approx(6.95e6 * psi))
    assert (own.strength, own.modulus) == (STRENGTH, granite.modulus)
    assert granite.law(0.5, granite.modulus) == Stones(tensile_strength=granite.strength).law(0.5, granite.modulus)
    base = stone((-9.0, -9.0, -1.0), (9.0, 9.0, 0.0), "base", "base", fixed=True)
    made = [in_pieces(MadeStructure([base, stone((0.0, 0.0, 0.0), (0.3, 0.8, 0.2))], []), {"wall": law}).notes for law in (granite, own)]
    assert made[0][-1] == (
        "material.stones: granite, tensile_strength 5.52 MPa (4.14 MPa to 6.89 MPa by the table), young 47.9 GPa (39.3 GPa to 56.5 GPa by "
        "the table)"
    )
    assert made[1][-1] == "material.stones: granite, young 47.9 GPa (39.3 GPa to 56.5 GPa by the table)"


# --- closed forms --------------------------------------------------------------------------------------------------------------


def lintel(high: float, **keys: Any) -> tuple[list[Block], dict[str, Any]]:
    """A lintel on two smooth rigid seats that is pressed at mid-span: its blocks and its scene."""
    seats = [stone((x, 0.0, -0.5), (x + 0.3, WIDE, 0.0), f"seat {x:g}", "base", fixed=True) for x in (-0.3, SPAN)]
    own = stone((-0.1, 0.0, 0.0), (SPAN + 0.1, WIDE, high), "lintel", "lintel")
    law = {"tensile_strength": STRENGTH, "young": YOUNG, "across": "x", **keys}
    push = {"kind": "push", "control": "displacement", "direction": "-z", "blocks": "lintel/1", "point": [SPAN / 2, WIDE / 2, high]}
    scene = {
        "title": "A lintel",
        "material": {"friction": {"default": 0.6, "base-lintel": 0.0}, "stones": {"lintel": law}},
        "loads": [push | {"targets": [9e-4], "speed": 2e-3}],
        "run": {"dt": 2e-3, "tolerance": 1e-8},
    }
    return [*seats, own], scene


def breaking_force(high: float) -> float:
    """P of P L / 4 + w L^2 / 8 - w c^2 / 2 = f_t b h^2 / 6, of a lintel that bears by c on its seats [N]."""
    weight = DENSITY * GRAVITY * WIDE * high  # per length
    return (STRENGTH * WIDE * high**2 / 6.0 - weight * (SPAN**2 / 8.0 - 0.1**2 / 2.0)) * 4.0 / SPAN


@pytest.mark.parametrize("high", [0.3, 0.4])
def test_a_lintel_breaks_at_the_moment_of_elastic_bending_and_the_run_counts_and_names_it(tmp_path: Path, high: float) -> None:
    with run_in(tmp_path, *lintel(high)) as results:
        force = require_pushes(results)[0].envelope()[1]
        planes = cracked(results)
    assert force.max() == pytest.approx(breaking_force(high), rel=0.02)
    assert planes.sum() == 1
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert (summary["stones"], summary["cracked_stones"], summary["cracked_stone_names"]) == (1, 1, ["lintel"])
    with (tmp_path / "joints.csv").open(encoding="utf-8") as file:
        assert [row["stone"] for row in csv.DictReader(file)] == ["", "", "lintel"]


def test_a_tough_stone_bears_more_and_takes_its_energy(tmp_path: Path) -> None:
    energy = 4.0 * STRENGTH**2 / (2.0 * YOUNG / 1.1)
    with run_in(tmp_path, *lintel(0.3, fracture_energy=energy)) as results:
        force = require_pushes(results)[0].envelope()[1]
        taken = results.energies["bond"][-1]
    assert 1.2 < force.max() / breaking_force(0.3) < 3.0
    assert 0.1 < taken / (energy * WIDE * 0.3) < 1.0


def test_limit_analysis_has_the_plane_as_plastic_bond(tmp_path: Path) -> None:
    blocks, scene = lintel(0.3)
    scene["loads"] = [{"kind": "point", "block": "lintel/1", "force": [0.0, 0.0, -1.0]}]  # at its centre of mass, 0.45 m from the seat
    weight = DENSITY * GRAVITY * WIDE * 0.3
    moment = STRENGTH * WIDE * 0.3**2 / 2.0 - weight * (SPAN**2 / 8.0 - 0.1**2 / 2.0)
    assert limit_factor(tmp_path, blocks, scene, [0]) == pytest.approx(moment / (0.5 * 0.45), rel=1e-3)


FOOT = 0.05  # of a flat arch on its seats [m]


@pytest.mark.parametrize("planes", ["mid", "cross"])
def test_a_dry_wall_of_stiff_stones_comes_to_rest_although_its_weight_shortens_them_by_nanometres(tmp_path: Path, planes: str) -> None:
    scene = {
        "structure": {"kind": "wall", "length": 2.0, "height": 2.0},
        "material": {"density": 2200.0, "friction": 0.6, "stones": {"kind": "granite", "planes": planes}},
        "run": {"dt": 4e-3, "duration": 0.02},
    }
    run_case(prepare(parse_scene(dump_toml(scene), tmp_path / "wall.toml")), tmp_path / "out")
    with Results.open(tmp_path / "out" / RESULTS) as results:
        assert np.ptp(results.position[:], axis=0).max() < 1e-8


def spread(folder: Path, by: float, strength: float) -> tuple[np.ndarray, np.ndarray]:
    """The thrust [N] of a flat arch, one stone on smooth seats between two abutments that part, by how far they have parted [m]."""
    ends = (-0.5, -FOOT, 0.0, SPAN, SPAN + FOOT, SPAN + 0.5)
    blocks = [
        stone((ends[1], 0.0, -0.2), (ends[2], WIDE, 0.0), "left seat", "base", fixed=True),
        stone((ends[3], 0.0, -0.2), (ends[4], WIDE, 0.0), "right seat", "base", fixed=True),
        stone((ends[0], 0.0, 0.0), (ends[1], WIDE, HIGH), "left", "base", fixed=True),
        stone((ends[4], 0.0, 0.0), (ends[5], WIDE, HIGH), "right", "base", fixed=True),
        stone((ends[1], 0.0, 0.0), (ends[4], WIDE, HIGH), "key", "arch"),
    ]
    scene = {
        "title": "A flat arch",
        "material": {"friction": 0.0, "stones": {"tensile_strength": strength, "young": YOUNG}},
        "loads": [{"kind": "settlement", "supports": "right", "direction": "x", "displacement": by, "start": 0.2, "duration": 1.0}],
        "run": {"dt": 2e-3, "duration": 1.6, "tolerance": 1e-9, "frames_per_second": 100.0},
    }
    with run_in(folder, blocks, scene) as results:
        right = [block.name for block in results.blocks].index("right")
        at = (results.joints.block_a == right) | (results.joints.block_b == right)
        moved = np.asarray(results.position[:, right, 0]) - results.position[0, right, 0]
        return moved, results.joint_history("normal_force")[:, at].sum(axis=1)


def test_a_flat_arch_cracks_when_its_abutments_have_parted_by_the_stretch_at_its_strength_and_stands_on_three_hinges(
    tmp_path: Path,
) -> None:
    # Hinges at the feet and an elastic plane at mid-span: the gap at a height y is d - 2 theta y, so the foot of the plane is stretched
    # by the parting d, and with the moment M at mid-span the thrust is 3 M / (2 h) - k d b h / 4, until k d = f_t. Then the upper part
    # s of the plane is pressed: M / (h - s / 3) = k b d s^2 / (2 (h - s)).
    moment, stiffness = DENSITY * GRAVITY * WIDE * HIGH * (SPAN**2 / 8.0 - FOOT**2 / 2.0), YOUNG / (0.5 * SPAN + FOOT)
    strength = 2e5
    end = strength / stiffness
    parted, thrust = spread(tmp_path, 3.0 * end, strength)
    whole = (parted < 0.9 * end) & (np.arange(len(parted)) > 2)
    assert thrust[whole] == pytest.approx(1.5 * moment / HIGH - stiffness * parted[whole] * WIDE * HIGH / 4.0, rel=0.03)
    per = stiffness * WIDE * parted[-1] / 2.0
    closed = brentq(lambda s: per * s * s / (HIGH - s) * (HIGH - s / 3.0) - moment, 0.0, 0.99 * HIGH)
    assert thrust[-1] == pytest.approx(moment / (HIGH - closed / 3.0), rel=0.02)
    assert thrust[-1] < 1.15 * moment / HIGH  # of three hinges at the edges
    assert json.loads((tmp_path / "summary.json").read_text())["cracked_stones"] == 1


# --- bad input -----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"pieces": 3}, "pieces counts with planes"),
        ({"planes": "cross", "across": "x"}, "across should be two axes"),
        ({"planes": "voronoi", "across": ["x", "x"]}, "across should be different axes"),
        ({"shear_fracture_energy": 5.0}, "needs fracture_energy"),
        ({"young": None}, "needs young"),
        ({"fracture_energy": 1.0}, "no more than its spring stores"),
        ({"cohesion": 1e5}, "above its cohesion over its friction"),
        ({"kind": "granit"}, 'no such kind of stone .did you mean "granite"'),
        ({"tensile_strength": None}, "needs tensile_strength, or the kind of a stone"),
    ],
)
def test_wrong_stones_are_refused_by_their_key(tmp_path: Path, keys: dict[str, Any], message: str) -> None:
    blocks, scene = lintel(0.3, **keys)
    scene["material"]["stones"]["lintel"] = {k: v for k, v in scene["material"]["stones"]["lintel"].items() if v is not None}
    if "planes" in keys and "across" not in keys:
        del scene["material"]["stones"]["lintel"]["across"]
    with pytest.raises(InputError, match=message) as caught:
        run_in(tmp_path, blocks, scene)
    assert "material.stones" in str(caught.value)


def test_pieces_without_a_strength_are_refused(tmp_path: Path) -> None:
    blocks, scene = lintel(0.3)
    del scene["material"]["stones"]
    with pytest.raises(InputError, match="nothing says how strong that is"):
        run_in(tmp_path, [*blocks[:2], replace(blocks[2], stone="beam")], scene)


def test_groups_that_are_none_and_groups_that_cannot_crack_are_refused(tmp_path: Path) -> None:
    blocks, scene = lintel(0.3)
    for group, message in (("lintl", 'material.stones.lintl: "lintl" is not a group'), ("base", "no block of it moves")):
        scene["material"]["stones"] = {group: {"tensile_strength": STRENGTH, "young": YOUNG}}
        with pytest.raises(InputError, match=message):
            run_in(tmp_path, blocks, scene)
