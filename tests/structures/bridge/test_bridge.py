# SPDX-License-Identifier: GPL-3.0-or-later
"""Bridges: their volumes against closed forms, their joints, their fill, and what does not fit together."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_run import shifted, write_run

import structures
from masonry_cd.app.limit_structure import limit_structure
from masonry_cd.app.scene import parse_scene
from masonry_cd.app.scene_text import dump_toml
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.limit.case import limit_case
from masonry_cd.mechanics.contact.find_joints import built_gap, find_joints
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.fill import CoveredFaces
from masonry_cd.mechanics.model.geometry import mass_properties
from masonry_cd.mechanics.model.state import State
from reports.drawing.solids import fill_layer, structure_scene
from reports.maps.crack_map import MapSubject, crack_scene
from reports.maps.framing import MapStyle, framing
from structures import MadeStructure
from structures.geometry.checks import check

SPAN = {"span": 6.0, "rise": 1.5, "thickness": 0.5, "voussoirs": 12}
SHAPES = (
    {"span": 4.0, "rise": 1.0, "thickness": 0.4, "voussoirs": 11},
    {"span": 8.0, "shape": "semicircular", "thickness": 0.5, "voussoirs": 20},
    {"span": 6.0, "shape": "elliptical", "rise": 2.0, "thickness": 0.5, "rings": 2, "voussoirs": 15},
    {"span": 4.0, "shape": "pointed", "rise": 2.6, "thickness": 0.4, "voussoirs": 14},
)
WALLS = {"course_height": 0.5, "unit_length": 1.0}


def made(*spans: dict, **keys: object) -> MadeStructure:
    return structures.make({"kind": "bridge", "spans": list(spans or (SPAN,)), **keys}, 2000.0, Path())


def volume(blocks: list[Block]) -> float:
    return sum(mass_properties(block.vertices, block.faces).volume for block in blocks)


def of(bridge: MadeStructure, group: str) -> list[Block]:
    return [block for block in bridge.blocks if block.group.startswith(group)]


@pytest.mark.parametrize("skew", [0.0, 30.0])
@pytest.mark.parametrize("rings", [1, 3])
def test_ring_has_the_volume_of_its_circle_however_it_is_cut_and_slanted(skew: float, rings: int) -> None:
    bridge = made({**SPAN, "rings": rings}, width=3.0, skew=skew, strips=2)
    inner = (3.0**2 + 1.5**2) / (2.0 * 1.5)
    half, outer = 2.0 * math.atan2(1.5, 3.0), inner + 0.5
    exact = 12 * 0.5 * (outer**2 - inner**2) * math.sin(2.0 * half / 12) * 3.0
    assert volume(of(bridge, "arch1")) == pytest.approx(exact, rel=1e-12)


def test_ellipse_has_its_span_rise_and_area() -> None:
    bridge = made({"span": 6.0, "shape": "elliptical", "rise": 2.0, "thickness": 0.4, "voussoirs": 200}, width=1.0)
    corners = np.concatenate([block.vertices for block in of(bridge, "arch1")])
    assert corners[:, 2].max() == pytest.approx(2.4, abs=1e-12)
    assert (corners[:, 0].min(), corners[:, 0].max()) == pytest.approx((-0.4, 6.4), abs=1e-12)
    # between an ellipse and its parallel at distance t: t times half the circumference, and half a circle of radius t
    h = ((3.0 - 2.0) / (3.0 + 2.0)) ** 2
    around = math.pi * 5.0 * (1.0 + 3.0 * h / (10.0 + math.sqrt(4.0 - 3.0 * h)))
    assert volume(of(bridge, "arch1")) == pytest.approx(0.4 * 0.5 * around + 0.5 * math.pi * 0.4**2, rel=2e-4)


def test_thickness_grows_evenly_from_the_crown_to_the_springings() -> None:
    bridge = made({**SPAN, "thickness_springing": 0.8}, width=1.0)
    joints = [block.vertices for block in of(bridge, "arch1")]
    crown = max(float(v[:, 2].max()) for v in joints) - 1.5
    first = joints[0][joints[0][:, 1] < 0.0][:, [0, 2]]
    widths = sorted(float(np.hypot(*(a - b))) for i, a in enumerate(first) for b in first[:i])
    assert crown == pytest.approx(0.5, abs=1e-12)
    assert any(width == pytest.approx(0.8, abs=1e-12) for width in widths)


@pytest.mark.parametrize(("first", "second"), list(pairwise([*SHAPES, SHAPES[0]])))
@pytest.mark.parametrize("skew", [0.0, -40.0])
def test_any_two_shapes_stand_on_a_pier_with_walls_that_fill_the_space_up_to_the_road(first: dict, second: dict, skew: float) -> None:
    bridge = made(first, second, width=4.0, skew=skew, walls={**WALLS, "thickness": 0.5}, piers=[{"width": 1.6, "height": 2.0}], cover=0.35)
    assembly = Assembly.from_blocks(bridge.blocks, 0.6)
    assert built_gap(assembly) < 1e-9
    joints = find_joints(assembly)
    assert set(np.flatnonzero(~assembly.fixed)) <= {*joints.block_a.tolist(), *joints.block_b.tolist()}  # each block stands on something
    filled = sum(block.carried.mass for block in bridge.blocks if block.carried) / 2000.0
    (fill,) = bridge.fills
    fixed = [f for f in fill.faces if f.kind == "top" and f.block.startswith("abutment")]
    over = sum(abs(f.area[2]) * f.pressed(fill.level)[0] for f in fixed)  # on abutments, which do not move
    # between the walls, 3 m wide, there is as much fill as each wall, 0.5 m thick, has stones
    assert volume(of(bridge, "spandrel_front")) == pytest.approx((filled + over) * 0.5 / 3.0, rel=1e-9)


def stepped(step: float) -> tuple[list[Block], set[tuple[str, str]]]:
    """The stones of a pier from the foot up, between two springings that differ, and the names of blocks that meet."""
    low, high = max(-step, 0.0), max(step, 0.0)
    other = {"span": 4.4, "rise": 1.3, "thickness": 0.45, "voussoirs": 15, "springing": high}
    bridge = made({**SPAN, "springing": low}, other, piers=[{"width": 1.6, "height": 3.0}], walls={**WALLS, "thickness": 0.5}, width=4.0)
    pier = sorted(of(bridge, "pier1"), key=lambda block: float(block.vertices[:, 2].min()))
    assert len({block.name for block in pier}) == len(pier)
    assembly = Assembly.from_blocks(bridge.blocks, 0.6)
    assert built_gap(assembly) < 1e-9
    joints, names = find_joints(assembly), assembly.names
    return pier, {(names[a], names[b]) for a, b in zip(joints.block_a.tolist(), joints.block_b.tolist(), strict=True)}


@pytest.mark.parametrize(("first", "second"), list(pairwise([*SHAPES, SHAPES[0]])))
@pytest.mark.parametrize("step", [0.01, 0.3, -0.8, 1.3])
def test_a_pier_between_springings_that_differ_is_sound_for_any_two_shapes(first: dict, second: dict, step: float) -> None:
    low, high = max(-step, 0.0), max(step, 0.0)
    keys = {"piers": [{"width": 1.6, "height": 3.0}], "walls": {**WALLS, "thickness": 0.5}, "width": 4.0}
    bridge = made({**first, "springing": low}, {**second, "springing": high}, **keys)
    check(bridge.blocks)
    pier = of(bridge, "pier1")
    assert min(float(np.ptp(block.vertices[:, 2])) for block in pier) > 0.25 * 0.3  # no slabs: a course is 0.3 m high
    assembly = Assembly.from_blocks(bridge.blocks, 0.6)
    assert built_gap(assembly) < 1e-9
    joints = find_joints(assembly)
    beds = np.abs(joints.normal[:, 2]) > 0.5
    on_bed = {*joints.block_a[beds].tolist(), *joints.block_b[beds].tolist()}
    assert {assembly.names.index(block.name) for block in pier} <= on_bed


def neighbours(pairs: set[tuple[str, str]], name: str) -> set[str]:
    return {b if a == name else a for a, b in pairs if name in (a, b)}


@pytest.mark.parametrize("step", [0.3, -0.8, 1.6])
def test_level_courses_lie_between_two_skewbacks_each_of_which_has_a_stone_of_its_own(step: float) -> None:
    pier, pairs = stepped(step)
    first, last = ("arch1.v12", "arch2.v1") if step > 0.0 else ("arch2.v1", "arch1.v12")  # on the lower and on the higher springing
    (lower,) = [block for block in pier if first in neighbours(pairs, block.name)]
    assert last in neighbours(pairs, pier[-1].name) and lower is not pier[-1]
    for below, above in pairwise(pier):
        assert not above.parts
        bed = above.vertices[np.abs(above.vertices[:, 2] - above.vertices[:, 2].min()) < 1e-9]
        on = below.vertices[np.abs(below.vertices[:, 2] - bed[0, 2]) < 1e-9]
        assert (bed.min(axis=0) > on.min(axis=0) - 1e-9).all() and (bed.max(axis=0) < on.max(axis=0) + 1e-9).all()
        assert np.ptp(above.vertices[:, 2]) > 0.2 and np.ptp(bed[:, 0]) > 0.7  # of courses of 0.5 m


def test_two_skewbacks_next_to_each_other_are_cut_from_one_stone_with_a_bed_of_the_whole_pier() -> None:
    pier, pairs = stepped(0.05)
    top = pier[-1]
    bed = top.vertices[np.abs(top.vertices[:, 2] - top.vertices[:, 2].min()) < 1e-9]
    assert np.ptp(bed, axis=0) == pytest.approx([1.6, 4.0, 0.0], abs=1e-9)
    assert {"arch1.v12", "arch2.v1"} <= neighbours(pairs, top.name)


def test_fill_rides_on_the_blocks_below_it_as_one_body_with_them() -> None:
    bridge = made(SPAN, width=2.0, cover=0.3)
    plain = {block.name: mass_properties(block.vertices, block.faces) for block in bridge.blocks}
    block = next(block for block in bridge.blocks if block.name == "arch1.v1")
    own, whole = plain["arch1.v1"], block.mass_properties
    assert block.carried is not None
    assert block.density * whole.volume == pytest.approx(2000.0 * own.volume + block.carried.mass)
    assert whole.centre[2] > own.centre[2]
    assembly = Assembly.from_blocks(bridge.blocks, 0.6)
    number = assembly.names.index("arch1.v1")
    assert assembly.volume[number] == pytest.approx(own.volume)
    turn = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    moved = assembly.placed(assembly.centre + 1.0, np.broadcast_to(turn, (assembly.count, 3, 3)))
    again = moved.blocks[number].mass_properties
    assert again.centre == pytest.approx(assembly.centre[number] + 1.0)
    assert again.unit_inertia * 2000.0 == pytest.approx(moved.inertia[number])
    extrados = sum(abs(f.area[2]) * f.pressed(bridge.fills[0].level)[0] for f in bridge.fills[0].faces if f.kind == "extrados")
    assert sum(b.carried.mass for b in bridge.blocks if b.carried) == pytest.approx(2000.0 * extrados)


@pytest.mark.parametrize("walls", [None, {**WALLS, "thickness": 0.5}])
def test_pictures_show_all_of_the_fill(walls: dict | None) -> None:
    bridge = made(SPAN, width=2.0, cover=0.3, skew=15.0, walls=walls)
    fill = CoveredFaces.of(bridge.fills, [block.name for block in bridge.blocks])
    layer = fill_layer(fill, lambda points, block: points, len(bridge.blocks))
    volume = 0.0  # by the divergence theorem, as a sum of tetrahedra
    for first, end in pairwise(layer.loop_start.tolist()):
        a, *rest = layer.points[layer.loops[first:end]]
        volume += sum(float(a @ np.cross(b, c)) for b, c in pairwise(rest)) / 6.0
    faces = [face for face in bridge.fills[0].faces if face.kind in ("extrados", "top")]
    assert volume == pytest.approx(sum(abs(f.area[2]) * f.pressed(bridge.fills[0].level)[0] for f in faces), rel=1e-9)
    scene = structure_scene(bridge.blocks, "bridge", fills=bridge.fills)
    x, y = scene.view.plane(layer.points).T
    assert scene.window.left < x.min() < x.max() < scene.window.right and scene.window.bottom < y.min() < y.max() < scene.window.top


def test_maps_of_a_run_show_the_fill_where_the_blocks_below_it_are(tmp_path: Path) -> None:
    bridge = made(SPAN, width=2.0, cover=0.3)
    assembly, by = Assembly.from_blocks(bridge.blocks, 0.6), np.array([0.1, 0.0, -0.05])
    rest, crown = State.at_rest(assembly), assembly.names.index("arch1.v6")
    path = write_run(tmp_path / "result.h5", bridge.blocks, [rest, shifted(rest, crown, by)], fills=bridge.fills)
    with Results.open(path) as results:
        fill, wanted = results.fill, CoveredFaces.of(bridge.fills, assembly.names)
        assert fill is not None and all(np.array_equal(got, own) for got, own in zip(fill, wanted, strict=True))
        framed = framing(results, [0, 1], MapStyle(scale=1.0))
        first, last = (MapSubject.of(results, k, framed).fill for k in (0, 1))
        assert any(layer.inside is not None and layer.owner is not None for layer in crack_scene(results, 1, framed).layers[3:])
    moved = last.points - first.points
    on_crown = np.tile(np.repeat(fill.block, np.diff(fill.start)) == crown, 2)
    assert moved[on_crown] == pytest.approx(np.broadcast_to(by, moved[on_crown].shape), abs=1e-12) and not moved[~on_crown].any()
    x, y = framed.view.plane(first.points).T
    assert framed.window.left < x.min() < x.max() < framed.window.right and framed.window.bottom < y.min() < y.max() < framed.window.top


def test_fill_that_lies_on_no_block_is_not_drawn(tmp_path: Path) -> None:
    bridge = made(SPAN, width=2.0, cover=0.3)
    bare, rest = [replace(fill, faces=()) for fill in bridge.fills], State.at_rest(Assembly.from_blocks(bridge.blocks, 0.6))
    with Results.open(write_run(tmp_path / "result.h5", bridge.blocks, [rest], fills=bare)) as results:
        assert results.fill is None and MapSubject.of(results, 0, framing(results, [0], MapStyle(scale=1.0))).fill is None
    assert len(structure_scene(bridge.blocks, "", fills=bare).layers) == len(structure_scene(bridge.blocks, "").layers)


def test_a_result_whose_fill_has_no_level_is_refused(tmp_path: Path) -> None:
    bridge = made(SPAN, width=2.0, cover=0.3)
    broken, rest = [replace(fill, level=np.nan) for fill in bridge.fills], State.at_rest(Assembly.from_blocks(bridge.blocks, 0.6))
    path = write_run(tmp_path / "result.h5", bridge.blocks, [rest], fills=broken)
    with pytest.raises(InputError, match="blocks/fill_corners"):
        Results.open(path)


def test_a_strip_without_walls_is_its_own_mirror_image_and_stands_on_one_foot_to_a_pier() -> None:
    from masonry_cd.mechanics.model.middle_plane import middle_plane

    bridge = made(SPAN, SPAN, SPAN, piers=[{"height": 4.0}], abutments=[{"rigid": False, "height": 2.0}])
    assert middle_plane(Assembly.from_blocks(bridge.blocks, 0.6), 1) == pytest.approx(0.0, abs=1e-12)
    assert sorted(b.name for b in bridge.blocks if b.fixed) == ["foot_abutment1", "foot_abutment2", "foot_pier1", "foot_pier2"]
    assert {f.kind for f in bridge.fills[0].faces} == {"extrados", "top", "back"}
    backs = [f.area for f in bridge.fills[0].faces if f.kind == "back"]
    assert sum(a[0] < 0 for a in backs) == sum(a[0] > 0 for a in backs) > 0  # into the fill behind either abutment


def test_wings_and_parapets_stand_next_to_abutments_of_both_kinds() -> None:
    walls = {**WALLS, "wing_length": 2.0, "parapet_height": 1.0, "parapet_thickness": 0.3}
    bridge = made(SPAN, walls=walls, abutments=[{"rigid": True}, {"rigid": False, "height": 2.0}], cover=0.4)
    assembly = Assembly.from_blocks(bridge.blocks, 0.6)
    find_joints(assembly)
    deck = bridge.fills[0].level
    assert volume(of(bridge, "wing1")) == pytest.approx(2 * 2.0 * 0.4 * deck)
    assert volume(of(bridge, "wing2")) == pytest.approx(2 * 2.0 * 0.4 * (deck + 2.0))
    assert volume(of(bridge, "parapet")) == pytest.approx(2 * 0.3 * 1.0 * (6.0 + 2 * 1.5 + 2 * 2.0))


@pytest.mark.parametrize(
    ("spans", "keys", "words"),
    [
        (
            [{**SPAN, "rise": 3.5}, {**SPAN, "thickness": 3.2}, {**SPAN, "shape": "pointed"}],
            {"cover": 0.2, "deck": 4.0},
            ["spans[0].rise: of a segmental span must be at most half the span, 3 m", "spans[1].thickness", "spans[2].rise: of a pointed",
             "structure.deck: give"],
        ),
        (
            [SPAN, {**SPAN, "start": 5.0}, {**SPAN, "start": 9.0}],
            {},
            ["spans[1].start: span 2 begins at x = 5 m, where a span before it reaches to x = 6 m", "spans[2].start: span 3"],
        ),
        (
            [SPAN, {**SPAN, "rise": 2.5}],
            {"deck": 1.9, "piers": [{"width": 3.0}]},
            ["structure.deck: the fill ends at 1.9 m, which must be 0.02 m or more above the extrados of span 1, 2 m at x = 3 m", "span 2"],
        ),
        ([SPAN, SPAN], {"piers": [{"width": 0.3}]}, ["structure.piers[0].width: pier1, from x = 6 to 6.3 m, must be wider"]),
        ([SPAN, SPAN], {"piers": [{}, {}]}, ["structure.piers: one for all, or one between each two of 2 spans, 1; got 2"]),
        (
            [SPAN, {**SPAN, "rise": 3.5, "start": 5.0}, {**SPAN, "start": 20.0}],
            {"deck": 1.9, "width": 0.7, "walls": WALLS, "piers": []},
            ["spans[1].rise: of a segmental span must be at most half the span", "structure.piers: one for all, or one between each two",
             "spans[1].start: span 2 begins at x = 5 m", "extrados of span 1, 2 m at x = 3 m", "extrados of span 3, 2 m at x = 23 m",
             "structure.walls.thickness: two of 0.4 m leave no road"],
        ),
        (
            [{"span": 6.0, "shape": "pointed", "rise": 3.2, "thickness": 1.0, "voussoirs": 400}, {**SPAN, "start": 5.0}],
            {},
            ["spans[0].voussoirs: too many for the joint at the apex, got 400", "spans[1].start: span 2 begins at x = 5 m"],
        ),
        ([SPAN], {"backing": {"height": 2.1}}, ["structure.backing.height: must be between 0.32 m"] * 2),
        ([SPAN], {"width": 0.7, "walls": WALLS}, ["structure.walls.thickness: two of 0.4 m leave no road"]),
    ],
)  # fmt: skip
def test_all_faults_are_named_by_span_and_place_a_line_each(spans: list[dict], keys: dict, words: list[str]) -> None:
    with pytest.raises(InputError) as failure:
        made(*spans, **keys)
    assert len(failure.value.lines) == len(words)
    for line, said in zip(failure.value.lines, words, strict=True):
        assert said in line


def test_a_scene_names_file_and_line_of_each_fault(tmp_path: Path) -> None:
    from masonry_cd.app.case import structure_of
    from masonry_cd.app.scene import parse_scene

    text = """title = "b"
[structure]
kind = "bridge"
[[structure.spans]]
span = 4.0
rise = 3.0
thickness = 0.4
[[structure.spans]]
span = 4.0
thickness = 0.4
[material]
density = 2000.0
friction = 0.6
[run]
dt = 1e-3
duration = 1.0
"""
    with pytest.raises(InputError) as failure:
        structure_of(parse_scene(text, tmp_path / "b.toml"))
    first, second = str(failure.value).split("\n")
    assert "b.toml:6: structure.spans[0].rise" in first
    assert "structure.spans[1].rise: missing" in second


def test_two_bridges_side_by_side_keep_their_fill_in_place() -> None:
    from structures import site

    own = {"kind": "bridge", "spans": [SPAN], "width": 2.0, "cover": 0.3}
    one = structures.make(own, 2000.0, Path())
    two = site.build([{**own, "name": "a"}, {**own, "name": "b", "at": [0.0, 50.0, 1.0], "rotate": 90.0}], 2000.0, Path())
    moved = two.fills[1]
    assert moved.level == pytest.approx(one.fills[0].level + 1.0)
    local = moved.along(moved.faces[0].corners)
    assert local - [0.0, 0.0, 1.0] == pytest.approx(one.fills[0].faces[0].corners)
    masses = [Assembly.from_blocks(blocks, 0.6).mass.sum() for blocks in (two.blocks,)]
    centre = next(b for b in two.blocks if b.name == "b.arch1.v1").mass_properties.centre
    x, y, z = next(b for b in one.blocks if b.name == "arch1.v1").mass_properties.centre
    assert masses[0] > 0.0
    assert centre == pytest.approx([-y, 50.0 + x, 1.0 + z])


def test_spans_piers_walls_and_parapets_are_its_parts_by_name() -> None:
    from structures.macro_elements import macro_elements

    bridge = made(
        {**SPAN, "rings": 2}, SPAN, walls={**WALLS, "wing_length": 2.0, "parapet_height": 0.9}, piers=[{"height": 4.0}], cover=0.4
    )
    parts = {part.name: part for part in macro_elements(bridge.blocks, structures.KINDS["bridge"].parts)}
    sides = [f"{what} {side}" for what in ("spandrel", "wing1", "wing2") for side in ("front", "back")]
    assert set(parts) == {"span arch1", "span arch2", "pier1", *sides, "parapet_front", "parapet_back"}
    rings = {bridge.blocks[b].group for b in parts["span arch1"].blocks}
    assert rings == {"arch1_ring1", "arch1_ring2"}


BACKED = {"span": 5.0, "rise": 2.5, "thickness": 0.5, "voussoirs": 101}


@pytest.mark.parametrize("skew", [0.0, 30.0])
def test_backing_fills_the_haunches_up_to_its_level_and_bears_the_fill_above(skew: float) -> None:
    """Next to half a circle of radius r the area up to h is that of a rectangle less half the segment between its middle and h."""
    bridge = made(BACKED, width=2.0, skew=skew, cover=0.4, backing={"height": 1.2, "density": 1500.0})
    area = 1.2 * (1.5 + 2.5) - 0.5 * (1.2 * math.sqrt(3.0**2 - 1.2**2) + 3.0**2 * math.asin(1.2 / 3.0))
    for block in of(bridge, "backing"):
        assert volume([block]) == pytest.approx(2.0 * area, rel=1e-3) and block.density == 1500.0
    (fill,) = bridge.fills
    plan = sum(face.area[2] for face in fill.faces if face.kind in ("extrados", "top"))
    assert plan == pytest.approx(2.0 * (fill.deck[1] - fill.deck[0]), rel=1e-9)  # fill lies on all of it once
    assert min(face.corners[:, 2].min() for face in fill.faces if face.kind in ("extrados", "top")) == pytest.approx(1.2)
    assert {face.block for face in fill.faces if face.kind == "back"} == {"backing.abutment1", "backing.abutment2"}
    weight = sum(block.carried.mass for block in bridge.blocks if block.carried)
    inside = 0.5 * math.pi * 3.0**2 + 2.0 * area
    assert weight == pytest.approx(2000.0 * 2.0 * (3.4 * (fill.deck[1] - fill.deck[0]) - inside), rel=1e-3)


def test_backing_is_pushed_off_its_abutment_at_the_friction_of_what_it_weighs_and_bears() -> None:
    """Below a coefficient of one the arch that leans on it helps it no more to stay than to go."""
    keys = {"kind": "bridge", "spans": [{**BACKED, "voussoirs": 21}], "width": 2.0, "backing": {"height": 1.2}}
    scene = {
        "structure": {**keys, "fill": {"passive": 0.0, "pressure": "none"}},
        "material": {"density": 2000.0, "friction": 0.5},
        "loads": [{"kind": "point", "block": "backing.abutment1", "force": [-1e3, 0.0, 0.0], "point": [-1.0, 0.0, 0.0]}],
        "limit": {"live": [0]},
    }
    case = limit_case(parse_scene(dump_toml(scene), Path("bridge.toml")))
    block = next(block for block in case.structure.made.blocks if block.name == "backing.abutment1")
    assert block.carried is not None and case.whole is not None
    bears = 0.5 * 9.81 * (2000.0 * volume([block]) + block.carried.mass)
    assert case.whole.analysis.governing.factor == pytest.approx(bears / 1e3, rel=1e-6)


def test_joints_of_a_bridge_crush_at_the_strength_of_its_kind_of_masonry() -> None:
    def strength(**keys: Any) -> float:
        scene = {
            "structure": {"kind": "bridge", "spans": [SPAN]}, "material": {"masonry": {"kind": "solid brick", **keys}, "friction": 0.6},
            "limit": {"push": "x"},
        }  # fmt: skip
        return float(limit_structure(parse_scene(dump_toml(scene), Path("bridge.toml"))).assembly.laws.crushing.max())

    assert strength() == pytest.approx(3.45e6)
    assert strength(crushing=False) == 0.0
