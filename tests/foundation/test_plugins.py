# SPDX-License-Identifier: GPL-3.0-or-later
"""Additions by a package, and by a file of the user's: the example package is installed next to the tests, and each of its parts used."""

from __future__ import annotations

import csv
import json
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from command_line import masonry_cd
from hostile import refused_at
from places import ROOT

import masonry_cd as mc
from masonry_cd.foundation import plugins
from masonry_cd.foundation.trust import VARIABLE, is_trusted
from masonry_cd.interface import protocols
from masonry_cd.interface.events import EVENTS
from masonry_cd.studies.assess.assumptions import assumptions_of

pytestmark = pytest.mark.filterwarnings("ignore::masonry_cd.interface.returned.RunWarning")
EXAMPLE = ROOT / "examples" / "plugin"
SCENE = """\
[structure]
kind = "stack"
cubes = 2

[material]
density = 2000.0
friction = 0.6

[[loads]]
kind = "surge"
amplitude = 0.1
length = 0.05

[run]
dt = 2e-3
duration = 0.02

[report]
heights = true
"""


def install(folder: Path) -> None:
    """Install the metadata that ``pip install --no-deps`` leaves of a package in a folder: its modules are found in place."""
    project = tomllib.loads((EXAMPLE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    about = folder / f"{project['name'].replace('-', '_')}-{project['version']}.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n")
    lines = [
        f"[{group}]\n" + "".join(f"{name} = {place}\n" for name, place in own.items()) for group, own in project["entry-points"].items()
    ]
    (about / "entry_points.txt").write_text("\n".join(lines))


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The example package is installed."""
    (tmp_path / "site").mkdir()
    install(tmp_path / "site")
    monkeypatch.syspath_prepend(tmp_path / "site")
    monkeypatch.syspath_prepend(EXAMPLE)
    plugins.entries.cache_clear()
    yield
    plugins.entries.cache_clear()
    for name in [name for name in sys.modules if name.startswith("masonry_cd_stacks")]:
        del sys.modules[name]


@pytest.fixture(autouse=True)
def trusting_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forget the trust of a command in this process at the end of the test."""
    monkeypatch.setenv(VARIABLE, "")


def command(*words: object) -> tuple[int, str]:
    """Run the command line: exit code, and all that it prints."""
    done = masonry_cd(*words)
    return done.exit_code, done.output


@pytest.mark.usefixtures("installed")
def test_a_scene_uses_kinds_and_a_report_of_a_package(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(SCENE)
    code, said = command("run", tmp_path / "scene.toml", "-o", tmp_path / "out", "-q", "--set", "loads[0].amplitude=4 mm/s")
    assert code == 0 and "loads[0].amplitude = 0.004 m/s: the ground moves at" in said
    rows = list(csv.DictReader((tmp_path / "out" / "heights.csv").open(encoding="utf-8")))
    assert [row["block"] for row in rows] == ["plate", "cube1", "cube2"]
    assert float(rows[2]["height_m"]) == pytest.approx(0.75, abs=1e-3)
    run = mc.open(tmp_path / "out")
    assert run.summary["loads"]["tables"][0]["kind"] == "surge"
    assert run.scene.structure.names == ["plate", "cube1", "cube2"]


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize("form", ["auto", "lab"])
def test_a_record_is_read_by_a_reader_of_a_package(tmp_path: Path, form: str) -> None:
    values = [0.0, 1.0, 0.5, -2.0, 0.0, 0.0, 1.0, 0.0, 0.5, 0.0]
    (tmp_path / "quake.txt").write_text("LAB dt=0.01 unit=m/s2\n" + "".join(f"{value}\n" for value in values))
    load = f'kind = "record"\npath = "quake.txt"\nformat = "{form}"\ncorrection = "none"\ndirection = "x"'
    text = SCENE.replace('kind = "surge"\namplitude = 0.1\nlength = 0.05', load).partition("[report]")[0]
    (tmp_path / "scene.toml").write_text(text)
    run = mc.run(tmp_path / "scene.toml", progress=False)
    assert run.summary["loads"]["tables"][0]["before"]["pga"] == pytest.approx(2.0)


@pytest.mark.usefixtures("installed")
def test_the_command_lists_them_and_a_scene_without_them_imports_none(tmp_path: Path) -> None:
    code, said = command("plugins")
    assert code == 0
    assert "structure stack: masonry-cd-stacks 0.1.0, masonry_cd_stacks.stack:STACK" in said.splitlines()
    assert {line.partition(" ")[0] for line in said.splitlines()} == {
        "structure",
        "load",
        "reader",
        "report",
        "mechanism",
        "joint",
        "solver",
    }
    assert not any(name.startswith("masonry_cd_stacks") for name in sys.modules)


def test_a_scene_that_needs_no_package_looks_for_none() -> None:
    script = (
        "import sys, masonry_cd as mc; mc.scene('examples/trilithon.toml').structure; "
        "from masonry_cd.foundation import plugins; print(plugins.entries.cache_info().currsize)"
    )
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "0"


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("structure.kind=stak", '"stak" (did you mean "stack"?)'),
        ("loads[0].kind=surg", '"surg" (did you mean "surge"?)'),
        ("structure.cubs=3", "structure.cubs: unknown key"),
        ("loads[0].amplitude=-1", "loads[0].amplitude"),
        ("report.height=true", '(did you mean "heights"?)'),
    ],
)
def test_what_is_wrong_is_said_in_a_line(tmp_path: Path, change: str, words: str) -> None:
    (tmp_path / "scene.toml").write_text(SCENE)
    code, said = command("run", tmp_path / "scene.toml", "-o", tmp_path / "out", "--set", change)
    assert code == 2 and words in said and said.count("\n") == 1


def test_a_package_that_cannot_be_used_is_named(installed: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "masonry_cd_stacks.stack", None)
    (tmp_path / "scene.toml").write_text(SCENE)
    code, said = command("build", tmp_path / "scene.toml", "-o", tmp_path / "out", "--no-picture")
    assert code == 2 and 'plug-in "stack" of masonry-cd-stacks 0.1.0 cannot be used' in said and said.count("\n") == 1


def test_a_file_of_the_users_runs_only_where_the_command_line_trusts_it(tmp_path: Path) -> None:
    mark = tmp_path / "ran"
    code = (EXAMPLE / "masonry_cd_stacks" / "stack.py").read_text(encoding="utf-8")
    (tmp_path / "own.py").write_text(f"open({str(mark)!r}, 'w').close()\n{code.replace('from __future__ import annotations', '')}")
    text = SCENE.replace('"stack"', '"own.py:build"').replace("[run]", "trusted = true\n[run]").partition("[[loads]]")[0]
    (tmp_path / "scene.toml").write_text(text + "[run]\ndt = 2e-3\nduration = 0.01\n")
    asked = ("build", tmp_path / "scene.toml", "-o", tmp_path / "out", "--no-picture")
    exit_code, said = command(*asked)
    assert exit_code == 2 and said.count("\n") == 1
    assert "own.py is a program that runs with your rights; if you trust it, pass --trust" in said
    assert not mark.exists() and not (tmp_path / "out").exists()
    exit_code, said = command(*asked, "--trust")
    assert exit_code == 0, said
    assert mark.exists()
    assert command(*asked, "--force")[0] == 2 and not is_trusted()  # it holds for one command
    for name, words in (("own.py:no", 'own.py defines no "no"'), ("none.py:build", "no file")):
        exit_code, said = command(*asked, "--force", "--trust", "--set", f"structure.kind={name}")
        assert exit_code == 2 and words in said


def test_a_load_of_the_users_and_trust_from_python(tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text((EXAMPLE / "masonry_cd_stacks" / "surge.py").read_text(encoding="utf-8"))
    scene = mc.scene(ROOT / "examples" / "trilithon.toml", "run.duration=0.02")
    scene = scene.changed(loads=[{"kind": f"{tmp_path / 'own.py'}:SURGE", "amplitude": 0.1, "length": 0.01}])
    with refused_at("loads[0].kind"):
        mc.Simulation(scene)
    mc.trust()
    try:
        sim = mc.Simulation(scene)
        sim.run()
    finally:
        mc.trust(False)
    assert sim.state.position[0, 0] == pytest.approx(0.5 * 0.1 * 0.01, rel=0.05)


@pytest.mark.usefixtures("installed")
def test_what_the_example_adds_is_what_the_protocols_say() -> None:
    load = {plugin.group: plugins.load(plugin.group, plugin.name) for plugin in mc.plugins()}
    assert isinstance(load["loads"], protocols.LoadKind) and isinstance(load["readers"], protocols.RecordReader)
    assert isinstance(load["reports"], protocols.Report) and callable(load["structures"].build)
    assert isinstance(load["joint_laws"], protocols.JointLaw) and callable(load["mechanisms"])
    assert set(load) == set(plugins.CALLED)


def test_the_page_has_every_contract() -> None:
    page = (ROOT / "docs" / "plugins.md").read_text(encoding="utf-8")
    calls = [f"`{name}({given})`" for group in plugins.CALLED.values() for name, given in group.items()]
    assert [call for call in [*calls, *(f"`f({given})`" for given in EVENTS.values())] if call not in page] == []
    assert [group for group in plugins.CALLED if f"`masonry_cd.{group}`" not in page] == []


@pytest.mark.usefixtures("installed")
def test_a_kind_of_a_package_has_a_starter_doubts_units_sizes_and_parts(tmp_path: Path) -> None:
    code, said = command("init", "stack", "-o", tmp_path / "scene.toml")
    assert code == 0, said
    code, said = command("build", tmp_path / "scene.toml", "-o", tmp_path / "out", "--no-picture", "--set", "structure.side=50 m")
    assert code == 0 and 'structure.side = 50 m: cubes are 1 cm (a model) to 5 m wide; for mm write "50 mm"' in said
    scene = mc.scene(tmp_path / "scene.toml")
    (sizes,) = (one for one in assumptions_of(scene.checked, scene.tables, shakes=False)[0] if one.name == "block size")
    tables = scene.tables
    sizes.levels[0].change(tables)
    assert sizes.levels[0].name == "x 0.7" and tables["structure"]["cubes"] == 6
    code, said = command("limit", tmp_path / "scene.toml", "--macro-elements", "--no-picture", "-o", tmp_path / "parts")
    assert code == 0 and "whole" in said


TOWER = (
    SCENE.partition("[[loads]]")[0]
    + """\
[limit]
push = "x"

[[limit.mechanism]]
group = "stack"
direction = "x"
mechanisms = ["toppling"]
"""
)


@pytest.mark.usefixtures("installed")
def test_a_mechanism_of_a_package_has_its_factor(tmp_path: Path) -> None:
    """Cubes of side a: what topples first is the whole stack, at a / (2 a)."""
    (tmp_path / "scene.toml").write_text(TOWER)
    code, said = command("limit", tmp_path / "scene.toml", "-o", tmp_path / "out")
    assert code == 0, said
    rows = list(csv.DictReader((tmp_path / "out" / "mechanisms.csv").open(encoding="utf-8")))
    own = [row for row in rows if row["mechanism"].startswith("toppling")]
    assert own and min(float(row["alpha0"]) for row in own) == pytest.approx(0.5, rel=1e-3)
    (tmp_path / "scene.toml").write_text(TOWER.replace("toppling", "topling"))
    code, said = command("limit", tmp_path / "scene.toml", "-o", tmp_path / "out2")
    assert code == 2 and '"topling" (did you mean "toppling"?)' in said and said.count("\n") == 1


@pytest.mark.usefixtures("installed")
def test_a_joint_law_of_a_package_holds_what_friction_does_not(tmp_path: Path) -> None:
    """A push of 0.8 of the weight, above friction: dry it slides, glued it does not."""
    pulse = 'kind = "pulse"\ndirection = "x"\nacceleration = 7.8\nduration = 0.06'
    text = SCENE.replace('kind = "surge"\namplitude = 0.1\nlength = 0.05', pulse)
    (tmp_path / "scene.toml").write_text(
        text.replace("cubes = 2", "cubes = 1").replace("duration = 0.02", "duration = 0.06").partition("[report]")[0]
    )
    gone = {}
    for law in (None, "glue"):
        sim = mc.Simulation(mc.scene(tmp_path / "scene.toml"), law=law)
        start = sim.state.position[-1, 0]
        sim.run()
        gone[law] = sim.state.position[-1, 0] - start
    assert gone[None] > 5e-4 and gone["glue"] < 0.5 * gone[None]
    with pytest.raises(mc.InputError, match=r'"glu" \(did you mean "glue"'):
        mc.Simulation(mc.scene(tmp_path / "scene.toml"), law="glu")


@pytest.mark.usefixtures("installed")
def test_a_solver_of_a_package_makes_runs_and_solves_files(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(SCENE.partition("[report]")[0].replace("duration = 0.02", 'duration = 0.02\nsolver = "jacobi"'))
    code, said = command("run", tmp_path / "scene.toml", "-o", tmp_path / "out", "-q", "--dump-problem", 5, "--set", "run.tolerance=1e-5")
    assert code == 0, said
    solver = mc.open(tmp_path / "out").summary["solver"]
    assert solver["name"] == "jacobi" and solver["steps_missed"] == 0 and 0.0 < solver["error_max"] < 1e-5
    problem = next((tmp_path / "out").glob("problem_5*.npz"))
    code, said = command("solve", problem, "--solver", "jacobi", "--tolerance", 1e-5, "--json")
    assert code == 0 and json.loads(said)["converged"]
    code, said = command("accuracy", problem, "-o", tmp_path / "rows", "--solvers", "jacobi,nlgs", "--tolerances", "1e-3", "--repeats", 1)
    assert code == 0 and "jacobi: reached all" in said
    for words in (("solve", problem, "--solver"), ("accuracy", problem, "-o", tmp_path / "no", "--solvers")):
        code, said = command(*words, "jacoby")
        assert code == 2 and '"jacoby" (did you mean "jacobi"?)' in said


@pytest.mark.parametrize(
    ("module", "function", "contract"),
    [
        ("stack", "def build(", plugins.CALLED["structures"]["build"]),
        ("surge", "def surge(", plugins.CALLED["loads"]["part"]),
        ("jacobi", "def solve(", plugins.CALLED["solvers"]["solve"]),
        ("glue", "def stresses(", plugins.CALLED["joint_laws"]["function"]),
    ],
)
def test_a_function_that_takes_something_else_is_said_in_a_line(
    installed: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module: str, function: str, contract: str
) -> None:
    """Before anything runs: the contract, and what the function takes."""
    own = tmp_path / "masonry_cd_stacks"
    shutil.copytree(EXAMPLE / "masonry_cd_stacks", own)
    text = (own / f"{module}.py").read_text(encoding="utf-8")
    (own / f"{module}.py").write_text(text.replace(function, function.replace("(", "(more, also, ")))
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE)
    with pytest.raises(mc.InputError) as refused:
        mc.Simulation(mc.scene(tmp_path / "scene.toml", "run.solver=jacobi"), law="glue")
    assert len(refused.value.lines) == 1
    assert "(more, also, " in str(refused.value) and f"({contract}) is needed" in str(refused.value)


@pytest.mark.usefixtures("installed")
def test_the_schema_has_the_keys_of_a_packages_kinds() -> None:
    code, said = command("schema")
    assert code == 0
    keys = json.loads(said)["properties"]
    assert "jacobi" in keys["run"]["properties"]["solver"]["enum"]
    (stack,) = [one for one in keys["structure"]["oneOf"] if one["properties"]["kind"]["const"] == "stack"]
    assert {"cubes", "side", "ground"} <= set(stack["properties"])
    (surge,) = [one for one in keys["loads"]["items"]["oneOf"] if one["properties"]["kind"]["const"] == "surge"]
    assert set(surge["required"]) == {"kind", "amplitude", "length"}
