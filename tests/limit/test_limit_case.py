# SPDX-License-Identifier: GPL-3.0-or-later
"""masonry_cd.limit.case: the limit analysis of a scene, what it writes, and what it refuses."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import browser
import numpy as np
import pytest
from command_line import masonry_cd
from limit_scenes import PUSH, TIE, TILT, pillar, said, scene
from models import box, ground
from pictures import pixels

from benchmarks.dry_walls import ASSOCIATED, dry_wall
from masonry_cd.analysis.limit import descent, programme
from masonry_cd.foundation.errors import InputError
from masonry_cd.limit.case import WantedMechanisms, limit_case
from masonry_cd.limit.facts import facts
from masonry_cd.limit.files import EVERY, write
from masonry_cd.limit.pictures import draw_whole
from masonry_cd.mechanics.model.blocks import Block
from structures.geometry.prism import prism_xz


def test_the_command_writes_what_it_finds(tmp_path):
    path, folder = scene(tmp_path, dry_wall(3), "[limit]\npush = 'x'\nstarts = 1\n"), tmp_path / "out"
    done = masonry_cd("limit", path, "-o", folder)
    assert done.exit_code == 0, done.output
    assert "load factor 0.40369" in done.output
    assert "Coulomb's law allows 0.35" in done.output
    made = json.loads((folder / "limit.json").read_text())
    assert made["associated"] == pytest.approx(ASSOCIATED[3], abs=1e-5)
    assert made["least"]["factor"] == pytest.approx(0.356, rel=1e-2)
    assert made["certificate"]["gap"] < 1e-9
    with (folder / "blocks.csv").open() as file:
        blocks = list(csv.DictReader(file))
    assert len(blocks) == made["blocks"]
    assert [row["block"] for row in blocks if row["moves"] == "True"] == made["mechanism"]["moving_blocks"]
    with (folder / "joints.csv").open() as file:
        joints = list(csv.DictReader(file))
    assert len(joints) == made["joints"]
    assert sum(row["state"] == "hinge" for row in joints) == made["mechanism"]["joints_hinge"]
    weight = sum(float(row["normal_force_n"]) for row in joints if row["block_a"] == "ground" or row["block_b"] == "ground")
    assert weight == pytest.approx(9.81 * 2000.0 * 0.2 * 0.4 * 0.175 * 38.5, rel=0.2)
    missing = {name for name in EVERY if not (folder / name).exists() and not name.startswith(("capacity", "crossing"))}
    assert missing == {"check.json", "check.csv", "spectrum.png", "ties.csv", "parts.kept"}  # no check, no tie, and it is done
    drawn = pixels(folder / "mechanism.png")
    assert (drawn == [0xD5, 0x5E, 0x00]).all(axis=2).sum() > 100  # hinges are marked
    again = masonry_cd("limit", path, "-o", folder)
    assert again.exit_code == 2
    assert "--force" in again.output


def test_the_curve_of_a_pillar_is_written(tmp_path):
    path, folder = scene(tmp_path, pillar(), "[limit]\npush = 'x'\n"), tmp_path / "out"
    done = masonry_cd("limit", path, "-o", folder, "--curve", "--set", "limit.curve.steps=20")
    assert done.exit_code == 0, done.output
    assert 'control block "a"; factor 0.3333 at the start' in done.output
    with (folder / "capacity.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert float(rows[0]["factor"]) == pytest.approx(1.0 / 3.0)
    assert float(rows[-1]["displacement_m"]) == pytest.approx(0.25, rel=1e-5)
    made = json.loads((folder / "capacity.json").read_text())
    assert made["ultimate"] == pytest.approx(0.25, rel=1e-5)
    assert [mark["moving_blocks"] for mark in made["marks"]] == [["a"]] * 3
    assert made["marks"][1]["joints_at_work"] == [{"block_a": "ground", "block_b": "a", "state": "hinge"}]
    drawn = pixels(folder / "capacity.png")
    assert (drawn == [0x00, 0x72, 0xB2]).all(axis=2).sum() > 500  # the curve
    assert (drawn == [0xD5, 0x5E, 0x00]).all(axis=2).sum() > 50  # its hinges


def test_without_being_asked_no_curve_is_followed(tmp_path):
    found = limit_case(scene(tmp_path, pillar(), PUSH))
    assert found.whole.curve is None
    assert not any("capacity curve" in line for line in said(found))


def test_ties_are_reported_written_and_drawn_with_what_they_pull(tmp_path):
    tables = f"{TIE}area = 1e-4\nmodulus = 2e11\nyield_force = 500.0\n[limit]\npush = 'x'\n"
    case = limit_case(scene(tmp_path, pillar(), tables))
    factor = (2000.0 * 9.81 * 0.3 * 0.25 + 500.0 * math.sqrt(0.5) * 1.5) / (2000.0 * 9.81 * 0.3 * 0.75)  # about the edge at x = 0.5
    assert case.whole.analysis.associated.factor == pytest.approx(factor, rel=1e-6)
    assert 'tie "rod": 500 N, yields at collapse' in said(case)
    assert facts(case)["ties"] == [
        {
            "tie": "rod",
            "block_a": "a",
            "block_b": "ground",
            "bars": 1,
            "tension_n": pytest.approx(500.0),
            "yield_force_n": 500.0,
            "yields": True,
        }
    ]
    write(case, tmp_path / "out")
    assert (tmp_path / "out" / "ties.csv").read_text().splitlines()[1] == "rod,a,ground,1,500,500,True"
    assert "Ties at collapse" in (tmp_path / "out" / "limit.html").read_text()
    purple = np.array([0x6A, 0x1B, 0x7A])
    for name in ("mechanism.png", "thrust.png"):
        assert (np.abs(pixels(tmp_path / "out" / name).astype(int) - purple).max(axis=-1) < 8).sum() > 500


@pytest.mark.parametrize("loads", [PUSH, TILT])
def test_a_scene_with_a_push_or_a_tilt_needs_no_table(loads, tmp_path):
    found = limit_case(scene(tmp_path, pillar(), loads))
    assert found.whole.analysis.associated.factor == pytest.approx(1.0 / 3.0, abs=1e-9)
    angle = facts(found).get("angle_degrees")
    assert (angle is None) == (loads is PUSH)
    assert angle is None or angle == pytest.approx(math.degrees(math.atan(1.0 / 3.0)))


def test_a_tilt_turns_gravity_but_no_other_load(tmp_path):
    """A weight of W on top turns with the block, a point load of W down the frame does not: m g (c b - s h) + W b/2... = 0."""
    weight = 2000.0 * 9.81 * 0.5 * 0.4 * 1.5
    load = f'[[loads]]\nkind = "point"\nblock = "a"\nforce = [0, 0, {-weight}]\npoint = [0.25, 0, 1.5]\n'
    found = limit_case(scene(tmp_path, pillar(), load + TILT, mu=2.0))
    phi = math.atan(found.whole.analysis.associated.factor)
    assert (math.cos(phi) + 1.0) * 0.25 == pytest.approx(math.sin(phi) * 0.75, abs=1e-8)


def test_where_nothing_slides_both_values_agree(tmp_path):
    assert any("both agree" in line for line in said(limit_case(scene(tmp_path, pillar(), PUSH))))


def test_live_loads_are_multiplied_and_others_are_not(tmp_path):
    points = "".join(
        f'[[loads]]\nkind = "point"\nblock = "a"\nforce = [{f}, 0, 0]\npoint = [0.25, 0, {z}]\n' for f, z in ((100.0, 1.5), (1000.0, 0.75))
    )
    found = limit_case(scene(tmp_path, pillar(), points + "[limit]\nlive = [1]\n"))
    weight = 2000.0 * 9.81 * 0.5 * 0.4 * 1.5
    assert found.whole.analysis.associated.factor == pytest.approx((weight * 0.25 - 100.0 * 1.5) / (1000.0 * 0.75), rel=1e-9)


def test_a_moment_is_multiplied_or_constant(tmp_path):
    """The pillar turns about its edge at x = 0.5: M_live + M_dead = W 0.25."""
    points = "".join(f'[[loads]]\nkind = "point"\nblock = "a"\nmoment = [0, {m}, 0]\n' for m in (100.0, 40.0))
    found = limit_case(scene(tmp_path, pillar(), points + "[limit]\nlive = [1]\n"))
    weight = 2000.0 * 9.81 * 0.5 * 0.4 * 1.5
    assert found.whole.analysis.associated.factor == pytest.approx((weight * 0.25 - 100.0) / 40.0, rel=1e-9)
    with pytest.raises(InputError, match="loads\\[0\\] is not a weight"):
        limit_case(scene(tmp_path, pillar(), points + "[limit]\npush = 'x'\nmasses = [0]\n"))


@pytest.mark.parametrize(("pivot", "edge"), [(-8.2, 2.0), (1.0, 1.8)])
def test_a_support_that_turns_bears_at_the_edge_where_it_has_the_least_power(tmp_path, pivot, edge):
    """N = W 0.8 / (edge - 0.2) about the edge of the left support, by the way of the edge over that of the corner that goes farthest."""
    blocks = [box("left", (0, -0.2, -0.5), (0.2, 0.2, 0), True), box("right", (1.8, -0.2, -0.5), (2, 0.2, 0), True)]
    blocks.append(box("beam", (0, -0.2, 0), (2, 0.2, 0.3)))
    keys = f"time = [0, 9]\nrotation = [0, 1]\naxis = 'y'\nabout = [{pivot}, 0, 0]\n"
    found = limit_case(scene(tmp_path, blocks, f'[[loads]]\nkind = "motion"\nsupports = "right"\n{keys}'))
    borne = 2000.0 * 9.81 * 2.0 * 0.4 * 0.3 * 0.8 / (edge - 0.2) * (edge - pivot) / math.hypot(2.0 - pivot, 0.5)
    assert facts(found)["support_force"] == pytest.approx(borne, rel=1e-6)


def test_a_settlement_is_read_from_the_loads(tmp_path):
    blocks = [box("left", (0, -0.2, -0.5), (0.2, 0.2, 0), True), box("right", (1.8, -0.2, -0.5), (2, 0.2, 0), True)]
    blocks.append(box("beam", (0, -0.2, 0), (2, 0.2, 0.3)))
    load = '[[loads]]\nkind = "settlement"\nsupports = "right"\ndisplacement = 0.1\nduration = 1.0\n'
    found = limit_case(scene(tmp_path, blocks, load))
    assert facts(found)["support_force"] == pytest.approx(2000.0 * 9.81 * 2.0 * 0.4 * 0.3 * 0.8 / 1.8, rel=1e-9)
    assert any("still bear" in line for line in said(found))


def test_what_shakes_is_left_out_and_said(tmp_path):
    shaken = '[[loads]]\nkind = "sinusoidal"\ndirection = "x"\namplitude = 0.1\nfrequency = 2.0\nduration = 1.0\n'
    found = limit_case(scene(tmp_path, pillar(), shaken + "[limit]\npush = 'x'\n"))
    assert any("loads[0] (sinusoidal): left out" in line for line in said(found))


def test_blocks_that_touch_along_a_line_are_counted(tmp_path):
    wedge = Block("b", *prism_xz(np.array([[0.25, 1.5], [0.35, 1.8], [0.15, 1.8]]), -0.2, 0.2), 2000.0)  # on its edge
    found = limit_case(scene(tmp_path, [*pillar(), wedge], PUSH))
    assert not found.whole.analysis.stands
    assert any("touch along a line" in line for line in said(found))


def test_what_falls_by_itself_is_named(tmp_path):
    blocks = [*pillar(), box("b", (0.3, -0.2, 1.5), (1.9, 0.2, 2.0))]
    path = scene(tmp_path, blocks, PUSH)
    done = masonry_cd("limit", path, "-o", tmp_path / "out", "--no-picture")
    assert done.exit_code == 0
    assert "does not stand under its dead loads" in done.output
    assert '"b"' in done.output
    assert json.loads((tmp_path / "out" / "limit.json").read_text())["stands"] is False


def test_an_unknown_view_is_refused_before_anything_is_written(tmp_path):
    done = masonry_cd("limit", scene(tmp_path, pillar(), PUSH), "-o", tmp_path / "out", "--view", "below")
    assert done.exit_code == 2
    assert 'view: "below" is not a view' in done.output
    assert not (tmp_path / "out").exists()


def test_a_solver_that_ends_before_its_tolerance_is_said(tmp_path, monkeypatch):
    blocks = [ground(2.0), box("a", (0.0, -0.2, 0.0), (0.5, 0.1, 1.5))]
    assert not any("before it met its tolerance" in line for line in said(limit_case(scene(tmp_path, blocks, PUSH))))
    monkeypatch.setattr(programme, "MOST", 4)
    found = limit_case(scene(tmp_path, blocks, PUSH))
    warned = [line for line in facts(found)["notes"] if "before it met its tolerance (MaxIterations after 4 iterations)" in line]
    assert any("the load factor" in line for line in warned)


def test_a_search_without_an_end_differs_from_none(tmp_path, monkeypatch):
    monkeypatch.setattr(descent, "EXACT", -1.0)  # no pair counts
    ended = limit_case(scene(tmp_path, pillar(), PUSH))
    assert any("of 4 starts, none converged" in line for line in said(ended))
    assert (facts(ended)["least"], facts(ended)["starts"]) == (None, 4)
    none = limit_case(scene(tmp_path, pillar(), PUSH + "[limit]\nstarts = 0\n"))
    assert any("not searched for" in line for line in said(none))


def test_a_tilt_next_to_a_point_load_is_searched_at_its_last_angle(tmp_path):
    load = '[[loads]]\nkind = "point"\nblock = "a"\nforce = [0, 0, -3000]\npoint = [0.25, 0, 1.5]\n'
    found = limit_case(scene(tmp_path, pillar(), load + TILT, mu=2.0)).whole.analysis
    assert found.least is not None
    assert found.least.optimum.factor == pytest.approx(found.associated.factor, rel=1e-6)


def test_a_structure_without_supports_is_refused(tmp_path):
    with pytest.raises(InputError, match="no block is fixed"):
        limit_case(scene(tmp_path, [box("a", (0, 0, 0), (1, 1, 1))], PUSH))


CHECK = '[limit.check]\nspectrum = "EC8"\nag = 2.0\n'


def test_a_check_by_a_code_is_printed_and_written_step_by_step(tmp_path):
    path, folder = scene(tmp_path, pillar(), f"[limit]\npush = 'x'\n{CHECK}"), tmp_path / "out"
    done = masonry_cd("limit", path, "-o", folder, "--no-picture")
    assert done.exit_code == 0, done.output
    assert "linear check satisfied: 2.422 m/s2 borne, 1 m/s2 required" in done.output
    made = json.loads((folder / "check.json").read_text())
    assert made == json.loads((folder / "limit.json").read_text())["check"]
    assert {step["symbol"]: step["value"] for step in made["steps"]}["a0*"] == pytest.approx(9.81 / 3.0 / 1.35)
    assert [one["passed"] for one in made["verdicts"]] == [True, True]
    with (folder / "check.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["symbol"] for row in rows] == [*(step["symbol"] for step in made["steps"]), "linear check", "non-linear check"]
    assert all(row["clause"] for row in rows)


def test_what_does_not_stand_is_not_checked(tmp_path):
    found = limit_case(scene(tmp_path, [*pillar(), box("b", (0.3, -0.2, 1.5), (1.9, 0.2, 2.0))], f"[limit]\npush = 'x'\n{CHECK}"))
    assert found.check is None
    assert facts(found)["check"] is None
    assert "limit.check: no check: there is no load factor at which a mechanism would start" in said(found)


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    """Files on a pillar that is checked, with pictures."""
    folder = tmp_path_factory.mktemp("checked")
    write(limit_case(scene(folder, pillar(), f"title = '<Pillar>'\n[limit]\npush = 'x'\n{CHECK}")), folder / "out")
    return folder / "out"


def test_the_page_shows_the_check_the_pictures_and_the_certificate(checked):
    page = (checked / "limit.html").read_text()
    assert page.count("data:image/png;base64,") == 3  # with the spectrum of the check
    assert "&lt;Pillar&gt;" in page and "<Pillar>" not in page
    assert "//" not in page.partition("<body>")[2].replace("data:image/png;base64,", "").split("<img")[0]  # no address
    for words in ("Code check", '<span class="verdict good">satisfied</span> linear check: 2.422 m', "[C8.7.1.5]", "Kinematic value"):
        assert words in page, words


@pytest.mark.parametrize(
    ("table", "asked", "command"),
    [
        ("", False, "masonry-cd limit scene.toml -o out"),
        ("", True, "masonry-cd limit scene.toml -o out --curve"),
        ("[limit.curve]\nsteps = 10\n", True, "masonry-cd limit scene.toml -o out"),
    ],
)
def test_the_command_on_the_page_asks_for_what_is_on_it(table: str, asked: bool, command: str, tmp_path: Path) -> None:
    write(limit_case(scene(tmp_path, pillar(), f"{PUSH}{table}"), wanted=WantedMechanisms(curve=asked)), tmp_path / "out", pictures=False)
    assert f"<pre>{command}</pre>" in (tmp_path / "out" / "limit.html").read_text()


def test_a_wall_that_leans_out_is_not_looked_at_along_its_motion(tmp_path):
    """From the front nothing of it would be seen: the thin lines of the structure as built lie behind what has moved."""
    case = limit_case(scene(tmp_path, pillar(), "[limit]\npush = '-y'\n"))
    folders = {view: tmp_path / view for view in ("auto", "front", "isometric")}
    for view, folder in folders.items():
        folder.mkdir()
        draw_whole(case.whole, case.scene.title, folder, view)
    drawn = {view: pixels(folder / "mechanism.png") for view, folder in folders.items()}
    assert np.array_equal(drawn["auto"], drawn["isometric"])
    assert drawn["auto"].shape != drawn["front"].shape or not np.array_equal(drawn["auto"], drawn["front"])


def test_the_page_of_what_falls_says_so_and_has_no_certificate(tmp_path):
    path = scene(tmp_path, [*pillar(), box("b", (0.3, -0.2, 1.5), (1.9, 0.2, 2.0))], PUSH)
    write(limit_case(path), tmp_path / "out", pictures=False)
    page = (tmp_path / "out" / "limit.html").read_text()
    assert "does not stand under its dead loads" in page
    assert "The mechanism under the dead loads." in page
    assert "Kinematic value" not in page and "data:image/png" not in page


@pytest.mark.parametrize("width", [390, 1400])
def test_the_page_fits_a_telephone_and_a_desk(width, checked, tmp_path):
    if browser.missing():
        pytest.skip(browser.missing())
    with browser.browser(tmp_path / "browser", width, 900) as window:
        window.open(checked / "limit.html")
        assert window.run("return document.documentElement.scrollWidth <= window.innerWidth")
        assert window.run("return [...document.images].every(image => image.naturalWidth > 0)")


def test_what_bears_no_live_load_has_no_factor_in_words(tmp_path):
    """The overhanging beam stands in balance over the edge of its support: the least weight on its end turns it over."""
    blocks = [box("ledge", (-2.0, -0.2, -0.5), (0.0, 0.2, 0.0), fixed=True), box("beam", (-1.0, -0.2, 0.0), (1.0, 0.2, 0.2))]
    load = '[[loads]]\nkind = "point"\nblock = "beam"\nforce = [0, 0, -100.0]\npoint = [1.0, 0, 0.2]\n'
    found = limit_case(scene(tmp_path, blocks, f"{load}[limit]\nlive = [0]\n"))
    assert found.whole.analysis.stands
    assert any("no load factor: the structure has no resistance to this load" in line for line in said(found))
    assert not any("e-1" in line for line in said(found) if "certificate" not in line)
    assert facts(found)["bears_nothing"] is True
    write(found, tmp_path / "out", pictures=False)
    assert "<dd>none</dd>" in (tmp_path / "out" / "limit.html").read_text()


def test_a_structure_that_bears_no_push_is_not_checked(tmp_path):
    blocks = [box("ledge", (-2.0, -0.2, -0.5), (0.0, 0.2, 0.0), fixed=True), box("beam", (-1.0, -0.2, 0.0), (1.0, 0.2, 0.2))]
    found = limit_case(scene(tmp_path, blocks, f"[limit]\npush = 'x'\n{CHECK}"))
    assert found.check is None
    assert any("no load factor" in line for line in said(found))
