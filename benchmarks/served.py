# SPDX-License-Identifier: GPL-3.0-or-later
"""Process that ``turns.py`` runs: steps of scenes in a tree of the program, by the benchmarks of that tree, which may be older.

So nothing of the program is imported here but in functions, and of the benchmarks only what older trees have too.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from masonry_cd.mechanics.dynamics.moreau_jean import Stepper

HEAP = ["--heap", "--dt", "4e-3", "--still", "1e-9", "--longest", "2", "--friction", "0.6"]
PACKING = ["--dt", "4e-3", "--still", "1e-9", "--longest", "2"]


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
