# SPDX-License-Identifier: GPL-3.0-or-later
"""The command ``python -m benchmarks.fuzz``: changes inputs for some minutes, or some cases, and tells what broke a promise."""

from __future__ import annotations

import argparse
import os
import re
import shlex
import shutil
import sys
import tempfile
import time
from collections import Counter
from contextlib import redirect_stderr, redirect_stdout, suppress
from io import StringIO
from pathlib import Path

import numpy as np

from benchmarks.fuzz import inputs, mutators, promises, worker


def main() -> int:
    """Run cases until time or number is reached; 1 where a promise was broken."""
    asked = _arguments()
    with tempfile.TemporaryDirectory(prefix="fuzz-") as place:
        folder = Path(place)
        (folder / "nursery").mkdir()
        found = [s for s in inputs.subjects(folder / "nursery") if asked.kind in s.kind and not (asked.quick and s.apart)]
        if not found:
            raise SystemExit(f"--kind: no kind of input has {asked.kind!r} in its name")
        _warm(found, folder)
        return _cases(asked, found, folder)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.fuzz", description=__doc__)
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--seed", type=int, default=0, help="case N of a seed is always the same")
    parser.add_argument("--cases", type=int, default=10**9, help="at most so many")
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--kind", default="", help="only kinds with this in their name; numbers of cases then mean others")
    parser.add_argument("--quick", action="store_true", help="without the formats that are read in a process of their own; likewise")
    parser.add_argument("-o", "--output", type=Path, default=Path("out/fuzz"), help="folder for what broke a promise")
    return parser.parse_args()


def _warm(found: list[inputs.Subject], folder: Path) -> None:
    """See that every input is good; and call the command line in this process, so that the forks find all imported and compiled."""
    from masonry_cd.cli import main as command_line

    home, words = Path.cwd(), sys.argv
    seen = set()
    for subject in found:
        if not subject.apart and (subject.command[0] != "build" or "build" not in seen):
            seen.add(subject.command[0])
            os.chdir(_laid_out(subject.files, folder / "good"))
            sys.argv = ["masonry-cd", *_command(subject.command)]
            with redirect_stdout(StringIO()), redirect_stderr(StringIO()), suppress(SystemExit):
                command_line()
            os.chdir(home)
            shutil.rmtree(folder / "good")
        place = _laid_out(subject.files, folder / "good")
        outcome = worker.run_case(place, _command(subject.command), _output(subject.command))
        wrong = promises.broken(outcome) or ("it is refused" if outcome.code == 2 and not subject.refused else "")
        if wrong:
            raise SystemExit(f"{subject.kind}: not a good input: {wrong}: {outcome.stderr[-500:]}")
        shutil.rmtree(place)
    sys.argv = words


def _cases(asked: argparse.Namespace, found: list[inputs.Subject], folder: Path) -> int:
    """Case after case; the table at the end."""
    weights = np.array([subject.weight for subject in found])
    end, number = time.monotonic() + 60.0 * asked.minutes, asked.first
    done: Counter[str] = Counter()
    refused: Counter[str] = Counter()
    broke: Counter[str] = Counter()
    while time.monotonic() < end and number < asked.first + asked.cases:
        random = np.random.default_rng([asked.seed, number])
        subject = found[int(random.choice(len(found), p=weights / weights.sum()))]
        files, command = _changed(subject, random)
        place = _laid_out(files, folder / "case")
        outcome = worker.run_case(place, command, _output(subject.command))
        shutil.rmtree(place)
        done[subject.kind] += 1
        refused[subject.kind] += outcome.code == 2
        wrong = promises.broken(outcome)
        if wrong:
            broke[subject.kind] += 1
            kept = _keep(asked.output / f"{asked.seed}-{number}-{re.sub(r'[^a-zA-Z]+', '-', subject.kind)}", files, command, wrong, outcome)
            print(f"{kept}: {wrong}", flush=True)
        number += 1
    _tell(done, refused, broke)
    changed, bad = sum(done.values()), sum(broke.values())
    print(f"seed {asked.seed}, cases {asked.first} to {number - 1}: {changed} changed inputs, {bad} broke a promise")
    return 1 if broke else 0


def _changed(subject: inputs.Subject, random: np.random.Generator) -> tuple[dict[str, bytes], list[str]]:
    """The files and the command of a case."""
    change = subject.changes[int(random.integers(len(subject.changes)))]
    command = _command(subject.command)
    if change == inputs.SET:
        return subject.files, [
            *command,
            *(word for _ in range(int(random.integers(1, 4))) for word in ("--set", mutators.set_text(random))),
        ]
    return subject.files | {subject.target: mutators.changed(subject.files[subject.target], change, random)}, command


def _command(words: tuple[str, ...]) -> list[str]:
    return [word.replace("OUT", "written") for word in words]


def _output(words: tuple[str, ...]) -> str:
    """What a command may write."""
    if words[0] in ("compare", "report"):
        return words[1]
    return "written.png" if "OUT.png" in words else "written"


def _laid_out(files: dict[str, bytes], folder: Path) -> Path:
    """A folder with files."""
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    return folder


def _keep(folder: Path, files: dict[str, bytes], command: list[str], wrong: str, outcome: promises.Outcome) -> Path:
    """Write a case that broke a promise, with the command that repeats it."""
    shutil.rmtree(folder, ignore_errors=True)
    _laid_out(files, folder)
    (folder / "COMMAND").write_text(f"cd {shlex.quote(str(folder))} && {shlex.join(['masonry-cd', *command])}\n", errors="backslashreplace")
    said = "\n".join(
        [wrong, f"exit code {outcome.code}", f"{outcome.seconds:.1f} s, {outcome.memory / 1e6:.0f} MB", outcome.stderr[-5000:]]
    )
    (folder / "WRONG").write_text(said, errors="backslashreplace")
    return folder


def _tell(done: Counter[str], refused: Counter[str], broke: Counter[str]) -> None:
    """A table by kind."""
    print("| kind | changed | refused | broke a promise |\n|---|---|---|---|")
    for kind in sorted(done):
        print(f"| {kind} | {done[kind]} | {refused[kind]} | {broke[kind]} |")


if __name__ == "__main__":
    sys.exit(main())
