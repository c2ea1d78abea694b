# SPDX-License-Identifier: GPL-3.0-or-later
"""masonry_cd.strengthening: forces against closed forms, cuts of the verification, what is out of reach, files and rules."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest
from command_line import masonry_cd
from limit_scenes import scene
from models import box, ground

from benchmarks.dry_walls import dry_wall
from masonry_cd.app.case import make_structures
from masonry_cd.app.scene import read_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.limit.case import limit_case
from masonry_cd.strengthening.design import MARGIN, StrengtheningDesign, strengthened
from masonry_cd.strengthening.facts import facts
from structures.tie_lines import by_rule

LAMBDA, HIGH, THICK, DEEP = 0.3, 3.0, 0.5, 0.4
WEIGHT = 9.81 * 2000.0 * HIGH * THICK * DEEP  # of a wall [N]
ROCK = box("rock", (-2.0, -0.2, 0.0), (-1.0, 0.2, HIGH), fixed=True)
WALL = box("a", (0.0, -0.2, 0.0), (THICK, 0.2, HIGH))
ASKED = f"[strengthen]\nfactor = {LAMBDA}\npushes = ['x']\n"


def tie(height: float, more: str = "", parts: str = "['rock', 'a']") -> str:
    return f"[[strengthen.ties]]\nalong = 'x'\nheight = {height}\nat = [0.0]\nparts = {parts}\n{more}"


def made(folder: Path, tables: str, blocks: list | None = None, mu: float = 0.8) -> StrengtheningDesign:
    return strengthened(read_scene(scene(folder, blocks or [ground(4.0), ROCK, WALL], tables, mu=mu)))


def needed(height: float, factor: float = LAMBDA, borne: float = 0.0) -> float:
    """F of a rigid wall that overturns, F h = lambda W H / 2 - W t / 2 - what other ties take up."""
    return (factor * WEIGHT * HIGH / 2.0 - WEIGHT * THICK / 2.0 - borne) / height


def test_one_tie_holds_a_wall_that_overturns(tmp_path):
    found = made(tmp_path, ASKED + tie(2.5))
    asked = (1.0 + MARGIN) * LAMBDA
    assert found.least.force == pytest.approx([needed(2.5, asked)], rel=1e-6)
    assert found.least.worth == pytest.approx([2.5 / (WEIGHT * HIGH / 2.0)])
    assert found.least.one_more == pytest.approx(found.least.cost - 1e-3 * 2.5 * needed(2.5, 0.99 * asked), rel=1e-6)
    numbers = facts(found)["factor"]
    assert numbers["before"] == pytest.approx(THICK / HIGH)
    assert LAMBDA <= numbers["with_least"] <= 1.01 * LAMBDA <= numbers["after"]


def test_the_cheaper_lever_is_taken_and_the_other_one_bears_the_rest(tmp_path):
    prices = "[strengthen.prices]\nforce = 1.0\n"
    asked = (1.0 + MARGIN) * LAMBDA
    low = tie(1.0) + tie(2.5)
    assert made(tmp_path, ASKED + low + prices).least.force == pytest.approx([0.0, needed(2.5, asked)])
    bound = tie(1.0) + tie(2.5, "largest_force = 400\n")
    found = made(tmp_path, ASKED + bound + prices)
    assert found.least.force == pytest.approx([needed(1.0, asked, 400.0 * 2.5), 400.0])
    assert found.least.worth[1] == pytest.approx(2.5 * found.least.worth[0])  # by its arm


def test_prices_of_anchors_take_fewer_ties(tmp_path):
    """Two bounds need both ties, but only one has to be built where a stronger single one costs less."""
    ties = tie(2.5, "largest_force = '0.9 kN'\n") + tie(2.0) + tie(1.8)
    by_force = made(tmp_path, ASKED + ties + "[strengthen.prices]\nforce = 1.0\n")
    assert (by_force.least.force > 0.0).sum() == 2
    by_anchor = made(tmp_path, ASKED + ties + "[strengthen.prices]\nforce = 1.0\nanchor = 1.0\n")
    assert by_anchor.least.force == pytest.approx([0.0, needed(2.0, (1.0 + MARGIN) * LAMBDA), 0.0])
    assert by_anchor.least.cost == pytest.approx(1e-3 * by_anchor.least.force.sum() + 2.0)
    fewest = made(tmp_path, ASKED.replace("factor", "fewest = true\nfactor") + ties + "[strengthen.prices]\nforce = 1.0\n")
    assert fewest.least.force == pytest.approx(by_anchor.least.force)


def test_where_sliding_gives_way_earlier_the_verification_adds_cuts(tmp_path):
    """A dry wall: without dilation it bears 0.356 in place of 0.404, and the cuts of associated sliding leave it below the target."""
    blocks = [*dry_wall(3), box("rock", (-2.0, -0.1, 0.0), (-1.0, 0.1, 2.0), fixed=True)]
    ties = "".join(tie((course + 0.5) * 0.175, parts="['rock', 'c*']") for course in (4, 6, 10))
    found = made(tmp_path, "[strengthen]\nfactor = 0.39\npushes = ['x']\n" + ties, blocks, mu=0.65)
    assert facts(found)["factor"]["before"] < 0.36
    assert len(found.cuts) == sum(not cut.dilates for cut in found.cuts) > 0  # associated sliding alone would ask for no tie
    assert found.reached == pytest.approx(1.0)  # the mechanism found before starts at the target now, though the search finds another
    assert 0.39 <= found.with_least[0].whole.analysis.least.optimum.factor < 0.4
    assert all(case.whole.analysis.least.optimum.factor >= 0.39 for case in found.after)


def test_what_no_candidate_crosses_is_named(tmp_path):
    blocks = [ground(4.0), ROCK, WALL, box("b", (2.0, -0.2, 0.0), (2.3, 0.2, HIGH))]
    with pytest.raises(
        InputError, match=r"out of reach: the whole, push x: .*1 of block.*load factor of 0.1, 0.3003 .*no candidate crosses"
    ):
        made(tmp_path, ASKED + tie(2.5), blocks)


def test_a_share_of_the_motion_of_a_code_is_met(tmp_path):
    """zeta_E = 1 of a check by accelerations: a0* of the wall is the demand, and its force that of the factor which follows."""
    check = "[limit]\npush = 'x'\n[limit.check]\nspectrum = 'EC8'\nag = 3.0\n"
    found = made(tmp_path, check + "[strengthen]\nzeta_E = 1.0\n" + tie(2.5))
    numbers = facts(found)
    assert numbers["zeta_E"]["before"] < 1.0 <= numbers["zeta_E"]["with_least"] <= 1.01
    alpha = numbers["parts"][0]["factor_with_least"]
    assert found.least.force == pytest.approx([needed(2.5, alpha)], rel=1e-6)
    assert numbers["verdict"] == {"before": "NOT satisfied", "with_least": "not decided", "after": "satisfied"}
    assert any("by accelerations" in note for note in numbers["notes"])


def test_the_command_writes_a_scene_with_its_ties(tmp_path):
    path, folder = scene(tmp_path, [ground(4.0), ROCK, WALL], ASKED + tie(2.5)), tmp_path
    done = masonry_cd("strengthen", path, "-o", folder / "out", "--shake", "--set", "run.duration=0.01")
    assert done.exit_code == 0, done.output
    assert "1 tie for load factor 0.3" in done.output
    numbers = json.loads((folder / "out" / "strengthen.json").read_text())
    written = tomllib.loads((folder / "out" / "strengthened.toml").read_text())
    (tables,) = written["structure"]["ties"]
    assert tables["yield_force"] == numbers["ties"][0]["yield_force"] == 26578.0
    assert "strengthen" not in written
    for name in ("before.png", "after.png", "strengthen.html", "ties.csv", "parts.csv", "shaken/comparison.csv"):
        assert (folder / "out" / name).stat().st_size > 0, name
    there = folder / "strengthened.toml"  # next to the blocks that it names
    there.write_text((folder / "out" / "strengthened.toml").read_text())
    again = limit_case(read_scene(there, ['limit.push="x"']))
    assert again.whole.analysis.least.optimum.factor == pytest.approx(numbers["factor"]["after"])


def test_a_scene_keeps_its_text(tmp_path):
    path = scene(tmp_path, [ground(4.0), ROCK, WALL], ASKED + tie(2.5))
    path.write_text(
        path.read_text().replace('structure = {kind = "file", path = "blocks.json"}\n', "")
        + '# a note\n[structure]\nkind = "file"\npath = "blocks.json" # own\n'
    )
    found = strengthened(read_scene(path))
    from masonry_cd.strengthening.files import scene_text

    text = scene_text(found.asked.scene, found.rows)
    assert "# own\n" in text and "[strengthen" not in text
    assert tomllib.loads(text)["structure"]["ties"] == found.rows


@pytest.mark.parametrize(
    ("name", "rule", "lines"),
    [
        ("church_tied", "roofs", {"x": 2, "y": 3}),
        ("church_tied", "corners", {"x": 2, "y": 2}),
        ("house_floors", "floors", {"x": 2, "y": 2}),
    ],
)
def test_rules_lie_under_what_rests_on_walls(name, rule, lines):
    blocks = make_structures(read_scene(f"examples/{name}.toml")).blocks
    found, left = by_rule(blocks, rule, 4.0, 0.5)
    assert {axis: sum(row["along"] == axis for row in found) for axis in "xy"} == lines
    assert not left
    assert all(row["height"] in (7.9, 2.2, 4.7) for row in found)
