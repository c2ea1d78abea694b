# SPDX-License-Identifier: GPL-3.0-or-later
"""Rigid runs under base motion say what they leave out; others are left alone."""

import pytest
from command_line import masonry_cd

from masonry_cd.app.case import prepare
from masonry_cd.app.scene import parse_scene
from masonry_cd.app.summary import FEW_FREE, elasticity_left_out
from masonry_cd.io.summary import Summary, read_summary

WALL = 'structure = { kind = "wall", length = 2.0, height = 1.0, thickness = 0.3, course_height = 0.25, unit_length = 0.5 }\n'
FEW_BLOCKS = 'structure = { kind = "wall", length = 0.5, height = 0.5, thickness = 0.3, course_height = 0.25, unit_length = 0.5 }\n'
SHAKEN = '[[loads]]\nkind = "sinusoidal"\ndirection = "x"\namplitude = 0.05\nfrequency = 5.0\ncycles = 2\n'
SETTLING = '[[loads]]\nkind = "settlement"\nsupports = ["base"]\ndirection = "-z"\ndisplacement = 0.01\nduration = 0.1\n'
RUN = "[run]\ndt = 2e-3\nduration = 0.1\n"
RIGID = "[material]\ndensity = 2000.0\nfriction = 0.6\n"
NAMED = '[material]\nfriction = 0.6\nmasonry = { kind = "squared stone", stiffness = "rigid" }\n'
ELASTIC = '[material]\nfriction = 0.6\nmasonry = "squared stone"\n'


def left_out(text, tmp_path):
    return elasticity_left_out(prepare(parse_scene(text, tmp_path / "scene.toml")))


def test_masonry_that_is_named_is_softer_or_stiffer_than_what_is_assumed(tmp_path):
    assumed, named = (left_out(WALL + material + SHAKEN + RUN, tmp_path) for material in (RIGID, NAMED))
    assert not assumed.elastic_basis.named and named.elastic_basis.named
    ratio = (2243.4 / 2850e6 / (2000.0 / 1500e6)) ** 0.5  # of sqrt(density / E)
    assert named.elastic_period / assumed.elastic_period == pytest.approx(ratio, rel=1e-3)


@pytest.mark.parametrize(
    "text",
    [
        WALL + RIGID + RUN,
        WALL + RIGID + SETTLING + RUN,
        WALL + ELASTIC + SHAKEN + RUN,
        WALL + RIGID + "[material.joints]\nnormal_stiffness = 1e10\n" + SHAKEN + RUN,
        FEW_BLOCKS + RIGID + SHAKEN + RUN,
    ],
    ids=["at rest", "settling", "masonry", "stiffness", "few blocks"],
)
def test_others_are_left_alone(text, tmp_path):
    assert left_out(text, tmp_path) == Summary()
    assert FEW_FREE >= 4


def test_a_run_says_it_last_and_keeps_it(tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text(WALL + RIGID + SHAKEN + RUN + "[report]\nhtml = true\n")
    result = masonry_cd("run", scene, "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    last = [line for line in result.stdout.splitlines() if not line.startswith("written:")][-1]
    summary = read_summary(tmp_path / "out")
    assert f"amplified {summary.amplification:.2g} times" in last
    assert f"about {summary.elastic_period:.2g} s along x" in last
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Left out by rigid joints: masonry of E = 1.5 GPa" in page


def test_a_run_on_masonry_says_what_it_takes(tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text(WALL + ELASTIC + SHAKEN + RUN)
    result = masonry_cd("run", scene, "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert "masonry: squared stone, density 2243 kg/m3, E 2.85 GPa (2.4 GPa to 3.3 GPa by the table)" in result.stdout
    summary = read_summary(tmp_path / "out")
    assert pytest.approx(2.85e9) == summary.masonry["taken"]["E"]
    assert not summary.has("elastic_period")
    assert summary.energy.balance_error < 1e-9
