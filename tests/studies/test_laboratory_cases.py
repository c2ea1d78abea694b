# SPDX-License-Identifier: GPL-3.0-or-later
"""studies.laboratory: the closed form of a bed, scenes that a user can run, and a command that lists its cases."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import masonry_cd

import structures
from masonry_cd.app.progress import Interrupted
from masonry_cd.app.scene import read_scene
from masonry_cd.io.summary import Summary
from masonry_cd.limit.case import limit_case
from masonry_cd.studies.laboratory import field_tests
from masonry_cd.studies.laboratory.case import Sample, run_in
from masonry_cd.studies.laboratory.cases import CASES, granite_walls, overturning, restitution, rocking_set
from masonry_cd.studies.laboratory.cases.bed import exact
from reports.laboratory import curves_figure


def test_the_closed_form_of_the_bed() -> None:
    published = (4040, 5054, 5950, 6397, 6703, 6942, 7011)  # at 0.1, 0.2, 0.5, 1, 2, 5, 10 mm [N]
    for way, force in zip((1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2), published, strict=True):
        assert exact(way) == pytest.approx(force, rel=1e-3)


def test_the_threshold_of_overturning_falls_towards_that_of_uplift() -> None:
    """A long pulse overturns whatever lifts off, at g tan(alpha); a short one by its impulse a t, which then decides alone."""
    assert overturning.exact(1e2) / 9.81 == pytest.approx(0.1, rel=1e-6)
    assert overturning.exact(1e-4) * 1e-4 == pytest.approx(overturning.exact(2e-4) * 2e-4, rel=1e-3)


def test_a_block_that_rocks_keeps_what_the_heights_of_its_swings_say() -> None:
    """A swing made by hand from Housner's factor gives it back."""
    slenderness, share = 4.0, 0.8
    alpha = float(np.arctan(1.0 / slenderness))
    first = share * alpha
    height = (np.cos(alpha - first) - np.cos(alpha)) * restitution.housner(slenderness) ** 2
    second = alpha - float(np.arccos(np.cos(alpha) + height))
    tilt = np.concatenate([np.linspace(first, 0.0, 50), -second * np.sin(np.linspace(0.0, np.pi, 201))[1:-1], [1e-6]])
    assert restitution.kept(tilt, slenderness) == pytest.approx(restitution.housner(slenderness), rel=1e-4)


@pytest.mark.parametrize("slenderness", [2.0, 8.0])
def test_a_block_that_rocks_is_followed_through_two_half_swings(slenderness: float) -> None:
    """Its time to the impact by quadrature of the energy equation of a block that turns about a corner."""
    alpha, p2 = float(np.arctan(1.0 / slenderness)), 3.0 * 9.81 / (2.0 * restitution.WIDTH * float(np.hypot(1.0, slenderness)))
    first = restitution.RELEASED * alpha
    share = (np.arange(20_000) + 0.5) / 20_000
    angle = first * (1.0 - share * share)  # fine where it is let go, at rest
    speed = np.sqrt(2.0 * p2 * (np.cos(alpha - first) - np.cos(alpha - angle)))
    to_impact = float((2.0 * first * share / speed).mean())
    assert 2.0 * to_impact < restitution.lasting(slenderness) < 2.4 * to_impact


def test_what_was_measured_of_rocking_blocks_lies_next_to_the_computed_curve() -> None:
    name, slenderness, measured = restitution.measured("concrete")
    assert name == "measured on concrete"
    assert set(slenderness) < set(restitution.SHAPES)
    assert measured == pytest.approx([0.97 * 0.85, 0.95 * (1.0 - 1.5 / 26.0)])


def test_blocks_of_a_set_lift_off_rock_and_fall_as_housner_has_it() -> None:
    """Ground that accelerates and stops: below g tan(alpha) nothing moves, and about the closed form of small angles it falls."""
    slope, t = rocking_set.WIDTH / rocking_set.HEIGHT, 0.4
    p = float(np.sqrt(0.75 * 9.81 / rocking_set.RADIUS))
    exact = 9.81 * slope * 0.5 * (1.0 + np.sqrt(1.0 + 2.0 / (np.cosh(p * t) - 1.0)))
    sizes = np.array([0.99 * 9.81 * slope, 0.9 * exact, 1.1 * exact])
    ground = np.zeros((3000, 3))
    ground[: round(t / rocking_set.DT)] = sizes
    still, rocks, falls = rocking_set.housner(ground)
    assert still == 0.0
    assert 0.3 < rocks < 1.0
    assert np.isinf(falls)


def test_samples_are_compared_by_quartiles_falls_and_kolmogorovs_distance() -> None:
    one = Sample("tilt", "", [0.1, 0.2, 0.3, np.inf], [0.2, 0.3, np.inf, np.inf])
    found = one.as_dict()
    assert found["measured"] == {"count": 4, "fallen": 0.25, "quartiles": [0.1, 0.2, 0.3]}
    assert found["computed"]["quartiles"] == [0.2, 0.3, None]
    assert found["distance"] == pytest.approx(0.25)
    assert "50 % fell; distance 0.250" in one.line


def test_the_bridge_is_computed_once_and_its_scene_gives_the_same_load_again(tmp_path: Path) -> None:
    load, hinges = field_tests.collapse(field_tests.PRESTWOOD, "structure.fill.passive=0.5", folder=tmp_path)
    assert hinges == 4
    again = limit_case(read_scene(tmp_path / "scene.toml"))
    assert again.whole.analysis.governing.factor == load
    (fill,) = structures.make(read_scene(tmp_path / "scene.toml").structure, 1800.0, tmp_path).fills
    assert (fill.passive, fill.density) == (0.5, 2040.0)
    assert fill.level == pytest.approx(1.428 + 0.22 + 0.165, abs=1e-2)  # crown of a faceted ring


def test_walls_are_as_high_and_long_as_those_tested() -> None:
    for kind in (granite_walls.SAWN, granite_walls.IRREGULAR, granite_walls.RUBBLE):
        blocks = kind.wall().blocks()
        stones = np.concatenate([block.vertices for block in blocks if block.group == "wall"])
        assert np.ptp(stones, axis=0) == pytest.approx([1.0, 0.2, 1.2])
        (beam,) = (block for block in blocks if block.name == "beam")
        assert beam.vertices[:, 2].mean() == pytest.approx(1.325)
        volume = sum(float(np.prod(np.ptp(block.vertices, axis=0))) for block in blocks if block.group == "wall")
        assert volume == pytest.approx(1.0 * 0.2 * 1.2)


SHARES = {
    "bed": 0.35, "bending": 0.35, "arch": 0.5, "columns": 0.15, "dry_walls": 0.6, "cyclic_walls": 2.0, "mortar_walls": 2.0,
    "cracked_walls": 0.25, "arch_bridge": 0.55, "restitution": 0.6, "overturning": 0.02, "rocking_set": 0.0,
}  # fmt: skip
OPEN_BED = 0.049  # by which an open bed of springs bears less than an edge, see overturning.py


def test_every_case_is_repeated_by_the_validation() -> None:
    assert set(SHARES) == set(CASES)


@pytest.mark.validation
@pytest.mark.parametrize(("name", "share"), SHARES.items())
def test_a_case_of_the_laboratory(name: str, share: float, tmp_path: Path) -> None:
    """Each number within a share of what was measured, distributions no farther apart than by chance: the page says which are nearer."""
    done = masonry_cd("validate", name, "-o", tmp_path)
    print(done.output)
    assert done.exit_code == 0, done.output
    for row in json.loads((tmp_path / "table.json").read_text()):
        if "crack" in row["quantity"]:  # half of it where stones stay whole
            assert row["elastic"] >= (0.5 if row["quantity"].startswith(("0.15", "0.5")) else 0.1), row
            continue
        for kind, below in (("rigid", 0.0), ("elastic", OPEN_BED if name == "overturning" else 0.0)):
            assert row[kind] is None or -share - below <= row[kind] / row["measured"] - 1.0 <= share, row
    for sample in json.loads((tmp_path / "samples.json").read_text()):
        assert sample["probability"] > 0.05, sample


def test_the_crack_maps_of_rubble_lie_on_their_walls() -> None:
    maps = granite_walls.crack_maps()
    assert len(maps) == 3
    for lines in maps:
        points = np.array([point for line in lines for point in line])
        assert (points >= 0.0).all()
        assert (points <= [1.0, granite_walls.HEIGHT]).all()
        length = sum(float(np.hypot(*np.diff(line, axis=0).T).sum()) for line in lines)
        assert 2.5 < length < 6.0
        assert min(map(len, lines)) > 1


@pytest.mark.slow(reason="a limit analysis of 58 blocks that crush")
def test_joints_crush_where_a_wall_has_a_strength_and_limit_analysis_bears_a_block_of_it(tmp_path: Path) -> None:
    """N (L - N / (t f)) / (2 H), with the weight of wall and beam in N at the toe: joints above it are pressed less."""
    kind = granite_walls.RUBBLE
    wall = kind.wall(kind.strength)
    weight = 9.81 * wall.thick * wall.length * (wall.density * granite_walls.HEIGHT + 2500.0 * wall.depth)
    force = 1.25e6 * wall.thick * wall.length + weight
    closed = force * (wall.length - force / (wall.thick * 1e6 * kind.strength)) / (2.0 * granite_walls.LEVER)
    assert wall.limit_force(tmp_path, "rubble", 1.25, 1e9 * 2.5) == pytest.approx(closed, rel=0.02)


def test_an_open_bed_of_springs_bears_less_than_an_edge() -> None:
    """The share follows by its maximum over theta, for the block that pulses overturn."""
    width, height, stiffness = overturning.WIDTH, overturning.HEIGHT, overturning.LAW["normal_stiffness"]
    weight = width * height * overturning.DENSITY * 9.81
    theta = np.geomspace(1e-5, 0.1, 10001)
    moment = 1.0 - 2.0 / width * (np.sqrt(2.0 * weight / (stiffness * theta)) / 3.0 + 0.5 * theta * height)
    assert 1.0 - moment.max() == pytest.approx(OPEN_BED, abs=5e-4)


def test_points_that_belong_to_curves_have_their_colours() -> None:
    x = np.arange(3.0)
    curves, points = [("a", x, x), ("b", x, 2.0 * x)], [("p", x, x), ("q", x, x)]
    lines = curves_figure(curves, points=points).axes[0].lines[:4]
    of_points, of_curves = np.split(np.array([line.get_color() for line in lines]), 2)
    assert of_points.tolist() == of_curves.tolist()
    assert len(set(of_curves)) == 2
    (alone, *_) = curves_figure(curves, points=points[:1]).axes[0].lines
    assert alone.get_color() not in set(of_curves)


def test_a_case_that_is_interrupted_has_no_result(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("masonry_cd.studies.laboratory.case.run_case", lambda case, folder: Summary(signal=15))
    tables = {"material": {"density": 2000.0, "friction": 0.6}, "run": {"dt": 1e-3, "duration": 1e-2}}
    with pytest.raises(Interrupted):
        run_in(tmp_path, restitution.tilted(3.0), tables)
