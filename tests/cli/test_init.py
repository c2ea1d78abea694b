# SPDX-License-Identifier: GPL-3.0-or-later
"""Starter scenes of every kind name every key and run as they are; pages open, and a shell completes commands."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
import webbrowser
from pathlib import Path
from typing import Any

import pytest
from command_line import done, masonry_cd, refusal
from json_schema import faults

from masonry_cd.app.scene_schema import TITLE, scene_schema, schema_text, structure_schema
from masonry_cd.app.starters import SCHEMA, starter
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.materials import Material
from reports.settings import Report
from reports.study.outputs import PAGE
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
    built = done("build", scene, "-o", tmp_path / "built", "--no-picture", *trust)
    assert ("loose spheres" if kind == "packing" else "1 piece") in built.stdout
    coarse = ["structure.block_length=2.5"] if kind == "church" else []  # its joints take up the weight of 945 blocks in 8 s
    words = [word for change in (*SHORT, *coarse, "report.crack_map=false", "report.html=false") for word in ("--set", change)]
    done("run", scene, "-o", tmp_path / "out", "-q", *words, *trust)
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["steps"] == 5


def test_the_first_line_names_the_schema_that_lies_next_to_it(tmp_path):
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


DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")


def view(folder):
    return masonry_cd("view", folder)


@pytest.fixture
def opened(monkeypatch) -> list[str]:
    """The pages that would have been opened; there is no display yet."""
    pages: list[str] = []
    monkeypatch.setattr(webbrowser, "open", lambda page: pages.append(page) or True)
    monkeypatch.setattr(sys, "platform", "linux")
    for name in DISPLAYS:
        monkeypatch.delenv(name, raising=False)
    return pages


@pytest.fixture
def run(tmp_path):
    (tmp_path / "report.html").write_text("<html></html>")
    return tmp_path


@pytest.mark.parametrize("display", DISPLAYS)
def test_the_page_opens_in_the_browser(run, opened, monkeypatch, display):
    monkeypatch.setenv(display, ":0")
    result = view(run)
    assert (result.exit_code, opened) == (0, [(run / "report.html").as_uri()])
    assert result.stdout == f"opened: {opened[0]}\n"


def test_without_a_display_or_a_browser_it_is_said_where_the_page_lies(run, opened, monkeypatch):
    place = (run / "report.html").as_uri()
    assert (view(run).stdout, opened) == (f"no display is available; the page is {place}\n", [])
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(webbrowser, "open", lambda page: False)
    assert place in view(run).stdout


@pytest.mark.parametrize(
    ("there", "folder", "remedy"),
    [
        ("result.h5", "", "write it with masonry-cd report {} --html"),
        ("study.json", "", "masonry-cd study STUDY -o {} --report"),
        ("other", "", "nor result.h5"),
        ("other", "none", "no such folder"),
        ("other", "other", "is a file"),
    ],
)
def test_a_folder_without_a_page_is_refused_with_the_command_that_makes_it(tmp_path, opened, there, folder, remedy):
    (tmp_path / there).write_bytes(b"")
    result = view(tmp_path / folder)
    assert (result.exit_code, opened) == (2, [])
    assert result.stderr.startswith(f"masonry-cd: error: {tmp_path / folder}: ") and remedy.format(tmp_path) in result.stderr


def test_the_page_of_a_study_opens(tmp_path, opened, monkeypatch):
    monkeypatch.setenv("DISPLAY", ":0")
    for name in ("study.json", PAGE):
        (tmp_path / name).write_text("{}")
    assert (view(tmp_path).exit_code, opened) == (0, [(tmp_path / PAGE).as_uri()])


def completed(line: str) -> set[str]:
    """The words that bash is offered after a line."""
    code = "import sys; sys.argv = ['masonry-cd']; from masonry_cd.cli import main; main()"
    asked = {"_MASONRY_CD_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(len(line.split(" ")) - 1)}
    out = subprocess.run([sys.executable, "-c", code], env=os.environ | asked, capture_output=True, text=True, check=False)
    return set(out.stdout.split())


def test_a_shell_completes_commands_and_options():
    assert {"run", "record", "report"} <= completed("masonry-cd r")
    assert "build" not in completed("masonry-cd r")
    assert completed("masonry-cd run --res") == {"--resume"}
    assert completed("masonry-cd init a") == {"aqueduct", "arch"}
