# SPDX-License-Identifier: GPL-3.0-or-later
"""masonry_cd.limit.checked: "satisfied" follows from a sure search with a margin, and every output has one verdict."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from command_line import masonry_cd
from limit_scenes import TIE, pillar, said, scene
from models import GRAVITY, box, ground

from masonry_cd.analysis.limit import solution
from masonry_cd.analysis.limit.oscillator import BY_CURVE, BY_LINKAGE
from masonry_cd.limit import search as limit_search
from masonry_cd.limit.case import LimitCase, limit_case
from masonry_cd.limit.facts import facts
from masonry_cd.limit.files import write
from masonry_cd.limit.whole import THE_WHOLE
from masonry_cd.mechanics.model.blocks import Block

BORNE = GRAVITY / 6.0 / 1.35  # a0* of the slab of 0.5 by 3 m


def wedged() -> list[Block]:
    """A slab between two cheeks that it does not press: without dilation it leans alone, as associated it has to move them aside."""
    cheeks = [box("left", (0.0, -1.6, 0.0), (1.0, -1.0, 3.0)), box("right", (0.0, 1.0, 0.0), (1.0, 1.6, 3.0))]
    return [ground(5.0), box("slab", (0.0, -1.0, 0.0), (0.5, 1.0, 3.0)), *cheeks]


def checked(folder: Path, ratio: float, more: str = "", displacements: bool = False) -> LimitCase:
    """The check of blocks pushed against -x, for a demand that the slab alone meets by a ratio."""
    check = f'[limit.check]\nspectrum = "EC8"\nag = {2.0 * BORNE / ratio}\ndisplacements = {str(displacements).lower()}\n'
    return limit_case(scene(folder, wedged(), f"[limit]\npush = '-x'\n{more}{check}", mu=0.6))


@pytest.mark.parametrize(("ratio", "state"), [(0.98, "NOT satisfied"), (1.03, "not decided"), (1.08, "satisfied")])
def test_the_least_factor_without_dilation_decides_with_a_margin(ratio: float, state: str, tmp_path: Path) -> None:
    case = checked(tmp_path, ratio)
    assert case.whole.analysis.associated.factor > 1.15 / 6.0  # would meet each of the three
    assert case.whole.analysis.least is not None and case.whole.analysis.starts == 5  # four for the check, one at the blocks as a part
    assert case.check is not None
    (verdict,) = case.check.verdicts
    assert (verdict.state, verdict.ratio) == (state, pytest.approx(ratio, rel=1e-3))
    assert ("margin of 5 %" in verdict.words) is (state == "not decided")


def test_every_output_has_the_same_verdict(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    case = checked(tmp_path, 1.03)
    write(case, folder, pictures=False)
    assert case.check is not None
    (words,) = (one.words for one in case.check.verdicts)
    assert words.startswith("linear check not decided: ") and words in said(case)
    made = json.loads((folder / "check.json").read_text())
    assert made == json.loads((folder / "limit.json").read_text())["check"]
    assert [(one["state"], one["passed"], one["words"]) for one in made["verdicts"]] == [("not decided", None, words)]
    found = json.loads((folder / "limit.json").read_text())
    assert (found["verdict"]["confidence"], made["borne"][0]["share"]) == ("doubtful", pytest.approx(1.03, rel=1e-3))
    assert made["borne"][0]["words"] in said(case) and made["worked"]["linear"] == ["a asked = ag S / q = 2.352 / 2 = 1.176 m/s2"]
    with (folder / "check.csv").open() as file:
        last = list(csv.DictReader(file))[-1]
    assert (last["symbol"], last["value"], last["meaning"]) == ("linear check", "not decided", words)
    verdict = case.verdict
    assert verdict is not None
    assert (verdict.state, verdict.ratio, verdict.margin) == ("not decided", pytest.approx(1.03, rel=1e-3), 0.05)
    assert verdict.search is not None and verdict.search.starts == 5 and verdict.search.agreeing >= 2
    assert json.loads((folder / "limit.json").read_text())["verdict"]["words"] == verdict.words
    assert any(verdict.reason in line for line in said(case))
    page = (folder / "limit.html").read_text()
    assert page.count('<span class="verdict look">not decided</span>') == 2
    assert (
        '<span class="verdict look">not decided</span> linear check: ' in page and "linear check, not decided: capacity over demand" in page
    )
    assert not any(f"{word}</span> linear check" in page for word in (">satisfied", "NOT satisfied"))


def test_without_a_search_or_with_one_start_nothing_is_satisfied(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    case = checked(tmp_path, 1.08, "starts = 0\n")
    assert case.check is not None and case.check.verdicts[0].state == "not decided"
    assert "not computed by default: limit.starts = 2 does" in case.check.verdicts[0].words
    case = checked(tmp_path, 1.5, "starts = 1\n")
    assert case.check is not None and case.check.verdicts[0].state == "not decided"
    assert "1 of 1 starts came to the least factor found, 2 have to agree" in case.check.verdicts[0].words
    monkeypatch.setattr(limit_search, "SEARCHED", 4)  # as of a large structure
    case = checked(tmp_path, 1.5)
    assert case.check is not None and case.whole.analysis.starts == 0
    assert case.check.verdicts[0].state == "not decided"
    assert "not computed by default in a structure of more than 4 contact points: limit.starts = 2 does" in case.check.verdicts[0].words


def test_starts_that_do_not_agree_decide_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solution, "AGREEING", -1.0)  # none agree, not even with themselves
    case = checked(tmp_path, 1.5)
    assert case.check is not None and case.check.verdicts[0].state == "not decided"
    assert "0 of 5 starts came to the least factor found" in case.check.verdicts[0].words


def test_that_a_mechanism_starts_is_enough_to_say_no(tmp_path: Path) -> None:
    case = checked(tmp_path, 0.5, "starts = 0\n")
    assert case.whole.analysis.least is None and case.check is not None
    assert case.check.verdicts[0].state == "NOT satisfied"


def test_without_a_check_no_search_is_made_by_default_in_space(tmp_path: Path) -> None:
    case = limit_case(scene(tmp_path, wedged(), "[limit]\npush = '-x'\n", mu=0.6))
    assert case.whole.analysis.starts == 0
    assert any("not searched for; limit.starts = 2 does" in line for line in said(case))


def test_the_mechanism_of_the_least_acceleration_is_checked_and_those_looked_at_are_listed(tmp_path: Path) -> None:
    tie = f"{TIE}area = 1e-4\nmodulus = 2e11\nyield_force = 500.0\n"
    case = limit_case(
        scene(tmp_path, pillar(), f'{tie}[limit]\npush = "x"\n[limit.check]\nspectrum = "EC8"\nag = 2.0\ndisplacements = false\n')
    )
    assert case.check is not None
    looked = facts(case)["check"]["basis"]["looked"]
    assert {one["found"].partition(",")[2] for one in looked} == {"", " found without the ties"}
    least = [one["acceleration"] for one in looked]
    assert least == sorted(least)
    assert {step.symbol: step.value for step in case.check.steps}["a0*"] == pytest.approx(least[0])
    write(case, tmp_path / "out", pictures=False)
    assert "found without the ties" in (tmp_path / "out" / "limit.html").read_text()


def test_what_does_not_stand_or_bears_nothing_does_not_satisfy_its_check(tmp_path: Path) -> None:
    aside = [ground(2.0), box("under", (0.0, -0.2, 0.0), (0.5, 0.2, 0.5)), box("a", (0.3, -0.2, 0.5), (1.3, 0.2, 1.0))]
    case = limit_case(scene(tmp_path, aside, '[limit]\npush = "x"\n[limit.check]\nspectrum = "EC8"\nag = 0.5\n'))
    assert not case.whole.analysis.stands and case.check is None
    assert case.verdict is not None and case.verdict.state == "NOT satisfied"
    assert any(case.verdict.reason in line for line in said(case)) and "does not stand under its dead loads" in case.verdict.words
    write(case, tmp_path / "out", pictures=False)
    assert ">NOT satisfied</span>" in (tmp_path / "out" / "limit.html").read_text()
    assert json.loads((tmp_path / "out" / "limit.json").read_text())["verdict"]["passed"] is False


def test_what_the_clauses_leave_open_is_said(tmp_path: Path) -> None:
    here = checked(tmp_path, 1.5)
    assert any("left open: FC = 1.35" in line for line in said(here))
    assert any("left open: not looked at: the motion at a height" in line for line in said(here))
    more = "height = 6.0\nbuilding_height = 12.0\nbuilding_period = 0.4\nstoreys = 3\nconfidence_factor = 1.2\n"
    check = f'[limit.check]\nspectrum = "EC8"\nag = 1.0\ndisplacements = false\n{more}'
    high = said(limit_case(scene(tmp_path, pillar(), f"[limit]\npush = 'x'\n{check}")))
    for words in ("FC = 1.2 as given", "1.1 xi1^-0.5 = 4.92", "second and higher modes"):
        assert any("left open: " in line and words in line for line in high), words


def test_what_dilates_has_no_oscillator_and_no_check_by_displacements(tmp_path: Path) -> None:
    slab = [ground(4.0), box("slab", (0.0, -1.0, 0.0), (2.0, 1.0, 0.4))]
    path = scene(tmp_path, slab, '[limit]\npush = "x"\nstarts = 0\n[limit.check]\nspectrum = "EC8"\nag = 2.0\n', mu=0.3)
    done = masonry_cd("limit", path, "-o", tmp_path / "out", "--no-picture")
    assert done.exit_code == 0, done.output
    rows = json.loads((tmp_path / "out" / "limit.json").read_text())["mechanisms"]
    (row,) = (row for row in rows if row["element"] == THE_WHOLE)
    assert row["found"] == "associated" and row["doubt"].startswith("the mechanism dilates") and row["fraction"] == 1.0
    assert row["displacement"] is None and row["no_displacement"] == row["doubt"]


def test_the_mechanism_that_is_followed_is_the_one_that_is_checked(tmp_path: Path) -> None:
    """The curve of the whole is of slab and cheeks, the associated mechanism: the slab alone falls with its centre over the edge."""
    check = checked(tmp_path, 0.5, displacements=True).check
    assert check is not None and [one.check for one in check.verdicts] == ["linear", "non-linear"]
    assert {step.symbol: step.value for step in check.steps}["d0*"] == pytest.approx(0.25, rel=3e-3)


@pytest.mark.parametrize(("width", "by"), [(1.0, BY_CURVE), (0.7, BY_LINKAGE)], ids=["plane", "space"])
def test_a_part_that_is_the_whole_is_not_listed_twice_and_d0_says_how_it_was_found(width: float, by: str, tmp_path: Path) -> None:
    """A slab alone, in the middle of its ground or next to it: the whole, and its group as a part, overturn at 1/6 with d0* = 0.25 m."""
    check = f'[limit]\npush = "-x"\n[limit.check]\nspectrum = "EC8"\nag = {2.0 * BORNE / 0.9}\n'
    slab = [ground(5.0), box("slab", (0.0, -1.0, 0.0), (0.5, width, 3.0))]
    rows = [each.row for each in limit_case(scene(tmp_path, slab, check, mu=0.6)).mechanisms]
    assert {row["element"] for row in rows} == {THE_WHOLE}
    assert rows[0]["last_by"] == by and rows[0]["last"] == pytest.approx(0.25, rel=1e-2)


def test_collapse_is_checked_by_displacements_alone(tmp_path: Path) -> None:
    """A slab that leans at 1/6: 0.6 d0* borne, a0* in m/s2, and what slides with dilation is not followed, nor decided."""
    check = f'[limit]\npush = "-x"\n[limit.check]\nspectrum = "EC8"\nag = {2.0 * BORNE}\nlimit_state = "SLC"\n'
    case = limit_case(scene(tmp_path, [ground(5.0), box("slab", (0.0, -1.0, 0.0), (0.5, 1.0, 3.0))], check, mu=0.6))
    first, *others = (each.row for each in case.mechanisms)
    assert case.verdict is not None and case.verdict.check == first["check"] == "non-linear"
    assert first["displacement"] == pytest.approx(0.6 * 0.25, rel=1e-2) and first["demand"] is None
    assert first["acceleration"] == pytest.approx(BORNE, rel=1e-3) and not any(row["state"] for row in others)
    assert any(line.startswith("checked: the least ratio, by displacements, of ") for line in said(case))
    write(case, tmp_path / "out", pictures=False)
    (tmp_path / "low").mkdir()
    slides = scene(
        tmp_path / "low",
        [ground(4.0), box("slab", (0.0, -1.0, 0.0), (2.0, 1.0, 0.4))],
        check.replace("[limit]", "[limit]\nstarts = 0"),
        mu=0.3,
    )
    unknown = limit_case(slides).verdict
    assert unknown is not None and unknown.state == "not decided" and "dilates" in unknown.reason


@pytest.mark.parametrize("state", ["SLV", "SLC"])
def test_beyond_the_end_of_a_table_nothing_is_decided_by_any_mechanism(state: str, tmp_path: Path) -> None:
    table = f"table = {{period = [0, 0.1, 0.5], acceleration = [{6.0 * BORNE}, {9.0 * BORNE}, {BORNE}]}}\n"
    check = f'[limit.check]\nspectrum = "table"\n{table}limit_state = "{state}"\n'
    case = limit_case(scene(tmp_path, pillar(), f"[limit]\npush = 'x'\nstarts = 4\n{check}"))
    assert case.verdict is not None
    assert case.verdict.state == "not decided"
    assert "s is beyond the spectrum, whose table ends at 0.5 s" in case.verdict.words
