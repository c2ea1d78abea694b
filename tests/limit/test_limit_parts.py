# SPDX-License-Identifier: GPL-3.0-or-later
"""masonry_cd.limit.parts: macro-elements of a scene, what is written of them, what is refused, and the one verdict."""

from __future__ import annotations

import csv
import html
import json
from pathlib import Path
from typing import Any

import pytest
from command_line import masonry_cd
from limit_scenes import said, scene
from models import GRAVITY, box, ground

from masonry_cd.app.scene import read_scene
from masonry_cd.limit.case import LimitCase, WantedMechanisms, limit_case
from masonry_cd.limit.checked import least_of
from masonry_cd.limit.facts import facts
from masonry_cd.limit.files import write
from masonry_cd.mechanics.model.blocks import Block

SLAB = '[[limit.mechanism]]\nblocks = ["slab"]\ndirection = "-x"\nmechanisms = ["overturning"]\n'
BUILDING = "building_height = 6.0\nbuilding_period = 0.2\nstoreys = 2\n"
BORNE = GRAVITY / 6.0 / 1.35  # a0* of the slab of 0.5 by 3 m


def slabs() -> list[Block]:
    """A slab that leans at 1/6, and a low block next to it that leans at 2."""
    return [ground(8.0), box("slab", (0.0, -1.0, 0.0), (0.5, 1.0, 3.0)), box("low", (3.0, -1.0, 0.0), (4.0, 1.0, 0.5))]


def parts_of(path: Path) -> LimitCase:
    """The chosen parts of a scene, on one process."""
    return limit_case(path, wanted=WantedMechanisms(whole=False, jobs=1))


def least_rows(case: LimitCase) -> list[dict[str, Any]]:
    """The governing mechanism of each part and push."""
    return [each.row for each in least_of(case.mechanisms)]


def found(folder: Path, ratio: float, more: str = SLAB, check: str = "") -> LimitCase:
    """The macro-elements of the slabs, for a demand that the slab meets by a ratio."""
    asked = f'[limit.check]\nspectrum = "EC8"\nag = {2.0 * BORNE / ratio}\ndisplacements = false\n{check}'
    return parts_of(scene(folder, slabs(), f"{asked}{more}", mu=0.6))


@pytest.mark.parametrize(("ratio", "state"), [(0.98, "NOT satisfied"), (1.03, "not decided"), (1.08, "satisfied")])
def test_the_least_ratio_decides(ratio: float, state: str, tmp_path: Path) -> None:
    case = found(tmp_path, ratio, SLAB + SLAB.replace('"slab"', '"low"'))
    assert case.verdict is not None
    assert (case.verdict.state, case.verdict.ratio) == (state, pytest.approx(ratio, rel=1e-3))
    first, *others = least_rows(case)
    assert first["element"] == "slab" and first["mechanism"].endswith("overturning")
    assert first["alpha0"] == pytest.approx(1.0 / 6.0, rel=1e-3) and first["fraction"] == pytest.approx(1.0, rel=1e-3)
    assert [row["element"] for row in others] == ["low"] and all(
        row["ratio"] > first["ratio"] for row in others if row["ratio"] and first["ratio"]
    )
    assert any(case.verdict.reason in line for line in said(case))


def test_a_part_above_the_ground_is_asked_for_the_motion_there(tmp_path: Path) -> None:
    """Without the building's period nothing is satisfied; with it the demand is that of the floor."""
    table = '[[limit.mechanism]]\nbox = [[-1.0, -2.0, 1.0], [1.0, 2.0, 4.0]]\ndirection = "x"\nmechanisms = ["overturning"]\n'
    blocks = [ground(8.0), box("low", (0.0, -1.0, 0.0), (1.5, 1.0, 1.0)), box("high", (0.0, -1.0, 1.0), (0.5, 1.0, 2.0))]
    building = "height = 1.0\nbuilding_height = 2.0\nbuilding_period = 0.3\nstoreys = 1\n"
    rows = []
    for more in ("", building):
        check = f'[limit.check]\nspectrum = "EC8"\nag = 0.2\ndisplacements = false\n{more}'
        case = parts_of(scene(tmp_path, blocks, f"{check}{table}", mu=0.8))
        rows.append(least_rows(case)[0])
        assert rows[-1]["height"] == pytest.approx(1.0)
    low, high = rows
    assert low["state"] == "not decided" and "held 1 m above the ground" in low["undecided"]
    assert (
        high["state"] == "satisfied" and low["demand"] is not None and high["demand"] is not None and high["demand"] > 1.2 * low["demand"]
    )


ASKED = {False: 1.8 * 1.4334 / 2.0, True: 7.531 / 2.0}  # ag S and aZ over q, by hand [m/s2]


def test_a_part_of_pieces_that_do_not_touch_and_values_that_are_doubted_draw_lines(tmp_path: Path) -> None:
    """As of the whole: the doubts of the scene; and which part is none."""
    both = SLAB.replace('["slab"]', '["slab", "low"]')
    notes = found(tmp_path, 1.0, both, "behaviour_factor = 4.0\n").notes
    assert any("slab and others" in line and "2 pieces" in line for line in notes)
    assert any(line.startswith("limit.check.behaviour_factor") for line in notes)
    assert not any("pieces" in line for line in found(tmp_path, 1.0).notes)


LEVELS = {
    "on the ground": (0.0, "", 0.0, False),
    "its own line": (0.0, "foundation = -6.0\n", 6.0, True),
    "a whole that is held there": (0.0, "height = 6.0\n", 6.0, True),
    "modelled where it is": (6.0, "foundation = 0.0\n", 6.0, True),
    "the lowest block counts as the foundation": (6.0, "", 0.0, False),
}  # fmt: skip


@pytest.mark.parametrize(("bed", "key", "height", "raised"), LEVELS.values(), ids=list(LEVELS))
def test_the_whole_and_its_parts_on_one_bed_are_asked_for_the_same(
    bed: float, key: str, height: float, raised: bool, tmp_path: Path
) -> None:
    """One meaning of height in all doors: terminal, page and limit.json have it, and NTC's [C7.2.7] the demand."""
    roof = box("roof", (-1.0, -1.0, bed - 0.2), (2.0, 1.0, bed), fixed=True)
    site = 'spectrum = "NTC"\nag = 1.8\nf0 = 2.42\ntc_star = 0.33\nground = "C"\ndisplacements = false\n'
    tables = f'[limit]\npush = "-x"\n[limit.check]\n{site}{BUILDING}{key}{SLAB}'
    path, folder = scene(tmp_path, [roof, box("slab", (0.0, -1.0, bed), (0.5, 1.0, bed + 3.0))], tables, mu=0.6), tmp_path / "out"
    done = masonry_cd("limit", path, "-o", folder, "--no-picture")
    assert done.exit_code == 0, done.output
    made = json.loads((folder / "limit.json").read_text())
    row, level = next(row for row in made["mechanisms"] if row["element"] == "slab"), made["check"]["level"]
    asked = made["check"]["verdicts"][0]["demand"]
    assert row["demand"] == pytest.approx(asked) and asked == pytest.approx(ASKED[raised], rel=1e-3)
    assert (level["line"], level["height"], row["height"]) == pytest.approx((bed, height, height))
    assert any(f"{height:g} m above the foundation" in line for line in done.output.splitlines())
    assert f"{height:g} m above the foundation" in html.unescape((folder / "limit.html").read_text())


def test_a_mechanism_above_the_ground_is_not_satisfied_by_the_motion_of_the_ground_whichever_command_asks(tmp_path: Path) -> None:
    blocks = [ground(8.0), box("low", (0.0, -1.0, 0.0), (1.5, 1.0, 1.0)), box("high", (0.0, -1.0, 1.0), (0.5, 1.0, 2.0))]
    for key, state in (("", "not decided"), ("height = 3.0\n", "not decided"), ("foundation = 0.0\n", "satisfied")):
        building = f"building_height = 6.0\nbuilding_period = 0.3\nstoreys = 1\n{key}" if key else ""
        check = f'[limit]\npush = "-x"\n[limit.check]\nspectrum = "EC8"\nag = 0.2\ndisplacements = false\n{building}'
        case = limit_case(scene(tmp_path, blocks, check, mu=0.8))
        assert case.verdict is not None and case.verdict.state == state
        assert ("limit.check." in case.verdict.because) == (state == "not decided")


def test_a_part_that_does_not_stand_is_not_held_and_nothing_is_satisfied_with_it(tmp_path: Path) -> None:
    """An arm whose centre of mass is beyond its foot falls with all other blocks held; the slab alone is satisfied."""
    arm = [box("foot", (3.0, -0.5, 0.0), (3.5, 0.5, 1.0)), box("arm", (3.0, -0.5, 1.0), (6.0, 0.5, 1.3))]
    check = f'[limit.check]\nspectrum = "EC8"\nag = {2.0 * BORNE / 1.5}\ndisplacements = false\n'
    table = SLAB.replace('"slab"', '"foot", "arm"')
    case = parts_of(scene(tmp_path, [*slabs()[:2], *arm], f"{check}{SLAB}{table}", mu=0.6))
    assert least_rows(case)[0]["state"] == "satisfied"
    assert case.verdict is not None and case.verdict.state == "not decided" and "no answer" in case.verdict.reason
    assert not any("held, no mechanism" in line for line in said(case))
    assert [part["held"] for part in facts(case)["parts"]] == [False, False]
    assert any(line.startswith("foot and others, push -x: ") and "may not stand" in line for line in case.notes)


def test_the_command_writes_a_table_a_page_and_pictures_and_one_verdict(tmp_path: Path) -> None:
    check = f'[limit]\npush = "-x"\n[limit.check]\nspectrum = "EC8"\nag = {2.0 * BORNE / 1.5}\ndisplacements = false\n'
    path, folder = scene(tmp_path, slabs(), f"{check}{SLAB}", mu=0.6), tmp_path / "out"
    done = masonry_cd("limit", path, "-o", folder)
    assert done.exit_code == 0, done.output
    made = json.loads((folder / "limit.json").read_text())
    assert made["verdict"]["reason"] in done.output
    with (folder / "mechanisms.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert rows[0]["element"] == "slab" and float(rows[0]["ratio"]) == pytest.approx(1.5, rel=1e-3)
    assert [path.name for path in (folder / "parts").glob("[!.]*")] == ["01_slab.png"]
    page = (folder / "limit.html").read_text()
    assert page.count("data:image/png") == 4 and "[C8.7.1.2]" in page and f">{made['verdict']['state']}</span>" in page
    assert html.unescape(page).count(made["verdict"]["reason"]) == 1 and ">1.50<" in page


def test_the_damage_of_a_run_stands_next_to_macro_elements_only(tmp_path: Path) -> None:
    path = scene(tmp_path, slabs(), SLAB)
    refused = masonry_cd("limit", path, "-o", tmp_path / "out", "--run", tmp_path)
    assert refused.exit_code == 2 and "has no damage.csv" in refused.output
    (tmp_path / "damage.csv").write_text("part,grade,mechanism\nblock,D3,overturning\n")
    blocks = read_scene(path).structure
    assert blocks["kind"] == "file"
    done = masonry_cd("limit", path, "-o", tmp_path / "out", "--run", tmp_path, "--no-picture")
    assert done.exit_code == 0, done.output
    assert "damage in the run" in (tmp_path / "out" / "limit.html").read_text()


def test_a_part_is_checked_by_displacements_as_the_whole_is(tmp_path: Path) -> None:
    """The slab as a part and as the whole: one d0*, one demand, one verdict, in table and page as well."""
    check = f'[limit]\npush = "-x"\n[limit.check]\nspectrum = "EC8"\nag = {2.0 * BORNE / 0.9}\nground = "D"\n'
    blocks = [ground(8.0), box("slab", (0.0, -1.0, 0.0), (0.5, 1.0, 3.0))]
    path = scene(tmp_path, blocks, check + SLAB, mu=0.6)
    part, whole = parts_of(path), limit_case(path)
    row, (linear, other) = part.mechanisms[0].row, whole.check.verdicts if whole.check else (None, None)
    assert linear is not None and other is not None and part.verdict is not None and whole.verdict is not None
    assert row["last"] == pytest.approx(0.25, rel=1e-3) and row["displacement"] == pytest.approx(0.1, rel=1e-3)
    assert row["displacement_demand"] == pytest.approx(other.demand, rel=1e-2) and row["demand"] == pytest.approx(linear.demand)
    assert (part.verdict.state, part.verdict.check) == (whole.verdict.state, whole.verdict.check)
    assert part.verdict.ratio == pytest.approx(whole.verdict.ratio, rel=1e-2) and row["ratio"] == part.verdict.ratio
    folder = tmp_path / "out"
    write(part, folder, pictures=False)
    with (folder / "mechanisms.csv").open() as file:
        first, *others = csv.DictReader(file)
    assert float(first["d0_m"]) == pytest.approx(0.25, rel=1e-3) and first["check"] == row["check"]
    assert all(not other["d0_m"] and "smaller a0*" in other["no_check_by_displacements"] for other in others)
    page = (folder / "limit.html").read_text()
    assert "d0* [mm]" in page and "does not last until collapse" in page


def test_a_part_at_a_height_is_asked_for_the_displacement_of_its_floor(tmp_path: Path) -> None:
    table = '[[limit.mechanism]]\nbox = [[-1.0, -2.0, 1.0], [1.0, 2.0, 4.0]]\ndirection = "x"\nmechanisms = ["overturning"]\n'
    blocks = [ground(8.0), box("low", (0.0, -1.0, 0.0), (1.5, 1.0, 1.0)), box("high", (0.0, -1.0, 1.0), (0.5, 1.0, 3.0))]
    building = "height = 1.0\nbuilding_height = 2.0\nbuilding_period = 1.4\nstoreys = 1\n"
    asked = []
    for more in ("", building):
        case = parts_of(scene(tmp_path, blocks, f'[limit.check]\nspectrum = "EC8"\nag = 1.0\n{more}{table}', mu=0.8))
        asked.append(case.mechanisms[0].row["displacement_demand"])
    assert asked[0] is not None and asked[1] is not None and asked[1] > 1.2 * asked[0]  # in resonance with the building
