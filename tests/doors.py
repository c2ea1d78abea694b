# SPDX-License-Identifier: GPL-3.0-or-later
"""The doors by which input comes in, for the tables of tests/refusals: each writes the files, and returns what tries them."""

from __future__ import annotations

import copy
import json
import re
import shlex
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import limit_scenes
import made_run
import numpy as np
from block_files import write_plate_and_block, write_plate_scene
from bridge_scenes import bridge
from command_line import masonry_cd, refusal
from hostile import TETRA
from models import box, ground
from places import ROOT
from records import write_suite
from studied import changed as changed_lines
from studied import write_records, write_study
from two_blocks import shaking, two_blocks
from typer.testing import Result

import loads
import masonry_cd as mc
import structures
from loads.signal import measures
from masonry_cd.analysis.modal.measured_modes import read_measured
from masonry_cd.app.case import make_structures
from masonry_cd.app.commands.modal import modal
from masonry_cd.app.scene import read_scene
from masonry_cd.app.scene_text import assign, dump_toml
from masonry_cd.foundation.errors import parse_table
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.materials import Material
from masonry_cd.studies.study.study_case import plan_of
from structures import MadeStructure

RAN = '[structure]\nkind = "file"\n[material]\ndensity = 2000.0\nfriction = 0.6\n[run]\ndt = 0.1\nduration = 0.2\n'
Door = Callable[..., Callable[[], Any]]


@cache
def piers() -> Assembly:
    """Three feet with a pier on each."""
    blocks = [box(f"foot{i}", (x, 0, -1), (x + 1, 1, 0), fixed=True) for i, x in enumerate((0.0, 4.0, 10.0))]
    return Assembly.from_blocks(blocks + [box(f"pier{i}", (x, 0, 0), (x + 1, 1, 2)) for i, x in enumerate((0.0, 4.0, 10.0))], 0.9)


@cache
def bridge_of(walls: bool = False) -> tuple[MadeStructure, Assembly]:
    """A bridge, whose fill presses on its spandrel walls where it has such."""
    return bridge(width=3.0, **({"walls": {}} if walls else {}))


@cache
def result_of_two_blocks() -> bytes:
    """The result file of a run in which a stone stays on its base."""
    blocks = [made_run.box("base", (-1, -1, -1), (1, 1, 0), "base", fixed=True), made_run.box("stone", (-0.5, -0.5, 0), (0.5, 0.5, 1))]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "result.h5"
        return made_run.write_run(path, blocks, [made_run.at_rest(blocks)] * 3, scene=RAN, ended=True).read_bytes()


def changed(table: Mapping[str, Any], changes: Mapping[str, Any], dropped: Sequence[str] = ()) -> dict[str, Any]:
    """A table some of whose keys, ``shocks[1].name`` for example, are others or gone."""
    out = copy.deepcopy({key: value for key, value in table.items() if key not in dropped})
    for key, value in changes.items():
        assign(out, key, value)
    return out


def repeated(text: str) -> str:
    """A text in which «x*9» stands for nine times x."""
    return re.sub(r"«(.*?)\*(\d+)»", lambda found: found[1] * int(found[2]), text)


def write_quake(folder: Path) -> None:
    """quake.csv: a shock of 2 s."""
    rows = "".join(f"{0.01 * k:.2f},{np.sin(np.pi * k / 200) ** 2 * np.sin(0.7 * k):.6g}\n" for k in range(201))
    (folder / "quake.csv").write_text(f"time_s,a_m_s2\n{rows}")


def load(folder: Path, group: Mapping[str, Any], changes: Mapping[str, Any], dropped: Sequence[str] = ()) -> Callable[[], Any]:
    """Loads of 100 steps on three piers, or on a bridge: those of ``before`` and ``base``, changed, ``without`` a structure or gravity."""
    write_quake(folder)
    tables, without = [*group.get("before", ()), changed(group["base"], changes, dropped)], group.get("without")
    made, assembly = bridge_of("walls" in group) if "on_bridge" in group else (None, piers())
    gravity = (0.0, 0.0, 0.0 if without == "gravity" else -9.81)
    fills = made.fills if made is not None and without != "fills" else ()
    return lambda: loads.build(tables, 1e-3, 100, gravity, folder, None if without == "structure" else assembly, fills=fills)


def measure(_: Path, __: Mapping[str, Any], text: str) -> Callable[[], Any]:
    """The name of an intensity measure."""
    return lambda: measures.parse(text, "intensity.measure")


def scene(folder: Path, group: Mapping[str, Any], old: str, new: str) -> Callable[[], Any]:
    """The text of a scene in which something stands instead of something else."""
    assert group["base"].count(old) >= 1, old
    (folder / "scene.toml").write_text(group["base"].replace(old, new, 1), encoding="utf-8")
    return lambda: read_scene(folder / "scene.toml")


def changes(folder: Path, group: Mapping[str, Any], *given: str) -> Callable[[], Any]:
    """A scene that is changed as by --set."""
    (folder / "scene.toml").write_text(group["base"], encoding="utf-8")
    return lambda: read_scene(folder / "scene.toml", [repeated(change) for change in given])


def blocks(folder: Path, group: Mapping[str, Any], old: str, new: str, keys: str = "", file: str = "") -> Callable[[], Any]:
    """The blocks of a scene in whose text something is written otherwise, of a file of one block with more keys, or of a text."""
    (folder / "scene.toml").write_text(group["base"].replace(old, repeated(new), 1), encoding="utf-8")
    own = json.dumps(TETRA)[:-1] + f", {keys}" * bool(keys) + "}"
    (folder / "b.json").write_text(repeated(file or f'{{"blocks": [{own}]}}'), encoding="utf-8")
    return lambda: make_structures(read_scene(folder / "scene.toml"))


def modal_check(folder: Path, _: Mapping[str, Any], options: Mapping[str, Any]) -> Callable[[], Any]:
    """The modal check of a block on a plate, with options as Python gives them."""
    scene = read_scene(write_plate_scene(folder))
    return lambda: modal(scene, options, folder / "out")


def structure(folder: Path, group: Mapping[str, Any], changes: Mapping[str, Any], dropped: Sequence[str] = ()) -> Callable[[], Any]:
    """The table of a structure."""
    return lambda: structures.build(changed(group["base"], changes, dropped), 2000.0, folder)


def building(
    folder: Path, group: Mapping[str, Any], changes: Mapping[str, Any], walls: Mapping[str, Any] | None = None, more: Sequence[Any] = ()
) -> Callable[[], Any]:
    """A building with other keys, and other keys of its walls by their names, of which "" leaves one out; and more walls."""
    keys = changed(group["base"], changes)
    own = [wall | (walls or {}).get(wall["name"], {}) for wall in keys["walls"]]
    keys["walls"] = [{key: value for key, value in wall.items() if value != ""} for wall in own] + [*more]
    return lambda: structures.build(keys, 2000.0, folder)


def limit(folder: Path, group: Mapping[str, Any], tables: str) -> Callable[[], Any]:
    """Limit analysis, or another ``command``, of boxes on a ground, by their names and corners, under tables of a scene."""
    stones = [ground(8.0), *(box(*stone) for stone in group["boxes"])]
    path = limit_scenes.scene(folder, stones, tables)
    return lambda: raised(masonry_cd(group.get("command", "limit"), path, "-o", folder / "out"))


def study(folder: Path, group: Mapping[str, Any], lines: Mapping[str, str]) -> Callable[[], Any]:
    """A study of a block on a plate, by three motions if need be: some of its lines, by what they begin with, are others."""
    write_records(folder)
    path = write_study(folder, group["base"], **lines)
    return lambda: plan_of(path)


def selection(folder: Path, group: Mapping[str, Any], lines: Mapping[str, str]) -> Callable[[], Any]:
    """A selection from five motions: some of its lines, by what they begin with, are others."""
    write_suite(folder / "suite", 5)
    (folder / "twice.csv").write_text("motion,magnitude\nm00,5.5\nm00,x\n")
    (folder / "words.csv").write_text("motion,magnitude\nm00,5.5\nm01,six\n")
    (folder / "select.toml").write_text(changed_lines(group["base"], dict(lines)))
    return lambda: raised(masonry_cd("select", folder / "select.toml", "-o", folder / "out"))


def command(
    folder: Path, group: Mapping[str, Any], words: str | list[str] = "", changed_keys: Mapping[str, Any] | None = None
) -> Callable[[], Any]:
    """A command line: the words of the group and more of them, on the scene of a block on a plate or on ``base``, with other keys.

    Next to the scene lie quake.csv, a file that is text, and the folder ``ran`` of a run of two blocks.
    """
    keys, base = dict(changed_keys or {}), group.get("base")
    if base is None:
        write_plate_scene(folder, **{key: repeated(str(line)) for key, line in keys.items()})
    else:
        write_plate_and_block(folder)
        (folder / "scene.toml").write_text(base if isinstance(base, str) else dump_toml(changed(base, keys)), encoding="utf-8")
    write_quake(folder)
    (folder / "text").write_text("text")
    (folder / "ran").mkdir()
    (folder / "ran" / "result.h5").write_bytes(result_of_two_blocks())
    more = shlex.split(words) if isinstance(words, str) else words
    typed = [word.replace("{}", str(folder)).replace("{root}", str(ROOT)) for word in [*shlex.split(group.get("command", "")), *more]]
    return lambda: raised(masonry_cd(*typed))


def arrays(_: Path, __: Mapping[str, Any], tables: Mapping[str, Any], change: Mapping[str, Any] | None = None) -> Callable[[], Any]:
    """The scene of Python of two blocks with other tables; with ``change``, which leaves out keys that are "", of a motion by arrays."""
    motion = {key: value for key, value in (shaking() | dict(change or {})).items() if not isinstance(value, str) or value}
    return lambda: mc.scene(two_blocks() | dict(tables) | ({} if change is None else {"loads": [motion]}))


def raised(result: Result) -> None:
    """Raise what a command was refused for."""
    raise refusal(result)


def measured(folder: Path, _: Mapping[str, Any], text: str) -> Callable[[], Any]:
    """A file of measured modes; none for no text."""
    if text:
        (folder / "measured.csv").write_text(repeated(text), encoding="utf-8")
    return lambda: read_measured(folder / "measured.csv")


def material(_: Path, __: Mapping[str, Any], keys: Mapping[str, Any]) -> Callable[[], Any]:
    """The keys of a material."""
    return lambda: parse_table(Material, {"density": 2000.0, "friction": 0.6, **keys}, "material")


DOORS: dict[str, Door] = {
    "load": load,
    "measure": measure,
    "scene": scene,
    "set": changes,
    "structure": structure,
    "building": building,
    "limit": limit,
    "study": study,
    "selection": selection,
    "command": command,
    "blocks": blocks,
    "modal": modal_check,
    "measured": measured,
    "material": material,
    "arrays": arrays,
}
