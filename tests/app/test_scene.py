# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene file: what it means, and values with units, which are the numbers that they say."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hostile import refused_at
from json_schema import faults
from places import EXAMPLES
from pydantic import BaseModel

import loads
import masonry_cd as mc
from masonry_cd.app.case import prepare
from masonry_cd.app.scene import parse_scene, read_scene
from masonry_cd.app.scene_schema import scene_schema
from masonry_cd.app.scene_text import dump_toml, parse_toml
from masonry_cd.app.scene_units import scene_in_si, unit_of_key
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.units import KINDS
from masonry_cd.limit.case import limit_case
from masonry_cd.mechanics.dynamics.settings import Run
from structures import KINDS as STRUCTURES
from structures.tables import CommonTable

GOOD = """\
title = "A test"
[structure]
kind = "arch"
radius = 10.0

[material]
density = 2200
friction = 0.6

[[loads]]
kind = "gravity"

[[loads]]
kind = "sinusoidal"
amplitude = 0.2

[run]
dt = 1e-3
duration = 8.0

[report]
crack_map = true
"""


@pytest.fixture
def write(tmp_path: Path):
    def _write(text: str) -> Path:
        path = tmp_path / "scene.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return _write


def test_reads_every_table_and_keeps_the_text(write):
    scene = read_scene(write(GOOD))
    assert scene.title == "A test"
    assert scene.structure == {"kind": "arch", "radius": 10.0}
    assert (scene.material.density, scene.material.friction) == (2200.0, 0.6)
    assert [load["kind"] for load in scene.loads] == ["gravity", "sinusoidal"]
    assert scene.run == Run(dt=1e-3, duration=8.0)
    assert scene.run.gravity == (0.0, 0.0, -9.81)
    assert scene.report.crack_map
    assert scene.text == GOOD


def test_the_title_falls_back_on_the_file_name(write):
    assert read_scene(write(GOOD.partition("\n")[2])).title == "scene"


def test_friction_by_pairs_of_groups(write):
    scene = read_scene(write(GOOD.replace("friction = 0.6", "friction.arch-base = 0.9\nfriction.default = 0.5")))
    assert scene.material.friction == {"arch-base": 0.9, "default": 0.5}


def test_joint_laws_by_pairs_of_groups_or_one_for_all(write):
    one = read_scene(write(GOOD.replace("[[loads]]", "[material.joints]\nnormal_stiffness = 1e10\n\n[[loads]]", 1)))
    assert one.material.joints["default"].stiffness == (1e10, 1e10 / 2.4)
    tables = (
        "[material.joints.arch-base]\ncohesion = 2e5\n[material.joints.arch-arch]\nnormal_stiffness = 1e9\ntangential_stiffness = 1e8\n"
    )
    pairs = read_scene(write(GOOD.replace("[[loads]]", f"{tables}\n[[loads]]", 1))).material.joints
    assert (pairs["arch-base"].stiffness, pairs["arch-base"].cohesion) == ((0.0, 0.0), 2e5)
    assert pairs["arch-arch"].stiffness == (1e9, 1e8)
    assert read_scene(write(GOOD)).material.joints == {}


@pytest.mark.parametrize(("duration", "dt", "steps"), [(8.0, 1e-3, 8000), (0.3, 0.1, 3), (1.0, 0.03, 34), (0.7, 0.007, 100)])
def test_steps_cover_the_duration_in_spite_of_rounding(duration, dt, steps):
    assert Run(dt=dt, duration=duration).steps == steps


def test_frames_are_a_whole_number_of_steps_apart():
    assert Run(dt=1e-3, duration=1.0, frames_per_second=100).frame_every == 10
    assert Run(dt=0.05, duration=1.0, frames_per_second=100).frame_every == 1


@pytest.mark.parametrize(("frames_per_second", "dt"), [(1e-308, 1e-3), (5e-324, 1e-3), (50.0, 5e-324), (1e-6, 1e-3)])
def test_frames_further_apart_than_any_run_is_long(frames_per_second, dt):
    run = Run(dt=dt, duration=10.0 * dt, frames_per_second=frames_per_second)
    assert run.frame_every > run.steps


def test_overrides_are_toml_values_and_else_text(write):
    changes = ["run.dt=2e-3", "loads[1].amplitude=0.5", "run.solver=nlgs", "run.gravity=[0, 0, -1.62]", "material.friction.arch-base=0.4"]
    scene = read_scene(write(GOOD.replace("friction = 0.6", "friction.default = 0.6")), changes)
    assert scene.run.dt == 2e-3
    assert scene.loads[1]["amplitude"] == 0.5
    assert scene.run.solver == "nlgs"
    assert scene.run.gravity == (0, 0, -1.62)
    assert scene.material.friction == {"default": 0.6, "arch-base": 0.4}


def test_the_text_kept_in_the_results_is_that_of_the_changed_scene(write, tmp_path):
    changed = read_scene(write(GOOD), ["run.dt=2e-3", 'structure.note=a "quoted" word'])
    again = tmp_path / "again.toml"
    again.write_text(changed.text)
    repeat = read_scene(again)
    assert (repeat.run, repeat.structure, repeat.loads) == (changed.run, changed.structure, changed.loads)
    assert "--set run.dt=2e-3" in changed.text.splitlines()[0]


def test_toml_written_reads_back_the_same():
    tables = {
        "title": 'a "b" \\ é',
        "structure": {"kind": "file", "on": True, "size": [1, 2.5, -3e-9], "at": {"x y": 1, "deep": {"z": "1"}}, "none": []},
        "loads": [{"kind": "a"}, {"kind": "b", "direction": [1.0, 0.0, 0.0]}],
    }
    assert tomllib.loads(dump_toml(tables)) == tables


def test_a_mark_of_the_encoding_at_the_head_is_no_error(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(GOOD, encoding="utf-8-sig")
    assert read_scene(path).run.duration == 8.0


def located(scene, place, text):
    """The error of a place as a command shows it."""
    with pytest.raises(InputError) as caught, scene.locating():
        raise InputError(place, text)
    return caught.value


def test_errors_of_other_packages_get_file_and_line(write):
    scene = read_scene(write(GOOD))
    assert str(located(scene, "loads[1].amplitude", "must be positive")).endswith("scene.toml:15: loads[1].amplitude: must be positive")
    assert str(located(scene, "loads[1].frequency", "missing")).endswith("scene.toml:13: loads[1].frequency: missing")
    assert str(located(scene, "record.csv:7", "not a number")) == "record.csv:7: not a number"


def test_an_error_elsewhere_names_its_line_in_the_file_whatever_was_changed(write):
    with refused_at("run.dt"):
        read_scene(write(GOOD.replace("dt = 1e-3", "dt = -1e-3")), ["run.seed=3"])
    scene = read_scene(write(GOOD), ["run.seed=3", "structure.thickness=-1"])
    assert str(located(scene, "structure.radius", "bad")).endswith("scene.toml:4: structure.radius: bad")
    assert str(located(scene, "structure.radius[1]", "bad")).endswith("scene.toml:4: structure.radius[1]: bad")  # item of a list
    assert str(located(scene, "structure.thickness", "bad")) == "--set structure.thickness=-1: structure.thickness: bad"


@pytest.mark.parametrize("change", ['title="\udcff"', "tit\udcffle=1"])
def test_bytes_that_are_no_text_are_refused(write, tmp_path, change):
    with refused_at(f"--set {change}"):
        read_scene(write(GOOD), [change])
    (tmp_path / "a\udcff.toml").write_text(GOOD, encoding="utf-8")
    with refused_at("a\udcff.toml"):
        read_scene(tmp_path / "a\udcff.toml")


NUMBERS = """
quiet_checks = ["loads[1].force"]
[structure]
kind = "column"
height = 1.5
diameter = 0.3
drums = 2
foundations = { x = [0.0] }
[material]
density = 1900.0
friction = 0.6
compressive_strength = { shaft = 5e6, default = 1e7 }
[material.joints]
normal_stiffness = 1e10
[[loads]]
kind = "settlement"
supports = "*.x2"
displacement = 0.03
duration = 0.1
[[loads]]
kind = "point"
block = "drum1"
force = [0.0, 0.0, -4000.0]
[[loads]]
kind = "sinusoidal"
direction = "x"
amplitude = 0.2
frequency = 5.0
cycles = 1
delay = { seconds = { "*.x2" = 0.005 } }
[run]
dt = 1e-3
duration = 0.3
gravity = [0.0, 0.0, -9.81]
[report]
opened = 1e-4
times = [0.1, 0.2]
[report.grades]
width = [1e-4, 5e-3, 15e-3, 25e-3, inf]
[limit]
push = "x"
[limit.check]
spectrum = "EC8"
ag = 2.4516625
"""
UNITS = {
    "height = 1.5": 'height = "150 cm"', "diameter = 0.3": 'diameter = "300 mm"', "x = [0.0]": 'x = ["0 mm"]',
    "density = 1900.0": 'density = "1.9 t/m3"', "shaft = 5e6": 'shaft = "5 MPa"', "= 1e10": '= "10 N/mm3"',
    "displacement = 0.03": 'displacement = "30 mm"', "duration = 0.1": 'duration = "100 ms"', "-4000.0]": '"-4 kN"]',
    "amplitude = 0.2": 'amplitude = "20 cm/s"', "frequency = 5.0": 'frequency = "5 Hz"', "= 0.005 }": '= "5 ms" }',
    "dt = 1e-3": 'dt = "1 ms"', "duration = 0.3": 'duration = "0.3 s"', "-9.81]": '"-9.81 m/s2"]', "opened = 1e-4": 'opened = "0.1 mm"',
    "[0.1, 0.2]": '["100 ms", 0.2]', "[1e-4, 5e-3,": '["0.1 mm", "5 mm",', "ag = 2.4516625": 'ag = "0.25 g"',
}  # fmt: skip
WITH_UNITS = NUMBERS
for number, text in UNITS.items():
    assert NUMBERS.count(number) == 1, number
    WITH_UNITS = WITH_UNITS.replace(number, text)


def test_a_scene_with_units_is_the_scene_with_numbers() -> None:
    plain, given = (parse_scene(text, Path("scene.toml")) for text in (NUMBERS, WITH_UNITS))
    assert scene_in_si(parse_toml(WITH_UNITS, Path("a"))) == parse_toml(NUMBERS, Path("a"))
    assert (given.run, given.material, given.text) == (plain.run, plain.material, WITH_UNITS)
    assert limit_case(given).whole.loads.constant.tolist() == limit_case(plain).whole.loads.constant.tolist()
    one, other = prepare(plain), prepare(given)
    assert (one.loading.support_velocity == other.loading.support_velocity).all()
    assert one.warnings == other.warnings
    assert [block.vertices.tolist() for block in one.assembly.blocks] == [block.vertices.tolist() for block in other.assembly.blocks]
    assert one.joints.polygon.tolist() == other.joints.polygon.tolist()
    assert faults(parse_toml(WITH_UNITS, Path("a")), scene_schema()) == []


def stated(value: Any, tables: dict[str, Any], key: str = "") -> Any:
    """Tables whose numbers state the unit of their key, where it has one."""
    if isinstance(value, dict):
        return {name: stated(item, tables, f'{key}."{name}"' if key else name) for name, item in value.items()}
    if isinstance(value, list):
        return [stated(item, tables, f"{key}[{i}]") for i, item in enumerate(value)]
    unit = unit_of_key(tables, key) if isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value) else ""
    return f"{value!r} {unit}" if unit else value


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda path: path.stem)
def test_every_number_of_the_examples_may_state_its_unit(path: Path) -> None:
    tables = parse_toml(path.read_text(encoding="utf-8"), path)
    made = stated(tables, tables)
    assert scene_in_si(made) == tables
    assert "design" in tables or '"' in json.dumps(made["run"]["dt"])
    if "design" not in tables:
        assert parse_scene(dump_toml(made), path).run == parse_scene(path.read_text(encoding="utf-8"), path).run


PURE = {
    *("accept", "tolerance", "theta", "strain_theta"),  # of errors and of the scheme
    *("friction", "rolling_friction", "restitution", "poisson", "damping", "drift", "lost", "core_shares", "shares"),
    "axis",  # a vector of any length
    *("cycles", "scale", "calibration", "initial", "peak"),  # initial is an angle in a tilt and a share in a push
    *("junction", "bond", "stages", "passive", "passive_shaken"),  # shares of courses, of a force, of the passive pressure
    *("active_at", "gone_at"),  # movement over depth
    *("behaviour_factor", "building_damping", "confidence_factor", "f0", "participation"),
    *("above", "below"),  # of whatever a gauge shows
    *("return_period", "years", "nominal_life", "frequency", "probability"),  # in years, and per year
    *("hazard_factor", "return_factor", "material_damping"),  # of a spectrum, and of a soil
    *("factor", "zeta_E", "price", "force", "force_length", "anchor"),  # goal and prices of a strengthening; factors of a rating
    *("plasticity_index", "overconsolidation"),  # of a soil
    "stress",  # share of the strength in service
}
"""Keys whose numbers have no unit."""


def test_every_key_takes_a_unit_or_has_none() -> None:
    assert set(bare(scene_schema())) == PURE


def bare(schema: Any, key: str = "") -> Iterator[str]:
    """The keys that take numbers alone."""
    if isinstance(schema, list):
        for choice in schema:
            yield from bare(choice, key)
    elif isinstance(schema, dict):
        if schema.get("type") == "number":
            yield key
        for word in ("anyOf", "oneOf", "items", "additionalProperties"):
            yield from bare(schema.get(word), key)
        for name, inner in schema.get("properties", {}).items():
            yield from bare(inner, name)


def test_set_takes_a_unit_bare_or_in_quotes_and_python_takes_it_in_a_dict() -> None:
    for change in ("loads[0].displacement=30 mm", 'loads[0].displacement="30 mm"'):
        scene = parse_scene(NUMBERS, Path("scene.toml"), [change])
        assert loads.parse_load(scene.loads[0], "").displacement == 0.03  # type: ignore[attr-defined]
        assert 'displacement = "30 mm"' in scene.text
    tables: dict[str, Any] = parse_toml(WITH_UNITS, Path("a"))
    assert mc.scene(tables).checked.run == parse_scene(NUMBERS, Path("a")).run
    assert mc.scene(tables, run={"dt": "2 ms"}).checked.run.dt == 0.002


def test_units_of_keys_by_their_path() -> None:
    tables = parse_toml(NUMBERS, Path("a"))
    paths = {
        "structure.height": "m", "material.joints.normal_stiffness": "N/m3", "loads[1].force": "N", "loads[2].frequency": "Hz",
        "run.dt": "s", "material.friction": "", "loads[7].force": "", "nothing.at.all": "", "": "", "limit.check.ag": "m/s2",
        "report.grades.width": "m", 'loads[2].delay.seconds."*.x2"': "s",
    }  # fmt: skip
    assert {path: unit_of_key(tables, path) for path in paths} == paths


def test_no_text_of_a_key_repeats_a_unit_that_its_field_declares() -> None:
    """It is written once, in the field; schema and reference put it behind the text."""
    schema = json.dumps(scene_schema())
    said = [text for text in re.findall(r'"description": "((?:[^"\\]|\\.)*)"', schema) if text.count("[") > 1]
    twice = [text for text in said if len(re.findall(r"\[([^\]]+)\]", text)) > 1 and sum(f"[{unit}]" in text for unit in KINDS) > 1]
    assert twice == []
    tables: list[type[BaseModel]] = [CommonTable, *(load.table for load in loads.KINDS.values())]
    tables += [kind.table for kind in STRUCTURES.values() if kind.table is not None]
    texts = [(table.__name__, name, field.description) for table in tables for name, field in table.model_fields.items()]
    assert [where for where in texts if where[2] and any(f"[{unit}]" in where[2] for unit in KINDS)] == []


def test_pint_is_imported_where_a_unit_is_met_and_nowhere_else() -> None:
    code = (
        "import sys; from pathlib import Path; from masonry_cd.app.scene import parse_scene; from masonry_cd.app.case import structure_of\n"
        "for text in sys.stdin.read().split('----'): structure_of(parse_scene(text, Path('a'))); print('pint' in sys.modules)"
    )
    both = f"{NUMBERS}----{WITH_UNITS}"
    out = subprocess.run([sys.executable, "-c", code], input=both, capture_output=True, text=True, check=True)
    assert out.stdout.split() == ["False", "True"]
