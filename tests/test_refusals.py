# SPDX-License-Identifier: GPL-3.0-or-later
"""Each refusal of the tables of tests/refusals names the place that is wrong, ends with exit code 2, and leaves no file behind."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from doors import DOORS, repeated
from places import ROOT

from masonry_cd.foundation.errors import LINE, Fault, InputError

TABLES = sorted((ROOT / "tests" / "refusals").glob("*.toml"))


def rows() -> list[Any]:
    """Every row with its group: the places that must be named, and what is tried."""
    out = []
    for table in TABLES:
        for name, group in tomllib.loads(table.read_text(encoding="utf-8")).items():
            for k, (places, *what) in enumerate(group["refused"]):
                every = [places] if isinstance(places, str) else places
                out.append(pytest.param(group, every, what, id=f"{table.stem}-{name}-{k}-{ascii(every[0])[1:60]}"))
    return out


def named(fault: Fault, folder: Path) -> str:
    """The place of a fault as a user reads it: file and line, key or option, and the key of a table with which its text begins."""
    key = re.match(r"[\w.]+(?=: )", fault.text)
    parts = (fault.source, fault.place, key.group() if key else "")
    said = ": ".join(part for part in parts if part).replace(f"{folder}/", "").replace(f"{ROOT}/", "").replace(str(folder), ".")
    return said.encode("utf-8", "backslashreplace").decode()


def contents(folder: Path) -> dict[Path, bytes | None]:
    """All that is in a folder."""
    return {path: path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


@pytest.mark.parametrize(("group", "places", "what"), rows())
def test_it_names_the_place_and_leaves_nothing(group: dict[str, Any], places: list[str], what: list[Any], tmp_path: Path) -> None:
    try_it = DOORS[group["door"]](tmp_path, group, *what)
    before = contents(tmp_path)
    with pytest.raises(InputError) as refused:
        try_it()
    assert [named(fault, tmp_path) for fault in refused.value.faults] == [repeated(place) for place in places]
    assert all(line.isprintable() and len(line) <= LINE for line in refused.value.lines)
    assert contents(tmp_path) == before


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.stem)
def test_no_row_is_there_twice(table: Path) -> None:
    for name, group in tomllib.loads(table.read_text(encoding="utf-8")).items():
        tried = [str(what) for _, *what in group["refused"]]
        assert len(set(tried)) == len(tried), name
