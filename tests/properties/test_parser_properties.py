# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes, block files and records changed at random: they are read, or refused by one line, and nothing else happens."""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import record_files
import records
from hostile import SCENE, TETRA, refusal
from hypothesis import given
from hypothesis import strategies as st
from places import EXAMPLES

import loads
from loads.readers import READERS, Request, Source, read
from masonry_cd.app.case import make_structures
from masonry_cd.app.scene import read_scene

LONGEST = 500  # characters of a message, its folder apart
SCENES = sorted(path.read_text(encoding="utf-8") for path in EXAMPLES.glob("*.toml"))
HOSTILE = [
    "", "0", "-1", "1e308", "-1e400", "nan", "inf", "true", '"x"', '"\\u0000"', "[]", "[[]]", "{}", "{a = {b = 1}}", "1979-05-27", "9" * 30,
    "1" * 5000, "[" * 3000, "[" * 300 + "]" * 300, '"' + "y" * 6000 + '"', '"\\u001b[31m"', "\0", "'", '"""', "=", "]",
]  # fmt: skip
WORDS = [
    "nan", "inf", "-1e999", "1e308", "1_000", "0x10", "٣", "", "\0", "9" * 400, "y" * 6000, ",", ";", "\t", "=", "#", "=1+1", "1,5",
    "\x1b[31m",
]  # fmt: skip
VALUES: list[Any] = [None, True, 0, -1, 10**30, 1e308, -0.0, "", "x", "a\0b", "\ud800", "y" * 6000, [], {}, [[]], [[[[1]]]], {"a": 1}]


@st.composite
def changed_lines(draw: st.DrawFn, texts: list[str], words: list[str]) -> str:
    """A text with one to three changes: lines left out, written twice, swapped; a value or a place in a line replaced; the end cut off."""
    lines = draw(st.sampled_from(texts)).splitlines()
    for _ in range(draw(st.integers(1, 3))):
        at, other = draw(st.integers(0, len(lines) - 1)), draw(st.integers(0, len(lines) - 1))
        kind = draw(st.sampled_from(["leave out", "repeat", "swap", "value", "value", "value", "insert", "cut"]))
        word, line = draw(st.sampled_from(words)), lines[at]
        if kind == "leave out" and len(lines) > 1:
            del lines[at]
        elif kind == "repeat":
            lines.insert(other, line)
        elif kind == "swap":
            lines[at], lines[other] = lines[other], line
        elif kind == "value":
            lines[at] = f"{line.partition('=')[0]}= {word}" if "=" in line else word
        elif kind == "insert":
            place = draw(st.integers(0, len(line)))
            lines[at] = line[:place] + word + line[place:]
        elif kind == "cut" and line:
            lines = [*lines[:at], line[: draw(st.integers(0, len(line)))]]
    return "\n".join(lines) + "\n"


@given(text=changed_lines(SCENES, HOSTILE))
def test_scenes(text: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    """The tables of the scene itself and those of its loads."""
    folder = tmp_path_factory.mktemp("scene")
    (folder / "scene.toml").write_text(text, encoding="utf-8")

    def prepared() -> None:
        scene = read_scene(folder / "scene.toml")
        loads.build(scene.loads, scene.run.dt, min(scene.run.steps, 200), scene.run.gravity, scene.folder)

    refusal(folder, prepared, LONGEST)


@given(data=st.binary(max_size=200))
def test_scenes_of_any_bytes(data: bytes, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("scene")
    (folder / "scene.toml").write_bytes(data)
    refusal(folder, lambda: read_scene(folder / "scene.toml"), LONGEST)


@given(key=st.sampled_from(["run.dt", "run", "loads[0].amplitude", "loads", "structure.kind", "a.b.c", "loads[7].x", "", "=", "[0]"]),
       value=st.sampled_from(HOSTILE))  # fmt: skip
def test_changes_by_the_command_line(key: str, value: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("scene")
    (folder / "scene.toml").write_text(SCENES[0], encoding="utf-8")
    refusal(folder, lambda: read_scene(folder / "scene.toml", [f"{key}={value}"]), LONGEST)


FILE: dict[str, Any] = {
    "units": "m",
    "blocks": [
        {**TETRA, "name": "a", "group": "base", "fixed": True, "density": 2000.0},
        {"name": "b", "vertices": [[x + 3.0, y, z] for x, y, z in TETRA["vertices"]], "faces": TETRA["faces"], "parts": []},
    ],
}


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The paths to all values inside a JSON value."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [(*path, key) for key, _ in inner] + [found for key, item in inner for found in places(item, (*path, key))]


@st.composite
def changed_files(draw: st.DrawFn) -> str:
    """A block file with one to three of its values replaced, left out or written twice."""
    content = deepcopy(FILE)
    for _ in range(draw(st.integers(1, 3))):
        path = draw(st.sampled_from(places(content) or [("blocks",)]))
        inner: Any = content
        for key in path[:-1]:
            inner = inner[key]
        kind = draw(st.sampled_from(["replace", "replace", "leave out", "repeat"]))
        if kind == "replace" or path[-1:] == ("blocks",):
            inner[path[-1]] = deepcopy(draw(st.sampled_from(VALUES)))
        elif kind == "leave out":
            del inner[path[-1]]
        elif isinstance(inner, list):
            inner.append(deepcopy(inner[path[-1]]))
        else:
            inner[f"{path[-1]}_"] = inner[path[-1]]
    return json.dumps(content)


@given(text=st.one_of(changed_files(), changed_lines([json.dumps(FILE, indent=1)], WORDS)))
def test_block_files(text: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("blocks")
    (folder / "scene.toml").write_text(SCENE)
    (folder / "b.json").write_text(text)
    refusal(folder, lambda: make_structures(read_scene(folder / "scene.toml")), LONGEST)


def knet(values: np.ndarray = records.WAVE) -> str:
    """A K-NET file of counts at 100 Hz."""
    keys = {"Origin Time": "2011/03/11", "Station Code": "X", "Sampling Freq(Hz)": "100Hz", "Duration Time(s)": f"{len(values) / 100:g}",
            "Dir.": "N-S", "Scale Factor": "2000(gal)/8388608", "Memo.": ""}  # fmt: skip
    counts = np.round(1000 * values).astype(int).astype(str)
    rows = [" ".join(counts[i : i + 8]) for i in range(0, len(counts), 8)]
    return "\n".join([*(f"{key:<18}{value}" for key, value in keys.items()), *rows]) + "\n"


RECORDS = {
    "at2": [records.at2()],
    "esm": [records.esm()],
    "knet": [knet()],
    "csv": [records.table(), records.table('"Time (s)";"NS [gal]";"UP [gal]"', ";").replace(".", ",")],
    "columns": [records.columns(), records.columns("# time [s]  acc [g]\n")],
}
REQUESTS = st.builds(
    Request,
    column=st.sampled_from([None, 0, 1, -1, 10**20, "ns", "", "y" * 6000]),
    time_step=st.sampled_from([None, None, 0.01]),
)


def test_the_records_are_sound_before_they_are_changed(tmp_path: Path) -> None:
    for format_, texts in RECORDS.items():
        for text in texts:
            (tmp_path / "quake.dat").write_text(text)
            found, record = read(Source.open(tmp_path / "quake.dat", "p"), "auto", Request(column=1 if format_ == "csv" else None))
            assert (found, len(record.values)) == (format_, len(records.WAVE))


@pytest.mark.parametrize("format_", RECORDS)
@given(data=st.data(), request_=REQUESTS)
def test_records(format_: str, data: st.DataObject, request_: Request, tmp_path_factory: pytest.TempPathFactory) -> None:
    """Read by their own name, by every other, and by what they hold; what is read is finite, and its step above zero."""
    folder = tmp_path_factory.mktemp("record")
    (folder / "quake.dat").write_text(data.draw(changed_lines(RECORDS[format_], WORDS)), encoding="utf-8")
    for name in ("auto", *READERS):
        refusal(folder, lambda name=name: sound(folder / "quake.dat", name, request_), LONGEST)


NETWORKS = {
    "cosmos": [record_files.cosmos()],
    "csmip": [record_files.csmip2(), record_files.csmip1()],
    "volumes": [record_files.volume("RENADIC", "COMP NS"), record_files.volume("* VOL1DS FILE:  5528/01", "COMP L1", pairs=False)],
    "geonet": [record_files.geonet()],
    "smc": [record_files.smc()],
    "networks": [record_files.afad(), record_files.unam(), record_files.cwb()],
    "counted": [record_files.counted()],
}


@pytest.mark.parametrize("format_", NETWORKS)
@given(data=st.data(), request_=REQUESTS)
def test_records_of_networks(format_: str, data: st.DataObject, request_: Request, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("record")
    (folder / "quake.dat").write_text(data.draw(changed_lines(NETWORKS[format_], WORDS)), encoding="utf-8")
    refusal(folder, lambda: sound(folder / "quake.dat", "auto", request_), LONGEST)


@given(content=st.binary(max_size=300))
def test_records_of_any_bytes(content: bytes, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("record")
    (folder / "quake.dat").write_bytes(content)
    for name in ("auto", *(name for name in READERS if name != "mseed")):
        refusal(folder, lambda name=name: sound(folder / "quake.dat", name, Request(time_step=0.01)), LONGEST)


def sound(path: Path, name: str, request: Request) -> None:
    """Read a record, which has to be one."""
    _, record = read(Source.open(path, "loads[0].path: quake.dat"), name, request)
    assert np.isfinite(record.values).all()
    assert record.values.ndim == 1
    assert 0.0 < record.step < np.inf
