# SPDX-License-Identifier: GPL-3.0-or-later
"""What the page tells a client: title block, findings in their order, assumptions and limits, checks in words, tables to take along."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import tomllib
import zlib
from base64 import urlsafe_b64decode
from datetime import date
from html import unescape
from pathlib import Path
from typing import Any

import browser as browsers
import numpy as np
import pytest
from made_run import at_rest, box, shifted, write_run

from masonry_cd.analysis.damage.part_damage import PartDamage, part_damage
from masonry_cd.analysis.stress.joint_pressure import largest_pressure
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from reports.damage import write_part_damage
from reports.outputs.page import write_pdf
from reports.page import write_page
from reports.settings import report_of

DRY = '[structure]\nkind = "file"\n[material]\ndensity = 2000.0\nfriction = 0.6\n[run]\ndt = 1e-3\nduration = 0.2\n'
SOUND: dict[str, Any] = {
    "steps": 200,
    "dt": 1e-3,
    "stopped": "",
    "solver": {"tolerance": 1e-6, "error_max": 9e-7, "error_mean": 1e-8},
    "closing": {"steps": 0, "jam": ""},
    "energy": {"at_rest": False, "balance_error": 1e-9, "balance_max": 1e-7, "lift_share": 0.0},
    "penetration_max": 2e-5,
    "penetration_where": "",
    "time_step_remarks": [],
    "planar": False,
}


def stack() -> list:
    """Two blocks on a base."""
    return [
        box("base", (-1, 0, -0.5), (2, 1, 0), "base", fixed=True),
        box("lower", (0, 0, 0), (1, 1, 1), "wall"),
        box("upper", (0, 0, 1), (1, 1, 2), "wall"),
    ]


def states(along: tuple[float, float, float] = (0.02, 0.0, 0.0), slip: float = 0.0) -> list:
    """The base goes along a vector and back, and the upper block has slipped; at rest in the end."""
    rest, slipped = at_rest(stack()), shifted(at_rest(stack()), 2, (slip, 0, 0))
    return [rest, shifted(slipped, slice(None), along), slipped]


def page_of(folder: Path, scene: str = DRY, summary: dict[str, Any] | None = None, **more: Any) -> str:
    """The text of the page of such a run."""
    moved = states(**{key: more.pop(key) for key in ("along", "slip") if key in more})
    with Results.open(write_run(folder / "result.h5", stack(), moved, "Two blocks", scene=scene, ended=True, **more)) as results:
        write_page(results, folder / "report.html", Summary(**(SOUND if summary is None else summary)), parts=part_damage(results))
    return (folder / "report.html").read_text(encoding="utf-8")


def words(text: str) -> str:
    """What a reader reads of the page, tags left out."""
    body = text[text.index("<body>") : text.index('<script type="application/json"')]
    return unescape(re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", body)))


def verdict(text: str, check: str) -> str:
    """The verdict of a check."""
    return re.search(rf'<th scope="row">{check}</th>.*?<span class="verdict \w+">(\w+)</span>', text).group(1)


def test_floors_of_the_scene_are_called_rigid_and_only_these(tmp_path):
    floor = '[[structure.floors]]\nheight = 3.0\nthickness = 0.2\nmass = 300.0\nwalls = ["*"]\n'
    said = "Bending, shear and stretching of the floors"
    assert said in words(page_of(tmp_path, DRY + floor))
    assert said not in words(page_of(tmp_path, DRY))


def test_the_title_block_says_whose_report_it_is(tmp_path):
    given = '[report]\nproject = "Garden wall <3>"\nclient = "City//Works"\nauthor = "A. Engineer"\ndate = "May 2025"\n'
    text = page_of(tmp_path, DRY + given)
    head = words(text)[:600]
    for said in ("Project Garden wall <3>", "Client City//Works", "Author A. Engineer", "Date May 2025", "Program masonry_cd", "SHA-256"):
        assert said in head, said
    printed = re.search(r"@media print \{ @page \{ (.*?) \} \}\n?</style>", text).group(1)
    assert "@top-left" in printed and "@bottom-center" in printed and "May 2025" in printed
    assert "<3>" not in printed and "//" not in text  # names stay text, wherever they stand


def test_without_a_date_it_is_that_of_today_and_nobody_is_named(tmp_path):
    head = words(page_of(tmp_path))[:300]
    assert f"Date {date.today().isoformat()}" in head
    assert not {"Project", "Client", "Author"} & set(head.split())


@pytest.mark.parametrize("bad", ['""', '"two\\nlines"', "3", f'"{"x" * 201}"'])
def test_a_bad_line_of_the_title_block_is_refused(bad):
    with pytest.raises(InputError, match=r"report\.client"):
        report_of(tomllib.loads(f"[report]\nclient = {bad}"))


def test_parts_come_before_joints_and_limits_after_them(tmp_path):
    text = page_of(tmp_path, slip=0.006)
    places = [text.index(f'id="{name}-title"') for name in ("parts", "model", "damage", "limits", "trust", "grades", "tables", "settings")]
    assert places == sorted(places)
    assert "D2 moderate damage : sliding 6 mm" in words(text)
    older = "largest drifts, of which this result file has no others, are over the 3 frames of the history, 100 ms apart."
    assert older in words(text)


def test_largest_drifts_of_a_run_are_over_all_time_steps(tmp_path):
    rest = at_rest(stack())
    states = [rest, shifted(rest, 2, (0.02, 0, 0)), rest]
    with Results.open(write_run(tmp_path / "result.h5", stack(), states, scene=DRY, ended=True, every=2)) as results:
        write_page(results, tmp_path / "report.html", Summary(**SOUND), parts=part_damage(results))
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Largest openings, slidings and drifts are over all time steps; mechanisms are those at the end." in words(text)
    assert 'data-name="largest drift [%]"' in text or "largest drift [%]" in words(text)


def test_the_grades_are_those_of_ems_98_with_the_numbers_in_force(tmp_path):
    said = words(page_of(tmp_path))
    assert "Grünthal" in said and "hair-line cracks in very few walls" in said and "total or near total collapse" in said
    assert "D2 moderate damage" in said and "5 mm" in said and "0.3 %" in said


def test_dry_joints_their_friction_and_what_is_left_out_are_said(tmp_path):
    said = words(page_of(tmp_path))
    for line in (
        "The 2 blocks that are free to move are rigid, of uniform density (2000 kg/m³)",
        "with the coefficient 0.6, an angle of 31° in all joints",
        "Joints are rigid and dry: they bear no tension",
        "crushing of the blocks",
        "The vertical component of the motion: the base moves along x only",
        "Ties and anchors: none is in the model",
    ):
        assert line in said, line


def test_mortar_is_described_by_its_numbers_and_a_vertical_motion_is_not_called_left_out(tmp_path):
    law = "[material.joints.wall-wall]\nnormal_stiffness = 2e10\ncohesion = 1.5e5\ntension = 1e5\n"
    friction = "[material.friction]\ndefault = 0.6\nwall-base = 0.4\n"
    scene = DRY.replace("friction = 0.6\n", "") + friction + law
    said = words(page_of(tmp_path, scene, along=(0.01, 0, 0.01)))
    assert "Joints of wall-wall: elastic, 20 GN/m³ across and 8.33 GN/m³ along, mortar with a cohesion of 150 kPa" in said
    assert "0.4, an angle of 21.8° (wall-base)" in said
    assert "All other joints are rigid and dry" in said
    assert "vertical component" not in said


def test_the_axes_of_the_base_and_the_largest_pressure_are_read_from_the_frames(tmp_path):
    force = np.array([[100.0, 50.0], [100.0, 8e5], [100.0, np.nan]])
    path = write_run(tmp_path / "result.h5", stack(), states(along=(0.0, 0.01, 0.0)), histories={"normal_force": force})
    with Results.open(path) as results:
        assert largest_pressure(results) == pytest.approx((8e5, 1, 0.1))  # on one square metre
        write_page(results, tmp_path / "report.html", Summary(**SOUND))
    assert "The support is rigid and moves as prescribed along y." in words((tmp_path / "report.html").read_text(encoding="utf-8"))


def test_a_sound_run_passes_all_checks(tmp_path):
    text = page_of(tmp_path)
    assert "All checks of the computation are good" in words(text)
    assert set(re.findall(r'class="verdict (\w+)"', text)) == {"good"}


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
def test_a_check_that_is_not_met_says_what_to_do(tmp_path, check, changes, expected):
    text = page_of(tmp_path, summary=SOUND | changes, slip=0.02)
    assert verdict(text, check) == expected
    first = {"look": "Read this before you rely on the run", "doubtful": "Do not rely on this run before it is mended"}[expected]
    assert f"{first}: {check.lower()}." in words(text)


def test_a_run_without_a_summary_says_that_its_checks_are_unknown(tmp_path):
    assert "The run left no summary, so its checks are not known" in words(page_of(tmp_path, summary={}))


def test_the_load_factor_of_a_tilt_is_given_with_its_angle(tmp_path):
    factor = {"end": 0.3, "limit": 2e-3, "given_way": 0.25, "given_way_time": 1.5}
    scene = DRY + '[[loads]]\nkind = "tilt"\ndirection = "x"\nrate = 3.0\n'
    said = words(page_of(tmp_path, scene, SOUND | {"load_factor": factor}))
    assert re.search(r"gave way at the load factor λ = 0\.25 \(14°\) , at 1\.5 s, when a block had moved by more than 2 mm", said)
    (tmp_path / "push").mkdir()
    still = {"load_factor": factor | {"given_way": None, "given_way_time": None}}
    said = words(page_of(tmp_path / "push", DRY, SOUND | still))
    assert "still stood at the load factor λ = 0.3 , with which the run ended" in said


def test_a_factor_on_rigid_joints_is_not_passed_off_as_the_least(tmp_path):
    factor = {"end": 0.3, "limit": 2e-3, "given_way": 0.25, "given_way_time": 1.5, "rigid": True}
    said = words(page_of(tmp_path, DRY, SOUND | {"load_factor": factor}))
    assert (
        "This run found one, not the least, and another solver or seed may find another: the command masonry-cd limit gives the bracket"
        in said
    )
    (tmp_path / "planar").mkdir()
    bracket = {"limit_analysis": {"least_found": 0.2231, "associated": 0.2712}}
    said = words(page_of(tmp_path / "planar", DRY, SOUND | {"load_factor": factor | bracket}))
    assert "limit analysis has 0.223, the least found without dilation, to 0.271, the associated value" in said
    (tmp_path / "no end").mkdir()
    bracket["limit_analysis"]["least_found"] = None
    said = words(page_of(tmp_path / "no end", DRY, SOUND | {"load_factor": factor | bracket}))
    assert "limit analysis has no least factor, at most 0.271, the associated value" in said
    for name, least, upper, expected in (
        ("one", 0.2712, 0.2712, "Limit analysis has 0.271: how joints slide makes no difference here"),
        ("wedged", 0.1667, None, "limit analysis has 0.167, the least found without dilation, and no finite associated value"),
    ):
        (tmp_path / name).mkdir()
        bracket["limit_analysis"] = {"least_found": least, "associated": upper}
        said = words(page_of(tmp_path / name, DRY, SOUND | {"load_factor": factor | bracket}))
        assert expected in said and ("This run found one" in said) is (name == "wedged")


def test_shaking_and_ties_have_tables(tmp_path):
    peaks = {"pga": 3.0, "pgv": 0.3, "pgd": 0.02}
    shock = {"name": "foreshock", "components": [{"direction": [0, 1, 0], "after": peaks}]}
    tables = [{"kind": "sinusoidal", "direction": [1, 0, 0], "after": peaks}, {"kind": "sequence", "shocks": [shock]}]
    tie = {"blocks": ["a", "b"], "tension_max": 1.05e6, "stress_max": 2.1e8, "tension_max_time": 1.234, "tension_end": 2e3}
    yielded = tie | {"name": "nave", "yield_time": 0.5123}
    text = page_of(tmp_path, summary=SOUND | {"loads": {"tables": tables}, "ties": [tie, yielded]})
    said = words(text)
    assert "load 1, sinusoidal x 3 (0.31 g) 30 cm/s 20 mm" in said and "foreshock y 3 (0.31 g)" in said
    assert "a to b 1.05 MN 210 1.23 2 kN –" in said and "nave 1.05 MN 210 1.23 2 kN 0.512" in said
    assert text.index('id="capacity-title"') < text.index('id="ties-title"') < text.index('id="damage-title"')


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
