# SPDX-License-Identifier: GPL-3.0-or-later
"""The search for kills that lose something: that it strikes, and that it would find what is wrong."""

from __future__ import annotations

import os
import shutil

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
