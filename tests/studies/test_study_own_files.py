# SPDX-License-Identifier: GPL-3.0-or-later
"""A study clears what studies have written, and nothing else."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from masonry_cd.foundation import own_files
from masonry_cd.foundation.errors import InputError
from masonry_cd.studies.study.folder import KEPT, NAME, StudyFolder


@pytest.mark.parametrize(
    "place", ["runs/notes.txt", "runs/a/thesis.tex", "rows/r.csv", "joints/x.npz", "reference/result.h5", "study.html"]
)
@pytest.mark.parametrize("listed", [True, False])
def test_files_of_others_stay(tmp_path: Path, place: str, listed: bool) -> None:
    if listed:
        for folder in (tmp_path, *(tmp_path / name for name in KEPT)):
            own_files.begin(folder, ())
    theirs = tmp_path / place
    theirs.parent.mkdir(parents=True, exist_ok=True)
    theirs.write_text("theirs", encoding="utf-8")
    with pytest.raises(InputError) as refused:
        StudyFolder(tmp_path).require_own()
    assert place in str(refused.value)


def test_a_study_of_an_earlier_version_is_cleared(tmp_path: Path) -> None:
    (tmp_path / NAME).write_text(json.dumps({"format": 1, "program": "0.1", "identity": {}}), encoding="utf-8")
    for name in ("rows/a.json", "joints/a.npz", "reference/run.txt", "runs/a/joints.csv", "runs/b.12.part/joints.csv"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("", encoding="utf-8")
    here = StudyFolder(tmp_path)
    here.require_own()
    here.clear()
    assert not list(tmp_path.iterdir())


def test_what_a_kill_leaves_is_cleared(tmp_path: Path) -> None:
    for folder in (tmp_path, *(tmp_path / name for name in KEPT)):
        own_files.begin(folder, ())
    for name in ("rows/a.part.json", "rows/a.hang", "runs/a.12.part/result.h5"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("", encoding="utf-8")
    StudyFolder(tmp_path).require_own()
