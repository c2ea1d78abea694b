# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps scenes in two trees of the program by turns, for ``benchmarks.profile --beside``: what the machine does meanwhile meets both alike.

Each tree has a process of its own, in which the packages of the program are those of the tree, and the scenes those of this one.
A process steps a share of a scene, then waits while the other one does.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from benchmarks.sitting import HERE, environment, head
from masonry_cd.foundation.errors import InputError

if TYPE_CHECKING:
    from masonry_cd.mechanics.dynamics.moreau_jean import Stepper

HEAD = head("scene", "contacts", "steps", "ms per step: beside", "here", "ratio", "missed: beside", "here", "largest error: beside", "here")
BEGIN = (  # packages are found in a tree, but for the benchmarks, which are these
    "import sys, types; sys.path.insert(0, {tree!r}); sys.modules['benchmarks'] = types.ModuleType('benchmarks')\n"
    "sys.modules['benchmarks'].__path__ = [{here!r}]; from benchmarks import turns; turns.serve()"
)
SHARES = 10  # of a scene, by turns
HEAP = ["--heap", "--dt", "4e-3", "--still", "1e-9", "--longest", "2", "--friction", "0.6"]
PACKING = ["--dt", "4e-3", "--still", "1e-9", "--longest", "2"]
SCENES = ("arch27", "tower50", "arcade50", "wall40x25", "packing1000", "heap1000", *(f"strong{k}" for k in range(1, 11)))


def machine_of(name: str, changes: Sequence[str]) -> tuple[Stepper, int]:
    """A stepper and its steps: of a scene file with changes of its keys, or by name.

    ``strongN`` is the N-th of ``strong_shaking``, ``packingN`` and ``heapN`` have N spheres, others are those of ``benchmarks.scenes``.

    Raises:
        ValueError: no such scene.
    """
    from benchmarks import ours, packing
    from benchmarks.scenes import scene
    from benchmarks.strong_shaking import strong_cases

    if name.endswith(".toml"):
        machine = ours.stepper_of_file(Path(name), ["run.threads=1", *changes])
        return machine, machine.settings.steps
    word, number = name.rstrip("0123456789"), name.lstrip("abcdefghijklmnopqrstuvwxyz")
    if word in ("packing", "heap") and number:
        asked = packing.arguments().parse_args([number, *(HEAP if word == "heap" else PACKING)])
        machine, _ = packing.stepper(asked, asked.friction[0])
        return machine, machine.settings.steps
    cases = list(strong_cases()) if word == "strong" else []
    if number.isdigit() and 0 < int(number) <= len(cases):
        _, made, steps = cases[int(number) - 1]
        return ours.stepper(made, steps, tolerance=1e-6), steps
    made = scene(name)
    return ours.stepper(made, made.steps), made.steps


def serve() -> None:
    """Make what standard input asks for, a line of JSON each: the name of a scene to begin, or a number of steps to take."""
    from benchmarks import ours

    for planar in (True, False):
        ours.warm_up("auto", 1e-8, {"planar": planar})
    machine, steps = None, 0
    for line in sys.stdin:
        asked = json.loads(line)
        if isinstance(asked, int):
            assert machine is not None
            begin = time.process_time()
            reports = [machine.step() for _ in range(asked)]
            spent, errors = time.process_time() - begin, [float(report.error) for report in reports]
            answer: dict[str, Any] = {"seconds": spent, "errors": errors, "contacts": [report.contacts for report in reports]}
        else:
            try:
                machine, steps = machine_of(*asked)
                answer = {"steps": steps, "tolerance": machine.settings.tolerance}
            except ValueError as wrong:
                answer = {"wrong": str(wrong)}
        print(json.dumps(answer), flush=True)


class Tree:
    """The process of a tree."""

    def __init__(self, folder: Path, asked: IO[str], answers: IO[str]) -> None:
        self._folder, self._asked, self._answers = folder, asked, answers

    def ask(self, what: int | list[Any]) -> dict[str, Any]:
        """What the process answers.

        Raises:
            InputError: no such scene, or the process has ended.
        """
        with suppress(BrokenPipeError):
            print(json.dumps(what), file=self._asked, flush=True)
        line = next((line for line in self._answers if line.startswith("{")), "")
        if not line:
            raise InputError(f"the process of {self._folder} has ended")
        answer = dict(json.loads(line))
        if "wrong" in answer:
            raise InputError(answer["wrong"])
        return answer


@contextmanager
def process_of(tree: Path) -> Iterator[Tree]:
    """The process of a tree, on one thread."""
    code = BEGIN.format(tree=str(tree.resolve()), here=str(HERE))
    with subprocess.Popen(
        [sys.executable, "-P", "-c", code], env=environment(1), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=HERE.parent
    ) as running:
        assert running.stdin is not None and running.stdout is not None
        yield Tree(tree, running.stdin, running.stdout)
        running.stdin.close()


def row(trees: tuple[Tree, Tree], name: str, changes: Sequence[str], repeats: int) -> str:
    """A line of the table: a scene in both trees, whose times are the least of so many runs."""
    best, out = np.full(2, np.inf), [dict[str, Any](), dict[str, Any]()]
    for _ in range(repeats):
        begun = [tree.ask([name, list(changes)]) for tree in trees]
        steps, seconds = int(begun[0]["steps"]), np.zeros(2)
        out = [{"errors": [], "contacts": []} for _ in trees]
        for share in np.diff(np.linspace(0, steps, SHARES + 1).astype(int)).tolist():
            for k, tree in enumerate(trees):
                answer = tree.ask(share)
                seconds[k] += answer["seconds"]
                for key, values in out[k].items():
                    values += answer[key]
        best = np.minimum(best, seconds)
    errors = np.array([each["errors"] for each in out])
    missed, largest = (errors > begun[1]["tolerance"]).sum(axis=1), errors.max(axis=1)
    cells = [Path(name).name, f"{np.mean(out[1]['contacts']):.0f}", str(steps), *(f"{1e3 * spent / steps:.4g}" for spent in best)]
    cells += [f"{best[1] / best[0]:.2f}", *map(str, missed), *(f"{x:.1e}" for x in largest)]
    return f"| {' | '.join(cells)} |"
