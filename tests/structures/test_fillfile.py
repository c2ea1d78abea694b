# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of bridges hold their fill: what is read back is what was built."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from bridge_scenes import SPAN, bridge, grid
from command_line import masonry_cd

import structures
from loads import fill as fill_loads
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Assembly
from structures import MadeStructure
from structures.files import blockfile, fillfile, meshfile

KEYS: dict[str, Any] = {"width": 3.0, "walls": {"thickness": 0.5}, "abutments": [{"rigid": False}], "skew": 20.0}


def back(folder: Path, **keys: Any) -> MadeStructure:
    return structures.make({"kind": "file", **keys}, 2000.0, folder)


def forces(made: MadeStructure) -> list[tuple]:
    """Return the action of the fill in a run: the block and the size of each force and bar."""
    assembly = Assembly.from_blocks(made.blocks, 0.6)
    (fill,) = made.fills
    own = grid(made, assembly)
    return [(bar.blocks, bar.arms.tobytes(), bar.tension, bar.stiffness, bar.limit) for bar in fill_loads.part(fill, own, False).forces]


def test_a_block_file_gives_back_the_fill_to_the_bit(tmp_path: Path) -> None:
    made, assembly = bridge(SPAN, **KEYS)
    blockfile.write(tmp_path / "blocks.json", made.blocks, made.fills)
    again = back(tmp_path, path="blocks.json")
    assert Assembly.from_blocks(again.blocks, 0.6).mass.tobytes() == assembly.mass.tobytes()
    assert Assembly.from_blocks(again.blocks, 0.6).inertia.tobytes() == assembly.inertia.tobytes()
    assert forces(again) == forces(made)
    blockfile.write(tmp_path / "again.json", again.blocks, again.fills)
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "blocks.json").read_bytes()


@pytest.mark.parametrize("suffix", ["obj", "vtu", "step"])
def test_other_formats_have_their_fill_in_a_file_next_to_them(tmp_path: Path, suffix: str) -> None:
    made, assembly = bridge(SPAN, **KEYS)
    meshfile.write(tmp_path / f"blocks.{suffix}", made.blocks)
    fillfile.write(tmp_path / "fill.json", made.blocks, made.fills)
    supports = {"fixed": [block.name for block in made.blocks if block.fixed]} if suffix == "step" else {}  # the others mark them
    again = back(tmp_path, path=f"blocks.{suffix}", fill="fill.json", **supports)
    masses = dict(zip(assembly.names, assembly.mass, strict=True))
    now = Assembly.from_blocks(again.blocks, 0.6)
    assert dict(zip(now.names, now.mass, strict=True)) == pytest.approx(masses, rel=1e-9)
    assert sorted(face.block for face in again.fills[0].faces) == sorted(face.block for face in made.fills[0].faces)


def test_several_bridges_in_their_places_come_back(tmp_path: Path) -> None:
    from structures import site

    own = {"kind": "bridge", "spans": [SPAN], "width": 2.0}
    two = site.build([{**own, "name": "a"}, {**own, "name": "b", "at": [0.0, 50.0, 1.0], "rotate": 30.0}], 2000.0, Path())
    blockfile.write(tmp_path / "blocks.json", two.blocks, two.fills)
    again = back(tmp_path, path="blocks.json")
    for one, other in zip(two.fills, again.fills, strict=True):
        assert one.along(one.faces[0].corners).tobytes() == other.along(other.faces[0].corners).tobytes()


def test_build_writes_both_and_the_solids_of_cad_files_are_those_of_the_blocks_alone(tmp_path: Path) -> None:
    scene = tmp_path / "bridge.toml"
    scene.write_text(
        '[structure]\nkind = "bridge"\nspans = [{span=6.0,rise=1.5,thickness=0.5,voussoirs=7}]\n'
        "[material]\ndensity = 2000.0\nfriction = 0.6\n[run]\ndt = 1e-3\nduration = 1.0\n"
    )
    asked = ["build", str(scene), "-o", str(tmp_path / "out"), "--no-picture", "--format", "json", "--format", "obj", "--format", "brep"]
    answer = masonry_cd(*asked)
    assert answer.exit_code == 0, answer.output
    assert "blocks.brep cannot store names of blocks, which fill.json needs to restore the fill" in answer.output
    alone = json.loads((tmp_path / "out" / "fill.json").read_text())
    whole = json.loads((tmp_path / "out" / "blocks.json").read_text())
    assert alone == {key: whole[key] for key in ("fills", "carried")}


def _cut(content: dict) -> None:
    content["blocks"] = [block for block in content["blocks"] if block["name"] != "arch1.v3"]


def _set(*path: Any, value: Any) -> Callable[[dict], None]:
    def change(content: dict) -> None:
        for key in path[:-1]:
            content = content[key]
        content[path[-1]] = value

    return change


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (_cut, r'^blocks\.json: fills\[0\]\.faces: no block "arch1\.v3" in blocks\.json$'),
        (_set("fills", value={}), r'^blocks\.json: "fills" must be a list of fills$'),
        (_set("fills", 0, "passive", value=1.5), r"^blocks\.json: fills\[0\]\.passive: input should be less than or equal to 1"),
        (_set("fills", 0, "deck", value=[2.0, 1.0]), r"^blocks\.json: fills\[0\]\.deck: must be two places, the lower first, got 2 and 1$"),
        (_set("fills", 0, "gone_at", value=1e-3), r"^blocks\.json: fills\[0\]\.gone_at: must exceed active_at, 0\.002, got 0\.001$"),
        (_set("fills", 0, "level", value=0.5), r"^blocks\.json: fills\[0\]\.faces\[\d+\]: reaches up to z = [\d.]+ m, above the fill"),
        (_set("carried", "arch1.v3", "mass", value=-1.0), r'^blocks\.json: carried, block "arch1\.v3"\.mass: '),
        (_set("carried", "other", value={}), r'^blocks\.json: carried: no block "other" in blocks\.json$'),
        (_set("carried", "arch1.v3", "inertia", value=[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]), "moments of 0 or more$"),
        (_set("units", value="cm"), r"^blocks\.json: fills and carried are in metres; give the blocks in metres as well$"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named_in_one_line(tmp_path: Path, change: Callable[[dict], None], said: str) -> None:
    made, _ = bridge(SPAN, width=2.0)
    blockfile.write(tmp_path / "blocks.json", made.blocks, made.fills)
    content = json.loads((tmp_path / "blocks.json").read_text())
    change(content)
    (tmp_path / "blocks.json").write_text(json.dumps(content))
    with pytest.raises(InputError, match=said):
        back(tmp_path, path="blocks.json")


def test_a_file_of_fill_belongs_to_other_formats_and_must_be_there(tmp_path: Path) -> None:
    made, _ = bridge(SPAN, width=2.0)
    blockfile.write(tmp_path / "blocks.json", made.blocks, made.fills)
    meshfile.write(tmp_path / "blocks.obj", made.blocks)
    with pytest.raises(InputError, match=r"^structure\.fill: belongs to blocks in other formats; blocks\.json holds its own$"):
        back(tmp_path, path="blocks.json", fill="fill.json")
    with pytest.raises(InputError, match=r'^structure\.fill: no file "fill\.json" in '):
        back(tmp_path, path="blocks.obj", fill="fill.json")
