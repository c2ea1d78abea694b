# SPDX-License-Identifier: GPL-3.0-or-later
"""Values in another unit draw one line that names key, value, both readings and how to confirm it; usual ones draw none."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from models import box
from places import EXAMPLES
from pydantic import BaseModel
from small_runs import FROM_FILE

import loads
from masonry_cd.app.case import prepare, structure_of
from masonry_cd.app.doubts import doubts, structure_doubts
from masonry_cd.app.record_doubts import unusual_pga
from masonry_cd.app.scene import Scene, parse_scene, read_scene
from masonry_cd.app.starters import starter
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.units import Declared, declared_at
from masonry_cd.limit.case import limit_case
from masonry_cd.limit.facts import facts
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.materials import Material
from structures import KINDS
from structures.tables import CommonTable

ROOT = EXAMPLES.parent
TEXT = f"""{FROM_FILE}
[material]
density = 2000.0
friction = 0.6
[run]
dt = 1e-3
duration = 1.0
[limit]
push = "x"
"""
# a support and a stone of 2 t that is 1 m high
PAIR = Assembly.from_blocks([box("base", (0, 0, -1), (1, 1, 0), fixed=True), box("stone", (0, 0, 0), (1, 1, 1))], 0.6)


def lines(*changes: str, summaries: tuple[dict[str, Any], ...] = ()) -> list[str]:
    return doubts(parse_scene(TEXT, Path("scene.toml"), changes), PAIR, find_joints(PAIR), summaries)


CHECK = 'limit.check={spectrum="EC8", ag=0.25}'
CASES = [
    (CHECK, "limit.check.ag = 0.25 m/s2 is 0.0255 g: ", 'for g write "0.25 g"'),
    ('loads=[{kind="record", target_pga=0.3, path="a", direction="x"}]', "loads[0].target_pga = 0.3 m/s2 is 0.0306 g: ", '"0.3 g"'),
    ('loads=[{kind="settlement", supports="base", displacement=30, duration=100}]', "loads[0].displacement = 30 m is 30 ", '"30 mm"'),
    ('loads=[{kind="settlement", supports="base", displacement=0.08, duration=0.1}]', "loads[0].displacement = 0.08 m is", "strike"),
    ('loads=[{kind="point", block="stone", force=[0, 0, -40.0]}]', "loads[0].force = 40 N is 0.002 times the", 'for kN write "40 kN"'),
    ('loads=[{kind="point", block="stone", force=[0, 0, -4e8]}]', "loads[0].force = 4e+08 N is 400 MPa on its block", "30 MPa"),
    ('loads=[{kind="point", block="stone", force=[0, 0, -2e7]}]', "loads[0].force = 2e+07 N is 1.02e+03 times ", "proof loads"),
    ("material.density=1.9", "material.density = 1.9 kg/m3: ", 'for t/m3 write "1.9 t/m3"'),
    ("material.density=19.0", "material.density = 19 kg/m3: ", 'for kN/m3 write "1937 kg/m3"'),
    ("material.friction=1.5", "material.friction = 1.5: ", "tangent"),
    ("material.friction={default = 0.6, base-block = 1.5}", "material.friction.base-block = 1.5: ", "tangent"),
    ('material={density=2000.0, friction=0.6, deformable="uniform", young=1500.0}', "material.young = 1500 Pa: ", '"1500 MPa"'),
    ("material.joints={normal_stiffness=20.0}", "material.joints.normal_stiffness = 20 N/m3: ", '"20 N/mm3"'),
    ('structure.ties=[{along="x", height=1.0, diameter=0.03, yield_force=160}]', "structure.ties[0].yield_force = 160 N is", '"160 kN"'),
    ('structure.ties=[{along="x", height=1.0, diameter=30, yield_force=1e8}]', "structure.ties[0].diameter = 30 m: ", '"30 mm"'),
    ('loads=[{kind="tie", blocks=["base", "stone"], area=7e-4, tension=40.0}]', "loads[0].tension = 40 N is 0.057 MPa", '"40 kN"'),
    ('loads=[{kind="point", block="st*", force=[0, 0, -40.0]}]', "loads[0].force = 40 N is 0.002 times the", '"40 kN"'),
    ('structure.ties=[{along="x", height=1.0, section=[20, 25]}]', "structure.ties[0].section[0] = 20 m: ", 'for mm write "20 mm"'),
    ("run.gravity=[0, 0, -1.0]", "run.gravity = 1 m/s2 is 0.102 g: ", 'for g write "1 g"'),
    ('structure={kind="church", roof_mass=1.2}', "structure.roof_mass = 1.2 kg/m2: ", 'for kN/m2 write "122.4 kg/m2"'),
    ('structure={kind="building", roofs=[{mass=1.5}]}', "structure.roofs[0].mass = 1.5 kg/m2: ", 'for kN/m2 write "153 kg/m2"'),
    ("structure.floors=[{height=3.0, mass=4.0}]", "structure.floors[0].mass = 4 kg/m2: ", 'for kN/m2 write "407.9 kg/m2"'),
    ('loads=[{kind="vehicle", axles=[100, 100], spacing=[2.0]}]', "loads[0].axles[0] = 100 N: ", 'for kN write "100 kN"'),
    ('loads=[{kind="push", control="displacement", direction="x", blocks="stone", targets=[0.1,-0.5]}]',
     "loads[0].targets[1] = -0.5 m", '"-0.5 mm"'),
    ('structure={kind="bridge", fill={friction_angle=0.6}}', "structure.fill.friction_angle = 0.6 degrees: ", '"0.6 rad"'),
    ('limit.check={spectrum="NTC", tc_star=300}', "limit.check.tc_star = 300 s: ", 'for ms write "300 ms"'),
    ("structure.ties=[{along='x', height=1.0, area=314}]", "structure.ties[0].area = 314 m2: ", '"314 cm2"; for mm2 write "314 mm2"'),
    ('limit.check={spectrum="EC8", behaviour_factor=4.0}', "limit.check.behaviour_factor = 4: ", "2 at the most"),
    ("material.density=1.9 kg/m3", "material.density = 1.9 kg/m3: ", 'for t/m3 write "1.9 t/m3"'),  # a text with a unit is judged alike
]  # fmt: skip


@pytest.mark.parametrize(("change", "begins", "holds"), CASES, ids=[change[:50] for change, _, _ in CASES])
def test_a_value_in_another_unit_draws_one_line_and_none_where_it_is_meant_so(change: str, begins: str, holds: str) -> None:
    (line,) = lines(change)
    assert line.startswith(begins)
    key = begins.partition(" = ")[0]
    assert holds in line
    assert line.endswith(f'if it is intended, set quiet_checks = ["{key}"]')
    assert lines(change, f'quiet_checks=["{key}"]') == []
    assert lines(change, 'quiet_checks=["run.dt"]') == [line]


SENSES = [
    ('limit.check={code="EC8", spectrum="NTC", behaviour_factor=2.0}', "limit.check.spectrum"),
    ('loads=[{kind="settlement", supports="base", displacement=0.01, duration=10, direction="z"}]', "loads[0].displacement"),
    ('loads=[{kind="settlement", supports="base", displacement=-0.01, duration=10}]', "loads[0].displacement"),
    ('loads=[{kind="settlement", supports="base", displacement=-0.01, duration=10, direction="z"}]', ""),
    ("run.gravity=[0, -9.81, 0]", "run.gravity"),
    ("run.gravity=[0, 0, 9.81]", "run.gravity"),
    ("run.gravity=[3.0, 0, -9.34]", ""),  # a table that is tilted by 18 degrees
    ('loads=[{kind="point", block="stone", force=[0, 0, 4e3]}]', "loads[0].force"),
    ('loads=[{kind="point", block="stone", force=[4e3, 0, 1e3]}]', ""),
    ('limit.push="z"', "limit.push"),
    ("limit.push=[1, 0, 0.5]", ""),
]  # fmt: skip


@pytest.mark.parametrize(("change", "key"), SENSES, ids=[change[:60] for change, _ in SENSES])
def test_what_points_the_wrong_way_or_is_of_another_code_draws_one_line(change: str, key: str) -> None:
    found = lines(change)
    assert [line.startswith(key) for line in found] == [True] * bool(key)
    if key:
        assert lines(change, f'quiet_checks=["{key}"]') == []


@pytest.mark.parametrize(("gap", "said"), [(0.0, False), (1e-5, False), (2e-3, True), (4e-3, True), (0.01, False), (0.05, False)])
def test_a_head_joint_that_gapes_is_named_with_its_blocks(gap: float, said: bool) -> None:
    """Two stones side by side on one bed; a joint of mortar that was left out, or an intended gap."""
    stones = [box("left", (0, 0, 0), (1, 1, 1)), box("right", (1 + gap, 0, 0), (2, 1, 1))]
    apart = Assembly.from_blocks([box("base", (0, 0, -1), (2, 1, 0), fixed=True), *stones], 0.6)
    found = doubts(parse_scene(TEXT, Path("scene.toml")), apart, find_joints(apart))
    assert ['"left"' in line and '"right"' in line and line.startswith("structure: ") for line in found] == [True] * said
    assert doubts(parse_scene(TEXT, Path("scene.toml"), ['quiet_checks=["structure"]']), apart, find_joints(apart)) == []


def test_the_key_that_silences_the_record_of_a_shock_is_one_of_the_scene() -> None:
    load = 'loads=[{kind="sequence", shocks=[{components=[{path="a", direction="x"}]}]}]'
    weak = ({"shocks": [{"factor": 1.0, "start": 0.0, "end": 2.0, "components": [{"after": {"pga": 0.02}}]}]},)
    (line,) = lines(load, summaries=weak)
    assert line.startswith("loads[0].shocks[0].components makes a PGA")
    assert lines(load, 'quiet_checks=["loads[0].shocks[0].components"]', summaries=weak) == []


def test_zero_leaves_something_out_and_is_never_doubted() -> None:
    assert lines("material.joints={cohesion=0.0}", 'loads=[{kind="point", block="stone", force=[0, 0, 0]}]') == []


@pytest.mark.parametrize(("amplitude", "pga", "said"), [(4.0, 25.0, "2.5 g"), (3.0, 18.8, ""), (1e-4, 6e-4, "6.1e-05 g"), (0.0, 0.0, "")])
def test_a_sine_is_judged_by_its_peak_acceleration(amplitude: float, pga: float, said: str) -> None:
    """At 1 Hz 3 m/s are 1.9 g, 4 m/s are 2.6 g."""
    load = f'loads=[{{kind="sinusoidal", direction="x", amplitude={amplitude}, frequency=1.0, cycles=1}}]'
    found = lines(load, summaries=({"after": {"pga": pga}},))
    assert [said in line and line.startswith("loads[0].amplitude = ") for line in found] == ([True] if said else [])


def test_a_force_on_the_one_block_of_a_group_is_compared_with_it() -> None:
    grouped = Assembly.from_blocks([*PAIR.blocks[:1], replace(PAIR.blocks[1], group="top")], 0.6)
    load = 'loads=[{kind="point", block="top", force=[0, 0, -40.0]}]'
    assert [line[:24] for line in doubts(parse_scene(TEXT, Path("scene.toml"), [load]), grouped, find_joints(grouped))] == [
        "loads[0].force = 40 N is"
    ]


@pytest.mark.parametrize(("pga", "doubted"), [(0.02, True), (3.0, False), (25.0, True)])
def test_a_record_is_judged_by_what_its_scale_makes_of_it(pga: float, doubted: bool) -> None:
    load = 'loads=[{kind="record", path="a", direction="x", scale=9.81}]'
    found = lines(load, summaries=({"factor": 9.81, "window": [0.0, 2.0], "after": {"pga": pga}},))
    assert [line.startswith("loads[0].scale = 9.81 makes a PGA of ") for line in found] == [True] * doubted
    assert bool(unusual_pga(pga, "quake.txt has a")) == doubted


def test_a_time_step_that_a_slipped_unit_makes_too_long_is_refused_with_that_value(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    tie = '[[loads]]\nkind = "tie"\nblocks = ["wall.1.1", "wall.2.1"]\ndiameter = 20\n'
    path.write_text(f'[structure]\nkind = "wall"\n[material]\ndensity = 2000.0\nfriction = 0.6\n{tie}[run]\ndt = 1e-3\nduration = 0.1\n')
    with pytest.raises(
        InputError, match=r"run.dt: 0.001 s is too long .* loads\[0\], .* 314 m2 .*; loads\[0\].diameter = 20 m: .*\"20 mm\""
    ):
        prepare(read_scene(path))


def test_the_lines_stand_among_the_warnings_of_a_run_and_the_notes_of_a_limit_analysis(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(TEXT.replace(FROM_FILE, 'structure = {kind = "column", drums = 2}\n').replace("0.6", "1.5"))
    scene = read_scene(path)
    (line,) = structure_doubts(scene, structure_of(scene).blocks)
    assert line in facts(limit_case(scene))["notes"]
    assert line in prepare(scene).warnings


@pytest.mark.parametrize(("displacement", "doubted"), [(0.19, False), (0.21, True)])
def test_supports_that_part_by_more_than_the_depth_of_a_joint_draw_a_line(displacement: float, doubted: bool) -> None:
    """A lintel of 4 m bears 0.2 m on either support, across its width of 1 m."""
    bearings = [box("left", (-1, 0, -1), (0.2, 1, 0), fixed=True), box("right", (3.8, 0, -1), (5, 1, 0), fixed=True)]
    lintel = Assembly.from_blocks([*bearings, box("lintel", (0, 0, 0), (4, 1, 2.5))], 0.6)
    load = f'loads=[{{kind="spreading", direction="x", displacement={displacement}, duration=10.0}}]'
    found = doubts(parse_scene(TEXT, Path("scene.toml"), [load]), lintel, find_joints(lintel))
    said = "loads[0].displacement = 0.21 m is 1.05 times the depth of the deepest joint on those supports, 0.2 m: "
    assert [line.startswith(said) for line in found] == [True] * doubted
    sinks = load.replace('"spreading", direction="x"', '"settlement", supports="left"')
    assert bool(doubts(parse_scene(TEXT, Path("scene.toml"), [sinks]), lintel, find_joints(lintel))) == doubted
    both = sinks.replace('"left"', '["left", "right"]')
    assert doubts(parse_scene(TEXT, Path("scene.toml"), [both]), lintel, find_joints(lintel)) == []


def test_a_floor_that_weighs_more_than_what_bears_it_draws_a_line() -> None:
    floor = replace(box("floor1", (0, 0, 1), (1, 1, 2), density=2500.0), group="floor1")
    heavy = Assembly.from_blocks([*PAIR.blocks, floor], 0.6)
    change = "structure.floors=[{height=3.0, mass=2500.0}]"
    (line,) = doubts(parse_scene(TEXT, Path("scene.toml"), [change]), heavy, find_joints(heavy))
    assert line.startswith("structure.floors[0].mass = 2500 kg/m2 is 2.5 t on 2 t of masonry: roofs and floors weigh less")


@pytest.mark.parametrize(("density", "said"), [(1.9, 'for t/m3 write "1.9 t/m3"'), (2.4e4, "basalt"), (2400.0, ""), (2000.0, "")])
def test_a_density_that_a_file_of_blocks_states_is_looked_at(density: float, said: str) -> None:
    """Once for all of its blocks; those that take the density of the scene have a line for its key alone."""
    blocks = [PAIR.blocks[0], *(replace(PAIR.blocks[1], name=name, density=density) for name in ("one", "two"))]
    found = structure_doubts(parse_scene(TEXT, Path("scene.toml")), blocks)
    assert [line.startswith('structure.path: the density of block "one" and of 1 more is') and said in line for line in found] == [
        True
    ] * bool(said)
    assert structure_doubts(parse_scene(TEXT, Path("scene.toml"), ['quiet_checks=["structure.path"]']), blocks) == []


QUANTITIES = {"kg/m2", "kg/m3", "N/m3", "m2"}  # of which every key is such a quantity of masonry or its ties


def test_every_key_of_such_a_quantity_says_what_is_usual() -> None:
    """A height, a thickness, and what has a unit of its own."""
    models = [CommonTable, Material, *(load.table for load in loads.KINDS.values()), *(kind.table for kind in KINDS.values())]
    seen = {(model, name): field for model in models if model for name, field in _declared_in(model)}
    bare = [
        f"{model.__name__}.{name}"
        for (model, name), one in seen.items()
        if (one.unit in QUANTITIES or (one.unit == "m" and name.endswith(("height", "thickness")))) and not one.usual
    ]
    assert len(seen) > 200 and bare == []


def _declared_in(model: type[BaseModel]) -> Iterator[tuple[str, Declared]]:
    """The keys of a table, and of those in it, with what their fields declare."""
    for name in model.model_fields:
        field = declared_at((model,), (name,))
        yield name, field
        for inner in field.models:
            yield from _declared_in(inner)


FILES = sorted([*EXAMPLES.glob("*.toml"), *(ROOT / "benchmarks").glob("*.toml"), ROOT / "docs" / "accuracy.toml"])
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
FENCED = [
    (f"{page.name}-{i}", text) for page in PAGES for i, text in enumerate(re.findall(r"```toml[^\n]*\n(.*?)```", page.read_text(), re.S))
]
SCENES = [(path.name, path.read_text()) for path in FILES] + FENCED
WHOLE = [
    (name, text) for name, text in SCENES if all(re.search(rf"^\[\[?{table}", text, re.M) for table in ("structure", "material", "run"))
]


@pytest.mark.parametrize("text", [text for _, text in WHOLE], ids=[name for name, _ in WHOLE])
def test_scenes_of_the_repository_draw_no_line(text: str) -> None:
    folder = EXAMPLES / "plans" if re.search(r"^plan = ", text, re.MULTILINE) else EXAMPLES
    assert _drawn(parse_scene(text, folder / "scene.toml")) == []


@pytest.mark.parametrize("kind", sorted({*KINDS} - {"file"}))
def test_starters_draw_no_line(kind: str, tmp_path: Path) -> None:
    assert _drawn(parse_scene(starter(kind, tmp_path / "scene.toml"), tmp_path / "scene.toml")) == []


def _drawn(scene: Scene) -> list[str]:
    """The lines of a scene whose records may not be there; its structure is built where a load is compared with it."""
    compared = any(table.get("kind") in ("point", "settlement", "spreading") for table in scene.loads)
    carries = any({"floors", "roof_mass", "roofs"} & {*table} for table in (scene.structure, *scene.structures))
    assembly = structure_of(scene).assembly if compared or carries else PAIR
    return doubts(scene, assembly, find_joints(assembly))
