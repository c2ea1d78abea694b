# SPDX-License-Identifier: GPL-3.0-or-later
"""Damage by part against motions that are known by construction: hinges, slips, leaning walls, fallen blocks, drift."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from made_run import at_rest, box, shifted, turned, write_run
from places import ROOT

from masonry_cd.analysis.damage import grades, part_damage
from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.mechanism import Rules
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.state import State
from reports import damage as damage_files

BASE = box("base", (-3, -1, -0.5), (3, 1, 0), "base", fixed=True)
PIER = [
    BASE,
    *(box(f"p{k}", (-0.5, -0.5, k), (0.5, 0.5, k + 1), "pier") for k in range(3)),
    box("cap", (-0.5, -0.5, 3), (0.5, 0.5, 3.5), "cap"),
]
WALL = [
    box("base", (-1, -1, -0.5), (7, 1, 0), "base", fixed=True),
    *(box(f"w{k}.{i}", (2 * i, -0.2, k), (2 * i + 2, 0.2, k + 1), "wall") for k in range(3) for i in range(3)),
]


def damage_of(folder: Path, blocks: Sequence[Block], states: Sequence[State], **settings: object) -> part_damage.PartDamage:
    with Results.open(write_run(folder / "result.h5", blocks, states)) as results:
        return part_damage.part_damage(results, part_damage.DamageSettings(**settings))  # type: ignore[arg-type]


def rows_of(damage: part_damage.PartDamage) -> dict[str, dict[str, object]]:
    return {row["part"]: row for row in damage.parts}


def turned_together(state: State, indices: Sequence[int], pivot: Sequence[float], degrees: float, axis: Sequence[float]) -> State:
    for index in indices:
        state = turned(state, index, pivot, degrees, axis)
    return state


def test_at_rest_nothing_is_damaged(tmp_path: Path) -> None:
    rest = at_rest(PIER)
    damage = damage_of(tmp_path, PIER, [rest, rest])
    assert [row["part"] for row in damage.parts] == ["pier", "cap", "structure"]
    for row in damage.parts:
        assert (row["grade"], row["mechanism"], row["grade_reason"]) == ("D0", "none", "")
        assert (row["opened"], row["slid"], row["separated"], row["hinges"], row["lost_blocks"]) == (0, 0, 0, 0, 0)
        assert row["residual_drift"] == pytest.approx(0.0, abs=1e-12)
    assert damage.hinges == []


def test_a_joint_between_two_parts_belongs_to_both_and_counts_once_in_the_whole(tmp_path: Path) -> None:
    """The cap slips by 8 mm on the pier: both have one slid joint of 1 m2, and so has the structure."""
    rest = at_rest(PIER)
    rows = rows_of(damage_of(tmp_path, PIER, [rest, shifted(rest, 4, (0.008, 0, 0))]))
    for part, joints in (("pier", 4), ("cap", 1), ("structure", 4)):
        row = rows[part]
        assert (row["joints"], row["slid"], row["slipped"]) == (joints, 1, 1), part
        assert row["slid_area"] == pytest.approx(1.0)
        assert row["residual_sliding"] == pytest.approx(0.008, abs=1e-9)
        assert (row["mechanism"], row["grade"], row["grade_label"]) == ("sliding", "D2", "moderate damage")
        assert row["grade_reason"] == 'sliding 8 mm in joint 3 ("p2", "cap") (D2 from 5 mm)'


def test_a_known_hinge_is_found_where_it_touches(tmp_path: Path) -> None:
    """The two upper blocks and the cap turn by 0.6 degrees about the right edge of the joint at z = 1, and close to 0.2."""
    rest = at_rest(PIER)
    wide, closed = (turned_together(rest, (2, 3, 4), (0.5, 0, 1.0), angle, (0, 1, 0)) for angle in (0.6, 0.2))
    damage = damage_of(tmp_path, PIER, [rest, wide, closed])
    (hinge,) = damage.hinges
    assert {hinge["block_a"], hinge["block_b"]} == {"p0", "p1"}
    assert (hinge["parts"], hinge["touches_towards"], hinge["at_end"]) == ("pier", "+x", True)
    np.testing.assert_allclose([hinge["x"], hinge["y"], hinge["z"]], [0.5, 0.0, 1.0], atol=1e-9)
    assert hinge["opening"] == pytest.approx(np.sin(np.radians(0.6)), abs=1e-9)
    assert hinge["residual_opening"] == pytest.approx(np.sin(np.radians(0.2)), abs=1e-9)
    assert hinge["time"] == pytest.approx(0.1)
    row = rows_of(damage)["pier"]
    assert (row["mechanism"], row["hinges"], row["hinges_ever"]) == ("hinging", 1, 1)
    assert row["first_opening_time"] == pytest.approx(0.1)
    assert row["crack_2_mm"] == 1 and sum(row[key] for key in row if key.startswith("crack_")) == 1


def test_a_hinge_that_closes_again_is_remembered_but_is_no_mechanism(tmp_path: Path) -> None:
    rest = at_rest(PIER)
    damage = damage_of(tmp_path, PIER, [rest, turned_together(rest, (2, 3, 4), (0.5, 0, 1.0), 0.5, (0, 1, 0)), rest])
    row = rows_of(damage)["pier"]
    assert (row["mechanism"], row["hinges"], row["hinges_ever"], row["opened"], row["grade"]) == ("none", 0, 1, 1, "D0")
    assert [h["mechanism"] for h in damage.history if h["part"] == "pier"] == ["none", "hinging", "none"]


def test_lifted_joints_part_and_do_not_hinge(tmp_path: Path) -> None:
    rest = at_rest(PIER)
    row = rows_of(damage_of(tmp_path, PIER, [rest, shifted(rest, [2, 3, 4], (0, 0, 0.002))]))["pier"]
    assert (row["mechanism"], row["hinges"], row["open"]) == ("parting", 0, 1)


@pytest.mark.parametrize(("sign", "towards"), [(1.0, "-y"), (-1.0, "+y")])
def test_a_leaning_wall_overturns_out_of_plane(tmp_path: Path, sign: float, towards: str) -> None:
    """A wall along x that turns as one by 1.5 degrees about an edge of its foot."""
    rest = at_rest(WALL)
    lean = turned_together(rest, range(1, 10), (0, -0.2 * sign, 0), 1.5 * sign, (1, 0, 0))
    row = rows_of(damage_of(tmp_path, WALL, [rest, lean]))["wall"]
    assert (row["mechanism"], row["other_mechanisms"], row["turn_towards"]) == ("out-of-plane overturning", "hinging", towards)
    assert row["turn"] == pytest.approx(np.radians(1.5), rel=1e-6)
    calm = rows_of(damage_of(tmp_path, WALL, [rest, lean], rules=Rules(turned=0.03)))["wall"]
    assert calm["mechanism"] == "hinging"


def test_two_walls_of_one_part_that_lean_apart_overturn_both(tmp_path: Path) -> None:
    """Nave walls are one part of two pieces; their rotations have opposite senses and must not cancel."""
    far = [box(f"v{b.name}", b.vertices.min(axis=0) + [0, 0.7, 0], b.vertices.max(axis=0) + [0, 0.7, 0], "wall") for b in WALL[1:]]
    blocks = [*WALL, *far]
    rest = at_rest(blocks)
    lean = turned_together(rest, range(1, 10), (0, -0.2, 0), 1.2, (1, 0, 0))
    lean = turned_together(lean, range(10, 19), (0, 0.9, 0), -1.2, (1, 0, 0))
    assert rows_of(damage_of(tmp_path, blocks, [rest, lean]))["wall"]["mechanism"] == "out-of-plane overturning"


def test_a_pier_leaning_as_a_whole_overturns(tmp_path: Path) -> None:
    rest = at_rest(PIER)
    lean = turned_together(rest, (1, 2, 3, 4), (0.5, 0.5, 0), 1.0, (0, 1, 0))
    row = rows_of(damage_of(tmp_path, PIER, [rest, lean]))["pier"]
    assert (row["mechanism"], row["turn_towards"]) == ("overturning", "+x")


def test_fallen_blocks_are_lost_and_their_joints_make_no_crack(tmp_path: Path) -> None:
    """The cap falls next to the pier: the pier is whole, the cap is lost; of the structure a seventh has gone."""
    rest = at_rest(PIER)
    damage = damage_of(tmp_path, PIER, [rest, shifted(rest, 4, (1.5, 0, -3.0))])
    rows = rows_of(damage)
    assert (rows["cap"]["mechanism"], rows["cap"]["grade"], rows["cap"]["lost_share"]) == ("falling blocks", "D5", 1.0)
    assert rows["cap"]["lost_names"] == ["cap"]
    assert (rows["pier"]["grade"], rows["pier"]["separated"], rows["pier"]["apart"], rows["pier"]["mechanism"]) == ("D0", 1, 0, "none")
    assert rows["structure"]["lost_share"] == pytest.approx(0.5 / 3.5)
    assert (rows["structure"]["grade"], rows["structure"]["mechanism"]) == ("D4", "falling blocks")


def test_drift_of_a_shear_is_its_slope(tmp_path: Path) -> None:
    """Courses shifted by 2 mm per metre of height, on a base that rides along: a drift of 0.002 everywhere, nothing absolute."""
    blocks = [BASE, *(box(f"c{k}", (-0.5, -0.5, k / 2), (0.5, 0.5, k / 2 + 0.5), "pier") for k in range(10))]
    rest = at_rest(blocks)
    sheared = rest.copy()
    sheared.position[1:, 1] += 0.002 * sheared.position[1:, 2]
    end = shifted(sheared, slice(None), (0.3, -0.1, 0.0))
    twice = rest.copy()
    twice.position[1:, 1] -= 0.004 * twice.position[1:, 2]
    damage = damage_of(tmp_path, blocks, [rest, twice, end])
    levels = [row for row in damage.levels if row["part"] == "pier"]
    assert [row["level"] for row in levels] == list(range(11))
    assert levels[0]["mean_z"] == pytest.approx(0.0) and np.isnan(levels[0]["residual_drift"])
    for row in levels[1:]:
        assert row["residual_drift"] == pytest.approx(0.002, rel=1e-9)
        assert row["largest_drift"] == pytest.approx(0.004, rel=1e-9)
        assert row["residual_y"] == pytest.approx(0.002 * row["mean_z"], rel=1e-9)
        assert row["largest_displacement"] == pytest.approx(0.004 * row["mean_z"], rel=1e-9)
    row = rows_of(damage)["structure"]
    of_height = 4.75 / 5.0  # the highest course has its centre a quarter of a metre below the top
    assert row["residual_drift"] == pytest.approx(0.002 * of_height, rel=1e-9)
    assert row["max_drift"] == pytest.approx(0.004 * of_height, rel=1e-9)


def test_a_single_course_that_slides_has_a_crack_but_no_drift(tmp_path: Path) -> None:
    blocks = [BASE, box("stone", (-0.5, -0.5, 0), (0.5, 0.5, 0.4), "stone")]
    rest = at_rest(blocks)
    row = rows_of(damage_of(tmp_path, blocks, [rest, shifted(rest, 1, (0.006, 0, 0))]))["stone"]
    assert (row["residual_drift"], row["grade"], row["mechanism"]) == (0.0, "D2", "sliding")


def test_spheres_that_shift_are_no_drift(tmp_path: Path) -> None:
    """Two layers of fill, of which the upper one rolls by a third of its height, next to a pier that stands."""
    layers = enumerate((0.2, 1.2))
    blocks = [*PIER, *(Block.sphere(f"s{k}", np.array([3.0 + 0.2 * k, 0.0, z]), 0.2, 2000.0, "fill") for k, z in layers)]
    rest = at_rest(blocks)
    rows = rows_of(damage_of(tmp_path, blocks, [rest, shifted(rest, len(blocks) - 1, (0.4, 0.0, -0.1))]))
    for part in ("fill", "structure"):
        assert (rows[part]["residual_drift"], rows[part]["max_drift"], rows[part]["grade"]) == (0.0, 0.0, "D0")


def test_grades_are_the_highest_reached_and_the_users(tmp_path: Path) -> None:
    default = grades.Grades()
    assert [grades.grade_of(w, 0.0, 0.0, default).name for w in (9e-5, 1e-4, 5e-3, 16e-3, 3.0)] == ["D0", "D1", "D2", "D3", "D4"]
    assert [grades.grade_of(0.0, d, 0.0, default).name for d in (2e-3, 3e-3, 6e-3, 2.0)] == ["D0", "D2", "D3", "D4"]
    assert [grades.grade_of(0.0, 0.0, s, default).name for s in (0.0, 1e-3, 0.05, 0.5)] == ["D0", "D3", "D4", "D5"]
    fallen = grades.grade_of(0.03, 0.0, 0.35, default, "sliding", "joint 1")  # both are D4
    assert (fallen.name, fallen.reason) == ("D4", "lost volume 35 % (D4 from 5 %)")
    own = grades.read_grades({"width": [1, 2, 3, 4, 5], "labels": list("abcdef")})
    grade = grades.grade_of(2.5, 4e-3, 0.0, own)
    assert (grade.name, grade.label, grade.reason) == ("D2", "c", "crack 2.5 m (D2 from 2 m)")


def test_the_files_hold_the_same_numbers(tmp_path: Path) -> None:
    rest = at_rest(PIER)
    hinge = turned_together(rest, (2, 3, 4), (0.5, 0, 1.0), 0.6, (0, 1, 0))
    damage = damage_of(tmp_path, PIER, [rest, hinge, shifted(hinge, 4, (1.5, 0, -3.0))])
    paths = damage_files.write_part_damage(damage, tmp_path)
    assert [path.name for path in paths] == list(damage_files.NAMES_OF_FILES)
    document = json.loads((tmp_path / "damage.json").read_text())
    for name, rows in (("damage.csv", document["parts"]), ("hinges.csv", document["hinges"]), ("drift.csv", document["levels"])):
        with (tmp_path / name).open() as file:
            table = list(csv.DictReader(file))
        assert len(table) == len(rows)
        for cells, row in zip(table, rows, strict=True):
            assert list(cells) == list(row)
            for key, cell in cells.items():
                assert same(cell, row[key]), (name, key, cell, row[key])
    with (tmp_path / "damage_history.csv").open() as file:
        history = list(csv.DictReader(file))
    assert len(history) == 3 * 3
    times, parts = document["history"]["time"], document["history"]["parts"]
    for cells in history:
        k = times.index(float(cells["time"]))
        assert all(same(cells[key], column[k]) for key, column in parts[cells["part"]].items())
    assert document["grades"]["reached_from"]["width"]["D2"] == 0.005
    assert document["grades"]["reached_from"]["width"]["D5"] == "inf"
    assert document["thresholds"]["opened"] == 1e-4


def same(cell: str, value: object) -> bool:
    """True where a CSV cell says what a JSON value says."""
    if value is None:
        return cell == ""
    if isinstance(value, bool):
        return cell == str(value).lower()
    if isinstance(value, list):
        return cell == " ".join(value)
    return float(cell) == value if isinstance(value, (int, float)) else cell == value


def test_without_damage_the_tables_keep_their_headings(tmp_path: Path) -> None:
    rest = at_rest(PIER)
    damage_files.write_part_damage(damage_of(tmp_path, PIER, [rest]), tmp_path)
    assert (tmp_path / "hinges.csv").read_text() == ",".join(damage_files.HINGE_COLUMNS) + "\n"
    hinge = turned_together(rest, (2, 3, 4), (0.5, 0, 1.0), 0.6, (0, 1, 0))
    damage_files.write_part_damage(damage_of(tmp_path, PIER, [rest, hinge]), tmp_path)
    assert (tmp_path / "hinges.csv").read_text().splitlines()[0] == ",".join(damage_files.HINGE_COLUMNS)


def test_thresholds_of_opening_set_the_time_of_the_first(tmp_path: Path) -> None:
    """The joint opens by 1.7 mm at 0.1 s and by 10 mm at 0.2 s; an opening of 5 mm comes with the second."""
    rest = at_rest(PIER)
    states = [rest, *(turned_together(rest, (2, 3, 4), (0.5, 0, 1.0), angle, (0, 1, 0)) for angle in (0.1, 0.6))]
    assert rows_of(damage_of(tmp_path, PIER, states))["pier"]["first_opening_time"] == pytest.approx(0.1)
    coarse = damage_of(tmp_path, PIER, states, thresholds=Thresholds(opened=0.005))
    assert rows_of(coarse)["pier"]["first_opening_time"] == pytest.approx(0.2)


def test_a_group_may_not_be_called_as_the_whole(tmp_path: Path) -> None:
    blocks = [BASE, box("one", (-0.5, -0.5, 0), (0.5, 0.5, 1), "structure")]
    with pytest.raises(InputError, match=r'^group "structure": this name stands for the whole'):
        damage_of(tmp_path, blocks, [at_rest(blocks)])


def test_long_histories_are_thinned_out_but_keep_their_ends(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(part_damage, "FRAMES", 4)
    rest = at_rest(PIER)
    damage = damage_of(tmp_path, PIER, [rest] * 11)
    assert sorted({row["time"] for row in damage.history}) == pytest.approx([0.0, 0.3, 0.7, 1.0])


def test_the_page_on_results_states_the_default_thresholds() -> None:
    text = (ROOT / "docs" / "results.md").read_text(encoding="utf-8")
    for name in ("width", "drift", "lost"):
        (line,) = [line for line in text.splitlines() if line.startswith(f"| `{name}`, ")]
        assert tuple(float(cell) for cell in line.split("|")[2:7]) == getattr(grades.Grades(), name)
