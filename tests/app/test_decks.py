# SPDX-License-Identifier: GPL-3.0-or-later
"""Decks for LMGC90 and 3DEC: read back they are the scene, to the digits of their numbers, and what they cannot say is refused."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import masonry_cd
from hostile import refused_at
from places import EXAMPLES

import masonry_cd as mc
from masonry_cd.app.case import prepare

STIFF = {"joints": {"normal_stiffness": 1e10, "tangential_stiffness": 4e9, "cohesion": 3e4, "tension": 2e4}}
ABOUT: dict[str, Any] = {"material": {"density": 1.0, "friction": 0.5}, "run": {"dt": 0.1, "duration": 1.0}}
SCENE = mc.scene(EXAMPLES / "trilithon.toml", "run.duration=0.4")
FORMATS = {"lmgc90": "DATBOX/BODIES.DAT", "3dec": "deck.3ddat"}


def written(scene: mc.Scene, form: str, folder: Path) -> Path:
    """The deck of a scene, whose joints have springs where it is for 3DEC; the file with its blocks."""
    made = scene.changed(material=STIFF) if form == "3dec" else scene
    made.to_deck(folder, form)
    return folder / FORMATS[form]


def column(text: str, first: int, last: int) -> str:
    """Letters of a line, counted from one, as a format of Fortran has them."""
    return text[first - 1 : last]


@pytest.mark.parametrize("form", FORMATS)
def test_a_deck_read_back_is_the_scene(tmp_path: Path, form: str) -> None:
    arch = mc.scene(EXAMPLES / "arch.toml", "run.duration=0.4")
    path = written(arch, form, tmp_path / "deck")
    again = mc.scene(structure={"kind": "file", "path": str(path), "units": "m", "up": "z"}, **ABOUT).structure
    assert len(again) == len(arch.structure)
    for ours, theirs in zip(arch.structure, again, strict=True):
        assert ours.fixed == theirs.fixed
        there = np.abs(ours.vertices[:, None] - theirs.vertices).max(axis=2).min(axis=1)
        assert len(ours.vertices) == len(theirs.vertices) and there.max() < 1e-9
        assert theirs.mass_properties.volume == pytest.approx(ours.mass_properties.volume, rel=1e-8)
        if form == "lmgc90":  # 3DEC has densities by group, which its reader leaves to the scene
            assert theirs.density == ours.density and theirs.group == (ours.group + "xxxxx")[:5]
        else:
            assert theirs.group == ours.group


def test_older_decks_of_lmgc90_have_another_word_for_faces(tmp_path: Path) -> None:
    path = written(SCENE, "lmgc90", tmp_path / "deck")
    path.write_text(path.read_text().replace("   nb_faces=", "    nb_face="))
    again = mc.scene(structure={"kind": "file", "path": str(path), "units": "m", "up": "z"}, **ABOUT).structure
    assert len(again) == len(SCENE.structure)


def test_numbers_of_lmgc90_stand_in_their_columns(tmp_path: Path) -> None:
    folder = written(SCENE, "lmgc90", tmp_path / "deck").parent
    lines = (folder / "BODIES.DAT").read_text().splitlines()
    corner = lines[next(i for i, line in enumerate(lines) if "POLYR" in line) + 1]
    stones = SCENE.structure
    assert [float(column(corner, a, a + 13)) for a in (35, 56, 77)] == pytest.approx(stones[0].vertices[0].tolist(), abs=1e-11)
    contactor = next(line for line in lines if "POLYR" in line)
    assert (int(column(contactor, 40, 47)), int(column(contactor, 60, 67))) == (8, 12)
    triangle = next(line for line in lines if "ver1" in line)
    assert len({int(column(triangle, a, a + 12)) for a in (35, 56, 77)}) == 3
    gravity = next(line for line in (folder / "BULK_BEHAV.DAT").read_text().splitlines() if "grv1" in line)
    assert [float(column(gravity, a, a + 13)) for a in (25, 46, 67)] == [0.0, 0.0, -9.81]
    laws = (folder / "TACT_BEHAV.DAT").read_text().splitlines()
    frictions = {column(line, 2, 6): float(column(line, 46, 59)) for line in laws if "IQS_CLB" in line}
    seen = {(column(line, 16, 20), column(line, 44, 48)): frictions[column(line, 23, 27)] for line in laws if line.startswith(" RBDY3")}
    assert seen["postx", "linte"] == 0.7 and seen["basex", "postx"] == 0.6 and len(seen) == 5
    assert all(0.0 < float(column(line, 55, 68)) < 0.1 for line in laws if line.startswith(" RBDY3"))


@pytest.mark.parametrize("form", FORMATS)
def test_the_base_of_a_deck_moves_as_that_of_the_scene(tmp_path: Path, form: str) -> None:
    """One of two supports settles next to the shaking of both, so that they are told apart."""
    base = [mc.box((x, -1, -0.5), (x + 1, 1, 0)) for x in (0.0, 1.5)]
    beam = mc.box((0.5, -0.5, 0), (2.0, 0.5, 0.4))
    sunk = {"kind": "settlement", "supports": "b1", "displacement": 0.01, "duration": 0.2}
    shaken = {"kind": "sinusoidal", "direction": "x", "amplitude": 0.2, "frequency": 5.0, "cycles": 2}
    scene = mc.scene(
        structure={"blocks": [*base, beam], "fixed": ["b0", "b1"]},
        material={"density": 2000.0, "friction": 0.5},
        loads=[shaken, sunk],
        run={"dt": 1e-3, "duration": 0.4},
    )
    path = written(scene, form, tmp_path / "deck")
    case = prepare(scene.checked)
    wanted = {b: case.loading.support_velocity[:401, case.assembly.support_of[b]] for b in (0, 1)}
    text = path.read_text() if form == "3dec" else (path.parent / "DRV_DOF.DAT").read_text()
    for b in (0, 1):
        for d, axis in ((0, "x"), (2, "z")):
            if form == "3dec":
                found = re.search(rf"apply velocity-{axis} 1 table '(\w+)' range group 'base\.{b}'", text)
                rows = found and re.search(rf"^table '{found[1]}' add \.\.\.\n((?:  .*\n)+)", text, re.MULTILINE)
                numbers = rows and re.findall(r"\(([^,]+),([^)]+)\)", rows[1])
            else:
                own = text.split("$bdyty")[b + 1]
                found = re.search(rf"^ vlocy  {d + 1:5d} evolution (\S+)$", own, re.MULTILINE)
                numbers = found and [line.split() for line in (path.parent / found[1]).read_text().splitlines()]
            values = np.array(numbers, dtype=float) if numbers else np.column_stack([1e-3 * np.arange(401), np.zeros(401)])
            assert np.allclose(values[:, 0], 1e-3 * np.arange(401)) and np.abs(values[:, 1] - wanted[b][:, d]).max() < 1e-9
    assert np.trapezoid(wanted[1][:, 2], dx=1e-3) == pytest.approx(-0.01, rel=1e-6)


def test_joints_of_3dec_are_those_of_the_scene(tmp_path: Path) -> None:
    text = written(SCENE, "3dec", tmp_path / "deck").read_text()
    (law,) = re.findall(r"^block contact property (.*) range group-intersection 'post' 'lintel'$", text, re.MULTILINE)
    found = dict(zip(law.split()[::2], map(float, law.split()[1::2]), strict=True))
    angle = math.degrees(math.atan(0.7))
    wanted = {"stiffness-normal": 1e10, "stiffness-shear": 4e9, "friction": angle, "cohesion": 3e4, "tension": 2e4}
    assert found == pytest.approx(wanted)
    for face in re.findall(r"face (.*?)(?: \.\.\.)?$", text, re.MULTILINE)[:6]:  # of the ground, clockwise seen from outside
        corners = np.array([word.strip("()").split(",") for word in face.split()], dtype=float)
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[1])
        assert normal @ (corners.mean(axis=0) - [0.0, 0.0, -0.25]) < 0.0


@pytest.mark.parametrize(
    ("form", "changes"),
    [
        ("lmgc", {}),
        ("vtkhdf", {}),
        ("3dec", {}),  # its joints have no springs
        ("lmgc90", {"material": STIFF}),
        ("lmgc90", {"loads": [{"kind": "point", "block": "lintel", "force": [0, 0, -1e4]}]}),
        ("lmgc90", {"loads": [{"kind": "gravity", "ramp": 0.1}]}),
        ("lmgc90", {"run": {"first_velocities": {"size": 1e-3}}}),
        ("lmgc90", {"events": [{"at": 0.1, "remove": "lintel"}]}),
        ("lmgc90", {"material": {"restitution": 0.3}}),
        ("lmgc90", {"loads": [{"kind": "motion", "supports": "base", "time": [0, 0.2], "rotation": [0, 1], "axis": "y"}]}),
        ("lmgc90", {"material": {"deformable": "uniform", "young": 1e9, "poisson": 0.2}}),
        ("3dec", {"material": {"joints": {"normal_stiffness": 1e10, "compressive_strength": 1e6}}}),
    ],
)
def test_what_a_deck_cannot_say_is_refused(tmp_path: Path, form: str, changes: dict[str, Any]) -> None:
    with refused_at("--format"):
        SCENE.changed(**changes).to_deck(tmp_path / "deck", form)
    assert not (tmp_path / "deck").exists()


def test_the_command_writes_a_deck_and_keeps_what_is_there(tmp_path: Path) -> None:
    words = ("export", EXAMPLES / "trilithon.toml", "--format", "lmgc90", "--set", "run.duration=0.1", "-o", tmp_path / "deck")
    assert masonry_cd(*words).exit_code == 0 and (tmp_path / "deck" / "command.py").is_file()
    assert masonry_cd(*words).exit_code == 2
    assert masonry_cd(*words, "--force").exit_code == 0
    assert masonry_cd("export", EXAMPLES / "trilithon.toml", "--format", "lmgc90").exit_code == 2
    compile((tmp_path / "deck" / "command.py").read_text(), "command.py", "exec")
