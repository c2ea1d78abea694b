"""What the pages tell a reader to type: every command parses, and README, tutorials and how-to pages are followed from top to bottom."""

from __future__ import annotations

import importlib.util
import re
import shlex
from pathlib import Path

import pytest
import typer
from doc_pages import DOCS, PAGES, Reader, command_lines, fences, page_name, typed
from places import ROOT

from masonry_cd.cli.app import app

COMMANDS = typer.main.get_command(app).commands
FOLLOWED = [ROOT / "README.md", DOCS / "index.md", *sorted(DOCS.glob("tutorials/*.md")), *sorted(DOCS.glob("howto/*.md"))]


def lines_of(first: str) -> list[tuple[str, str]]:
    """All lines on all pages that begin with a word, each with its page."""
    return [(page_name(page), line) for page in PAGES for line in command_lines(page) if shlex.split(line)[0] == first]


def test_lines_are_found_and_loops_undone():
    assert list(typed("a \\\n  1  # why\n\nfor x in 2 3; do\n  b --set k=$x\ndone\n")) == ["a 1", "b --set k=2", "b --set k=3"]
    assert len(lines_of("masonry-cd")) >= 100
    assert {name for name, _ in lines_of("masonry-cd")} >= {"README.md", "docs/command_reference.md", "docs/tutorials/sweep.md"}


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_every_command_parses(page: Path):
    for line in command_lines(page):
        words = shlex.split(line)
        if words[0] == "masonry-cd" and words[1] != "COMMAND":
            COMMANDS[words[1]].make_context(words[1], words[2:])
        elif words[0].endswith("python") and words[1] == "-m":
            assert importlib.util.find_spec(words[2]), line
        elif words[0].endswith("python"):
            assert (ROOT / words[1]).is_file(), line
        elif words[0] == "make":
            (target,) = [word for word in words[1:] if "=" not in word]
            assert re.search(rf"^{target}:", (ROOT / "Makefile").read_text(), re.MULTILINE), line


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_commands_in_a_sentence_have_the_options_that_it_gives_them(page: Path):
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    for name, rest in re.findall(r"`masonry-cd ([a-z]+)((?: [^`]*)?)`", text):
        known = {option for parameter in COMMANDS[name].params for option in (*parameter.opts, *parameter.secondary_opts)}
        given = set(re.findall(r"(?<=\s)(--?[a-z][\w-]*)", rest))
        assert given - known - {"--help"} == set(), (name, rest)


@pytest.mark.parametrize("page", FOLLOWED, ids=page_name)
def test_a_reader_can_follow_the_page(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    done = Reader(tmp_path).follow(page)
    expected = [line for fence in fences(page) if fence.language == "sh" for line in typed(fence.text)]
    assert done == [line for line in expected if line.startswith("masonry-cd ") and "COMMAND" not in line]
    assert done, "a page that tells nobody to do anything"
