# SPDX-License-Identifier: GPL-3.0-or-later
"""What is written of an assessment: table, tornado, page."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

from made_assessment import made, row, written
from PIL import Image

from masonry_cd.analysis.run_row import RunRow
from reports.assess.outputs import FILES, text_table, write_assessment

FAILED = RunRow("failed", "blocks <overlap>", 0.1)


def test_all_files_are_written_and_say_the_same(tmp_path: Path) -> None:
    found = made({("friction", "0.4"): FAILED, ("joint stiffness", "E 3.3 GPa"): row(120.0, steps_missed=3)})
    write_assessment(written(tmp_path, found))
    assert {file.name for file in tmp_path.glob("[!.]*")} == set(FILES)
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


def test_the_table_for_people_shows_chance_in_one_row_and_marks_what_missed() -> None:
    found = made({("friction", "0.4"): FAILED, ("joint stiffness", "E 3.3 GPa"): row(120.0, steps_missed=3)})
    lines = text_table(found).splitlines()
    assert sum(line.startswith("ensemble") for line in lines) == 1
    assert any("95.8 to 104" in line for line in lines)
    assert any("E 3.3 GPa" in line and "* 3 steps missed" in line for line in lines)
    alone = made({("friction", "0.4"): row(101.0, steps_missed=1)})
    assert any("* 1 step missed" in line for line in text_table(alone).splitlines())
    assert any("0.4" in line and "failed: blocks <overlap>" in line for line in lines)


def test_without_a_base_case_the_page_says_so_and_has_no_picture(tmp_path: Path) -> None:
    found = made()
    first, *others = found.members
    broken = type(found)(found.title, found.scene, found.assumptions, (), (replace(first, row=FAILED), *others))
    write_assessment(written(tmp_path, broken))
    assert not (tmp_path / "assess.png").exists()
    assert "No verdict" in (tmp_path / "assess.html").read_text(encoding="utf-8")
