# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of spectra, of mechanisms and of faulty blocks, the head of a sheet, and the files of an assessment."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from limit_loads import joined, push_loads
from made_assessment import made, row, written
from models import box, ground, tower
from PIL import Image

from masonry_cd.analysis.code_check.check import check_at
from masonry_cd.analysis.code_check.ground import ground_of
from masonry_cd.analysis.code_check.level import level_of
from masonry_cd.analysis.code_check.spectra import spectra
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.code_check.verdicts import CheckSpectrum
from masonry_cd.analysis.limit.analysis import LimitOptions, analyse
from masonry_cd.analysis.limit.oscillator import Oscillator
from masonry_cd.analysis.run_row import RunRow
from masonry_cd.foundation.errors import parse_table
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.joint_laws import JointLaw
from reports.assess.outputs import FILES, write_assessment
from reports.assess.picture import INDICES
from reports.drawing.figure import COLUMN, MARGIN, TITLE, WIDTH, Sheet, layout
from reports.drawing.palette import CRUSHED, FAULTY, INK
from reports.drawing.parts import Lines, view_named
from reports.drawing.refused_blocks import draw_refused_blocks
from reports.limit.picture import LimitSubject, mechanism_scene
from reports.limit.spectrum_picture import draw_spectra
from structures.geometry.checks import Unsound, check

G = 9.81
WALL = Oscillator(0.125, G, 1.0, 0.5, 0.25, np.array([0.0, 0.5]), np.array([0.125, 0.0]))
HELD = {"spectrum": "EC8", "ag": 1.5, "building_height": 10.0, "building_period": 0.3}


def of(keys: dict[str, Any], folder: Path) -> tuple[CheckSpectrum, ...]:
    """The spectra of the check of a wall, held 6 m up."""
    table = parse_table(CheckTable, keys, "limit.check")
    level, ground = level_of(table, 6.0, 0.0), ground_of(table, folder)
    return spectra(check_at(table, level, WALL, ground), table, ground, G)


def test_a_picture_has_a_panel_for_each_check(tmp_path: Path) -> None:
    times = 0.01 * np.arange(400)
    samples = 1.5 * np.sin(8.0 * times) * np.sin(np.pi * times / 3.99) ** 2
    (tmp_path / "a.csv").write_text("time,a\n" + "\n".join(f"{t:.2f},{a:.8f}" for t, a in zip(times, samples, strict=True)))
    record = {"record": {"path": "a.csv", "units": "m/s2", "correction": "none"}}
    widths = []
    for name, keys in {"both": HELD | {"storeys": 3}, "record": record, "linear": HELD | {"code": "EC8"}}.items():
        with Image.open(draw_spectra(of(keys, tmp_path), tmp_path / f"{name}.png", "A wall", "as built, $ and all")) as drawn:
            widths.append(drawn.width)
            assert np.asarray(drawn.convert("L")).std() > 10.0
    assert widths[0] == widths[1] > 1.3 * widths[2]
    _, displaced = of(record, tmp_path)
    assert displaced.asked[displaced.largest] == pytest.approx(displaced.check.demand, rel=5e-3)


def slabs_pushed(direction: tuple[float, float, float]) -> LimitSubject:
    """Two slabs, which keep a picture from being a front view, in the mechanism of a push."""
    blocks = [ground(8.0), box("one", (0.0, 0.0, 0.0), (0.5, 0.5, 3.0)), box("two", (1.0, 2.0, 0.0), (1.5, 2.5, 3.0))]
    assembly, joints = joined(blocks, 0.6)
    found = analyse(assembly, joints, push_loads(assembly, direction), LimitOptions(starts=0))
    return LimitSubject(found.governing.mechanism, blocks, joints)


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0)])
def test_blocks_move_towards_the_viewer(direction: tuple[float, float, float]) -> None:
    view = mechanism_scene(slabs_pushed(direction), "", "").view
    assert view.towards @ direction > 0.1
    assert np.allclose(np.cross(view.right, view.up), view.towards)


def test_a_view_by_name_stays_and_the_key_has_no_empty_lines() -> None:
    scene = mechanism_scene(slabs_pushed((0.0, 1.0, 0.0)), "", "", "isometric")
    assert np.array_equal(scene.view.towards, view_named("isometric").towards)
    words = [sign.text for sign in scene.key[0].signs]
    assert any(word.startswith("hinge: ") for word in words) and not any(": 0 " in word for word in words)


def test_joints_that_crush_are_outlined_and_counted() -> None:
    blocks = [ground(8.0), box("one", (0.0, 0.0, 0.0), (0.5, 0.5, 3.0))]
    assembly, joints = joined(blocks, 0.6, {"default": JointLaw(compressive_strength=3e5)})
    found = analyse(assembly, joints, push_loads(assembly, (1.0, 0.0, 0.0)), LimitOptions(starts=0))
    scene = mechanism_scene(LimitSubject(found.governing.mechanism, blocks, joints), "", "")
    assert "crushes: 1 joint" in [sign.text for sign in scene.key[0].signs]
    (outline,) = [layer for layer in scene.layers if isinstance(layer, Lines) and layer.colour == CRUSHED]
    assert len(outline.pairs) == 4


LINE = "over all time steps: largest displacement 0.896 m, 4 joints opened, 120 slid, 7 opened and slid, 15 separated"
LONG = f'{LINE} · provisional: the run ended at 12.34 s, the base still moving at 123 mm/s, still moving at 456 mm/s ("facade.12.34")'


def ink(facts: str) -> np.ndarray:
    """Return True for each pixel of the head of a sheet with such facts that is drawn on."""
    sheet = Sheet(layout(1.4))
    sheet.draw_head("A church of which a long title tells", facts)
    return np.asarray((sheet.pixels()[:TITLE] < 200).any(axis=2))


@pytest.mark.parametrize("facts", [LINE, LONG, f"{LINE}\n{LONG}", f"{LONG}\n{LONG}"])
def test_facts_stay_between_the_margins_and_clear_of_the_title(facts: str) -> None:
    drawn = ink(facts)
    assert not drawn[:, :MARGIN].any() and not drawn[:, -MARGIN:].any()
    rows = drawn.any(axis=1)
    assert not rows[0] and not rows[-1]
    starts = np.flatnonzero(np.diff(rows.astype(int)) == 1)
    assert len(starts) >= 2  # the title, and lines below it with white between


FAILED = RunRow("failed", "blocks <overlap>", 0.1)


def test_all_files_are_written_and_say_the_same(tmp_path: Path) -> None:
    found = made({("friction", "0.4"): FAILED, ("joint stiffness", "E 3.3 GPa"): row(120.0, steps_missed=3)})
    write_assessment(written(tmp_path, found))
    assert {file.name for file in tmp_path.glob("[!.]*")} == set(FILES) - {INDICES}
    facts = json.loads((tmp_path / "assess.json").read_text(encoding="utf-8"))
    assert facts["found"]["verdict"].startswith("between D2 and D4; joint stiffness decides; ")
    assert facts["found"]["bars"]["joint stiffness"]["displacement_max"]["shows"] is True
    with (tmp_path / "assess.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(found.members)
    assert {row["reason"] for row in rows if row["status"] == "failed"} == {"blocks <overlap>"}
    assert rows[-1]["displacement_max"] == repr(1e-3 * 97.0)
    page = (tmp_path / "assess.html").read_text(encoding="utf-8")
    assert "Joint stiffness decides" in page
    assert "blocks &lt;overlap&gt;" in page
    assert '<dl class="block"><div><dt>Scene</dt><dd>made.toml</dd></div><div><dt>Program</dt><dd>masonry_cd 1.2.3</dd></div>' in page
    assert "http://" not in page.replace("http://www.w3.org", "")
    with Image.open(tmp_path / "assess.png") as picture:
        assert picture.width > 1500


TOWER = tower(4)
RED = np.array([int(FAULTY[i : i + 2], 16) for i in (1, 3, 5)])


def faulty(which: str) -> list[Block]:
    """A tower whose second stone has a fault."""
    block = TOWER[2]
    bad = {
        "open": replace(block, faces=block.faces[1:]),
        "reversed": replace(block, faces=tuple(face[::-1] for face in block.faces)),
        "bent": replace(block, vertices=block.vertices + np.where(np.arange(8)[:, None] == 6, [0.0, 0.0, 0.02], 0.0)),
        "overlap": replace(block, vertices=block.vertices + [0.0, 0.0, 0.02]),
        "not finite": replace(block, vertices=np.where(np.arange(8)[:, None] == 0, np.nan, block.vertices)),
    }[which]
    return [*TOWER[:2], bad, *TOWER[3:]]


@pytest.mark.parametrize(("which", "names"), [("open", 1), ("reversed", 1), ("bent", 1), ("overlap", 2), ("not finite", 0)])
def test_faulty_blocks_are_drawn_in_colour(tmp_path: Path, which: str, names: int) -> None:
    from matplotlib.image import imread

    with pytest.raises(Unsound) as failure:
        check(faulty(which), "tower.json")
    fault = failure.value
    assert TOWER[2].name in fault.faulty
    draw_refused_blocks(fault.blocks, fault.faulty, str(fault), tmp_path / "problem.png")
    image = (255 * imread(tmp_path / "problem.png")[..., :3]).round().astype(int)
    hue = np.abs(image - (image.max(axis=-1, keepdims=True) / RED.max()) * RED).max(axis=-1) < 12  # the colour, however it is lit
    red = int((hue & (image.max(axis=-1) > 90)).sum())
    assert (red > 10000 * names) if names else (red < 2000)
    named = (image[TITLE + 10 : -50, : WIDTH - COLUMN - 100] == [int(INK[i : i + 2], 16) for i in (1, 3, 5)]).all(axis=-1).sum()
    assert (named > 50) if names else (named == 0), "names next to the model, with a line to each block"
