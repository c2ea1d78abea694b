# SPDX-License-Identifier: GPL-3.0-or-later
"""What the page tells a client: title block, verdicts of its checks, tables to take along; its words are in tests/approved."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import tomllib
import zlib
from base64 import urlsafe_b64decode
from datetime import date
from typing import Any

import browser as browsers
import numpy as np
import pytest
from approvals import DRY, SOUND, TITLED, page_of, stack, states, words
from made_run import at_rest, box, shifted, write_run

from masonry_cd.analysis.damage.part_damage import PartDamage, part_damage
from masonry_cd.analysis.stress.peaks import largest_pressure
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from reports.damage import write_part_damage
from reports.outputs.page import write_pdf
from reports.page import write_page
from reports.settings import report_of


def verdict(text: str, check: str) -> str:
    """The verdict of a check."""
    return re.search(rf'<th scope="row">{check}</th>.*?<span class="verdict \w+">(\w+)</span>', text).group(1)


def test_the_title_block_is_printed_on_each_page_and_names_stay_text(tmp_path):
    text = page_of(tmp_path, TITLED)
    printed = re.search(r"@media print \{ @page \{ (.*?) \} \}\n?</style>", text).group(1)
    assert "@top-left" in printed and "@bottom-center" in printed and "May 2025" in printed
    assert "<3>" not in printed and "//" not in text  # names stay text, wherever they stand


def test_without_a_date_it_is_that_of_today_and_nobody_is_named(tmp_path):
    head = words(page_of(tmp_path))[:300]
    assert f"Date {date.today().isoformat()}" in head
    assert not {"Project", "Client", "Author"} & set(head.split())


@pytest.mark.parametrize("bad", ['""', '"two\\nlines"', "3", f'"{"x" * 201}"'])
def test_a_bad_line_of_the_title_block_is_refused(bad):
    with pytest.raises(InputError) as refused:
        report_of(tomllib.loads(f"[report]\nclient = {bad}"))
    assert refused.value.place == "report.client"


def test_the_axes_of_the_base_and_the_largest_pressure_are_read_from_the_frames(tmp_path):
    force = np.array([[100.0, 50.0], [100.0, 8e5], [100.0, np.nan]])
    path = write_run(tmp_path / "result.h5", stack(), states(along=(0.0, 0.01, 0.0)), histories={"normal_force": force})
    with Results.open(path) as results:
        assert largest_pressure(results) == pytest.approx((8e5, 1, 0.1))  # on one square metre
        write_page(results, tmp_path / "report.html", Summary(**SOUND))
    assert "The support is rigid and moves as prescribed along y." in words((tmp_path / "report.html").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("check", "changes", "expected"),
    [
        ("End of the run", {"stopped": "no solution"}, "doubtful"),
        ("Contact forces", {"closing": {"steps": 3, "jam": "a wedge"}}, "doubtful"),
        ("Energy balance", {"energy": SOUND["energy"] | {"balance_error": 5e-3}}, "look"),
        ("Energy balance", {"energy": SOUND["energy"] | {"balance_error": 0.1}}, "doubtful"),
        ("Energy balance", {"energy": SOUND["energy"] | {"lift_share": 0.1}}, "doubtful"),
        ("Overlap of blocks", {"penetration_max": 5e-4}, "look"),
        ("Overlap of blocks", {"penetration_max": 5e-3}, "doubtful"),
        ("Time step", {"time_step_remarks": ["run.dt 0.01 s is coarse for the shaking"]}, "look"),
        ("Loads", {"loads": {"acted": [{"load": "loads[0]", "measure": "cycles", "share": 0.0}]}}, "look"),
        ("Joint laws", {"shortening_where": "a and b at 1 s", "shortening_max": 1e-3}, "look"),
        ("Model", {"doubts": ["block a falls"]}, "look"),
    ],
)
def test_a_check_that_is_not_met_has_its_verdict(tmp_path, check, changes, expected):
    text = page_of(tmp_path, summary=SOUND | changes, slip=0.02)
    assert verdict(text, check) == expected


def test_the_page_carries_the_tables_of_the_runs_folder(tmp_path):
    text = page_of(tmp_path, slip=0.006)
    facts = json.loads(re.search(r'id="facts-data">(.*?)</script>', text, re.DOTALL).group(1))
    packed = zlib.decompress(urlsafe_b64decode(re.search(r'id="packed-data">([^<]*)<', text).group(1)))
    held, at = {}, 0
    for item in facts["contents"]:
        size = int(np.prod(item["shape"])) * {"uint8": 1, "u1": 1, "u2": 2, "i2": 2, "u4": 4, "f4": 4}[item["kind"]]
        held[item["name"]], at = packed[at : at + size], at + size
    with Results.open(tmp_path / "result.h5") as results:
        damage: PartDamage = part_damage(results)
        write_part_damage(damage, tmp_path)
    for name in ("damage.csv", "damage_history.csv", "drift.csv", "hinges.csv"):
        assert held[f"file/{name}"] == (tmp_path / name).read_bytes()
        assert f'data-file="{name}"' in text
    assert held["file/joints.csv"].startswith(b"joint,block_a,block_b,area")


def test_the_model_is_looked_at_as_the_scene_asks_and_across_a_wall_that_leaves_its_plane(tmp_path):
    def view(folder: str, **more: Any) -> str:
        (tmp_path / folder).mkdir()
        return re.search(r'"view":"(\w+)"', page_of(tmp_path / folder, **more)).group(1)

    assert view("in", slip=0.01) == "front"
    assert view("out", along=(0, 0, 0), slip=0.01, scene=DRY + '[report]\nview = "side"\n') == "side"
    (tmp_path / "across").mkdir()
    moved = shifted(at_rest(stack()), 2, (0, 0.3, 0))
    with Results.open(write_run(tmp_path / "across" / "result.h5", stack(), [at_rest(stack()), moved])) as results:
        write_page(results, tmp_path / "across" / "report.html")
    text = (tmp_path / "across" / "report.html").read_text(encoding="utf-8")
    assert '"view":"isometric"' in text
    assert json.loads(re.search(r'"high":(\[[^\]]*\])', text).group(1))[1] == pytest.approx(0.8)  # the block that went is in view


@pytest.mark.skipif(bool(browsers.missing()) or not shutil.which("pdftotext"), reason="no Chromium, or no pdftotext (poppler-utils)")
def test_each_printed_page_has_its_number_and_the_heads_of_its_tables(tmp_path):
    blocks = [box("ground", (-1, 0, -0.5), (2, 1, 0), "base", fixed=True)]
    blocks += [box(f"stone {k}", (0, 0, 0.1 * k), (1, 1, 0.1 * k + 0.1), "tower") for k in range(60)]
    rest = at_rest(blocks)
    slipped = rest
    for k in range(60):
        slipped = shifted(slipped, slice(k + 1, None), (1e-3, 0, 0))
    scene = DRY + '[report]\nproject = "A tower"\nauthor = "Office"\n'
    with Results.open(write_run(tmp_path / "result.h5", blocks, [rest, slipped], "Tower", scene=scene, ended=True)) as results:
        write_page(results, tmp_path / "report.html", Summary(**SOUND), parts=part_damage(results))
    write_pdf(tmp_path / "report.html", tmp_path / "report.pdf")
    pages = subprocess.run(["pdftotext", tmp_path / "report.pdf", "-"], capture_output=True, text=True, check=True).stdout.split("\f")[:-1]
    assert len(pages) >= 4
    for k, text in enumerate(pages, start=1):
        assert f"{k}/{len(pages)}" in text.replace(" ", "") and "A tower" in text and "Office" in text and date.today().isoformat() in text
    rows = [text for text in pages if "stone" in text and re.search(r"slid\n", text) and "graded" not in text and "[structure]" not in text]
    assert len(rows) >= 2, "the table goes over more than one page"
    assert all("block a" in text for text in rows)
    assert "Joints 1 to 40 of 60 in this order; all of them are in joints.csv" in " ".join(" ".join(pages).split())
