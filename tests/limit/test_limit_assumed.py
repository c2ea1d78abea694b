# SPDX-License-Identifier: GPL-3.0-or-later
"""limit.assumed: the factor with bond, crushing and fill assumed otherwise, by closed forms and a programme of its own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from limit_scenes import pillar, said, scene
from models import GRAVITY
from scipy.optimize import linprog

from masonry_cd.analysis.limit.outcome import on_the_whole
from masonry_cd.app.scene import parse_scene
from masonry_cd.limit.assumed import STRENGTH, TOGETHER
from masonry_cd.limit.case import LimitCase, limit_case
from masonry_cd.limit.facts import facts

WIDE, HIGH, DEEP = 0.5, 1.5, 0.4  # of the pillar [m]
WEIGHT = 2000.0 * GRAVITY * WIDE * HIGH * DEEP
PUSH = "[limit]\npush = 'x'\n"
CRUSHING = "material.joints.compressive_strength"


def test_a_pillar_that_is_glued_down_bears_b_over_h_without_its_bond(tmp_path: Path) -> None:
    case = limit_case(scene(tmp_path, pillar(), PUSH, joints=", joints = {cohesion = 1e4}"))
    (one,) = case.assumed.rows
    assert (one.assumed, one.factor) == ("bond", pytest.approx(WIDE / HIGH, rel=1e-6))
    assert case.whole is not None and case.whole.analysis.associated.factor > 1.1 * WIDE / HIGH
    verdict = on_the_whole(facts(case))
    assert verdict is not None and one.line in verdict.because and one.line in said(case)


def test_a_pillar_whose_joint_crushes_bears_b_over_h_where_it_would_not(tmp_path: Path) -> None:
    strength = 3.0 * WEIGHT / (WIDE * DEEP)
    case = limit_case(scene(tmp_path, pillar(), PUSH, joints=f", joints = {{compressive_strength = {strength}}}"))
    (one,) = case.assumed.rows
    assert (one.assumed, one.factor) == ("crushing", pytest.approx(WIDE / HIGH, rel=1e-6))
    assert case.whole is not None and case.whole.analysis.associated.factor == pytest.approx(WIDE / HIGH * (1.0 - 1.0 / 3.0), rel=1e-3)


def test_a_check_names_the_factor_without_bond_and_dry_joints_assume_nothing(tmp_path: Path) -> None:
    check = f'{PUSH}[limit.check]\nspectrum = "EC8"\nag = 1.0\ndisplacements = false\n'
    bonded = limit_case(scene(tmp_path, pillar(), check, joints=", joints = {cohesion = 1e4}"))
    assert bonded.verdict is not None and bonded.assumed.rows[0].line in bonded.verdict.reason
    assert limit_case(scene(tmp_path, pillar(), check)).assumed.rows == ()


# --- bridges --------------------------------------------------------------------------------------------------------------------------

PRESTWOOD = {"span": 6.55, "rise": 1.428, "thickness": 0.22, "cover": 0.165, "voussoirs": 16, "width": 3.8, "angle": 30.0, "at": 1.64}
DEEP_ARCH = {"span": 4.0, "rise": 2.0, "thickness": 0.4, "cover": 0.5, "voussoirs": 14, "width": 2.0, "angle": 36.0, "at": 1.2}
AXLE, LINE, FRICTION, MASONRY, FILL = 1e3, 0.3, 2.0, 2100.0, 1900.0


def text_of(arch: dict[str, float], fill: str = "", place: str = "", material: str = "", more: str = "") -> str:
    """The scene of an arch between rigid abutments under a line of load."""
    return f"""
[structure]
kind = "bridge"
width = {arch["width"]}
cover = {arch["cover"]}
spans = [{{span = {arch["span"]}, rise = {arch["rise"]}, thickness = {arch["thickness"]}, voussoirs = {arch["voussoirs"]}}}]
fill = {{density = {FILL}, friction_angle = {arch["angle"]}{fill}}}
{more}
[material]
density = {MASONRY}
friction = {FRICTION}{material}
[[loads]]
kind = "vehicle"
axles = [{AXLE}]
across = "line"
contact = [{LINE}, {LINE}]
{place or f"position = {arch['at']}"}
[limit]
live = [0]
starts = 0
"""


def analysed(text: str, *changes: str) -> LimitCase:
    return limit_case(parse_scene(text, Path("arch.toml"), changes))


def by_own_programme(arch: dict[str, float], share: float, strength: float = np.inf, cells: int = 2, inset: float = 0.0) -> float:
    """The static theorem for a ring of stones as one linear programme: pressures at places of each joint, shear below friction, fill that
    pushes back up to a share of K_p, and the line of load spread evenly over its length and the depth below it (2:1); without a strength
    pressures keep inside the joint by a share of its depth."""
    half, rise, count = 0.5 * arch["span"], arch["rise"], int(arch["voussoirs"])
    radius = (half**2 + rise**2) / (2.0 * rise)
    turn = np.linspace(-1.0, 1.0, count + 1) * np.arcsin(half / radius)
    ray = np.stack([np.sin(turn), np.cos(turn)], axis=1)
    centre, thick, width = np.array([half, rise - radius]), arch["thickness"], arch["width"]
    inner, outer, road = centre + radius * ray, centre + (radius + thick) * ray, rise + thick + arch["cover"]
    sine = np.sin(np.radians(arch["angle"]))
    passive = share * (1.0 + sine) / (1.0 - sine) * FILL * GRAVITY * width
    dead, live, most, push = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros(count), np.zeros((count, 3))
    for k in range(count):
        (xa, za), (xb, zb) = outer[k], outer[k + 1]
        for corners, density in (
            (np.array([inner[k], inner[k + 1], outer[k + 1], outer[k]]), MASONRY),
            (np.array([outer[k], outer[k + 1], [xb, road], [xa, road]]), FILL),
        ):
            x, z = corners.T
            cross = x * np.roll(z, -1) - z * np.roll(x, -1)
            area, first = 0.5 * cross.sum(), ((x + np.roll(x, -1)) * cross).sum() / 6.0
            dead[k] += density * GRAVITY * width * np.array([0.0, -area, -first])
        x = xa + (np.arange(400) + 0.5) / 400.0 * (xb - xa)
        over = LINE + road - (za + (x - xa) / (xb - xa) * (zb - za))
        part = np.where(np.abs(x - arch["at"]) < 0.5 * over, 1.0 / over, 0.0) * (xb - xa) / 400.0
        live[k] += [0.0, -part.sum(), -(x * part).sum()]
        z = np.linspace(za, zb, 401)
        depth = road - 0.5 * (z[1:] + z[:-1])
        height = float((depth * z[1:]).sum() / depth.sum())
        most[k] = passive * depth.mean() * abs(zb - za)
        way = 1.0 if zb > za else -1.0  # what rises to the right has its fill at the left, and is pushed to the right
        push[k] = [way, 0.0, -height * way]
    live /= abs(live[:, 1].sum()) / AXLE
    place = inset + (1.0 - 2.0 * inset) * np.arange(cells) / (cells - 1) if np.isinf(strength) else (np.arange(cells) + 0.5) / cells
    joints = [(inner[k] + s * (outer[k] - inner[k]), np.array([ray[k][1], -ray[k][0]]), ray[k]) for k in range(count + 1) for s in place]
    unknowns = 2 * len(joints) + count + 1  # normal forces, shears, passive pushes, the factor
    equal, right = np.zeros((3 * count, unknowns)), -dead.ravel()
    for i, (point, normal, shear) in enumerate(joints):
        for column, way in ((i, normal), (len(joints) + i, shear)):
            wrench = np.array([way[0], way[1], point[0] * way[1] - point[1] * way[0]])
            k = i // cells
            if k < count:
                equal[3 * k : 3 * k + 3, column] += wrench
            if k > 0:
                equal[3 * k - 3 : 3 * k, column] -= wrench
    for k in range(count):
        equal[3 * k : 3 * k + 3, 2 * len(joints) + k] = push[k]
    equal[:, -1] = live.ravel()
    slides = np.zeros((2 * len(joints), unknowns))
    for i in range(len(joints)):
        for row, sign in ((2 * i, 1.0), (2 * i + 1, -1.0)):
            slides[row, len(joints) + i], slides[row, i] = sign, -FRICTION
    cap = None if np.isinf(strength) else strength * width * thick / cells
    bounds = [(0.0, cap)] * len(joints) + [(None, None)] * len(joints) + [(0.0, float(p)) for p in most] + [(0.0, None)]
    found = linprog(-np.eye(unknowns)[-1], slides, np.zeros(len(slides)), equal, right, bounds)
    return float(found.x[-1])


@pytest.mark.parametrize("arch", [PRESTWOOD, DEEP_ARCH], ids=["Prestwood", "deep"])
def test_the_rows_of_a_bridge_are_those_of_a_programme_of_its_own(arch: dict[str, float]) -> None:
    found = analysed(text_of(arch, ', spread = "2:1"')).assumed
    rows = {row.key: row.factor for row in found.rows}
    assert found.rows[0].factor == pytest.approx(by_own_programme(arch, 1.0 / 3.0), rel=0.02)
    assert rows["structure.fill.passive=0"] == pytest.approx(by_own_programme(arch, 0.0), rel=0.02)
    assert rows["structure.fill.passive=1"] == pytest.approx(by_own_programme(arch, 1.0), rel=0.02)
    crushed = f"{CRUSHING}={STRENGTH:g}"
    assert rows[crushed] == pytest.approx(by_own_programme(arch, 1.0 / 3.0, STRENGTH, 60), rel=0.02)
    assert rows[f"{crushed} structure.fill.passive=0"] == pytest.approx(by_own_programme(arch, 0.0, STRENGTH, 60), rel=0.02)
    assert found.range == (min(rows.values()), max(rows.values()))


@pytest.mark.parametrize("place", ["", "# at its worst"])
def test_each_row_is_the_factor_of_a_scene_that_assumes_so(place: str) -> None:
    text = text_of(DEEP_ARCH | {"voussoirs": 9}, place=place) + "positions = 6\n"
    found = analysed(text).assumed
    assert len(found.rows) == 6
    for row in [row for row in found.rows[1:] if not place or row.assumed == "fill"]:
        again = analysed(text, *row.key.split())
        assert again.whole is not None and again.whole.analysis.governing.factor == pytest.approx(row.factor, rel=1e-3 if place else 1e-9)


def test_the_verdict_takes_what_lowers_the_factor_where_the_scene_states_nothing() -> None:
    arch = PRESTWOOD | {"voussoirs": 9}
    case = analysed(text_of(arch))
    found, verdict = case.assumed, on_the_whole(facts(case))
    assert found.decides is not None and found.decides.assumed == TOGETHER and found.decides.factor == min(found.range or ())
    assert verdict is not None and verdict.grade == f"load factor at most {found.decides.factor:.4g}"
    assert "structure.fill.passive" in verdict.why and CRUSHING in verdict.why
    strong = analysed(text_of(arch, material="\njoints = {compressive_strength = 5e7}"))
    assert strong.assumed.decides is not None and strong.assumed.decides.key == "structure.fill.passive=0"
    stated = analysed(text_of(arch, ', passive = 0.5, spread = "2:1"', material="\njoints = {compressive_strength = 5e7}"))
    verdict, own = on_the_whole(facts(stated)), stated.assumed.rows[0].factor
    assert stated.assumed.decides is None and verdict is not None and verdict.grade == f"load factor at most {own:.4g}"
    named = analysed(text_of(arch, material='\nmasonry = {kind = "solid brick", crushing = false}'))
    assert {row.key: row.counts for row in named.assumed.rows}[f"{CRUSHING}=3.45e+06"] is False  # the scene says that nothing crushes


def test_walls_are_left_out_as_by_a_scene_without_them() -> None:
    walls = "[structure.walls]\nthickness = 0.3\ncourse_height = 1.2\nunit_length = 2.0\n"
    arch = PRESTWOOD | {"voussoirs": 7, "span": 3.0, "rise": 1.0, "thickness": 0.4, "at": 0.8}
    with_walls = analysed(text_of(arch, more=walls), "material.friction=0.7").assumed
    (row,) = [row for row in with_walls.rows if row.assumed == "walls"]
    bare = analysed(text_of(arch), "material.friction=0.7").whole
    assert bare is not None and row.factor == pytest.approx(bare.analysis.governing.factor, rel=1e-9)


@pytest.mark.parametrize(("pressure", "end"), [("none", "which stiffen the arches"), ("active", "which give way before the arches")])
def test_walls_stiffen_the_arches_until_they_give_way(pressure: str, end: str) -> None:
    """Walls on which nothing presses add weight and friction; those that the fill pushes out bear less than the arches alone."""
    arch = PRESTWOOD | {"voussoirs": 7, "span": 3.0, "rise": 1.0, "thickness": 0.4, "at": 0.8}
    walls = "[structure.walls]\nthickness = 0.45\ncourse_height = 1.2\nunit_length = 2.0\n"
    found = analysed(text_of(arch, f', pressure = "{pressure}"', more=walls), "material.friction=0.7").assumed
    own, (row,) = found.rows[0].factor, [row for row in found.rows if row.assumed == "walls"]
    assert own is not None and row.factor is not None and row.words.endswith(end)
    assert (row.factor < 0.97 * own) if pressure == "none" else (0.0 < own < 0.97 * row.factor)


def test_a_check_that_is_met_with_what_the_scene_does_not_state_is_not_decided() -> None:
    """A demand between what the bridge bears as computed and what it bears without what is assumed."""
    text = text_of(DEEP_ARCH | {"voussoirs": 9}).partition("[[loads]]")[0] + PUSH
    spectrum = '[limit.check]\nspectrum = "EC8"\ndisplacements = false\nag = '
    ag = 0.5
    found = analysed(text + f"{spectrum}{ag}\n")
    assert found.verdict is not None and found.verdict.ratio is not None and found.verdict.state == "satisfied"
    own, decides = found.assumed.rows[0].factor, found.assumed.decides
    assert own is not None and decides is not None and decides.factor is not None and decides.factor < 0.8 * own
    asked = ag * found.verdict.ratio / 1.15  # borne 1.15 times as computed
    doubted = analysed(text + f"{spectrum}{asked}\n").verdict
    assert doubted is not None and doubted.state == "not decided" and "passive_shaken" in doubted.reason
    stated = analysed(
        text + f"{spectrum}{asked}\n", "structure.fill.passive_shaken=0.3", "material.joints.compressive_strength=1e9"
    ).verdict
    assert stated is not None and stated.state == "satisfied"


def test_rings_bear_as_one_where_they_are_bonded_and_less_the_less_they_are() -> None:
    """With stones of both rings between the same joints, bond that does not break makes the one ring that a row of the table has."""
    arch = PRESTWOOD | {"voussoirs": 9, "thickness": 0.44}
    text = text_of(arch, ', spread = "2:1", passive = 0.0').replace("voussoirs = 9", "voussoirs = 9, rings = 2")
    found = analysed(text, "material.friction=0.6").assumed
    (row,) = [row for row in found.rows if row.assumed == "rings"]
    one = analysed(text, "material.friction=0.6", row.key).whole
    assert one is not None and row.factor == pytest.approx(one.analysis.governing.factor, rel=1e-9) and not row.counts
    bond = "material.joints={default={}, arch1_ring1-arch1_ring2={cohesion=%g}}"
    factors = [found.rows[0].factor]
    for cohesion in (1e4, 3e4, 1e6):
        bonded = analysed(text, "material.friction=0.6", bond % cohesion).whole
        assert bonded is not None
        factors.append(bonded.analysis.governing.factor)
    assert factors == sorted(factors) and factors[0] < 0.7 * factors[-1]
    assert factors[-1] == pytest.approx(row.factor, rel=1e-3)
