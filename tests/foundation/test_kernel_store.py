# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of compiled kernels: whole or absent, shared by processes, and dropped when others have taken their place."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from masonry_cd.foundation import kernel_store as store


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder that is written to."""
    monkeypatch.setenv(store.FOLDER, str(tmp_path / "kernels"))
    monkeypatch.setattr(store, "SHIPPED", str(tmp_path / "brought"))
    return tmp_path / "kernels"


def test_what_is_written_is_read(place: Path) -> None:
    name = store.name_of("package.kernel", "a" * 64, "float64")
    assert store.read(name) is None and not store.is_there(name)
    store.write(name, b"code")
    assert store.read(name) == b"code" and store.is_there(name)
    assert [file.name for file in place.iterdir()] == [name]


def test_another_source_kind_or_processor_has_another_file() -> None:
    names = {store.name_of("package.kernel", sources, kind) for sources in ("a" * 64, "b" * 64) for kind in ("float64", "int64")}
    assert len(names) == 4


@pytest.mark.parametrize("cut", [0, 3, 20, 35])
def test_a_file_that_is_cut_off_counts_as_absent(place: Path, cut: int) -> None:
    name = store.name_of("package.kernel", "a" * 64, "float64")
    store.write(name, b"code")
    (place / name).write_bytes((place / name).read_bytes()[:cut])
    assert store.read(name) is None


def test_a_damaged_file_counts_as_absent(place: Path) -> None:
    name = store.name_of("package.kernel", "a" * 64, "float64")
    store.write(name, b"code")
    (place / name).write_bytes(b"x" + (place / name).read_bytes()[1:])
    assert store.read(name) is None


def test_files_of_other_sources_go_when_they_are_old(place: Path) -> None:
    """Young ones may be of another checkout that shares the folder."""
    old, young, new = (store.name_of("kernel", sources, "float64") for sources in "abc")
    other = store.name_of("kernels", "a", "float64")
    for name in (old, young, other):
        store.write(name, b"code")
    for name in (old, other):
        os.utime(place / name, (0, 0))
    store.write(new, b"code")
    assert sorted(file.name for file in place.iterdir()) == sorted([young, other, new])


def test_what_a_wheel_brings_is_read_and_never_written(place: Path, tmp_path: Path) -> None:
    name = store.name_of("package.kernel", "a" * 64, "float64")
    store.write(name, b"code")
    place.rename(tmp_path / "brought")
    assert store.read(name) == b"code"
    store.write(name, b"other")
    assert store.read(name) == b"code"
