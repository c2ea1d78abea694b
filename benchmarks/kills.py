# SPDX-License-Identifier: GPL-3.0-or-later
"""Kills and interrupts runs at random moments and at chosen points, resumes them until their end, and compares all that they wrote.

    python -m benchmarks.kills --times 500 --seed 1

Half of the times are SIGKILL, half are one to three of Ctrl-C and its like. A run is struck up to three times: while it runs, while it is
resumed, while it writes its last files. Half of the strikes come after a random time, half before or after a random call of what writes
files. After each, what is there of result.h5 must read, without a word on damage, and be what the undisturbed run wrote up to there. At
the end result.h5 (but for what depends on the clock), joints.csv, summary.json (but for seconds) and all other files must be the same byte
by byte. Each run is a process forked from one that has the kernels in memory; it goes through the command line like any other.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.bits.cases import HERE
from benchmarks.bits.runs import read_folder
from masonry_cd.cli import main
from masonry_cd.cli.app import app
from masonry_cd.foundation.system import STOPPING
from masonry_cd.io import checkpoint, segments
from masonry_cd.io.result_writer import ResultWriter
from masonry_cd.io.results import Results

SCENES = {  # by kind: the scene, and changes that make it short
    "planar": ("aqueduct", "run.duration=0.08", "run.frames_per_second=250"),
    "spatial": ("tower", "run.duration=0.3"),
    "elastic": ("elastic", "run.duration=0.08"),
    "mortar": ("mortar", "run.duration=0.04"),
    "debris": ("debris", "run.duration=0.2", "report.damage=true"),
    "islands": ("islands", "run.duration=0.2"),
    "sequence": ("shocks", "run.dt=8e-3"),
    "air": ("falling",),
    "alone": ("alone",),
    "unshaken": ("tower", "loads=[]", "run.duration=0.1"),
    "parting": ("tower", "run.gravity=[0,0,9.81]", "run.duration=0.1"),  # blocks fall off their support: all joints vanish
    "threads": ("church", "run.duration=0.02", "run.solver=admm", "run.threads=2"),  # of 300 blocks
}
EVERY = ("0", "0.03", "10")  # seconds between two checkpoints
PATIENCE = 300.0  # seconds after which a run counts as hanging
SECONDS = re.compile(r'"(wall_seconds|stepping_seconds)": [0-9.e+-]+')
POINTS: tuple[tuple[Any, str], ...] = (
    (os, "replace"), (os, "fsync"), (os, "unlink"), (ResultWriter, "flush"), (ResultWriter, "_write"), (ResultWriter, "_publish"),
    (ResultWriter, "write_peaks"), (ResultWriter, "write_closing"), (segments, "append"), (segments.Sealer, "seal"),
    (segments.Sealer, "carry_over"), (checkpoint, "save"), (checkpoint, "remove"), (json, "dumps"),
)  # fmt: skip


@dataclass
class Reference:
    """An undisturbed run."""

    words: list[str]
    folder: Path
    seconds: float


class Wrong(Exception):
    """A run that did not end as it should."""


def forked(words: Sequence[str], said: Path, before: Callable[[], None] = lambda: None) -> int:
    """Start a run of the command line in a process of its own; return its number. Strikes are held back until the program begins."""
    held = signal.pthread_sigmask(signal.SIG_BLOCK, STOPPING)
    if pid := os.fork():
        signal.pthread_sigmask(signal.SIG_SETMASK, held)
        return pid
    code = 70
    try:
        with said.open("w", encoding="utf-8") as stream:
            os.dup2(stream.fileno(), 1)
            os.dup2(stream.fileno(), 2)
        for number in STOPPING:
            signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)
        sys.argv = ["masonry-cd", *words]
        before()
        code = _command(held)
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def _command(held: set[int | signal.Signals]) -> int:
    """Run the command line, with the signals held back that were so before; its exit code."""
    try:
        signal.pthread_sigmask(signal.SIG_SETMASK, held)
        main()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0 if end.code is None else 1
    except KeyboardInterrupt:  # a moment before or after the command, which lets none through
        return 128 + signal.SIGINT
    finally:
        signal.pthread_sigmask(signal.SIG_BLOCK, STOPPING)
    return 0


def ended(pid: int) -> int:
    """Wait for a process; its exit code, or less the number of the signal that ended it."""
    limit = time.monotonic() + PATIENCE
    while time.monotonic() < limit:
        done, status = os.waitpid(pid, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.002)
    os.kill(pid, signal.SIGKILL)
    os.waitpid(pid, 0)
    raise Wrong(f"hung for {PATIENCE:g} s")


def strike_at(rng: random.Random, send: Callable[[], None]) -> Callable[[], None]:
    """Return the first action of a process, by which it is struck before or after a random call of something that writes."""
    (owner, name), call, after = rng.choice(POINTS), rng.choice((1, 1, 2, 3, 5, 8, 20)), rng.random() < 0.5

    def install() -> None:
        original, calls = getattr(owner, name), 0

        def called(*args: Any, **options: Any) -> Any:
            nonlocal calls
            calls += 1
            if calls == call and not after:
                send()
            out = original(*args, **options)
            if calls == call and after:
                send()
            return out

        setattr(owner, name, called)

    return install


def struck(reference: Reference, words: list[str], said: Path, rng: random.Random, kill: bool) -> int:
    """Run until a strike ends it, or it ends; its exit code."""
    numbers = [signal.SIGKILL] if kill else [rng.choice(STOPPING) for _ in range(rng.randint(1, 3))]

    def send() -> None:
        for number in numbers:
            os.kill(os.getpid(), number)

    if rng.random() < 0.5:
        return ended(forked(words, said, strike_at(rng, send)))
    pid = forked(words, said)
    time.sleep(rng.random() * 1.1 * reference.seconds)
    for number in numbers:
        with suppress(ProcessLookupError):
            os.kill(pid, number)
        time.sleep(rng.random() * 0.02)
    return ended(pid)


def check_between(out: Path, reference: Reference) -> None:
    """Check that what a strike has left reads, and is what the undisturbed run wrote up to there."""
    if not (out / "result.h5").exists():
        return
    with Results.open(out / "result.h5") as found, Results.open(reference.folder / "result.h5") as whole:
        if found.words:
            raise Wrong(found.words[0])
        frames = found.frames
        same = np.array_equal(found.time, whole.time[:frames]) and np.array_equal(found.position[:frames], whole.position[:frames])
        steps = len(found.per_step("step_time"))
        same &= np.array_equal(found.per_step("penetration"), whole.per_step("penetration")[:steps])
        if not same:
            raise Wrong("rows of result.h5 differ after a strike")
    if (out / "summary.json").exists():
        json.loads((out / "summary.json").read_text())


def check_end(out: Path, reference: Reference) -> None:
    """All files must be those of the undisturbed run."""
    names = [sorted(str(path.relative_to(folder)) for path in folder.rglob("*")) for folder in (out, reference.folder)]
    if names[0] != names[1]:
        raise Wrong(f"files {names[0]}, not {names[1]}")
    found, whole = (without_scene(read_folder(folder)) for folder in (out, reference.folder))
    differing = [name for name in whole if name not in found or bits_of(found[name]) != bits_of(whole[name])]
    if found.keys() != whole.keys() or differing:
        raise Wrong(f"differs: {', '.join(differing[:5])}")
    for name in names[0]:
        one, other = out / name, reference.folder / name
        if one.suffix in (".csv", ".json") and SECONDS.sub("", one.read_text()) != SECONDS.sub("", other.read_text()):
            raise Wrong(f"{name} differs")


def bits_of(array: np.ndarray) -> tuple[tuple[int, ...], bytes]:
    """Return the shape and bytes that must be alike: rows without columns, as of no joints, have a number but no bytes."""
    return array.shape, array.tobytes()


def without_scene(found: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Results without the text of the scene, in which the time between two checkpoints is another."""
    return {name: array for name, array in found.items() if name != "result.h5/attributes/scene"}


def trial(reference: Reference, out: Path, rng: random.Random, kill: bool, most: int) -> int:
    """Strike a run up to some times and bring it to its end; how often it was struck."""
    shutil.rmtree(out, ignore_errors=True)
    said, strikes, begun = out.with_suffix(".said"), 0, False
    wanted = min(most, rng.randint(1, 3))
    for _ in range(40):
        go_on = (
            ["--resume"] if begun and any((out / name).exists() for name in ("checkpoint.npz", "checkpoint_before.npz")) else ["--force"]
        )
        words = [*reference.words, "-o", str(out), *go_on, "--set", f"run.checkpoint_every={reference_every(out, rng, begun)}"]
        code = struck(reference, words, said, rng, kill) if strikes < wanted else ended(forked(words, said))
        begun, text = True, said.read_text()
        expected = (0, -signal.SIGKILL) if kill else (0, *(128 + n for n in STOPPING), *(-n for n in STOPPING))
        if code not in expected or "Traceback" in text:
            raise Wrong(f"exit code {code}: {text[-300:]}")
        strikes += code != 0
        check_between(out, reference)
        if code == 0:
            check_end(out, reference)
            return strikes
    raise Wrong("never came to its end")


def reference_every(out: Path, rng: random.Random, begun: bool) -> str:
    """How often a run takes checkpoints: it is part of its scene, so it stays."""
    note = out.with_suffix(".every")
    if not begun:
        note.write_text(rng.choice(EVERY))
    return note.read_text()


def undisturbed(folder: Path, kinds: Iterable[str]) -> dict[str, Reference]:
    """The runs to compare with, by kind; the first of each brings the kernels into memory."""
    found = {}
    for kind in kinds:
        scene, *changes = SCENES[kind]
        words = ["run", str(HERE / f"{scene}.toml"), "-q", *(word for change in changes for word in ("--set", change))]
        out, said = folder / kind, folder / f"{kind}.said"
        with suppress(SystemExit):
            app([*words, "-o", str(folder / "first"), "--force", "--set", "run.threads=1"])
        begin = time.monotonic()
        if code := ended(forked([*words, "-o", str(out), "--set", "run.checkpoint_every=10"], said)):
            raise Wrong(f"{kind}: exit code {code}: {said.read_text()}")
        found[kind] = Reference(words, out, time.monotonic() - begin)
        print(f"{kind}: {found[kind].seconds:.2f} s undisturbed", flush=True)
    return found


def strike(words: Sequence[str] | None = None) -> int:
    """Strike until there were as many strikes as requested; the number of runs that did not end as they should."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--times", type=int, default=20, help="kills and interrupts together")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kind", action="append", choices=SCENES, help="of scene; all when not given")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="end after these, whatever was reached")
    parser.add_argument("--keep", type=Path, help="folder for what a run left that did not end as it should")
    asked = parser.parse_args(words)
    wrong, done, number, begin = 0, Counter[str](), 0, time.monotonic()
    with tempfile.TemporaryDirectory(prefix="kills") as name:
        kinds = asked.kind or list(SCENES)
        references = undisturbed(Path(name), kinds)
        while sum(done.values()) < asked.times and time.monotonic() - begin < 60.0 * asked.minutes:
            kill, rng = number % 2 == 0, random.Random(f"{asked.seed} {number}")
            kind = kinds[number // 2 % len(kinds)]
            what = "kills" if kill else "interrupts"
            left = (asked.times + 1) // 2 - sum(count for key, count in done.items() if key.endswith(what))
            out = Path(name) / "trial"
            try:
                if left > 0:
                    done[f"{kind} {what}"] += trial(references[kind], out, rng, kill, left)
            except Exception as failure:
                wrong, done[f"{kind} {what}"] = wrong + 1, done[f"{kind} {what}"] + 1
                print(f"{kind}, {what}, number {number}: {failure}", flush=True)
                if asked.keep and out.exists():
                    shutil.copytree(out, asked.keep / f"{kind}-{number}", dirs_exist_ok=True)
            number += 1
    for what in ("kills", "interrupts"):
        by_kind = {key.split()[0]: count for key, count in sorted(done.items()) if key.endswith(what)}
        print(f"{what}: {sum(by_kind.values())} ({', '.join(f'{kind} {count}' for kind, count in by_kind.items())})")
    print(f"{number} runs in {time.monotonic() - begin:.0f} s; {wrong} did not end as they should")
    return wrong


if __name__ == "__main__":
    sys.exit(min(strike(), 1))
