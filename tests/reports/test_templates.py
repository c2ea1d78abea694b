# SPDX-License-Identifier: GPL-3.0-or-later
"""Pages by templates: what is filled in is text, what is missing is an error, and headings go down by one."""

from __future__ import annotations

import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest
from made_assessment import made, written
from made_run import at_rest, box, shifted, write_run
from made_study import Made, write_study_folder

from masonry_cd.analysis.damage.part_damage import part_damage
from masonry_cd.analysis.limit.outcome import on_the_whole
from masonry_cd.io.results import Results
from reports.assess.outputs import write_assessment
from reports.limit.page import STATES, LimitPage, write_limit_page
from reports.page import write_page
from reports.page.document import filled
from reports.study.outputs import write_study

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
        "mechanisms": [], "parts": [], "left_open": [], "without": [],
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
