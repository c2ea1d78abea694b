# SPDX-License-Identifier: GPL-3.0-or-later
"""structures.ties and loads.bars: ties hold where their line leaves the masonry, and carry what statics says, up to their yield force."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from models import advance, box, ground

import loads
import structures
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly, Block
from structures import MadeStructure, site
from structures.files import blockfile
from structures.geometry.prism import prism_xz
from structures.ties import TieRowTable, ties_of

G = (0.0, 0.0, -9.81)
WALL = {"kind": "wall", "length": 4.0, "height": 3.0, "course_height": 0.5, "unit_length": 1.0, "thickness": 0.5}
ROD = {"along": "x", "height": 1.25, "diameter": 0.02}


def made(table: dict[str, Any], *ties: dict[str, Any], folder: Path = Path()) -> MadeStructure:
    return structures.make({**table, "ties": list(ties)}, 2000.0, folder)


def two(yield_force: float | None = None) -> list[dict[str, Any]]:
    limit = {} if yield_force is None else {"yield_force": yield_force}
    return [{"along": "x", "height": 0.5, "area": 1e-4, "damping": 0.1, "tension": 0.0, **limit}]


def run(blocks: list[Block], bars: Any, tables: list[dict[str, Any]], dt: float, time: float, mu: float = 0.0) -> Stepper:
    """A run of blocks with ties of a structure and other loads."""
    assembly, steps = Assembly.from_blocks(blocks, mu), round(time / dt)
    loading = loads.build(tables, dt, steps, G, Path(), assembly, ties=[(bar.where, bar.load()) for bar in bars])
    settings = Run.model_validate({"dt": dt, "duration": time, "solver": "nlgs", "tolerance": 1e-9})
    machine = Stepper(assembly, loading.support_velocity, loading.acceleration, settings, forces=loading.forces)
    advance(machine, steps)
    return machine


def test_a_tie_along_a_wall_holds_its_end_blocks_by_their_faces():
    bars = made(WALL, ROD).ties
    assert [bar.blocks for bar in bars] == [("wall.3.1", "wall.3.4")]
    assert bars[0].points == pytest.approx(np.array([[-2.0, 0.0, 1.25], [2.0, 0.0, 1.25]]))
    assert bars[0].keys["area"] == pytest.approx(math.pi * 1e-4)
    (middle,) = made(WALL, {**ROD, "anchor": "middle"}).ties
    assert middle.points[:, 0] == pytest.approx([-1.5, 1.5])
    (below,) = made(WALL, {**ROD, "height": 1.5}).ties  # in a bed joint: the course below
    assert below.blocks == ("wall.3.1", "wall.3.4")


def test_places_across_come_from_numbers_spacing_or_as_given():
    church = {"kind": "church", "block_length": 2.0, "length": 16.0, "width": 8.0, "height": 8.0, "apse": False, "tower": False}
    tie = {"along": "y", "height": 7.3, "parts": ["nave_walls"], "section": [0.2, 0.25], "material": "timber"}
    (one,) = made(church, tie).ties
    assert one.points[:, 0] == pytest.approx([8.0, 8.0])  # the middle of the nave
    assert one.points[:, 1] == pytest.approx([-5.0, 5.0])  # the outer faces
    assert (one.keys["area"], one.keys["modulus"]) == pytest.approx((0.05, 1.1e10))
    for keys, places in (({"number": 2}, [4.0, 12.0]), ({"spacing": 4.0}, [2.0, 6.0, 10.0, 14.0]), ({"at": [3.0, 5.0]}, [3.0, 5.0])):
        bars = made(church, {**tie, **keys}).ties
        assert [bar.points[0, 0] for bar in bars] == pytest.approx(places)
        assert [bar.keys["name"] for bar in bars] == [f"tie1.{k + 1}" for k in range(len(places))]
    (along,) = made(church, {**tie, "along": "x", "parts": ["east_wall", "facade"], "height": 6.2, "at": [-3.0]}).ties
    assert along.points[:, 0] == pytest.approx([0.0, 16.0])  # whichever is named first
    assert along.blocks[0].startswith("facade.")


def test_a_plate_hands_the_pull_on_by_the_area_that_it_covers():
    """0.6 m around a corner of four blocks of 1 m by 0.5 m, off its middle by 0.1 m up: shares 4/12 and 8/12 of the height."""
    wall = {**WALL, "length": 2.0, "thickness": 4.0, "leaves": 4, "through": 100}
    tie = {"along": "x", "height": 1.1, "diameter": 0.02, "plate": 0.6, "tension": 1000.0, "yield_force": 5e3}
    bars = made(wall, {**tie, "at": [0.5]}).ties
    first = {}
    for bar in bars:
        first[bar.blocks[0]] = first.get(bar.blocks[0], 0.0) + bar.keys["area"] / (math.pi * 1e-4)
    assert sum(first.values()) == pytest.approx(1.0)
    by_course = {course: sum(share for name, share in first.items() if name.startswith(f"wall.{course}.")) for course in (2, 3)}
    assert by_course == pytest.approx({2: 4 / 12, 3: 8 / 12})
    assert sum(bar.keys["tension"] for bar in bars) == pytest.approx(1000.0)
    assert sum(bar.keys["yield_force"] for bar in bars) == pytest.approx(5e3)
    assert {bar.keys["name"] for bar in bars} == {"tie1"}


def test_a_structure_in_its_place_takes_its_ties_along():
    tables = [{"name": "a", **WALL, "ties": [ROD]}, {"name": "b", **WALL, "ties": [ROD], "at": [5.0, 9.0, 0.0], "rotate": 90}]
    (a, b) = site.build(tables, 2000.0, Path()).ties
    assert b.points == pytest.approx(np.array([[5.0, 7.0, 1.25], [5.0, 11.0, 1.25]]))
    assert b.blocks == ("b.wall.3.1", "b.wall.3.4")
    assert (a.keys["name"], b.keys["name"], b.where) == ("a.tie1", "b.tie1", "structures[1].ties[0]")


@pytest.mark.parametrize(
    ("tie", "message"),
    [
        ({**ROD, "height": 9.0}, "structure.ties[0].height: no block of the parts stands at z = 9 m"),
        (
            {**ROD, "at": [3.0]},
            "structure.ties[0]: the line along x at y = 3 m, z = 1.25 m meets no block: its end would hold on to nothing",
        ),
        (
            {**ROD, "along": "y"},
            'structure.ties[0]: the line along y at x = 0 m, z = 1.25 m has both ends in block "wall.3.2"; a tie needs',
        ),
        ({**ROD, "parts": ["wal"]}, 'structure.ties[0].parts: "wal" is not a group or block (did you mean "wall"?); groups: wall, base'),
        ({**ROD, "area": 1e-4}, "structure.ties[0]: give exactly one of diameter, area and section"),
        ({**ROD, "number": 2, "spacing": 1.0}, "structure.ties[0]: give one of at, number and spacing"),
        ({**ROD, "plate": 1e5}, "structure.ties[0].plate: 100000 m is so wide that next to nothing of it lies on the wall"),
        ({**ROD, "plate": 3.0}, "structure.ties[0].plate: 3 m is so wide that 15 % of it lies on the wall; at least half has to"),
        ({**ROD, "tension": 2e3, "yield_force": 1e3}, "structure.ties[0]: the tension at the start, 2 kN, must be below yield_force"),
        ({**ROD, "hight": 2}, 'structure.ties[0].hight: unknown key (did you mean "height"?)'),
        ({**ROD, "along": "z"}, "structure.ties[0].along: input should be 'x' or 'y'"),
    ],
)
def test_what_is_wrong_is_named(tie, message):
    with pytest.raises(InputError) as failure:
        made(WALL, tie)
    assert str(failure.value).startswith(message)


def test_two_ties_of_one_name_are_refused():
    with pytest.raises(InputError, match=r'^structure.ties\[1\].name: "rod" is the name of other ties'):
        made(WALL, {**ROD, "name": "rod"}, {**ROD, "name": "rod", "height": 2.25})


def test_a_time_step_too_long_for_a_tie_names_it():
    wall = made(WALL, {"along": "x", "height": 1.25, "area": 0.5})
    with pytest.raises(InputError, match=r"^run.dt: 0.001 s is too long for the 1.63e\+03 Hz of structure.ties\[0\]"):
        run(wall.blocks, wall.ties, [], 1e-3, 0.01)


def pushed(yield_force: float | None, push: float, time: float = 1.0) -> Stepper:
    """Two stones on smooth ground, tied, and pushed apart by a force that grows over half a second."""
    blocks = [ground(20.0), box("a", (-2.0, 0.0, 0.0), (-1.0, 1.0, 1.0)), box("b", (1.0, 0.0, 0.0), (2.0, 1.0, 1.0))]
    bars, _ = ties_of(blocks, [TieRowTable.model_validate(table) for table in two(yield_force)])
    tables = [
        {"kind": "point", "block": name, "force": [sign * push, 0.0, 0.0], "point": [x, 0.5, 0.5], "ramp": 0.5}
        for name, sign, x in (("a", -1, -1.5), ("b", 1, 1.5))
    ]
    return run(blocks, bars, tables, 5e-4, time)


def test_a_tie_between_two_blocks_pushed_apart_bears_the_push():
    machine = pushed(None, 3000.0)
    assert machine.tensions == pytest.approx([3000.0], rel=2e-3)
    stiffness = 2.1e11 * 1e-4 / 4.0
    stretch = np.diff(machine.state.position[1:, 0]) - np.diff(machine.assembly.centre[1:, 0])
    assert stretch == pytest.approx([3000.0 / stiffness], rel=5e-3)
    assert (machine.motion.yielded == 0.0).all()


def test_and_no_more_than_its_yield_force():
    """Beyond it each stone moves on under what is left: the work that the tie takes is its yield force times its lasting stretch."""
    machine = pushed(2000.0, 3000.0)
    assert machine.tensions == [2000.0]
    speed = np.diff(machine.state.velocity[1:, 0])[0]
    since = 0.5 * 2000.0 / 3000.0  # when the push, which grows over 0.5 s, reaches the yield force
    impulse = 0.5 * (0.5 - since) * 1000.0 + 0.5 * 1000.0
    assert speed == pytest.approx(2.0 * impulse / machine.assembly.mass[1], rel=1e-2)
    stretch = np.diff(machine.state.position[1:, 0]) - np.diff(machine.assembly.centre[1:, 0])
    assert machine.motion.yielded == pytest.approx(stretch - 2000.0 * 4.0 / (2.1e11 * 1e-4), rel=1e-2)
    assert abs(machine.energy["balance"]) < 1e-6 * machine.energy["force_work"]


def test_a_yielded_tie_goes_on_from_a_checkpoint_to_the_bit():
    whole = pushed(2000.0, 3000.0)
    loads_ = whole.system.loads
    first, second = (
        Stepper(whole.assembly, loads_.support_velocity, loads_.acceleration, whole.settings, forces=loads_.forces) for _ in range(2)
    )
    advance(first, 1200)
    second.restore({name: array.copy() for name, array in first.snapshot().items()})
    assert second.motion.yielded[0] > 1e-4
    advance(second, 800)
    assert (second.state.position == whole.state.position).all()
    assert (second.motion.yielded == whole.motion.yielded).all()


def test_a_tie_across_the_springings_bears_the_thrust_of_an_arch(tmp_path):
    """Two rafters on smooth feet lean on one another: H = W x / rise, between the extremes of the line of thrust at foot and crown."""
    left = Block("left", *prism_xz(np.array([[-2.0, 0.0], [-1.4, 0.0], [0.0, 1.6], [0.0, 2.2]]), 0.0, 0.5), 2000.0)
    right = Block("right", *prism_xz(np.array([[2.0, 0.0], [0.0, 2.2], [0.0, 1.6], [1.4, 0.0]]), 0.0, 0.5), 2000.0)
    feet = [box(f"foot{k}", (x - 1.0, 0, -0.5), (x + 1.0, 0.5, 0), fixed=True) for k, x in ((1, -2.0), (2, 2.0))]
    blockfile.write(tmp_path / "blocks.json", [*feet, left, right])
    tie = {"along": "x", "height": 0.05, "area": 4e-4, "damping": 0.1, "parts": ["left", "right"]}
    blocks, _, bars, *_ = made({"kind": "file", "path": "blocks.json"}, tie, folder=tmp_path)
    assert [bar.blocks for bar in bars] == [("left", "right")]
    held = run(blocks, bars, [], 2e-4, 0.4)
    assert np.abs(held.state.position - held.assembly.centre).max() < 2e-3
    weight, arm = held.assembly.mass[3] * 9.81, held.assembly.centre[3, 0]
    thrust = [weight * (foot - arm) / (crown - 0.05) for foot, crown in ((1.4, 2.2), (2.0, 1.6))]
    assert thrust[0] < held.tensions[0] < thrust[1]
