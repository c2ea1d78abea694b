# SPDX-License-Identifier: GPL-3.0-or-later
"""Damaged results: every command ends with what still holds, or with one line; none hangs, crashes, or reports what is not so."""

from __future__ import annotations

import random
import shutil
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest
from command_line import done, masonry_cd
from datasets import contents
from forked import ended
from places import ROOT
from small_runs import ctrl_c_before_step

from masonry_cd.foundation.errors import InputError
from masonry_cd.io.layout import FORMAT
from masonry_cd.io.results import Results

LIMIT = 120  # seconds after which a process counts as hanging
SCENE = ROOT / "benchmarks" / "bits" / "tower.toml"
ASKED = ("run", SCENE, "-q", "--set", "run.duration=0.2", "--set", "run.frames_per_second=100", "--set", "run.checkpoint_every=0", "-o")
FLIPS, CUTS = (8, 60), (4, 20)  # in the core, and in all
HISTORIES = ("opening", "sliding", "normal_force", "force_point")


def seeds(core: int, most: int) -> list[object]:
    """Return seeds of random damage; those beyond the core are slow."""
    more = pytest.mark.slow(reason="one of many kinds of damage, each tried in a process")
    return [seed if seed < core else pytest.param(seed, marks=more) for seed in range(most)]


@pytest.fixture(scope="module")
def stopped(tmp_path_factory) -> Path:
    """The folder of a run that Ctrl-C ended after 70 of its 100 steps."""
    folder = tmp_path_factory.mktemp("stopped")

    with ctrl_c_before_step(69):
        assert masonry_cd(*ASKED, folder / "out").exit_code == 130
    assert masonry_cd(*ASKED, folder / "whole").exit_code == 0
    shutil.copytree(folder / "out", folder / "tried")  # so that the processes below find all that they import
    for words in commands(folder / "tried", folder):
        assert masonry_cd(*words).exit_code == 0
    return folder


def commands(out: Path, stopped: Path) -> tuple[tuple[object, ...], ...]:
    """The commands that read the results of a run."""
    return (
        ("report", out, "--no-crack-map"),
        ("export", out, "-o", out / "view"),
        ("compare", out, stopped / "whole"),
        (*ASKED, out, "--resume"),
    )


def values(results: Results) -> Iterator[np.ndarray]:
    """Yield the values that grow, as far as they are held."""
    yield from (results.time, results.position[: results.frames], results.velocity[: results.frames])
    yield from map(results.joint_history, HISTORIES)
    yield from results.energies.values()


def holds_what_was_written(damaged: Path, original: Path) -> bool:
    """Return True if results read, in which case they are those that were written: all of them, or the first of them and a word."""
    try:
        found = Results.open(damaged)
    except InputError as reason:
        assert len(str(reason).splitlines()) == 1
        return False
    with found, Results.open(original) as kept:
        for now, then in zip(values(found), values(kept), strict=True):
            assert now.tobytes() == then[: len(now)].tobytes()
            assert len(now) == len(then) or found.words
        assert [b.vertices.tobytes() for b in found.blocks] == [b.vertices.tobytes() for b in kept.blocks]
        assert found.scene == kept.scene
        peaks = [p.tobytes() for p in found.peaks.values()] == [p.tobytes() for p in kept.peaks.values()]
        assert peaks or found.words
        of_steps = [p.tobytes() for p in found.step_peaks.values()] == [p.tobytes() for p in kept.step_peaks.values()]
        assert of_steps or found.words
        assert found.support == kept.support
    return True


def command_copes(number: int, out: Path, stopped: Path) -> None:
    """One of the commands that read results, on a folder whose result.h5 is damaged; fails where it does not end as it should."""
    reads = holds_what_was_written(out / "result.h5", stopped / "out" / "result.h5")
    words = commands(out, stopped)[number % 4]
    result = masonry_cd(*words)
    assert result.exception is None or isinstance(result.exception, SystemExit), result.output
    assert result.exit_code == 0 or (result.exit_code == 2 and len(result.stderr.splitlines()) == 1), result.output
    assert result.exit_code == 0 if reads and words[0] != "run" else True, result.output
    if words[0] == "run" and result.exit_code == 0:
        assert contents(out / "result.h5") == contents(stopped / "whole" / "result.h5")
    elif words[0] == "run":
        assert not list(out.glob("*.part.*")) and not (out / "run.lock").exists()


def folder_with(data: bytes, stopped: Path, to: Path) -> Path:
    """A copy of the folder of the run with other bytes in result.h5."""
    shutil.rmtree(to, ignore_errors=True)
    shutil.copytree(stopped / "out", to)
    (to / "result.h5").write_bytes(data)
    return to


def marked(data: bytes) -> bytes:
    """The bytes of a result file as its writer leaves them when it is killed: marked as being written."""
    from masonry_cd.io.hdf5_file import SUPERBLOCK, lookup3

    head = bytearray(data[: SUPERBLOCK.size])
    head[11] = 5
    head[-4:] = lookup3(bytes(head[:-4])).to_bytes(4, "little")
    return bytes(head) + data[len(head) :]


@pytest.mark.parametrize("seed", seeds(*FLIPS))
def test_flipped_bits(stopped, tmp_path, seed):
    """Half of the places lie in the first tenth of the file, where most of what HDF5 says about it is."""
    rng, data = random.Random(seed), bytearray((stopped / "out" / "result.h5").read_bytes())
    for _ in range(1 + seed % 3):
        data[rng.randrange(len(data) // (10 if seed % 2 else 1))] ^= 1 << rng.randrange(8)
    kept = marked(data) if seed % 5 == 0 else bytes(data)
    assert ended(lambda: command_copes(seed // 2, folder_with(kept, stopped, tmp_path / "out"), stopped), LIMIT) == ""


@pytest.mark.parametrize("seed", seeds(*CUTS))
def test_files_cut_off(stopped, tmp_path, seed):
    """Files are of a run that ended and, every other one, of a run that was killed, whose file does not say how long it is."""
    data = (stopped / "out" / "result.h5").read_bytes()
    kept = (marked(data) if seed % 2 else data)[: random.Random(seed).randrange(len(data))]
    assert ended(lambda: command_copes(seed // 2, folder_with(kept, stopped, tmp_path / "out"), stopped), LIMIT) == ""


def test_what_precedes_the_damage_is_reported_with_a_word(stopped, tmp_path):
    out = folder_with((stopped / "out" / "result.h5").read_bytes(), stopped, tmp_path / "out")
    with h5py.File(out / "result.h5", "r+") as file:
        rows = file["segments/rows"][...]
        assert len(rows) > 2
        names = [name.decode() for name in file["segments/names"][...]]
        frames = rows[:, names.index("position")]
        last = int(np.flatnonzero(np.diff(frames[1:]))[1]) + 1  # segment before the one that holds the third frame from here
        good = int(frames[last])
        file["position"][good, 1, 2] += 1e-9
    with Results.open(out / "result.h5") as results, Results.open(stopped / "out" / "result.h5") as kept:
        assert results.frames == good
        assert np.array_equal(results.time, kept.time[:good])
        assert len(results.per_step("penetration")) == rows[last, names.index("penetration")]
        assert results.words == (
            f"{out / 'result.h5'}: damaged; data after {kept.time[good - 1]:.6g} s is left out ({good} frames are intact)",
        )
    result = masonry_cd("report", out, "--no-crack-map")
    assert (result.exit_code, len(result.stderr.splitlines())) == (0, 1)
    assert "result.h5: damaged; data after" in result.stderr


def test_peaks_that_are_damaged_give_way_to_those_of_the_frames(stopped, tmp_path):
    out = folder_with((stopped / "out" / "result.h5").read_bytes(), stopped, tmp_path / "out")
    with h5py.File(out / "result.h5", "r+") as file:
        file["joints/peak/opening"][0] = 7.0
    result = done("report", out, "--no-crack-map")
    assert result.stderr.endswith("the largest values of the joints are damaged; the largest values of the frames are used\n")
    assert "7.0" not in (out / "joints.csv").read_text()


def test_results_of_a_newer_format_are_refused_and_older_ones_read(stopped, tmp_path):
    import pandas as pd

    out = folder_with((stopped / "out" / "result.h5").read_bytes(), stopped, tmp_path / "out")
    with h5py.File(out / "result.h5", "r+") as file:
        file.attrs["format"] = FORMAT + 1
    result = masonry_cd("report", out, "--no-crack-map")
    assert (result.exit_code, len(result.stderr.splitlines())) == (2, 1)
    assert f"result.h5: has format {FORMAT + 1} of a newer masonry_cd" in result.stderr
    with h5py.File(out / "result.h5", "r+") as file:
        for name in ("format", "constant", "inputs"):
            del file.attrs[name]
        del file["segments"], file["closing"], file["peaks"], file["blocks/support"]
    (out / "joints.csv").unlink()
    result = masonry_cd("report", out, "--no-crack-map")
    assert (result.exit_code, result.stderr) == (0, "")
    older, newer = (pd.read_csv(folder / "out" / "joints.csv") for folder in (tmp_path, stopped))
    assert newer.provisional.str.contains("interrupted").all()
    assert not older.provisional.str.contains("interrupted|cut off").any()  # which a file of that time does not tell
    pd.testing.assert_frame_equal(older.drop(columns="provisional"), newer.drop(columns="provisional"))


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("joints/block_a", lambda a: a + 99, "has indices out of range"),
        ("blocks/loops", lambda a: a + 99, "has indices out of range"),
        ("blocks/loop_start", lambda a: a[::-1], "does not partition its"),
        ("joints/polygon_start", lambda a: a * 2, "does not partition its"),
        ("joints/normal", lambda a: a[:, :2], "should have the shape"),
        ("blocks/density", lambda a: a.astype("S8"), "should have real numbers"),
        ("joints/area", None, "not the result of a run"),
        ("blocks/fixed", lambda a: a[:1], "should have the shape"),
        ("position", lambda a: a[:, :1], "position should have real numbers"),
        ("joints/opening", lambda a: a.astype(int), "joints/opening should have real numbers"),
        ("peaks/drift", lambda a: a[:1], "peaks/level_displacement should have the shape"),
        ("peaks/hinge_place", lambda a: a[:, :2], "peaks/hinge_place should have the shape"),
        ("peaks/displacement", None, "peaks/displacement should have real numbers"),
        ("blocks/support", lambda a: a * 0 + 1, "blocks/support is not a support"),
    ],
)
def test_arrays_that_no_run_writes_are_named(stopped, tmp_path, name, change, message):
    """In a file without checksums, or one whose checksums were made to fit."""
    out = folder_with((stopped / "out" / "result.h5").read_bytes(), stopped, tmp_path / "out")
    with h5py.File(out / "result.h5", "r+") as file:
        array = file[name][...]
        del file[name], file.attrs["format"]
        if change is not None:
            file.create_dataset(name, data=change(array), maxshape=(None,) * array.ndim)
    result = masonry_cd("report", out, "--no-crack-map")
    assert (result.exit_code, len(result.stderr.splitlines())) == (2, 1), result.output
    assert message in result.stderr


def test_a_dataset_that_announces_more_than_the_file_holds_is_not_read(stopped, tmp_path):
    out = folder_with((stopped / "out" / "result.h5").read_bytes(), stopped, tmp_path / "out")
    with h5py.File(out / "result.h5", "r+") as file:
        file["position"].resize(1 << 50, axis=0)
        frames = len(file["time"])
        del file.attrs["format"]
    with Results.open(out / "result.h5") as results:
        assert results.frames == frames
    with h5py.File(out / "result.h5", "r+") as file:
        del file["joints/area"]
        file.create_dataset("joints/area", shape=(1 << 50,), chunks=(1024,), dtype=float)
    with pytest.raises(InputError, match="joints/area has more entries than the file stores"):
        Results.open(out / "result.h5")


def test_a_summary_of_another_shape_is_one_line_and_is_written_anew(stopped, tmp_path):
    out = folder_with((stopped / "out" / "result.h5").read_bytes(), stopped, tmp_path / "out")
    for text in ('{"solver": 7}', '{"title": "cut o', "[" * 100_000):
        (out / "summary.json").write_text(text)
        result = masonry_cd("compare", out, stopped / "whole")
        assert (result.exit_code, len(result.stderr.splitlines())) == (2, 1), result.output
        result = masonry_cd("report", out, "--no-crack-map")
        assert (result.exit_code, len(result.stderr.splitlines())) == (0, 1), result.output
        assert "it is written again" in result.stderr
        assert masonry_cd("compare", out, stopped / "whole").exit_code == 0
    (out / "summary.json").write_text('{"format": 99}')
    result = masonry_cd("report", out, "--no-crack-map")
    assert (result.exit_code, len(result.stderr.splitlines())) == (2, 1)
    assert "summary.json: has format 99 of a newer masonry_cd" in result.stderr
