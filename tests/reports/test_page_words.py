# SPDX-License-Identifier: GPL-3.0-or-later
"""The words of pages for a client: loads, motions, title block, verdicts, tables; what is filled into a template stays text."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import zlib
from base64 import urlsafe_b64decode
from datetime import date
from html import unescape
from itertools import pairwise
from pathlib import Path
from typing import Any

import browser as browsers
import numpy as np
import pytest
from approvals import DRY, SOUND, TITLED, page_of, stack, states, words
from made_assessment import made, written
from made_run import at_rest, box, shifted, write_run
from made_study import Made, write_study_folder

from masonry_cd.analysis.damage.part_damage import PartDamage, part_damage
from masonry_cd.analysis.deformed import solids_of
from masonry_cd.analysis.limit.outcome import on_the_whole
from masonry_cd.analysis.stress.peaks import largest_pressure
from masonry_cd.analysis.support_motion import support_motions
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from reports.assess.outputs import write_assessment
from reports.damage import write_part_damage
from reports.limit.page import STATES, LimitPage, write_limit_page
from reports.outputs.page import write_pdf
from reports.page import write_page
from reports.page.document import filled
from reports.study.outputs import write_study

SCENE = """[structure]
kind = "file"
[material]
density = 2000.0
friction = 0.6
[[loads]]
kind = "settlement"
supports = ["right"]
direction = "-z"
displacement = 0.03
duration = 0.5
[[loads]]
kind = "point"
block = "beam"
point = [1.0, 0.5, 0.5]
force = [0.0, 0.0, -400e3]
[[loads]]
kind = "push"
direction = [1.0, 0.0, 0.0]
rate = 0.05
[[loads]]
kind = "tie"
blocks = ["beam", "left"]
diameter = 0.02
tension = 5e3
"""


def blocks() -> list[Any]:
    """A beam on three supports."""
    return [
        box("left", (0, 0, -0.2), (0.5, 1, 0), "base", fixed=True),
        box("middle", (1, 0, -0.2), (1.5, 1, 0), "base", fixed=True),
        box("right", (2, 0, -0.2), (2.5, 1, 0), "base", fixed=True),
        box("beam", (0, 0, 0), (2.5, 1, 0.5), "beam"),
    ]


def result(folder: Path, settling: float = -0.03) -> Path:
    rest = at_rest(blocks())
    return write_run(folder / "result.h5", blocks(), [rest, shifted(rest, 2, (0, 0, settling))], scene=SCENE, ended=True)


def page(folder: Path, path: Path) -> tuple[str, dict[str, Any]]:
    """Words and facts of a page."""
    with Results.open(path) as results:
        write_page(results, folder / "report.html")
    text = (folder / "report.html").read_text(encoding="utf-8")
    facts = re.search(r'<script type="application/json" id="facts-data">(.*?)</script>', text, re.DOTALL)
    assert facts is not None
    body = text[text.index("<body>") : text.index('<script type="application/json"')]
    return unescape(re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", body))), json.loads(facts.group(1))


def test_a_support_that_settles_is_not_averaged_with_those_that_do_not(tmp_path):
    with Results.open(result(tmp_path)) as results:
        first, second = support_motions(results, solids_of(results.blocks))
    assert (first.names, second.names) == (("right",), ("left", "middle"))
    assert first.displacement[-1] == pytest.approx([0.0, 0.0, -0.03])
    assert first.moves and not second.moves
    said, facts = page(tmp_path, tmp_path / "result.h5")
    assert facts["motions"] == ["right"] and facts["motions_at_rest"]
    assert "base/0/displacement/z" in json.dumps(facts["contents"])
    assert "right 30 mm 0, 0, −30" in said
    assert "left, middle at rest" in said


def test_supports_that_move_alike_are_one_motion(tmp_path):
    rest = at_rest(blocks())
    path = write_run(tmp_path / "result.h5", blocks(), [rest, shifted(rest, slice(None), (0.02, 0, 0))], scene=SCENE, ended=True)
    said, facts = page(tmp_path, path)
    assert facts["motions"] == [""]
    assert "Motions of the supports" not in said


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


def test_the_axes_of_the_base_and_the_largest_pressure_are_read_from_the_frames(tmp_path):
    force = np.array([[100.0, 50.0], [100.0, 8e5], [100.0, np.nan]])
    path = write_run(tmp_path / "result.h5", stack(), states(along=(0.0, 0.01, 0.0)), histories={"normal_force": force})
    with Results.open(path) as results:
        assert largest_pressure(results) == pytest.approx((8e5, 1, 0.1))  # on one square metre
        write_page(results, tmp_path / "report.html", Summary(**SOUND))
    assert "The support is rigid and moves as prescribed along y." in words((tmp_path / "report.html").read_text(encoding="utf-8"))
    with Results.open(path) as results:
        write_page(results, tmp_path / "report.html", Summary(**SOUND, loads={"base": {"peak_rotation": 1.5}}))
    assert "moves as prescribed along y, and turns by up to 1.5 degrees." in words((tmp_path / "report.html").read_text(encoding="utf-8"))


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


HOSTILE = "<script>alert(1)</script> & //example.org \" '"
TEXT = "&lt;script&gt;alert(1)&lt;&#47;script&gt; &amp; &#47;&#47;example.org &quot; &#x27;"


def run_page(folder: Path, title: str = "A wall") -> str:
    blocks = [box("base", (-1, 0, -0.5), (2, 1, 0), "base", fixed=True), box(HOSTILE, (0, 0, 0), (1, 1, 1), "wall")]
    states = [at_rest(blocks), shifted(at_rest(blocks), 1, (0.01, 0, 0))]
    with Results.open(write_run(folder / "result.h5", blocks, states, title)) as results:
        write_page(results, folder / "report.html", parts=part_damage(results))
    return (folder / "report.html").read_text(encoding="utf-8")


def limit_page(folder: Path, title: str = "An arch") -> str:
    summary = {
        "title": title, "version": "0", "stands": True, "bears_nothing": False, "no_finite_factor": False, "associated": 0.2, "least": None,
        "blocks": 2, "joints": 1, "notes": [title], "modelled": ["masses: 1 t"], "check": None, "ties": [], "certificate": None,
        "rating": None, "service": None,
        "mechanisms": [], "parts": [], "left_open": [], "assumed": {"rows": [], "decides": None, "range": None, "brief": []},
        "solver": {"method": "m", "iterations": 1},
        "verdict": {"state": "not decided", "confidence": "doubtful", "because": "", "reason": title},
        "mechanism": {"of": "associated", "moving_blocks": [title]} | {f"joints_{key}": 0 for key in STATES},
    }  # fmt: skip
    summary["on_the_whole"] = on_the_whole(summary).as_dict()
    write_limit_page(LimitPage(summary, [title], title, [], {"project": title}), {}, folder / "limit.html")
    return (folder / "limit.html").read_text(encoding="utf-8")


def study_page(folder: Path, title: str = "A study") -> str:
    write_study(write_study_folder(folder, Made(records=4, levels=(2.0, 3.0), more={"title": title})))
    return (folder / "study.html").read_text(encoding="utf-8")


def assess_page(folder: Path, title: str = "Made") -> str:
    found = made()
    write_assessment(written(folder, type(found)(title, found.scene, found.assumptions, found.left_out, found.members)))
    return (folder / "assess.html").read_text(encoding="utf-8")


PAGES = (run_page, limit_page, study_page, assess_page)


@pytest.mark.parametrize("page", PAGES)
def test_a_hostile_title_stays_text(page, tmp_path):
    text = page(tmp_path, HOSTILE)
    body = text[text.index("<body") :].partition('<script type="application/json"')[0]
    assert f"<h1>{TEXT}</h1>" in body and f"<title>{TEXT}" in text
    assert "<script>alert" not in text and "//example" not in text


@pytest.mark.parametrize("page", PAGES)
def test_headings_follow_one_another_and_pictures_have_words(page, tmp_path):
    text = page(tmp_path)
    levels = [int(level) for level in re.findall(r"<h([1-6])\b", text[text.index("<body") :])]
    assert levels[0] == 1 and levels.count(1) == 1
    assert all(after <= before + 1 for before, after in pairwise(levels)), levels
    assert all(re.search(r'alt="[^"]{10,}"', image) for image in re.findall(r"<img\b[^>]*>", text))
    named = set(re.findall(r'\bid="([^"]+)"', text))
    assert set(re.findall(r'aria-labelledby="([^"]+)"', text)) | set(re.findall(r'href="#([^"]+)"', text)) <= named
    assert not re.search(r"\{\{|\{%|%\}", text.partition("<body")[2].partition("<script")[0])


def test_a_value_that_nobody_gives_is_an_error():
    from jinja2 import UndefinedError

    with pytest.raises(UndefinedError):
        filled("limit.html")


def test_reports_without_a_page_do_not_load_the_templates():
    code = "import reports.outputs, reports.page, reports.study.outputs, reports.limit.page, sys; sys.exit('jinja2' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
