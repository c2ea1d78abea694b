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
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

import numpy as np

from benchmarks.fuzz import inputs, mutators, promises, together


@dataclass
class Tally:
    """Outcomes of the cases of a kind."""

    done: int = 0
    refused: int = 0
    broke: int = 0
    seconds: float = 0.0  # the longest
    memory: float = 0.0  # the most [B]

    def add(self, outcome: promises.Outcome) -> str:
        """Count a case: the promise that it broke."""
        wrong = promises.broken(outcome)
        self.done += 1
        self.refused += outcome.code == 2
        self.broke += bool(wrong)
        self.seconds, self.memory = max(self.seconds, outcome.seconds), max(self.memory, outcome.memory)
        return wrong


def main() -> int:
    """Run cases until time or number is reached; 1 where a promise was broken."""
    asked = _arguments()
    with tempfile.TemporaryDirectory(prefix="fuzz-") as place:
        folder = Path(place)
        (folder / "nursery").mkdir()
        every = inputs.subjects(folder / "nursery", asked.kind)
        found = [s for s in every if re.search(asked.kind, s.kind) and not (asked.quick and s.apart)]
        if not found:
            raise SystemExit(f"--kind: no kind of input has {asked.kind!r} in its name")
        _warm(found, folder, asked.together > 1)
        return _cases(asked, found, folder)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.fuzz", description=__doc__)
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--seed", type=int, default=0, help="case N of a seed is always the same")
    parser.add_argument("--cases", type=int, default=10**9, help="at most this number")
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--kind", default="", help="only kinds with this pattern in their name; numbers of cases then mean others")
    parser.add_argument("--quick", action="store_true", help="without the formats that are read in a process of their own; likewise")
    parser.add_argument("--even", action="store_true", help="one kind after the other, as many cases of each; likewise")
    parser.add_argument("--together", type=int, default=1, help="this number of cases in a process, where a command allows it")
    parser.add_argument("-o", "--output", type=Path, default=Path("out/fuzz"), help="folder for what broke a promise")
    return parser.parse_args()


def _warm(found: list[inputs.Subject], folder: Path, libraries: bool) -> None:
    """See that every input is good; and call the command line in this process, so that the forks find all imported and compiled."""
    if libraries:
        together.keep_commands()
    seen = set()
    for subject in found:
        if libraries or (not subject.apart and (subject.command[0] != "build" or "build" not in seen)):
            seen.add(subject.command[0])
            _call_here(subject, folder)
        outcome = together.alone(_case(subject, subject.files, _command(subject.command)), folder)
        wrong = promises.broken(outcome) or ("it is refused" if outcome.code == 2 and not subject.refused else "")
        if wrong:
            raise SystemExit(f"{subject.kind}: not a good input: {wrong}: {outcome.stderr[-500:]}")


def _call_here(subject: inputs.Subject, folder: Path) -> None:
    """Call the command line in this process, without a word."""
    from masonry_cd.cli import main as command_line

    home, words = Path.cwd(), sys.argv
    os.chdir(together.laid_out(subject.files, folder / "good"))
    sys.argv = ["masonry-cd", *_command(subject.command)]
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()), together.readers_here(), suppress(SystemExit):
        command_line()
    os.chdir(home)
    sys.argv = words
    shutil.rmtree(folder / "good")


def _cases(asked: argparse.Namespace, found: list[inputs.Subject], folder: Path) -> int:
    """Batch after batch; the table at the end."""
    end, number = time.monotonic() + 60.0 * asked.minutes, asked.first
    tallies: dict[str, Tally] = {}
    while time.monotonic() < end and number < asked.first + asked.cases:
        count = min(asked.together, asked.first + asked.cases - number)
        drawn = [_drawn(asked, found, number + k) for k in range(count)]
        for k, (subject, case, outcome) in enumerate(_outcomes(drawn, folder)):
            if wrong := tallies.setdefault(subject.kind, Tally()).add(outcome):
                name = f"{asked.seed}-{number + k}-{re.sub(r'[^a-zA-Z]+', '-', subject.kind)}"
                print(f"{_keep(asked.output / name, case, wrong, outcome)}: {wrong}", flush=True)
        number += count
    _tell(tallies)
    changed, bad = sum(t.done for t in tallies.values()), sum(t.broke for t in tallies.values())
    print(f"seed {asked.seed}, cases {asked.first} to {number - 1}: {changed} changed inputs, {bad} broke a promise")
    return 1 if bad else 0


Drawn = tuple[inputs.Subject, together.Case]


def _drawn(asked: argparse.Namespace, found: list[inputs.Subject], number: int) -> Drawn:
    """The case of a number."""
    random = np.random.default_rng([asked.seed, number])
    weights = np.array([subject.weight for subject in found])
    drawn = int(random.choice(len(found), p=weights / weights.sum()))
    subject = found[number % len(found) if asked.even else drawn]
    return subject, _case(subject, *_changed(subject, random))


def _outcomes(drawn: list[Drawn], folder: Path) -> Iterator[tuple[inputs.Subject, together.Case, promises.Outcome]]:
    """How cases end, in their order: those that may in one process, the others each in its own."""
    shared = [case for _, case in drawn if len(drawn) > 1 and case.command[0] in together.COMMANDS]
    outcomes = together.run_cases(shared, folder)
    for subject, case in drawn:
        one = next(outcomes) if any(case is other for other in shared) else together.alone(case, folder)
        yield subject, case, one


def _case(subject: inputs.Subject, files: dict[str, bytes], command: list[str]) -> together.Case:
    return together.Case(files, command, _output(subject.command))


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
    """Return the paths that a command may write."""
    if words[0] in ("compare", "report"):
        return words[1]
    return "written.png" if "OUT.png" in words else "written"


def _keep(folder: Path, case: together.Case, wrong: str, outcome: promises.Outcome) -> Path:
    """Write a case that broke a promise, with the command that repeats it."""
    shutil.rmtree(folder, ignore_errors=True)
    together.laid_out(case.files, folder)
    words = f"cd {shlex.quote(str(folder))} && {shlex.join(['masonry-cd', *case.command])}\n"
    (folder / "COMMAND").write_text(words, errors="backslashreplace")
    said = "\n".join(
        [wrong, f"exit code {outcome.code}", f"{outcome.seconds:.1f} s, {outcome.memory / 1e6:.0f} MB", outcome.stderr[-5000:]]
    )
    (folder / "WRONG").write_text(said, errors="backslashreplace")
    return folder


def _tell(tallies: dict[str, Tally]) -> None:
    """A table by kind."""
    print("| kind | changed | refused | broke a promise | longest [s] | most memory [MB] |\n|---|---|---|---|---|---|")
    for kind, tally in sorted(tallies.items()):
        print(f"| {kind} | {tally.done} | {tally.refused} | {tally.broke} | {tally.seconds:.1f} | {tally.memory / 1e6:.0f} |")


if __name__ == "__main__":
    sys.exit(main())
