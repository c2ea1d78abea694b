# SPDX-License-Identifier: GPL-3.0-or-later
"""Only files that the program wrote itself are overwritten or removed."""

from __future__ import annotations

from pathlib import Path

import pytest

from masonry_cd.foundation import own_files
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError

NAMES = ("joints.csv", "page.html", "map_*.png")


def write(path: Path, text: str = "ours") -> None:
    with replacing(path) as part:
        part.write_text(text, encoding="utf-8")


def test_files_of_others_are_refused_and_all_named(tmp_path: Path) -> None:
    for name in ("joints.csv", "map_1.png", "notes.txt"):
        (tmp_path / name).write_text("theirs", encoding="utf-8")
    with pytest.raises(InputError) as refused:
        own_files.begin(tmp_path, NAMES)
    assert "joints.csv" in str(refused.value) and "map_1.png" in str(refused.value) and "notes.txt" not in str(refused.value)
    assert not (tmp_path / own_files.LIST).exists()


def test_own_files_are_written_again_and_removed(tmp_path: Path) -> None:
    own_files.begin(tmp_path / "out", NAMES)
    for text in ("first", "second"):
        write(tmp_path / "out" / "joints.csv", text)
    own_files.check(tmp_path / "out", NAMES)
    own_files.remove(tmp_path / "out", NAMES)
    assert not (tmp_path / "out" / "joints.csv").exists()


def test_a_file_edited_since_belongs_to_who_edited_it(tmp_path: Path) -> None:
    own_files.begin(tmp_path, NAMES)
    write(tmp_path / "joints.csv")
    (tmp_path / "joints.csv").write_text("ours, and theirs", encoding="utf-8")
    own_files.remove(tmp_path, NAMES)
    with pytest.raises(InputError, match=r"joints\.csv"):
        own_files.check(tmp_path, NAMES)
    with pytest.raises(InputError, match=r"joints\.csv"):
        write(tmp_path / "joints.csv")
    assert (tmp_path / "joints.csv").read_text(encoding="utf-8") == "ours, and theirs"


def test_a_kill_before_the_list_or_before_the_file_leaves_it_ours(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own_files.begin(tmp_path, NAMES)
    write(tmp_path / "joints.csv")
    with monkeypatch.context() as killed, pytest.raises(KeyboardInterrupt):
        killed.setattr(Path, "replace", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        write(tmp_path / "joints.csv", "never in place")
    own_files.check(tmp_path, NAMES)


def test_what_a_kill_leaves_half_written_is_nobodys(tmp_path: Path) -> None:
    own_files.begin(tmp_path, ("*",))
    (tmp_path / "map_1.part.png").write_text("half", encoding="utf-8")
    own_files.begin(tmp_path, ("*",))


def test_a_folder_without_a_list_is_adopted_where_something_proves_it(tmp_path: Path) -> None:
    (tmp_path / "joints.csv").write_text("of an earlier version", encoding="utf-8")
    own_files.begin(tmp_path, NAMES, lambda folder: folder == tmp_path)
    own_files.check(tmp_path, NAMES)
    (tmp_path / "page.html").write_text("theirs", encoding="utf-8")
    with pytest.raises(InputError, match=r"page\.html"):
        own_files.begin(tmp_path, NAMES, lambda _: True)


def test_a_file_that_grows_is_known_by_its_name(tmp_path: Path) -> None:
    own_files.begin(tmp_path, NAMES)
    own_files.note(tmp_path / "page.html", growing=True)
    (tmp_path / "page.html").write_text("half", encoding="utf-8")
    own_files.check(tmp_path, NAMES)
