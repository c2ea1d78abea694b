# SPDX-License-Identifier: GPL-3.0-or-later
"""Limit analysis from the state that a run left: closed form of a pier that stands tilted, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from command_line import masonry_cd
from limit_scenes import said
from models import box

from masonry_cd.app.case import prepare
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.limit import whole as whole_module
from masonry_cd.limit.case import limit_case
from masonry_cd.limit.left_state import against_undamaged
from structures.files import blockfile

WIDE, HIGH = 0.5, 1.5  # of the pillar [m]
TILT = 0.02  # by which one of the two supports goes down [m]


def scene(folder: Path, name: str = "scene.toml", limit: str = "", high: float = HIGH, down: float = TILT) -> Path:
    """A pillar on two supports side by side, one of which settles: it leans by down / 0.4."""
    blocks = [
        box("left", (-0.3, -0.2, -0.2), (0.1, 0.2, 0.0), fixed=True), box("right", (0.4, -0.2, -0.2), (0.8, 0.2, 0.0), fixed=True),
        box("pillar", (0.0, -0.2, 0.0), (WIDE, 0.2, high)),
    ]  # fmt: skip
    blockfile.write(folder / f"{name}.json", blocks)
    path = folder / name
    path.write_text(
        f'structure = {{kind = "file", path = "{name}.json"}}\nmaterial = {{density = 2000.0, friction = 2.0}}\n'
        f'run = {{dt = 2e-3, duration = 0.6, frames_per_second = 20}}\nlimit = {{push = "-x"{limit}}}\n'
        f'[[loads]]\nkind = "settlement"\nsupports = "right"\ndisplacement = {down}\nduration = 0.4\n'
    )
    return path


@pytest.fixture(scope="module")
def left(tmp_path_factory) -> Path:
    """The folder of a scene that was run into ``run``."""
    folder = tmp_path_factory.mktemp("left")
    run_case(prepare(read_scene(scene(folder))), folder / "run")
    return folder


def test_a_pillar_whose_support_settled_overturns_about_the_edge_that_is_left(left):
    """It rests on the inner edge of the left support, 0.1 m from its own corner: the centre of mass and that edge are where the run left
    them."""
    whole = limit_case(scene(left, "whole.toml"))
    assert whole.whole.analysis.associated.factor == pytest.approx(0.25 / 0.75, rel=1e-6)
    case = limit_case(scene(left, "left.toml", ', from = "run"'))
    centre = case.whole.assembly.centre[2]
    assert centre[2] < 0.75 and centre[0] > 0.25
    edge = case.whole.joints.polygon[case.whole.joints.polygon[:, 0].argmin()]
    assert edge[0] == pytest.approx(0.1, abs=1e-3)
    exact = (centre[0] - edge[0]) / (centre[2] - edge[2])
    assert case.whole.analysis.associated.factor == pytest.approx(exact, rel=1e-3)
    note = next(line for line in said(case) if line.startswith("from run at"))
    assert f"{case.whole.analysis.governing.factor:.4g} against 0.3333 as built" in note


def test_at_the_beginning_it_is_as_built(left):
    case = limit_case(scene(left, "first.toml", ', from = "run", time = 0.0'))
    assert case.whole.analysis.associated.factor == pytest.approx(0.25 / 0.75, rel=1e-3)


@pytest.mark.parametrize(
    ("limit", "high", "message"),
    [
        (', from = "run"', 1.6, 'a run of another structure: block "pillar"'),
        (', from = "nowhere"', HIGH, "no such result file; it takes the folder of a run"),
        (', from = "run", time = 9.0', HIGH, "limit.time: 9 s"),
        (", time = 1.0", HIGH, "time: needs from"),
        (', from = "run", curve = {}', HIGH, "limit.curve: is followed from the structure as built"),
    ],
)
def test_what_is_no_state_of_it_is_refused(left, limit, high, message):
    done = masonry_cd("limit", scene(left, "bad.toml", limit, high), "-o", left / "bad")
    assert done.exit_code == 2 and message in done.output and done.output.count("\n") == 1
    assert not (left / "bad" / "limit.json").exists()


def test_a_wrong_folder_is_said_before_anything_is_analysed(left, monkeypatch):
    monkeypatch.setattr(whole_module, "analyse", lambda *_: pytest.fail("analysed first"))
    with pytest.raises(InputError, match="no such result file"):
        limit_case(scene(left, "bad.toml", ', from = "nowhere"'))


@pytest.mark.parametrize(
    ("now", "whole", "words"),
    [
        ({"unlimited": True, "least": None}, {}, "no finite load factor against load factor 0.3333 as built"),
        ({}, {"unlimited": True, "least": None}, "load factor 0.3333 against no finite load factor as built"),
        ({}, {"standing": 0.5}, "as built it did not stand under its dead loads; load factor 0.3333 now"),
        ({"standing": 0.25}, {}, "as built it bore its dead loads; now it bears 25 % of them"),
        ({}, {"least": None}, "both associated: a search did not converge"),
    ],
)
def test_what_has_no_two_factors_says_which_it_lacks(left, now, whole, words):
    built = limit_case(scene(left, "built.toml")).whole.analysis
    assert built.least is not None
    assert words in against_undamaged(replace(built, **now), replace(built, **whole))
