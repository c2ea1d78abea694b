# SPDX-License-Identifier: GPL-3.0-or-later
"""The search for kills that lose something: that it strikes, and that it would find what is wrong."""

from __future__ import annotations

import os
import shutil

import h5py
import numpy as np
import pytest

from benchmarks import kills

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs os.fork")


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    """An undisturbed run."""
    return kills.undisturbed(tmp_path_factory.mktemp("kills"), ["spatial"])["spatial"]


@pytest.mark.slow(reason="runs are begun and killed until there were enough strikes, each a process")
def test_runs_are_struck_until_there_were_as_many_strikes_as_asked_for(capsys):
    assert kills.strike(["--times", "2", "--kind", "spatial", "--seed", "5"]) == 0
    said = capsys.readouterr().out
    assert "kills: 1 (spatial 1)" in said
    assert "interrupts: 1 (spatial 1)" in said
    assert "; 0 did not end as they should" in said


def test_other_tables_and_files_are_found(reference, tmp_path):
    out = tmp_path / "out"
    shutil.copytree(reference.folder, out)
    kills.check_end(out, reference)
    table = out / "joints.csv"
    table.write_text(table.read_text().replace("intact", "opened", 1))
    with pytest.raises(kills.Wrong, match=r"joints\.csv"):
        kills.check_end(out, reference)
    table.unlink()
    with pytest.raises(kills.Wrong, match="files"):
        kills.check_end(out, reference)


def test_other_rows_of_results_are_found(reference, tmp_path):
    out = tmp_path / "out"
    shutil.copytree(reference.folder, out)
    kills.check_between(out, reference)
    with h5py.File(out / "result.h5", "r+") as file:
        file["position"][1, 1, 0] += 1e-12
    with pytest.raises(kills.Wrong):
        kills.check_between(out, reference)


def test_rows_without_columns_are_counted():
    """The joints' histories of a scene without joints have no bytes that could differ."""
    assert kills.bits_of(np.zeros((3, 0))) == kills.bits_of(np.zeros((3, 0)))
    assert kills.bits_of(np.zeros((3, 0))) != kills.bits_of(np.zeros((2, 0)))
