# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps scenes in two trees of the program by turns, for ``benchmarks.profile --against``: other load of the machine affects both.

Each tree has a process of its own (``served.py``), whose program and named scenes are those of the tree; files of
scenes are those given. A process steps a share of a scene, then waits while the other one does.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

import numpy as np

from benchmarks.sitting import HERE, environment, head
from masonry_cd.foundation.errors import InputError

HEAD = head("scene", "contacts", "steps", "ms per step: other", "here", "ratio", "missed: other", "here", "largest error: other", "here")
BEGIN = "import sys, runpy; sys.path.insert(0, {tree!r}); runpy.run_path({served!r})['serve']()"
SHARES = 10  # of a scene, by turns
SCENES = ("arch27", "tower50", "arcade50", "wall40x25", "packing1000", "heap1000", *(f"strong{k}" for k in range(1, 11)))


class Tree:
    """The process of a tree."""

    def __init__(self, folder: Path, asked: IO[str], answers: IO[str]) -> None:
        self._folder, self._asked, self._answers = folder, asked, answers

    def ask(self, what: int | list[Any]) -> dict[str, Any]:
        """Return the answer of the process.

        Raises:
            InputError: no such scene, or the process has ended.
        """
        with suppress(BrokenPipeError):
            print(json.dumps(what), file=self._asked, flush=True)
        line = next((line for line in self._answers if line.startswith("{")), "")
        if not line:
            raise InputError("", f"the process of {self._folder} has ended")
        answer = dict(json.loads(line))
        if "wrong" in answer:
            raise InputError("", answer["wrong"])
        return answer


@contextmanager
def process_of(tree: Path) -> Iterator[Tree]:
    """The process of a tree, on one thread."""
    code = BEGIN.format(tree=str(tree.resolve()), served=str(HERE / "served.py"))
    with subprocess.Popen(
        [sys.executable, "-P", "-c", code], env=environment(1), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=HERE.parent
    ) as running:
        assert running.stdin is not None and running.stdout is not None
        yield Tree(tree, running.stdin, running.stdout)
        running.stdin.close()


def row(trees: tuple[Tree, Tree], name: str, changes: tuple[Sequence[str], Sequence[str]], repeats: int) -> str:
    """A line of the table: a scene in both trees, with changes of its keys for each, whose times are the least of some runs."""
    best, out = np.full(2, np.inf), [dict[str, Any](), dict[str, Any]()]
    for _ in range(repeats):
        begun = [tree.ask([name, list(own)]) for tree, own in zip(trees, changes, strict=True)]
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
