# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes in Python: the same checks and words as the command line, from files, dicts and keywords."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hostile import refused_at
from places import EXAMPLES, ROOT

import masonry_cd as mc
from masonry_cd.app.scene import read_scene

ARCH = EXAMPLES / "arch.toml"


def python(folder: Path, code: str) -> subprocess.CompletedProcess[str]:
    """Run Python in a folder."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run([sys.executable, "-c", code], cwd=folder, env=environment, capture_output=True, text=True, check=False)


def test_importing_it_imports_nothing_else(tmp_path: Path) -> None:
    heavy = "('numba', 'numpy', 'pydantic', 'pandas', 'matplotlib', 'pyvista', 'h5py', 'masonry_cd.interface', 'reports')"
    code = f"import sys, masonry_cd as mc; dir(mc); mc.__version__; print([name for name in {heavy} if name in sys.modules])"
    assert python(tmp_path, code).stdout == "[]\n"


def test_every_name_is_there_and_no_other() -> None:
    assert all(getattr(mc, name) is not None for name in mc.__all__)
    assert set(mc.__all__) <= set(dir(mc))
    with pytest.raises(AttributeError, match="no attribute 'scenario'"):
        _ = mc.scenario  # type: ignore[attr-defined]


def test_type_checkers_read_the_same_names() -> None:
    stub = ast.parse((ROOT / "masonry_cd" / "__init__.pyi").read_text(encoding="utf-8"))
    named = {item.asname: f"{node.module}:{item.name}" for node in stub.body if isinstance(node, ast.ImportFrom) for item in node.names}
    assert named == mc.NAMES


def test_a_file_and_its_changes_are_those_of_the_command_line() -> None:
    made = mc.scene(ARCH, "run.dt=5e-4", material={"friction": 0.7}, structure={"thickness": np.float64(0.5)})
    asked = read_scene(ARCH, ["run.dt=5e-4", "structure.thickness=0.5", "material.friction=0.7"])
    assert made.tables == mc.scene(ARCH).changed("run.dt=5e-4").changed(structure={"thickness": 0.5}, material={"friction": 0.7}).tables
    assert made.checked.run == asked.run
    assert made.checked.structure == asked.structure
    assert mc.scene(ARCH, "run.dt=5e-4").text == read_scene(ARCH, ["run.dt=5e-4"]).text
    assert mc.scene(ARCH).text == str(mc.scene(ARCH)) == ARCH.read_text()


def test_dict_and_keywords_are_one(tables: dict[str, Any]) -> None:
    first, second = mc.scene(tables), mc.scene(**tables)
    assert first.text == second.text
    third = mc.scene({key: tables[key] for key in ("structure", "material", "run")}, loads=tables["loads"], title=tables["title"])
    assert third.tables == first.tables
    assert "report" not in first.tables


def test_a_table_with_a_kind_takes_the_place_of_the_other() -> None:
    wall = {"kind": "wall", "length": 2.0, "height": 1.0, "thickness": 0.4, "course_height": 0.25}
    assert mc.scene(ARCH, structure=wall).tables["structure"] == wall
    assert mc.scene(ARCH, structure={"thickness": 0.3}).tables["structure"]["voussoirs"] == 27


def test_a_scene_does_not_change() -> None:
    arch = mc.scene(ARCH)
    arch.tables["run"]["dt"] = 1.0
    finer = arch.changed("run.dt=1e-4")
    assert (arch.tables["run"]["dt"], finer.tables["run"]["dt"]) != (1.0, 1.0)
    assert arch.text == ARCH.read_text()
    assert finer.changed("run.duration=1").tables["run"] == finer.tables["run"] | {"duration": 1}


def test_nothing_and_numpy_become_what_toml_knows(tables: dict[str, Any]) -> None:
    made = mc.scene(tables, run={"seed": np.int64(3), "dt": np.float32(0.5) / 256, "tolerance": None}, report={"times": np.array([0.1])})
    assert made.tables["run"]["seed"] == 3
    assert "tolerance" not in made.tables["run"]
    assert made.tables["report"]["times"] == [0.1]


@pytest.mark.parametrize(
    ("make", "place"),
    [
        (lambda: mc.scene("none.toml"), "none.toml"),
        (lambda: mc.scene(ARCH, run={"dt": "fast"}), '--set run.dt="fast": run.dt'),
        (lambda: mc.scene(ARCH, runs={"dt": 1}), "--set runs={ dt = 1 }: runs"),
        (lambda: mc.scene({}), "scene: material"),
        (lambda: mc.scene(7), "scene"),
        (lambda: mc.scene(ARCH, run={"dt": object()}), "run.dt"),
    ],
)
def test_errors_name_what_the_user_gave(make: Any, place: str) -> None:
    with pytest.raises(mc.InputError) as caught:
        make()
    assert str(caught.value).startswith(f"{place}: ")


def test_errors_of_the_structure_name_the_scene(tables: dict[str, Any]) -> None:
    made = mc.scene(tables | {"structure": {"kind": "arch", "spann": 4.0}})
    with refused_at("structure.spann"):
        _ = made.structure
    of_file = mc.scene(ARCH, "structure.voussoirs=1")
    with refused_at("structure.voussoirs"):
        _ = of_file.structure


def test_the_structure_knows_its_blocks(tables: dict[str, Any]) -> None:
    made = mc.scene(tables).structure
    assert (len(made), made.names, repr(made)) == (3, ["b0", "b1", "b2"], "<Structure: 3 blocks, 1 of them fixed>")
    assert made["b2"] is made[2]
    assert (made["b2"].vertices.shape, made["b2"].density, made["b0"].group) == ((8, 3), 2000.0, "base")
    assert [block.name for block in made[1:]] == ["b1", "b2"]
    assert made.table.loc["b2", ["volume", "mass", "z"]].tolist() == pytest.approx([0.128, 256.0, 0.8])
    assert made.table.attrs["units"] == {"volume": "m3", "mass": "kg", "x": "m", "y": "m", "z": "m"}
    with pytest.raises(mc.InputError, match=r'no block is named "b9"'):
        _ = made["b9"]


def test_it_shows_itself(tables: dict[str, Any]) -> None:
    made = mc.scene(tables | {"title": "A < B"})
    assert repr(made) == '<Scene "A < B": file, sinusoidal, 0.1 s>'
    assert "A &lt; B" in made._repr_html_()
    assert "b2" in made.structure._repr_html_()
    picture = made.picture("isometric")
    assert picture.size[0] == 1800
    assert len(picture.getcolors(1 << 24)) > 20
    assert picture._repr_png_().startswith(b"\x89PNG")


def test_a_scene_is_written_as_the_command_line_reads_it(tables: dict[str, Any], tmp_path: Path) -> None:
    made = mc.scene(tables)
    path = made.write(tmp_path / "new" / "two.toml")
    again = mc.scene(path)
    assert again.text == made.text
    assert all(np.array_equal(a.vertices, b.vertices) for a, b in zip(made.structure, again.structure, strict=True))
    of_file = mc.scene(EXAMPLES / "trilithon.toml", "run.dt=1e-3")
    with pytest.raises(mc.InputError, match=r"names trilithon.json, which is relative to .*: write it there"):
        of_file.write(tmp_path / "trilithon.toml")
