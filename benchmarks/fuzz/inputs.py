# SPDX-License-Identifier: GPL-3.0-or-later
"""Good inputs of every kind, small and quick: what is changed, what lies next to it, and the command that reads it."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.fuzz import formats, plans, study_texts, texts

BYTES, LINES, TOKENS, TOML, JSON, NPZ, HDF5, SET = "bytes", "lines", "tokens", "toml", "json", "npz", "hdf5", "set"


@dataclass(frozen=True)
class Subject:
    """An input that is good before it is changed.

    Attributes:
        kind: for the table of results.
        command: words after ``masonry-cd``; OUT stands for a folder that is not there yet.
        target: the file that is changed; empty where ``--set`` texts are added to the command instead.
        files: names and contents of all files.
        changes: the ways in which the target may be changed, drawn evenly.
        weight: how often it is drawn.
        apart: read by another program, in a child process: slower.
        refused: also before it is changed, as a .geo that is not trusted is.
    """

    kind: str
    command: tuple[str, ...]
    target: str
    files: dict[str, bytes]
    changes: tuple[str, ...]
    weight: float = 1.0
    apart: bool = False
    refused: bool = False


RUN = ("run", "scene.toml", "-o", "OUT", "-q")
STUDY = ("study", "study.toml", "-o", "OUT", "--plan")
BUILD = ("build", "scene.toml", "-o", "OUT", "--no-picture")
MESHES = {  # written of one structure, and how often each is drawn
    "blocks.obj": 5.0, "blocks.stl": 0.6, "text.stl": 0.4, "blocks.vtu": 0.8, "blocks.vtm": 0.5, "blocks.vtp": 0.4, "blocks.vtkhdf": 0.4,
    "blocks.step": 0.4, "blocks.brep": 0.4,
}  # fmt: skip
CONVERTED = """
import pyvista, trimesh
blocks = trimesh.load("meshes/blocks.stl")
open("meshes/text.stl", "w").write(blocks.export(file_type="stl_ascii"))
pyvista.wrap(blocks).save("meshes/blocks.vtp")
"""
SCENE_CHANGES = (TOML, TOML, TOML, TOKENS, LINES, BYTES)
TEXT_CHANGES = (TOKENS, TOKENS, LINES, BYTES)


def subjects(nursery: Path, kind: str = "") -> list[Subject]:
    """All of them; what has to be made by the program or by a library is made in a folder, where a kind that is requested needs it."""
    blocks = {"blocks.json": texts.blocks()}
    found = [*_scenes(blocks), *_structures(), *_studies(blocks), *_records(blocks), *_measured(blocks), _set_texts(blocks)]
    found.append(
        Subject("block file JSON", RUN, "blocks.json", {"scene.toml": texts.scene().encode(), **blocks}, (JSON, JSON, TOKENS, BYTES), 8)
    )
    found += [*_plans(), *_formats(nursery)]
    makers = {"block file": (_meshes,), "solid": (_solids,), "friction problem": (_problems,), "summary": (_problems, _former_runs)}
    asked = [begin for begin in makers if kind.startswith(begin)] or ([] if kind.startswith("record") else [*makers])
    for make in dict.fromkeys(one for begin in asked for one in makers[begin]):
        found += make(nursery)
    return found


def _scenes(blocks: dict[str, bytes]) -> Iterator[Subject]:
    for name, text in texts.SCENES.items():
        files = {"scene.toml": text.encode(), **blocks, "quake.csv": texts.RECORDS["csv"].encode()}
        yield Subject(f"scene, {name}", RUN, "scene.toml", files, SCENE_CHANGES, 4)


def _structures() -> Iterator[Subject]:
    for name, text in texts.STRUCTURES.items():
        yield Subject(f"scene, {name}", BUILD, "scene.toml", {"scene.toml": text.encode()}, SCENE_CHANGES, 2)


def _plans() -> Iterator[Subject]:
    """Plans of buildings."""
    for kind, name, files in plans.plans():
        changes = (JSON, JSON, TOKENS, BYTES) if name.endswith("json") else TEXT_CHANGES
        yield Subject(kind, BUILD, name, files, changes, 4, apart=not name.endswith("json"))


def _studies(blocks: dict[str, bytes]) -> Iterator[Subject]:
    """Study files, checked and planned."""
    files = {"scene.toml": texts.scene(loads=texts.SINE).encode(), **blocks, **study_texts.motions()}
    for name, text in study_texts.STUDIES.items():
        yield Subject(f"study, {name}", STUDY, "study.toml", {"study.toml": text.encode(), **files}, SCENE_CHANGES, 3)


def _set_texts(blocks: dict[str, bytes]) -> Subject:
    files = {"scene.toml": texts.SCENES["sine"].encode(), **blocks, "quake.csv": texts.RECORDS["csv"].encode()}
    return Subject("--set", RUN, "", files, (SET,), 6)


def _records(blocks: dict[str, bytes]) -> Iterator[Subject]:
    for name, text in texts.RECORDS.items():
        quake = f"quake.{name}"
        keys = texts.KEYS_OF_RECORDS.get(name, "")
        scene = texts.scene(loads=f'[[loads]]\nkind = "record"\ndirection = "x"\npath = "{quake}"\n{keys}')
        yield Subject(f"record {name}", RUN, quake, {quake: text.encode(), "scene.toml": scene.encode(), **blocks}, TEXT_CHANGES, 4)
        words = [word for key in keys.split("\n") if key for word in ("--set", key)]
        yield Subject(f"record {name}", ("record", quake, "-o", "OUT.png", *words), quake, {quake: text.encode()}, TEXT_CHANGES, 0.5)


def _formats(nursery: Path) -> Iterator[Subject]:
    """Records and blocks in the formats of networks and of other programs."""
    for kind, command, name, content in formats.records():
        yield Subject(kind, command, name, {name: content}, TEXT_CHANGES if b"\0" not in content else (BYTES,), 2)
    for kind, name, files in formats.blocks(nursery):
        binary = name.endswith(("glb", "3mf")) or name == "binary.ply"
        yield Subject(kind, BUILD, name, files, (BYTES,) if binary else TEXT_CHANGES, 0.8, apart=True)


def _measured(blocks: dict[str, bytes]) -> Iterator[Subject]:
    """A file of measured modes, read before the modes are computed."""
    command = ("modal", "scene.toml", "-o", "OUT", "--method", "joints", "--young", "3e9", "--modes", "2", "--pictures", "0")
    files = {"scene.toml": texts.scene().encode(), **blocks, "measured.csv": texts.MEASURED.encode()}
    yield Subject("measured modes", (*command, "--reference", "measured.csv"), "measured.csv", files, TEXT_CHANGES, 3)


def _meshes(nursery: Path) -> Iterator[Subject]:
    """The blocks of the scene in the formats of meshes, as the program writes them."""
    (nursery / "scene.toml").write_text(texts.scene())
    (nursery / "blocks.json").write_bytes(texts.blocks())
    written = ("obj", "stl", "vtu", "vtm", "vtkhdf", "step", "brep")
    formats = [word for name in written for word in ("--format", name)]
    _made(nursery, "-m", "masonry_cd", "build", "scene.toml", "-o", "meshes", "--no-picture", *formats)
    _made(nursery, "-c", CONVERTED)
    for name, weight in MESHES.items():
        fixed = '["plate*"]' if name.endswith(("obj", "vtu", "vtm", "vtkhdf")) else "{ below = 0.05 }"
        scene = texts.scene(structure=f'kind = "file"\npath = "{name}"\nunits = "m"\nup = "z"\nfixed = {fixed}\nrepair = true')
        files = {"scene.toml": scene.encode(), **_below(nursery / "meshes", Path(name).stem if name.endswith("vtm") else name)}
        changes = TEXT_CHANGES if name.endswith((".obj", ".vtm", ".step", ".brep")) else (BYTES, BYTES, TOKENS, LINES)
        yield Subject(f"block file {name.split('.')[1].upper()}", BUILD, name, files, changes, weight, apart=True)
        for part in sorted(path for path in files if "/" in path)[:1]:
            yield Subject("block file VTM, a part", BUILD, part, files, (BYTES, TOKENS, LINES), 0.3, apart=True)


def _below(folder: Path, stem: str) -> dict[str, bytes]:
    """The files of a folder, and of folders in it, whose names begin with a stem."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob(f"{stem}*")) if path.is_file()} | {
        str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.glob(f"{stem}/*")) if path.is_file()
    }


def _solids(nursery: Path) -> Iterator[Subject]:
    """A box as STEP and BREP, and a .geo that is not trusted."""
    code = """
import gmsh
gmsh.initialize(); gmsh.option.setNumber("General.Terminal", 0)
gmsh.model.occ.addBox(0, 0, 0, 1, 0.4, 0.5); gmsh.model.occ.synchronize()
for name in ("wall.step", "wall.brep"): gmsh.write(name)
"""
    _made(nursery, "-c", code)
    (nursery / "wall.geo").write_text('SetFactory("OpenCASCADE");\nBox(1) = {0, 0, 0, 1, 0.4, 0.5};\n')
    for name in ("wall.step", "wall.brep", "wall.geo"):
        units = "" if name.endswith("step") else 'units = "m"\n'
        keys = f'kind = "solid"\npath = "{name}"\n{units}course_height = 0.25\nunit_length = 0.5\nchord = 0.05\ntime_limit = 10.0'
        files = {"scene.toml": texts.scene(structure=keys).encode(), name: (nursery / name).read_bytes()}
        yield Subject(f"solid {name[5:].upper()}", BUILD, name, files, TEXT_CHANGES, 0.4, apart=True, refused=name.endswith("geo"))


def _problems(nursery: Path) -> Iterator[Subject]:
    """Friction problems of a step, over bodies and in the impulses alone, in both formats; and one of elastic joints."""
    from masonry_cd.io.problem_files import read_problem, write_problem
    from masonry_cd.mechanics.friction.problem import FrictionProblem

    _made(nursery, "-m", "masonry_cd", "run", "scene.toml", "-o", "dumped", "-q", "--dump-problem", "2")
    problem = read_problem(nursery / "dumped" / "problem_2.npz")
    assert isinstance(problem, FrictionProblem)
    for form, value in (("global", problem), ("local", problem.to_local())):
        for suffix, change in ((".npz", NPZ), (".hdf5", HDF5)):
            path = nursery / f"{form}{suffix}"
            write_problem(path, value)
            command = ("solve", path.name, "--max-iterations", "50")
            yield Subject(f"friction problem {suffix}", command, path.name, {path.name: path.read_bytes()}, (change, change, BYTES), 3)
    bench = nursery / "bench.npz"
    np.savez(bench, G=np.diag([2.0, 2.0, 1.0]), g=np.array([[-1.0], [0.0], [-2.0]]), mus=np.array([0.25]))
    yield Subject(
        "friction problem of ContactBench", ("solve", bench.name), bench.name, {bench.name: bench.read_bytes()}, (NPZ, NPZ, BYTES)
    )


def _former_runs(nursery: Path) -> Iterator[Subject]:
    """The summary of a run, which reports and comparisons read next to its results."""
    files = {
        f"{run}/{name}": (nursery / "dumped" / name).read_bytes() for run in ("dumped", "other") for name in ("result.h5", "summary.json")
    }
    for command in (("compare", "dumped", "other"), ("report", "dumped", "--no-crack-map")):
        yield Subject("summary of a run", command, "dumped/summary.json", files, (JSON, JSON, TOKENS, BYTES), 1.5)


def _made(folder: Path, *words: str) -> None:
    """Run Python in a folder; what fails there is an error of this program."""
    subprocess.run([sys.executable, *words], cwd=folder, check=True, capture_output=True)
