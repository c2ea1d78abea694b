# SPDX-License-Identifier: GPL-3.0-or-later
"""mc.limit_analysis: what the command finds, as values, DataFrames and images."""

from __future__ import annotations

import json

import numpy as np
import pytest
from two_blocks import two_blocks

import masonry_cd as mc

pytestmark = pytest.mark.filterwarnings("ignore::masonry_cd.interface.returned.RunWarning")
PUSH = {"push": "x", "check": {"spectrum": "EC8", "ag": 2.0}}


def test_values_tables_and_files_are_those_of_the_command(tmp_path) -> None:
    found = mc.limit_analysis(mc.scene(two_blocks(), limit=PUSH), tmp_path / "out")
    made = json.loads((tmp_path / "out" / "limit.json").read_text())
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
        found.write(tmp_path / "out")


def test_pictures_are_images_and_the_page_shows_itself(tmp_path) -> None:
    found = mc.limit_analysis(mc.scene(two_blocks(), limit={"push": "x"}))
    assert found.folder is None and found.check is None
    for picture in (found.mechanism(), found.thrust("front")):
        assert np.asarray(picture.convert("RGB")).std() > 1.0
    assert "How good the answer is" in found.write(tmp_path / "page")._repr_html_()


def test_the_capacity_curve_is_that_of_the_command(tmp_path) -> None:
    found = mc.limit_analysis(mc.scene(two_blocks(), limit={"push": "x", "curve": {}}), tmp_path / "out")
    made = json.loads((tmp_path / "out" / "capacity.json").read_text())
    assert found.capacity is not None
    assert found.capacity.attrs["end"] == made["end"] and found.capacity.attrs["control"] == made["control"]["block"]
    with (tmp_path / "out" / "capacity.csv").open() as file:
        lines = file.read().splitlines()
    assert lines[0].split(",") == ["point", *found.capacity.columns]
    assert [float(line.split(",")[2]) for line in lines[1:]] == pytest.approx(found.capacity["factor"].tolist(), rel=1e-8)
    assert np.asarray(found.capacity_curve().convert("RGB")).std() > 1.0


def test_no_curve_is_none_and_its_picture_a_line() -> None:
    found = mc.limit_analysis(mc.scene(two_blocks(), limit={"push": "x"}))
    assert found.capacity is None
    with pytest.raises(mc.InputError, match=r"limit\.curve"):
        found.capacity_curve()


def test_a_scene_without_a_load_is_refused() -> None:
    with pytest.raises(mc.InputError, match="no load to multiply"):
        mc.limit_analysis(mc.scene(two_blocks()))
