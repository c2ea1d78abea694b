"""README and the page on the scene file speak of the program as it is: the scene runs, the block file reads, the tables name every key."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from doc_pages import fences
from places import ROOT
from pydantic import BaseModel

from loads.kinds.artificial import ArtificialTable
from loads.kinds.driven import PropTable
from loads.kinds.forces import PointTable, TieTable
from loads.kinds.gravity import GravityTable
from loads.kinds.pulse import PulseTable
from loads.kinds.record import RecordTable
from loads.kinds.sequence import SequenceTable
from loads.kinds.settlement import SettlementTable, SpreadingTable
from loads.kinds.sinusoidal import SinusoidalTable
from loads.kinds.tilt import PushTable, TiltTable
from loads.kinds.vehicle import VehicleTable
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.app.assess_table import AssessTable
from masonry_cd.app.case import prepare
from masonry_cd.app.output_table import CrackTable, JointTable, SupportTable
from masonry_cd.app.output_table import PointTable as PointOutput
from masonry_cd.app.scene import read_scene
from masonry_cd.app.static_loads import CurveTable
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.materials import Material
from reports.settings import Report
from structures.bridge.table import AbutmentTable, FillTable, SpanTable
from structures.bridge.table import WallTable as BridgeWallTable
from structures.files.blockfile import read
from structures.floors import AnchorTable, FloorTable
from structures.kinds.aqueduct import AqueductTable
from structures.kinds.arch import ArchTable
from structures.kinds.bridge import BridgeTable
from structures.kinds.church import ChurchTable
from structures.kinds.column import ColumnTable
from structures.kinds.dome import DomeTable
from structures.kinds.packing import PackingTable
from structures.kinds.tower import TowerTable
from structures.kinds.vault import VaultTable
from structures.kinds.wall import WallTable
from structures.schema import OpeningTable

README = ROOT / "README.md"
SCENE_FILE = ROOT / "docs" / "scene_file.md"


def fenced(page: Path, language: str) -> str:
    """The first code block of a language."""
    return next(fence.text for fence in fences(page) if fence.language == language)


def keys_after(mark: str) -> set[str]:
    """Names in the first column of the first table whose heading, or section, begins with the mark."""
    text = SCENE_FILE.read_text()
    rows = text[text.index(mark) :].split("\n\n")
    table = rows[0] if mark.startswith("|") else next(part for part in rows if part.startswith("| key"))
    first = [line.split("|")[1] for line in table.splitlines()[2:]]
    return set(re.findall(r"`(\w+)`", " ".join(first)))


def test_the_scene_of_the_readme_is_sound(tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text(fenced(README, "toml"))
    case = prepare(read_scene(scene, ["run.duration=0.01"]))
    assert case.assembly.count >= 150


def test_the_block_file_of_the_page_is_sound(tmp_path):
    (tmp_path / "blocks.json").write_text(fenced(SCENE_FILE, "json"))
    (block,) = read(tmp_path / "blocks.json", 2000.0)
    assert (block.name, block.density, block.group) == ("v1", 2200, "arch")


@pytest.mark.parametrize(
    ("mark", "model"),
    [
        ('| `kind = "arch"`', ArchTable),
        ('| `kind = "aqueduct"`', AqueductTable),
        ('| `kind = "bridge"`', BridgeTable),
        ("| `[[structure.spans]]`", SpanTable),
        ("| `[[structure.piers]]`", AbutmentTable),
        ("| `[structure.walls]`", BridgeWallTable),
        ("| `[structure.fill]`", FillTable),
        ('| `kind = "wall"`', WallTable),
        ("| `[[structure.openings]]`", OpeningTable),
        ("| `[[structure.floors]]`", FloorTable),
        ("| `anchors` of a floor", AnchorTable),
        ('| `kind = "tower"`', TowerTable),
        ('| `kind = "column"`', ColumnTable),
        ('| `kind = "vault"`', VaultTable),
        ('| `kind = "dome"`', DomeTable),
        ('| `kind = "church"`', ChurchTable),
        ('| `kind = "packing"`', PackingTable),
        ('| `kind = "sinusoidal"`', SinusoidalTable),
        ('| `kind = "record"`', RecordTable),
        ('| `kind = "sequence"`', SequenceTable),
        ('| `kind = "artificial"`', ArtificialTable),
        ('| `kind = "tilt"`', TiltTable),
        ('| `kind = "push"`', PushTable),
        ('| `kind = "prop"`', PropTable),
        ('| `kind = "pulse"`', PulseTable),
        ("| `[[output.point]]`", PointOutput),
        ("| `[[output.joint]]`", JointTable),
        ("| `[[output.crack]]`", CrackTable),
        ("| `[[output.support]]`", SupportTable),
        ('| `kind = "settlement"`', SettlementTable),
        ('| `kind = "spreading"`', SpreadingTable),
        ('| `kind = "point"`', PointTable),
        ('| `kind = "tie"`', TieTable),
        ('| `kind = "vehicle"`', VehicleTable),
        ('| `kind = "gravity"`', GravityTable),
        ("| `[limit.check]`", CheckTable),
        ("| `[limit.curve]`", CurveTable),
        ("## [material]", Material),
        ("## [assess]", AssessTable),
        ("## [run]", Run),
        ("## [report]", Report),
    ],
)
def test_the_tables_name_every_key_and_no_other(mark: str, model: type[BaseModel]):
    common = {"kind"} | ({"direction"} if mark.startswith("| `kind") else set())
    assert keys_after(mark) - common == set(model.model_fields) - common


def test_the_readme_stays_an_introduction():
    assert len(README.read_text().splitlines()) <= 160
