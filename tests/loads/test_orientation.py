# SPDX-License-Identifier: GPL-3.0-or-later
"""Which way a channel points: by its name, or by that of its file."""

from __future__ import annotations

import pytest

from loads.readers.orientation import of_name, of_record


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        *[(name, (True, None)) for name in ("HNZ", "IV.AQK..HNZ", "U-D", "ud", "Up", "DWN", "Vertical", "V", "az", "acc_z", "UD2", "HG3")],
        *[(name, (False, 0.0)) for name in ("N-S", "ns", "HNN", "north", "360", "N00E", "180 DEG", "acc_ns", "S00E")],
        *[(name, (False, 90.0)) for name in ("E-W", "we", "HHE", "090", "90", "N90E", "est", "270", "acc E", "EW1")],
        *[(name, (False, 172.0)) for name in ("N08W", "S08E", "352", "172")],
        *[(name, (False, None)) for name in ("HN1", "ax", "H2", "long", "Trans", "x")],
        *[(name, None) for name in ("", "a", "acc", "column 1", "1", "?", "L1", "ch3", "N-Z", "v", "first", "NS EW", "999")],
    ],
)
def test_which_way_a_channel_points(name: str, wanted: tuple[bool, float | None] | None) -> None:
    assert of_name(name) == wanted


@pytest.mark.parametrize(
    ("path", "vertical"), [("AKT013.UD", True), ("RSN1-E07-UP.AT2", True), ("a/b_NS.acc", False), ("x_N08W.txt", False), ("hnz.txt", True)]
)
def test_the_name_of_the_file_says_it_where_the_file_does_not(path: str, vertical: bool) -> None:
    found = of_record("", path)
    assert found is not None
    assert found.vertical == vertical


@pytest.mark.parametrize("path", ["setup.txt", "test_n.csv", "z.txt", "quake.v2", "NS_of_a_bridge.txt"])
def test_other_names_of_files_say_nothing(path: str) -> None:
    assert of_record("", path) is None
