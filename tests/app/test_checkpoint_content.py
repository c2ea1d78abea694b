# SPDX-License-Identifier: GPL-3.0-or-later
"""The contents of a checkpoint are checked before use: whatever is changed in it, with a checksum that fits, no process crashes."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from block_files import cuboid
from command_line import done, masonry_cd
from datasets import contents
from forked import ended
from places import ROOT
from small_runs import ctrl_c_before_step, write_scene

from masonry_cd.app import run_loop
from masonry_cd.app.case import prepare
from masonry_cd.app.checkpoint_checks import KeptArrays, check_content
from masonry_cd.app.scene import read_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.io import checkpoint
from masonry_cd.io.results import Results
from masonry_cd.mechanics.dynamics.equilibrium import settles
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper

LIMIT = 300  # seconds after which a process counts as hanging

SCENES = {  # what the stepper of each remembers: impacts and islands, bonds and springs, factors of the solver
    "islands": ("run.duration=0.3", 100),
    "mortar": ("run.duration=0.08", 25),
    "elastic": ("run.duration=0.08", 25),
    "softening": ("run.duration=0.08", 25),
}
SOFT = ("material.joints.fracture_energy=15", "material.joints.shear_fracture_energy=60")


def asked(name: str, out: Path) -> tuple[object, ...]:
    keys = [key for given in overrides(name) for key in ("--set", given)]
    return ("run", ROOT / "benchmarks" / "bits" / f"{name.replace('softening', 'mortar')}.toml", "-o", out, "-q", *keys)


def overrides(name: str) -> list[str]:
    return [SCENES[name][0], *(SOFT if name == "softening" else ())]


@pytest.fixture(scope="module", params=SCENES)
def stopped(request, tmp_path_factory) -> tuple[str, Path]:
    """A scene, and the folder of its run that Ctrl-C ended on its way."""
    name, out = request.param, tmp_path_factory.mktemp(request.param) / "out"

    with ctrl_c_before_step(SCENES[name][1]):
        assert masonry_cd(*asked(name, out)).exit_code == 130
    shutil.copytree(out, out.with_name("tried"))  # so that the processes below find all that they import
    assert masonry_cd(*asked(name, out.with_name("tried")), "--resume").exit_code == 0
    return name, out


def wrong_ones(name: str, array: np.ndarray) -> dict[str, np.ndarray]:
    """An array as no run leaves it, by what is wrong."""
    found = {"longer": np.concatenate([array, array[:1]]) if array.ndim and len(array) else np.zeros((2, 5))}
    found["flat"] = array.reshape(-1, 1, 1)
    found["type"] = array.astype(np.float32 if array.dtype == np.float64 else np.float64 if array.dtype != np.float32 else np.int8)
    found["order of bytes"] = array.astype(array.dtype.newbyteorder(">")) if array.dtype.itemsize > 1 else array.astype("S4")
    counter = name.endswith(("tally", "rebuilds", "counts"))
    if array.dtype == np.int64 and array.size and not counter:
        for word, value in (("far", 2**40), ("beyond", 10_000), ("before", -7)):
            found[word] = array.copy()
            found[word].flat[array.size // 2] = value
    # what has not been learnt yet may be NaN, and memory that is filled before it is read may hold anything
    if (
        array.dtype == np.float64
        and array.size
        and not name.endswith(("rho", "pose", "built", "allowance", "energy", "first_opening_time"))
    ):
        found["not a number"] = array.copy()
        found["not a number"].flat[array.size // 2] = -np.inf
    return found


def refusals(name: str, out: Path, changed: list[dict[str, np.ndarray]], numbers: dict) -> str:
    """Return the faults found when the run of a folder is resumed with changed checkpoints, one after another; "" for nothing."""
    for number, arrays in enumerate(changed):
        checkpoint.save(out / checkpoint.NAME, arrays, numbers)
        checkpoint.before(out / checkpoint.NAME).unlink()
        before = sorted((path.name, path.read_bytes()) for path in out.iterdir())
        result = masonry_cd(*asked(name, out), "--resume")
        if result.exit_code != 2 or len(result.stderr.splitlines()) != 1 or "checkpoint.npz: " not in result.stderr:
            return f"{number}: {result.exit_code} {result.output}"
        if sorted((path.name, path.read_bytes()) for path in out.iterdir()) != before:
            return "something was left behind"
    return ""


def read(name: str, folder: Path) -> tuple[dict[str, np.ndarray], dict, Callable[..., None]]:
    """Return the contents of the checkpoint of a run, and the check of it."""
    case = prepare(read_scene(asked(name, folder)[1], overrides(name)))
    loading = case.loading
    stepper = Stepper(case.assembly, loading.support_velocity, loading.acceleration, case.scene.run, forces=loading.forces)
    arrays, numbers = checkpoint.load(folder / checkpoint.NAME)
    kept = KeptArrays(case.assembly.blocks, case.joints.count, case.scene.stress, settles(case.assembly))
    return arrays, numbers, lambda arrays, numbers: check_content(arrays, numbers, stepper, kept)


def test_every_array_is_checked(stopped):
    """Each array is left out, and is of another shape, type, and with values out of range; all of which is refused by its name."""
    arrays, numbers, check = read(*stopped)
    check(arrays, numbers)
    assert {"detector/feature", "islands/root", "peaks/opening"} <= arrays.keys()
    optional = ("carried_impulse", "islands/forces", "islands/impacts")  # a run may leave none of these
    let_through = []
    for key, array in arrays.items():
        changed = {word: arrays | {key: wrong} for word, wrong in wrong_ones(key, array).items()}
        if not key.startswith(optional):
            changed["missing"] = {other: kept for other, kept in arrays.items() if other != key}
        let_through += [f"{key} {word}" for word, wrong in changed.items() if not refused(check, wrong, numbers)]
    assert let_through == []


def refused(check: Callable[..., None], arrays: dict[str, np.ndarray], numbers: dict) -> bool:
    """Return True if a check raises an error of one line."""
    try:
        check(arrays, numbers)
    except InputError as reason:
        return len(str(reason).splitlines()) == 1
    return False


def out_of_place(arrays: dict[str, np.ndarray]) -> list[dict[str, np.ndarray]]:
    """Arrays of the right shape whose indices are those of nothing, or of something else."""
    changed = []
    for key, shift in (("detector/place", 1), ("detector/point_count", 99), ("detector/feature", 3), ("steps", 999)):
        changed.append(arrays | {key: arrays[key] + shift})
    changed.append(arrays | {"detector/parts": arrays["detector/parts"][::-1].copy()})
    bodies = len(arrays["islands/root"])
    changed.append(arrays | {"islands/root": np.arange(bodies - 1, -1, -1)})  # blocks that are each other's first: an endless search
    changed.append(arrays | {"orientation": 2.0 * arrays["orientation"]})
    for key in arrays:
        if key.endswith((" place", " row", " target", " first", " order")) and (arrays[key] != arrays[key][::-1]).any():
            changed.append(arrays | {key: arrays[key][::-1].copy()})
    return [*changed, *(arrays | {key: np.zeros(3)} for key in ("unknown", "islands/forces 0", "islands/forces 999999 k"))]


@pytest.mark.slow(reason="a run is resumed with each of twenty changed checkpoints")
def test_no_index_out_of_place_reaches_a_kernel(stopped, tmp_path):
    """The command gives one line and leaves the folder as it was."""
    name, folder = stopped
    out = tmp_path / "out"
    shutil.copytree(folder, out)
    arrays, numbers = checkpoint.load(out / checkpoint.NAME)
    assert ended(lambda: refusals(name, out, out_of_place(arrays), numbers), LIMIT) == ""


def test_every_number_is_checked(stopped):
    arrays, numbers, check = read(*stopped)
    wrong = [{**numbers, key: value} for key in numbers for value in (None, "x", [1], {"a": 1}, -3, 1e300, float("nan"))]
    for key, value in numbers["report"].items():
        for other in (None, [1], {"a": [1]}, 3 if isinstance(value, str) else "x"):
            wrong.append({**numbers, "report": {**numbers["report"], key: other}})
    let_through = [changed for changed in wrong if not refused(check, arrays, changed)]
    assert let_through == [{**numbers, "mark": "x"}]  # a mark is compared with the results


def test_the_one_before_is_taken_where_the_last_is_no_good(stopped, tmp_path):
    name, folder = stopped
    out = tmp_path / "out"
    shutil.copytree(folder, out)
    saved = out / checkpoint.NAME
    arrays, numbers = checkpoint.load(saved)
    checkpoint.save(saved, arrays | {"position": arrays["position"][:-1]}, numbers)  # the good one becomes the one before
    result = done(*asked(name, out), "--resume")
    assert "the run continues from the previous checkpoint" in result.stderr
    assert contents(out / "result.h5") == contents(folder.with_name("tried") / "result.h5")


def test_inputs_that_changed_are_named(block_on_plate, tmp_path):
    scene, out = block_on_plate(duration="duration = 0.02"), tmp_path / "out"

    with ctrl_c_before_step(7):
        assert masonry_cd("run", scene, "-o", out, "-q").exit_code == 130
    blocks, kept = tmp_path / "blocks.json", (tmp_path / "blocks.json").read_text()
    table = json.loads(kept)
    table["blocks"][1]["vertices"] = [[x, 1.01 * y, z] for x, y, z in table["blocks"][1]["vertices"]]
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    blocks.write_text(json.dumps(table))
    result = masonry_cd("run", scene, "-o", out, "-q", "--resume")
    assert (result.exit_code, len(result.stderr.splitlines())) == (2, 1)
    assert "result.h5: blocks.json: not what it was when the run began" in result.stderr
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before
    blocks.write_text(kept)
    assert masonry_cd("run", scene, "-o", out, "-q", "--resume").exit_code == 0


STEPS, SAVED, KILLED = 60, 37, 45  # the last before the kill, which leaves rows of a frame and of steps beyond the checkpoint
PLATE = cuboid((-1.0, -1.0, -0.2), (1.0, 1.0, 0.0)) | {"name": "plate", "fixed": True, "group": "base"}


def block(name: str, low: float) -> dict[str, Any]:
    """A cube of 0.2 m whose lower face is at a height [m]."""
    return cuboid((-0.1, -0.1, low), (0.1, 0.1, low + 0.2)) | {"name": name}


SCENES_JOINTS = {  # blocks, and direction of gravity
    "no joints": ([PLATE, block("a", 0.05), block("b", 0.5)], -1.0),
    "one block": ([block("a", 0.0)], -1.0),
    "no motion": ([PLATE, block("a", 0.0), block("b", 0.2)], -1.0),
    "joints that vanish": ([PLATE, block("a", 0.0), block("b", 0.2)], 1.0),
}


def run(scene: Path, out: Path, *more: str) -> dict[str, Any]:
    """A run by the command line, with its damage; its summary."""
    words = ["run", str(scene), "-o", str(out), "-q", "--set", "report.damage=true", "--set", "run.until_still=false", *more]
    done(*words)
    return json.loads((out / "summary.json").read_text())


class Killed(BaseException):
    """Stands for a kill between two steps."""


@pytest.mark.parametrize("name", SCENES_JOINTS)
def test_a_killed_run_ends_as_the_unbroken_one(tmp_path, monkeypatch, name):
    blocks, up = SCENES_JOINTS[name]
    scene = write_scene(
        tmp_path,
        blocks,
        "[material]\ndensity = 2000.0\nfriction = 0.5\n"
        f"[run]\ndt = 4e-3\nduration = {STEPS * 4e-3}\nframes_per_second = 50\ngravity = [0.0, 0.0, {up * 9.81}]\n",
    )
    whole = run(scene, tmp_path / "whole")

    def save(loop: Any) -> None:
        if loop.report.steps == SAVED:
            loop.save(loop.save_to)
        if loop.report.steps == KILLED:
            raise Killed

    with monkeypatch.context() as kill:
        kill.setattr(run_loop._Loop, "save_when_due", save)
        with pytest.raises(Killed):
            run(scene, tmp_path / "broken")
    with Results.open(tmp_path / "broken" / "result.h5") as results:
        assert results.rows("step_time") == KILLED
        assert results.words == ()
    resumed = run(scene, tmp_path / "broken", "--resume")
    assert contents(tmp_path / "broken" / "result.h5") == contents(tmp_path / "whole" / "result.h5")
    assert shapes(tmp_path / "broken" / "result.h5") == shapes(tmp_path / "whole" / "result.h5")  # empty rows have no bytes to compare
    for table in tmp_path.glob("whole/*.csv"):
        assert (tmp_path / "broken" / table.name).read_bytes() == table.read_bytes()
    seconds = {"wall_seconds", "stepping_seconds"}
    assert {key: resumed[key] for key in resumed.keys() - seconds} == {key: whole[key] for key in whole.keys() - seconds}


def shapes(path: Path) -> dict[str, tuple[int, ...]]:
    """Return the shapes of all datasets but the segments, which end where checkpoints were."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.update({name: getattr(item, "shape", ())}) if "segments" not in name else None)
    return {name: shape for name, shape in found.items() if name != "closing"}
