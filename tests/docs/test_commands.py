# SPDX-License-Identifier: GPL-3.0-or-later
"""Commands on the pages: every command parses, and README, tutorials and how-to pages are followed from top to bottom."""

from __future__ import annotations

import importlib.util
import re
import shlex
import tomllib
from pathlib import Path

import pytest
import typer
from command_line import masonry_cd
from doc_pages import DOCS, PAGES, Reader, command_lines, fences, page_name, typed
from places import ROOT

from masonry_cd.app.limit_table import limit_table
from masonry_cd.cli.app import app
from masonry_cd.foundation.errors import parse_table
from masonry_cd.foundation.plugins import CALLED, OWN_FILE
from masonry_cd.mechanics.model.materials import Material
from masonry_cd.studies.study.clusters import SlurmTable
from masonry_cd.studies.study.study_file import StudyTables
from structures.building.table import BuildingRoofTable
from structures.floors import FloorTable
from structures.plans.keys import StoreyTable

COMMANDS = typer.main.get_command(app).commands
FIRST_HOUR = DOCS / "tutorials" / "first_hour.md"
IN_A_SCENE = re.findall(r"^\| `(.+?)` \| `(.+?)` \| `(.+?)` \| `(.+?)` \|$", FIRST_HOUR.read_text(encoding="utf-8"), re.MULTILINE)
ON_THE_LINE = re.findall(r"^\| `masonry-cd (.+?)` \| `(.+?)` \|$", FIRST_HOUR.read_text(encoding="utf-8"), re.MULTILINE)
FOLLOWED = [ROOT / "README.md", DOCS / "index.md", *sorted(DOCS.glob("tutorials/*.md")), *sorted(DOCS.glob("howto/*.md"))]
QUICK = ("docs/howto/blocks.md", "docs/howto/code_check.md", "docs/howto/runs.md")
LONG = pytest.mark.slow(reason="types every command of a page: runs, pictures and reports, 5 to 20 s")


def lines_of(first: str) -> list[tuple[str, str]]:
    """All lines on all pages that begin with a word, each with its page."""
    return [(page_name(page), line) for page in PAGES for line in command_lines(page) if shlex.split(line)[0] == first]


def test_lines_are_found_and_loops_undone():
    assert list(typed("a \\\n  1  # why\n\nfor x in 2 3; do\n  b --set k=$x\ndone\n")) == ["a 1", "b --set k=2", "b --set k=3"]
    assert len(lines_of("masonry-cd")) >= 100
    assert {name for name, _ in lines_of("masonry-cd")} >= {"README.md", "docs/command_reference.md", "docs/tutorials/first_hour.md"}


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_every_command_parses(page: Path):
    for line in command_lines(page):
        words = shlex.split(line)
        if words[0] == "masonry-cd" and words[1] != "COMMAND":
            COMMANDS[words[1]].make_context(words[1], words[2:])
        elif words[0].endswith("python") and words[1] == "-m":
            assert importlib.util.find_spec(words[2]), line
        elif words[0].endswith("python"):
            assert (ROOT / words[1]).is_file(), line
        elif words[0] == "make":
            (target,) = [word for word in words[1:] if "=" not in word]
            assert re.search(rf"^{target}:", (ROOT / "Makefile").read_text(), re.MULTILINE), line


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_commands_in_a_sentence_have_the_options_that_it_gives_them(page: Path):
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    for name, rest in re.findall(r"`masonry-cd ([a-z]+)((?: [^`]*)?)`", text):
        known = {option for parameter in COMMANDS[name].params for option in (*parameter.opts, *parameter.secondary_opts)}
        given = set(re.findall(r"(?<=\s)(--?[a-z][\w-]*)", rest))
        assert given - known - {"--help"} == set(), (name, rest)


@pytest.mark.parametrize(
    "page", [pytest.param(page, id=page_name(page), marks=[] if page_name(page) in QUICK else LONG) for page in FOLLOWED]
)
def test_a_reader_can_follow_the_page(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    done = Reader(tmp_path).follow(page)
    expected = [line for fence in fences(page) if fence.language == "sh" for line in typed(fence.text)]
    assert done == [line for line in expected if line.startswith("masonry-cd ") and "COMMAND" not in line]
    assert done, "a page that tells nobody to do anything"


@pytest.fixture(scope="module")
def beginner(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a reader of the first hour, who has the drawing and the scene of the second task."""
    folder = tmp_path_factory.mktemp("first_hour")
    reader = Reader(folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for fence in fences(FIRST_HOUR):
            for line in typed(fence.text) if fence.language == "sh" else ():
                if line.startswith(("masonry-cd init", "masonry-cd build drawing", "cp ")):
                    reader.type(line)
            if fence.title:
                reader.save(fence)
    return folder


def test_there_are_three_mistakes_for_each_task():
    assert [len([scene for scene, *_ in IN_A_SCENE if task in scene]) for task in ("aqueduct", "twenty")] == [3, 3]
    assert len(ON_THE_LINE) >= 3


@pytest.mark.parametrize(("scene", "right", "wrong", "said"), IN_A_SCENE)
def test_a_mistake_in_a_scene_ends_in_the_line_of_the_page(scene, right, wrong, said, beginner: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(beginner)
    text = Path(scene).read_text(encoding="utf-8")
    assert text.count(right) == 1
    Path("mistake.toml").write_text(text.replace(right, wrong), encoding="utf-8")
    result = masonry_cd("run", "mistake.toml", "-o", "out/mistake")
    assert (result.exit_code, result.stderr) == (2, f"masonry-cd: error: {said}\n")
    assert not Path("out/mistake").exists()


@pytest.mark.parametrize(("words", "said"), ON_THE_LINE)
def test_a_mistake_on_the_command_line_ends_in_the_line_of_the_page(words, said, beginner: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(beginner)
    result = masonry_cd(*shlex.split(words))
    assert (result.exit_code, result.stderr) == (2, f"masonry-cd: error: {said}\n")


def test_parts_of_scenes_and_of_studies_have_keys_that_there_are():
    checks = {
        "docs/howto/bridges.md": [lambda tables: limit_table(tables["limit"])],
        "docs/howto/buildings.md": [
            lambda tables: [
                parse_table(kind, each, name)
                for name, kind in (("floors", FloorTable), ("roofs", BuildingRoofTable))
                for each in tables["structure"][name]
            ],
        ],
        "docs/howto/calibrate.md": [
            lambda tables: parse_table(StudyTables, {"scene": "pier.toml", "design": "sample", "samples": 100, **tables}, "")
        ],
        "docs/howto/code_check.md": [lambda tables: limit_table(tables["limit"])],
        "docs/howto/plans.md": [
            lambda tables: [parse_table(StoreyTable, each, "structure.storeys") for each in tables["structure"]["storeys"]],
        ],
        "docs/limit_analysis.md": [lambda tables: limit_table(tables["limit"])],
        "docs/plugins.md": [
            lambda tables: [[*CALLED].index(name.removeprefix("masonry_cd.")) for name in tables["project"]["entry-points"]],
            lambda tables: re.fullmatch(OWN_FILE, tables["structure"]["kind"])["path"],
        ],
        "docs/scene_file.md": [lambda tables: parse_table(Material, {"density": 2000.0, "friction": 0.6} | tables["material"], "")],
        "docs/studies.md": [lambda tables: parse_table(StudyTables, tables, ""), lambda tables: parse_table(SlurmTable, tables, "")],
    }
    parts = {page_name(page): [fence for fence in fences(page) if fence.language == "toml" and not fence.title] for page in PAGES}
    assert {page: len(found) for page, found in parts.items() if found} == {page: len(each) for page, each in checks.items()}
    for page, each in checks.items():
        for fence, check in zip(parts[page], each, strict=True):
            check(tomllib.loads(fence.text))
