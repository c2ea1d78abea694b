# SPDX-License-Identifier: GPL-3.0-or-later
"""The JSON schema of the scene file says what the reader of scenes does."""

from __future__ import annotations

import copy
import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from command_line import masonry_cd
from json_schema import faults
from places import EXAMPLES, ROOT

import loads
import structures
from loads import KINDS as LOADS
from masonry_cd.analysis.damage.grades import read_grades
from masonry_cd.app.scene import read_scene
from masonry_cd.app.scene_schema import FILE, scene_schema, schema_text
from masonry_cd.app.scene_text import dump_toml
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly
from reports.settings import Report
from structures import KINDS as STRUCTURES

STUDIES = [EXAMPLES / "study_arch.toml", EXAMPLES / "attribute_columns.toml"]
SCENES = sorted({*EXAMPLES.glob("*.toml"), ROOT / "docs" / "accuracy.toml"} - set(STUDIES))
ARCH: dict[str, Any] = {
    "structure": {"kind": "arch", "span": 4.0, "thickness": 0.4},
    "material": {"density": 2200.0, "friction": 0.6},
    "loads": [{"kind": "sinusoidal", "direction": "x", "amplitude": 0.2, "frequency": 2.0, "cycles": 4}],
    "run": {"dt": 1e-3, "duration": 3.0},
}


@pytest.fixture(scope="module")
def schema() -> dict[str, Any]:
    return scene_schema()


def keys(schema: Any, where: str = "") -> Iterator[tuple[str, dict[str, Any]]]:
    """All keys of all tables, with where they stand."""
    if isinstance(schema, list):
        for item in schema:
            yield from keys(item, where)
    if isinstance(schema, dict):
        for name, key in schema.get("properties", {}).items():
            yield f"{where}.{name}", key
            yield from keys(key, f"{where}.{name}")
        for word in ("items", "anyOf", "oneOf", "additionalProperties"):
            yield from keys(schema.get(word), where)


def read(scene: dict[str, Any], folder: Path) -> None:
    """Read a scene as a run does, up to its blocks and loads."""
    path = folder / "scene.toml"
    path.write_text(dump_toml(scene), encoding="utf-8")
    asked = read_scene(path)
    read_grades(asked.report.grades)
    blocks = structures.build(asked.structure, asked.material.density, folder)
    loads.build(asked.loads, asked.run.dt, 10, asked.run.gravity, folder, Assembly.from_blocks(blocks, 0.5))


def test_the_file_in_the_package_is_what_is_generated():
    assert FILE.read_text(encoding="utf-8") == schema_text(), "write it again: masonry-cd schema -o masonry_cd/app/scene.schema.json"


@pytest.mark.slow(reason="builds the schema of every table three times")
def test_the_command_prints_it_or_writes_it(tmp_path):
    assert masonry_cd("schema").stdout == schema_text()
    masonry_cd("schema", "-o", tmp_path / "s.json")
    assert (tmp_path / "s.json").read_text(encoding="utf-8") == schema_text()


def test_every_key_has_a_text(schema):
    bare = [where for where, key in keys(schema) if not key.get("description")]
    assert not bare


def test_every_kind_is_in_it_with_all_of_its_keys(schema):
    tables = schema["properties"]
    own = {kind["properties"]["kind"]["const"]: set(kind["properties"]) for kind in tables["structure"]["oneOf"]}
    assert own.keys() == set(STRUCTURES)
    for kind, found in own.items():
        model = STRUCTURES[kind].table
        assert model is not None
        assert found == set(model.model_fields) | {"kind", "most_blocks", "floors", "foundations", "ground", "ties"}
    shaking = {kind["properties"]["kind"]["const"]: set(kind["properties"]) for kind in tables["loads"]["items"]["oneOf"]}
    assert shaking == {kind: set(load.table.model_fields) for kind, load in LOADS.items()}
    assert set(tables["run"]["properties"]) == set(Run.model_fields)
    assert set(tables["report"]["properties"]) == {*Report.model_fields, *Report.further_keys()}


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_the_examples_fit(schema, path):
    assert faults(tomllib.loads(path.read_text(encoding="utf-8")), schema) == []


@pytest.mark.parametrize(
    ("table", "key", "value"),
    [
        ("structure", "kind", "arc"),
        ("structure", "spann", 4.0),
        ("structure", "span", -4.0),
        ("structure", "span", "wide"),
        ("structure", "openings", []),  # of a wall
        ("structure", "foundations", "corner"),
        ("structure", "ground", "yes"),
        ("structure", "ties", [{"along": "x"}]),
        ("structure", "floors", [{"height": 3.0}]),
        ("material", "friction", 35.0),
        ("material", "density", -2.2),
        ("material", "joints", {"cohesion": -1.0}),
        ("material", "joints", {"arch-base": {"cohesive": 1.0}}),
        ("run", "dt", 0.2),
        ("run", "dt", "automatic"),
        ("run", "gravity", [0.0, -9.81]),
        ("run", "solver", "jacobi"),
        ("report", "crack_maps", True),
        ("report", "view", "below"),
        ("report", "extra", ["energies"]),
        ("report", "grades", {"width": [1e-3, 2e-3]}),
        ("report", "grades", {"widths": [1e-3, 2e-3, 3e-3, 4e-3, 5e-3]}),
        ("loads", "kind", "sine"),
        ("loads", "direction", "w"),
        ("loads", "amplitud", 1.0),
        ("loads", "frequency", 0.0),
        ("loads", "delay", {"velocity": 1.0}),
    ],
)
def test_what_the_reader_refuses_does_not_fit(schema, table, key, value, tmp_path):
    scene = copy.deepcopy(ARCH)
    assert faults(scene, schema) == []
    place = scene.setdefault(table, {})
    (place[0] if table == "loads" else place)[key] = value
    assert faults(scene, schema)
    with pytest.raises(InputError):
        read(scene, tmp_path)


@pytest.mark.parametrize(
    ("table", "key", "value"),
    [
        ("structure", "abutment", False),
        ("structure", "foundations", {"x": [-2.2, 2.2]}),
        ("structure", "ground", -3.0),
        ("structure", "ties", [{"along": "x", "height": 0.2, "diameter": 0.02}]),
        ("material", "friction", {"default": 0.6, "arch-base": 0.9}),
        ("material", "joints", {"normal_stiffness": 1e9}),
        ("material", "joints", {"default": {"normal_stiffness": 1e9, "cohesion": 1e5}}),
        ("run", "dt", "auto"),
        ("run", "solver", "newton"),
        ("report", "energy", True),
        ("report", "grades", {"drift": [1e-3, 2e-3, 3e-3, 4e-3, float("inf")]}),
    ],
)
def test_what_the_reader_takes_fits(schema, table, key, value, tmp_path):
    scene = copy.deepcopy(ARCH)
    scene.setdefault(table, {})[key] = value
    assert faults(scene, schema) == []
    read(scene, tmp_path)


def test_only_a_block_file_does_without_a_density(schema):
    scene = copy.deepcopy(ARCH)
    del scene["material"]["density"]
    assert faults(scene, schema)
    assert faults(scene | {"structure": {"kind": "file", "path": "blocks.json"}}, schema) == []


def test_it_is_plain_json_of_draft_7():
    def refuse(word: str) -> None:
        raise AssertionError(word)

    text = schema_text()
    json.loads(text, parse_constant=refuse)  # no NaN, no Infinity
    assert '"$ref"' not in text
    assert "prefixItems" not in text
    assert '"null"' not in text
