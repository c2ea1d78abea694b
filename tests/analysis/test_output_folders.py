# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of each command are declared once: what writes them finds its names there."""

from __future__ import annotations

from masonry_cd.analysis.outputs.folders import FOLDERS, files_of
from masonry_cd.app.commands.modal import METHODS
from masonry_cd.limit.curve import CURVE_OUTPUTS
from masonry_cd.limit.vehicle import CROSSING_OUTPUTS
from reports.assess import outputs as assess
from reports.study.joint_maps import TABLE
from reports.study.outputs import FILES


def test_what_writes_a_file_finds_it_declared():
    assert {*CURVE_OUTPUTS, *CROSSING_OUTPUTS, "limit.json", "mechanisms.csv", "limit.html"} <= {*files_of("limit")}
    assert {f"{what}_{method}.{form}" for what, form in (("shapes", "csv"), ("modes", "png")) for method in METHODS} <= {*files_of("modal")}
    assert {assess.CSV, assess.FILE, assess.PICTURE, assess.PAGE} == {*files_of("assess")}
    assert {TABLE, "fragility.csv", "study.html"} <= {*FILES}
    assert "runs.csv" not in FILES  # which a study makes run by run, and no report takes away
    assert all(meaning for files in FOLDERS.values() for meaning in files.values())
