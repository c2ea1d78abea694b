"""masonry_cd.app.limit_case: the limit analysis of a scene, what it writes, and what it refuses."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest
from ferris_tin_loi import ASSOCIATED, dry_wall
from models import box, ground
from pictures import pixels
from typer.testing import CliRunner

from masonry_cd.app.limit_case import OUTPUTS, limit_case, lines, summary
from masonry_cd.cli.app import app
from masonry_cd.errors import InputError
from masonry_cd.model.blocks import Block
from structures.files import blockfile
from structures.geometry.prism import prism_xz

PUSH = '[[loads]]\nkind = "push"\ndirection = "x"\nrate = 0.1\n'
TILT = '[[loads]]\nkind = "tilt"\ndirection = "x"\nrate = 0.1\n'


def scene(folder: Path, blocks: list[Block], tables: str, mu: float = 0.65, joints: str = "") -> Path:
    """A scene file about blocks."""
    blockfile.write(folder / "blocks.json", blocks)
    path = folder / "scene.toml"
    path.write_text(
        f'structure = {{kind = "file", path = "blocks.json"}}\nmaterial = {{density = 2000.0, friction = {mu}{joints}}}\n'
        f"run = {{dt = 1e-3, duration = 1.0}}\n{tables}"
    )
    return path


def pillar() -> list[Block]:
    return [ground(2.0), box("a", (0.0, -0.2, 0.0), (0.5, 0.2, 1.5))]


def test_the_command_writes_what_it_finds(tmp_path):
    path, folder = scene(tmp_path, dry_wall(3), "[limit]\npush = 'x'\nstarts = 1\n"), tmp_path / "out"
    done = CliRunner().invoke(app, ["limit", str(path), "-o", str(folder)])
    assert done.exit_code == 0, done.output
    assert "load factor 0.40369" in done.output
    assert "Coulomb's law allows 0.35" in done.output
    made = json.loads((folder / "limit.json").read_text())
    assert made["associated"] == pytest.approx(ASSOCIATED[3], abs=1e-5)
    assert made["least"]["factor"] == pytest.approx(0.356, rel=1e-2)
    assert made["certificate"]["gap"] < 1e-9
    with (folder / "blocks.csv").open() as file:
        blocks = list(csv.DictReader(file))
    assert len(blocks) == made["blocks"]
    assert [row["block"] for row in blocks if row["moves"] == "True"] == made["mechanism"]["moving_blocks"]
    with (folder / "joints.csv").open() as file:
        joints = list(csv.DictReader(file))
    assert len(joints) == made["joints"]
    assert sum(row["state"] == "hinge" for row in joints) == made["mechanism"]["joints_hinge"]
    weight = sum(float(row["normal_force_n"]) for row in joints if row["block_a"] == "ground" or row["block_b"] == "ground")
    assert weight == pytest.approx(9.81 * 2000.0 * 0.2 * 0.4 * 0.175 * 38.5, rel=0.2)
    assert all((folder / name).exists() for name in OUTPUTS)
    drawn = pixels(folder / "mechanism.png")
    assert (drawn == [0xD5, 0x5E, 0x00]).all(axis=2).sum() > 100  # hinges are marked
    again = CliRunner().invoke(app, ["limit", str(path), "-o", str(folder)])
    assert again.exit_code == 2
    assert "--force" in again.output


@pytest.mark.parametrize("loads", [PUSH, TILT])
def test_a_scene_with_a_push_or_a_tilt_needs_no_table(loads, tmp_path):
    found = limit_case(scene(tmp_path, pillar(), loads))
    assert found.analysis.associated.factor == pytest.approx(1.0 / 3.0, abs=1e-9)
    angle = summary(found).get("angle_degrees")
    assert (angle is None) == (loads is PUSH)
    assert angle is None or angle == pytest.approx(math.degrees(math.atan(1.0 / 3.0)))


def test_a_tilt_turns_gravity_but_no_other_load(tmp_path):
    """A weight of W on top turns with the block, a point load of W down the frame does not: m g (c b - s h) + W b/2... = 0."""
    weight = 2000.0 * 9.81 * 0.5 * 0.4 * 1.5
    load = f'[[loads]]\nkind = "point"\nblock = "a"\nforce = [0, 0, {-weight}]\npoint = [0.25, 0, 1.5]\n'
    found = limit_case(scene(tmp_path, pillar(), load + TILT, mu=2.0))
    phi = math.atan(found.analysis.associated.factor)
    assert (math.cos(phi) + 1.0) * 0.25 == pytest.approx(math.sin(phi) * 0.75, abs=1e-8)


def test_where_nothing_slides_both_values_agree(tmp_path):
    assert any("both agree" in line for line in lines(limit_case(scene(tmp_path, pillar(), PUSH))))


def test_live_loads_are_multiplied_and_others_are_not(tmp_path):
    points = "".join(
        f'[[loads]]\nkind = "point"\nblock = "a"\nforce = [{f}, 0, 0]\npoint = [0.25, 0, {z}]\n' for f, z in ((100.0, 1.5), (1000.0, 0.75))
    )
    found = limit_case(scene(tmp_path, pillar(), points + "[limit]\nlive = [1]\n"))
    weight = 2000.0 * 9.81 * 0.5 * 0.4 * 1.5
    assert found.analysis.associated.factor == pytest.approx((weight * 0.25 - 100.0 * 1.5) / (1000.0 * 0.75), rel=1e-9)


def test_a_settlement_is_read_from_the_loads(tmp_path):
    blocks = [box("left", (0, -0.2, -0.5), (0.2, 0.2, 0), True), box("right", (1.8, -0.2, -0.5), (2, 0.2, 0), True)]
    blocks.append(box("beam", (0, -0.2, 0), (2, 0.2, 0.3)))
    load = '[[loads]]\nkind = "settlement"\nsupports = "right"\ndisplacement = 0.1\nduration = 1.0\n'
    found = limit_case(scene(tmp_path, blocks, load))
    assert summary(found)["support_force"] == pytest.approx(2000.0 * 9.81 * 2.0 * 0.4 * 0.3 * 0.8 / 1.8, rel=1e-9)
    assert any("still bear" in line for line in lines(found))


def test_what_shakes_is_left_out_and_said(tmp_path):
    shaken = '[[loads]]\nkind = "sinusoidal"\ndirection = "x"\namplitude = 0.1\nfrequency = 2.0\nduration = 1.0\n'
    found = limit_case(scene(tmp_path, pillar(), shaken + "[limit]\npush = 'x'\n"))
    assert any("loads[0] (sinusoidal): left out" in line for line in lines(found))


def test_blocks_that_touch_along_a_line_are_counted(tmp_path):
    wedge = Block("b", *prism_xz(np.array([[0.25, 1.5], [0.35, 1.8], [0.15, 1.8]]), -0.2, 0.2), 2000.0)  # on its edge
    found = limit_case(scene(tmp_path, [*pillar(), wedge], PUSH))
    assert not found.analysis.stands
    assert any("touch along a line" in line for line in lines(found))


def test_what_falls_by_itself_is_named(tmp_path):
    blocks = [*pillar(), box("b", (0.3, -0.2, 1.5), (1.9, 0.2, 2.0))]
    path = scene(tmp_path, blocks, PUSH)
    done = CliRunner().invoke(app, ["limit", str(path), "-o", str(tmp_path / "out"), "--no-picture"])
    assert done.exit_code == 0
    assert "does not stand under its dead loads" in done.output
    assert '"b"' in done.output
    assert json.loads((tmp_path / "out" / "limit.json").read_text())["stands"] is False


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ("", "no load to multiply"),
        (PUSH + TILT, "several patterns"),
        (PUSH + PUSH.replace('"x"', '"y"'), "several patterns"),
        ("[limit]\npush = 'x'\ntilt = 'y'\n", "one pattern"),
        ("[limit]\npush = ['x', 'y']\n", "vector of three numbers"),
        ("[limit]\npush = '-z'\n", "does no work on any mechanism"),
        ("[limit]\ntilt = 'z'\n", "must be level"),
        ("[limit]\nlive = [0]\n", "no load of kind point"),
        ("[limit]\npsuh = 'x'\n", 'did you mean "push"'),
        ("[limit]\npush = 'x'\nsides = 2\n", "at least 3"),
        ("gravity = 1\n[limit]\npush = 'x'\n", "unknown key"),
    ],
)
def test_bad_input_is_one_line(tables, message, tmp_path):
    path = scene(tmp_path, pillar(), tables)
    with pytest.raises(InputError, match=r"scene\.toml|limit") as refused:
        limit_case(path)
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_structure_without_supports_is_refused(tmp_path):
    with pytest.raises(InputError, match="no block is fixed"):
        limit_case(scene(tmp_path, [box("a", (0, 0, 0), (1, 1, 1))], PUSH))
