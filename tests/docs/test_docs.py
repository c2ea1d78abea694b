# SPDX-License-Identifier: GPL-3.0-or-later
"""The documentation speaks of the code as it is: the picture shows the packages of the tree, and the examples run."""

from __future__ import annotations

import importlib.util
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import scenes
from doc_pages import DOCS, PAGES, page_name
from models import stepper, tower

import masonry_cd.mechanics.solvers
from masonry_cd import __version__
from masonry_cd.mechanics.friction.problem import Problem, natural_map_error
from masonry_cd.mechanics.solvers import SOLVERS, Options

ROOT = Path(__file__).resolve().parents[2]
JACOBI = ROOT / "examples" / "solver" / "jacobi.py"


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


@pytest.fixture
def added(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The example put where the program looks for solvers."""
    package = masonry_cd.mechanics.solvers
    monkeypatch.setattr(package, "__path__", [*package.__path__, str(JACOBI.parent)])
    yield
    sys.modules.pop("masonry_cd.mechanics.solvers.jacobi", None)


def test_every_package_of_the_tree_is_drawn(picture: ModuleType, found: dict[str, tuple]) -> None:
    homes = [ROOT / "masonry_cd", ROOT / "masonry_cd" / "mechanics"]
    core = {str(path.parent.relative_to(ROOT)) for home in homes for path in home.glob("*/__init__.py")} - {"masonry_cd/mechanics"}
    assert set(found) == core | {"structures", "loads", "reports"}
    assert {name for floor in picture.floors() for name in floor} == set(found)


def test_the_picture_is_that_of_the_code(picture: ModuleType, found: dict[str, tuple]) -> None:
    assert picture.drawn() == picture.as_drawn(found), "draw it again: python docs/draw_architecture.py"


def test_the_picture_is_drawn_alike_twice(picture: ModuleType, found: dict[str, tuple], tmp_path: Path) -> None:
    first, second = tmp_path / "1.png", tmp_path / "2.png"
    picture.draw(first, found)
    picture.draw(second, found)
    assert first.read_bytes() == second.read_bytes()
    assert str(ROOT).encode() not in first.read_bytes()


def test_imports_are_read_with_their_place(found: dict[str, tuple]) -> None:
    assert "masonry_cd/mechanics/friction" in found["masonry_cd/mechanics/solvers"].imports
    assert "structures" in found["masonry_cd/app"].lazy  # imported inside functions: a run without blocks never needs gmsh
    assert all(name not in package.imports + package.lazy for name, package in found.items())


@pytest.mark.parametrize("problem", [scenes.tower(3), scenes.tower(2).to_local()], ids=["bodies", "local"])
def test_the_example_of_a_solver_solves(jacobi: ModuleType, problem: Problem) -> None:
    solution = jacobi.solve(problem, Options(tolerance=1e-6))
    assert 0 < solution.iterations < 2000
    assert natural_map_error(problem, solution.impulse) < 1e-6
    again = jacobi.solve(problem, Options(tolerance=1e-6))
    assert np.array_equal(solution.impulse, again.impulse)
    missed = jacobi.solve(problem, Options(tolerance=1e-12, max_iterations=40))
    assert missed.iterations == 40


@pytest.mark.usefixtures("added")
def test_one_file_adds_a_solver() -> None:
    assert "jacobi" in SOLVERS
    machine = stepper(tower(2), 5, solver="jacobi", tolerance=1e-6)
    reports = [machine.step() for _ in range(5)]
    assert reports[0].iterations > 0
    assert max(report.error for report in reports) < 1e-6
    assert np.abs(machine.state.position - machine.assembly.centre).max() < 1e-6


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
