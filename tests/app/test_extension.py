# SPDX-License-Identifier: GPL-3.0-or-later
"""A kind of structure or load, a record format, a solver, an output, a quantity per step, a code: one file adds it, here in a folder that
its package gets besides."""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Callable, Iterator
from importlib import import_module
from runpy import run_path
from textwrap import dedent

import numpy as np
import pytest
from hostile import refused_at
from made_run import at_rest, box, write_run
from models import box as free
from models import ground
from places import ROOT

import loads
import masonry_cd as mc
import structures
from loads import readers
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.app.commands.solve import solve
from masonry_cd.app.limit_table import limit_table
from masonry_cd.app.run_case import file_names
from masonry_cd.app.scene import read_scene
from masonry_cd.app.static_loads import static_loads
from masonry_cd.foundation.errors import parse_table
from masonry_cd.foundation.extensions import Extensions
from masonry_cd.foundation.table_schema import table_schema
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.solvers import SOLVERS
from masonry_cd.studies.study.plan import perturb
from reports.files import Job, known_files
from reports.settings import report_of

SCENE = """\
[structure]
kind = "slab"
[material]
density = 2000.0
friction = 0.5
[run]
dt = 1e-3
duration = 1.0
"""
SLAB = """\
    from masonry_cd.mechanics.model.blocks import Block
    from structures.geometry.prism import box
    from structures.kind import StructureKind

    def build(table, density, folder):
        return [Block("ground", *box((-2, -2, -1), (2, 2, 0)), density, "base", fixed=True),
                Block("slab", *box((-1, -1, 0), (1, 1, table["thickness"])), density)]

    KIND = StructureKind(build)
"""
ONE_CONTACT = """\
    import numpy as np
    from masonry_cd.mechanics.friction.problem import Solution

    def solve(problem, options, start=None):
        "Of a single contact without friction: p_n = max(0, -q_n / W_nn)."
        impulse = np.zeros((1, 3))
        impulse[0, 0] = max(0.0, -problem.q[0, 0] / problem.w[0, 0])
        return Solution(impulse, None, 1, "one contact: solved")
"""
JOLT = """\
    import numpy as np
    from loads.motion import LoadAction, LoadKind, LoadTable, Static, parse_direction

    class JoltTable(LoadTable):
        "The base moves along x at a constant speed [m/s]; limit analysis pushes."
        speed: float

    def jolt(table, grid, where):
        return LoadAction(motion=lambda times: np.outer(np.full(len(times), table.speed), [1.0, 0.0, 0.0]), lines=(f"{where} jolt",))

    KINDS = {
        "jolt": LoadKind(
            JoltTable,
            jolt,
            static=lambda table, grid, where: Static("a jolt", direction=parse_direction("x")),
            pattern=lambda table: "push",
            grown=lambda keys, factor: {**keys, "speed": factor * keys["speed"]},
        )
    }
"""
TALLY = """\
    import numpy as np
    from loads.readers.source import RawRecord, Reader

    def recognises(source):
        return bool(source.lines) and source.lines[0].startswith("TALLY")

    def read(source, request):
        return RawRecord(np.array([float(line) for line in source.lines[1:]]), 0.01, 0.0, "cm/s2")

    FORMATS = {"tally": Reader(recognises, read)}
"""


@pytest.fixture
def add(tmp_path, monkeypatch) -> Iterator[Callable[[str, str, str], None]]:
    """Put a module into a package, as if its file lay there."""
    added = []

    def put(package: str, name: str, source: str) -> None:
        target, folder = import_module(package), tmp_path / package
        folder.mkdir()
        (folder / f"{name}.py").write_text(dedent(source).replace("\\\\", "\\"), encoding="utf-8")
        monkeypatch.setattr(target, "__path__", [*target.__path__, str(folder)])
        added.append((target, name))

    yield put
    for target, name in added:
        sys.modules.pop(f"{target.__name__}.{name}", None)
        if hasattr(target, name):
            delattr(target, name)


def test_a_structure(add, tmp_path):
    assert "slab" not in structures.KINDS
    add("structures.kinds", "slab", SLAB)
    blocks = structures.build({"kind": "slab", "thickness": 0.3}, 2000.0, tmp_path)
    assert [block.name for block in blocks] == ["ground", "slab"]
    with refused_at("structure.kind"):
        structures.build({"kind": "slap"}, 2000.0, tmp_path)


def test_a_solver(add, tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE)
    with refused_at("run.solver"):
        read_scene(tmp_path / "scene.toml", ["run.solver=one_contact"])
    add("masonry_cd.mechanics.solvers", "one_contact", ONE_CONTACT)
    assert read_scene(tmp_path / "scene.toml", ["run.solver=one_contact"]).run.solver == "one_contact"
    assert "masonry_cd.mechanics.solvers.one_contact" not in sys.modules  # its name was read from the file
    w = np.diag([2.0, 1.0, 1.0])
    at, ends = np.tile(np.arange(3), 3), np.arange(0, 10, 3)
    np.savez(tmp_path / "one.npz", W_data=w.ravel(), W_indices=at, W_indptr=ends, q=[-3.0, 0.0, 0.0], mu=[0.0])
    found = solve(tmp_path / "one.npz", "one_contact", output=tmp_path / "solution.npz").value
    assert found["converged"]
    assert found["reason"] == "one contact: solved"
    assert np.load(tmp_path / "solution.npz")["r"][0] == pytest.approx([1.5, 0.0, 0.0])


def test_a_load(add, tmp_path):
    table = {"kind": "jolt", "speed": 0.4}
    with refused_at("loads[0].kind"):
        loads.build([table], 1e-3, 10, (0.0, 0.0, -9.81), tmp_path)
    add("loads.kinds", "jolt", JOLT)
    loading = loads.build([table], 1e-3, 10, (0.0, 0.0, -9.81), tmp_path)
    assert (loading.support_velocity == [0.4, 0.0, 0.0]).all()
    assert loading.lines[0] == "loads[0] jolt"
    with refused_at("loads[0].speed"):
        loads.build([{"kind": "jolt"}], 1e-3, 10, (0.0, 0.0, -9.81), tmp_path)
    standing = Assembly.from_blocks([ground(2.0), free("stone", (-0.5, -0.5, 0.0), (0.5, 0.5, 1.0))], 0.6)
    pushed = static_loads([table], limit_table({}), (0.0, 0.0, -9.81), tmp_path, standing)
    assert (pushed.kind, pushed.words) == ("push", "a jolt") and pushed.live[1, 0] == pytest.approx(9.81 * standing.mass[1])
    tables = {"loads": [dict(table)]}
    perturb(tables, "loads", 0.5)
    assert tables["loads"][0]["speed"] == pytest.approx(0.6)


def test_a_format_of_records(add, tmp_path):
    (tmp_path / "quake.txt").write_text("TALLY\n1.0\n-2.0\n")
    source = readers.Source.open(tmp_path / "quake.txt", "quake.txt")
    add("loads.readers", "zz_tally", TALLY)  # after "tables", whose formats recognise much
    name, record = readers.read(source, "auto", readers.Request())
    assert name == "tally"
    assert record.values == pytest.approx([1.0, -2.0])


def test_helpers_are_none_and_what_is_not_there_is_a_key_error():
    assert not {"church_parts", "church_table"} & set(structures.KINDS)
    assert not {"options", "nlgs_kernels"} & set(SOLVERS)
    with pytest.raises(KeyError):
        SOLVERS["options"]
    assert not Extensions("structures.layout", "nothing_of_the_kind")


WEIGHT = """\
    from masonry_cd.foundation.csv_files import write_csv
    from reports.files import Output

    def _weight(job):
        rows = ([block.name, f"{block.density * block.mass_properties.volume:.6g}"] for block in job.results.blocks)
        write_csv(job.folder / "weight.csv", ["block", "mass_kg"], rows)
        return [job.folder / "weight.csv"]

    OUTPUTS = {"weight": Output({"weight.csv": "the mass of every block"}, _weight)}
"""


def test_an_output_of_a_run(add, tmp_path):
    """One file: the run writes it where the scene asks, a new run clears it, and the reference lists it."""
    asked = "[report]\nweight = true"
    assert "weight.csv" not in known_files()
    with refused_at("report.weight"):
        report_of(tomllib.loads(asked))
    add("reports.outputs", "weight", WEIGHT)
    blocks = [box("ground", (-1, -1, -1), (1, 1, 0), "base", fixed=True), box("stone", (0, 0, 0), (1, 1, 1))]
    with Results.open(write_run(tmp_path / "result.h5", blocks, [at_rest(blocks)] * 2)) as results:
        assert Job(results, tmp_path, report_of({}), Summary()).write() == [] and not report_of({}).asks
        settings = report_of(tomllib.loads(asked))
        assert Job(results, tmp_path, settings, Summary()).write() == [tmp_path / "weight.csv"] and settings.asks
    assert (tmp_path / "weight.csv").read_text().splitlines()[1:] == ["ground,8000", "stone,2000"]
    assert "weight.csv" in file_names()
    assert "| `weight.csv` | the mass of every block |" in run_path(str(ROOT / "docs" / "write_output_reference.py"))["reference"]()


ISLANDS = """\
    from masonry_cd.app.per_step import Quantity

    QUANTITIES = {"solver/islands": Quantity(lambda made: made.report.islands, "islands of the step", whole=True)}
"""


def test_a_quantity_per_step(add, tmp_path):
    """One file: every run records it, and it is a column of ``run.steps``."""
    add("masonry_cd.app.per_step", "islands", ISLANDS)
    scene = mc.scene(ROOT / "examples" / "trilithon.toml", "run.duration=0.01", "report.crack_map=false")
    run = mc.run(scene, tmp_path / "out", progress=False)
    assert (run.steps["islands"] == 1).all() and run.steps["islands"].dtype == np.int64


SWISS = """\
    from masonry_cd.analysis.code_check.code import Code
    from masonry_cd.analysis.code_check.steps import CodeCheck
    from masonry_cd.analysis.code_check.verdicts import CheckResult

    def check(table, oscillator, ground):
        verdict = CheckResult("linear", ground.peak, oscillator.acceleration(), "m/s2", "9.1")
        return CodeCheck("SIA269", "SIA 269/8", "", ground.words, (), (verdict,))

    CODES = {"SIA269": Code(check, "9.2")}
"""


def test_a_code(add):
    """One file: [limit.check] takes its name, and refuses the keys that it does not know."""
    asked = {"code": "SIA269", "spectrum": "EC8", "ag": 1.0}
    with refused_at("limit.check.code"):
        parse_table(CheckTable, asked, "limit.check")
    add("masonry_cd.analysis.code_check.codes", "sia269", SWISS)
    table = parse_table(CheckTable, asked, "limit.check")
    assert table.by.height == "9.2" and not table.checks_displacements
    with refused_at("limit.check"):
        parse_table(CheckTable, asked | {"limit_state": "SLV"}, "limit.check")
    assert "SIA269" in table_schema(CheckTable)["properties"]["code"]["enum"]
