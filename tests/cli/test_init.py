# SPDX-License-Identifier: GPL-3.0-or-later
"""Starter scenes: of every kind, they name every key, and run as they are."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from command_line import masonry_cd, refusal
from json_schema import faults

from masonry_cd.app.scene_schema import TITLE, scene_schema, schema_text, structure_schema
from masonry_cd.app.starters import SCHEMA, starter
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.materials import Material
from reports.settings import Report
from structures import KINDS

SHORT = ("run.duration=0.01", "run.until_still=false")


@pytest.fixture(scope="module")
def schema() -> dict[str, Any]:
    return scene_schema()


def init(*words: object):
    return masonry_cd("init", *words)


@pytest.mark.parametrize("kind", KINDS)
def test_a_starter_names_every_key_and_fits_the_schema(kind, schema):
    text = starter(kind, Path("scene.toml"))
    named = set(re.findall(r"^(?:# )?\[{0,2}(?:\w+\.)?(\w+)(?:\]+ | =)", text, re.MULTILINE))
    keys = {*structure_schema(kind)["properties"], *Material.model_fields, *Run.model_fields, *Report.model_fields}
    assert keys - named == set()
    assert faults(tomllib.loads(text), schema) == []


@pytest.mark.parametrize("kind", ["arch", "wall", "church"])
def test_a_key_behind_its_mark_holds_as_it_stands_there(kind, schema):
    """Each of them taken out from behind its mark, in its table, is TOML and fits the schema."""
    text = starter(kind, Path("scene.toml"))
    hidden = [match.start() for match in re.finditer(r"^# \w+ = \S", text, re.MULTILINE)]
    assert len(hidden) >= 20
    for at in hidden:
        head = max(text.rfind("\n[", 0, at), text.rfind("\n# [", 0, at)) + 1
        inside = text[head] == "#"
        shown = text[:head] + text[head + 2 * inside : at] + text[at + 2 :]
        wrong = faults(tomllib.loads(shown), schema)
        line = text[at : text.index("\n", at)]
        needed = [fault for fault in wrong if not fault.endswith(("missing", "fit"))]  # of a table that needs other keys, too
        assert (needed if inside else wrong) == [], line


@pytest.mark.usefixtures("trusting")  # what --trust leaves in this process ends with the test
@pytest.mark.parametrize("kind", KINDS)
def test_a_starter_is_built_and_runs(kind, tmp_path):
    scene = tmp_path / "scene.toml"
    said, trust = init(kind, "-o", scene).stdout, ["--trust"] if kind == "solid" else []
    assert ("--trust" in said) == bool(trust)
    built = masonry_cd("build", scene, "-o", tmp_path / "built", *trust)
    assert built.exit_code == 0, built.stderr
    assert ("loose spheres" if kind == "packing" else "1 piece") in built.stdout
    coarse = ["structure.block_length=2.5"] if kind == "church" else []  # its joints take up the weight of 945 blocks in 8 s
    words = [word for change in (*SHORT, *coarse, "report.crack_map=false", "report.html=false") for word in ("--set", change)]
    result = masonry_cd("run", scene, "-o", tmp_path / "out", "-q", *words, *trust)
    assert result.exit_code == 0, result.stderr
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["steps"] == 5


def test_the_first_line_names_the_schema_that_lies_beside_it(tmp_path):
    init("wall", "-o", tmp_path / "new" / "scene.toml")
    first = (tmp_path / "new" / "scene.toml").read_text().splitlines()[0]
    assert first == f"#:schema ./{SCHEMA}"
    assert (tmp_path / "new" / SCHEMA).read_text(encoding="utf-8") == schema_text()


def test_without_a_name_it_is_called_by_its_kind(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert init("dome").stdout == f"written: dome.toml, {SCHEMA}\n"
    assert init("tower").exit_code == 0  # the same schema may lie there


@pytest.mark.parametrize(("kind", "there"), [("arch", "scene.toml"), ("file", "blocks.json"), ("solid", "solid.geo"), ("arch", SCHEMA)])
def test_a_file_that_is_there_is_not_overwritten(kind, there, tmp_path):
    (tmp_path / there).write_text("mine")
    result = init(kind, "-o", tmp_path / "scene.toml")
    assert result.exit_code == 2
    assert refusal(result).place == str(tmp_path / there)
    assert [file.name for file in tmp_path.iterdir()] == [there]
    assert (tmp_path / there).read_text() == "mine"
    assert init(kind, "-o", tmp_path / "scene.toml", "--force").exit_code == 0
    assert (tmp_path / there).read_text() != "mine"


def test_the_schema_of_another_version_is_replaced(tmp_path):
    (tmp_path / SCHEMA).write_text(json.dumps({"title": TITLE}))
    assert init("arch", "-o", tmp_path / "scene.toml").exit_code == 0
    assert (tmp_path / SCHEMA).read_text(encoding="utf-8") == schema_text()
