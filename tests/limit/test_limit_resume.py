# SPDX-License-Identifier: GPL-3.0-or-later
"""limit.kept: an analysis of parts that was stopped goes on with those that it was done with, to the same numbers."""

from __future__ import annotations

import csv
import json
import pickle
from pathlib import Path
from typing import Any

import pytest
from command_line import masonry_cd
from limit_scenes import scene
from test_limit_parts import SLAB, slabs

from masonry_cd.app.limit_structure import limit_structure
from masonry_cd.app.scene import read_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.limit import parts
from masonry_cd.limit.kept import NAME, KeptParts

TABLES = '[limit]\npush = "-x"\n[limit.check]\nspectrum = "EC8"\nag = 2.0\n' + SLAB + SLAB.replace('"slab"', '"low"')


def command(path: Path, folder: Path, *options: str) -> Any:
    return masonry_cd("limit", path, "-o", folder, "--no-picture", "-q", *options)


def facts(folder: Path) -> dict[str, Any]:
    made = json.loads((folder / "limit.json").read_text())
    return {key: made[key] for key in ("mechanisms", "verdict", "least", "associated", "parts")}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Results of the parts where two processes analyse them at a stretch."""
    folder = tmp_path_factory.mktemp("whole")
    with pytest.MonkeyPatch.context() as two:
        two.setattr("masonry_cd.limit.case.cores", lambda: 2)
        assert command(scene(folder, slabs(), TABLES, mu=0.6), folder / "out").exit_code == 0
    return facts(folder / "out")


def test_what_was_stopped_after_a_part_goes_on_to_the_same_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, whole: Any) -> None:
    """Here one process analyses them, one after another."""
    path = scene(tmp_path, slabs(), TABLES, mu=0.6)
    calls: list[str] = []
    analyse = parts.analyse_element

    def counted(whole, element, way, effort):
        if len(calls) == 1 and not (tmp_path / "go").exists():
            raise KeyboardInterrupt
        calls.append(element.name)
        return analyse(whole, element, way, effort)

    monkeypatch.setattr(parts, "analyse_element", counted)
    folder = tmp_path / "stopped"
    assert command(path, folder).exit_code == 130
    with (folder / "mechanisms.csv").open() as file:
        assert {row["element"] for row in csv.DictReader(file)} == {"slab"}  # the table has grown so far
    (tmp_path / "go").touch()
    assert command(path, folder, "--resume").exit_code == 0
    assert calls == ["slab", "low"] and facts(folder) == whole
    assert not (folder / NAME).exists()


def test_a_record_that_is_cut_short_or_of_another_scene_is_analysed_again(tmp_path: Path) -> None:
    structure = limit_structure(read_scene(scene(tmp_path, slabs(), TABLES, mu=0.6)))
    (push, _), folder = parts.asked_for(structure, False), tmp_path / "out"
    (one,) = parts.analysed(parts.whole_of(structure, structure.loads_of_parts()), [push], parts.effort_of(structure.asked, 0), (1, True))
    KeptParts.to(folder, structure, False).add(one, [])
    whole = (folder / NAME).read_bytes()
    assert KeptParts.to(folder, structure, True).of(push) is not None
    (folder / NAME).write_bytes(whole[:-1])
    assert KeptParts.to(folder, structure, True).of(push) is None
    (folder / NAME).write_bytes(whole)
    (tmp_path / "other").mkdir()
    other = limit_structure(read_scene(scene(tmp_path / "other", slabs(), TABLES, mu=0.5)))
    kept = KeptParts.to(folder, other, True)
    assert kept.of(push) is None and kept.others == 1


def test_a_record_runs_no_code(tmp_path: Path) -> None:
    structure = limit_structure(read_scene(scene(tmp_path, slabs(), TABLES, mu=0.6)))
    folder = tmp_path / "out"
    folder.mkdir()
    record = KeptParts.to(folder, structure, False).stamp + pickle.dumps(print)
    (folder / NAME).write_bytes(len(record).to_bytes(8, "big") + record)
    with pytest.raises(InputError, match="print"):
        KeptParts.to(folder, structure, True)


def test_where_nothing_is_kept_all_is_analysed(tmp_path: Path, whole: dict[str, Any]) -> None:
    assert command(scene(tmp_path, slabs(), TABLES, mu=0.6), tmp_path / "resumed", "--resume").exit_code == 0
    assert facts(tmp_path / "resumed") == whole
