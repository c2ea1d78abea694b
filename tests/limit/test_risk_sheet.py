# SPDX-License-Identifier: GPL-3.0-or-later
"""reports.risk and masonry-cd risk: the sheet of a pillar as it is and as widened, and what is just borne of several mechanisms."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from command_line import masonry_cd, refusal
from limit_scenes import PUSH, scene
from models import box, ground

import masonry_cd as mc
from masonry_cd.limit.case import limit_case
from masonry_cd.mechanics.model.blocks import Block

HAZARD = "[hazard]\nreturn_period = [30, 475, 2475]\nag = [0.5, 1.6, 3.2]\nf0 = [2.4, 2.45, 2.5]\ntc_star = [0.26, 0.32, 0.34]\n"
CHECK = '[limit.check]\nspectrum = "NTC"\ndisplacements = false\n'
TABLES = PUSH + HAZARD + CHECK


def pillar(width: float) -> list[Block]:
    """A pillar of a width [m] and 4 m of height, which overturns at a load factor of width / height."""
    return [ground(2.0), box("a", (0.0, -0.2, 0.0), (width, 0.2, 4.0))]


def analysed(folder: Path, name: str, width: float, tables: str = TABLES) -> Path:
    """The folder of the limit analysis of a pillar."""
    (folder / name).mkdir()
    done = masonry_cd("limit", scene(folder / name, pillar(width), tables), "-o", folder / name / "out")
    assert done.exit_code == 0, done.output
    return folder / name / "out"


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Limit analyses of a pillar of 0.35 m, and of 0.5 m."""
    folder = tmp_path_factory.mktemp("risk")
    return analysed(folder, "before", 0.35), analysed(folder, "after", 0.5)


def test_the_sheet_has_capacity_return_period_and_class_by_hand(folders: tuple[Path, Path], tmp_path: Path) -> None:
    before, after = folders
    done = masonry_cd("risk", before, "--after", after, "-o", tmp_path / "out")
    assert done.exit_code == 0, done.output
    made = json.loads((tmp_path / "out" / "risk.json").read_text())
    for name, width in (("as_it_is", 0.35), ("strengthened", 0.5)):
        capacity = made[name]["capacity"]
        # linear check: alpha0 g / CF = ag S / q on ground A, S = 1
        assert capacity["borne"] == pytest.approx(2.0 * width / 4.0 * 9.81 / 1.35, rel=1e-6)
        slope = (475.0 / 30.0, 1.6 / 0.5) if capacity["borne"] < 1.6 else (2475.0 / 475.0, 2.0)
        from_row = (30.0, 0.5) if capacity["borne"] < 1.6 else (475.0, 1.6)
        by_hand = from_row[0] * (capacity["borne"] / from_row[1]) ** (math.log(slope[0]) / math.log(slope[1]))
        assert capacity["return_period_years"] == pytest.approx(by_hand, rel=1e-9)
        assert made[name]["risk"]["index"] == pytest.approx(capacity["borne"] / capacity["asked"])
    assert (made["as_it_is"]["risk"]["index_class"], made["strengthened"]["risk"]["index_class"]) == ("B", "A+")
    page = (tmp_path / "out" / "risk.html").read_text(encoding="utf-8")
    assert page.count("<img") == 1
    assert "TR1 (PGA_C &#47; ag1)^(ln(TR2 &#47; TR1) &#47; ln(ag2 &#47; ag1))" in page
    assert "the guideline asks for the behaviour of the whole building as well" in page  # what the class leaves open
    sheet = mc.risk_sheet(before, after)
    assert sheet.table.loc["class"].tolist()[:2] == [made[name]["risk"]["risk_class"] for name in ("as_it_is", "strengthened")]
    assert str(sheet).splitlines() == done.output.splitlines()[:2]


def test_a_sheet_is_of_one_site_and_of_analyses_with_a_hazard(folders: tuple[Path, Path], tmp_path: Path) -> None:
    other = analysed(tmp_path, "other", 0.5, TABLES.replace("1.6, 3.2", "1.7, 3.2"))
    assert "differ in hazard" in str(refusal(masonry_cd("risk", folders[0], "--after", other)))
    plain = analysed(tmp_path, "plain", 0.5, PUSH)
    assert "has no code check" in str(refusal(masonry_cd("risk", plain)))
    assert "has no limit.json" in str(refusal(masonry_cd("risk", tmp_path)))
    assert "has no summary.json" in str(refusal(masonry_cd("risk", folders[0], "--study", tmp_path)))
    assert not (tmp_path / "out").exists()


def test_what_is_just_borne_is_that_of_the_mechanism_that_bears_least(tmp_path: Path) -> None:
    """A stocky pillar on a plinth is not decided, as no building is given; the slender one on the ground is satisfied, and bears less."""
    plinth = box("plinth", (4.0, -0.5, 0.0), (6.0, 0.5, 2.0), fixed=True)
    slab = box("ground", (-2.0, -1.0, -0.2), (8.0, 1.0, 0.0), fixed=True)
    blocks = [slab, plinth, box("low", (0.0, -0.2, 0.0), (0.8, 0.2, 4.0)), box("high", (4.5, -0.2, 2.0), (5.5, 0.2, 4.0))]
    parts = '[[limit.mechanism]]\nblocks = ["low"]\ndirection = "x"\n[[limit.mechanism]]\nblocks = ["high"]\ndirection = "x"\n'
    found = limit_case(scene(tmp_path, blocks, HAZARD + CHECK + parts))
    assert found.decides is not None
    assert found.check is not None
    assert found.check.risk is not None
    assert (found.decides.part.element.name, found.decides.row["state"]) == ("high", "not decided")
    (borne,) = found.check.borne
    assert borne.borne == pytest.approx(2.0 * 0.2 * 9.81 / 1.35, rel=1e-6)
    assert found.check.risk.index == pytest.approx(borne.borne / borne.asked)
    assert any(note.startswith("what is just borne is that of low, push x") for note in found.check.notes)
