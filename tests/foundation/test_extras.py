# SPDX-License-Identifier: GPL-3.0-or-later
"""A package that a plain install lacks is named with its extra; a user's own loads.py never takes the place of our packages."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
import tomllib
from operator import attrgetter, methodcaller
from pathlib import Path

import pytest
from command_line import masonry_cd
from places import EXAMPLES, ROOT

import masonry_cd as mc
from masonry_cd.foundation import extras
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.own_packages import PACKAGES

ENERGY = ["--set", "report.energy=true"]
PACKAGE_OF = {
    "vtkmodules": "vtk",
    "PIL": "pillow",
    "skfem": "scikit-fem",
    "sklearn": "scikit-learn",
    "dask_jobqueue": "dask-jobqueue",
    "pyoma2": "pyoma-2",
}


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
        package = PACKAGE_OF.get(module, module)
        assert package in {line.partition(">=")[0] for line in declared["optional-dependencies"][extra]}, module
        assert package not in needed, module


@pytest.mark.parametrize(
    ("module", "arguments", "said"),
    [
        ("pyvista", ["run", "trilithon.toml", "--set", "report.crack_map=true"], "report.crack_map needs pyvista"),
        ("matplotlib", ["run", "trilithon.toml", "--set", "report.crack_map=false", *ENERGY], "report.energy needs matplotlib"),
        ("matplotlib", ["run", "trilithon.toml", "--set", "report.html=true"], "report.html needs matplotlib"),
        ("pyvista", ["build", "trilithon.toml"], "structure.png needs pyvista"),
        ("meshio", ["build", "trilithon.toml", "--no-picture", "--format", "vtu"], "blocks as .vtu needs meshio"),
        ("matplotlib", ["accuracy", "trilithon.toml"], "the picture of accuracy needs matplotlib"),
        ("pyarrow", ["study", "study_arch.toml"], "a study needs pyarrow"),
        ("skfem", ["modal", "trilithon.toml", "--young", "1e9"], "the bonded continuum needs scikit-fem"),
    ],
)
def test_a_command_names_the_extra_that_it_lacks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module, arguments, said) -> None:
    absent(monkeypatch, module)
    command, scene, *others = arguments
    ended = masonry_cd(command, EXAMPLES / scene, *others, "-o", tmp_path / "out")
    assert (ended.exit_code, ended.stdout) == (2, "")
    assert f'{said}, which is not installed: pip install "masonry-cd[{extras.EXTRA_OF[module]}]"' in ended.stderr
    assert ended.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_run_without_pictures_needs_none_of_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    absent(monkeypatch, *extras.EXTRA_OF)
    short = ["--set", "run.duration=0.01", "--set", "report.crack_map=false", "--set", "report.damage=true"]
    ended = masonry_cd("run", EXAMPLES / "trilithon.toml", "-o", tmp_path / "out", "-q", *short)
    assert ended.exit_code == 0 and "which is not installed" not in ended.stderr
    assert (tmp_path / "out" / "damage.json").exists()


def test_a_first_scene_draws_nothing_where_nothing_can_be_drawn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    absent(monkeypatch, *extras.EXTRA_OF)
    scene = tmp_path / "arch.toml"
    assert masonry_cd("init", "arch", "-o", scene).exit_code == 0
    ended = masonry_cd("run", scene, "-o", tmp_path / "out", "-q", "--set", "run.duration=0.01")
    assert ended.exit_code == 0 and (tmp_path / "out" / "summary.json").exists()


def test_a_module_that_no_extra_brings_is_a_fault() -> None:
    assert extras.missing(ModuleNotFoundError("no", name="masonry_cd.gone")) is None
    assert "masonry-cd[cad]" in str(extras.missing(ModuleNotFoundError("no", name="trimesh.util")))


def test_every_import_of_an_optional_package_is_preceded_by_a_check() -> None:
    """Whoever imports one names it to ``require`` in the same function, or stands behind a door that has: those are listed."""
    behind = {  # what an import there stands behind
        "masonry_cd/studies/study": "a study requires its libraries before it begins",
        "masonry_cd/studies/accuracy_picture.py": "blank, of foundation/figures.py, which makes every figure",
        "masonry_cd/interface/frames.py": "to_xarray of a run, and record of a simulation",
        "structures/plans/dxf_file.py": "opened of structures/files/drawing.py",
        "structures/files/dxf_blocks.py": "opened of structures/files/drawing.py",
        "structures/files/drawing.py": "its opened",
        "structures/files/mesh_readers.py": "its read_vtm",
        "structures/files/meshfile.py": "its require_writer",
        "structures/files/vtkfile.py": "require_writer of meshfile.py",
        "reports": "blank, and Canvas of drawing/render.py",
    }
    bare = []
    for file in (file for package in ("masonry_cd", "reports", "loads", "structures") for file in sorted((ROOT / package).rglob("*.py"))):
        place = file.relative_to(ROOT).as_posix()
        for function in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if not isinstance(function, ast.FunctionDef):
                continue
            required = {
                word.value
                for call in ast.walk(function)
                if isinstance(call, ast.Call) and ast.unparse(call.func) == "require"
                for word in call.args
                if isinstance(word, ast.Constant)
            }
            for node in ast.walk(function):
                if not isinstance(node, ast.Import | ast.ImportFrom):
                    continue
                names = [node.module] if isinstance(node, ast.ImportFrom) else [one.name for one in node.names]
                modules = {str(name).partition(".")[0] for name in names}
                if modules & set(extras.EXTRA_OF) - required and not any(place.startswith(door) for door in behind):
                    bare.append((place, function.name, modules))
    assert [one for one in bare if one[0] != "masonry_cd/foundation/figures.py"] == []


@pytest.mark.parametrize(
    ("module", "call"),
    [
        *(("pandas", attrgetter(name)) for name in ("joints", "parts", "hinges", "levels", "history", "steps", "energy")),
        *(("pandas", methodcaller(name)) for name in ("blocks", "joint_history", "joint_forces", "reactions")),
        ("pandas", lambda run: run.motion("left")),
        ("pandas", lambda run: run.structure.table),
        ("PIL", lambda run: run.scene.picture()),
        ("matplotlib", lambda run: run.plot.energy()),
        ("matplotlib", lambda run: run.plot.page()),
        ("pyvista", lambda run: run.mesh()),
        ("vtkmodules", lambda run: run.plot.crack_map()),
        ("obspy", lambda run: run.to_traces("left")),
        ("skfem", lambda run: mc.modal(run.scene, young=1e9)),
        ("clarabel", lambda run: mc.macro_elements(run.scene)),
        ("PIL", lambda run: run.plot.crack_map()),
        ("pyvista", lambda run: run.plot.crack_map()),
        ("matplotlib", lambda run: run.plot.crack_map()),
        ("matplotlib", lambda run: run.plot.history("left")),
        ("xarray", lambda run: run.to_xarray()),
        ("trimesh", lambda run: run.to_trimesh()),
        ("PIL", lambda run: mc.scene(EXAMPLES / "trilithon.toml").structure.picture()),
        ("pandas", lambda run: mc.scene(EXAMPLES / "trilithon.toml").structure.table),
    ],
)
def test_python_names_the_extra_that_it_lacks(short_run, monkeypatch: pytest.MonkeyPatch, module, call) -> None:
    from reports.drawing.render import require_context

    absent(monkeypatch, module)
    require_context.cache_clear()
    with pytest.raises(InputError, match=rf"which is not installed: pip install \"masonry-cd\[{extras.EXTRA_OF[module]}\]"):
        call(short_run)


@pytest.fixture(scope="module")
def short_run(tmp_path_factory: pytest.TempPathFactory):
    folder = tmp_path_factory.mktemp("run")
    return mc.run(mc.scene(EXAMPLES / "trilithon.toml", "run.duration=0.01", "report.crack_map=false"), folder / "out", progress=False)


def python(folder: Path, *arguments: str, path: tuple[Path, ...] = ()) -> subprocess.CompletedProcess[str]:
    """Run Python in a folder, with further folders before this tree on its path."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(map(str, (*path, ROOT)))}
    return subprocess.run([sys.executable, *arguments], cwd=folder, env=environment, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("name", PACKAGES)
def test_a_file_next_to_a_script_is_named_with_the_remedy(tmp_path: Path, name: str) -> None:
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
