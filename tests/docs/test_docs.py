# SPDX-License-Identifier: GPL-3.0-or-later
"""The documentation speaks of the code as it is: the picture shows the packages of the tree, and the examples run."""

from __future__ import annotations

import ast
import importlib.util
import re
import runpy
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import cast

import numpy as np
import pytest
import scenes
from doc_pages import DOCS, PAGES, page_name
from places import ROOT

import masonry_cd as mc
import structures
from masonry_cd import __version__
from masonry_cd.mechanics.friction.problem import Problem, natural_map_error
from masonry_cd.mechanics.solvers import Options
from masonry_cd.studies.laboratory.field_tests import PRESTWOOD, WITHIN, collapse
from structures.files import meshfile

JACOBI = ROOT / "examples" / "plugin" / "masonry_cd_stacks" / "jacobi.py"


def loaded(path: Path, name: str) -> ModuleType:
    """A module from a file, under a name of its own."""
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def picture() -> ModuleType:
    """The script that draws the picture of the packages."""
    return loaded(DOCS / "draw_architecture.py", "draw_architecture")


@pytest.fixture(scope="module")
def found(picture: ModuleType) -> dict[str, tuple]:
    """All packages of the tree, as the script reads them."""
    return picture.packages()


@pytest.fixture
def jacobi() -> Iterator[ModuleType]:
    """The example of a solver as a module."""
    yield loaded(JACOBI, "example_jacobi")
    del sys.modules["example_jacobi"]


def test_every_package_of_the_tree_is_drawn(picture: ModuleType, found: dict[str, tuple]) -> None:
    homes = [ROOT / "masonry_cd", ROOT / "masonry_cd" / "mechanics"]
    core = {str(path.parent.relative_to(ROOT)) for home in homes for path in home.glob("*/__init__.py")} - {"masonry_cd/mechanics"}
    assert set(found) == core | {"structures", "loads", "reports"}
    assert {name for floor in picture.floors() for name in floor} == set(found)


def test_the_picture_is_that_of_the_code(picture: ModuleType, found: dict[str, tuple]) -> None:
    assert picture.drawn() == picture.as_drawn(found), "draw it again: python docs/draw_architecture.py"


@pytest.mark.parametrize("problem", [scenes.tower(3), scenes.tower(2).to_local()], ids=["bodies", "local"])
def test_the_example_of_a_solver_solves(jacobi: ModuleType, problem: Problem) -> None:
    solution = jacobi.solve(problem, Options(tolerance=1e-6))
    assert 0 < solution.iterations < 2000
    assert natural_map_error(problem, solution.impulse) < 1e-6
    again = jacobi.solve(problem, Options(tolerance=1e-6))
    assert np.array_equal(solution.impulse, again.impulse)
    missed = jacobi.solve(problem, Options(tolerance=1e-12, max_iterations=40))
    assert missed.iterations == 40


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_files_that_a_page_names_are_there(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    named = set(re.findall(r"`((?:[\w-]+/)+[\w-]+\.\w+)`", text))
    named = {name for name in named if (ROOT / name.split("/")[0]).is_dir() and not name.startswith("out/")}
    assert sorted(name for name in named if not (ROOT / name).exists()) == []
    links = {link.split("#")[0] for link in re.findall(r"\]\(([^)\s]+)\)", text) if "://" not in link}
    assert sorted(link for link in links if link and not (page.parent / link).exists()) == []


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_links_to_a_heading_find_it(page: Path) -> None:
    for target, anchor in re.findall(r"\]\(([^)\s#]*)#([^)\s]+)\)", page.read_text(encoding="utf-8")):
        if "://" in target:
            continue
        headings = re.findall(r"^#+ (.*)$", ((page.parent / target) if target else page).read_text(), re.MULTILINE)
        assert anchor in {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_the_citation_names_this_version() -> None:
    text = (ROOT / "CITATION.cff").read_text()
    assert re.findall(r"^version: (\S+)$", text, re.MULTILINE) == [__version__]


def test_every_validation_test_is_described() -> None:
    marked = set()
    for path in (ROOT / "tests").rglob("test_*.py"):
        text = path.read_text()
        every = re.search(r"^pytestmark = pytest\.mark\.validation", text, re.MULTILINE)
        own = r"^def (test_\w+)" if every else r"^@pytest\.mark\.validation\n(?:@.*\n)*(?:async )?def (test_\w+)"
        marked |= set(re.findall(own, text, re.MULTILINE))
    described = set(re.findall(r"^\| `(test_\w+)` \|", (DOCS / "validation.md").read_text(), re.MULTILINE))
    assert marked == described


def test_the_reference_of_scenes_is_what_is_generated():
    reference = loaded(DOCS / "write_scene_reference.py", "write_scene_reference")
    for page, text in reference.pages().items():
        assert page.read_text(encoding="utf-8") == text, "python docs/write_scene_reference.py"


WRITER = ROOT / "docs" / "write_field_tests.py"


def test_the_page_is_what_its_generator_makes() -> None:
    made = runpy.run_path(str(WRITER))
    text = (ROOT / "docs" / "field_tests.md").read_text(encoding="utf-8")
    assert text == made["page"]()


def test_four_hinges_within_a_fifth_of_the_test_at_full_passive_pressure_and_below_it_by_default() -> None:
    full, hinges = collapse(PRESTWOOD, "structure.fill.passive=1.0")
    default, _ = collapse(PRESTWOOD)
    assert hinges == 4
    assert abs(full / PRESTWOOD.measured - 1.0) < WITHIN
    assert 0.6 < default / PRESTWOOD.measured < 0.8


PAGE = ROOT / "docs" / "howto" / "compas_dem.md"
THEIRS = (11, 24)  # lines that are no comments and not empty: the arch, the cross vault


@pytest.mark.filterwarnings("ignore::masonry_cd.interface.returned.RunWarning")
@pytest.mark.parametrize("number", [0, 1], ids=["arch", "vault"])
def test_an_example_is_no_longer_than_theirs_and_stands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    snippet = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)[number]
    assert sum(bool(line.strip()) for line in snippet.splitlines()) <= THEIRS[number]
    vault = structures.build({"kind": "vault", "form": "cross", "voussoirs": 7, "span": 2.0, "thickness": 0.4}, 2400.0, tmp_path)
    meshfile.write(tmp_path / "crossvault.obj", vault)
    text = (tmp_path / "crossvault.obj").read_text(encoding="utf-8")
    (tmp_path / "crossvault.obj").write_text(re.sub(r"^v (.*)$", _drawn_larger, text, flags=re.MULTILINE), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    exec(compile(snippet, PAGE.name, "exec"), names)
    run = cast(mc.Run, names["run"])
    weight = 9.81 * sum(block.density * block.mass_properties.volume for block in run.scene.structure if not block.fixed)
    assert run.reactions()["fz"].sum() == pytest.approx(weight, rel=0.05)


def _drawn_larger(line: re.Match[str]) -> str:
    """A corner in the units of the drawing, of which 40 are a metre."""
    return "v " + " ".join(repr(40.0 * float(word)) for word in line[1].split())


RIDDLES = re.compile(
    r"\b(told|dear|dearer|goes on with|carries news|room for|left undone|as ever|hereby|whilst|in the place of)\b", re.IGNORECASE
)
LONGEST = 75  # words to a sentence of running text
MODULES = sorted(path for name in ("masonry_cd", "structures", "loads", "reports") for path in (ROOT / name).rglob("*.py"))


def sentences(text: str) -> list[str]:
    """Those of the paragraphs of a page: no fences, tables, headings, lists of links."""
    text = re.sub(r"^(```|~~~).*?^\1", "", text, flags=re.DOTALL | re.MULTILINE)
    paragraphs = [part for part in re.split(r"\n\s*\n|\n(?=\s*[-*\d]+\.? )", text) if not re.match(r"\s*(\||#|    |!\[)", part)]
    return [sentence for part in paragraphs for sentence in re.split(r"(?<=[.:;?!])\s+", part)]


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_pages_say_it_plainly(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    plain = re.sub(r"```.*?```|`[^`]*`", "", text, flags=re.DOTALL)
    assert sorted({found.group() for found in RIDDLES.finditer(plain)}) == []
    assert [sentence for sentence in sentences(text) if len(sentence.split()) > LONGEST] == []


def test_sentences_are_found() -> None:
    assert sentences("# Head\n\nOne. Two\nlines.\n\n```sh\nno. no.\n```\n\n| a. b |\n") == ["One.", "Two\nlines."]


def test_docstrings_say_what_and_not_the_same() -> None:
    vague = []
    for path in MODULES:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and (ast.get_docstring(node) or "").startswith("The same"):
                vague.append(f"{path.relative_to(ROOT)}: {getattr(node, 'name', 'module')}")
    assert vague == []
