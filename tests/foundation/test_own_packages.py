# SPDX-License-Identifier: GPL-3.0-or-later
"""A user's own loads.py, structures.py or reports.py never takes the place of this program's packages unnoticed."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from places import EXAMPLES, ROOT

from masonry_cd.foundation.own_packages import PACKAGES, require_own_packages


def python(folder: Path, *arguments: str, path: tuple[Path, ...] = ()) -> subprocess.CompletedProcess[str]:
    """Run Python in a folder, with further folders before this tree on its path."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(map(str, (*path, ROOT)))}
    return subprocess.run([sys.executable, *arguments], cwd=folder, env=environment, capture_output=True, text=True, check=False)


def test_the_packages_are_found() -> None:
    require_own_packages()


@pytest.mark.parametrize("name", PACKAGES)
def test_a_file_beside_a_script_is_named_with_the_remedy(tmp_path: Path, name: str) -> None:
    (tmp_path / f"{name}.py").write_text("mine = 1\n")
    (tmp_path / "script.py").write_text("from masonry_cd.app.scene import read_scene\n")
    ended = python(tmp_path, "script.py")
    assert ended.returncode == 1
    said = ended.stderr.strip().splitlines()[-1]
    assert said.startswith(
        f'masonry_cd.foundation.errors.InputError: {tmp_path / name}.py hides the package "{name}" of masonry_cd: rename it, or run'
    )


def test_a_module_that_is_loaded_already_is_named_too(tmp_path: Path) -> None:
    (tmp_path / "loads.py").write_text("mine = 1\n")
    code = "import loads, sys; sys.path.remove(sys.path[0]); import masonry_cd.app.case"
    assert f'{tmp_path / "loads"}.py hides the package "loads"' in python(tmp_path, "-c", code).stderr


def test_the_command_says_so_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "reports.py").write_text("mine = 1\n")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    ended = python(elsewhere, "-m", "masonry_cd", "--version", path=(tmp_path,))
    assert (ended.returncode, ended.stdout, len(ended.stderr.splitlines())) == (2, "", 1)
    assert ended.stderr.startswith(f"masonry-cd: error: {tmp_path}/reports.py hides the package")


def test_the_working_folder_is_not_looked_into_by_the_module(tmp_path: Path) -> None:
    """python -m masonry_cd in a folder with files of these names works, as the installed command does."""
    for name in PACKAGES:
        (tmp_path / f"{name}.py").write_text("raise SystemExit('the wrong file')\n")
    ended = python(tmp_path, "-m", "masonry_cd", "build", str(EXAMPLES / "trilithon.toml"), "-o", "out", "--no-picture")
    assert (ended.returncode, ended.stderr) == (0, "")
    assert (tmp_path / "out" / "blocks.json").exists()
