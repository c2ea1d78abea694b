# SPDX-License-Identifier: GPL-3.0-or-later
"""The pages of the documentation: their blocks of code, and a reader who types what a page says, in a folder of his own."""

from __future__ import annotations

import re
import shlex
import shutil
import signal
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import numpy as np
import records
from command_line import masonry_cd
from places import EXAMPLES, ROOT

from masonry_cd.app.case import prepare
from masonry_cd.app.progress import Interrupt
from masonry_cd.app.scene import read_scene
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from structures.files.blockfile import read

DOCS = ROOT / "docs"
PAGES = sorted([*DOCS.rglob("*.md"), *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "benchmarks/README.md"))])
NOT_TYPED = ("make ", ". .venv/bin/activate", "sudo apt-get ", "pip ", "docker ")  # set-up: tests of the Makefile have their own place
STEPS = 12  # of a run that is only begun
RECORDS = ("elcentro.AT2", "motion.AT2")  # that a reader brings


class Fence(NamedTuple):
    """A block of code: its language, the title that names its file, and its text."""

    language: str
    title: str
    text: str


def page_name(page: Path) -> str:
    """A page by its place in the repository."""
    return page.relative_to(ROOT).as_posix()


def fences(page: Path) -> list[Fence]:
    """Blocks of code between fences, in their order."""
    found = re.findall(r'^```(\w+)(?: title="([^"]*)")?\n(.*?)^```$', page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    return [Fence(*each) for each in found]


def command_lines(page: Path) -> list[str]:
    """Every line of shell on a page, from fences and from indented blocks, loops undone."""
    text = page.read_text(encoding="utf-8")
    outside = re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)
    indented = "\n".join(re.findall(r"^    ((?:masonry-cd|make|python|\.venv/bin/python) .*)$", outside, re.MULTILINE))
    return [line for part in [*(fence.text for fence in fences(page) if fence.language == "sh"), indented] for line in typed(part)]


def typed(text: str) -> Iterator[str]:
    """Lines of a block of shell as a shell runs them: joined at a backslash, without comments, loops over words undone."""
    text = text.replace("\\\n", " ")
    loop = re.compile(r"^for (\w+) in (.*?); do\n(.*?)^done$", re.DOTALL | re.MULTILINE)

    def undone(found: re.Match[str]) -> str:
        name, words, body = found.groups()
        return "\n".join(body.replace(f"${name}", word) for word in words.split())

    for line in loop.sub(undone, text).splitlines():
        if words := shlex.split(line, comments=True):
            yield shlex.join(words)


@dataclass
class Reader:
    """Types a page's commands and saves its files, in a folder with the examples, two records and a suite of them. Runs are only begun."""

    folder: Path

    def __post_init__(self) -> None:
        shutil.copytree(EXAMPLES, self.folder / "examples")
        time = np.arange(400) * records.STEP
        shaking = np.round(0.2 * np.sin(2 * np.pi * 2.0 * time) * np.sin(np.pi * time / 4.0), 6)
        for name in RECORDS:
            (self.folder / name).write_text(records.at2(shaking, count="400"))
        records.write_suite(self.folder / "suite")

    def follow(self, page: Path) -> list[str]:
        """Do all that a page says; return the commands of the program that were typed."""
        done = []
        for fence in fences(page):
            if fence.language == "toml":
                self.save(fence)
            elif fence.language == "csv":
                (self.folder / fence.title).write_text(fence.text)
            elif fence.language == "json":
                (self.folder / "block_file.json").write_text(fence.text)
                assert read(self.folder / "block_file.json", 2000.0)
            elif fence.language == "sh":
                done += [line for line in typed(fence.text) if self.type(line)]
        return done

    def save(self, fence: Fence) -> None:
        """Save a scene under its title, and prepare it as a run does, unless it is for limit analysis alone."""
        tables = tomllib.loads(fence.text)
        if fence.title:
            path = self.folder / fence.title
            path.write_text(fence.text)
            if {"records", "design"} & tables.keys():  # a selection or a study, which its command reads
                return
            scene = read_scene(path, begun(path))
            if not any(load["kind"] == "vehicle" and not {"position", "speed"} & {*load} for load in scene.loads):  # which limit places
                prepare(scene)

    def type(self, line: str) -> bool:
        """Run a line; whether it was a command of the program."""
        words = shlex.split(line)
        if words[0] == "cp":
            shutil.copy(self.folder / words[1], self.folder / words[2])
        elif words[0] == "masonry-cd":
            if "COMMAND" in words:
                return False
            if "--resume" in words:
                self.stop(words[1:])
            result = masonry_cd(*self.shortened(words[1:]))
            assert result.exit_code == 0, f"{line}\n{result.output}\n{result.exception!r}"
            return True
        else:
            assert line.startswith(NOT_TYPED), f"what is {line!r}?"
        return False

    def stop(self, words: list[str]) -> None:
        """Begin a run that is to be resumed, with Ctrl-C at its tenth step."""
        original, calls = Stepper.step, 0

        def step(*arguments: Any) -> Any:
            nonlocal calls
            done = original(*arguments)
            calls += isinstance(getattr(signal.getsignal(signal.SIGINT), "__self__", None), Interrupt)  # not those that compile the kernels
            if calls == 10:
                signal.raise_signal(signal.SIGINT)
            return done

        begin = self.shortened([word for word in words if word != "--resume"])
        with mock.patch.object(Stepper, "step", step), mock.patch.object(sys, "argv", ["masonry-cd", *begin]):
            result = masonry_cd(*begin, "--force")
        assert result.exit_code == 130, result.output
        assert f"continue with: masonry-cd {shlex.join(words[:4])}" in result.output

    def shortened(self, words: list[str]) -> list[str]:
        """A command that takes no longer than it must."""
        if words[0] in ("run", "strengthen"):
            return [*words, *(word for change in begun(self.folder / words[1]) for word in ("--set", change))]
        if words[0] == "assess":
            few = ["assess.members=3", 'assess.leave_out=["block size", "bond", "damping", "joint stiffness"]']
            return [*words, *(word for change in [*begun(self.folder / words[1]), *few] for word in ("--set", change))]
        if words[0] == "calibrate":
            return [*words, *(["--plan"] if "--plan" not in words else [])]
        if words[0] == "modal":
            return [*words, "--modes", "1", "--pictures", "0"]
        return words


def begun(scene: Path) -> list[str]:
    """Changes by which a scene is only begun. An arch is cheap: its whole motion is run in coarse steps."""
    asked: dict[str, Any] = tomllib.loads(scene.read_text(encoding="utf-8"))
    still = ["run.until_still=false"]
    if asked["structure"]["kind"] == "arch":
        return [*still, "run.dt=5e-3", "run.tolerance=1e-4", "run.frames_per_second=10"]
    return [*still, f"run.duration={STEPS * asked['run']['dt']}"]
