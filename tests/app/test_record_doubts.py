# SPDX-License-Identifier: GPL-3.0-or-later
"""Channels along another axis, records that act twice, and scales that convert once too often draw one line each, at their key."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from two_blocks import two_blocks

import masonry_cd as mc
from loads.readers.orientation import of_name, of_record
from masonry_cd.app.case import prepare

TIME = 0.01 * np.arange(401)
SWELL = np.sin(np.pi * TIME / 4.0) ** 2
NS, EW, UD = (1.5 * SWELL * np.sin(w * TIME + w) for w in (17.0, 22.0, 31.0))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """One station in a table of three channels, in a file each, and in files whose headings alone name the channel."""
    rows = "".join(",".join(f"{v:.9g}" for v in row) + "\n" for row in zip(TIME, NS, EW, UD, strict=True))
    (tmp_path / "three.csv").write_text("time_s,NS_m_s2,EW_m_s2,UD_m_s2\n" + rows)
    (tmp_path / "lettered.csv").write_text("time_s,ax_m_s2,ay_m_s2,az_m_s2\n" + rows)
    (tmp_path / "bearings.csv").write_text("time_s,N08W_m_s2,S82W_m_s2,ch3_m_s2\n" + rows)
    (tmp_path / "plain.csv").write_text("time_s,first_m_s2,second_m_s2,third_m_s2\n" + rows)
    for name, values in (("quake_NS.txt", NS), ("quake_EW.txt", EW), ("quake_UD.txt", UD), ("copy.txt", NS)):
        (tmp_path / name).write_text("".join(f"{t:.2f} {a:.9g}\n" for t, a in zip(TIME, values, strict=True)))
    heading = "PEER\nA QUAKE, 1/1/80, A STATION, {}\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS= 401, DT= .01 SEC\n"
    for name, values in (("UP", UD), ("090", EW)):
        (tmp_path / f"peer{name}.at2").write_text(heading.format(name) + "\n".join(f"{a / 9.80665:.9g}" for a in values))
    return tmp_path


def doubted(folder: Path, *loads: dict[str, Any], quiet: tuple[str, ...] = ()) -> list[str]:
    """The keys of the lines that loads draw."""
    tables = [{"kind": "record", "path": str(folder / load.pop("file"))} | load if "file" in load else load for load in loads]
    made = mc.scene(two_blocks(), loads=tables, run={"dt": 2e-3, "duration": 5.0}, quiet_checks=[*quiet])
    lines = [line for line in prepare(made.checked).warnings if line.startswith("loads[")]
    return [line.partition(":")[0].partition(" = ")[0] for line in lines]


def one(file: str, direction: Any, column: str | None = None, **keys: Any) -> dict[str, Any]:
    of_text = {"units": "m/s2"} if file.endswith(".txt") else {}
    return {"file": file, "direction": direction, "correction": "none", **({"column": column} if column else {}), **of_text, **keys}


@pytest.mark.parametrize(
    ("loads", "keys"),
    [
        ([one("three.csv", "x", "UD")], ["loads[0].direction"]),
        ([one("three.csv", "z", "NS")], ["loads[0].direction"]),
        ([one("three.csv", [0.2, 0.1, 1.0], "EW")], ["loads[0].direction"]),
        ([one("lettered.csv", "y", "az")], ["loads[0].direction"]),
        ([one("lettered.csv", "-z", "ax")], ["loads[0].direction"]),
        ([one("quake_UD.txt", "x")], ["loads[0].direction"]),
        ([one("peerUP.at2", "x")], ["loads[0].direction"]),
        ([one("peer090.at2", "z")], ["loads[0].direction"]),
        ([one("three.csv", "x", "NS"), one("three.csv", "x", "EW")], ["loads[1].direction"]),
        ([one("three.csv", "x", "NS"), one("three.csv", "-x", "EW")], ["loads[1].direction"]),
        ([one("three.csv", "x", "NS"), one("three.csv", "y", "EW", rotate=-90.0)], ["loads[1].direction"]),
        ([one("bearings.csv", "x", "N08W"), one("bearings.csv", "x", "S82W")], ["loads[1].direction"]),
        ([one("plain.csv", "x", "first"), one("plain.csv", "x", "second")], ["loads[1].direction"]),
        ([one("quake_NS.txt", "y"), one("quake_EW.txt", "y")], ["loads[1].direction"]),
        ([one("three.csv", "x", "NS"), one("three.csv", "x", "NS")], ["loads[1].direction"]),
        ([one("three.csv", "x", "NS"), one("three.csv", "x", "NS", scale=0.5, start=1.0)], ["loads[1].direction"]),
        ([one("quake_NS.txt", "x"), one("copy.txt", "x", scale=0.7)], ["loads[1].direction"]),
        ([one("three.csv", "x", "NS"), one("three.csv", "y", "EW"), one("three.csv", "z", "UD")], []),
        ([one("three.csv", "x", "NS"), one("three.csv", "x", "EW", start=4.5)], []),  # after the other
        ([one("three.csv", "x", "NS", rotate=30.0), one("three.csv", "y", "EW", rotate=30.0)], []),
        ([one("quake_NS.txt", "x"), one("plain.csv", "x", "second")], []),  # which may be of another kind of motion
        ([one("plain.csv", "z", "first")], []),
        ([one("bearings.csv", "z", "ch3")], []),
    ],
)  # fmt: skip
def test_channels_along_another_axis_are_doubted(folder: Path, loads: list[dict[str, Any]], keys: list[str]) -> None:
    assert doubted(folder, *[{**load} for load in loads]) == keys
    assert doubted(folder, *[{**load} for load in loads], quiet=tuple(keys)) == []


def test_the_components_of_a_shock_are_judged_alike(folder: Path) -> None:
    def component(direction: str, column: str) -> dict[str, Any]:
        return {"path": str(folder / "three.csv"), "direction": direction, "column": column, "correction": "none"}

    shocks = [{"components": [component("x", "NS"), component("x", "EW")]}, {"components": [component("x", "UD"), component("y", "EW")]}]
    found = doubted(folder, {"kind": "sequence", "rest": 0.1, "shocks": shocks})
    assert found == ["loads[0].shocks[1].components[0].direction", "loads[0].shocks[0].components[1].direction"]


def test_channels_of_traces_are_known_by_their_names() -> None:
    motion = {"kind": "record", "time": TIME, "acceleration": np.column_stack([UD, NS]), "channels": ["HNZ", "HNN"], "correction": "none"}
    made = mc.scene(two_blocks(), loads=[motion])
    assert [line[:18] for line in prepare(made.checked).warnings if "vertical by its name" in line] == ["loads[0].direction"]


@pytest.mark.parametrize("scale", [9.81, 9.80665, 9.8, -9.81, 0.00981, 980.665, 0.01, 100.0, 0.102, 0.001])
def test_a_scale_that_converts_units_once_more_is_doubted(folder: Path, scale: float) -> None:
    assert doubted(folder, one("three.csv", "x", "NS", scale=scale)) == ["loads[0].scale"]
    text = one("quake_NS.txt", "x", scale=scale)
    implausible = not 0.05 <= 1.4 * abs(scale) <= 19.6
    assert doubted(folder, {**text}) == ["loads[0].scale"] * implausible  # the file names no unit: the scale may be what makes it m/s2
    assert doubted(folder, {**text, "units": "gal", "scale": 100.0 * scale}) == ["loads[0].scale"] * (
        implausible or any(abs(100.0 * abs(scale) / size - 1.0) < 2e-3 for size in (1.0e-3 * 9.80665, 980.665, 100.0, 1000.0))
    )


@pytest.mark.parametrize("scale", [0.5, 2.0, 10.0, 0.1, 9.0])
def test_other_scales_are_let_pass(folder: Path, scale: float) -> None:
    assert doubted(folder, one("three.csv", "x", "NS", scale=scale)) == []


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
