# SPDX-License-Identifier: GPL-3.0-or-later
"""The distribution of `python -m build`: installed apart from the checkout it builds, runs and reports, and its own tests pass on it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest
from places import ROOT

from masonry_cd import __version__
from masonry_cd.foundation import kernel_store

PACKAGES = ("masonry_cd", "structures", "loads", "reports")
QUICK = ("loads/test_quantity.py", "loads/test_readers.py", "foundation/test_units.py")  # tests that need no kernels
SCENE = """
structure = {kind = "arch", span = 4.0, thickness = 0.6}
material = {density = 2000.0, friction = 0.6}
run = {dt = 2e-3, duration = 0.01}
"""

pytestmark = pytest.mark.slow(reason="builds the wheel and the source archive")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with `site`, the packages as the wheel installs them, and `source`, the source archive."""
    folder = tmp_path_factory.mktemp("distribution")
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", folder / "dist", ROOT]  # the wheel is made from the archive
    subprocess.run(command, check=True, capture_output=True, env=os.environ | {"MASONRY_CD_KERNELS": ""})
    (wheel,) = (folder / "dist").glob("*.whl")
    zipfile.ZipFile(wheel).extractall(folder / "site")
    (archive,) = (folder / "dist").glob("*.tar.gz")
    with tarfile.open(archive) as file:
        file.extractall(folder, filter="data")
    (folder / f"masonry_cd-{__version__}").rename(folder / "source")
    return folder


def from_wheel(made: Path, *arguments: str, cwd: Path) -> str:
    """Standard output of Python on the wheel's packages alone, with the kernels that this checkout has compiled."""
    store = os.environ.get("NUMBA_CACHE_DIR") or str(Path(kernel_store.__file__).parents[1] / "__pycache__")
    env = os.environ | {"PYTHONPATH": str(made / "site"), "NUMBA_CACHE_DIR": store}
    ended = subprocess.run([sys.executable, *arguments], cwd=cwd, env=env, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return ended.stdout


def test_the_wheel_holds_the_packages_and_their_data(made: Path):
    code = f"import sys, importlib; print(*[importlib.import_module(name).__file__ for name in {PACKAGES}], sep='\\n')"
    found = from_wheel(made, "-c", code, cwd=made).split()
    assert [Path(file).is_relative_to(made / "site") for file in found] == [True] * len(PACKAGES)
    files = [path for package in PACKAGES for path in (ROOT / package).rglob("*") if path.is_file() and "__pycache__" not in path.parts]
    lacking = [str(path) for path in files if not (made / "site" / path.relative_to(ROOT)).exists()]
    assert lacking == []


def test_the_wheel_runs_a_scene_and_draws_its_page(made: Path, tmp_path: Path):
    (tmp_path / "arch.toml").write_text(SCENE, encoding="utf-8")
    from_wheel(made, "-m", "masonry_cd", "run", "arch.toml", "-o", "out", cwd=tmp_path)
    from_wheel(made, "-m", "masonry_cd", "report", "out", "--html", cwd=tmp_path)
    assert (tmp_path / "out" / "summary.json").exists() and (tmp_path / "out" / "report.html").exists()


def test_quick_tests_of_the_source_archive_pass_on_the_wheel(made: Path, tmp_path: Path):
    for name in ("tests", "examples", "docs", "benchmarks"):
        shutil.copytree(made / "source" / name, tmp_path / name)
    shutil.copy(made / "source" / "pyproject.toml", tmp_path)
    out = from_wheel(made, "-m", "pytest", "-q", "-p", "no:cacheprovider", *(f"tests/{name}" for name in QUICK), cwd=tmp_path)
    assert " passed" in out and "failed" not in out
