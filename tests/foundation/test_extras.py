# SPDX-License-Identifier: GPL-3.0-or-later
"""What a plain install lacks is named with the extra that brings it, before anything takes its time."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

import pytest
from places import EXAMPLES, ROOT
from typer.testing import CliRunner

from masonry_cd.cli.app import app
from masonry_cd.foundation import extras
from masonry_cd.foundation.errors import InputError

PACKAGES = {"vtkmodules": "vtk", "PIL": "pillow", "skfem": "scikit-fem", "dask_jobqueue": "dask-jobqueue"}


def absent(monkeypatch: pytest.MonkeyPatch, *modules: str) -> None:
    """Take modules away, with what they have loaded of themselves."""
    for module in modules:
        for name in [name for name in sys.modules if name.partition(".")[0] == module]:
            monkeypatch.delitem(sys.modules, name)
        monkeypatch.setitem(sys.modules, module, None)


def test_the_table_is_that_of_the_package() -> None:
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    needed = {line.partition(">=")[0] for line in declared["dependencies"]}
    for module, extra in extras.EXTRA_OF.items():
        package = PACKAGES.get(module, module)
        assert package in {line.partition(">=")[0] for line in declared["optional-dependencies"][extra]}, module
        assert package not in needed, module


@pytest.mark.parametrize(
    ("module", "arguments", "said"),
    [
        ("pyvista", ["run", "trilithon.toml", "--set", "report.crack_map=true"], "report: a picture needs pyvista"),
        ("matplotlib", ["run", "trilithon.toml", "--set", 'report.extra=["energy"]'], "report: a picture needs matplotlib"),
        ("matplotlib", ["run", "trilithon.toml", "--set", "report.html=true"], "report.html: the page needs matplotlib"),
        ("pyvista", ["build", "trilithon.toml"], "structure.png needs pyvista"),
        ("pyarrow", ["study", "study_arch.toml"], "a study needs pyarrow"),
        ("skfem", ["modal", "trilithon.toml", "--young", "1e9"], "this needs scikit-fem"),
    ],
)
def test_a_command_names_the_extra_that_it_lacks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module, arguments, said) -> None:
    absent(monkeypatch, module)
    command, scene, *others = arguments
    ended = CliRunner().invoke(app, [command, str(EXAMPLES / scene), *others, "-o", str(tmp_path / "out")])
    assert (ended.exit_code, ended.stdout) == (2, "")
    assert f'{said}, which is not installed: pip install "masonry-cd[{extras.EXTRA_OF[module]}]"' in ended.stderr
    assert ended.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_run_without_pictures_needs_none_of_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    absent(monkeypatch, *extras.EXTRA_OF)
    short = ["--set", "run.duration=0.01", "--set", "report.crack_map=false", "--set", "report.damage=true"]
    ended = CliRunner().invoke(app, ["run", str(EXAMPLES / "trilithon.toml"), "-o", str(tmp_path / "out"), "-q", *short])
    assert (ended.exit_code, ended.stderr) == (0, "")
    assert (tmp_path / "out" / "damage.json").exists()


def test_a_module_that_no_extra_brings_is_a_fault() -> None:
    assert extras.missing(ModuleNotFoundError("no", name="masonry_cd.gone")) is None
    assert "masonry-cd[cad]" in str(extras.missing(ModuleNotFoundError("no", name="trimesh.util")))


def test_a_library_that_is_there_passes(monkeypatch: pytest.MonkeyPatch) -> None:
    extras.require("this", "matplotlib")
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(InputError, match=r'a plot needs matplotlib, which is not installed: pip install "masonry-cd\[pictures\]", or not'):
        extras.require("a plot", "matplotlib", without=", or not")
