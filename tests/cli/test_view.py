# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd view``, and the completion of commands in a shell."""

from __future__ import annotations

import os
import subprocess
import sys
import webbrowser

import pytest
from command_line import masonry_cd

from reports.study.outputs import PAGE

DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")


def view(folder):
    return masonry_cd("view", folder)


@pytest.fixture
def opened(monkeypatch) -> list[str]:
    """The pages that would have been opened; there is no display yet."""
    pages: list[str] = []
    monkeypatch.setattr(webbrowser, "open", lambda page: pages.append(page) or True)
    monkeypatch.setattr(sys, "platform", "linux")
    for name in DISPLAYS:
        monkeypatch.delenv(name, raising=False)
    return pages


@pytest.fixture
def run(tmp_path):
    (tmp_path / "report.html").write_text("<html></html>")
    return tmp_path


@pytest.mark.parametrize("display", DISPLAYS)
def test_the_page_opens_in_the_browser(run, opened, monkeypatch, display):
    monkeypatch.setenv(display, ":0")
    result = view(run)
    assert (result.exit_code, opened) == (0, [(run / "report.html").as_uri()])
    assert result.stdout == f"opened: {opened[0]}\n"


def test_without_a_display_or_a_browser_it_is_said_where_the_page_lies(run, opened, monkeypatch):
    place = (run / "report.html").as_uri()
    assert (view(run).stdout, opened) == (f"no display here; the page is {place}\n", [])
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(webbrowser, "open", lambda page: False)
    assert place in view(run).stdout


@pytest.mark.parametrize(
    ("there", "folder", "remedy"),
    [
        ("result.h5", "", "masonry-cd report {} --html makes it"),
        ("study.json", "", "masonry-cd study STUDY -o {} --report makes it"),
        ("other", "", "nor a result.h5"),
        ("other", "none", "no such folder"),
        ("other", "other", "is a file"),
    ],
)
def test_a_folder_without_a_page_is_refused_with_the_command_that_makes_it(tmp_path, opened, there, folder, remedy):
    (tmp_path / there).write_bytes(b"")
    result = view(tmp_path / folder)
    assert (result.exit_code, opened) == (2, [])
    assert result.stderr.startswith(f"masonry-cd: error: {tmp_path / folder}: ") and remedy.format(tmp_path) in result.stderr


def test_the_page_of_a_study_opens(tmp_path, opened, monkeypatch):
    monkeypatch.setenv("DISPLAY", ":0")
    for name in ("study.json", PAGE):
        (tmp_path / name).write_text("{}")
    assert (view(tmp_path).exit_code, opened) == (0, [(tmp_path / PAGE).as_uri()])


def completed(line: str) -> set[str]:
    """What bash is offered after a line."""
    code = "import sys; sys.argv = ['masonry-cd']; from masonry_cd.cli import main; main()"
    asked = {"_MASONRY_CD_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(len(line.split(" ")) - 1)}
    out = subprocess.run([sys.executable, "-c", code], env=os.environ | asked, capture_output=True, text=True, check=False)
    return set(out.stdout.split())


def test_a_shell_completes_commands_and_options():
    assert {"run", "record", "report"} <= completed("masonry-cd r")
    assert "build" not in completed("masonry-cd r")
    assert completed("masonry-cd run --res") == {"--resume"}
    assert completed("masonry-cd init a") == {"aqueduct", "arch"}
