# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that a user names are refused where they are pipes or devices; only files that the program wrote itself are overwritten."""

from __future__ import annotations

import io
import os
import socket
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hostile import refused_at

from loads.readers import Source
from masonry_cd.analysis.fragility import folder as study_folder
from masonry_cd.analysis.modal.measured_modes import read_measured
from masonry_cd.app.inputs import file_digests
from masonry_cd.app.scene import read_scene
from masonry_cd.foundation import files, own_files
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from masonry_cd.io import checkpoint
from masonry_cd.io.problem_files import read_problem
from masonry_cd.io.results import Results
from masonry_cd.io.summary import read_summary
from masonry_cd.studies.accuracy.command import AccuracyRequest, accuracy
from masonry_cd.studies.study.study_file import read_study
from structures.kinds import file as block_file
from structures.kinds import solid


def made_of(name: str) -> Callable[[Path], object]:
    return lambda path: block_file.build(
        {"path": path.name, **({} if name.endswith("json") else {"units": "m", "up": "z"})}, 1.0, path.parent
    )


READ: dict[str, Callable[[Path], object]] = {
    "quake.txt": lambda path: Source.open(path, "loads[0].path: quake.txt"),
    "scene.toml": read_scene,
    "study.toml": read_study,
    "problem.npz": read_problem,
    "problem.hdf5": read_problem,
    "result.h5": Results.open,
    "checkpoint.npz": checkpoint.load,
    "accuracy.toml": lambda path: accuracy(path, path.parent, AccuracyRequest(), print),
    "study.json": lambda path: study_folder.read_study(path.parent),
    "summary.json": lambda path: read_summary(path.parent),
    "modes.csv": read_measured,
    "blocks.json": made_of("json"),
    "blocks.obj": made_of("obj"),
    "blocks.stl": made_of("stl"),
    "scan.step": lambda path: solid.build({"path": path.name, "course_height": 0.3}, 1.0, path.parent),
    "listed.vtu": lambda path: file_digests([{"path": path.name}], path.parent),
}


@pytest.mark.parametrize("name", READ)
def test_a_pipe_is_refused_and_not_waited_for(tmp_path: Path, name: str) -> None:
    os.mkfifo(tmp_path / name)
    with pytest.raises(InputError, match=r"is a pipe; a file is needed|not a summary") as failure:
        READ[name](tmp_path / name)
    assert name in str(failure.value)


def test_devices_and_sockets_are_named_as_what_they_are(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="/dev/zero: is a device"):
        files.read_bytes(Path("/dev/zero"))
    with socket.socket(socket.AF_UNIX) as open_socket:
        open_socket.bind(str(tmp_path / "s"))
        with refused_at("s"):
            files.is_file(tmp_path / "s")


def test_what_says_that_it_is_empty_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As files of the kernel do, which may wait for ever."""
    (tmp_path / "log").write_bytes(b"")
    monkeypatch.setattr(Path, "open", lambda *_: pytest.fail("the file is opened"))
    assert files.read_bytes(tmp_path / "log") == b""


def test_a_regular_file_is_read_as_before(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_bytes(b"\xef\xbb\xbfone\r\ntwo\rthree\n")
    assert files.read_text(tmp_path / "a.txt", encoding="utf-8-sig") == "one\ntwo\nthree\n"
    (tmp_path / "link").symlink_to(tmp_path / "a.txt")
    assert files.is_file(tmp_path / "link")
    assert not files.is_file(tmp_path)
    assert not files.is_file(tmp_path / "none")
    assert not files.is_file(tmp_path / "a\0b")


def test_a_file_beyond_all_memory_is_refused_before_it_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "large.txt").write_bytes(b"0123456789")
    monkeypatch.setattr(files, "MOST", 9)
    with refused_at("large.txt"):
        files.read_bytes(tmp_path / "large.txt")


@pytest.mark.parametrize("header", ["{'descr': '<f8', 'shape': (3,), ((", "{'descr': '<f8'", "[[[", "'''"])
def test_a_member_of_an_npz_whose_header_is_broken_is_named(tmp_path: Path, header: str) -> None:
    """numpy reads the header of a version 1 array as Python source."""
    text = f"{header:<117}\n".encode()
    member = b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text
    with zipfile.ZipFile(tmp_path / "problem.npz", "w") as archive:
        archive.writestr("mu.npy", member)
        sound = io.BytesIO()
        np.save(sound, np.zeros(3))
        archive.writestr("q.npy", sound.getvalue())
    with refused_at("problem.npz"):
        read_problem(tmp_path / "problem.npz")


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
