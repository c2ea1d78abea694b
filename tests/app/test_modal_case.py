# SPDX-License-Identifier: GPL-3.0-or-later
"""The modal check of a scene: files, words, and the way round from computed shapes to a measured file."""

from __future__ import annotations

import csv
import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from command_line import done
from hostile import refused_at
from models import wall

import masonry_cd as mc
from masonry_cd.app.commands.modal import ModalOptions, modal
from masonry_cd.app.scene import read_scene
from masonry_cd.cli.modal import by_group
from masonry_cd.foundation.errors import parse_table

ARCH = """\
title = "Arch"
[structure]
kind = "arch"
span = 3.0
thickness = 0.4
width = 0.8
voussoirs = 9
[material]
density = 2200.0
friction = 0.6
[run]
dt = 1e-3
duration = 1.0
"""
NAMED = ARCH.replace("density = 2200.0", 'masonry = "squared stone"')


@pytest.fixture
def arch(tmp_path: Path) -> Path:
    scene = tmp_path / "arch.toml"
    scene.write_text(ARCH)
    return scene


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_a_scene_from_file_to_files_and_back(arch: Path, tmp_path: Path) -> None:
    """Shapes computed with one modulus, taken for measured: the fit from another start finds that modulus again."""
    first = modal(read_scene(arch), {"young": 3e9, "modes": 3, "method": "joints", "pictures": 0}, tmp_path / "first").value
    measured = tmp_path / "first" / "shapes_joints.csv"
    result = modal(read_scene(arch), {"reference": measured, "fit": True, "modes": 3, "pictures": 0}, tmp_path / "second")
    second = result.value
    joints, continuum = second["models"]["joints"], second["models"]["continuum"]
    assert joints["young_pa"] == pytest.approx(3e9, rel=1e-9)
    assert joints["young_fitted"] is True
    assert [p["mac"] for p in joints["measured"]] == pytest.approx([1.0] * 3)
    assert [p["error_percent"] for p in joints["measured"]] == pytest.approx([0.0] * 3, abs=1e-6)
    assert continuum["measured"][0]["error_percent"] == pytest.approx(0.0, abs=1e-9)
    assert continuum["measured"][0]["mac"] > 0.95
    assert not first["warnings"]
    assert [path.name for path in result.written] == ["modal.json", "modal.csv", "shapes_continuum.csv", "shapes_joints.csv"]
    assert json.loads((tmp_path / "second" / "modal.json").read_text())["models"]["joints"]["frequency_hz"] == joints["frequency_hz"]
    table = rows(tmp_path / "second" / "modal.csv")
    assert {row["model"] for row in table} == {"continuum", "joints"}
    assert float(table[0]["frequency_hz"]) * float(table[0]["period_s"]) == pytest.approx(1.0)
    assert float(table[0]["measured_hz"]) == pytest.approx(first["models"]["joints"]["frequency_hz"][0])


def test_mesh_convergence_is_tabled(tmp_path: Path) -> None:
    options = {"young": 2e9, "method": "continuum", "modes": 2, "convergence": [0.2, 0.8, 0.4], "mesh_size": 0.4, "pictures": 0}
    out = modal(wall(2, 6), options, tmp_path).value
    table = rows(tmp_path / "mesh_convergence.csv")
    assert [float(row["element_size_m"]) for row in table] == [0.8, 0.4, 0.2]
    unknowns = [int(row["unknowns"]) for row in table]
    assert unknowns == sorted(unknowns) and unknowns[0] < unknowns[2]
    assert float(table[2]["f1_above_finest_percent"]) == 0.0
    assert float(table[0]["f1_above_finest_percent"]) > float(table[1]["f1_above_finest_percent"]) > 0.0
    assert float(table[1]["f1_hz"]) == pytest.approx(out["models"]["continuum"]["frequency_hz"][0], rel=1e-12)


def test_pictures_show_every_mode_in_colour(tmp_path: Path) -> None:
    from matplotlib.image import imread

    written = modal(wall(3, 4), {"young": 2e9, "modes": 2, "pictures": 2}, tmp_path).written
    for method in ("continuum", "joints"):
        path = tmp_path / f"modes_{method}.png"
        assert path in written
        image = imread(path)[..., :3]
        assert image.shape[1] == 1200, "a row of two"
        spread = image.max(axis=2) - image.min(axis=2)
        for half in np.array_split(spread, 2, axis=1):  # a panel each
            assert (half > 0.3).mean() > 0.02
        yellow = (image[..., 0] > 0.7) & (image[..., 1] > 0.7) & (image[..., 2] < 0.45)
        assert yellow.sum() > 500  # the places that move most


def test_lines_and_warnings(tmp_path: Path) -> None:
    measured = tmp_path / "measured.csv"
    measured.write_text("mode,frequency_hz,x_m,y_m,z_m,ux,uy,uz\n1,5.0,0.3,0,0.3,0,0,1\n1,,0.9,0,0.3,0,0,-1\n")
    out = modal(wall(3, 4), {"young": 2e9, "method": "joints", "modes": 1, "reference": measured})
    assert not out.written
    assert any("matches computed mode" in line for line in out.warnings)
    assert "Hz" in "\n".join(out.lines)
    loose = modal(wall(3, 4), {"young": 2e9, "method": "joints", "modes": 1, "restraint": {"base": "z"}})
    assert loose.warnings == ["joints: the supports leave 3 rigid motions free; they are not listed"]


def test_values_by_group() -> None:
    assert by_group(["3e9"], "young") == 3e9
    assert by_group(["pier=4 GPa", "default=2e9"], "young") == {"pier": "4 GPa", "default": 2e9}
    made = parse_table(ModalOptions, {"young": by_group(["pier=4 GPa", "default=2e9"], "young")}, "modal")
    assert made.young == {"pier": 4e9, "default": 2e9}
    with refused_at("modal.young"):
        by_group(["pier=4e9", "2e9"], "young")


def test_a_named_masonry_has_its_modulus_whichever_door_it_comes_through(tmp_path: Path) -> None:
    """The command, ``mc.modal`` of a file, and of keys."""
    path = tmp_path / "named.toml"
    path.write_text(NAMED)
    options = {"method": "joints", "modes": 2, "pictures": 0}
    done("modal", path, "-o", tmp_path / "out", "--method", "joints", "--modes", "2", "--pictures", "0")
    by_command = json.loads((tmp_path / "out" / "modal.json").read_text())["models"]["joints"]["frequency_hz"]
    for source in (path, tomllib.loads(NAMED)):
        assert mc.modal(source, **options)["models"]["joints"]["frequency_hz"] == by_command


def test_changes_of_the_scene_reach_the_model(arch: Path) -> None:
    """The first mode of an arch sways across its plane, where a wider one is stiffer."""
    asked = {"young": 1e9, "method": "joints", "modes": 1}
    narrow, wide = (modal(read_scene(arch, [f"structure.width={width}"]), asked).value for width in (0.4, 0.8))
    assert wide["models"]["joints"]["frequency_hz"][0] > 1.3 * narrow["models"]["joints"]["frequency_hz"][0]
