# SPDX-License-Identifier: GPL-3.0-or-later
"""mc.limit_analysis and mc.macro_elements: what the command finds, as values, DataFrames and images."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from two_blocks import two_blocks

import masonry_cd as mc

pytestmark = pytest.mark.filterwarnings("ignore::masonry_cd.interface.returned.RunWarning")
CHECK = {"spectrum": "EC8", "ag": 2.0}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> mc.LimitAnalysis:
    """Two blocks pushed, with their check and their curve, in a folder."""
    asked = {"push": "x", "check": CHECK, "curve": {}}
    return mc.limit_analysis(mc.scene(two_blocks(), limit=asked), tmp_path_factory.mktemp("limit") / "out")


@pytest.fixture(scope="module")
def bare() -> mc.LimitAnalysis:
    """The factor alone, in no folder."""
    return mc.limit_analysis(mc.scene(two_blocks(), limit={"push": "x"}))


def test_values_tables_and_files_are_those_of_the_command(whole: mc.LimitAnalysis) -> None:
    found, made = whole, json.loads((whole.folder / "limit.json").read_text())
    assert found.stands is made["stands"] is True
    assert found.factor == made["associated"]
    assert found.least == made["least"]["factor"]
    assert found.verdict is not None and repr(found).endswith(f": {found.verdict['state']}>")
    assert "load factor" in str(found) and "linear check" in str(found)
    assert found.blocks.index[found.blocks["moves"]].tolist() == made["mechanism"]["moving_blocks"]
    assert (found.joints["state"] == "hinge").sum() == made["mechanism"]["joints_hinge"]
    assert found.check is not None
    assert found.check["value"].tolist() == [step["value"] for step in made["check"]["steps"]]
    assert found.check.attrs["verdicts"] == made["check"]["verdicts"]
    with pytest.raises(mc.InputError, match="force"):
        found.write(whole.folder)


def test_pictures_are_images_and_the_page_shows_itself(bare: mc.LimitAnalysis, tmp_path: Path) -> None:
    assert bare.folder is None and bare.check is None
    for picture in (bare.mechanism(), bare.thrust("front")):
        assert np.asarray(picture.convert("RGB")).std() > 1.0
    assert "Accuracy of the result" in bare.write(tmp_path / "page")._repr_html_()


def test_the_capacity_curve_is_that_of_the_command(whole: mc.LimitAnalysis) -> None:
    found, made = whole, json.loads((whole.folder / "capacity.json").read_text())
    assert found.capacity is not None
    assert found.capacity.attrs["end"] == made["end"] and found.capacity.attrs["control"] == made["control"]["block"]
    lines = (whole.folder / "capacity.csv").read_text().splitlines()
    assert lines[0].split(",") == ["point", *found.capacity.columns]
    assert [float(line.split(",")[2]) for line in lines[1:]] == pytest.approx(found.capacity["factor"].tolist(), rel=1e-8)
    assert np.asarray(found.capacity_curve().convert("RGB")).std() > 1.0


def test_no_curve_is_none_and_its_picture_a_line(bare: mc.LimitAnalysis) -> None:
    assert bare.capacity is None
    with pytest.raises(mc.InputError, match=r"limit\.curve"):
        bare.capacity_curve()


def test_tables_and_verdict_are_those_of_the_command(tmp_path: Path) -> None:
    found = mc.macro_elements(mc.scene(two_blocks(), limit={"check": CHECK}), tmp_path / "out", jobs=1)
    made = json.loads((tmp_path / "out" / "limit.json").read_text())
    with (tmp_path / "out" / "mechanisms.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert list(found.mechanisms.columns) == list(rows[0]) and len(found.mechanisms) == len(rows)
    assert found.parts["ratio"].is_monotonic_increasing and len(found.parts) == len(found.parts[["element", "push"]].drop_duplicates())
    assert found.verdict is not None and found.verdict["words"] == made["verdict"]["words"] and found.verdict["reason"] in str(found)
    assert found.verdict["state"] in repr(found)
    with pytest.raises(mc.InputError, match="force"):
        found.write(tmp_path / "out")


def test_without_a_check_there_is_no_verdict() -> None:
    found = mc.macro_elements(mc.scene(two_blocks()), jobs=1)
    assert found.verdict is None and found.parts["ratio"].isna().all() and found.parts["a0_m_s2"].is_monotonic_increasing
