# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes and block files of numbers, depths and characters that nobody means: one line each, quoted values cut."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hostile import SCENE, TETRA, refusal, refused_at

import loads
from masonry_cd.app.case import make_structures
from masonry_cd.app.scene import read_scene
from masonry_cd.app.scene_text import override
from masonry_cd.foundation.errors import InputError


def blocks(**keys: object) -> str:
    return json.dumps({"blocks": [{**TETRA, **keys}]})


def line(folder: Path, scene: str, file: str) -> str:
    (folder / "scene.toml").write_text(scene, encoding="utf-8")
    (folder / "b.json").write_text(file, encoding="utf-8")
    message = refusal(folder, lambda: make_structures(read_scene(folder / "scene.toml")))
    assert message is not None
    return message


def test_the_files_are_sound_before_they_are_changed(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "b.json").write_text(blocks())
    assert len(make_structures(read_scene(tmp_path / "scene.toml")).blocks) == 1


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("2000.0", "1" * 5000, "scene.toml: a number of more than 4300 digits"),
        ("[run]", f"[report]\ngrades = {'[' * 3000}{']' * 3000}\n[run]", "scene.toml: lists or tables nested too deep"),
        ("[run]", f"[report]\ngrades = {'{a=' * 1500}1{'}' * 1500}\n[run]", "scene.toml: lists or tables nested too deep"),
        ('"file"', '["file"]', "scene.toml:3: structure.kind: unknown kind"),
        ('"file"', "{a = 1}", "scene.toml:3: structure.kind: unknown kind"),
        ('"file"', f'"{"y" * 6000}"', f'scene.toml:3: structure.kind: unknown kind "{"y" * 300} ..."; one of aqueduct, arch'),
        ('"b.json"', '["b.json"]', "scene.toml:4: structure.path: input should be a valid string"),
        ('"b.json"', '"b\\u0000.json"', 'scene.toml:4: structure.path: no file "b\\x00.json"'),
        ('"b.json"', f'"{"x" * 6000}"', f'scene.toml:4: structure.path: no file "{"x" * 300} ..."'),
        ('"b.json"', '"\\u001b[31m"', 'scene.toml:4: structure.path: no file "\\x1b[31m"'),
        ('"a"', '"a\\u0000"', "scene.toml:1: title: holds a NUL character"),
        ("density", '"\'" = 1\ndensity', "scene.toml:5: material.': unknown key"),
    ],
)
def test_scenes(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert line(tmp_path, SCENE.replace(old, new, 1), blocks()).startswith(message)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (".".join(200 * ["a"]) + "=1", "--set a.a.a."),
        ("structure." + ".".join(200 * ["a"]) + "=1", "--set structure.a.a."),
        ("title=" + 100 * "[" + 100 * "]", "--set title: lists or tables nested too deep"),
        ("report.grades=" + 25 * "{a=" + "1" + 25 * "}", "--set report.grades: lists or tables nested too deep"),
        ('title="\udcff"', '--set title="\\udcff": holds bytes that are no text in UTF-8'),
        ("tit\udcffle=1", "--set tit\\udcffle=1: holds bytes that are no text in UTF-8"),
    ],
)
def test_changes(tmp_path: Path, change: str, message: str) -> None:
    (tmp_path / "scene.toml").write_text(SCENE, encoding="utf-8")
    said = refusal(tmp_path, lambda: read_scene(tmp_path / "scene.toml", [change]))
    assert said is not None
    assert said.startswith(message)
    with pytest.raises(InputError):
        override({}, change)


def test_names_of_bytes_that_are_no_text(tmp_path: Path) -> None:
    (tmp_path / "a\udcff.toml").write_text(SCENE, encoding="utf-8")
    said = refusal(tmp_path, lambda: read_scene(tmp_path / "a\udcff.toml"))
    assert said == "a\\udcff.toml: its name, or a folder of it, holds bytes that are no text in UTF-8; rename it"


@pytest.mark.parametrize(
    ("file", "message"),
    [
        (blocks(density=0).replace('"density": 0', f'"density": {"1" * 5000}'), "b.json: a number of more than 4300 digits"),
        ("[" * 200_000, "b.json: lists or objects nested too deep"),
        ('{"notes": ' * 100_000 + "1" + "}" * 100_000, "b.json: lists or objects nested too deep"),
        (blocks(name="a\0b"), 'b.json: block "a\\x00b": its name has control characters'),
        (blocks(group="\x1b[31m"), 'b.json: block "b0": its group has control characters'),
        (blocks(name="a\ud800"), 'b.json: block "a\\ud800".name: input should be a valid string'),
        (blocks(name="n" * 9000, density="x"), f'b.json: block "{"n" * 300} ...".density: input should be a valid number'),
        (blocks(name=["a"]), "b.json: blocks[0].name: input should be a valid string"),
        (json.dumps({"units": ["m"], "blocks": [TETRA]}), "b.json: unknown units"),
        (json.dumps({"units": "m" * 9000, "blocks": [TETRA]}), f'b.json: unknown units "{"m" * 300} ..."'),
    ],
)
def test_block_files(tmp_path: Path, file: str, message: str) -> None:
    assert line(tmp_path, SCENE, file).startswith(message)


@pytest.mark.parametrize("kind", [["sinusoidal"], {"a": 1}, 3])
def test_kinds_of_loads_that_are_no_words(kind: object) -> None:
    with refused_at("loads[0].kind"):
        loads.build([{"kind": kind}], 1e-3, 10, (0.0, 0.0, -9.81), Path())
